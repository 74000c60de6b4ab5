// Script of the page of a result: state, controls and texts.

// ---- State ----------------------------------------------------------------------------------------------------------

const {isMeasured, cells, axes: parameters} = facts;
const loads = facts.loads.values;
const state = {
  mu0: parameters?.mu0.start ?? 0,
  tau0: parameters?.tau0.start ?? 0, // shear strength in MPa
  rule: 0,
  way: 0,
  kind: 0,
  amplitude: 0,
  dimension: facts.start.cell,
  load: facts.start.load,
  quantity: "friction",
  pointed: null, // indices (dimension, load) of the chart cell under the pointer
};
const numbers = {offsets: facts.tables, formats: facts.formats, floats: null, small: null};
let mapped = null;
const RULE_COLOURS = {all: "var(--all)", opposing: "var(--opposing)"};

const FRICTION = ["map", "readout", "over", "friction", "area", "stiffness", "unloading", "compass"];
const hasBothRules = facts.rules.length > 1;
const amplitudeCount = Math.max(1, facts.amplitudes.length);
const place = () => placeAt(parameters, state.mu0, state.tau0);

/** Return the index of a coefficient in the tables. */
function indexOf(rule, cell, load, way = state.way) {
  const [R, W, L] = [facts.rules.length, facts.ways.length, loads.length];
  const lead = (state.kind * cells.values.length + cell) * amplitudeCount + state.amplitude;
  return ((lead * R + facts.rules.indexOf(rule)) * W + way) * L + load;
}

/** Return friction for a rule: value, interval, status and kind of interval.
 * Without a combined interval, the interval is the interval of the mean. It is then drawn but not printed. */
function frictionAt(rule, cell, load, at = place(), way = state.way) {
  const index = indexOf(rule, cell, load, way);
  const first = index * at.size;
  const status = facts.statuses[numbers.small[numbers.offsets.status + first + at.node]];
  const result = {load: loads[load], status: status.name, value: NaN, lower: NaN, upper: NaN, trusted: status.isTrusted, index};
  if (!status.hasValue) return result;
  const point = pointAt(numbers, "friction", index, at);
  const isCombined = facts.combined[state.kind] && facts.ways[way].isWhole;
  if (!isMeasured) return {...result, ...point, isCombined};
  const sampling = pointAt(numbers, "sampling", index, at);
  const ends = isCombined ? {} : {lower: sampling.lower, upper: sampling.upper};
  return {...result, ...point, ...ends, sampling, isCombined};
}

/** Return the quantity (other than friction) that is shown in the plot with the given name. */
function quantityAt(id, cell, load, at = place()) {
  if (isMeasured) {
    const own = facts.quantities.find(({name}) => name === facts.curves[id].of);
    const [value, lower, upper] = own.points[state.kind][cell][load].map((each) => each ?? NaN);
    return {load: loads[load], status: Number.isFinite(value) ? "ok" : "not-solved", value, lower, upper, trusted: true,
      decimals: own.decimals[state.kind][cell][load], upperDecimals: own.upperDecimals[state.kind][cell][load]};
  }
  const friction = frictionAt(facts.rules[state.rule], cell, load, at);
  return friction.status === "ok" ? {...friction, ...pointAt(numbers, id, friction.index, at)} : friction;
}

/** Return the rule, the colour and the name of each curve. */
const curves = () => (hasBothRules ? facts.rules : [facts.rules[state.rule]])
  .map((rule) => ({rule, colour: RULE_COLOURS[rule], name: hasBothRules ? ruleName(rule) : ""}));

// ---- Texts ----------------------------------------------------------------------------------------------------------

const ruleName = (rule) => facts.ruleNames[rule];
const loadName = (l) => facts.loads.texts[l];
const materialName = () => `μ0 = ${state.mu0}, τ0 = ${state.tau0} MPa`;
const dimensionIfAny = () => (cells.values.length > 1 || !isMeasured ? [cells.texts[state.dimension]] : []);
const amplitudeIfAny = () => (isMeasured ? [] : [`amplitude ${facts.amplitudes[state.amplitude]}`]);
const wayName = () => `the upper body moves ${facts.ways[state.way].words}`;
const motionWords = () => (facts.ways[state.way].directions.length > 1 ? facts.ways[state.way].words : wayName());
const counted = (count, thing) => `${count} ${thing}${count === 1 ? "" : "s"}`;

