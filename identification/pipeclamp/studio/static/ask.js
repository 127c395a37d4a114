// What is asked of the server, and jobs that are followed until they end.

const GONE = "The studio doesn't answer. What was shown as saved is saved; start it again, and open the address that it prints.";

export async function ask(path, body) {
  const how = body === undefined ? {} : { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body) };
  const answer = await fetch(path, how).catch(() => { throw new Error(GONE); });
  const content = await answer.json().catch(() => ({ error: `the studio answered ${answer.status}` }));
  if (!answer.ok) throw new Error(content.error || `the studio answered ${answer.status}`);
  return content;
}

const place = () => document.getElementById("jobs");
let said = null; // stays beside the jobs until it is closed, or something is started

// A box that stays isn't taken out and put back: a click whose button is down wouldn't arrive.
function show(boxes) {
  const wanted = [...(said ? [said] : []), ...boxes], there = place().children;
  if (wanted.length !== there.length || wanted.some((box, index) => box !== there[index])) place().replaceChildren(...wanted);
}

function withdraw() {
  said?.remove();
  said = null;
}

function say(name, ...content) {
  withdraw();
  const close = textOf("button", "Close");
  close.type = "button";
  close.addEventListener("click", withdraw);
  said = document.createElement("div");
  said.className = name;
  said.append(...content, close);
  place().prepend(said);
}

export function complain(message) {
  say("job refused", textOf("b", "This doesn't work."), textOf("span", message, "says"));
}

// Something that is there now, and where.
export function tell(message, words, address) {
  const link = textOf("a", words);
  link.href = address;
  say("job", textOf("span", message, "says"), link);
}

export function textOf(tag, text, name = "") {
  const made = document.createElement(tag);
  made.textContent = text;
  if (name) made.className = name;
  return made;
}

const boxes = new Map(); // of jobs, by number: a job tells many times a second what it does

function drawn(job, key) {
  const known = boxes.get(job.number);
  if (known?.classList.contains(job.state)) {
    known.querySelector(".says").textContent = job.says;
    return known;
  }
  const box = document.createElement("div");
  boxes.set(job.number, box);
  box.className = `job ${job.state}`;
  box.append(textOf("b", job.title));
  if (job.state === "running") {
    const bar = document.createElement("progress");
    bar.setAttribute("aria-label", job.title);
    box.append(bar);
  }
  box.append(textOf("span", job.says, "says"));
  const time = textOf("span", `${Math.round(job.seconds)} s`, "time");
  time.setAttribute("aria-hidden", "true");
  box.append(time);
  if (job.state === "running") {
    const cancel = textOf("button", "Cancel");
    cancel.type = "button";
    cancel.addEventListener("click", () => ask(`/c/${key}/jobs/${job.number}/cancel`, {}));
    box.append(cancel);
    const began = Date.now() - 1000 * job.seconds;
    const clock = setInterval(() => {
      if (!box.isConnected) clearInterval(clock);
      else time.textContent = `${Math.round((Date.now() - began) / 1000)} s`;
    }, 1000);
  }
  return box;
}

let following = null;

// Shows a campaign's running jobs, and calls `ended` once with each that ends while the page is open.
export function follow(key, ended) {
  if (following) following.close();
  const seen = new Set();
  following = new EventSource(`/c/${key}/jobs`);
  following.onmessage = (event) => {
    const jobs = JSON.parse(event.data);
    for (const job of jobs) if (job.state === "running") seen.add(job.number);
    const over = jobs.filter((job) => seen.has(job.number) && job.state !== "running");
    const told = jobs.filter((job) => job.state === "running" || (seen.has(job.number) && job.state !== "done"));
    show(told.map((job) => drawn(job, key)));
    if (!jobs.some((job) => job.state === "running")) following.close();
    for (const job of over) {
      seen.delete(job.number);
      ended(job);
    }
  };
  let failures = 0;
  following.onopen = () => { failures = 0; };
  following.onerror = () => {
    failures += 1; // the browser asks again by itself
    if (failures < 2 && following.readyState !== EventSource.CLOSED) return;
    following.close();
    show([]);
    complain(GONE);
  };
}

export async function start(path, body, key, ended) {
  try {
    const job = await ask(path, body);
    withdraw();
    if (job.state === "running") follow(key, ended);
    return job;
  } catch (error) {
    complain(error.message);
    return null;
  }
}
