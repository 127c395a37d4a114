// Files dropped on the page: taken, looked into, and made a campaign once that is confirmed.
import { ask, complain, start, textOf } from "./ask.js";

const drop = document.getElementById("drop");
const input = document.getElementById("files");
const form = document.getElementById("import");
const write = document.getElementById("write");
const batch = [...crypto.getRandomValues(new Uint8Array(8))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
let taken = 0;

async function take(files) {
  const told = document.getElementById("taken");
  for (const file of files) {
    told.textContent = `taking ${file.name} ...`;
    const answer = await fetch(`/uploads/${batch}/${encodeURIComponent(file.name)}`, { method: "PUT", body: file });
    if (!answer.ok) {
      const content = await answer.json().catch(() => ({}));
      complain(`${file.name}: ${content.error || answer.status}`);
      continue;
    }
    taken += 1;
  }
  told.textContent = `${taken} file${taken === 1 ? "" : "s"} taken`;
  if (taken) { form.hidden = false; write.disabled = true; form.requestSubmit(form.querySelector("[value=look]")); }
}

drop.addEventListener("dragover", (event) => { event.preventDefault(); drop.classList.add("over"); });
drop.addEventListener("dragleave", () => drop.classList.remove("over"));
drop.addEventListener("drop", (event) => { event.preventDefault(); drop.classList.remove("over"); take([...event.dataTransfer.files]); });
input.addEventListener("change", () => take([...input.files]));

const value = (id) => document.getElementById(id).value.trim();

form.addEventListener("input", () => { write.disabled = true; });
form.addEventListener("submit", async (event) => {
  event.preventDefault();
  const dry = event.submitter?.value !== "write";
  const job = await start("/import/jobs", { batch, name: value("name"), columns: value("columns"), pattern: value("pattern"), skip_unusable: document.getElementById("skip").checked, dry_run: dry }, "-", ended);
  if (job) {
    const line = document.createElement("pre");
    line.className = "scroll";
    line.tabIndex = 0;
    line.textContent = job.command;
    document.getElementById("line").replaceChildren(line);
  }
});

function ended(job) {
  if (job.state !== "done") return;
  if (job.kind === "import") { location.assign(`/c/${encodeURIComponent(value("name"))}/`); return; }
  const found = job.result.lines.map((line) => textOf("p", line));
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
  write.disabled = false;
}
