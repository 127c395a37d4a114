"use strict";
// Draws a page's pictures in the light or the dark look, again where that changes, and in the light one on paper.

const DARK = {
  "#1f2933": "#e6eaef", "#e4e7eb": "#313a45", "white": "#161b22", "#52606d": "#a9b4c0", "#d64545": "#ff7b72",
  "#1c7ed6": "#74b3f0", "#2b8a3e": "#69db7c", "#9c36b5": "#da77f2", "#c2255c": "#f783ac", "#0b7285": "#66d9e8",
  "#846358": "#c8a99e", "#495057": "#adb5bd", "#5f9bd1": "#3d73a6",
};
const PAPER_WIDTH = 680;
const TITLE_CHARACTER = 8.1; // px, of a title at 15 px, where the font is a wide one
const TITLE_LINE = 20;
const BUTTONS = 56; // px, of those that save a picture, at its right edge
const LEGEND_CHARACTER = 6.8; // px, of an entry at 12 px
const LEGEND_SYMBOL = 50; // px, with the room about it
const LEGEND_LINE = 19;
const LEGEND_MARGIN = 40; // px, that a picture keeps beside its legend
const FADE = 48; // px, in which a picture that goes on beyond its right edge fades
const darkness = matchMedia("(prefers-color-scheme: dark)");
let onPaper = false;

function isDark() {
  return darkness.matches && !onPaper;
}

function inLook(specification) {
  let text = JSON.stringify(specification);
  if (isDark()) {
    for (const [light, dark] of Object.entries(DARK)) text = text.replaceAll(`"${light}"`, `"${dark}"`);
  }
  return JSON.parse(text);
}

function saveButton(format) {
  return {
    name: `Save as ${format.toUpperCase()}`,
    icon: Plotly.Icons.camera,
    click: (picture) => {
      const title = picture.layout.title?.text ?? "picture";
      const filename = title.replace(/<[^>]*>/g, " ").replace(/[^\p{L}\p{N}]+/gu, "_").slice(0, 60);
      Plotly.downloadImage(picture, { format, filename, width: picture.clientWidth, height: picture.clientHeight });
    },
  };
}

// A picture that has another layout for narrow windows is drawn by that where it would be cut.
function fitting(element, specification) {
  const width = onPaper ? PAPER_WIDTH : element.clientWidth;
  const { narrow, least_width: least } = specification;
  return { fitted: narrow && width && width < least ? { data: specification.data, ...narrow } : specification, width };
}

// Plotly cuts titles that are wider than the picture, and draws its buttons over them.
function withTitleWrapped(layout, width) {
  const text = layout.title?.text;
  if (!text || !width) return;
  const most = Math.max(Math.floor((width - 10) / TITLE_CHARACTER), 20);
  const lines = text.split("<br>").flatMap((line) => (line.includes("<") ? [line] : wrapped(line, most)));
  const further = lines.length - text.split("<br>").length;
  if (!further) return;
  layout.title = { ...layout.title, text: lines.join("<br>"), yref: "container", y: 1, yanchor: "top", pad: { t: 12 } };
  layout.margin = { ...layout.margin, t: (layout.margin?.t ?? 50) + TITLE_LINE * further };
  if (layout.height) layout.height += TITLE_LINE * further;
}

// In a picture that goes on beyond its right edge the legend's row would do so too: its entries stand below each other.
function withLegendSeen(layout, data, seen) {
  const names = data.filter((trace) => trace.name && trace.showlegend !== false).map((trace) => trace.name);
  const row = names.reduce((width, name) => width + LEGEND_SYMBOL + LEGEND_CHARACTER * name.length, 0);
  if (layout.showlegend === false || layout.legend?.orientation !== "h" || row < seen) return;
  const further = LEGEND_LINE * (names.length - 1);
  // a legend in one column would take its width from the picture
  layout.legend = { ...layout.legend, entrywidth: 1, entrywidthmode: "fraction", xref: "container", xanchor: "left" };
  layout.margin = { ...layout.margin, b: (layout.margin?.b ?? 50) + further };
  if (layout.height) layout.height += further;
}

// A legend cuts names that are wider than the picture.
function withNamesWrapped(layout, data, seen) {
  if (layout.showlegend === false || !seen) return;
  const most = Math.max(Math.floor((seen - LEGEND_SYMBOL - LEGEND_MARGIN) / LEGEND_CHARACTER), 12);
  let further = 0;
  for (const trace of data) {
    if (!trace.name || trace.name.includes("<")) continue;
    const lines = wrapped(trace.name, most);
    trace.name = lines.join("<br>");
    if (trace.showlegend !== false) further += lines.length - 1;
  }
  if (!further) return;
  layout.margin = { ...layout.margin, b: (layout.margin?.b ?? 50) + LEGEND_LINE * further };
  if (layout.height) layout.height += LEGEND_LINE * further;
}