function showParameters() {
  byId("parameters").textContent = [`${materialName()}`, ...(loads.length ? [`load ${loadName(state.load)}`] : []),
    ...dimensionIfAny(), ...amplitudeIfAny(), motionWords()].join(", ") + ".";
}

/** Return the name of an interval. The interval for generated surfaces is always due to sampling of repetitions.
 */
function intervalName(isCombined, isQuantity = false) {
  if (!isMeasured) return "interval";
  if (isQuantity && facts.combined[state.kind]) return "combined interval";
  if (!isCombined) return "interval of the mean";
  return `combined interval${facts.ranged && !isAtRange() ? ", μ0 and τ0 exact where the study has other values" : ""}`;
}

/** Return whether mu0 and tau0 are both within the uncertainty ranges of the study. */
const isAtRange = () => ["mu0", "tau0"].every((name) => !parameters[name].ranged.length || parameters[name].ranged.includes(state[name]));

function whyNoInterval() {
  if (isMeasured && facts.memberCounts[state.kind] < 2) return `there are fewer than two ${facts.kinds[state.kind]}`;
  if (isMeasured) return `too few ${facts.kinds[state.kind]} have a coefficient, or all coefficients are equal`;
  return facts.repetitions === 1 ? "there is one repetition" : "fewer than two repetitions carry load";
}

// ---- Result ---------------------------------------------------------------------------------------------------------

function showReadout() {
  showParameters();
  const [d, l] = [state.pointed?.[0] ?? state.dimension, state.pointed?.[1] ?? state.load];
  const where = [...(isMeasured && cells.values.length < 2 ? [] : [cells.texts[d]]), loadName(l), motionWords()];
  const answers = [element("p", {class: "hint"}, `${state.pointed ? "Under the pointer" : "At"}: ${where.join(", ")}`)];
  const points = curves().map((curve) => ({...curve, at: frictionAt(curve.rule, d, l), alone: slopeEstimate(curve.rule, d)}));
  const judged = judgement(points, d, l);
  for (const [i, {at, colour, rule, alone}] of points.entries()) {
    answers.push(element("p", {class: i ? "of other" : "of", style: `color: ${colour}`}, facts.ruleDescriptions[rule]), ...answerOf(at, rule, judged.saysSlopes ? null : alone));
    if (i || !judged.answer || !at.isCombined) continue;
    const {bar, most} = judged.answer;
    if (bar) answers.push(contributionBar(bar));
    if (most && (bar || rule !== "all")) answers.push(element("p", {class: "hint"}, most));
  }
  if (points.length > 1 && isMeasured)
    answers.push(element("p", {class: "hint"}, facts.ruleNote));
  const [{at: {status, value, lower, upper}}] = points;
  Object.assign(byId("readout").dataset, {dimension: cells.values[d], load: loads[l], mu0: state.mu0, tau0: state.tau0 / 1000, status, value, lower, upper});
  byId("answer").replaceChildren(...answers);
  byId("judgement").replaceChildren(...judged.elements);
  byId("sentence").replaceChildren(...judged.more);
  byId("figures").replaceChildren(figuresOf(points[0].at, d, l));
}

const isSame = (first, second) => Math.abs(first - second) <= 1e-9 * Math.max(Math.abs(first), Math.abs(second), 1e-300);

/** Draw the contributions to a coefficient as a bar, with its interval. */
function contributionBar({contributions, ends: [low, high], value, texts}) {
  const most = 1.05 * Math.max(value, high ?? value);
  const percent = (part) => `${(100 * part) / most}%`;
  const bar = shape("svg", {class: "bar", role: "img", width: "100%", height: 34});
  let from = 0;
  const colours = (contributions.length < 3 ? ["accent", "opposing"] : ["accent", "area", "opposing"]).map((name) => `var(--${name})`);
  contributions.forEach((part, index) => {
    const begin = part < 0 ? from + part : from;
    bar.append(shape("rect", {x: percent(begin), y: 6, width: percent(Math.abs(part)), height: 16, fill: colours[index]}));
    from += part;
  });
  if (low !== null) {
    const to = high ?? most; // an interval without upper limit is drawn up to the end of the bar
    bar.append(shape("line", {x1: percent(low), x2: percent(to), y1: 14, y2: 14, stroke: "var(--ink)", "stroke-width": 2}));
    for (const end of high === null ? [low] : [low, high]) bar.append(shape("line", {x1: percent(end), x2: percent(end), y1: 8, y2: 20, stroke: "var(--ink)", "stroke-width": 2}));
  }
  bar.setAttribute("aria-label", texts.join(""));
  return element("div", {}, bar, element("p", {class: "hint"}, ...texts.map((text, index) => element("span", {style: `color: ${colours[index]}; font-weight: 600`}, text))));
}

