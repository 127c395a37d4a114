// Files dropped on the page: taken, looked into, and made a campaign once that is confirmed.
import { follow, start, tell, textOf } from "./ask.js";

/* global drawIn, onLookChanged */

const drop = document.getElementById("drop");
const input = document.getElementById("files");
const form = document.getElementById("import");
const write = document.getElementById("write");
const look = form.querySelector("[value=look]");
const WIDE = 900; // px, from which on loops stand beside each other
const batch = [...crypto.getRandomValues(new Uint8Array(8))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
const mine = new Set(); // numbers of the jobs that this page started
let taken = 0;

async function take(files) {
  const told = document.getElementById("taken");
  const refused = [];
  for (const file of files) {
    told.textContent = `taking ${file.name} ...`;
    const answer = await fetch(`/uploads/${batch}/${encodeURIComponent(file.name)}`, { method: "PUT", body: file });
    if (!answer.ok) {
      const content = await answer.json().catch(() => ({}));
      refused.push(content.error || `${file.name}: the studio answered ${answer.status}`);
      continue;
    }
    taken += 1;
  }
  told.textContent = [`${taken} file${taken === 1 ? "" : "s"} taken`, ...refused].join("\n");
  if (taken) { form.hidden = false; right(false); form.requestSubmit(look); }
}

drop.addEventListener("dragover", (event) => { event.preventDefault(); drop.classList.add("over"); });
drop.addEventListener("dragleave", () => drop.classList.remove("over"));
drop.addEventListener("drop", (event) => { event.preventDefault(); drop.classList.remove("over"); take([...event.dataTransfer.files]); });
input.addEventListener("change", () => take([...input.files]));

const value = (id) => document.getElementById(id).value.trim();

// What comes next is the button that stands out.
function right(known) {
  write.disabled = !known;
  write.classList.toggle("primary", known);
  look.classList.toggle("primary", !known);
}

// A refusal ends with the option that would tell the channels, a look with the pattern of the files' names: one click takes it over.
const PROPOSED = { columns: /--columns "([^"]+)"/, pattern: /with the pattern "([^"]+)"/ };
function propose(said) {
  for (const [id, words] of Object.entries(PROPOSED)) {
    const button = document.getElementById(`proposed-${id}`);
    const option = said.match(words);
    button.hidden = !option;
    button.onclick = () => {
      document.getElementById(id).value = option[1];
      button.hidden = true;
      right(false);
    };
  }
}

form.addEventListener("input", () => right(false));
form.addEventListener("submit", async (event) => {
  event.preventDefault();
  const dry = event.submitter?.value !== "write";
  const job = await start("/import/jobs", { batch, name: value("name"), columns: value("columns"), rate: value("rate").replace(",", "."), pattern: value("pattern"), skip_unusable: document.getElementById("skip").checked, dry_run: dry }, "-", ended);
  if (job) {
    mine.add(job.number);
    const line = document.createElement("pre");
    line.className = "scroll";
    line.tabIndex = 0;
    line.textContent = job.command;
    document.getElementById("line").replaceChildren(line);
  }
});

function ended(job) {
  const at = job.kind === "import" && job.state === "done" ? `/c/${encodeURIComponent(job.result.name)}/` : "";
  if (!mine.has(job.number)) { // another page's, or this one's before it was loaded anew
    if (at) tell(`${job.result.name} is imported.`, "Open it", at);
    return;
  }
  propose(job.state === "done" ? job.result.lines.join("\n") : job.says);
  if (job.state !== "done") { document.getElementById("found").replaceChildren(); return; }
  if (at) { location.assign(at); return; }
  const found = job.result.lines.map((line) => textOf("p", line));
  const { loops } = job.result;
  if (loops) found.push(pictured(loops));
  for (const table of job.result.tables) {
    const made = document.createElement("table");
    made.className = "plain";
    if (table.caption) made.append(textOf("caption", table.caption));
    const head = made.createTHead().insertRow();
    for (const name of table.header) { const cell = textOf("th", name); cell.scope = "col"; head.append(cell); }
    const body = made.createTBody();
    for (const row of table.rows) { const line = body.insertRow(); for (const cell of row) line.append(textOf("td", cell)); }
    const around = document.createElement("div");
    around.className = "scroll";
    around.tabIndex = 0;
    around.setAttribute("role", "region");
    around.setAttribute("aria-label", table.header.join(", "));
    around.append(made);
    found.push(around);
  }
  document.getElementById("found").replaceChildren(...found);
  if (loops) onLookChanged(() => drawLoops(loops));
  right(true);
}

function pictured(loops) {
  const around = document.createElement("details");
  around.open = innerWidth > WIDE;
  const figure = document.createElement("figure");
  const place = document.createElement("div");
  place.id = "loops";
  figure.append(textOf("figcaption", loops.words, "hidden"), place);
  around.append(textOf("summary", loops.title), figure);
  around.addEventListener("toggle", () => drawLoops(loops));
  return around;
}

function drawLoops(loops) {
  const place = document.getElementById("loops");
  if (place?.closest("details").open) drawIn(place, JSON.parse(loops.specification));
}

follow("-", ended);
// They may have been chosen before this ran: the page shows before its pictures' library has come.
if (input.files.length) take([...input.files]);
