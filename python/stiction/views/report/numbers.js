"use strict";

// What a result says at a load, for any mu0 and tau0. Reading off, intervals and statuses are those of `friction_map`
// and `area_map`, or of `at_load`, step for step; the names are the same where the things are.
//
// All that these functions know is in their arguments: nothing here looks at the page. A result, for one sliding rule and
// direction, is {facts, means, sums}: what Python says of it, the means over the members, variable -> (dimension,
// amplitude, step), and the sums of each, variable -> (dimension, amplitude, member, step). Steps are approaches, or
// loads of the half-space. Of measured bodies, where facts.reading is "elastic", each member carries a load before it
// slides: a result is then {facts, motions, chosen, members}, the sums of all of its motions, which of these are averaged
// (several directions), and which members are.

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
    facts, repetitions, count, around: facts.stepsAround, normal, values, meanNormal, meanValues,
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

const sumOf = (values) => values.reduce((sum, value) => sum + value, 0);

/** Sums over the repetitions of values (repetition, approach). */
function totals(values, count) {
  const total = new Float64Array(count);
  for (let i = 0; i < values.length; i++) total[i % count] += values[i];
  return total;
}

/** Of each repetition's number, the mean of the others'. */
function without(each) {
  const total = sumOf(each);
  return each.map((value) => (total - value) / (each.length - 1));
}

/** Least-squares slope of mean values against mean normal loads over the steps around an index. */
function slopeAround({meanNormal, meanValues, around, count}, index) {
  const first = Math.max(index - 1 - around, 0);
  const last = Math.min(index + around, count - 1) + 1;
  const [x, y] = [meanNormal.subarray(first, last), meanValues.subarray(first, last)];
  const [middleX, middleY] = [x, y].map((values) => sumOf(values) / values.length);
  const squares = sumOf(x.map((value) => (value - middleX) ** 2));
  return squares > 0 ? sumOf(x.map((value, i) => (value - middleX) * (y[i] - middleY))) / squares : 0;
}

/** Ends of the interval of a mean that is read off at a load, where the mean load reaches it. */
function interval(jack, mean, load) {
  if (jack === null) return [NaN, NaN];
  const {facts, repetitions, count, meanNormal} = jack;
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
    const half = halfWidth(logarithms, facts);
    return [mean * Math.exp(-half), mean * Math.exp(half)].sort((one, other) => one - other);
  }
  // What is not positive has no logarithm.
  const half = halfWidth(without(values.map((value, r) => value - slope * loads[r])), facts);
  return [Math.max(mean - half, jack.least), mean + half];
}

/** Half the interval of a mean from its leave-one-out values. */
function halfWidth(values, facts) {
  const repetitions = values.length;
  const centre = sumOf(values) / repetitions;
  const each = values.map((value) => (value - centre) ** 2);
  const squares = sumOf(each);
  const kurtosis = squares > 0 ? (repetitions * sumOf(each.map((power) => power ** 2))) / squares ** 2 : 3;
  const freedom = Math.min(Math.max((2 * repetitions) / Math.max(kurtosis - 1, 1e-9), 1), repetitions - 1);
  return studentQuantile(facts, freedom) * Math.sqrt(((repetitions - 1) / repetitions) * squares);
}

/** The upper end of the interval of Student's t, for any degrees of freedom from 1 on: facts.student are the coefficients
 * of its Chebyshev polynomials over the inverse of the freedom, which Clenshaw's recurrence sums. */
function studentQuantile({student}, freedom) {
  const x = 2 / freedom - 1;
  const [first, second] = student.slice(1).reduceRight(([one, other], each) => [2 * x * one - other + each, one], [0, 0]);
  return student[0] + x * first - second;
}

