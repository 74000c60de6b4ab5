"use strict";

// Interpolation of values in mu0 and tau0. The library computed the values at nodes; this script unpacks them.
// These functions do not access the document.

/** Decode doubles from their leading bytes. All first bytes are stored first, then all second bytes, and so on. */
function doubles(planes, leading) {
  const count = planes.length / leading;
  const values = new Float64Array(count);
  const bytes = new Uint8Array(values.buffer);
  for (let plane = 0; plane < leading; plane++)
    for (let i = 0, from = plane * count; i < count; i++) bytes[8 * i + 7 - plane] = planes[from + i];
  return values;
}

// ---- Interpolation -------------------------------------------------------------------------------------------------

// A value is treated as a node if its distance from the node is below this fraction of the axis length.
const ROUND_OFF = 1e-9;

/** Return node indices with weights for interpolation at a value on an axis {rising, bounds}.
 * If a node equals the value, the list has only this node.
 * Otherwise, `linear` has two neighbours and `cubic` has up to four neighbours.
 * `panel` is the index of the first neighbour. */
function weightsAt({rising, bounds}, value) {
  const last = rising.length - 1;
  const single = (index) => ({panel: index === last ? last - 1 : index, isNode: true, linear: [[index, 1]], cubic: [[index, 1]]});
  const ranged = bounds.findIndex(([low, high]) => low <= value && value <= high);
  if (ranged >= 0) return single(rising.length + ranged);
  const near = rising.findIndex((node) => Math.abs(node - value) <= ROUND_OFF * rising[last]);
  if (near >= 0) return single(near);
  const panel = Math.min(Math.max(rising.findLastIndex((node) => node <= value), 0), last - 1);
  const over = (first, count) => Array.from({length: count}, (_, i) => [first + i, rising.slice(first, first + count)
    .reduce((weight, node, k) => (k === i ? weight : (weight * (value - node)) / (rising[first + i] - node)), 1)]);
  const linear = over(panel, 2);
  return {panel, isNode: false, linear, cubic: last < 3 ? linear : over(Math.min(Math.max(panel - 1, 0), last - 3), 4)};
}

/** Return the weights of the nodes around a given pair of mu0 and tau0. */
function placeAt({mu0, tau0}, valueOfMu0, valueOfTau0) {
  const [m, t] = [weightsAt(mu0, valueOfMu0), weightsAt(tau0, valueOfTau0)];
  const columns = tau0.rising.length + tau0.bounds.length;
  const both = (kind) => m[kind].flatMap(([i, w]) => t[kind].map(([j, v]) => [i * columns + j, w * v]));
  const linear = both("linear").sort(([, first], [, second]) => second - first);
  return {size: (mu0.rising.length + mu0.bounds.length) * columns, cubic: both("cubic"), linear,
    panel: m.panel * columns + t.panel, isNode: m.isNode && t.isNode};
}

const weighted = (table, first, weights) => weights.reduce((sum, [node, weight]) => sum + weight * table[first + node], 0);

/** Interpolate a table at a place by cubic polynomials. If one of the 16 nodes has no value, interpolate bilinearly. */
function between(table, first, {cubic, linear}) {
  const value = weighted(table, first, cubic);
  return Number.isFinite(value) ? value : weighted(table, first, linear);
}

/** Return the table entry at the node nearest to a place. */
const atNearest = (table, first, {linear}) => table[first + linear[0][0]];

/** Return the status code at a place. It is the code of the nearest node, unless a neighbouring node has no value. */
function statusAt(table, first, {linear}, statuses) {
  const [nearest, ...others] = linear.map(([node]) => table[first + node]);
  if (!statuses[nearest].isOk) return nearest;
  return others.find((code) => !statuses[code].isOk) ?? nearest;
}

const NO_INTERVAL = -128; // code of an interval that is not printed
const EXPONENT = -127; // code of an upper end that is printed with one digit and an exponent, as in 5e+09

/** Return a value and its interval at a place, and the format of the nearest node if the quantity has a unit.
 * The interval is unbounded if it is unbounded at a neighbouring node. */
function pointAt({offsets, formats, floats, small}, name, index, place) {
  const first = index * place.size;
  const interpolated = (part) => between(floats, offsets[`${name}_${part}`] + first, place);
  const nearest = (part) => atNearest(small, offsets[`${name}_${part}`] + first, place);
  const isOpen = place.linear.some(([node]) => floats[offsets[`${name}_upper`] + first + node] === Infinity);
  return {value: interpolated("value"), lower: interpolated("lower"), upper: isOpen ? Infinity : interpolated("upper"),
    decimals: nearest("decimals"), upperDecimals: nearest("upper_decimals"), format: formats[name]?.[nearest("format")]};
}

/** Return a number without an interval at a place, and the format of the nearest node.
 * The number is that of the nearest node if another neighbour has no number. */
function numberAt({offsets, formats, floats, small}, name, index, place) {
  const nearest = (table, part) => atNearest(table, offsets[`${name}_${part}`] + index * place.size, place);
  const value = between(floats, offsets[`${name}_value`] + index * place.size, place);
  return {value: Number.isFinite(value) ? value : nearest(floats, "value"), format: formats[name][nearest(small, "format")]};
}

/** Return the assessment and the caveats at the node nearest to a place. Numbers in caveats are interpolated. */
function judgementAt(numbers, judgements, index, place) {
  const {assessment, caveats} = judgements[atNearest(numbers.floats, numbers.offsets.judgement + index * place.size, place)];
  const filled = ({text, number}) => (number ? text.replace("{}", printed(numberAt(numbers, number, index, place))) : text);
  return {assessment, caveats: caveats.map((caveat) => ({...caveat, text: filled(caveat)}))};
}

// ---- Numbers as text ------------------------------------------------------------------------------------------------

/** Format a number with decimals, or rounded to tens, without a minus sign for zero. */
function inDecimals(value, digits) {
  const text = digits >= 0 ? value.toFixed(Math.min(digits, 100)) : String(Math.round(value / 10 ** -digits) * 10 ** -digits);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−");
}

/** Format both ends of an interval. The text is empty if the library prints no interval. */
function formatEnds({lower, upper, decimals, upperDecimals}) {
  if (upperDecimals === NO_INTERVAL || Number.isNaN(lower) || Number.isNaN(upper)) return "";
  const withExponent = () => upper.toExponential(0).replace(/([+-])(\d)$/, (_, sign, digit) => `${sign}0${digit}`);
  const bounded = () => `${upperDecimals === EXPONENT ? withExponent() : inDecimals(upper, upperDecimals)}]`;
  return `[${inDecimals(lower, decimals)}, ${upper === Infinity ? "∞)" : bounded()}`;
}

/** Format a value and its interval with the same decimals and the same unit as the library. */
function quoted({value, lower, upper, decimals, upperDecimals, format: {factor, text} = {factor: 1, text: "{}"}}) {
  if (!Number.isFinite(value)) return "none";
  const ends = formatEnds({lower: lower / factor, upper: upper / factor, decimals, upperDecimals});
  return text.replace("{}", [inDecimals(value / factor, decimals), ends].filter(Boolean).join(" "));
}

/** Format a number {value, format} without an interval. The library chooses the format {factor, digits, text} of a node. */
const printed = ({value, format: {factor, digits, text}}) =>
  text.replace("{}", String(Number((value / factor).toPrecision(digits))).replace("-", "−"));
