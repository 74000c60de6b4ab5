"use strict";

// What a result says at a load, for any mu0 and tau0. Reading off, intervals and statuses are those of `friction_map`
// and `area_map`, step for step; the names are the same where the things are.
//
// All that these functions know is in their arguments: nothing here looks at the page. A result, for one sliding rule and
// direction, is {facts, means, sums}: what Python says of it, the means over the repetitions, variable -> (dimension,
// amplitude, step), and the sums of each, variable -> (dimension, amplitude, repetition, step). Steps are approaches, or
// loads of the half-space.

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

/** Arrays of equal length by name, for each motion: those that have nothing to do with it, then its own. */
function parts({plain, directed}, motions, values) {
  const size = values.length / (plain.length + motions * directed.length) || 0;
  const some = (names, first) => Object.fromEntries(
    names.map((name, i) => [name, values.subarray((first + i) * size, (first + i + 1) * size)]));
  const shared = some(plain, 0);
  return Array.from({length: motions}, (_, m) => ({...shared, ...some(directed, plain.length + m * directed.length)}));
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
const OF_STIFFNESS = ["stiffness_elastic", "stiffness_frictional", "stiffness_adhesive"];
const QUANTITIES = {friction: OF_TANGENTIAL, area: OF_AREA, stiffness: OF_STIFFNESS};

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
  const count = facts.steps.length;
  const from = pairIndex(facts, d, a) * count;
  const normal = combined(means, OF_NORMAL, from, count, mu0, tau0);
  return {
    from,
    normal,
    of: (quantity) => combined(means, QUANTITIES[quantity], from, count, mu0, tau0),
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

/** The figures of validity where a load is reached: each a sum over the sum of others. */
function validityAt({facts, means}, curves, index, fraction) {
  const at = (name) => valueAt(means[name], curves.from, index, fraction);
  return Object.fromEntries(Object.entries(facts.validity).map(([name, {of, over}]) =>
    [name, over.length ? at(of) / over.reduce((sum, each) => sum + at(each), 0) : at(of)]));
}

/** Whether a value stands where the model is meant for: no share that is drawn is above its limit. */
function isTrusted(facts, validity) {
  return Object.entries(facts.validity).every(([name, {limit, isDrawn}]) => !(isDrawn && validity[name] > limit));
}

// ---- Intervals ------------------------------------------------------------------------------------------------------

/** Normal loads and values (repetition, approach) of a dimension and amplitude, and their leave-one-out means. */
function jackknife({facts, sums}, d, a, quantity, mu0, tau0) {
  if (!facts.hasIntervals) return null;
  const [repetitions, count] = [facts.repetitions, facts.steps.length];
  const size = repetitions * count;
  const from = pairIndex(facts, d, a) * size;
  const normal = combined(sums, OF_NORMAL, from, size, mu0, tau0);
  const values = quantity === "stiffness"
    ? stiffnessOf(facts, sums, normal, from)
    : combined(sums, QUANTITIES[quantity], from, size, mu0, tau0);
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

/** Normal stiffness of normal loads (repetition, step): along the approach, or that of the half-space, whose steps are
 * loads, along each pair's own. */
function stiffnessOf({steps}, {compliance}, normal, from) {
  const values = new Float64Array(normal.length);
  for (let r = 0; r < normal.length; r += steps.length)
    values.set(gradient(normal.subarray(r, r + steps.length), steps), r);
  return compliance ? values.map((value, i) => value / compliance[from + i]) : values;
}

/** Derivative of values along steps by the parabola through a point and its neighbours. */
function gradient(values, steps) {
  const last = values.length - 1;
  return values.map((_, i) => {
    const m = Math.min(Math.max(i, 1), last - 1);
    const [before, after] = [steps[m] - steps[m - 1], steps[m + 1] - steps[m]];
    const [left, right] = [(values[m] - values[m - 1]) / before, (values[m + 1] - values[m]) / after];
    const bend = (right - left) / (before + after);
    return left + bend * (2 * steps[i] - steps[m] - steps[m - 1]);
  });
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
    return [mean * Math.exp(-half), mean * Math.exp(half)].sort((one, other) => one - other);
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

/** Value, status and whether it is trusted, and sound by every figure of validity, over (load, dimension): of a quantity,
 * or of the width of the interval of friction. */
function mapOf(result, quantity, a, loads, mu0, tau0) {
  const {dimensions, steps} = result.facts;
  const grid = () => loads.map(() => new Array(dimensions.length).fill(null));
  const map = {value: grid(), status: grid(), trusted: grid(), isSound: grid()};
  const isWidth = quantity === "width";
  const of = isWidth ? "friction" : quantity;
  dimensions.forEach((_, d) => {
    const curves = meanCurves(result, d, a, mu0, tau0);
    const values = curves.of(of);
    const jack = isWidth ? jackknife(result, d, a, of, mu0, tau0) : null;
    loads.forEach((load, l) => {
      const index = crossing(curves.normal, 0, steps.length, load);
      map.status[l][d] = statusOf(curves, index, load);
      if (index < 0) return;
      const fraction = fractionOf(curves.normal, 0, index, load);
      const value = valueAt(values, 0, index, fraction);
      map.value[l][d] = value / (of === "friction" ? load : 1);
      if (isWidth) {
        const [lower, upper] = interval(jack, value, load);
        const width = (upper - lower) / (2 * Math.abs(value));
        map.value[l][d] = Number.isFinite(width) ? width : null;
      }
      const validity = validityAt(result, curves, index, fraction);
      map.trusted[l][d] = isTrusted(result.facts, validity);
      map.isSound[l][d] = Object.entries(result.facts.validity).every(([name, {limit}]) => !(validity[name] > limit));
    });
  });
  return map;
}

/** What is known of a quantity at loads: value, interval, status and validity. */
function readOff(result, quantity, d, a, loads, mu0, tau0) {
  const curves = meanCurves(result, d, a, mu0, tau0);
  const values = curves.of(quantity);
  const jack = jackknife(result, d, a, quantity, mu0, tau0);
  return loads.map((load) => {
    const index = crossing(curves.normal, 0, curves.normal.length, load);
    const status = statusOf(curves, index, load);
    if (index < 0) return {load, status, value: NaN, lower: NaN, upper: NaN, validity: null, trusted: false};
    const fraction = fractionOf(curves.normal, 0, index, load);
    const value = valueAt(values, 0, index, fraction);
    const [lower, upper] = interval(jack, value, load);
    const divisor = quantity === "friction" ? load : 1;
    const validity = validityAt(result, curves, index, fraction);
    return {
      load, status, value: value / divisor, lower: lower / divisor, upper: upper / divisor, validity,
      trusted: isTrusted(result.facts, validity),
    };
  });
}

/** A quantity at a load at every dimension. */
function overDimensions(result, quantity, a, load, mu0, tau0) {
  return result.facts.dimensions.map((dimension, d) => ({
    dimension, ...readOff(result, quantity, d, a, [load], mu0, tau0)[0],
  }));
}

/** Where to begin: the sound cell (d, l) of a map that is nearest to its middle, or the middle. */
function beginning(map) {
  const [rows, columns] = [map.value.length, map.value[0].length];
  let best = [Math.floor(columns / 2), Math.floor(rows / 2)];
  let least = Infinity;
  map.isSound.forEach((row, l) => row.forEach((isSound, d) => {
    const distance = ((l + 0.5) / rows - 0.5) ** 2 + ((d + 0.5) / columns - 0.5) ** 2;
    if (isSound && distance < least) [best, least] = [[d, l], distance];
  }));
  return best;
}

/** Range of colours: the highest few per cent share one, or friction at the highest D would take them all. */
function colourRange({colourQuantiles}, maps) {
  const values = maps.flatMap((map) => map.value.flat()).filter((value) => value > 0).sort((x, y) => x - y);
  if (!values.length) return [0.1, 1];
  const [lowest, highest] = colourQuantiles.map((share) => values[Math.round(share * (values.length - 1))]);
  const low = Number(lowest.toPrecision(2));
  return [low, Math.max(Number(highest.toPrecision(2)), Number((1.05 * low).toPrecision(3)))];
}

/** Edges [x, y, x, y] between the cells that are true and those that are false; others have none. */
function boundary(cells, x, y) {
  const lines = [];
  const differ = (one, other) => typeof one === "boolean" && typeof other === "boolean" && one !== other;
  cells.forEach((row, l) => row.forEach((cell, d) => {
    if (differ(cell, row[d + 1])) lines.push([x[d + 1], y[l], x[d + 1], y[l + 1]]);
    if (differ(cell, cells[l + 1]?.[d])) lines.push([x[d], y[l + 1], x[d + 1], y[l + 1]]);
  }));
  return lines;
}

/** Round numbers of an axis, with texts; on a logarithmic one also those without. */
function ticksOf(low, high, isLog, most) {
  if (!(high > low)) return [{value: low, text: tickText(low)}];
  if (isLog && high / low > 4) {
    const first = Math.ceil(Math.log10(low) - 1e-9); // and the digits of the decade before it
    const decades = Array.from({length: Math.ceil(Math.log10(high)) - first + 2}, (_, i) => first - 1 + i);
    const named = high / low > 200 ? [1] : high / low > 20 ? [1, 3] : [1, 2, 3, 5];
    const every = Math.max(1, Math.ceil((Math.log10(high / low) * named.length) / most));
    return decades.flatMap((decade) => [1, 2, 3, 4, 5, 6, 7, 8, 9].map((digit) => {
      const value = Number(`${digit}e${decade}`);
      const isNamed = named.includes(digit) && (decade - first) % every === 0;
      return {value, text: isNamed ? tickText(value) : ""};
    })).filter(({value}) => value >= low * (1 - 1e-9) && value <= high * (1 + 1e-9));
  }
  const rough = (high - low) / most;
  const unit = 10 ** Math.floor(Math.log10(rough));
  const step = unit * [1, 2, 5, 10].find((factor) => factor * unit >= rough * (1 - 1e-9));
  const start = Math.ceil(low / step - 1e-9);
  return Array.from({length: Math.floor(high / step + 1e-9) - start + 1}, (_, i) => {
    const value = Number(((start + i) * step).toPrecision(12));
    return {value, text: tickText(value)};
  });
}

function tickText(value) {
  const size = Math.abs(value);
  if (value === 0 || (size >= 1e-3 && size < 1e5)) return String(value).replace("-", "−");
  const [mantissa, exponent] = value.toExponential().split("e");
  return `${mantissa === "1" ? "" : `${mantissa.replace("-", "−")} × `}10${superscript(Number(exponent))}`;
}

// ---- Measured surfaces ---------------------------------------------------------------------------------------------

/** Mean of a sample, without what is not finite, and its interval by Student's t; as `intervals.of_sample`. */
function ofSample(values, confidence, fewest) {
  const known = values.filter(Number.isFinite);
  const count = known.length;
  const mean = known.reduce((sum, value) => sum + value, 0) / count;
  if (count < fewest) return [mean, NaN, NaN];
  const squares = known.reduce((sum, value) => sum + (value - mean) ** 2, 0);
  const half = studentQuantile(0.5 + confidence / 2, count - 1) * Math.sqrt(squares / (count - 1) / count);
  const least = known.some((value) => value < 0) ? -Infinity : 0;
  return [mean, Math.max(mean - half, least), mean + half];
}

/** The friction coefficient of the sums of normal and tangential load: elastic, per mu0 and per tau0 of each. */
function coefficientOf([normal, normalMu0, normalTau0, tangential, tangentialMu0, tangentialTau0], mu0, tau0) {
  const load = normal + mu0 * normalMu0 + tau0 * normalTau0;
  return load > 0 ? (tangential + mu0 * tangentialMu0 + tau0 * tangentialTau0) / load : NaN;
}

/** The friction coefficient by the slope of the gap alone; as `gentle_friction`. */
function gentleFriction(mu0, tau0, {gradient, slope, modulus, kappa}, sliding) {
  const m = mu0 + (kappa * tau0) / (modulus * gradient);
  const mean = slope / (2 * Math.sqrt(2 * Math.PI));
  if (sliding === "all") return m;
  return m * mean < 1 ? (m / 2 + mean) / (1 - m * mean) : NaN;
}

// ---- Example profiles ----------------------------------------------------------------------------------------------

/** Position in a list of indices of the one that is nearest to an index. */
function nearest(indices, index) {
  const distances = indices.map((each) => Math.abs(each - index));
  return distances.indexOf(Math.min(...distances));
}

/** The contacts drawn of an example, from their packed rows, and how many are left out. */
function exampleContactsOf({amplitudes, approaches, counts, leftOut}, packed, e, a, k, shear) {
  const at = (e * amplitudes.length + a) * approaches.length + k;
  const total = packed.length / 4;
  const first = counts.slice(0, at).reduce((sum, count) => sum + count, 0);
  const contacts = Array.from({length: counts[at]}, (_, i) => {
    const [x, z, normal, force] = [0, 1, 2, 3].map((row) => packed[row * total + first + i]);
    return {x, z, normal, force, opposes: shear * normal < 0};
  });
  return {contacts, leftOut: leftOut[at]};
}

/** A pair near to a dimension, amplitude and approach: x in µm, heights and approach in nm, and contacts. The upper body
 * moves to the right where shear is 1, to the left where it is -1. */
function exampleAt(facts, profiles, contacts, {pair, dimension, amplitude, step, shear}) {
  const {dimensions, amplitudes, approaches, starts, spacing, points} = facts.example;
  const [d, a] = [nearest(dimensions, dimension), nearest(amplitudes, amplitude)];
  const e = pair * dimensions.length + d;
  const approach = 1000 * facts.steps[approaches[step]];
  const factor = (1000 * facts.amplitudes[amplitudes[a]]) / facts.amplitudes[amplitudes[0]];
  const body = (side) => {
    const first = (2 * e + side) * points;
    return Array.from(profiles.subarray(first, first + points), (z) => factor * z);
  };
  return {
    dimension: dimensions[d], amplitude: amplitudes[a], approach,
    x: Array.from({length: points}, (_, i) => starts[e] + i * spacing),
    lower: body(0), upper: body(1).map((z) => z - approach),
    ...exampleContactsOf(facts.example, contacts, e, a, step, shear),
  };
}

// ---- Numbers as text ------------------------------------------------------------------------------------------------

const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";

function superscript(exponent) {
  const digits = [...String(Math.abs(exponent))].map((digit) => SUPERSCRIPTS[digit]).join("");
  return (exponent < 0 ? "⁻" : "") + digits;
}

/** A number for people. */
function shown(value, digits = 4) {
  if (!Number.isFinite(value)) return "–";
  if (value !== 0 && (Math.abs(value) < 1e-4 || Math.abs(value) >= 1e5)) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
    return `${mantissa.replace("-", "−")} × 10${superscript(Number(exponent))}`;
  }
  return value.toPrecision(digits).replace("-", "−");
}

/** A length, µm, in the unit that suits it. */
function lengthName(value) {
  const [size, unit] = value < 1 ? [1000 * value, "nm"] : [value, "µm"];
  return `${Number(size.toPrecision(4))} ${unit}`;
}
