// Pictures of one run: the loop, what is measured less what laws give, the harmonics.
/* global Plotly */

const CONFIG = { responsive: true, displayModeBar: false, doubleClick: "reset" };
const AXES = { phase: "phase / deg after the largest displacement", y: "y / mm", v: "v / mm/s" };

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const closed = (values) => [...values, values[0]];

function layout(height, x, y, more = {}) {
  const look = { gridcolor: colour("line"), zerolinecolor: colour("soft"), linecolor: colour("ink"), ticks: "outside", automargin: true };
  return {
    font: { family: "system-ui, 'Segoe UI', Roboto, Arial, sans-serif", size: 12, color: colour("ink") },
    plot_bgcolor: "rgba(0,0,0,0)", paper_bgcolor: "rgba(0,0,0,0)", height, margin: { l: 56, r: 10, t: 8, b: 38 },
    showlegend: false, hovermode: "closest",
    xaxis: { ...look, title: { text: x, standoff: 4 }, ...more.xaxis }, yaxis: { ...look, title: { text: y, standoff: 4 }, ...more.yaxis },
    ...(more.layout || {}),
  };
}

function abscissa(run, axis) {
  if (axis !== "phase") return closed(run[axis]);
  return Array.from({ length: run.y.length + 1 }, (_, index) => (360 * index) / run.y.length);
}

// Where the abscissa turns back: the band is drawn in pieces between.
const TURNS = { phase: [], y: [0, 0.5], v: [0.25, 0.75] };

function band(run, axis) {
  if (!run.scatter) return [];
  const count = run.y.length;
  const xs = abscissa(run, axis);
  const turns = TURNS[axis].map((turn) => Math.round(turn * count));
  const pieces = turns.length ? [[turns[0], turns[1]], [turns[1], turns[0] + count]] : [[0, count]];
  return pieces.map(([from, to]) => {
    const along = Array.from({ length: to - from + 1 }, (_, index) => from + index);
    const x = along.map((index) => (axis === "phase" ? xs[index] : xs[index % count]));
    const high = along.map((index) => run.scatter[Math.floor(((index % count) * run.scatter.length) / count)]);
    return {
      x: [...x, ...x.slice().reverse()], y: [...high, ...high.map((value) => -value).reverse()], fill: "toself",
      fillcolor: colour("band"), line: { width: 0 }, mode: "lines", hoverinfo: "skip",
    };
  });
}

let drawn = 0;

// `lines`: what is drawn over the measured loop, each { name, force, colour, dash, harmonics }.
export function drawRun(run, lines, axis) {
  const line = (y, name, look, x) => ({ x, y: closed(y), name, mode: "lines", line: { simplify: false, ...look }, hovertemplate: `${name}<br>%{x:.4g}, %{y:.4g} N<extra></extra>` });
  const looked = (each) => ({ color: colour(each.colour), width: 1.8, dash: each.dash || "solid" });
  const loop = [line(run.measured, "measured", { color: colour("measured"), width: 4 }, closed(run.y))];
  for (const each of lines) loop.push(line(each.force, each.name, looked(each), closed(run.y)));
  Plotly.react("loop", loop, layout(320, "y / mm", "F / N"), CONFIG);
  const x = abscissa(run, axis);
  const left = lines.map((each) => line(run.measured.map((force, index) => force - each.force[index]), each.name, looked(each), x));
  const ticks = axis === "phase" ? { range: [0, 360], dtick: 45 } : {};
  Plotly.react("residual", [...band(run, axis), ...left], layout(190, AXES[axis], "N", { xaxis: ticks, yaxis: { rangemode: "normal" } }), CONFIG);
  const number = ++drawn; // harmonics come a frame later: the loop first
  requestAnimationFrame(() => setTimeout(() => number === drawn && drawHarmonics(lines)));
  for (const [id, what] of [["loop", "Loop: force over displacement"], ["residual", "Measured less law"], ["harmonics", "Harmonics of the force"]]) {
    const place = document.getElementById(id);
    place.setAttribute("role", "img");
    place.setAttribute("aria-label", `${what}, run ${run.run}, measured and ${lines.map((each) => each.name).join(", ") || "no law"}`);
  }
}

function drawHarmonics(lines) {
  const place = document.getElementById("harmonics");
  const known = lines.filter((each) => each.harmonics);
  place.previousElementSibling.hidden = place.hidden = !known.length;
  if (!known.length) return;
  const orders = known[0].harmonics.measured.map((_, index) => index + 1);
  const bars = (y, name, fill) => ({ type: "bar", x: orders, y, name, marker: { color: colour(fill) }, hovertemplate: `${name}, harmonic %{x}: %{y:.3g} N<extra></extra>` });
  const data = [bars(known[0].harmonics.measured, "measured", "measured"), ...known.map((each) => bars(each.harmonics.computed, each.name, each.colour))];
  const least = Math.max(Math.min(...known[0].harmonics.measured), 1e-6); // what a law gives far below it says nothing
  const most = Math.max(...known.flatMap((each) => [...each.harmonics.measured, ...each.harmonics.computed]));
  const range = [Math.floor(Math.log10(least)), Math.log10(most) + 0.2];
  const decades = { type: "log", dtick: 1, exponentformat: "none", range };
  Plotly.react(place, data, layout(170, "harmonic", "N", { xaxis: { dtick: 1 }, yaxis: decades, layout: { barmode: "group", bargap: 0.25 } }), CONFIG);
}
