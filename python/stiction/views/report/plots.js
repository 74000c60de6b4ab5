// How numbers are drawn: every function takes the element it draws in and what it draws, and knows nothing of the state
// of the page.

// ---- Elements -------------------------------------------------------------------------------------------------------

/** An element with attributes and children; text is never markup. */
function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

function svg(width, ...shapes) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  for (const [key, value] of Object.entries({width, height: 16, viewBox: `0 0 ${width} 16`, "aria-hidden": "true"}))
    made.setAttribute(key, value);
  for (const [name, attributes] of shapes) {
    const shape = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) shape.setAttribute(key, value);
    made.append(shape);
  }
  return made;
}

// ---- Axes -----------------------------------------------------------------------------------------------------------

const FONT = {family: getComputedStyle(document.body).fontFamily, size: 13, color: "#1b1f24"};
const MARGIN = {l: 72, r: 16, t: 8, b: 48};
const CONFIG = {displayModeBar: false, responsive: true, scrollZoom: false, doubleClick: false};
const AXIS = {
  ticks: "outside", ticklen: 5, tickcolor: "#57606a", linecolor: "#57606a", linewidth: 1, mirror: true,
  showline: true, zeroline: false, gridcolor: "#e6eaee", fixedrange: true, tickangle: 0,
  exponentformat: "power", minexponent: 4,
};
const LOG_AXIS = {...AXIS, type: "log", minor: {ticks: "outside", ticklen: 3, tickcolor: "#8c959f"}};

const titled = (text) => ({text, standoff: 6});

function layout(xaxis, yaxis, more = {}) {
  return {font: FONT, margin: MARGIN, dragmode: false, showlegend: false, hovermode: "closest",
    paper_bgcolor: "#ffffff", plot_bgcolor: "#fefefe", xaxis, yaxis, ...more};
}

/** A logarithmic axis over a range: powers of ten alone where there are several, else 2 and 5 between them. */
function logAxis(text, low, high) {
  const ticks = high / low > 300 ? {dtick: 1} : high / low >= DECADE ? {dtick: "D2"} : {};
  return {...LOG_AXIS, title: titled(text), range: [low, high].map(Math.log10), ...ticks};
}

const loadAxis = (low, high) => logAxis("normal load <i>F</i><sub>N</sub> (mN)", low, high);

// ---- The map ---------------------------------------------------------------------------------------------------------

// Fill patterns of the map and of its legend. The first is the map's background, which costs nothing to draw.
const BACKGROUND = "not-reached";
const MARKS = {
  "not-reached": {shape: "/", fgcolor: "#8c959f", bgcolor: "#ffffff"},
  "below-range": {shape: "\\", fgcolor: "#57606a", bgcolor: "#e6eaee"},
  "no-contact": {shape: ".", fgcolor: "#57606a", bgcolor: "#ffffff"},
  "self-locked": {shape: "", fgcolor: "#7a0019", bgcolor: "#7a0019"},
};
const VALIDITY_LINES = {share_beyond_hertz: "solid", share_below_grid: "2px,2px"};

/** Round numbers on the scale of colours, no closer than their labels are long. */
function colourTicks(ticks, low, high, width) {
  const place = (tick) => (width * Math.log(tick / low)) / Math.log(high / low);
  let last = -Infinity;
  return ticks.filter((tick) => {
    const isFree = tick >= low * 0.999 && tick <= high * 1.001 && place(tick) - last >= 36;
    if (isFree) last = place(tick);
    return isFree;
  });
}

function swatch(mark) {
  const stroke = {stroke: mark.fgcolor, "stroke-width": 1.3};
  const rising = mark.shape === "/";
  const slanted = [-8, 0, 8, 16].map((x) => ["path", {d: rising ? `M${x} 16 l16 -16` : `M${x} 0 l16 16`, ...stroke}]);
  const dots = [4, 12, 20].flatMap((x) => [4, 12].map((y) => ["circle", {cx: x, cy: y, r: 1.3, fill: mark.fgcolor}]));
  const pattern = {"/": slanted, "\\": slanted, ".": dots, "": []}[mark.shape];
  const frame = {x: 0.5, y: 0.5, width: 23, height: 15};
  const outline = {...frame, fill: "none", stroke: "#57606a"};
  return svg(24, ["rect", {...frame, fill: mark.bgcolor}], ...pattern, ["rect", outline]);
}