function answerOf(at, rule, alone) {
  const reason = at.status === "ok" ? [] : [element("p", {class: "interval"}, facts.why[at.status]?.why ?? "")];
  if (!Number.isFinite(at.value)) return [element("p", {class: "value"}, at.status), ...reason];
  const ends = formatEnds(at);
  const sampled = at.sampling && formatEnds(at.sampling);
  const [interval] = at.isCombined || !isMeasured
    ? [ends ? [`${PERCENT} ${intervalName(at.isCombined)} `, element("span", {"data-lower": at.lower, "data-upper": at.upper}, ends)] : [`No interval: ${whyNoInterval()}`]]
    : [["No combined interval: it exists only for the mean over all directions"]];
  return [
    element("p", {class: "value", "data-rule": rule}, element("i", {}, "μ"), element("sub", {}, "s"), at.status === "ok" ? " = " : " ≥ ", data(at.value, inDecimals(at.value, at.decimals))),
    element("p", {class: "interval"}, ...interval),
    ...reason,
    ...(sampled && (!at.isCombined || sampled !== ends) ? [element("p", {class: "hint"}, `Interval of the mean, ${facts.ruleDescriptions[rule]}: ${sampled}`)] : []),
    ...(alone ? [element("p", {class: "hint"}, "The small-slope estimate is ", data(alone.value, quoted(alone)))] : []),
  ];
}

/** Return the small-slope estimate, or null if there is none. */
function slopeEstimate(rule, cell) {
  if (numbers.offsets.slopes_value === undefined) return null;
  const index = ((state.kind * cells.values.length + cell) * facts.rules.length + facts.rules.indexOf(rule)) * facts.ways.length + state.way;
  const point = pointAt(numbers, "slopes", index, place());
  return Number.isFinite(point.value) ? point : null;
}

/** CSS classes by assessment. */
const ASSESSMENT_CLASSES = {"Quote it": "good", "Quote with care": "care", "Do not quote": "bad"};

/** Return the elements of the assessment and its caveats. */
function judgement(points, d, l) {
  const assemble = (elements, saysSlopes = false, answer = null) => ({elements, saysSlopes, answer,
    more: answer ? [element("p", {class: "sentence"}, answer.sentence), ...(saysSlopes ? [element("p", {class: "hint"}, answer.slopes)] : [])] : []});
  if (!isMeasured) {
    const index = ((d * amplitudeCount + state.amplitude) * facts.ways.length + state.way) * loads.length + l;
    const {assessment, caveats} = judgementAt(numbers, facts.judgements, index, place());
    return assemble(assessmentElements(assessment, caveats));
  }
  const isWhole = facts.ways[state.way].isWhole;
  const isHere = ({at}) => isSame(at.load, loads[l]) && (at.cut_off === undefined || isSame(at.cut_off, cells.values[d]));
  const answer = facts.points.find((each) => isHere(each) && isSame(each.at.mu0, state.mu0) && isSame(1000 * each.at.tau0, state.tau0));
  if (answer) return assemble(assessmentElements(answer.assessment, answer.caveats), isWhole && answer.slopes !== "", isWhole ? answer : null);
  const near = facts.points.reduce((best, each) => {
    const apart = ({at}) => Math.abs(Math.log(at.load / loads[l])) + (at.cut_off !== undefined && !isSame(at.cut_off, cells.values[d]) ? 10 : 0);
    return !best || apart(each) < apart(best) ? each : best;
  }, null);
  const back = element("button", {type: "button"}, "Back to the values of the study");
  back.addEventListener("click", () => goTo(near.at));
  return assemble(near ? [element("p", {class: "hint"}, "The assessment applies to the loads, μ0 and τ0 of the study; at " +
    `${near.loadText} it is: ${near.assessment}. `, back)] : []);
}

const MAX_OPEN_CAVEATS = 3; // number of caveats above the closed list of further caveats; faults are always above this list

function assessmentElements(assessment, caveats) {
  const kind = ASSESSMENT_CLASSES[assessment];
  const list = (some) => (some.length ? [element("ul", {class: "caveats"}, ...some.map(({text, remedy, severity}) =>
    element("li", {class: severity}, `${text.replace(/^[a-z]/, (letter) => letter.toUpperCase())}; ${remedy}.`)))] : []);
  const numOpen = Math.max(MAX_OPEN_CAVEATS, caveats.filter(({severity}) => severity === "fault").length);
  const rest = caveats.slice(numOpen);
  return [element("div", {class: `said ${kind}`}, element("p", {class: `assessment ${kind}`}, assessment), ...list(caveats.slice(0, numOpen)),
    ...(rest.length ? [element("details", {}, element("summary", {}, `${rest.length} more`), ...list(rest))] : []))];
}

