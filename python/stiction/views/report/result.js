// The page of a result: its state, its controls, and its words.

// ---- State ----------------------------------------------------------------------------------------------------------

const middle = (list) => list[Math.floor(list.length / 2)];
const isMeasured = facts.reading === "elastic";
const state = {
  mu0: isMeasured ? facts.mu0[0] : middle(facts.mu0),
  tau0: facts.tau0[0], // MPa
  rule: 0,
  way: 0,
  kind: 0,
  amplitude: 0,
  // Of two readings of a scan the one whose interval covers both.
  dimension: isMeasured ? Math.max(0, facts.dimensions.indexOf(facts.answers.find(({covered}) => !covered)?.at.cut_off))
    : Math.floor(facts.dimensions.length / 2),
  load: 0,
  quantity: "friction",
  pointed: null, // (dimension, load) under the pointer
};
const loads = isMeasured ? facts.steps : facts.loads.length ? geometric(...facts.loads, facts.loadSteps) : [];
let motions = [];
let mapped = null;
let colours = [0.1, 1];
const tau0 = () => state.tau0 / 1000; // GPa
const RULE_COLOURS = {all: "var(--all)", opposing: "var(--opposing)"};

const FRICTION = ["map", "readout", "over", "friction", "area", "stiffness", "unloading", "compass"];
const hasBothRules = facts.rules.length > 1;

/** The result by a sliding rule, in the picked direction, and where in it what is picked lies. */
function picked(rule = facts.rules[state.rule], isPointed = true) {
  const {directions} = facts.ways[state.way];
  const chosen = directions.map((d) => facts.rules.indexOf(rule) * facts.directions.length + d);
  return {
    result: {facts, ...motions[chosen[0]], motions, chosen, kind: state.kind, members: facts.kinds[state.kind].members}, directions,
    d: (isPointed ? state.pointed?.[0] : null) ?? state.dimension, a: state.amplitude,
  };
}

/** What is drawn as one curve each. */
const curves = () => (hasBothRules ? facts.rules : [facts.rules[state.rule]])
  .map((rule) => ({rule, colour: RULE_COLOURS[rule], name: hasBothRules ? ruleName(rule) : ""}));

// ---- Words ----------------------------------------------------------------------------------------------------------

const ruleName = (rule) => (rule === "all" ? "all contacts rub" : "only climbing contacts rub");
const dimensionName = (value) => (isMeasured ? (value > 0 ? `cut-off ${withUnit(value, "um")}` : "no cut-off") : `D = ${value.toFixed(3)}`);
const loadName = (l) => withUnit(loads[l], "mN") + (facts.area ? ` (${withUnit(loads[l] / facts.area, "GPa")})` : "");
const lengthName = (value) => withUnit(value, "um");
const materialName = () => `μ0 = ${state.mu0}, τ0 = ${state.tau0} MPa`;
const dimensionIfAny = () => (facts.dimensions.length > 1 || !isMeasured ? [dimensionName(facts.dimensions[state.dimension])] : []);
const amplitudeIfAny = () => (isMeasured ? [] : [`amplitude ${lengthName(facts.amplitudes[state.amplitude])}`]);
const wayName = () => `the upper body moves ${facts.ways[state.way].words}`;
const motionWords = () => (facts.ways[state.way].directions.length > 1 ? facts.ways[state.way].words : wayName());
const counted = (count, thing) => `${count} ${thing}${count === 1 ? "" : "s"}`;

function sayParameters() {
  byId("parameters").textContent = [`${materialName()}`, ...(loads.length ? [`load ${loadName(state.load)}`] : []),
    ...dimensionIfAny(), ...amplitudeIfAny(), motionWords()].join(", ") + ".";
}

// ---- The answer -----------------------------------------------------------------------------------------------------