const colour = (fill) => svg(24, ["rect", {x: 0.5, y: 0.5, width: 23, height: 15, fill, stroke: "#57606a"}]);

function line(dash) {
  const stroke = {stroke: "#ffffff", "stroke-width": 2, "stroke-dasharray": dash === "solid" ? "none" : "2 2"};
  return svg(28, ["rect", {width: 28, height: 16, fill: "#3b528b"}], ["path", {d: "M0 8 H28", ...stroke}]);
}

const ring = () => svg(16, ["circle", {cx: 8, cy: 8, r: 5.5, fill: "none", stroke: "#d1005d", "stroke-width": 2.5}]);

/** The friction coefficient over dimension and load: map of `frictionMap`, ends of the colours, picked [d, l]. */
function drawMap(place, legendPlace, facts, map, loads, [low, high], picked) {
  const x = edges(facts.dimensions);
  const y = edges(loads.map(Math.log)).map(Math.exp);
  const ticks = colourTicks(facts.ticks, low, high, place.clientWidth - MARGIN.l - MARGIN.r);
  const traces = [];
  const legend = [];
  for (const [name, mark] of Object.entries(MARKS)) {
    const [xs, ys] = outlines(map.status, name, x, y);
    if (!xs.length) continue;
    legend.push([swatch(mark), facts.statuses[name].short]);
    if (name === BACKGROUND) continue;
    traces.push({
      type: "scatter", mode: "lines", x: xs, y: ys, fill: "toself", hoverinfo: "skip", line: {width: 0},
      fillcolor: mark.bgcolor,
      fillpattern: {shape: mark.shape, fgcolor: mark.fgcolor, bgcolor: mark.bgcolor, size: 7, solidity: 0.2},
    });
  }
  const values = map.value.flat().filter((value) => value !== null);
  // Plotly has no pointer for a map without any value, so a row beyond the axis always has some.
  const beyond = facts.dimensions.map(() => low);
  const logarithm = (value) => (value === null ? null : Math.log10(Math.max(value, 1e-12)));
  traces.push({
    type: "heatmap", x, y: [...y, 2 * y.at(-1)], z: [...map.value, beyond].map((row) => row.map(logarithm)),
    zmin: Math.log10(low), zmax: Math.log10(high), colorscale: "Viridis", hoverinfo: "none", hoverongaps: true,
    colorbar: {
      orientation: "h", yref: "container", y: 1, yanchor: "top", ypad: 0, len: 1, thickness: 14, outlinewidth: 0,
      ticks: "outside",
      tickvals: ticks.map(Math.log10), ticktext: ticks.map(String), tickangle: 0,
    },
  });
  for (const [name, dash] of Object.entries(VALIDITY_LINES)) {
    const {limit, onMap} = facts.validity[name];
    const [xs, ys] = boundary(map[name], limit, x, y);
    if (!xs.length) continue;
    traces.push({
      type: "scatter", mode: "lines", x: xs, y: ys, hoverinfo: "skip", line: {color: "#ffffff", dash, width: 2},
    });
    legend.push([line(dash), onMap]);
  }
  const [dimension, load] = [facts.dimensions[picked[0]], loads[picked[1]]];
  traces.push({ // a ring on a wider one
    type: "scatter", mode: "markers", x: [dimension, dimension], y: [load, load], hoverinfo: "skip",
    marker: {symbol: "circle-open", size: 13, color: ["#ffffff", "#d1005d"], line: {width: [5.5, 2.5]}},
  });
  legend.push([ring(), "picked point"]);
  if (values.some((value) => value > high)) legend.push([colour("#fde725"), `${shown(high, 2)} and above`]);
  if (values.some((value) => value < low)) legend.push([colour("#440154"), `${shown(low, 2)} and below`]);
  Plotly.react(place, traces, layout(
    {...AXIS, title: {text: `fractal dimension <i>D</i>${facts.convention}`}, range: [x[0], x.at(-1)]},
    loadAxis(y[0], y.at(-1)),
    {margin: {...MARGIN, t: 44}, annotations: [{
      text: "<i>μ</i><sub>s</sub>", font: {...FONT, size: 15}, showarrow: false,
      xref: "paper", x: 0, xanchor: "right", xshift: -6, yref: "paper", y: 1, yanchor: "middle", yshift: 37,
    }]},
  ), CONFIG);
  legendPlace.replaceChildren(...legend.map(([picture, text]) => element("li", {}, picture, text)));
}

