"use strict";

// Unpack and print the numbers that the library computed for all mu0 and tau0 on the page.
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

// ---- Values at one mu0 and tau0 --------------------------------------------------------------------------------------

/** Return the place of a pair of mu0 and tau0 in the tables: the number of pairs, and the index of this pair. */
function placeAt({mu0, tau0}, valueOfMu0, valueOfTau0) {
  const columns = tau0.values.length;
  return {size: mu0.values.length * columns, node: mu0.values.indexOf(valueOfMu0) * columns + tau0.values.indexOf(valueOfTau0)};
}

const NO_INTERVAL = -128; // code for an interval that is not printed
const EXPONENT = -127; // code for an upper limit that is printed with one digit and an exponent, as in 5e+09

/** Return a value and its interval at a place, and their format if the quantity has a unit. */
function pointAt({offsets, formats, floats, small}, name, index, {size, node}) {
  const entry = (table, part) => table[offsets[`${name}_${part}`] + index * size + node];
  return {value: entry(floats, "value"), lower: entry(floats, "lower"), upper: entry(floats, "upper"),
    decimals: entry(small, "decimals"), upperDecimals: entry(small, "upper_decimals"), format: formats[name]?.[entry(small, "format")]};
}

/** Return a number without an interval at a place, and its format. */
function numberAt({offsets, formats, floats, small}, name, index, {size, node}) {
  const entry = (table, part) => table[offsets[`${name}_${part}`] + index * size + node];
  return {value: entry(floats, "value"), format: formats[name][entry(small, "format")]};
}

/** Return the assessment and the caveats at a place, with their numbers. */
function judgementAt(numbers, judgements, index, place) {
  const {assessment, caveats} = judgements[numbers.floats[numbers.offsets.judgement + index * place.size + place.node]];
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

/** Format a coefficient and its interval. If the softer body shears, the coefficient is a lower limit. */
const coefficientText = (point) => `${point.status === "ok" ? "" : "≥ "}${quoted(point)}`;

/** Format a number {value, format} without an interval. The library chooses the format {factor, digits, text}. */
const printed = ({value, format: {factor, digits, text}}) =>
  text.replace("{}", String(Number((value / factor).toPrecision(digits))).replace("-", "−"));