function showReadout() {
  sayParameters();
  const load = loads[state.pointed?.[1] ?? state.load];
  const dimension = facts.dimensions[state.pointed?.[0] ?? state.dimension];
  const where = [...(isMeasured && facts.dimensions.length < 2 ? [] : [dimensionName(dimension)]), loadName(state.pointed?.[1] ?? state.load), motionWords()];
  const answers = [element("p", {class: "hint"}, `${state.pointed ? "Under the pointer" : "At"}: ${where.join(", ")}`)];
  const points = curves().map((curve) => {
    const {result, d, a, directions} = picked(curve.rule);
    const [at] = withCombined(readOff(result, "friction", d, a, [load], state.mu0, tau0()), curve.rule, () => d);
    return {...curve, result, d, a, at,
      alone: slopesAlone(result, d, directions, curve.rule, state.mu0, tau0())};
  });
  const judged = judgement(points, load, dimension);
  for (const [i, {at, colour, rule, alone}] of points.entries()) {
    answers.push(element("p", {class: i ? "of other" : "of", style: `color: ${colour}`}, facts.ruleWords[rule]), ...answerOf(at, rule, judged.saysSlopes ? NaN : alone));
    if (judged.said?.parts && rule === "all" && at.isCombined) answers.push(barOf(judged.said, at.value), ...(judged.said.most ? [element("p", {class: "hint"}, judged.said.most)] : []));
  }
  if (points.length > 1 && isMeasured)
    answers.push(element("p", {class: "hint"}, "Where μ0 was measured on smooth faces, all contacts rub; which rule holds elsewhere is not known."));
  const [{at}] = points;
  const {status, value, lower, upper} = at;
  Object.assign(byId("readout").dataset, {dimension, load, mu0: state.mu0, tau0: tau0(), status, value, lower, upper});
  byId("answer").replaceChildren(...answers);
  byId("judgement").replaceChildren(...judged.elements);
  byId("sentence").replaceChildren(...judged.more);
  byId("figures").replaceChildren(figuresOf(points[0], load));
}

const isSame = (one, other) => Math.abs(one - other) <= 1e-9 * Math.max(Math.abs(one), Math.abs(other), 1e-300);
const isAllRound = () => facts.ways[state.way].directions.length === facts.directions.length;

/** Points of friction by a rule at cut-offs, with the combined intervals of the library where it has evaluated them: at
 * mu0 and tau0 of the study, over all directions, of the first kind of members. */
function withCombined(points, rule, dimensionOf) {
  const table = isAllRound() && state.kind === 0
    ? facts.combined.find((each) => each.rule === rule && isSame(each.mu0, state.mu0) && isSame(each.tau0, tau0())) : null;
  return points.map((point) => {
    const ends = table?.ends[dimensionOf(point)]?.[stepOf(facts, point.load)];
    return point.status === "ok" && ends?.every(Number.isFinite) ? {...point, lower: ends[0], upper: ends[1], isCombined: true} : point;
  });
}

/** What holds the bodies as one bar, mu0, tau0 on the true area and slopes, with the interval of everything known. */
function barOf({parts, intervals}, value) {
  const [low, high] = intervals.all;
  const most = 1.05 * Math.max(value, high);
  const percent = (part) => `${(100 * part) / most}%`;
  const bar = shape("svg", {class: "bar", role: "img", width: "100%", height: 34});
  let from = 0;
  const names = ["μ0", "τ0 on the true area", "slopes"];
  const colours = ["accent", "area", "opposing"].map((name) => `var(--${name})`);
  parts.forEach((part, index) => {
    const begin = part < 0 ? from + part : from;
    bar.append(shape("rect", {x: percent(begin), y: 6, width: percent(Math.abs(part)), height: 16, fill: colours[index]}));
    from += part;
  });
  bar.append(shape("line", {x1: percent(low), x2: percent(high), y1: 14, y2: 14, stroke: "var(--ink)", "stroke-width": 2}));
  for (const end of [low, high]) bar.append(shape("line", {x1: percent(end), x2: percent(end), y1: 8, y2: 20, stroke: "var(--ink)", "stroke-width": 2}));
  const said = parts.map((part, index) => `${index ? (part <= -0.0005 ? " \u2212 " : " + ") : ""}${Math.abs(part).toFixed(3)} (${names[index]})`);
  bar.setAttribute("aria-label", `${said.join("")}; interval ${low.toFixed(3)} to ${high.toFixed(3)}`);
  return element("div", {}, bar, element("p", {class: "hint"}, ...said.map((text, index) => element("span", {style: `color: ${colours[index]}; font-weight: 600`}, text))));
}

