/* global drawIn, inLook, lawLine, onLookChanged, setCommand */
// A campaign's page: the map, the run that is looked at, candidates, sliders, jobs.
import { ask, complain, follow, start, tell, textOf } from "./ask.js";
import { drawRun } from "./draw.js";

const { key, law, worst } = document.body.dataset;
const beside = document.body.dataset.with;
const base = `/c/${encodeURIComponent(key)}`;
const percent = (share) => `${(100 * share).toPrecision(3)}%`;
const cells = [...document.querySelectorAll(".map .cell")];
const runs = [...new Set(cells.flatMap((cell) => cell.dataset.runs.split("|")))];
let shown = null; // the run that is drawn, with its laws
let moved = null; // what the law gives with parameters moved

const chosen = (name) => document.querySelector(`input[name="${name}"]:checked`)?.value || "";

// The run that was picked stays in the address, so that a reload and another law show the same one.
function remember(run) {
  const address = new URL(location.href);
  address.searchParams.delete("token");
  address.searchParams.set("run", run);
  history.replaceState(null, "", address);
  for (const link of document.querySelectorAll(".chip, .act a[href^='/c/']")) {
    const target = new URL(link.href);
    if (target.pathname.includes("/laws/")) { target.searchParams.set("run", run); link.href = target; }
  }
}

// Laws' files don't change: what was fetched of a run once stays right. A pointer on a cell fetches ahead of the click.
const fetched = new Map();
function fetchRun(run) {
  const candidate = chosen("candidate");
  const query = new URLSearchParams({ laws: [beside, law].filter(Boolean).join(","), ...(candidate ? { candidate } : {}) });
  const path = `${base}/runs/${encodeURIComponent(run)}?${query}`;
  if (!fetched.has(path)) {
    fetched.set(path, ask(path));
    fetched.get(path).catch(() => fetched.delete(path));
  }
  return fetched.get(path);
}

let asked = 0;
async function look(run, scroll = false, picked = true) {
  const number = ++asked;
  try {
    const found = await fetchRun(run);
    if (number !== asked) return; // a later click is under way
    shown = found;
    moved = null;
    for (const slider of sliders) toFit(slider);
    draw();
    mark(run);
    if (picked) remember(run);
    if (scroll && innerWidth <= 900) document.getElementById("run-title").scrollIntoView({ block: "start", behavior: "smooth" });
  } catch (error) {
    complain(error.message);
  }
}

// The run with what is drawn over it: the law with parameters moved among the others, the law itself last.
function drawnRun() {
  if (!moved) return shown;
  const last = shown.laws.length - 1;
  const among = (list, one) => [...list.slice(0, last), one, list[last]];
  return { ...shown, laws: among(shown.laws, moved.force), by_law: among(shown.by_law, moved.by_law) };
}

function draw() {
  const run = drawnRun();
  drawRun(run, chosen("against") || "y");
  document.getElementById("run-title").textContent = shown.run;
  const words = Object.entries(shown.conditions).map(([name, value]) => {
    const [symbol, unit] = name.split(" / ");
    return unit ? `${symbol} ${value} ${name.slice(symbol.length + 3)}` : `${symbol} ${value}`;
  });
  document.getElementById("conditions").textContent = [...words, `${shown.cycles} cycle${shown.cycles > 1 ? "s" : ""}`].join(", ");
  const errors = run.by_law.map((each, index) => {
    const { color, dash } = inLook(lawLine(index, run.by_law.length));
    const sample = textOf("i", "", "line");
    sample.style.borderTopColor = color;
    sample.style.borderTopStyle = { dot: "dotted" }[dash] || (dash ? "dashed" : "solid");
    const told = textOf("span", "");
    told.append(sample, `${each.name}: error `, textOf("b", percent(each.nrmse)));
    return told;
  });
  const noise = run.by_law[0]?.noise_nrmse;
  errors.reverse();
  if (noise) errors.push(textOf("span", `scatter ${percent(noise)}`));
  document.getElementById("errors").replaceChildren(...errors);
}

function mark(run) {
  for (const cell of cells) {
    const own = cell.dataset.runs.split("|");
    cell.setAttribute("aria-pressed", String(own.includes(run)));
    if (own.includes(run)) {
      const several = own.length > 1 ? own : [];
      document.getElementById("runs").replaceChildren(...several.map((name, index) => {
        const button = textOf("button", String(index + 1), "small");
        button.type = "button";
        button.title = name;
        button.setAttribute("aria-label", `Run ${name}`);
        button.setAttribute("aria-pressed", String(name === run));
        button.addEventListener("click", () => look(name));
        return button;
      }));
    }
  }
}

// One cell of each map takes part in the order of Tab; arrows go on from there.
function arrows() {
  for (const map of document.querySelectorAll(".map")) {
    const own = [...map.querySelectorAll(".cell")];
    own.forEach((cell, index) => { cell.tabIndex = index ? -1 : 0; });
    map.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] }[event.key];
      const cell = event.target.closest(".cell");
      if (!step || !cell) return;
      event.preventDefault();
      let [row, column] = [cell.closest("tr").sectionRowIndex, cell.parentElement.cellIndex];
      const rows = map.tBodies[0].rows;
      for (;;) {
        row += step[0]; column += step[1];
        const place = rows[row]?.cells[column];
        if (!place) return;
        const next = place.querySelector(".cell");
        if (!next) continue;
        own.forEach((each) => { each.tabIndex = -1; });
        next.tabIndex = 0;
        next.focus();
        look(next.dataset.runs.split("|")[0]);
        return;
      }
    });
  }
}