// ---- Curves against load --------------------------------------------------------------------------------------------

const CURVE = "#0b5cad";
const MOST_BAND = 2.5; // times the highest value, of a band on a linear scale
const MOST_BAND_LOG = 100; // times the highest or lowest value, on a logarithmic one
const DECADE = 10; // and at least as much of it, so that a power of ten is among its ticks

/** Points of `frictionAt` or `areaAt` against load, one of them ringed; returns the range that is drawn. */
function drawCurve(place, facts, points, picked, title, wantsLog) {
  const ok = points.filter((point) => point.status === "ok");
  const ends = ok.flatMap((point) => [point.value, point.lower, point.upper]).filter((value) => value > 0);
  const values = ok.map((point) => point.value).filter((value) => value > 0);
  const [least, most] = [Math.min(...values), Math.max(...values)];
  const isLog = wantsLog && values.length > 0;
  let low = 0;
  let high = 1;
  // A band may be cut off, or a wide one would make a flat line of all the rest.
  if (isLog) {
    low = Math.max(Math.min(...ends) / 1.3, least / MOST_BAND_LOG);
    high = Math.min(Math.max(...ends) * 1.3, most * MOST_BAND_LOG);
    const missing = Math.max(1, Math.sqrt((1.01 * DECADE) / (high / low)));
    [low, high] = [low / missing, high * missing];
  } else if (values.length) {
    high = Math.min(1.05 * Math.max(...ends), MOST_BAND * most);
  }
  const axis = isLog ? logAxis(title, low, high) : {...AXIS, title: titled(title), range: [low, high]};
  const nothing = {
    text: "no value in this range of loads", showarrow: false, xref: "paper", yref: "paper", x: 0.5, y: 0.5,
  };
  Plotly.react(place, curveTraces(facts, points, picked, low, high), layout(
    loadAxis(points[0].load, points.at(-1).load), axis, {annotations: ok.length ? [] : [nothing]},
  ), CONFIG);
  return [low, high];
}

function curveTraces(facts, points, picked, low, high) {
  const x = points.map((point) => point.load);
  const put = (name) => points.map((point) => (Number.isFinite(point[name]) ? point[name] : null));
  const band = points.filter((point) => Number.isFinite(point.lower));
  const trusted = points.map((point) => (isTrusted(facts, point) ? point.value : null));
  const ends = (point) => (Number.isFinite(point.lower) ? ` [${shown(point.lower)}, ${shown(point.upper)}]` : "");
  const text = points.map((point) => `${shown(point.value)}${ends(point)}<br>at ${shown(point.load)} mN`);
  const plain = {type: "scatter", hoverinfo: "skip"};
  return [
    {...plain, mode: "lines", line: {width: 0}, fill: "toself", fillcolor: "rgba(11, 92, 173, 0.2)",
      x: [...band.map((point) => point.load), ...band.map((point) => point.load).reverse()],
      y: [...band.map((point) => Math.max(point.lower, low)),
        ...band.map((point) => Math.min(point.upper, high)).reverse()]},
    {...plain, mode: "lines", x, y: put("value"), line: {color: CURVE, width: 2, dash: "dot"}, hoverinfo: "text", text},
    {...plain, mode: "lines", x, y: trusted, line: {color: CURVE, width: 2.5}},
    {...plain, mode: "markers", x: [points[picked].load], y: [points[picked].value],
      marker: {symbol: "circle-open", size: 12, color: "#d1005d", line: {width: 2.5}}},
  ];
}