function answerOf(at, rule, alone) {
  if (at.status !== "ok")
    return [element("p", {class: "value"}, at.status), element("p", {class: "interval"}, facts.statuses[at.status]?.why ?? "")];
  const {lower, upper} = at;
  const text = quoted(at.value, lower, upper);
  const [value, ends] = text.split(/ (?=\[)/);
  const of = `${PERCENT} ${intervalName(at.isCombined)} `;
  return [
    element("p", {class: "value", "data-rule": rule}, element("i", {}, "μ"), element("sub", {}, "s"), " = ", data(at.value, value)),
    element("p", {class: "interval"}, ...(ends
      ? [of, element("span", {"data-lower": lower, "data-upper": upper}, ends)]
      : [`No interval: ${whyNoInterval()}`])),
    ...(Number.isFinite(alone) ? [element("p", {class: "hint"}, "The slopes alone predict ", data(alone, quoted(alone)))] : []),
  ];
}

/** Name of an interval; of generated surfaces there is nothing but the sampling of repetitions. */
function intervalName(isCombined) {
  if (!isMeasured) return "interval";
  return isCombined ? "interval, combined uncertainty" : "interval of the sampling of positions alone";
}

function whyNoInterval() {
  if (isMeasured) return "too few members have an answer, or all are equal";
  if (facts.repetitions === 1) return "there is one repetition";
  if (!facts.hasIntervals) return "there are too many repetitions for a page; the library has it";
  return "fewer than two repetitions carry load";
}

/** The verdict, and its reasons: the library's where it has spoken, at the points that were asked for. */
function judgement(points, load, dimension) {
  const saying = (elements, saysSlopes = false, said = null) => ({elements, saysSlopes, said,
    more: said ? [element("p", {class: "sentence"}, said.sentence), ...(saysSlopes ? [element("p", {class: "hint"}, said.slopes)] : [])] : []});
  if (!isMeasured) {
    const {result, d, a, at} = points.find(({rule}) => rule === facts.quotedRule) ?? points[0];
    if (!facts.hasIntervals && facts.repetitions > 1)
      return saying([element("p", {class: "hint"}, "There are too many repetitions for intervals on a page; `stiction at` has them and the verdict.")]);
    const area = readOff(result, "area", d, a, [load], state.mu0, tau0())[0].value;
    const doubts = doubtsOfEnsemble(facts, at, area);
    return saying(saidVerdict(verdictOf(facts, doubts), doubts));
  }
  const said = facts.answers.find(({at}) => isSame(at.load, load) && isSame(at.mu0, state.mu0) && isSame(at.tau0, tau0()) &&
    (at.cut_off === undefined || isSame(at.cut_off, dimension)));
  if (said) return saying(saidVerdict(said.verdict, said.doubts), isAllRound() && said.slopes !== "", isAllRound() ? said : null);
  const near = facts.answers.reduce((best, each) => {
    const apart = ({at}) => Math.abs(Math.log(at.load / load)) + (at.cut_off !== undefined && !isSame(at.cut_off, dimension) ? 10 : 0);
    return !best || apart(each) < apart(best) ? each : best;
  }, null);
  const back = element("button", {type: "button"}, "Back to what was asked for");
  back.addEventListener("click", () => goTo(near.at));
  return saying(near ? [element("p", {class: "hint"}, `The verdict is about the loads, μ0 and τ0 that the study asks for; at ` +
    `${withUnit(near.at.load, "mN")} it is: ${near.verdict}. `, back)] : []);
}

const MOST_DOUBTS = 3; // that are open below the verdict

function saidVerdict(verdict, doubts) {
  const kind = KIND[verdict];
  const list = (some) => (some.length ? [element("ul", {class: "doubts"}, ...some.map(({text, cure, severity}) =>
    element("li", {class: severity}, `${text.replace(/^[a-z]/, (one) => one.toUpperCase())}; ${cure}.`)))] : []);
  const rest = doubts.slice(MOST_DOUBTS);
  return [element("div", {class: `said ${kind}`}, element("p", {class: `verdict ${kind}`}, verdict), ...list(doubts.slice(0, MOST_DOUBTS)),
    ...(rest.length ? [element("details", {}, element("summary", {}, `${rest.length} more`), ...list(rest))] : []))];
}

function figuresOf({result, d, a, at}, load) {
  const list = element("dl", {});
  const row = (words, value, text, isBeyond = false) => list.append(element("dt", {}, words),
    element("dd", isBeyond ? {class: "beyond"} : {}, isBeyond ? "⚠ " : "", data(value, text)));
  if (at.status !== "ok") list.append(element("dt", {}, "Status"), element("dd", {class: "status"}, at.status));
  if (isMeasured) {
    for (const {name, words, unit, limit} of facts.quantities) {
      const of = readOff(result, name, d, a, [load], state.mu0, tau0())[0];
      if (Number.isFinite(of.value)) row(words, of.value, intervalWithUnit(of.value, of.lower, of.upper, unit), limit !== null && of.value > limit);
    }
    row("Members with an answer", at.answered, `${at.answered} of ${at.all}`);
    return list;
  }
  if (at.status === "ok") for (const [quantity, words, unit] of [["area", "True contact area", "µm²"], ["stiffness", "Normal stiffness", "mN/µm"]]) {
    if (quantity === "stiffness" && !facts.hasStiffness) continue;
    const of = readOff(result, quantity, d, a, [load], state.mu0, tau0())[0];
    row(words, of.value, `${quoted(of.value, of.lower, of.upper)}\u00a0${unit}`);
  }
  for (const [name, value] of Object.entries(at.validity ?? {})) {
    const {words, limit, isShare} = facts.validity[name];
    row(words, value, isShare && Number.isFinite(value) ? `${(100 * value).toFixed(0)} %` : shown(value, 2), value > limit);
  }
  return list;
}

// ---- The map --------------------------------------------------------------------------------------------------------

const TITLES = {friction: "_μ_~s~", width: "±", area: "_A_ (µm²)", stiffness: "mN/µm"};

function showMap() {
  const {result, a, d} = picked(undefined, false);
  mapped = mapOf(result, state.quantity, a, loads, state.mu0, tau0());
  const legend = drawMap(byId("map"), {
    facts, map: mapped, loads, colours, picked: [d, state.load],
    ticks: state.quantity === "friction" ? facts.ticks : null, title: TITLES[state.quantity],
  });
  byId("legend").replaceChildren(...legend.map(([picture, words]) => element("li", {}, picture, words)));
}

// ---- Curves ---------------------------------------------------------------------------------------------------------

const QUANTITY = {
  friction: {title: "coefficient of static friction _μ_~s~", isLog: false, of: "friction", factor: 1},
  area: isMeasured
    ? {title: "true contact area _A_/_A_~0~ (%)", isLog: true, of: "contact_area_fraction", factor: 100}
    : {title: "true contact area _A_ (µm²)", isLog: true, of: "area", factor: 1},
  stiffness: isMeasured
    ? {title: "normal stiffness over area (GPa/mm)", isLog: true, of: "stiffness_per_area", factor: 1}
    : {title: "normal stiffness (mN/µm)", isLog: true, of: "stiffness", factor: 1},
  unloading: {title: "normal stiffness over area (GPa/mm)", isLog: true, of: "unloading_stiffness_per_area", factor: 1},
};

const hasQuantity = (id) => (isMeasured ? facts.quantities.some(({name}) => name === QUANTITY[id].of) : id !== "stiffness" || facts.hasStiffness);

/** One curve for each of `curves`; one of what has nothing to do with friction. */
function seriesOf(id, points) {
  const {factor} = QUANTITY[id];
  const drawn = isMeasured && id !== "friction" ? [{...curves()[0], name: "", colour: "var(--area)"}] : curves();
  return drawn.map((curve) => ({...curve, points: points(curve.rule).map((point) => (
    {...point, value: factor * point.value, lower: factor * point.lower, upper: factor * point.upper}))}));
}

function showCurve(id) {
  const series = seriesOf(id, (rule) => {
    const {result, d, a} = picked(rule, false);
    const points = readOff(result, QUANTITY[id].of, d, a, loads, state.mu0, tau0());
    return (id === "friction" ? withCombined(points, rule, () => d) : points).map((point) => ({...point, x: point.load}));
  });
  const levels = id === "friction" && isMeasured ? series.map(({rule, colour}) => {
    const {result, d, directions} = picked(rule, false);
    return {value: slopesAlone(result, d, directions, rule, state.mu0, tau0()), colour, name: `by slope alone, ${rule}`};
  }).filter(({value}) => Number.isFinite(value)) : [];
  const room = isMeasured ? 1.15 : 1;
  const x = {low: loads[0] / room, high: loads.at(-1) * room, isLog: true, title: `normal load _F_~N~ (mN)${isMeasured ? `; 1 mN is ${shown(1000 / facts.area)} MPa` : ""}`};
  const drawn = drawCurves(byId(id), series, x, {...QUANTITY[id], picked: loads[state.load], levels});
  byId(`${id}-caption`).textContent = curveCaption(series, [...dimensionIfAny(), ...amplitudeIfAny()], drawn, "load");
}

function showOver() {
  const load = loads[state.load];
  const series = seriesOf("friction", (rule) => {
    const {result, a} = picked(rule, false);
    return withCombined(overDimensions(result, "friction", a, load, state.mu0, tau0()), rule, ({dimension}) => facts.dimensions.indexOf(dimension))
      .map((point) => ({...point, x: point.dimension}));
  });
  const ends = isMeasured ? [facts.dimensions[0], facts.dimensions.at(-1)] : [edges(facts.dimensions)[0], edges(facts.dimensions).at(-1)];
  const drawn = drawCurves(byId("over"), series, {low: ends[0], high: ends[1], title: facts.cell.title},
    {...QUANTITY.friction, picked: facts.dimensions[state.dimension]});
  byId("over-caption").textContent = curveCaption(series, [loadName(state.load), ...amplitudeIfAny()], drawn, isMeasured ? "cut-off" : "dimension");
}

function curveCaption(series, where, [low, high], of) {
  const points = series.flatMap((each) => each.points);
  const ok = points.filter((point) => point.status === "ok");
  const words = [`At ${[...where, materialName()].join(", ")}; ${motionWords()}${hasBothRules ? "" : `, ${ruleName(facts.rules[0])}`}.`];
  if (ok.length && ok.every((point) => Number.isFinite(point.lower))) {
    words.push(`Shaded: ${PERCENT} ${intervalName(ok.every((point) => point.isCombined))}.`);
    const cut = [];
    if (ok.some((point) => point.upper > high)) cut.push("above");
    if (ok.some((point) => point.lower < low)) cut.push("below");
    if (cut.length) words.push(`It is cut off ${cut.join(" and ")}; pointing at the curve tells its ends.`);
  }
  else if (ok.length) words.push(`No interval: ${whyNoInterval()}.`);
  if (ok.some((point) => !point.trusted))
    words.push("Dotted: over half of the load beyond Hertz, or on radii below the grid spacing.");
  const counts = new Map();
  for (const point of points) if (point.status !== "ok") counts.set(point.status, (counts.get(point.status) ?? 0) + 1);
  for (const [status, count] of counts)
    words.push(`No value at ${count} of ${counted(points.length, of)} (${status}): ${facts.statuses[status]?.why ?? ""}.`);
  return words.join(" ");
}

// ---- Measured surfaces ----------------------------------------------------------------------------------------------

function showCompass() {
  const series = curves().map((curve) => {
    const {result, d, a} = picked(curve.rule, false);
    const first = facts.rules.indexOf(curve.rule) * facts.directions.length;
    return {...curve, points: facts.directions.map((_, way) => readOff({...result, ...motions[first + way], chosen: [first + way]}, "friction", d, a, [loads[state.load]], state.mu0, tau0())[0])};
  });
  const {directions} = facts.ways[state.way];
  drawCompass(byId("compass"), facts.directions, series, directions.length === 1 ? directions[0] : null,
    ({value, lower, upper}, angle, name) => `${angle}°: ${quoted(value, lower, upper)}${name ? `, ${name}` : ""}`);
  byId("compass-caption").textContent = `At ${[loadName(state.load), ...dimensionIfAny(), materialName()].join(", ")}. Angle: motion of the upper body. ` +
    `Shaded: ${PERCENT} ${intervalName(false)}. Click, or use the arrow keys, to pick a direction; double-click for the mean over all.`;
}

// ---- Tables ---------------------------------------------------------------------------------------------------------

const material = () => [state.mu0, state.tau0];

function curveRows(id, head) {
  const names = ["result", head, ["area", "stiffness", "unloading"].includes(id) ? QUANTITY[id].title.replaceAll(/[_~]/g, "") : "mu_s", "lower", "upper", "status",
    "mu0", "tau0 (MPa)"];
  return () => [names, ...byId(id).drawn.series.flatMap(({name, points}) => points.map(({x, value, lower, upper, status}) =>
    [name || facts.name, x, value, lower, upper, status ?? "", ...material()]))];
}

const mapRows = () => [["fractal dimension", "load (mN)", state.quantity, "status", "within validity", "mu0", "tau0 (MPa)"],
  ...loads.flatMap((load, l) => facts.dimensions.map((dimension, d) => [dimension, load, mapped.value[l][d] ?? NaN,
    mapped.status[l][d], mapped.trusted[l][d] ?? "", ...material()]))];

// ---- Controls -------------------------------------------------------------------------------------------------------

let sliders = {}; // of load and dimension

function sayIfStrong() {
  const isStrong = state.tau0 > facts.tau0Sane;
  byId("strong").hidden = !isStrong;
  byId("strong").textContent = `τ0 is above a tenth of the effective modulus, ${shown(facts.tau0Sane, 3)} MPa.`;
}

/** Pick a dimension and a load; returns what undoes it. */
function pick(d, l) {
  const before = [state.dimension, state.load];
  Object.assign(state, {dimension: d, load: l, pointed: null}); // a finger that taps never leaves
  sliders.dimension.set(d);
  sliders.load.set(l);
  redraw(...FRICTION);
  return () => pick(...before);
}

/** Set everything to a point that was asked for. */
function goTo({load, mu0, tau0: strength, cut_off: cutOff}) {
  for (const [id, value] of [["mu0", mu0], ["tau0", Number((1000 * strength).toPrecision(12))]]) {
    byId(`${id}-number`).value = value;
    byId(`${id}-number`).dispatchEvent(new Event("input"));
  }
  pick(cutOff === undefined ? state.dimension : nearest(facts.dimensions, cutOff), nearest(loads, load));
}

function connect() {
  const said = addressed();
  const whole = (text, count, otherwise) => Math.floor(numberOf(text, 0, count - 1, otherwise));
  state.mu0 = numberOf(said.mu0, 0, 1e3, state.mu0);
  state.tau0 = numberOf(said.tau0, 0, 1e9, state.tau0);
  for (const [key, count] of [["rule", facts.rules.length], ["way", facts.ways.length], ["amplitude", facts.amplitudes.length],
    ["kind", facts.kinds.length]]) state[key] = whole(said[key], count, state[key]);
  const changed = () => {
    sayIfStrong();
    redraw(...FRICTION);
  };
  amount("mu0", {value: state.mu0, most: facts.mu0Most, step: 0.01, unit: "",
    changed: (value) => { state.mu0 = value; changed(); }});
  amount("tau0", {value: state.tau0, most: facts.tau0Most, step: Number((facts.tau0Most / 200).toPrecision(1)), unit: " MPa",
    changed: (value) => { state.tau0 = value; changed(); }});
  sayIfStrong();
  const set = (key) => (value) => {
    state[key] = value;
    redraw(...FRICTION);
  };
  choice("rule", hasBothRules && !drawings.map ? [] : facts.rules.map(ruleName), state.rule, set("rule"));
  choice("way", facts.ways.map(({words}) => words), state.way, set("way"));
  choice("kind", facts.kinds.map(({words}) => words), state.kind, set("kind"));
  byId("amplitude-label").textContent = `Amplitude (${facts.measure === "height" ? "total height" : facts.measure})`;
  choice("amplitude", facts.amplitudes.map(lengthName), state.amplitude, set("amplitude"));
  byId("dimension-label").textContent = isMeasured ? "Cut-off wavelength" : `Fractal dimension D${facts.convention}`;
  byId("dimension-control").hidden = facts.dimensions.length < 2;
  const d = Number(said.d ?? NaN);
  if (Number.isFinite(d)) state.dimension = nearest(facts.dimensions, d);
  sliders.dimension = index("dimension", {value: state.dimension, count: facts.dimensions.length,
    name: (at) => dimensionName(facts.dimensions[at]), changed: (at) => { state.dimension = at; redraw(...FRICTION); }});
  byId("link").addEventListener("click", async () => {
    await navigator.clipboard.writeText(location.href).then(() => { byId("link").textContent = "Copied"; }, () => { byId("link").textContent = location.href; });
  });
  window.addEventListener("resize", () => redraw(...Object.keys(drawings)));
  if (!loads.length) return;
  connectLoad(said);
  connectMap(said);
  for (const id of ["friction", "area", "stiffness", "unloading", "over"]) if (drawings[id]) connectCurve(id);
  if (drawings.compass) connectCompass();
  atRest = () => {
    if (drawings.map) settleMap();
    address(addressOf());
  };
  if (drawings.map) beginMap(said, Number.isFinite(d));
  sayParameters();
}

function connectLoad(said) {
  const at = numberOf(said.load, 1e-300, 1e300, isMeasured ? facts.asked[0] : NaN);
  state.load = Number.isFinite(at) ? nearest(loads.map(Math.log), Math.log(at)) : Math.floor(loads.length / 2);
  sliders.load = index("load", {value: state.load, count: loads.length, name: loadName,
    changed: (l) => { state.load = l; redraw(...FRICTION); }});
}

/** What arrow keys do on a plot: a step for each. */
function onArrows(place, steps, move) {
  place.addEventListener("keydown", (event) => {
    if (!(event.key in steps)) return;
    event.preventDefault();
    move(steps[event.key]);
  });
}

function connectMap(said) {
  if (!drawings.map) return;
  const list = byId("quantity");
  const lacking = [...(facts.hasIntervals ? [] : ["width"]), ...(facts.hasStiffness ? [] : ["stiffness"])];
  for (const option of [...list.options]) if (lacking.includes(option.value)) option.remove();
  if ([...list.options].some(({value}) => value === said.show)) state.quantity = said.show;
  list.value = state.quantity;
  list.addEventListener("change", () => {
    state.quantity = list.value;
    redraw("map");
  });
  slow = (place) => place === "map" && state.quantity === "width";
  const place = byId("map");
  toolbar(place, mapRows);
  const cell = (x, y) => {
    const d = edges(facts.dimensions).findLastIndex((edge) => edge <= x);
    const l = edges(loads.map(Math.log)).findLastIndex((edge) => edge <= Math.log(y));
    return [Math.min(Math.max(d, 0), facts.dimensions.length - 1), Math.min(Math.max(l, 0), loads.length - 1)];
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
      const value = mapped.value[l][d];
      tip(place, `${value === null ? mapped.status[l][d] : shown(value, 3)} at ${dimensionName(facts.dimensions[d])}, ${withUnit(loads[l], "mN")}`, here);
    },
    leave,
    pick: (x, y) => pick(...cell(x, y)),
    redrawn: () => redraw("map"),
  });
  onArrows(place, {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}, (step) => {
    pick(Math.min(Math.max(state.dimension + step[0], 0), facts.dimensions.length - 1),
      Math.min(Math.max(state.load + step[1], 0), loads.length - 1));
  });
}