function figuresOf(at, d, l) {
  const list = element("dl", {});
  const row = (words, value, text, isBeyond = false) => list.append(element("dt", {}, words),
    element("dd", isBeyond ? {class: "beyond"} : {}, isBeyond ? "⚠ " : "", data(value, text)));
  if (at.status !== "ok") list.append(element("dt", {}, "Status"), element("dd", {class: "status"}, at.status));
  const here = place();
  if (isMeasured) {
    for (const {words, points, texts, isBeyond} of facts.quantities) {
      const [value] = points[state.kind][d][l];
      if (value !== null) row(words, value, texts[state.kind][d][l], isBeyond[state.kind][d][l]);
    }
    const answered = numbers.floats[numbers.offsets.answered + at.index * here.size + here.node];
    row(`${facts.kinds[state.kind].replace(/^./, (letter) => letter.toUpperCase())} with a coefficient`, answered, `${answered} of ${facts.memberCounts[state.kind]}`);
    return list;
  }
  if (at.status !== "ok") return list;
  for (const [quantity, words] of [["area", "True contact area"], ["stiffness", "Normal stiffness"]]) {
    if (!hasQuantity(quantity)) continue;
    const of = quantityAt(quantity, d, l);
    row(words, of.value, quoted(of));
  }
  for (const {name, words} of facts.means) {
    const number = numberAt(numbers, `mean_${name}`, at.index, here);
    const isBeyond = Boolean(numbers.small[numbers.offsets[`beyond_${name}`] + at.index * here.size + here.node]);
    if (Number.isFinite(number.value)) row(words, number.value, printed(number), isBeyond);
  }
  return list;
}

// ---- The map --------------------------------------------------------------------------------------------------------

const TITLES = {friction: "_μ_~s~", width: "±", area: "_A_ (µm²)", stiffness: "mN/µm"};

/** Return the quantity of the map by (load, dimension): values, statuses, and whether each value counts as valid. */
function mapAt() {
  const [at, rule] = [place(), facts.rules[state.rule]];
  const of = {
    friction: (d, l) => frictionAt(rule, d, l, at),
    width: (d, l) => {
      const point = frictionAt(rule, d, l, at);
      return point.status === "ok" ? {...point, ...numberAt(numbers, "width", point.index, at)} : point;
    },
  }[state.quantity] ?? ((d, l) => quantityAt(state.quantity, d, l, at));
  const points = loads.map((_, l) => cells.values.map((__, d) => of(d, l)));
  const grid = (pick) => points.map((row) => row.map(pick));
  return {status: grid(({status}) => status), value: grid(({value}) => (Number.isFinite(value) ? value : null)),
    trusted: grid(({status, trusted}) => (status === "ok" ? trusted : null)), points};
}

const UNIT_COLOURS = [{value: 0.1, text: "0.1"}, {value: 1, text: "1"}]; // colour scale of a quantity without positive values

function coloursOf() {
  const index = (state.amplitude * facts.rules.length + state.rule) * facts.ways.length + state.way;
  const ends = facts.maps.includes(state.quantity) ?
    ["low", "high"].map((end) => numberAt(numbers, `colours_${state.quantity}_${end}`, index, place())) : [];
  return ends.length && ends.every(({value}) => value > 0) ? ends.map((end) => ({...end, text: printed(end)})) : UNIT_COLOURS;
}

function showMap() {
  mapped = mapAt();
  const legend = drawMap(byId("map"), {
    facts, map: mapped, loads, colours: coloursOf(), picked: [state.dimension, state.load],
    ticks: state.quantity === "friction" ? facts.ticks : null, title: TITLES[state.quantity],
  });
  byId("legend").replaceChildren(...legend.map(([picture, words]) => element("li", {}, picture, words)));
}

// ---- Curves ---------------------------------------------------------------------------------------------------------

const QUANTITY = {
  friction: {title: "coefficient of static friction _μ_~s~", isLog: false},
  area: {title: facts.curves.area?.title ?? "true contact area _A_ (µm²)", isLog: true},
  stiffness: {title: facts.curves.stiffness?.title ?? "normal stiffness (mN/µm)", isLog: true},
  unloading: {title: facts.curves.unloading?.title ?? "", isLog: true},
};

