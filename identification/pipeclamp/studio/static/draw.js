// Pictures of one run, as the pages draw them (page.js, explorer.js), and its harmonics.
/* global drawIn, lawLine, runPicture */

// `run`: as the studio gives it; its last law is the one that the page is about.
export function drawRun(run, axis) {
  const names = run.by_law.map((each) => each.name);
  const picture = runPicture({ ...run, words: "" }, names, [...names.keys()], axis);
  delete picture.layout.title;
  Object.assign(picture.layout, { height: undefined, showlegend: false, margin: { l: 64, r: 10, t: 8, b: 44 } });
  if (!names.length) { // no law, no difference: the loop has all the room
    picture.layout.yaxis.domain = [0, 1];
    picture.layout.xaxis.anchor = "y";
    delete picture.layout.yaxis2;
  }
  // margins that fit themselves are laid out several times
  for (const axis of ["xaxis", "yaxis", "yaxis2"]) if (picture.layout[axis]) picture.layout[axis].automargin = false;
  drawIn(document.getElementById("loop"), picture);
  document.getElementById("loop-words").textContent = `Run ${run.run}: the measured loop${names.length ? ` and that of ${names.join(", ")}; below it measured less law` : ""}.`;
  const number = ++drawn; // harmonics come a frame later: the loop first
  requestAnimationFrame(() => setTimeout(() => number === drawn && drawHarmonics(run.by_law)));
}

let drawn = 0;

function drawHarmonics(laws) {
  const place = document.getElementById("harmonics");
  place.closest("figure").hidden = place.closest("figure").previousElementSibling.hidden = !laws.length;
  if (!laws.length) return;
  const x = laws[0].measured.map((_, index) => index + 1);
  const bars = (y, name, color) => ({ type: "bar", x, y, name, marker: { color }, hovertemplate: `${name}, harmonic %{x}: %{y:.3g} N<extra></extra>` });
  const data = [bars(laws[0].measured, "measured", "#52606d"), ...laws.map((each, index) => bars(each.computed, each.name, lawLine(index, laws.length).color))];
  const least = Math.max(Math.min(...laws[0].measured), 1e-6); // what a law gives far below it says nothing
  const most = Math.max(...laws.flatMap((each) => [...each.measured, ...each.computed]));
  const look = { gridcolor: "#e4e7eb", zerolinecolor: "#52606d", linecolor: "#1f2933", ticks: "outside" };
  const layout = {
    font: { family: "system-ui, 'Segoe UI', Roboto, Arial, sans-serif", size: 12, color: "#1f2933" },
    plot_bgcolor: "white", paper_bgcolor: "white", margin: { l: 64, r: 10, t: 8, b: 38 }, showlegend: false,
    barmode: "group", bargap: 0.25, hovermode: "closest",
    xaxis: { ...look, title: { text: "harmonic", standoff: 4 }, dtick: 1 },
    yaxis: { ...look, title: { text: "N" }, type: "log", dtick: 1, exponentformat: "none", range: [Math.floor(Math.log10(least)), Math.log10(most) + 0.2] },
  };
  drawIn(place, { data, layout });
}