/** Probability that Student's t of a whole number of degrees of freedom is below t > 0; Abramowitz & Stegun, 26.7.3-4. */
function studentBelow(t, freedom) {
  const angle = Math.atan(t / Math.sqrt(freedom));
  const [sine, cosine, isOdd] = [Math.sin(angle), Math.cos(angle), freedom % 2 === 1];
  let term = isOdd ? cosine : 1;
  let sum = freedom === 1 ? 0 : term;
  for (let k = isOdd ? 3 : 2; k < freedom; k += 2) {
    term *= (cosine * cosine * (k - 1)) / k;
    sum += term;
  }
  return 0.5 + (isOdd ? (angle + sine * sum) / Math.PI : (sine * sum) / 2);
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
  const {dimensions, validity: figures} = result.facts;
  const isWidth = quantity === "width";
  const columns = dimensions.map((_, d) => readOff(result, isWidth ? "friction" : quantity, d, a, loads, mu0, tau0, isWidth));
  const grid = (of) => loads.map((_, l) => columns.map((column) => (column[l].status === "ok" ? of(column[l]) : null)));
  const finite = (value) => (Number.isFinite(value) ? value : null);
  return {
    status: loads.map((_, l) => columns.map((column) => column[l].status)),
    value: grid(({value, lower, upper}) => (isWidth ? finite((upper - lower) / (2 * Math.abs(value))) : value)),
    trusted: grid(({trusted}) => trusted),
    isSound: grid(({validity}) => Object.entries(figures).every(([name, {limit}]) => !(validity[name] > limit))),
  };
}