const hasQuantity = (id) => (isMeasured ? facts.quantities.some(({name}) => name === facts.curves[id]?.of)
  : id === "area" || (id === "stiffness" && facts.hasStiffness));

/** Return a series for each curve. Quantities other than friction have only one series. */
function seriesOf(id, points) {
  const drawn = id === "friction" ? curves() : [{...curves()[0], name: "", colour: "var(--area)"}];
  return drawn.map((curve) => ({...curve, points: points(curve.rule)}));
}

function showCurve(id) {
  const at = place();
  const series = seriesOf(id, (rule) => loads.map((load, l) => ({
    ...(id === "friction" ? frictionAt(rule, state.dimension, l, at) : quantityAt(id, state.dimension, l, at)), x: load})));
  const levels = id === "friction" && isMeasured ? series.flatMap(({rule, colour}) => {
    const alone = slopeEstimate(rule, state.dimension);
    return alone ? [{value: alone.value, colour, name: `small-slope estimate, ${rule}`}] : [];
  }) : [];
  const room = isMeasured ? 1.15 : 1;
  const x = {low: loads[0] / room, high: loads.at(-1) * room, isLog: true, title: `normal load _F_~N~ (mN)${facts.loads.unit}`};
  const drawn = drawCurves(byId(id), series, x, {...QUANTITY[id], picked: loads[state.load], levels});
  byId(`${id}-caption`).textContent = curveCaption(series, [...dimensionIfAny(), ...amplitudeIfAny()], drawn, "load", id);
}

function showOver() {
  const at = place();
  const series = seriesOf("friction", (rule) => cells.values.map((value, d) => ({...frictionAt(rule, d, state.load, at), x: value})));
  const ends = edges(cells.values);
  const drawn = drawCurves(byId("over"), series, {low: ends[0], high: ends.at(-1), title: facts.cell.title},
    {...QUANTITY.friction, picked: cells.values[state.dimension]});
  byId("over-caption").textContent = curveCaption(series, [loadName(state.load), ...amplitudeIfAny()], drawn, "dimension", "friction");
}

function curveCaption(series, where, [low, high], of, id) {
  const points = series.flatMap((each) => each.points);
  const ok = points.filter((point) => point.status === "ok");
  const words = [`At ${[...where, materialName()].join(", ")}; ${motionWords()}${hasBothRules ? "" : `, ${ruleName(facts.rules[0])}`}.`];
  if (ok.length && ok.every((point) => Number.isFinite(point.lower))) {
    words.push(`Shaded: ${PERCENT} ${intervalName(id === "friction" && ok.every((point) => point.isCombined), id !== "friction")}.`);
    const cut = [];
    if (ok.some((point) => point.upper > high)) cut.push("above");
    if (ok.some((point) => point.lower < low)) cut.push("below");
    if (cut.length) words.push(`It is cut off ${cut.join(" and ")}; point at the curve to see its ends.`);
  }
  else if (ok.length) words.push(`No interval: ${whyNoInterval()}.`);
  if (ok.some((point) => !point.trusted))
    words.push(`Dotted: ${facts.beyondModel}.`);
  const counts = new Map();
  for (const point of points) if (point.status !== "ok") counts.set(point.status, (counts.get(point.status) ?? 0) + 1);
  for (const [status, count] of counts)
    words.push(`${facts.statuses.find(({name}) => name === status)?.hasValue ? "Only a lower limit" : "No value"} at ${count} of ${counted(points.length, of)} (${status}): ${facts.why[status]?.why ?? ""}.`);
  return words.join(" ");
}

// ---- Measured surfaces ----------------------------------------------------------------------------------------------

function showCompass() {
  const at = place();
  const ways = facts.directions.map((angle) => facts.ways.findIndex((way) => way.angle === angle));
  const series = curves().map((curve) => ({...curve, points: ways.map((way) => frictionAt(curve.rule, state.dimension, state.load, at, way))}));
  const {angle} = facts.ways[state.way];
  drawCompass(byId("compass"), facts.directions, series, angle === null ? null : facts.directions.indexOf(angle),
    (point, degrees, name) => `${degrees}°: ${quoted(point)}${name ? `, ${name}` : ""}`);
  byId("compass-caption").textContent = `At ${[loadName(state.load), ...dimensionIfAny(), materialName()].join(", ")}. Angle: motion of the upper body. ` +
    `Shaded: ${PERCENT} ${intervalName(false)}. Click, or use the arrow keys, to pick a direction; double-click for the mean over all.`;
}

