"use strict";
// Runs to be picked: a map over A and f, the picked run's loop under each law, and what the law leaves over below it.

const LAW_COLOURS = ["#1c7ed6", "#e8590c", "#2b8a3e", "#9c36b5", "#0b7285", "#846358", "#c2255c", "#495057"];
const DASHES = ["dot", "dash", "longdash", "dashdot"];
const EXCESS_COLOURS = [[255, 247, 236], [253, 212, 158], [252, 141, 89], [215, 48, 31], [127, 0, 0]];
const MOST_EXCESS = 30; // the same on every page, so that maps compare
const AXES = {
  y: { title: "y / mm", turns: [0, 0.5] },
  v: { title: "v / mm/s", turns: [0.25, 0.75] },
  phase: { title: "phase / deg after the largest displacement", turns: [] },
};

function lawLine(index, count) {
  // the law that the page is about is red and whole, those before it are broken lines
  if (index === count - 1) return { color: "#d64545", width: 1.8 };
  return { color: LAW_COLOURS[index % LAW_COLOURS.length], width: 1.6, dash: DASHES[index % DASHES.length] };
}

function samplesOf(packed) {
  if (Array.isArray(packed)) return packed;
  const bytes = Uint8Array.from(atob(packed.int16), (character) => character.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  return Array.from({ length: bytes.length / 2 }, (_, index) => packed.step * view.getInt16(2 * index, true));
}

const closed = (values) => [...values, values[0]];

function abscissa(run, axis) {
  const samples = samplesOf(run[axis]);
  return axis === "phase" ? [...samples, samples[0] + 360] : closed(samples);
}

function differenceOf(run, law) {
  const computed = samplesOf(run.laws[law]);
  return samplesOf(run.measured).map((force, index) => force - computed[index]);
}

// Single cycles show none.
function showsScatter(runs) {
  return runs.some((run) => run.squared_scatter !== null);
}

function scatterAt(run, phase) {
  return run.scatter[Math.floor((phase * run.scatter.length) / 360) % run.scatter.length];
}

// The band of one standard deviation of scatter, in pieces along which the abscissa doesn't turn back.
function bandTraces(run, axis, xs) {
  if (!run.scatter) return [];
  const phases = samplesOf(run.phase);
  const count = phases.length;
  const turns = AXES[axis].turns.map((turn) => Math.max(phases.findIndex((phase) => phase >= 360 * turn), 0));
  const pieces = turns.length ? [[turns[0], turns[1]], [turns[1], turns[0] + count]] : [[0, count]];
  return pieces.map(([from, to], piece) => {
    const along = Array.from({ length: to - from + 1 }, (_, index) => (from + index) % count);
    const x = along.map((index, place) => (axis === "phase" ? xs[from + place] : xs[index]));
    const high = along.map((index) => scatterAt(run, phases[index]));
    return {
      x: [...x, ...x.slice().reverse()], y: [...high, ...high.map((value) => -value).reverse()], xaxis: "x", yaxis: "y2",
      fill: "toself", fillcolor: "rgba(134, 142, 150, 0.28)", line: { width: 0 }, mode: "lines", hoverinfo: "skip",
      name: "cycle-to-cycle scatter, ± 1 standard deviation", legendgroup: "scatter", showlegend: piece === 0,
    };
  });
}

function withRoom(xs) {
  const known = xs.filter(Number.isFinite);
  const [low, high] = [Math.min(...known), Math.max(...known)];
  const room = 0.03 * (high - low || 1);
  return [low - room, high + room];
}

/**
 * Give Plotly's picture of one run: its loop above, and below what is measured less what each law gives.
 * `shown` holds the indices of the laws; `names` all their labels; `axis` is y, v or phase.
 */
function runPicture(run, names, shown, axis) {
  const xs = abscissa(run, axis);
  const trace = (y, yaxis, name, line, more) => ({
    x: xs, y: closed(y), xaxis: "x", yaxis, name, mode: "lines", line: { simplify: false, ...line }, legendgroup: name,
    ...more,
  });
  const data = [
    trace(samplesOf(run.measured), "y", "measured", { color: "#52606d", width: 4 }),
    ...bandTraces(run, axis, xs),
  ];
  for (const law of shown) {
    const line = lawLine(law, names.length);
    data.push(trace(samplesOf(run.laws[law]), "y", names[law], line));
    data.push(trace(differenceOf(run, law), "y2", names[law], line, { showlegend: false }));
  }
  const look = {
    gridcolor: "#e4e7eb", zerolinecolor: "#52606d", linecolor: "#1f2933", ticks: "outside", automargin: true,
  };
  const layout = {
    title: { text: `${run.run}: ${run.words}`, font: { size: 15 }, x: 0.01, xanchor: "left" },
    font: { family: "system-ui, 'Segoe UI', Roboto, Arial, sans-serif", size: 12, color: "#1f2933" },
    plot_bgcolor: "white", paper_bgcolor: "white", height: 620, margin: { l: 64, r: 16, t: 46, b: 90 },
    legend: { orientation: "h", yref: "container", yanchor: "bottom", y: 0, x: 0 }, hovermode: "closest",
    xaxis: { ...look, title: { text: AXES[axis].title }, anchor: "y2" },
    yaxis: { ...look, title: { text: "F / N" }, domain: [0.44, 1] },
    yaxis2: { ...look, title: { text: "measured less law / N" }, domain: [0, 0.38] },
  };
  if (axis === "phase") Object.assign(layout.xaxis, { range: [0, 360], dtick: 45 });
  else layout.xaxis.range = withRoom(xs); // Plotly's own ends where lines do, and cuts the loop's turns
  return { data, layout };
}

const rootShare = (share, whole) => Math.sqrt(share / whole);

function errorOf(runs, law) {
  const sum = (of) => runs.reduce((total, run) => total + of(run), 0);
  const force = sum((run) => run.squared_force);
  const known = runs.every((run) => run.squared_scatter !== null);
  return {
    error: rootShare(sum((run) => run.squared_error[law]), force),
    scatter: known ? rootShare(sum((run) => run.squared_scatter), force) : null,
  };
}

function excessColour(excess) {
  const share = Math.min(Math.max(Math.log(excess) / Math.log(MOST_EXCESS), 0), 1) * (EXCESS_COLOURS.length - 1);
  const low = Math.min(Math.floor(share), EXCESS_COLOURS.length - 2);
  const mixed = EXCESS_COLOURS[low].map((value, channel) =>
    Math.round(value + (share - low) * (EXCESS_COLOURS[low + 1][channel] - value)));
  const [red, green, blue] = mixed.map((value) => (value / 255) ** 2.2);
  return { background: `rgb(${mixed.join(",")})`, dark: 0.2126 * red + 0.7152 * green + 0.0722 * blue < 0.18 };
}

const percent = (share) => `${(100 * share).toPrecision(3)}%`;
const short = (value) => (value >= 10 ? value.toFixed(0) : value.toFixed(1));

function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key in made && key !== "list") made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

