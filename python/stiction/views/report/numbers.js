"use strict";

// What a result says at a load, for any mu0 and tau0. Reading off, intervals and statuses are those of `friction_map`
// and `area_map`, step for step; the names are the same where the things are.
//
// All that these functions know is in their arguments: nothing here looks at the page. A result is
// {facts, means, sums}: what Python says of it, the means over the repetitions, variable -> (dimension, amplitude,
// approach), and the sums of each, variable -> (dimension, amplitude, repetition, approach).

// ---- Numbers as they are packed ------------------------------------------------------------------------------------

/** Doubles from their leading bytes: all first bytes, then all second ones, and so on. */
function doubles(planes, leading) {
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

// ---- Reading off at a load -----------------------------------------------------------------------------------------

/** First upward crossing of a load by the curve normal[from, from + count): its index, or -1. */
function crossing(normal, from, count, load) {
  if (normal[from] === load) return 0;
  for (let k = 1; k < count; k++) if (normal[from + k - 1] < load && normal[from + k] >= load) return k;
  return -1;
}

/** Share of the step that ends at an index that is done where the load is reached. */
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

/** elastic + mu0 frictional + tau0 adhesive, tau0 in GPa, of as many numbers from an offset on as count says. */
function combined(arrays, [elastic, frictional, adhesive], from, count, mu0, tau0) {
  const part = arrays[elastic].subarray(from, from + count);
  if (!frictional) return part;
  const perMu0 = arrays[frictional].subarray(from, from + count);
  const perTau0 = arrays[adhesive].subarray(from, from + count);
  return part.map((value, i) => value + mu0 * perMu0[i] + tau0 * perTau0[i]);
}

const pairIndex = ({amplitudes}, d, a) => d * amplitudes.length + a;

/** Mean curves of a dimension and amplitude. */
function meanCurves({facts, means}, d, a, mu0, tau0) {
  const count = facts.approaches.length;
  const from = pairIndex(facts, d, a) * count;
  const normal = combined(means, OF_NORMAL, from, count, mu0, tau0);
  return {
    from,
    normal,
    tangential: combined(means, OF_TANGENTIAL, from, count, mu0, tau0),
    area: combined(means, OF_AREA, from, count, mu0, tau0),
    touched: facts.touched[d][a],
    locked: facts.touchedAtLast[d][a] && normal[count - 1] <= 0,
  };
}

function statusOf(curves, index, load) {
  if (!curves.touched) return "no-contact";
  if (index >= 0) return "ok";
  if (curves.normal[0] >= load) return "below-range";
  return curves.locked ? "self-locked" : "not-reached";
}

/** The figures of `Validity` where a load is reached. */
function validityAt({means}, curves, index, fraction) {
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

/** Normal loads and values (repetition, approach) of a dimension and amplitude, and their leave-one-out means. */
function jackknife({facts, sums}, d, a, what, mu0, tau0) {
  if (!facts.hasIntervals) return null;
  const [repetitions, count] = [facts.repetitions, facts.approaches.length];
  const size = repetitions * count;
  const from = pairIndex(facts, d, a) * size;
  const normal = combined(sums, OF_NORMAL, from, size, mu0, tau0);
  const values = combined(sums, what, from, size, mu0, tau0);
  let carrying = 0;
  for (let r = 0; r < repetitions; r++)
    if (normal.subarray(r * count, (r + 1) * count).some((load) => load !== 0)) carrying++;
  if (carrying < 2) return null;
  const [meanNormal, meanValues] = [normal, values].map(
    (each) => totals(each, count).map((total) => total / repetitions));
  return {
    repetitions, count, confidence: facts.confidence, around: facts.stepsAround, normal, values, meanNormal, meanValues,
    least: values.some((value) => value < 0) ? -Infinity : 0,
  };
}

/** Sums over the repetitions of values (repetition, approach). */
function totals(values, count) {
  const total = new Float64Array(count);
  for (let i = 0; i < values.length; i++) total[i % count] += values[i];
  return total;
}

/** Of each repetition's number, the mean of the others'. */
function without(each) {
  const total = each.reduce((sum, value) => sum + value, 0);
  return each.map((value) => (total - value) / (each.length - 1));
}

/** Least-squares slope of mean values against mean normal loads over the steps around an index. */
function slopeAround({meanNormal, meanValues, around, count}, index) {
  const first = Math.max(index - 1 - around, 0);
  const last = Math.min(index + around, count - 1) + 1;
  const [x, y] = [meanNormal.subarray(first, last), meanValues.subarray(first, last)];
  const [middleX, middleY] = [x, y].map((values) => values.reduce((sum, value) => sum + value, 0) / values.length);
  let squares = 0;
  let products = 0;
  for (let i = 0; i < x.length; i++) {
    squares += (x[i] - middleX) ** 2;
    products += (x[i] - middleX) * (y[i] - middleY);
  }
  return squares > 0 ? products / squares : 0;
}

/** Ends of the interval of a mean that is read off at a load, where the mean load reaches it. */
function interval(jack, mean, load) {
  if (jack === null) return [NaN, NaN];
  const {repetitions, count, meanNormal, confidence} = jack;
  const index = crossing(meanNormal, 0, count, load);
  if (index < 0) return [NaN, NaN];
  const fraction = fractionOf(meanNormal, 0, index, load);
  const slope = slopeAround(jack, index);
  const [loads, values] = [jack.normal, jack.values].map(
    (each) => Array.from({length: repetitions}, (_, r) => valueAt(each, r * count, index, fraction)));
  const othersLoad = without(loads).map((other) => other / load);
  if (othersLoad.some((other) => other <= 0)) return [NaN, NaN];
  const logarithms = without(values).map(
    (other, r) => Math.log(other / mean) - ((slope * load) / mean) * Math.log(othersLoad[r]));
  if (logarithms.every(Number.isFinite)) {
    const half = halfWidth(logarithms, confidence);
    return [mean * Math.exp(-half), mean * Math.exp(half)];
  }
  // What is not positive has no logarithm.
  const half = halfWidth(without(values.map((value, r) => value - slope * loads[r])), confidence);
  return [Math.max(mean - half, jack.least), mean + half];
}

/** Half the interval of a mean from its leave-one-out values. */
function halfWidth(values, confidence) {
  const repetitions = values.length;
  const centre = values.reduce((total, value) => total + value, 0) / repetitions;
  let squares = 0;
  let fourths = 0;
  for (const value of values) {
    const power = (value - centre) ** 2;
    squares += power;
    fourths += power ** 2;
  }
  const kurtosis = squares > 0 ? (repetitions * fourths) / squares ** 2 : 3;
  const freedom = Math.min(Math.max((2 * repetitions) / Math.max(kurtosis - 1, 1e-9), 1), repetitions - 1);
  return studentQuantile(0.5 + confidence / 2, freedom) * Math.sqrt(((repetitions - 1) / repetitions) * squares);
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
function frictionMap(result, a, loads, mu0, tau0) {
  const {dimensions, approaches} = result.facts;
  const grid = () => loads.map(() => new Array(dimensions.length).fill(null));
  const map = {value: grid(), status: grid(), share_beyond_hertz: grid(), share_below_grid: grid()};
  dimensions.forEach((_, d) => {
    const curves = meanCurves(result, d, a, mu0, tau0);
    loads.forEach((load, l) => {
      const index = crossing(curves.normal, 0, approaches.length, load);
      map.status[l][d] = statusOf(curves, index, load);
      if (index < 0) return;
      const fraction = fractionOf(curves.normal, 0, index, load);
      map.value[l][d] = valueAt(curves.tangential, 0, index, fraction) / load;
      const validity = validityAt(result, curves, index, fraction);
      map.share_beyond_hertz[l][d] = validity.share_beyond_hertz;
      map.share_below_grid[l][d] = validity.share_below_grid;
    });
  });
  return map;
}

/** What is known at a load: value, interval, status and validity; of the area, or of the friction coefficient. */
function readOff(result, curves, values, jack, load, divisor) {
  const index = crossing(curves.normal, 0, curves.normal.length, load);
  const status = statusOf(curves, index, load);
  if (index < 0) return {load, status, value: NaN, lower: NaN, upper: NaN, validity: null};
  const fraction = fractionOf(curves.normal, 0, index, load);
  const value = valueAt(values, 0, index, fraction);
  const [lower, upper] = interval(jack, value, load);
  return {
    load, status, value: value / divisor, lower: lower / divisor, upper: upper / divisor,
    validity: validityAt(result, curves, index, fraction),
  };
}

/** The friction coefficient at loads. */
function frictionAt(result, d, a, loads, mu0, tau0) {
  const curves = meanCurves(result, d, a, mu0, tau0);
  const jack = jackknife(result, d, a, OF_TANGENTIAL, mu0, tau0);
  return loads.map((load) => readOff(result, curves, curves.tangential, jack, load, load));
}

/** The true contact area at loads, µm². */
function areaAt(result, d, a, loads, mu0, tau0) {
  const curves = meanCurves(result, d, a, mu0, tau0);
  const jack = jackknife(result, d, a, OF_AREA, mu0, tau0);
  return loads.map((load) => readOff(result, curves, curves.area, jack, load, 1));
}

/** Range of colours: the highest few per cent share one, or friction at the highest D would take them all. */
function colourRange({colourQuantiles}, maps) {
  const values = maps.flatMap((map) => map.value.flat()).filter((value) => value > 0).sort((x, y) => x - y);
  if (!values.length) return [0.1, 1];
  const [lowest, highest] = colourQuantiles.map((share) => values[Math.round(share * (values.length - 1))]);
  const low = Number(lowest.toPrecision(2));
  return [low, Math.max(Number(highest.toPrecision(2)), Number((1.05 * low).toPrecision(3)))];
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

/** Edges between the cells that have a share above a limit and those that have not. */
function boundary(shares, limit, x, y) {
  const xs = [];
  const ys = [];
  const isKnown = (share) => typeof share === "number";
  const differ = (one, other) => isKnown(one) && isKnown(other) && one > limit !== other > limit;
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

// ---- Example profiles ----------------------------------------------------------------------------------------------

/** Position in a list of indices of the one that is nearest to an index. */
function nearest(indices, index) {
  const distances = indices.map((each) => Math.abs(each - index));
  return distances.indexOf(Math.min(...distances));
}

/** The contacts drawn of an example, from their packed rows, and how many are left out. */
function exampleContactsOf({example, shear}, packed, d, a, k) {
  const {amplitudes, approaches, counts, leftOut} = example;
  const at = (d * amplitudes.length + a) * approaches.length + k;
  const total = packed.length / 4;
  const first = counts.slice(0, at).reduce((sum, count) => sum + count, 0);
  const contacts = Array.from({length: counts[at]}, (_, i) => {
    const [x, z, normal, force] = [0, 1, 2, 3].map((row) => packed[row * total + first + i]);
    return {x, z, normal, force, opposes: shear * normal < 0};
  });
  return {contacts, leftOut: leftOut[at]};
}

/** The example nearest to a dimension, amplitude and approach: x in µm, heights and approach in nm, and contacts. */
function exampleAt(facts, profiles, contacts, dimension, amplitude, k) {
  const {dimensions, amplitudes, approaches, starts, spacing, points} = facts.example;
  const [d, a] = [nearest(dimensions, dimension), nearest(amplitudes, amplitude)];
  const approach = 1000 * facts.approaches[approaches[k]];
  const factor = (1000 * facts.amplitudes[amplitudes[a]]) / facts.amplitudes[amplitudes[0]];
  const body = (side) => {
    const first = (2 * d + side) * points;
    return Array.from(profiles.subarray(first, first + points), (z) => factor * z);
  };
  return {
    dimension: dimensions[d], amplitude: amplitudes[a], approach,
    x: Array.from({length: points}, (_, i) => starts[d] + i * spacing),
    lower: body(0), upper: body(1).map((z) => z - approach),
    ...exampleContactsOf(facts, contacts, d, a, k),
  };
}

// ---- Numbers as text ------------------------------------------------------------------------------------------------

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

/** A length, µm, in the unit that suits it. */
function lengthName(value) {
  const [size, unit] = value < 1 ? [1000 * value, "nm"] : [value, "µm"];
  return `${Number(size.toPrecision(4))} ${unit}`;
}