// ---- Tables ---------------------------------------------------------------------------------------------------------

const material = () => [state.mu0, state.tau0];

function curveRows(id, head) {
  const isFriction = !["area", "stiffness", "unloading"].includes(id);
  const names = ["result", head, isFriction ? "mu_s" : QUANTITY[id].title.replaceAll(/[_~]/g, ""), "lower", "upper", "interval", "status",
    "mu0", "tau0 (MPa)"];
  return () => [names, ...byId(id).drawn.series.flatMap(({name, points}) => points.map(({x, value, lower, upper, isCombined, status}) =>
    [name || facts.name, x, value, lower, upper, intervalName(isFriction && isCombined), status ?? "", ...material()]))];
}

const mapRows = () => [["fractal dimension", "load (mN)", state.quantity, "status", "within validity", "mu0", "tau0 (MPa)"],
  ...loads.flatMap((load, l) => cells.values.map((dimension, d) => [dimension, load, mapped.value[l][d] ?? NaN,
    mapped.status[l][d], mapped.trusted[l][d] ?? "", ...material()]))];

// ---- Controls -------------------------------------------------------------------------------------------------------

let sliders = {}; // sliders for mu0, tau0, load and dimension

function showStrengthNotice() {
  byId("strong").hidden = !(state.tau0 > facts.strength.limit);
  byId("strong").textContent = facts.strength.text;
}

/** Pick a dimension and a load. Return a function that undoes this choice. */
function pick(d, l) {
  const before = [state.dimension, state.load];
  // Reset the cell under the pointer here, because touch screens send no leave event.
  Object.assign(state, {dimension: d, load: l, pointed: null});
  sliders.dimension.set(d);
  sliders.load.set(l);
  redraw(...FRICTION);
  return () => pick(...before);
}

/** Select the value of mu0 or tau0 (MPa) that equals a number, and return whether the page has such a value. */
function selectParameter(name, number) {
  const position = parameters[name].values.findIndex((value) => isSame(value, number));
  if (position < 0) return false;
  state[name] = parameters[name].values[position];
  sliders[name].set(position);
  showStrengthNotice();
  redraw(...FRICTION);
  return true;
}

/** Set all controls to the values of one point of the study. */
function goTo({load, mu0, tau0: strength, cut_off: cutOff}) {
  selectParameter("mu0", mu0);
  selectParameter("tau0", 1000 * strength);
  pick(cutOff === undefined ? state.dimension : nearest(cells.values, cutOff), nearest(loads, load));
}

function connect() {
  const fields = addressFields();
  const whole = (text, count, fallback) => Math.floor(parseNumber(text, 0, count - 1, fallback));
  for (const name of parameters ? ["mu0", "tau0"] : []) {
    const {values} = parameters[name];
    state[name] = values[nearest(values, parseNumber(fields[name], 0, values.at(-1), state[name]))];
  }
  for (const [key, count] of [["rule", facts.rules.length], ["way", facts.ways.length], ["amplitude", facts.amplitudes.length],
    ["kind", facts.kinds.length]]) state[key] = whole(fields[key], count, state[key]);
  const changed = () => {
    showStrengthNotice();
    redraw(...FRICTION);
  };
  for (const [name, unit] of [["mu0", ""], ["tau0", " MPa"]])
    connectParameter(name, unit, changed);
  showStrengthNotice();
  const set = (key) => (value) => {
    state[key] = value;
    redraw(...FRICTION);
  };
  choice("rule", hasBothRules && !drawings.map ? [] : facts.rules.map(ruleName), state.rule, set("rule"));
  choice("way", facts.ways.map(({words}) => words.replace(/^the (mean over .*?)( all round| along [xy])?$/, "$1")), state.way, set("way"));
  choice("kind", facts.kinds, state.kind, set("kind"));
  byId("amplitude-label").textContent = `Amplitude (${facts.measure})`;
  choice("amplitude", facts.amplitudes, state.amplitude, set("amplitude"));
  byId("dimension-label").textContent = isMeasured ? "Cutoff wavelength" : facts.cell.label;
  byId("dimension-control").hidden = cells.values.length < 2;
  const d = Number(fields.d ?? NaN);
  if (Number.isFinite(d)) state.dimension = nearest(cells.values, d);
  sliders.dimension = index("dimension", {value: state.dimension, count: cells.values.length,
    name: (at) => cells.texts[at], changed: (at) => { state.dimension = at; redraw(...FRICTION); }});
  byId("link").addEventListener("click", async () => {
    await navigator.clipboard.writeText(location.href).then(() => { byId("link").textContent = "Copied"; }, () => { byId("link").textContent = location.href; });
  });
  window.addEventListener("resize", () => redraw(...Object.keys(drawings)));
  if (!loads.length) return;
  connectLoad(fields);
  connectMap(fields);
  for (const id of ["friction", "area", "stiffness", "unloading", "over"]) if (drawings[id]) connectCurve(id);
  if (drawings.compass) connectCompass();
  atRest = () => address(addressOf());
  showParameters();
  address(addressOf());
}