// A loop, or what the laws leave over, as small as a cell; `height` is one for all cells.
function smallPicture(run, shown, count, residual, height) {
  const y = samplesOf(run.y);
  const reach = Math.max(...y.map(Math.abs));
  const most = Math.max(...samplesOf(run.measured).map(Math.abs));
  const lines = residual
    ? shown.map((law) => [differenceOf(run, law), lawLine(law, count)])
    : [[samplesOf(run.measured), { color: "#52606d", width: 3 }],
       ...shown.map((law) => [samplesOf(run.laws[law]), lawLine(law, count)])];
  const look = inLook({ lines: lines.map(([, line]) => line) }).lines;
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "-1.1 -1.1 2.2 2.2");
  svg.setAttribute("preserveAspectRatio", "none");
  lines.forEach(([force, line], index) => {
    const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
    const points = closed(force).map((value, place) =>
      `${(closed(y)[place] / reach).toFixed(3)},${(-value / (most * height)).toFixed(3)}`);
    path.setAttribute("d", `M${points.join("L")}`);
    path.setAttribute("fill", "none");
    path.setAttribute("stroke", look[index].color);
    path.setAttribute("stroke-width", line.width > 2 ? 2.4 : 1.2);
    path.setAttribute("vector-effect", "non-scaling-stroke");
    svg.append(path);
  });
  return svg;
}