/** Whether a point has a value that Hertz stands for. */
const isTrusted = (facts, {validity}) => validity?.share_beyond_hertz <= facts.validity.share_beyond_hertz.limit;

// ---- Example profiles ----------------------------------------------------------------------------------------------

const ELASTIC = "#0b5cad";
const OPPOSING = "#b34700";

/** The bodies and contacts of `exampleAt`; returns how many times heights are drawn larger than lengths. */
function drawExample(place, facts, {x, lower, upper, approach, contacts}) {
  const bottom = Math.min(...lower, ...upper);
  const top = Math.max(...upper) + approach;
  const pad = 0.06 * (top - bottom || 1);
  const range = [bottom - pad, top + pad];
  const span = x.at(-1) - x[0] || facts.example.spacing;

  const margin = {...MARGIN, t: 16};
  const width = place.clientWidth - margin.l - margin.r;
  const height = place.clientHeight - margin.t - margin.b;
  const perPixel = [span / width, (range[1] - range[0]) / height]; // µm and nm
  const strongest = Math.max(...contacts.map((contact) => contact.force));

  const plain = {type: "scatter", hoverinfo: "skip", mode: "lines"};
  const flat = (z) => ({...plain, x: [x[0], x.at(-1)], y: [z, z], line: {width: 0}});
  const traces = [
    flat(range[0]),
    {...plain, x, y: lower, line: {color: "#57606a", width: 1.2}, fill: "tonexty", fillcolor: "rgba(87,96,106,0.25)"},
    flat(range[1]),
    {...plain, x, y: upper, line: {color: "#5b3b8c", width: 1.2}, fill: "tonexty", fillcolor: "rgba(91,59,140,0.18)"},
  ];
  for (const [opposes, color, symbol] of [[false, ELASTIC, "circle"], [true, OPPOSING, "diamond"]]) {
    const some = contacts.filter((contact) => contact.opposes === opposes);
    const arrows = {x: [], y: [], size: []};
    const bases = {x: [], y: [], text: []};
    for (const {x: cx, z, normal, force} of some) {
      const length = 14 + 46 * Math.sqrt(force / strongest); // pixels, in the direction that the force has in truth
      const from = [x[0] + cx, 1000 * z];
      arrows.x.push(from[0], from[0] + length * normal * perPixel[0], null);
      arrows.y.push(from[1], from[1] + length * Math.sqrt(1 - normal ** 2) * perPixel[1], null);
      arrows.size.push(0, 11, 0);
      bases.x.push(from[0]);
      bases.y.push(from[1]);
      bases.text.push(`${shown(force, 3)} mN, slope ${shown((Math.asin(-facts.shear * normal) * 180) / Math.PI, 3)}°`);
    }
    traces.push({
      ...plain, mode: "lines+markers", x: arrows.x, y: arrows.y, line: {color, width: 2},
      marker: {color, size: arrows.size, opacity: 1, symbol: "arrow", angleref: "previous"},
    }, {
      ...plain, mode: "markers", x: bases.x, y: bases.y, hoverinfo: "text", text: bases.text,
      marker: {color, size: 10, symbol, opacity: 1, line: {color: "#ffffff", width: 1.5}},
    });
  }
  const label = (text, y, yanchor, color) => ({text, xref: "paper", yref: "paper", x: 0.01, y, xanchor: "left", yanchor,
    showarrow: false, font: {...FONT, color}, bgcolor: "rgba(255, 255, 255, 0.8)"});
  Plotly.react(place, traces, layout(
    {...AXIS, title: {text: "position <i>x</i> (µm)"}, range: [x[0], x.at(-1)]},
    {...AXIS, title: titled("height (nm)"), range},
    {margin, annotations: [
      label(`upper body, about to move ${facts.shear > 0 ? "right →" : "left ←"}`, 0.99, "top", "#4a2f75"),
      label("lower body", 0.01, "bottom", "#3d444d"),
    ]},
  ), CONFIG);
  return perPixel[0] / (perPixel[1] / 1000);
}