/** Connect the slider of mu0 or tau0, whose positions are the values that the library evaluated. */
function connectParameter(name, unit, changed) {
  const values = parameters?.[name].values ?? [0];
  sliders[name] = index(name, {value: Math.max(values.indexOf(state[name]), 0), count: values.length, name: (at) => `${values[at]}${unit}`,
    changed: (at) => { state[name] = values[at]; changed(); }});
}

function connectLoad(fields) {
  const at = parseNumber(fields.load, 1e-300, 1e300, NaN);
  if (Number.isFinite(at)) state.load = nearest(loads.map(Math.log), Math.log(at));
  sliders.load = index("load", {value: state.load, count: loads.length, name: loadName,
    changed: (l) => { state.load = l; redraw(...FRICTION); }});
}

/** Connect arrow keys to a plot, with a step for each key. */
function onArrows(place, steps, move) {
  place.addEventListener("keydown", (event) => {
    if (!(event.key in steps)) return;
    event.preventDefault();
    move(steps[event.key]);
  });
}

function connectMap(fields) {
  if (!drawings.map) return;
  const list = byId("quantity");
  for (const option of [...list.options]) if (!facts.maps.includes(option.value)) option.remove();
  if ([...list.options].some(({value}) => value === fields.show)) state.quantity = fields.show;
  list.value = state.quantity;
  list.addEventListener("change", () => {
    state.quantity = list.value;
    redraw("map");
  });
  const place = byId("map");
  toolbar(place, mapRows);
  const cell = (x, y) => {
    const d = edges(cells.values).findLastIndex((edge) => edge <= x);
    const l = edges(loads.map(Math.log)).findLastIndex((edge) => edge <= Math.log(y));
    return [Math.min(Math.max(d, 0), cells.values.length - 1), Math.min(Math.max(l, 0), loads.length - 1)];
  };
  const leave = () => {
    tip(place, "");
    if (state.pointed) { state.pointed = null; redraw("readout"); }
  };
  interactive(place, {
    point: (x, y, here) => {
      state.pointed = cell(x, y);
      redraw("readout");
      const [d, l] = state.pointed;
      tip(place, `${textOfCell(d, l)} at ${cells.texts[d]}, ${loadName(l)}`, here);
    },
    leave,
    pick: (x, y) => pick(...cell(x, y)),
    redrawn: () => redraw("map"),
  });
  onArrows(place, {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}, (step) => {
    pick(Math.min(Math.max(state.dimension + step[0], 0), cells.values.length - 1),
      Math.min(Math.max(state.load + step[1], 0), loads.length - 1));
  });
}

/** Return the value and interval of a map cell, or the status of the cell if it has no value. */
function textOfCell(d, l) {
  if (mapped.value[l][d] === null) return mapped.status[l][d];
  const point = mapped.points[l][d];
  return state.quantity === "width" ? printed(point) : coefficientText(point);
}

function connectCurve(id) {
  const place = byId(id);
  const over = id === "over";
  toolbar(place, curveRows(id, over ? facts.cell.name : "load (mN)"), {hasScales: true});
  const all = () => (over ? cells.values : loads.map(Math.log));
  const pickAt = (at) => (over ? pick(at, state.load) : pick(state.dimension, at));
  interactive(place, {
    point: (x, _, here) => {
      const words = place.drawn.series.map(({points, name}) => {
        const of = points[nearest(points.map((p) => (over ? p.x : Math.log(p.x))), over ? x : Math.log(x))];
        return {at: of.x, text: `${Number.isFinite(of.value) ? coefficientText(of) : of.status}${name ? `, ${name}` : ""}`};
      });
      tip(place, words.length ? `${words.map(({text}) => text).join("; ")} at ${over ? cells.texts[cells.values.indexOf(words[0].at)] : loadName(loads.indexOf(words[0].at))}` : "", here);
    },
    leave: () => tip(place, ""),
    pick: (x) => pickAt(nearest(all(), over ? x : Math.log(x))),
    redrawn: () => redraw(id),
  });
  onArrows(place, {ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1}, (step) => {
    pickAt(Math.min(Math.max((over ? state.dimension : state.load) + step, 0), all().length - 1));
  });
}