function differenceReach(runs, shown) {
  const reach = runs.map((run) => {
    const most = Math.max(...samplesOf(run.measured).map(Math.abs));
    return Math.max(...shown.flatMap((law) => differenceOf(run, law).map((value) => Math.abs(value) / most)));
  });
  return Math.max(...reach, 1e-9);
}

let explorers = 0;

function explore(root, content) {
  const { laws, conditions, runs } = content;
  const last = laws.length - 1;
  const worst = [...runs.keys()].sort((one, other) =>
    errorOf([runs[other]], last).error - errorOf([runs[one]], last).error);
  const state = { run: worst[0], shown: new Set([last]), axis: "y", show: "excess", split: 0, level: -1 };
  if (last > 0) state.shown.add(0);
  const further = conditions.slice(2);
  const id = `explorer-${explorers++}`;

  const choice = (legend, name, options, chosen, change) => element("fieldset", {},
    element("legend", { textContent: legend }),
    ...options.map(([value, label]) => element("label", {},
      element("input", {
        type: "radio", name: `${id}-${name}`, value, checked: value === chosen, onchange: () => change(value),
      }), ` ${label}`)));

  const lawBoxes = laws.map((label, law) => element("label", {},
    element("input", {
      type: "checkbox", checked: state.shown.has(law),
      onchange: (event) => {
        if (event.target.checked) state.shown.add(law);
        else state.shown.delete(law);
        update();
      },
    }), " ", element("span", { className: "swatch" }),
    ` ${label}: ${percent(errorOf(runs, law).error)}`));

  const picker = element("select", { onchange: (event) => { state.run = Number(event.target.value); update(); } },
    ...worst.map((index) => element("option", {
      value: index, textContent: `${runs[index].run}: ${runs[index].words}, error ${percent(errorOf([runs[index]], last).error)}`,
    })));
  const step = (by) => {
    const place = (worst.indexOf(state.run) + by + runs.length) % runs.length;
    state.run = worst[place];
    update();
  };
  const levels = element("select", {
    onchange: (event) => {
      [state.split, state.level] = event.target.value.split(",").map(Number);
      update();
    },
  }, ...further.flatMap((condition, split) => condition.labels.map((label, level) => element("option", {
    value: `${split},${level}`, textContent: `${condition.title} ${label}`,
  }))));
  levels.prepend(element("option", { value: "0,-1", textContent: "all tests" }));
  levels.value = "0,-1";

  const maps = element("div", { className: "maps" });
  const meaning = element("p"); // not among the maps, which may be scrolled and fade at their end
  const picture = element("div", { className: "chosen" });
  const caption = element("figcaption", { className: "unseen" });

  root.append(
    element("div", { className: "controls" },
      element("fieldset", {}, element("legend", { textContent: laws.length > 1 ? "Laws" : "Law" }), ...lawBoxes)),
    element("div", { className: "controls" },
      choice("Map of", "show",
        [["excess", showsScatter(runs) ? "error over scatter" : "error"], ["loops", "loops"], ["difference", "measured less law"]], state.show,
        (value) => { state.show = value; update(); }),
      ...(further.length ? [element("label", {}, "at ", levels)] : [])),
    maps,
    meaning,
    element("div", { className: "controls" },
      element("label", {}, "Run ", picker),
      element("button", { type: "button", textContent: "worse", onclick: () => step(-1) }),
      element("button", { type: "button", textContent: "better", onclick: () => step(1) }),
      choice("against", "axis", [["y", "displacement"], ["v", "velocity"], ["phase", "phase"]], state.axis,
        (value) => { state.axis = value; update(); })),
    element("figure", {}, caption, picture),
  );

  function mapOf(law, shownRuns, reach) {
    const [A, f] = conditions;
    const small = state.show !== "excess";
    const at = (row, column) => shownRuns.filter((index) =>
      runs[index].levels[0] === row && runs[index].levels[1] === column);
    const worstRun = shownRuns.reduce((one, other) =>
      errorOf([runs[other]], law).error > errorOf([runs[one]], law).error ? other : one, shownRuns[0]);
    const cell = (row, column) => {
      const there = at(row, column);
      if (!there.length) return element("td");
      const chosen = there.reduce((one, other) =>
        errorOf([runs[other]], law).error > errorOf([runs[one]], law).error ? other : one);
      const { error, scatter } = errorOf(there.map((index) => runs[index]), law);
      const excess = scatter ? error / scatter : null;
      const words = `${A.title} ${A.labels[row]}, ${f.title} ${f.labels[column]}: error ${percent(error)}`
        + (scatter ? `, ${short(excess)} times the scatter of ${percent(scatter)}` : ", scatter not known");
      const button = element("button", {
        type: "button", title: words, "aria-label": `${words}; show the run`,
        "aria-pressed": String(there.includes(state.run)), onclick: () => { state.run = chosen; update(); },
      });
      if (small) {
        button.append(smallPicture(runs[chosen], [law], laws.length, state.show === "difference", reach));
      } else {
        const { background, dark } = excessColour(excess ?? 1);
        button.textContent = excess === null ? percent(error) : short(excess);
        button.style.background = background;
        if (dark) button.classList.add("dark");
      }
      if (there.includes(worstRun)) button.classList.add("worst");
      return element("td", {}, button);
    };
    const rows = [...A.labels.keys()].filter((row) => shownRuns.some((index) => runs[index].levels[0] === row));
    const columns = [...f.labels.keys()].filter((column) => shownRuns.some((index) => runs[index].levels[1] === column));
    return element("div", {},
      element("h3", { textContent: laws.length > 1 ? laws[law] : content.title }),
      element("table", { className: small ? "map small" : "map" },
        element("thead", {}, element("tr", {},
          element("th", { scope: "col", textContent: `${A.title} \\ ${f.title}` }),
          ...columns.map((column) => element("th", { scope: "col", textContent: f.labels[column] })))),
        element("tbody", {}, ...rows.reverse().map((row) => element("tr", {},
          element("th", { scope: "row", textContent: A.labels[row] }), ...columns.map((column) => cell(row, column)))))));
  }

  function scale() {
    const known = showsScatter(runs);
    if (state.show === "loops") return "Each loop on its own scale; framed: the largest error in percent of its rms force.";
    if (state.show === "difference") return "Measured less law over displacement, as a share of each run's largest force, all on one scale; framed: the largest error in percent of its rms force.";
    if (!known) return "Error in percent of the rms force. Single cycles show no scatter, so that it isn't known how much of it is scatter; framed: holds the run with the largest error in percent.";
    const parts = [1, 3, 10, 30].map((value) => {
      const { background, dark } = excessColour(value);
      return element("span", { className: dark ? "dark" : "", style: `background: ${background}`, textContent: value });
    });
    return element("span", { className: "scale" }, "error over cycle-to-cycle scatter: ", ...parts, " 1 is as good as can be; framed: holds the run with the largest error in percent");
  }

  function update() {
    const shown = [...state.shown].sort((one, other) => one - other);
    const focused = document.activeElement?.closest?.(".maps") === maps ? document.activeElement.title : null;
    const shownRuns = [...runs.keys()].filter((index) =>
      state.level < 0 || runs[index].levels[2 + state.split] === state.level);
    const reach = state.show === "difference" ? differenceReach(shownRuns.map((index) => runs[index]), shown) : 1.0;
    root.querySelectorAll(".swatch").forEach((swatch, law) => {
      swatch.style.borderTopColor = inLook(lawLine(law, laws.length)).color;
    });
    maps.replaceChildren(...shown.map((law) => mapOf(law, shownRuns, reach)));
    meaning.replaceChildren(scale());
    if (focused) [...maps.querySelectorAll("button")].find((button) => button.title === focused)?.focus();
    picker.value = String(state.run);
    const run = runs[state.run];
    caption.textContent = `${run.run}, ${run.words}: measured loop, and below it measured less law. `
      + shown.map((law) => `${laws[law]}: error ${percent(errorOf([run], law).error)}`).join("; ");
    drawIn(picture, runPicture(run, laws, shown, state.axis));
  }

  onLookChanged(update);
}

for (const root of document.querySelectorAll(".explorer")) {
  const script = root.querySelector("script");
  const content = JSON.parse(script.textContent);
  script.remove();
  explore(root, content);
}
