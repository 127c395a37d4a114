"use strict";
// Draws a page's pictures in the light or the dark look, again where that changes, and in the light one on paper.

const DARK = {
  "#1f2933": "#e6eaef", "#e4e7eb": "#313a45", "white": "#161b22", "#52606d": "#a9b4c0", "#d64545": "#ff7b72",
  "#1c7ed6": "#74b3f0", "#2b8a3e": "#69db7c", "#9c36b5": "#da77f2", "#c2255c": "#f783ac", "#0b7285": "#66d9e8",
  "#846358": "#c8a99e", "#495057": "#adb5bd",
};
const PAPER_WIDTH = 680;
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

function drawIn(element, specification) {
  const { data, layout } = inLook(specification);
  if (onPaper) layout.width = PAPER_WIDTH;
  const config = {
    responsive: !onPaper, displaylogo: false, modeBarButtons: [[saveButton("svg"), saveButton("png")]],
  };
  return Plotly.react(element, data, layout, config);
}

const redrawn = [];

function onLookChanged(draw) {
  redrawn.push(draw);
  draw();
}

function lookChanged() {
  redrawn.forEach((draw) => draw());
}

darkness.addEventListener("change", lookChanged);
for (const [event, paper] of [["beforeprint", true], ["afterprint", false]]) {
  addEventListener(event, () => { onPaper = paper; lookChanged(); });
}

for (const element of document.querySelectorAll(".picture")) {
  const script = element.querySelector("script");
  const specification = JSON.parse(script.textContent);
  script.remove();
  onLookChanged(() => drawIn(element, specification));
}

for (const command of document.querySelectorAll(".command")) {
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