/** What is known of a quantity at loads: value, interval where that is wanted, status and validity. */
function readOff(result, quantity, d, a, loads, mu0, tau0, hasInterval = true) {
  if (result.facts.reading === "elastic") return loads.map((load) => meanOfMembers(result, quantity, d, a, load, mu0, tau0));
  const curves = meanCurves(result, d, a, mu0, tau0);
  const values = curves.of(quantity);
  const jack = hasInterval ? jackknife(result, d, a, quantity, mu0, tau0) : null;
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
      load, status, value: value / divisor, lower: lower / divisor, upper: upper / divisor, validity, mu0, tau0,
      contacts: valueAt(result.means.contact_count, curves.from, index, fraction),
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

// ---- The verdict ---------------------------------------------------------------------------------------------------

/** The first check of each group that the numbers of a point do not pass; as `doubts.doubted`. */
function doubted(checks, numbers) {
  return checks.map((group) => group.find(({name, limit}) => numbers[name] > limit)).filter(Boolean)
    .map(({name, text, cure, severity, shown: by, about}) => {
      const words = {percent, digits: (value) => significant(value), digit: (value) => significant(value, 1)}[by]
        ?? ((value) => withUnit(value, by));
      return {text: text.replace("{}", words(numbers[about || name])), cure, severity};
    });
}

/** Why the friction coefficient of an ensemble at a load, with this mean contact area, is not to be quoted or with care:
 * the checks and words are the library's. */
function doubtsOfEnsemble({checks, advice, repetitions, nominalArea, limits}, point, area) {
  const {status, value, lower, upper, load, validity, contacts, mu0, tau0} = point;
  if (status !== "ok" || Number.isNaN(value)) {
    const [text, cure] = advice[status] ?? advice[""];
    return [{text, cure, severity: "fault"}];
  }
  const isMerged = nominalArea !== null && area / nominalArea > limits.merged;
  return doubted(checks, {
    ...validity, deficit: -value, missing_interval: Number(!(Number.isFinite(lower) && Number.isFinite(upper))),
    half_width: (upper - lower) / (2 * value), mean_pressure: area > 0 ? load / area : NaN,
    contact_count: contacts, contacts_missing_of_all: limits.of_all - contacts * repetitions,
    contacts_missing: isMerged ? NaN : limits.least - contacts, contacts_wanting: isMerged ? NaN : limits.few - contacts,
    share_of_mu0: mu0 > 0 && tau0 === 0 ? 1 - Math.abs(value / mu0 - 1) : NaN, beyond_mu0: value - mu0,
  });
}

/** How the style calls each verdict. */
const KIND = {"Quote it": "good", "Quote with care": "care", "Do not quote": "bad"};

/** The verdict that doubts come to. */
function verdictOf({verdicts}, doubts) {
  const severities = doubts.map(({severity}) => severity);
  return verdicts[severities.includes("fault") ? "fault" : severities.length ? "caution" : ""];
}

// ---- Beginning and drawing -----------------------------------------------------------------------------------------

/** Where to begin: the sound cell (d, l) of a map whose width is least, or without widths that is nearest to its middle, or the middle. */
function beginning(map, widths = null) {
  const [rows, columns] = [map.value.length, map.value[0].length];
  let best = [Math.floor(columns / 2), Math.floor(rows / 2)];
  let least = Infinity;
  map.isSound.forEach((row, l) => row.forEach((isSound, d) => {
    const distance = ((l + 0.5) / rows - 0.5) ** 2 + ((d + 0.5) / columns - 0.5) ** 2;
    const size = widths ? widths[l][d] ?? Infinity : distance;
    if (isSound && size < least) [best, least] = [[d, l], size];
  }));
  return best;
}

/** Range of colours: the highest few per cent share one, or friction at the highest D would take them all. */
function colourRange({colourQuantiles}, map) {
  const values = map.value.flat().filter((value) => value > 0).sort((x, y) => x - y);
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

// ---- Members that carry one load -----------------------------------------------------------------------------------

/** Index of the step that is a load, or -1. */
const stepOf = ({steps}, load) => steps.findIndex((step) => Math.abs(step - load) <= 1e-9 * load);

/** A/F of a hardness where the elastic A/F is known; as `mechanics.hardness._estimate`. */
function estimatedArea({mixing: [exponent, power]}, hardness, elastic) {
  const own = exponent * (hardness * elastic) ** power;
  const [smaller, larger] = [Math.min(1 / hardness, elastic), Math.max(1 / hardness, elastic)];
  return larger * Math.exp(Math.log1p((smaller / larger) ** own) / own);
}

/** A/F of a hardness between those that were solved; as `mechanics.hardness.area_per_load`. */
function areaPerLoad(growth, {areas, elastic}, hardness) {
  const logs = growth.nodes.map(Math.log);
  const last = logs.length - 1;
  const excess = (node) => Math.log(areas[node] / estimatedArea(growth, growth.nodes[node], elastic));
  if (!last) return estimatedArea(growth, hardness, elastic) * Math.exp(excess(0));
  const log = Math.min(Math.max(Math.log(hardness), logs[0]), logs[last]);
  const after = Math.max(logs.findIndex((each) => each >= log), 1);
  const part = (log - logs[after - 1]) / (logs[after] - logs[after - 1]);
  return estimatedArea(growth, hardness, elastic) * Math.exp(excess(after - 1) * (1 - part) + excess(after) * part);
}

/** True area at the onset of sliding over that before shear, by junction growth; Infinity where interfaces seize. */
function grownArea({growth, directions, steps, area}, motion, step, mu0, tau0) {
  if (!growth) return 1;
  const {hardness, alpha, tables} = growth;
  const left = hardness ** 2 - alpha * tau0 ** 2;
  const shear = alpha * mu0 * tau0;
  const pressure = left / (shear + Math.sqrt(shear ** 2 + (1 + alpha * mu0 ** 2) * Math.max(left, 0)));
  if (!(pressure > steps[step] / area)) return Infinity;
  const table = tables[Math.floor(motion / directions.length)][step];
  return areaPerLoad(growth, table, pressure) / areaPerLoad(growth, table, hardness);
}

/** Normal and tangential load of each member at a step, in a motion. */
function loadsOfMembers({facts, motions, members}, motion, d, a, step, mu0, tau0) {
  const sheared = tau0 && tau0 * grownArea(facts, motion, step, mu0, tau0);
  return members.map((member) => {
    const at = (pairIndex(facts, d, a) * facts.repetitions + member) * facts.steps.length + step;
    return [OF_NORMAL, OF_TANGENTIAL].map((names) => {
      const [elastic, frictional, adhesive] = names.map((name) => motions[motion].sums[name][at]);
      return elastic + mu0 * frictional + (sheared && adhesive ? sheared * adhesive : 0);
    });
  });
}

/** The friction coefficient of each member at a step, over the chosen motions; NaN where there is none. */
function frictionOfMembers(result, ...at) {
  const loads = result.chosen.map((motion) => loadsOfMembers(result, motion, ...at));
  return result.members.map((_, i) =>
    sumOf(loads.map((own) => (own[i][0] > 0 ? own[i][1] / own[i][0] : NaN))) / loads.length);
}

/** Mean of friction over the members at a load with its interval, or of one of facts.quantities as it was handed over. */
function meanOfMembers(result, quantity, d, a, load, mu0, tau0) {
  const {facts, kind} = result;
  const step = stepOf(facts, load);
  const said = {load, validity: null, trusted: true};
  if (step < 0) return {...said, status: "not-reached", value: NaN, lower: NaN, upper: NaN};
  if (quantity !== "friction") {
    const [value, lower, upper] = facts.quantities.find(({name}) => name === quantity).means[kind][d][step].map((each) => each ?? NaN);
    return {...said, status: Number.isFinite(value) ? "ok" : "not-solved", value, lower, upper};
  }
  const values = frictionOfMembers(result, d, a, step, mu0, tau0);
  const [value, lower, upper] = intervalOf(result, values);
  const answered = values.filter(Number.isFinite).length;
  const loads = answered ? [] : loadsOfMembers(result, result.chosen[0], d, a, step, mu0, tau0);
  const seizes = loads.some(([, tangential]) => tangential === Infinity);
  const status = answered ? "ok" : seizes ? "seizure" : loads.some(([normal]) => normal <= 0) ? "self-locked" : "not-solved";
  return {...said, status, value, lower, upper, answered, all: values.length};
}

/** Mean and interval of values of members: of independent ones, or of neighbours along lines. */
function intervalOf({facts, members}, values) {
  if (facts.interval !== "neighbours") return ofSample(values, facts);
  const known = members.map((member, i) => ({line: facts.lines[member], x: facts.offsets[0][member], y: facts.offsets[1][member], value: values[i]}))
    .filter(({value}) => Number.isFinite(value)).sort((one, other) => one.y - other.y || one.line - other.line || one.x - other.x);
  const lines = [...new Set(known.map(({line}) => line))];
  let independent = known.map(({value}) => value);
  if (lines.length > 1) {
    const of = lines.map((line) => known.filter((each) => each.line === line));
    const sums = of.map((each) => sumOf(each.map(({value}) => value)));
    const mean = sumOf(sums) / known.length;
    independent = sums.map((sum, i) => mean + ((sum - of[i].length * mean) * lines.length) / known.length);
  }
  const [mean, lower, upper] = ofNeighbours(independent, facts);
  const all = known.map(({value}) => value);
  return [mean, Math.max(lower, Math.min(...all)), Math.min(upper, Math.max(...all))];
}

/** Mean of a sample, without what is not finite, and its interval by Student's t, of the logarithm unless signed; as `intervals.of_sample`. */
function ofSample(values, facts) {
  const known = values.filter(Number.isFinite);
  const count = known.length;
  const mean = sumOf(known) / count;
  if (count < facts.fewest) return [mean, NaN, NaN];
  const squares = sumOf(known.map((value) => (value - mean) ** 2));
  const half = studentQuantile(facts, count - 1) * Math.sqrt(squares / (count - 1) / count);
  if (!(mean > 0) || known.some((value) => value < 0)) return [mean, mean - half, mean + half];
  const factor = Math.exp(half / mean);
  return [mean, mean / factor, mean * factor];
}

const CORRELATIONS = Array.from({length: 20}, (_, i) => 0.05 * i);

/** Mean of values in the order in which they are neighbours, and its interval; as `intervals.of_neighbours`. */
function ofNeighbours(values, facts) {
  const count = values.length;
  const mean = sumOf(values) / count;
  if (count < facts.fewestNeighbours || values.every((value) => value === values[0])) return [mean, NaN, NaN];
  const spread = Math.sqrt(sumOf(values.map((value) => (value - mean) ** 2)) / (count - 1));
  if (!(spread > 0)) return [mean, NaN, NaN];
  const y = values.map((value) => (value - mean) / spread);
  const sum = sumOf(y);
  const processes = CORRELATIONS.map((rho) => {
    const ones = (count - (count - 2) * rho) / (1 + rho);
    const centre = (y[0] + y[count - 1] + (1 - rho) * (sum - y[0] - y[count - 1])) / (1 + rho) / ones;
    let squares = (y[0] - centre) ** 2;
    let inflation = count;
    for (let i = 1; i < count; i++) {
      squares += (y[i] - centre - rho * (y[i - 1] - centre)) ** 2 / (1 - rho ** 2);
      inflation += 2 * (count - i) * rho ** i;
    }
    return {
      weight: (count - 1) * (Math.log(1 - rho ** 2) + Math.log(squares)) + Math.log(ones) - Math.log(1 - rho),
      error: Math.sqrt((squares / (count - 1)) * (inflation / count ** 2)),
    };
  });
  const least = Math.min(...processes.map(({weight}) => weight));
  for (const each of processes) each.weight = Math.exp(-0.5 * (each.weight - least));
  const total = sumOf(processes.map(({weight}) => weight));
  const below = (half) => sumOf(processes.map(({weight, error}) => (weight / total) * studentBelow(half / error, count - 1)));
  let [low, high] = [0, studentQuantile(facts, count - 1) * Math.max(...processes.map(({error}) => error))];
  for (let step = 0; step < 45; step++) {
    const middle = (low + high) / 2;
    if (below(middle) < 0.5 + facts.confidence / 2) low = middle;
    else high = middle;
  }
  const power = (n) => sumOf(y.map((value) => value ** n)) / count;
  const bend = power(3) / power(2) ** 1.5 / 3;
  const isBent = Math.abs(bend) > 1e-9;
  const [down, up] = isBent ? [-Math.expm1(-bend * high) / bend, Math.expm1(bend * high) / bend] : [high, high];
  return [mean, Math.max(mean - spread * down, Math.min(...values)), Math.min(mean + spread * up, Math.max(...values))];
}

/** The friction coefficient by the slope of the gap alone; as `gentle_friction`. */
function gentleFriction(mu0, tau0, {gradient, slope, modulus, kappa}, sliding) {
  const m = mu0 + (kappa * tau0) / (modulus * gradient);
  const mean = slope / (2 * Math.sqrt(2 * Math.PI));
  if (sliding === "all") return m;
  return m * mean < 1 ? (m / 2 + mean) / (1 - m * mean) : NaN;
}

/** What the mean slopes of the gap alone say, on the mean over directions (indices). */
function slopesAlone({facts, members}, d, directions, sliding, mu0, tau0) {
  if (!facts.gap) return NaN;
  const {modulus, gap: {gradient, slope, kappa}} = facts;
  const mean = (values) => {
    const known = members.map((member) => values[member]).filter(Number.isFinite);
    return sumOf(known) / known.length;
  };
  return sumOf(directions.map((way) => gentleFriction(mu0, tau0, {gradient: mean(gradient[d]),
    slope: mean(slope[Math.min(way, slope.length - 1)][d]), modulus, kappa}, sliding))) / directions.length;
}

/** Position in a list of the number that is nearest to another one. */
function nearest(list, value) {
  const distances = list.map((each) => Math.abs(each - value));
  return distances.indexOf(Math.min(...distances));
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

/** A value with so many decimals, or rounded to tens, without the minus of a zero; as `digits._in_decimals`. */
function inDecimals(value, digits) {
  const text = digits >= 0 ? value.toFixed(Math.min(digits, 100)) : String(Math.round(value / 10 ** -digits) * 10 ** -digits);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−");
}

const HUGE = 100;
const MOST_DIGITS = 4;
const exponentOf = (value) => Math.floor(Math.log10(Math.abs(value)));

/** A number by so many significant digits, without zeros at its end; as `digits.significant`. */
function significant(value, digits = 2) {
  const size = Math.abs(value);
  if (size !== 0 && !(size >= 1e-6 && size < 1e6)) return shown(value, digits);
  const text = Number(value.toPrecision(digits)).toFixed(size < 1 ? digits + 5 : digits);
  return text.replace(/\.?0+$/, "").replace("-", "−");
}

/** A number to quote, by one digit of half the width of its interval; as `digits.quoted`. */
function quoted(mean, lower = NaN, upper = NaN) {
  if (!Number.isFinite(mean)) return "none";
  if (!Number.isFinite(lower) || !Number.isFinite(upper)) return inDecimals(mean, mean === 0 ? 1 : 1 - exponentOf(mean));
  const size = mean === 0 ? 0 : -exponentOf(mean);
  const width = upper > lower ? -exponentOf((upper - lower) / 2) : Infinity;
  const decimals = mean === 0 && upper > lower ? width : Math.min(Math.max(width, size + 1), size + MOST_DIGITS - 1);
  const low = inDecimals(lower, decimals);
  if (low === inDecimals(upper, decimals)) return significant(mean, MOST_DIGITS);
  const isHuge = upper > HUGE * Math.abs(mean) && mean !== 0; // of such an end the size alone is known
  return `${inDecimals(mean, decimals)} [${low}, ${isHuge ? significant(upper, 1) : inDecimals(upper, decimals)}]`;
}

const SMALLEST_PERCENT = 0.001;

/** A fraction as percent, by two digits where it is small; as `digits.percent`. */
function percent(fraction) {
  if (!Number.isFinite(fraction)) return "none";
  const value = 100 * fraction;
  if (value !== 0 && Math.abs(value) < SMALLEST_PERCENT) return `less than ${SMALLEST_PERCENT} %`;
  const digits = Math.abs(value) < 1 ? 2 : 3;
  return `${Math.abs(value) < 10 ? String(Number(value.toPrecision(digits))) : value.toFixed(0)} %`;
}

// Of each unit the least value that is written in it, its factor to core units, and its name.
const PREFIXES = {
  mN: [[1e6, 1e6, "kN"], [1e3, 1e3, "N"], [0.01, 1, "mN"], [1e-5, 1e-3, "µN"], [0, 1e-6, "nN"]],
  GPa: [[1, 1, "GPa"], [1e-3, 1e-3, "MPa"], [1e-6, 1e-6, "kPa"], [0, 1e-9, "Pa"]],
  um: [[1e6, 1e6, "m"], [1e3, 1e3, "mm"], [1, 1, "µm"], [0, 1e-3, "nm"]],
};

/** Factor and name of the unit in which a value has the fewest zeros, of another in which its first digit is seen. */
function unitFor(value, unit) {
  const units = PREFIXES[unit];
  if (!units) return unit === "%" ? [0.01, "%"] : [1, unit];
  if (value === 0) return [1, unit.replace("um", "µm")];
  const size = Number(Math.abs(value).toPrecision(3)); // as it is shown
  const [, factor, name] = units.find(([least]) => size >= least);
  return [factor, name];
}

/** A value, by three digits, in the unit in which it has the fewest zeros; as `digits.with_unit`. */
function withUnit(value, unit) {
  if (!Number.isFinite(value)) return "none";
  const [factor, name] = unitFor(value, unit);
  return `${String(Number((value / factor).toPrecision(3))).replace("-", "−")} ${name}`.trim();
}

/** A value with its interval in one unit. */
function intervalWithUnit(value, lower, upper, unit) {
  if (!Number.isFinite(value)) return "none";
  const [factor, name] = unitFor(value, unit);
  if (value === 0 && !(upper > 0)) return `0 ${name}`.trim();
  return `${quoted(value / factor, lower / factor, upper / factor)}\u00a0${name}`.trim();
}