// Sliders: the law is asked for the run with other values, one question at a time, the latest values last.
const sliders = [...document.querySelectorAll("input[data-parameter]")];
const short = (value) => Number(value).toPrecision(4);
let busy = false, again = false;

function show(slider) {
  slider.nextElementSibling.textContent = short(slider.value);
}

function toFit(slider) {
  slider.value = slider.dataset.fit;
  slider.dataset.moved = "";
  show(slider);
}

async function move() {
  if (busy) { again = true; return; }
  busy = true;
  const candidate = sliders.find((each) => each.dataset.moved)?.dataset.candidate || "";
  const values = Object.fromEntries(sliders.filter((each) => each.dataset.moved).map((each) => [each.dataset.parameter, Number(each.value)]));
  const run = shown.run;
  try {
    const given = await ask(`${base}/moved`, { law, run, values, candidate });
    if (shown.run === run) { moved = given; draw(); }
  } catch (error) {
    complain(error.message);
  }
  busy = false;
  if (again) { again = false; move(); }
}

// A law that was made from this tab is opened; what else has ended is on this page when it is loaded anew. Another
// tab says what is there, and stays as it is.
function ended(job) {
  if (job.state !== "done" && !job.result.law) return;
  const address = new URL(location.href);
  if (job.result.law) { address.pathname = `${base}/laws/${job.result.law}`; address.searchParams.delete("with"); }
  else if (job.law && job.law !== law) return;
  address.hash = { build: "fmu", report: "fmu", respond: "on-pipe" }[job.kind] || "";
  address.searchParams.delete("token");
  if (!sessionStorage.getItem(ours(job))) {
    tell(`${job.title}: ${job.says}.`, "Open it", address);
    return;
  }
  if (address.hash || address.href === location.href) { history.replaceState(null, "", address); location.reload(); }
  else location.assign(address);
}

const ours = (job) => `pipeclamp ${key} ${job.number}`;
async function begin(body) {
  const job = await start(`${base}/jobs`, body, encodeURIComponent(key), ended);
  if (job) sessionStorage.setItem(ours(job), "begun here");
}

document.addEventListener("click", (event) => {
  const starter = event.target.closest("[data-start]");
  const limits = document.getElementById("limits")?.value.trim() || "";
  if (starter) begin({ kind: starter.dataset.start, law, effect: starter.dataset.effect, limits });
  const cell = event.target.closest(".map .cell");
  if (cell) look(cell.dataset.runs.split("|")[0], true);
});
document.addEventListener("submit", (event) => {
  if (event.target.dataset.job !== "identify") return;
  event.preventDefault();
  begin({ kind: "identify", base: chosen("base") });
});
document.addEventListener("change", (event) => {
  const { name, form } = event.target;
  if (name === "against" && shown) draw();
  if (name === "candidate") {
    for (const about of document.querySelectorAll("[data-about]")) about.hidden = about.dataset.about !== event.target.value;
    if (shown) look(shown.run);
  }
  if (name === "base") {
    setCommand(form.querySelector("code"), event.target.dataset.line);
  }
  if (name === "with" || name === "by") {
    const address = new URL(location.href);
    if (event.target.value) address.searchParams.set(name, event.target.value); else address.searchParams.delete(name);
    if (name === "with") address.pathname = `${base}/laws/${law}`;
    address.searchParams.delete("token");
    location.assign(address);
  }
});
for (const event of ["pointerover", "focusin"]) {
  document.addEventListener(event, ({ target }) => {
    const cell = target.closest?.(".map .cell");
    if (cell) fetchRun(cell.dataset.runs.split("|")[0]).catch(() => {});
  });
}
for (const slider of sliders) {
  slider.addEventListener("input", () => {
    // the law's own are moved, or those of one candidate
    sliders.filter((each) => each.dataset.candidate !== slider.dataset.candidate).forEach(toFit);
    slider.dataset.moved = "yes";
    show(slider);
    if (shown) move();
  });
}
document.getElementById("reset")?.addEventListener("click", () => { sliders.forEach(toFit); moved = null; if (shown) draw(); });
const walk = (step) => shown && look(runs[(runs.indexOf(shown.run) + step + runs.length) % runs.length]);
document.getElementById("previous").addEventListener("click", () => walk(-1));
document.getElementById("next").addEventListener("click", () => walk(1));
onLookChanged(() => { if (shown) draw(); });

// The map fades from what it was with the law before.
for (const cell of cells.filter((each) => each.dataset.before)) {
  const own = [...cell.classList].find((name) => /^s\d$/.test(name));
  cell.classList.replace(own, cell.dataset.before);
  setTimeout(() => cell.classList.replace(cell.dataset.before, own), 350);
}
arrows();
const wanted = new URLSearchParams(location.search).get("run");
if (runs.includes(wanted)) look(wanted);
else if (runs.length) look(worst || runs[0], false, false);
for (const place of document.querySelectorAll(".drawn")) {
  onLookChanged(() => drawIn(place, JSON.parse(place.dataset.specification)));
}
follow(encodeURIComponent(key), ended);
// What another tab has begun meanwhile is shown to whoever comes back to this one.
document.addEventListener("visibilitychange", () => { if (!document.hidden) follow(encodeURIComponent(key), ended); });