/** Where the map begins: at what the address says, or at the sound cell whose interval is narrowest. */
function beginMap(said, isAddressed) {
  showMap();
  const {result, a} = picked();
  const widths = facts.hasIntervals ? mapOf(result, "width", a, loads, state.mu0, tau0()).value : null;
  const [d, l] = beginning(mapped, widths);
  if (!isAddressed) sliders.dimension.set(state.dimension = d);
  if (said.load === undefined) sliders.load.set(state.load = l);
  colours = colourRange(facts, mapped);
  address(addressOf());
}

/** Draw the map, at rest, in colours that fit it. */
function settleMap() {
  if (wanted.has("map")) showMap();
  wanted.delete("map");
  const fitted = colourRange(facts, mapped);
  if (String(fitted) === String(colours)) return;
  colours = fitted;
  showMap();
}

function connectCurve(id) {
  const place = byId(id);
  const over = id === "over";
  toolbar(place, curveRows(id, over ? facts.cell.name : "load (mN)"), {hasScales: true});
  const all = () => (over ? facts.dimensions : loads.map(Math.log));
  const take = (at) => (over ? pick(at, state.load) : pick(state.dimension, at));
  interactive(place, {
    point: (x, _, here) => {
      const words = place.drawn.series.map(({points, name}) => {
        const of = points[nearest(points.map((p) => (over ? p.x : Math.log(p.x))), over ? x : Math.log(x))];
        return {at: of.x, text: `${of.status === "ok" ? quoted(of.value, of.lower, of.upper) : of.status}${name ? `, ${name}` : ""}`};
      });
      tip(place, words.length ? `${words.map(({text}) => text).join("; ")} at ${over ? dimensionName(words[0].at) : withUnit(words[0].at, "mN")}` : "", here);
    },
    leave: () => tip(place, ""),
    pick: (x) => take(nearest(all(), over ? x : Math.log(x))),
    redrawn: () => redraw(id),
  });
  onArrows(place, {ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1}, (step) => {
    take(Math.min(Math.max((over ? state.dimension : state.load) + step, 0), all().length - 1));
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
    const apart = (one) => Math.abs(((one - angle + 540) % 360) - 180);
    set(wayOf(facts.directions.reduce((best, each, d) => (apart(each) < apart(facts.directions[best]) ? d : best), 0)));
  });
  compass.addEventListener("dblclick", () => { if (facts.ways[0].directions.length > 1) set(0); });
}