// Words that are longer than a line, as names of files, break where they have a low line, a dot or a hyphen, else anywhere.
function broken(word, most) {
  const pieces = [];
  let rest = word;
  while (rest.length >= most) {
    const ends = [..."_.-"].map((mark) => rest.lastIndexOf(mark, most - 2) + 1);
    const end = Math.max(...ends) || most - 1;
    pieces.push(rest.slice(0, end));
    rest = rest.slice(end);
  }
  return [...pieces, rest];
}

function wrapped(line, most) {
  const lines = [""];
  for (const word of line.split(" ").flatMap((one) => broken(one, most))) {
    const last = lines[lines.length - 1];
    if (last && last.length + word.length >= most) lines.push(word);
    else lines[lines.length - 1] = last ? `${last} ${word}` : word;
  }
  return lines;
}

function drawIn(element, specification) {
  const { fitted, width } = fitting(element, specification);
  const { data, layout } = inLook({ data: fitted.data, layout: fitted.layout });
  const seen = onPaper ? width : element.closest("figure")?.clientWidth || width;
  const scrolls = width > seen + 4;
  const titled = onPaper ? seen : Math.min(seen, width - BUTTONS);
  withTitleWrapped(layout, scrolls ? Math.min(seen - FADE, titled) : titled);
  withNamesWrapped(layout, data, scrolls ? seen - FADE : seen);
  if (scrolls) withLegendSeen(layout, data, seen - FADE);
  // what was wrapped has made it higher
  if (specification.narrow) element.style.height = fitted === specification ? "" : `${layout.height}px`;
  if (onPaper) layout.width = PAPER_WIDTH;
  const config = {
    responsive: !onPaper, displaylogo: false, modeBarButtons: [[saveButton("svg"), saveButton("png")]],
  };
  return Plotly.react(element, data, layout, config).then(markMore);
}

// What goes on beyond its right edge fades there, and can be scrolled from the keyboard.
const SCROLLED = "figure, .table, .maps, .scroll";

function markMore() {
  for (const element of document.querySelectorAll(SCROLLED)) {
    element.classList.toggle("more", element.scrollWidth - element.clientWidth - element.scrollLeft > 4);
    if (element.scrollWidth > element.clientWidth + 4 && !element.hasAttribute("tabindex")) element.tabIndex = 0;
  }
}

document.addEventListener("scroll", (event) => { if (event.target.matches?.(SCROLLED)) markMore(); }, true);

const redrawn = [];

function onLookChanged(draw) {
  redrawn.push(draw);
  draw();
}

function lookChanged() {
  redrawn.forEach((draw) => draw());
}

darkness.addEventListener("change", lookChanged);
let lastWidth = innerWidth, resizing = 0;
addEventListener("resize", () => {
  clearTimeout(resizing);
  resizing = setTimeout(() => {
    if (innerWidth === lastWidth) return; // a bar of the browser that comes and goes
    lastWidth = innerWidth;
    lookChanged();
    markMore();
  }, 150);
});
for (const [event, paper] of [["beforeprint", true], ["afterprint", false]]) {
  addEventListener(event, () => { onPaper = paper; lookChanged(); });
}

for (const element of document.querySelectorAll(".picture")) {
  const script = element.querySelector("script");
  const specification = JSON.parse(script.textContent);
  script.remove();
  onLookChanged(() => drawIn(element, specification));
}

markMore();

// A command breaks between its words, not at an option's hyphens; a word that is longer than the line still does.
function setCommand(code, line) {
  code.replaceChildren(...line.split(/( +)/).map((part) => {
    if (!part.trim()) return part;
    const word = document.createElement("span");
    word.className = "word";
    word.textContent = part;
    return word;
  }));
}

for (const command of document.querySelectorAll(".command")) {
  setCommand(command.querySelector("code"), command.querySelector("code").textContent);
  const button = command.querySelector("button");
  button.addEventListener("click", async () => {
    const code = command.querySelector("code");
    try {
      await navigator.clipboard.writeText(code.textContent);
      button.textContent = "Copied";
    } catch {
      getSelection().selectAllChildren(code);
      button.textContent = "Selected";
    }
  });
}