function connectCompass() {
  const compass = byId("compass");
  toolbar(compass, curveRows("compass", "direction (degrees)"), {hasAxes: false});
  const count = facts.directions.length;
  const set = (way) => {
    state.way = byId("way").value = way;
    redraw(...FRICTION);
  };
  const wayOf = (d) => facts.ways.findIndex(({directions}) => directions.length === 1 && directions[0] === d);
  onArrows(compass, {ArrowLeft: 1, ArrowUp: 1, ArrowRight: -1, ArrowDown: -1}, (step) => {
    const now = facts.ways[state.way].directions;
    set(wayOf(now.length > 1 ? 0 : (now[0] + step + count) % count));
  });
  compass.addEventListener("pointermove", (event) => tipOfNearest(compass, positionIn(compass, event)));
  compass.addEventListener("pointerleave", () => tip(compass, ""));
  compass.addEventListener("click", (event) => {
    const [x, y] = positionIn(compass, event);
    const {centre} = compass.axes;
    const angle = (Math.atan2(centre[1] - y, x - centre[0]) * 180) / Math.PI;
    const difference = (direction) => Math.abs(((direction - angle + 540) % 360) - 180);
    set(wayOf(facts.directions.reduce((best, direction, d) => (difference(direction) < difference(facts.directions[best]) ? d : best), 0)));
  });
  compass.addEventListener("dblclick", () => { if (facts.ways[0].directions.length > 1) set(0); });
}

function addressOf() {
  const values = {mu0: state.mu0, tau0: state.tau0, d: cells.values[state.dimension], load: loads[state.load]};
  for (const [key, list] of [["rule", facts.rules], ["way", facts.ways], ["amplitude", facts.amplitudes], ["kind", facts.kinds]])
    if (list.length > 1) values[key] = state[key];
  if (state.quantity !== "friction") values.show = state.quantity;
  return values;
}

// ---- Start ----------------------------------------------------------------------------------------------------------

async function unpackAll() {
  numbers.floats = doubles(await unpacked("floats"), facts.leading);
  numbers.small = new Int8Array((await unpacked("small")).buffer);
}

/** Hide plots and controls for which the result has no values. */
function hideUnavailable() {
  const isMissing = {
    map: isMeasured || !loads.length,
    readout: !loads.length,
    over: isMeasured || cells.values.length < 2 || !loads.length,
    friction: !loads.length,
    area: !loads.length || !hasQuantity("area"),
    stiffness: !loads.length || !hasQuantity("stiffness"),
    unloading: !isMeasured || !hasQuantity("unloading"),
    compass: facts.directions.length < 3 || !loads.length,
  };
  for (const id of Object.keys(isMissing).filter((name) => isMissing[name])) {
    byId(id === "readout" ? "top" : id).closest("section, .panel").hidden = true;
    delete drawings[id];
  }
  byId("top").classList.toggle("alone", isMissing.map && !byId("top").querySelector(".figure"));
  if (isMeasured) {
    byId("main").classList.add("pair");
    byId("top").after(byId("controls"));
    byId("numbers").hidden = false;
    byId("numbers").append(byId("figures"), byId("sentence"));
  }
  byId("more").addEventListener("toggle", () => redraw(...Object.keys(drawings)));
  byId(isMeasured ? "of-ensembles" : "of-members").hidden = true;
  byId("exact").hidden = !facts.ranged;
}

start(async () => {
  await unpackAll();
  drawings = {map: showMap, readout: showReadout, over: showOver, friction: () => showCurve("friction"),
    area: () => showCurve("area"), stiffness: () => showCurve("stiffness"), unloading: () => showCurve("unloading"), compass: showCompass};
  hideUnavailable();
  if (!loads.length) {
    showNotice("No pair of this study touches within its approaches, so there is no load, area or friction to show.");
    byId("controls").hidden = true;
  } else if (facts.steps === 1 && !isMeasured) {
    showNotice("This study has a single approach. Values at a load are interpolated between approaches, so there are none.");
  }
  connect();
  Object.keys(drawings).forEach((place) => drawings[place]());
});