function addressOf() {
  const values = {mu0: state.mu0, tau0: state.tau0, d: facts.dimensions[state.dimension], load: loads[state.load]};
  for (const [key, list] of [["rule", facts.rules], ["way", facts.ways], ["amplitude", facts.amplitudes], ["kind", facts.kinds]])
    if (list.length > 1) values[key] = state[key];
  if (state.quantity !== "friction") values.show = state.quantity;
  return values;
}

// ---- Beginning ------------------------------------------------------------------------------------------------------

async function unpackAll() {
  const {variables, perRepetition, rules, directions} = facts;
  const count = rules.length * directions.length;
  const [means, sums] = [parts(variables, count, await unpacked("means")), parts(perRepetition, count, await unpacked("sums"))];
  motions = means.map((each, m) => ({means: each, sums: sums[m]}));
}

/** Take away what a result has nothing for. */
function hideOthers() {
  const lacking = {
    map: isMeasured || !loads.length,
    readout: !loads.length,
    over: facts.dimensions.length < 2 || !loads.length,
    friction: !loads.length,
    area: !loads.length || !hasQuantity("area"),
    stiffness: !loads.length || !hasQuantity("stiffness"),
    unloading: !isMeasured || !hasQuantity("unloading"),
    compass: facts.directions.length < 3 || !loads.length,
  };
  for (const id of Object.keys(lacking).filter((each) => lacking[each])) {
    byId(id === "readout" ? "top" : id).closest("section, .panel").hidden = true;
    delete drawings[id];
  }
  byId("top").classList.toggle("alone", lacking.map && !byId("top").querySelector(".figure"));
  if (isMeasured) {
    byId("main").classList.add("pair");
    byId("top").after(byId("controls"));
    byId("numbers").hidden = false;
    byId("numbers").append(byId("figures"), byId("sentence"));
  }
  byId("more").addEventListener("toggle", () => redraw(...Object.keys(drawings)));
  byId(isMeasured ? "of-ensembles" : "of-members").hidden = true;
  byId("over-title").textContent = `Friction coefficient over ${isMeasured ? "cut-off wavelength" : "fractal dimension"}`;
}

start(async () => {
  await unpackAll();
  drawings = {map: showMap, readout: showReadout, over: showOver, friction: () => showCurve("friction"),
    area: () => showCurve("area"), stiffness: () => showCurve("stiffness"), unloading: () => showCurve("unloading"), compass: showCompass};
  hideOthers();
  if (!loads.length) {
    say("No pair of this study touches within its approaches: there is no load, no area and no friction to show.");
    byId("controls").hidden = true;
  } else if (facts.steps.length === 1 && !isMeasured) {
    say("This study has one approach. Values at a load are read off between two, so there are none to show.");
  }
  connect();
  Object.keys(drawings).forEach((place) => drawings[place]());
});
