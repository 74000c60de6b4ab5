"use strict";

// What a result says at the mu0 and tau0 of the sliders. Reading off, intervals and statuses are those of
// studies/maps.py and studies/intervals.py, step for step; the names are the same where the things are.

const CONFIDENCE = 0.95;
const STATUS = {
  "ok": "",
  "no-contact": "no pair touches within the approaches",
  "self-locked": "friction locks the contacts: at the largest approach the mean load is zero or below",
  "not-reached": "no approach carries this load",
  "below-range": "the smallest approach carries more than this load",
};
const VALIDITY = [
  ["relative_overlap", "Load-weighted mean of overlap / radius", 1, 0.1],
  ["share_beyond_hertz", "Load on overlaps above a tenth of the radius", 100, 0.5],
  ["share_below_grid", "Load on radii below the grid spacing", 100, 0.5],
  ["share_crossed", "Would-be contacts refused, centres crossed", 100, 0.5],
];
const TICKS = [0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 5, 7, 10, 20, 30, 50, 100];

const facts = JSON.parse(document.getElementById("facts").textContent);
const byId = (id) => document.getElementById(id);

// ---- Numbers of the page --------------------------------------------------------------------------------------------

async function inflated(id) {
  const element = byId(`packed-${id}`);
  const text = atob(element.textContent);
  element.remove();
  const bytes = Uint8Array.from(text, (character) => character.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Doubles from their leading bytes: all first bytes, then all second ones, and so on. */
async function unpacked(id, leading) {
  const planes = await inflated(id);
  const count = planes.length / leading;
  const values = new Float64Array(count);
  const bytes = new Uint8Array(values.buffer);
  for (let plane = 0; plane < leading; plane++)
    for (let i = 0, from = plane * count; i < count; i++) bytes[8 * i + 7 - plane] = planes[from + i];
  return values;
}

/** Arrays of equal length by name. */
function parts(names, values) {
  const size = values.length / names.length;
  return Object.fromEntries(names.map((name, i) => [name, values.subarray(i * size, (i + 1) * size)]));
}

const K = facts.approaches.length;
const R = facts.repetitions;
let means = null; // variable -> (dimension, amplitude, approach)
let sums = null; // variable -> (dimension, amplitude, repetition, approach)
let exampleProfiles = null;
let exampleContacts = null;

// ---- Reading off at a load -----------------------------------------------------------------------------------------

/** First upward crossing of a load by the curve normal[from, from + K): its index, or -1. */
function crossing(normal, from, load) {
  if (normal[from] === load) return 0;
  for (let k = 1; k < K; k++) if (normal[from + k - 1] < load && normal[from + k] >= load) return k;
  return -1;
}

/** Of the step that ends at an index, how much is gone where the load is reached. */
function fractionOf(normal, from, index, load) {
  const before = normal[from + Math.max(index - 1, 0)];
  const step = normal[from + index] - before;
  return step > 0 ? (load - before) / step : 1;
}

function valueAt(values, from, index, fraction) {
  const before = values[from + Math.max(index - 1, 0)];
  return before + fraction * (values[from + index] - before);
}

const OF_AREA = ["contact_area", "", ""];
const OF_NORMAL = ["normal_elastic", "normal_frictional", "normal_adhesive"];
const OF_TANGENTIAL = ["tangential_elastic", "tangential_frictional", "tangential_adhesive"];

/** count numbers from an offset: elastic + mu0 frictional + tau0 adhesive, tau0 in GPa. */
function combined(arrays, [elastic, frictional, adhesive], from, count, mu0, tau0) {
  const part = arrays[elastic].subarray(from, from + count);
  if (!frictional) return part;
  const perMu0 = arrays[frictional].subarray(from, from + count);
  const perTau0 = arrays[adhesive].subarray(from, from + count);
  return part.map((value, i) => value + mu0 * perMu0[i] + tau0 * perTau0[i]);
}

const pairIndex = (d, a) => d * facts.amplitudes.length + a;

/** Mean curves of a dimension and amplitude. */
function meanCurves(d, a, mu0, tau0) {
  const from = pairIndex(d, a) * K;
  const normal = combined(means, OF_NORMAL, from, K, mu0, tau0);
  return {
    from,
    normal,
    tangential: combined(means, OF_TANGENTIAL, from, K, mu0, tau0),
    area: combined(means, OF_AREA, from, K, mu0, tau0),
    touched: facts.touched[d][a],
    locked: facts.touchedAtLast[d][a] && normal[K - 1] <= 0,
  };
}

function statusOf(curves, index, load) {
  if (!curves.touched) return "no-contact";
  if (index >= 0) return "ok";
  if (curves.normal[0] >= load) return "below-range";
  return curves.locked ? "self-locked" : "not-reached";
}

/** Figures of mechanics.contact.Validity where a load is reached. */
function validityAt(curves, index, fraction) {
  const at = (name) => valueAt(means[name], curves.from, index, fraction);
  const load = at("normal_elastic");
  const crossed = at("crossed_count");
  return {
    relative_overlap: at("overlap_load") / load,
    share_beyond_hertz: at("load_beyond_hertz") / load,
    share_below_grid: at("load_below_grid") / load,
    share_crossed: crossed / (crossed + at("contact_count")),
  };
}

// ---- Intervals ------------------------------------------------------------------------------------------------------

const AROUND = 4; // steps on both sides of a crossing over which the slope of a mean is taken

/** Normal loads and values (repetition, approach) of a dimension and amplitude, and their means. */
function jackknife(d, a, what, mu0, tau0) {
  if (!facts.hasIntervals) return null;
  const from = pairIndex(d, a) * R * K;
  const normal = combined(sums, OF_NORMAL, from, R * K, mu0, tau0);
  const values = combined(sums, what, from, R * K, mu0, tau0);
  let carrying = 0;
  for (let r = 0; r < R; r++) if (normal.subarray(r * K, (r + 1) * K).some((load) => load !== 0)) carrying++;
  if (carrying < 2) return null;
  return {
    normal, values, meanNormal: meanOf(normal), meanValues: meanOf(values),
    least: values.some((value) => value < 0) ? -Infinity : 0,
  };
}

function totals(values) {
  const total = new Float64Array(K);
  for (let i = 0; i < values.length; i++) total[i % K] += values[i];
  return total;
}

const meanOf = (values) => totals(values).map((total) => total / R);

/** Of each repetition's number, the mean of the others'. */
function without(each) {
  const total = each.reduce((sum, value) => sum + value, 0);
  return each.map((value) => (total - value) / (R - 1));
}

/** Least-squares slope of mean values against mean normal loads over the steps around an index. */
function slopeAround(jack, index) {
  const first = Math.max(index - 1 - AROUND, 0);
  const last = Math.min(index + AROUND, K - 1) + 1;
  const x = jack.meanNormal.subarray(first, last);
  const y = jack.meanValues.subarray(first, last);
  const middle = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
  const [middleX, middleY] = [middle(x), middle(y)];
  let squares = 0;
  let products = 0;
  for (let i = 0; i < x.length; i++) {
    squares += (x[i] - middleX) ** 2;
    products += (x[i] - middleX) * (y[i] - middleY);
  }
  return squares > 0 ? products / squares : 0;
}

/** Ends of the 95 % interval of a mean that is read off at a load, where the mean load reaches it. */
function interval(jack, mean, load) {
  if (jack === null) return [NaN, NaN];
  const index = crossing(jack.meanNormal, 0, load);
  if (index < 0) return [NaN, NaN];
  const fraction = fractionOf(jack.meanNormal, 0, index, load);
  const slope = slopeAround(jack, index);
  const repetitions = Array.from({length: R}, (_, r) => r);
  const loads = repetitions.map((r) => valueAt(jack.normal, r * K, index, fraction));
  const values = repetitions.map((r) => valueAt(jack.values, r * K, index, fraction));
  const othersLoad = without(loads).map((other) => other / load);
  if (othersLoad.some((other) => other <= 0)) return [NaN, NaN];
  const logarithms = without(values).map(
    (other, r) => Math.log(other / mean) - ((slope * load) / mean) * Math.log(othersLoad[r]));
  if (logarithms.every(Number.isFinite)) {
    const half = halfWidth(logarithms);
    return [mean * Math.exp(-half), mean * Math.exp(half)];
  }
  const half = halfWidth(without(values.map((value, r) => value - slope * loads[r]))); // no logarithm
  return [Math.max(mean - half, jack.least), mean + half];
}

/** Half the interval of a mean from its leave-one-out values. */
function halfWidth(values) {
  const centre = values.reduce((total, value) => total + value, 0) / R;
  let squares = 0;
  let fourths = 0;
  for (const value of values) {
    const power = (value - centre) ** 2;
    squares += power;
    fourths += power ** 2;
  }
  const kurtosis = squares > 0 ? (R * fourths) / squares ** 2 : 3;
  const freedom = Math.min(Math.max((2 * R) / Math.max(kurtosis - 1, 1e-9), 1), R - 1);
  return studentQuantile(0.5 + CONFIDENCE / 2, freedom) * Math.sqrt(((R - 1) / R) * squares);
}

/** Quantile of Student's t above the median, for any degrees of freedom from 1 on. */
function studentQuantile(probability, freedom) {
  // The distribution is concave above 0, so Newton's steps from the left never pass the quantile.
  const scale = Math.exp(logGamma((freedom + 1) / 2) - logGamma(freedom / 2)) / Math.sqrt(freedom * Math.PI);
  let t = 0;
  for (let step = 0; step < 200; step++) {
    const tail = incompleteBeta(freedom / (freedom + t * t), freedom / 2, 0.5) / 2;
    const density = scale * (1 + (t * t) / freedom) ** (-(freedom + 1) / 2);
    const change = (tail - (1 - probability)) / density;
    t += change;
    if (Math.abs(change) <= 1e-14 * t) break;
  }
  return t;
}

/** Regularised incomplete beta function I_x(a, b); DLMF 8.17.22 by the algorithm of Lentz. */
function incompleteBeta(x, a, b) {
  if (x <= 0 || x >= 1) return x <= 0 ? 0 : 1;
  if (x > (a + 1) / (a + b + 2)) return 1 - incompleteBeta(1 - x, b, a);
  const front = Math.exp(logGamma(a + b) - logGamma(a) - logGamma(b) + a * Math.log(x) + b * Math.log1p(-x)) / a;
  const tiny = 1e-300;
  let c = 1;
  let d = 1 / (1 - ((a + b) * x) / (a + 1) || tiny);
  let value = d;
  for (let m = 1; m < 10_000; m++) {
    let ratio = 1;
    for (const term of [
      (m * (b - m) * x) / ((a + 2 * m - 1) * (a + 2 * m)),
      (-(a + m) * (a + b + m) * x) / ((a + 2 * m) * (a + 2 * m + 1)),
    ]) {
      d = 1 / (1 + term * d || tiny);
      c = 1 + term / c || tiny;
      ratio = d * c;
      value *= ratio;
    }
    if (Math.abs(ratio - 1) < 1e-15) break;
  }
  return front * value;
}

/** Logarithm of the gamma function above 0: Stirling's series (DLMF 5.11.1) where it is exact, and recurrence below. */
function logGamma(x) {
  let shift = 0;
  for (; x < 12; x++) shift += Math.log(x);
  const u = 1 / (x * x);
  const series = (1 / 12 - u * (1 / 360 - u * (1 / 1260 - u * (1 / 1680 - u * (1 / 1188 - u * 691 / 360360))))) / x;
  return (x - 0.5) * Math.log(x) - x + Math.log(2 * Math.PI) / 2 + series - shift;
}

// ---- The map and the curves as numbers -----------------------------------------------------------------------------

function geometric(low, high, count) {
  // Five digits, so that a load is what it says.
  return Array.from({length: count}, (_, i) => Number((low * (high / low) ** (i / (count - 1))).toPrecision(5)));
}

function edges(centres) {
  if (centres.length === 1) return [centres[0] - 0.05, centres[0] + 0.05];
  const middles = centres.slice(1).map((centre, i) => (centre + centres[i]) / 2);
  return [2 * centres[0] - middles[0], ...middles, 2 * centres.at(-1) - middles.at(-1)];
}

/** Value, status and shares beyond validity over (load, dimension). */
function frictionMap(a, loads, mu0, tau0) {
  const grid = () => loads.map(() => new Array(facts.dimensions.length).fill(null));
  const map = {value: grid(), status: grid(), share_beyond_hertz: grid(), share_below_grid: grid()};
  facts.dimensions.forEach((_, d) => {
    const curves = meanCurves(d, a, mu0, tau0);
    loads.forEach((load, l) => {
      const index = crossing(curves.normal, 0, load);
      map.status[l][d] = statusOf(curves, index, load);
      if (index < 0) return;
      const fraction = fractionOf(curves.normal, 0, index, load);
      map.value[l][d] = valueAt(curves.tangential, 0, index, fraction) / load;
      const validity = validityAt(curves, index, fraction);
      map.share_beyond_hertz[l][d] = validity.share_beyond_hertz;
      map.share_below_grid[l][d] = validity.share_below_grid;
    });
  });
  return map;
}

/** What is known at a load: value, interval, status and validity; of the area, or of the friction coefficient. */
function readOff(curves, values, jack, load, divisor) {
  const index = crossing(curves.normal, 0, load);
  const status = statusOf(curves, index, load);
  if (index < 0) return {load, status, value: NaN, lower: NaN, upper: NaN, validity: null};
  const fraction = fractionOf(curves.normal, 0, index, load);
  const value = valueAt(values, 0, index, fraction);
  const [lower, upper] = interval(jack, value, load);
  return {
    load, status, value: value / divisor, lower: lower / divisor, upper: upper / divisor,
    validity: validityAt(curves, index, fraction),
  };
}

function frictionAt(d, a, load, mu0, tau0) {
  const curves = meanCurves(d, a, mu0, tau0);
  return readOff(curves, curves.tangential, jackknife(d, a, OF_TANGENTIAL, mu0, tau0), load, load);
}

/** Range of colours: the highest few per cent share one, or friction at the highest D would take them all. */
function colourRange(maps) {
  const values = maps.flatMap((map) => map.value.flat()).filter((value) => value > 0).sort((x, y) => x - y);
  if (!values.length) return [0.1, 1];
  const quantile = (share) => values[Math.round(share * (values.length - 1))];
  const low = Number(quantile(0.01).toPrecision(2));
  return [low, Math.max(Number(quantile(0.95).toPrecision(2)), Number((1.05 * low).toPrecision(3)))];
}

// ---- State ----------------------------------------------------------------------------------------------------------

const middle = (list) => list[Math.floor(list.length / 2)];
const state = {
  mu0: middle(facts.mu0),
  tau0: facts.tau0[0], // MPa
  amplitude: 0,
  dimension: Math.floor(facts.dimensions.length / 2),
  load: Math.floor(facts.loadSteps / 2),
  example: 0,
  range: facts.loads,
  colours: null,
  pointed: null, // (dimension, load) under the pointer
};
let loads = [];
const tau0 = () => state.tau0 / 1000; // GPa

// What is drawn, by the id of its place on the page.
const drawings = {
  map: drawMap,
  readout: drawReadout,
  friction: () => drawCurve("friction"),
  area: () => drawCurve("area"),
  profiles: drawExample,
};
const FRICTION = ["map", "readout", "friction", "area"];
const REST = 150; // ms without a change, after which what nobody sees is drawn as well
const wanted = new Set();
let frame = 0;
let rest = 0;

function redraw(...places) {
  if (!facts.loads.length) places = places.filter((place) => !FRICTION.includes(place));
  places.forEach((place) => wanted.add(place));
  cancelAnimationFrame(frame);
  frame = requestAnimationFrame(drawSeen);
}

function drawSeen() {
  drawSome((place) => {
    const {top, bottom} = byId(place).getBoundingClientRect();
    return top < innerHeight && bottom > 0;
  });
  clearTimeout(rest);
  rest = setTimeout(drawSome, REST, () => true);
}

function drawSome(isChosen) {
  for (const place of [...wanted].filter(isChosen)) {
    drawings[place]();
    wanted.delete(place);
  }
}

// ---- Words and figures ----------------------------------------------------------------------------------------------

const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";

/** A number for people. */
function shown(value, digits = 4) {
  if (!Number.isFinite(value)) return "–";
  if (value !== 0 && (Math.abs(value) < 1e-4 || Math.abs(value) >= 1e5)) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
    const power = [...String(Math.abs(Number(exponent)))].map((digit) => SUPERSCRIPTS[digit]).join("");
    return `${mantissa.replace("-", "−")} × 10${exponent.startsWith("-") ? "⁻" : ""}${power}`;
  }
  return value.toPrecision(digits).replace("-", "−");
}

const CONVENTION = facts.classical ? " (classical)" : "";
const dimensionName = (d) => `D = ${facts.dimensions[d].toFixed(3)}`;

/** A length, µm, in the unit that suits it. */
function lengthName(value) {
  const [size, unit] = value < 1 ? [1000 * value, "nm"] : [value, "µm"];
  return `${Number(size.toPrecision(4))} ${unit}`;
}

/** An element with attributes and children; text is never markup. */
function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

// A number that people see shortened, and programs in full.
const data = (value, text) => element("data", {value: String(value)}, text);

function drawReadout() {
  const [d, l] = state.pointed ?? [state.dimension, state.load];
  const at = frictionAt(d, state.amplitude, loads[l], state.mu0, tau0());
  const readout = byId("readout");
  Object.assign(readout.dataset, {
    dimension: facts.dimensions[d], load: at.load, mu0: state.mu0, tau0: tau0(), status: at.status,
    value: at.value, lower: at.lower, upper: at.upper,
  });
  const children = [
    element("p", {class: "hint"}, `${state.pointed ? "Under the pointer" : "Picked"}: ${dimensionName(d)}, F`,
      element("sub", {}, "N"), ` = ${shown(at.load)} mN`),
  ];
  if (at.status === "ok") {
    children.push(
      element("p", {class: "value"}, element("i", {}, "μ"), element("sub", {}, "s"), " = ",
        data(at.value, shown(at.value))),
      element("p", {class: "interval"}, ...intervalText(at)),
    );
  } else {
    children.push(element("p", {class: "value"}, at.status), element("p", {class: "interval"}, STATUS[at.status]));
  }
  const list = element("dl", {}, element("dt", {}, "Status"), element("dd", {class: "status"}, at.status));
  for (const [name, label, factor, limit] of at.validity ? VALIDITY : []) {
    const value = at.validity[name];
    const text = factor === 1 ? shown(value, 2) : `${(factor * value).toFixed(0)} %`;
    const beyond = value > limit;
    list.append(
      element("dt", {}, label),
      element("dd", beyond ? {class: "beyond"} : {}, beyond ? "⚠ " : "", data(value, text)),
    );
  }
  const figures = [list];
  if (at.status === "ok") {
    const inFull = (value) => (Number.isFinite(value) ? value.toPrecision(9) : "none");
    const full = [at.value, at.lower, at.upper].map(inFull);
    figures.push(element("p", {class: "full"},
      `In full: ${full[0]} [${full[1]}, ${full[2]}] at D = ${facts.dimensions[d]}, ${at.load} mN, ` +
      `μ0 = ${state.mu0}, τ0 = ${state.tau0} MPa`));
  }
  byId("answer").replaceChildren(...children);
  byId("figures").replaceChildren(...figures);
}

function intervalText(at) {
  if (Number.isFinite(at.lower)) {
    return ["95 % interval [", data(at.lower, shown(at.lower)), ", ", data(at.upper, shown(at.upper)), "]"];
  }
  return [`No interval: ${whyNoInterval()}`];
}

function whyNoInterval() {
  if (R === 1) return "there is one repetition";
  if (!facts.hasIntervals) return "there are too many repetitions for a page; the library has it";
  return "fewer than two repetitions carry load";
}

// ---- Plots ----------------------------------------------------------------------------------------------------------

const FONT = {family: getComputedStyle(document.body).fontFamily, size: 13, color: "#1b1f24"};
const MARGIN = {l: 72, r: 16, t: 8, b: 48};
const CONFIG = {displayModeBar: false, responsive: true, scrollZoom: false, doubleClick: false};
const AXIS = {
  ticks: "outside", ticklen: 5, tickcolor: "#57606a", linecolor: "#57606a", linewidth: 1, mirror: true,
  showline: true, zeroline: false, gridcolor: "#e6eaee", fixedrange: true, tickangle: 0, exponentformat: "power", minexponent: 4,
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

// Fill patterns of the map and of its legend. The first is the map's background, which costs nothing to draw.
const BACKGROUND = "not-reached";
const MARKS = {
  "not-reached": {shape: "/", fgcolor: "#8c959f", bgcolor: "#ffffff", text: "load not reached"},
  "below-range": {shape: "\\", fgcolor: "#57606a", bgcolor: "#e6eaee", text: "below the loads computed"},
  "no-contact": {shape: ".", fgcolor: "#57606a", bgcolor: "#ffffff", text: "no contact"},
  "self-locked": {shape: "", fgcolor: "#7a0019", bgcolor: "#7a0019", text: "self-locked: no load is carried"},
};
const VALIDITY_LINES = [
  ["share_beyond_hertz", "solid", "above: over half of the load on overlaps > radius / 10"],
  ["share_below_grid", "2px,2px", "below: over half of the load on radii < grid spacing"],
];

/** Round numbers on the scale of colours, no closer than their labels are long. */
function colourTicks(low, high, width) {
  const place = (tick) => (width * Math.log(tick / low)) / Math.log(high / low);
  let last = -Infinity;
  return TICKS.filter((tick) => {
    const isFree = tick >= low * 0.999 && tick <= high * 1.001 && place(tick) - last >= 36;
    if (isFree) last = place(tick);
    return isFree;
  });
}

/** Outlines, one after the other, of the cells of a status: of each column's runs. */
function outlines(status, name, x, y) {
  const xs = [];
  const ys = [];
  for (let d = 0; d + 1 < x.length; d++) {
    for (let l = 0; l < status.length; l++) {
      if (status[l][d] !== name) continue;
      const first = l;
      while (l + 1 < status.length && status[l + 1][d] === name) l++;
      xs.push(x[d], x[d + 1], x[d + 1], x[d], x[d], null);
      ys.push(y[first], y[first], y[l + 1], y[l + 1], y[first], null);
    }
  }
  return [xs, ys];
}

/** Edges between the cells that have a share above a half and those that have not. */
function boundary(shares, x, y) {
  const xs = [];
  const ys = [];
  const isKnown = (share) => typeof share === "number";
  const differ = (one, other) => isKnown(one) && isKnown(other) && one > 0.5 !== other > 0.5;
  shares.forEach((row, l) => row.forEach((share, d) => {
    if (differ(share, row[d + 1])) {
      xs.push(x[d + 1], x[d + 1], null);
      ys.push(y[l], y[l + 1], null);
    }
    if (differ(share, shares[l + 1]?.[d])) {
      xs.push(x[d], x[d + 1], null);
      ys.push(y[l + 1], y[l + 1], null);
    }
  }));
  return [xs, ys];
}

function drawMap() {
  const map = frictionMap(state.amplitude, loads, state.mu0, tau0());
  const x = edges(facts.dimensions);
  const y = edges(loads.map(Math.log)).map(Math.exp);
  const [low, high] = state.colours;
  const ticks = colourTicks(low, high, byId("map").clientWidth - MARGIN.l - MARGIN.r);
  const traces = [];
  const legend = [];
  for (const [name, mark] of Object.entries(MARKS)) {
    const [xs, ys] = outlines(map.status, name, x, y);
    if (!xs.length) continue;
    legend.push([swatch(mark), mark.text]);
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
  for (const [name, dash, text] of VALIDITY_LINES) {
    const [xs, ys] = boundary(map[name], x, y);
    if (!xs.length) continue;
    traces.push({
      type: "scatter", mode: "lines", x: xs, y: ys, hoverinfo: "skip", line: {color: "#ffffff", dash, width: 2},
    });
    legend.push([line(dash), text]);
  }
  const [dimension, load] = [facts.dimensions[state.dimension], loads[state.load]];
  traces.push({ // a ring on a wider one
    type: "scatter", mode: "markers", x: [dimension, dimension], y: [load, load], hoverinfo: "skip",
    marker: {symbol: "circle-open", size: 13, color: ["#ffffff", "#d1005d"], line: {width: [5.5, 2.5]}},
  });
  legend.push([ring(), "picked point"]);
  if (values.some((value) => value > high)) legend.push([colour("#fde725"), `${shown(high, 2)} and above`]);
  if (values.some((value) => value < low)) legend.push([colour("#440154"), `${shown(low, 2)} and below`]);
  Plotly.react("map", traces, layout(
    {...AXIS, title: {text: `fractal dimension <i>D</i>${CONVENTION}`}, range: [x[0], x.at(-1)]},
    loadAxis(y[0], y.at(-1)),
    {margin: {...MARGIN, t: 44}, annotations: [{
      text: "<i>μ</i><sub>s</sub>", font: {...FONT, size: 15}, showarrow: false,
      xref: "paper", x: 0, xanchor: "right", xshift: -6, yref: "paper", y: 1, yanchor: "middle", yshift: 37,
    }]},
  ), CONFIG);
  byId("legend").replaceChildren(...legend.map(([picture, text]) => element("li", {}, picture, text)));
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

const CURVE = "#0b5cad";
const MOST_BAND = 2.5; // times the highest value, of a band on a linear scale
const MOST_BAND_LOG = 100; // times the highest or lowest value, on a logarithmic one
const DECADE = 10; // and at least as much of it, so that a power of ten is among its ticks

function drawCurve(id) {
  const {dimension: d, amplitude: a, mu0} = state;
  const curves = meanCurves(d, a, mu0, tau0());
  const [what, curve, title] = {
    friction: [OF_TANGENTIAL, curves.tangential, "friction coefficient <i>μ</i><sub>s</sub>"],
    area: [OF_AREA, curves.area, "true contact area <i>A</i> (µm²)"],
  }[id];
  const jack = jackknife(d, a, what, mu0, tau0());
  const points = loads.map((load) => readOff(curves, curve, jack, load, id === "friction" ? load : 1));
  const ok = points.filter((point) => point.status === "ok");
  const ends = ok.flatMap((point) => [point.value, point.lower, point.upper]).filter((value) => value > 0);
  const values = ok.map((point) => point.value).filter((value) => value > 0);
  const [least, most] = [Math.min(...values), Math.max(...values)];
  const isLog = id === "area" && values.length > 0;
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
  Plotly.react(id, curveTraces(points, low, high), layout(
    loadAxis(loads[0], loads.at(-1)), axis, {annotations: ok.length ? [] : [nothing]},
  ), CONFIG);
  byId(`${id}-caption`).textContent = curveCaption(points, ok, low, high);
}

function curveTraces(points, low, high) {
  const x = points.map((point) => point.load);
  const put = (name) => points.map((point) => (Number.isFinite(point[name]) ? point[name] : null));
  const band = points.filter((point) => Number.isFinite(point.lower));
  const trusted = points.map((point) => (point.validity?.share_beyond_hertz <= 0.5 ? point.value : null));
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
    {...plain, mode: "markers", x: [loads[state.load]], y: [points[state.load].value],
      marker: {symbol: "circle-open", size: 12, color: "#d1005d", line: {width: 2.5}}},
  ];
}

function curveCaption(points, ok, low, high) {
  const amplitude = lengthName(facts.amplitudes[state.amplitude]);
  const words = [
    `At ${dimensionName(state.dimension)}, amplitude ${amplitude}, μ0 = ${state.mu0}, τ0 = ${state.tau0} MPa.`,
  ];
  if (ok.length && ok.every((point) => Number.isFinite(point.lower))) {
    words.push("Shaded: 95 % interval.");
    const cut = [];
    if (ok.some((point) => point.upper > high)) cut.push("above");
    if (ok.some((point) => point.lower < low)) cut.push("below");
    if (cut.length) words.push(`It is cut off ${cut.join(" and ")}; pointing at the curve tells its ends.`);
  }
  else if (ok.length) words.push(`No interval: ${whyNoInterval()}.`);
  if (ok.some((point) => point.validity.share_beyond_hertz > 0.5))
    words.push("Dotted: over half of the load on overlaps above a tenth of the radius.");
  const counts = new Map();
  for (const point of points) if (point.status !== "ok") counts.set(point.status, (counts.get(point.status) ?? 0) + 1);
  for (const [status, count] of counts)
    words.push(`No value at ${count} of ${points.length} loads (${status}): ${STATUS[status]}.`);
  return words.join(" ");
}

// ---- Example profiles ----------------------------------------------------------------------------------------------

const ELASTIC = "#0b5cad";
const OPPOSING = "#b34700";

/** Which of some indices is nearest to one. */
function nearest(indices, index) {
  const distances = indices.map((each) => Math.abs(each - index));
  return distances.indexOf(Math.min(...distances));
}

function exampleContactsOf(d, a, k) {
  const {amplitudes, approaches, counts} = facts.example;
  const at = (d * amplitudes.length + a) * approaches.length + k;
  const total = exampleContacts.length / 4;
  const first = counts.slice(0, at).reduce((sum, count) => sum + count, 0);
  return Array.from({length: counts[at]}, (_, i) => {
    const [x, z, normal, force] = [0, 1, 2, 3].map((row) => exampleContacts[row * total + first + i]);
    return {x, z, normal, force, opposes: facts.shear * normal < 0};
  }).concat({leftOut: facts.example.leftOut[at]});
}

function drawExample() {
  const {dimensions, amplitudes, approaches, starts, spacing, points} = facts.example;
  const [d, a, k] = [nearest(dimensions, state.dimension), nearest(amplitudes, state.amplitude), state.example];
  const approach = 1000 * facts.approaches[approaches[k]];
  const factor = (1000 * facts.amplitudes[amplitudes[a]]) / facts.amplitudes[amplitudes[0]];
  const x = Array.from({length: points}, (_, i) => starts[d] + i * spacing);
  const body = (side) => {
    const first = (2 * d + side) * points;
    return Array.from(exampleProfiles.subarray(first, first + points), (z) => factor * z);
  };
  const lower = body(0);
  const upper = body(1).map((z) => z - approach);
  const bottom = Math.min(...lower, ...upper);
  const top = Math.max(...upper) + approach;
  const pad = 0.06 * (top - bottom || 1);
  const range = [bottom - pad, top + pad];
  const span = x.at(-1) - x[0] || spacing;

  const plot = byId("profiles");
  const margin = {...MARGIN, t: 16};
  const width = plot.clientWidth - margin.l - margin.r;
  const height = plot.clientHeight - margin.t - margin.b;
  const perPixel = [span / width, (range[1] - range[0]) / height]; // µm and nm
  const found = exampleContactsOf(d, a, k);
  const {leftOut} = found.pop();
  const strongest = Math.max(...found.map((contact) => contact.force));

  const plain = {type: "scatter", hoverinfo: "skip", mode: "lines"};
  const flat = (z) => ({...plain, x: [x[0], x.at(-1)], y: [z, z], line: {width: 0}});
  const traces = [
    flat(range[0]),
    {...plain, x, y: lower, line: {color: "#57606a", width: 1.2}, fill: "tonexty", fillcolor: "rgba(87,96,106,0.25)"},
    flat(range[1]),
    {...plain, x, y: upper, line: {color: "#5b3b8c", width: 1.2}, fill: "tonexty", fillcolor: "rgba(91,59,140,0.18)"},
  ];
  for (const [opposes, color, symbol] of [[false, ELASTIC, "circle"], [true, OPPOSING, "diamond"]]) {
    const some = found.filter((contact) => contact.opposes === opposes);
    const arrows = {x: [], y: [], size: []};
    const bases = {x: [], y: [], text: []};
    for (const {x: cx, z, normal, force} of some) {
      const length = 14 + 46 * Math.sqrt(force / strongest); // pixels, in the direction that the force has in truth
      const from = [starts[d] + cx, 1000 * z];
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
  const exaggeration = perPixel[0] / (perPixel[1] / 1000);
  const label = (text, y, yanchor, color) => ({text, xref: "paper", yref: "paper", x: 0.01, y, xanchor: "left", yanchor,
    showarrow: false, font: {...FONT, color}, bgcolor: "rgba(255, 255, 255, 0.8)"});
  Plotly.react(plot, traces, layout(
    {...AXIS, title: {text: "position <i>x</i> (µm)"}, range: [x[0], x.at(-1)]},
    {...AXIS, title: titled("height (nm)"), range},
    {margin, annotations: [
      label(`upper body, about to move ${facts.shear > 0 ? "right →" : "left ←"}`, 0.99, "top", "#4a2f75"),
      label("lower body", 0.01, "bottom", "#3d444d"),
    ]},
  ), CONFIG);

  const words = [
    `The first pair at ${dimensionName(dimensions[d])}, amplitude ${lengthName(facts.amplitudes[amplitudes[a]])}:`,
    `${points} points of it around where the two first touch. Vertical exaggeration: ${shown(exaggeration, 2)}.`,
  ];
  const opposing = found.filter((contact) => contact.opposes).length;
  const count = found.length + leftOut;
  if (count) {
    words.push(
      `${count} ${count === 1 ? "contact" : "contacts"} here at this approach; diamonds are on slopes that oppose`,
      `the motion (${opposing}), circles are not (${found.length - opposing}). Arrows: the normal force on the upper`,
      `body, in its true direction; lengths go with its square root, and the strongest is ${shown(strongest, 3)} mN.`,
    );
  } else words.push("No contacts here at this approach.");
  if (leftOut) words.push(`The ${leftOut} weakest are not drawn.`);
  byId("profiles-caption").textContent = words.join(" ");
}

// ---- Controls -------------------------------------------------------------------------------------------------------

/** A slider and a number that mean the same; the number takes any value from 0 on. */
function friction(id, most, step) {
  const [slider, number] = [byId(id), byId(`${id}-number`)];
  Object.assign(slider, {min: 0, max: most, step});
  slider.value = number.value = state[id];
  slider.addEventListener("input", () => {
    number.value = slider.value;
    byId(`${id}-wrong`).hidden = true;
    state[id] = Number(slider.value);
    changed();
  });
  number.addEventListener("input", () => {
    byId(`${id}-wrong`).hidden = number.validity.valid;
    if (!number.validity.valid) return;
    state[id] = Number(number.value);
    slider.value = number.value;
    changed();
  });
  const changed = () => {
    sayIfStrong();
    redraw(...FRICTION);
  };
}

function sayIfStrong() {
  const isStrong = state.tau0 > facts.tau0Sane;
  byId("strong").hidden = !isStrong;
  byId("strong").textContent = `τ0 is above a tenth of the effective modulus, ${shown(facts.tau0Sane, 3)} MPa.`;
}

/** A slider over the indices of a list. */
function index(id, key, count, name, ...changes) {
  const slider = byId(id);
  slider.max = count - 1;
  slider.value = state[key];
  slider.disabled = count < 2;
  const show = () => {
    byId(`${id}-text`).textContent = name(state[key]);
    slider.setAttribute("aria-valuetext", name(state[key]));
  };
  slider.addEventListener("input", () => {
    state[key] = Number(slider.value);
    state.pointed = null;
    show();
    redraw(...changes);
  });
  return {show, set: (value) => { slider.value = state[key] = value; show(); }};
}

const NARROWEST = 1.01; // of a range: the loads in it are told apart by five digits

/** Two numbers, the lower and the higher end of a range. */
function range(id, taken) {
  const [low, high, wrong] = ["low", "high", "wrong"].map((part) => byId(`${id}-${part}`));
  const setWrong = (isWrong) => {
    wrong.hidden = !isWrong;
    for (const each of [low, high]) each.setCustomValidity(isWrong ? wrong.textContent : "");
  };
  for (const end of [low, high]) {
    end.addEventListener("input", () => {
      const ends = [Number(low.value), Number(high.value)];
      const ordered = ends[0] > 0 && ends[1] >= NARROWEST * ends[0] && ends.every(Number.isFinite);
      setWrong(!ordered);
      if (ordered) taken(ends);
    });
  }
  return (ends) => {
    [low.value, high.value] = ends.map((end) => (end < 1e-3 ? end.toExponential() : end));
    setWrong(false);
    taken(ends);
  };
}

function connect() {
  for (const form of document.forms) form.addEventListener("submit", (event) => event.preventDefault());
  friction("mu0", facts.mu0Most, 0.01);
  friction("tau0", facts.tau0Most, Number((facts.tau0Most / 200).toPrecision(1)));
  byId("convention").textContent = CONVENTION;

  const amplitude = byId("amplitude");
  amplitude.append(...facts.amplitudes.map((value, a) => element("option", {value: a}, lengthName(value))));
  byId("amplitude-label").textContent = `Amplitude (${facts.measure === "height" ? "total height" : facts.measure})`;
  amplitude.disabled = facts.amplitudes.length < 2;
  amplitude.addEventListener("change", () => {
    state.amplitude = Number(amplitude.value);
    redraw(...FRICTION, "profiles");
  });

  const dimension = index("dimension", "dimension", facts.dimensions.length, dimensionName, ...FRICTION, "profiles");
  const load = index("load", "load", facts.loadSteps, (l) => `${shown(loads[l])} mN`, ...FRICTION);
  const {approaches} = facts.example;
  state.example = Math.floor((2 * approaches.length) / 3);
  const approachName = (k) => lengthName(facts.approaches[approaches[k]]);
  const approach = index("approach", "example", approaches.length, approachName, "profiles");
  [dimension, approach].forEach((slider) => slider.show());
  window.addEventListener("resize", () => redraw("map", "profiles"));
  if (!facts.loads.length) return;

  const setLoads = range("load", (ends) => {
    state.range = ends;
    loads = geometric(...ends, facts.loadSteps);
    load.show();
    redraw(...FRICTION);
  });
  const setColours = range("colour", (ends) => {
    state.colours = ends;
    redraw("map");
  });
  setLoads(facts.loads);
  setColours(colourRange(facts.mu0.flatMap((m) => facts.tau0.flatMap(
    (t) => facts.amplitudes.map((_, a) => frictionMap(a, loads, m, t / 1000))))));
  byId("all-loads").addEventListener("click", () => setLoads(facts.loads));
  byId("fit-colours").addEventListener("click", () => {
    setColours(colourRange([frictionMap(state.amplitude, loads, state.mu0, tau0())]));
  });

  drawMap(); // which makes it something that says what is pointed at
  const map = byId("map");
  const cell = (event) => {
    const [l, d] = event.points.find((point) => point.data.type === "heatmap")?.pointIndex ?? [];
    return d === undefined ? null : [d, l];
  };
  map.on("plotly_hover", (event) => {
    state.pointed = cell(event);
    redraw("readout");
  });
  map.on("plotly_unhover", () => {
    state.pointed = null;
    redraw("readout");
  });
  map.on("plotly_click", (event) => {
    const [d, l] = cell(event) ?? [state.dimension, state.load];
    state.pointed = null; // a finger that taps never leaves
    dimension.set(d);
    load.set(l);
    redraw(...FRICTION, "profiles");
  });
}

// ---- Beginning ------------------------------------------------------------------------------------------------------

function say(text) {
  byId("trouble").hidden = false;
  byId("trouble").textContent = text;
}

async function begin() {
  if (typeof DecompressionStream === "undefined") return say("This page needs a browser of 2023 or later.");
  const library = document.createElement("script");
  library.textContent = new TextDecoder().decode(await inflated("plotly"));
  document.head.append(library);
  means = parts(facts.variables, await unpacked("means", 8));
  sums = parts(facts.perRepetition, await unpacked("sums", 5));
  exampleProfiles = await unpacked("profiles", 3);
  exampleContacts = await unpacked("contacts", 3);
  if (!facts.loads.length) {
    say("No pair of this study touches within its approaches: there is no load, no area and no friction to show.");
    for (const id of ["map", "friction", "area"]) byId(id).closest("section").hidden = true;
    byId("controls").hidden = true;
  } else if (K === 1) {
    say("This study has one approach. Values at a load are read off between two, so there are none to show.");
  }
  connect();
  redraw(...FRICTION, "profiles");
  drawSome(() => true);
  byId("main").setAttribute("aria-busy", "false");
}

begin().catch((error) => say(`This page could not be drawn: ${error.message}`));
