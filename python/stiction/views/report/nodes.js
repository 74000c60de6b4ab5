"use strict";

// Results between nodes of mu0 and tau0: the library evaluated the nodes, and these functions unpack and interpolate.
// Nothing here looks at the page.

/** Doubles from their leading bytes: all first bytes, then all second ones, and so on. */
function doubles(planes, leading) {
  const count = planes.length / leading;
  const values = new Float64Array(count);
  const bytes = new Uint8Array(values.buffer);
  for (let plane = 0; plane < leading; plane++)
    for (let i = 0, from = plane * count; i < count; i++) bytes[8 * i + 7 - plane] = planes[from + i];
  return values;
}

// ---- Interpolation -------------------------------------------------------------------------------------------------

const ROUND_OFF = 1e-9; // distance over the length of an axis up to which a value is that of a node

/** Nodes with their weights at a value of an axis {rising, bounds}: itself, or two neighbours and up to four; the panel
 * has the index of the first neighbour. */
function weightsAt({rising, bounds}, value) {
  const last = rising.length - 1;
  const alone = (index) => ({panel: index === last ? last - 1 : index, isNode: true, linear: [[index, 1]], cubic: [[index, 1]]});
  const ranged = bounds.findIndex(([low, high]) => low <= value && value <= high);
  if (ranged >= 0) return alone(rising.length + ranged);
  const near = rising.findIndex((node) => Math.abs(node - value) <= ROUND_OFF * rising[last]);
  if (near >= 0) return alone(near);
  const panel = Math.min(Math.max(rising.findLastIndex((node) => node <= value), 0), last - 1);
  const over = (first, count) => Array.from({length: count}, (_, i) => [first + i, rising.slice(first, first + count)
    .reduce((weight, node, k) => (k === i ? weight : (weight * (value - node)) / (rising[first + i] - node)), 1)]);
  const linear = over(panel, 2);
  return {panel, isNode: false, linear, cubic: last < 3 ? linear : over(Math.min(Math.max(panel - 1, 0), last - 3), 4)};
}

/** Where mu0 and tau0 lie between the nodes. */
function placeAt({mu0, tau0}, valueOfMu0, valueOfTau0) {
  const [m, t] = [weightsAt(mu0, valueOfMu0), weightsAt(tau0, valueOfTau0)];
  const columns = tau0.rising.length + tau0.bounds.length;
  const both = (kind) => m[kind].flatMap(([i, w]) => t[kind].map(([j, v]) => [i * columns + j, w * v]));
  const linear = both("linear").sort(([, one], [, other]) => other - one);
  return {size: (mu0.rising.length + mu0.bounds.length) * columns, cubic: both("cubic"), linear,
    panel: m.panel * columns + t.panel, isNode: m.isNode && t.isNode};
}

const weighted = (table, first, weights) => weights.reduce((sum, [node, weight]) => sum + weight * table[first + node], 0);

/** A table at a place: by cubics, or bilinear where one of 16 nodes has no value. */
function between(table, first, {cubic, linear}) {
  const value = weighted(table, first, cubic);
  return Number.isFinite(value) ? value : weighted(table, first, linear);
}

/** The entry of the nearest node. */
const atNearest = (table, first, {linear}) => table[first + linear[0][0]];

/** Number of the status at a place: that of the nearest node, unless others around it have no value. */
function statusAt(table, first, {linear}, statuses) {
  const [nearest, ...others] = linear.map(([node]) => table[first + node]);
  if (!statuses[nearest].isOk) return nearest;
  return others.find((code) => !statuses[code].isOk) ?? nearest;
}

const NO_INTERVAL = -128; // decimals of an upper end that is not printed

/** A value and its interval at a place from the tables of a name; an interval without an upper end at a node around it has
 * none there. */
function pointAt({offsets, floats, small}, name, index, place) {
  const first = index * place.size;
  const of = (part) => between(floats, offsets[`${name}_${part}`] + first, place);
  const decimals = (part) => atNearest(small, offsets[`${name}_${part}`] + first, place);
  const isOpen = place.linear.some(([node]) => floats[offsets[`${name}_upper`] + first + node] === Infinity);
  return {value: of("value"), lower: of("lower"), upper: isOpen ? Infinity : of("upper"),
    decimals: decimals("decimals"), upperDecimals: decimals("upper_decimals")};
}

// ---- Numbers as text ------------------------------------------------------------------------------------------------

/** A number with so many decimals, or rounded to tens, without the minus of a zero. */
function inDecimals(value, digits) {
  const text = digits >= 0 ? value.toFixed(Math.min(digits, 100)) : String(Math.round(value / 10 ** -digits) * 10 ** -digits);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−");
}

/** Both ends of an interval in their decimals; empty where the library prints none. */
function endsOf({lower, upper, decimals, upperDecimals}) {
  if (upperDecimals === NO_INTERVAL || Number.isNaN(lower) || Number.isNaN(upper)) return "";
  return `[${inDecimals(lower, decimals)}, ${upper === Infinity ? "∞)" : `${inDecimals(upper, upperDecimals)}]`}`;
}

/** A value with its interval in the decimals of the library. */
function quoted(point) {
  if (!Number.isFinite(point.value)) return "none";
  return [inDecimals(point.value, point.decimals), endsOf(point)].filter(Boolean).join(" ");
}

/** Text with a number {factor, decimals, unit} in place of {}. */
const filled = (text, number, value) => (number
  ? text.replace("{}", `${inDecimals(number.factor * value, number.decimals)}${number.unit}`) : text);
