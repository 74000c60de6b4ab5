// The page of a result, or of two side by side: its state, its controls, and its words.

// ---- State ----------------------------------------------------------------------------------------------------------

const middle = (list) => list[Math.floor(list.length / 2)];
const results = facts.results.map((own) => ({facts: {...facts, ...own}, motions: []}));
const first = results[0].facts; // its dimensions, amplitudes and motions are picked from, and the other's nearest are shown
const isMeasured = first.reading === "elastic";
const state = {
  mu0: isMeasured ? facts.mu0[0] : middle(facts.mu0),
  tau0: facts.tau0[0], // MPa
  rule: 0,
  way: 0,
  kind: 0,
  amplitude: 0,
  // Of two readings of a scan the one whose interval covers both.
  dimension: isMeasured ? Math.max(0, first.dimensions.indexOf(first.answers.find(({covered}) => !covered)?.at.cut_off))
    : Math.floor(first.dimensions.length / 2),
  load: 0,
  range: null,
  quantity: "friction",
  colours: [0.1, 1],
  isLocked: false,
  pointed: null, // (dimension, load) under the pointer
};
let heights = null;
let patches = null;
let contactColumns = null;
let loads = [];
let allLoads = [];
let maps = [];
const tau0 = () => state.tau0 / 1000; // GPa
const COLOURS = ["var(--accent)", "var(--second)"]; // of results
const RULE_COLOURS = {all: "var(--all)", opposing: "var(--opposing)"};

const FRICTION = ["maps", "readout", "over", "friction", "area", "stiffness", "unloading", "compass", "positions"];
const hasBothRules = () => results.length === 1 && first.rules.length > 1;

/** Index of a result's rule and way that are nearest to what is picked. */
function motionOf(own, rule) {
  const way = first.ways[state.way];
  const same = own.ways.find(({words}) => words === way.words) ?? own.ways[0];
  const r = Math.max(0, own.rules.indexOf(rule));
  return {r, directions: same.directions, chosen: same.directions.map((d) => r * own.directions.length + d)};
}

/** A result by a sliding rule, in the picked direction, and where in it what is picked lies. */
function picked(r, rule = first.rules[state.rule], isPointed = true) {
  const {facts: own, motions} = results[r];
  const {chosen, directions} = motionOf(own, rule);
  const dimension = first.dimensions[(isPointed ? state.pointed?.[0] : null) ?? state.dimension];
  const {members} = own.kinds[Math.min(state.kind, own.kinds.length - 1)];
  return {
    result: {facts: own, ...motions[chosen[0]], motions, chosen, members}, directions,
    d: nearest(own.dimensions, dimension), a: nearest(own.amplitudes, first.amplitudes[state.amplitude]),
  };
}

/** What is drawn as one curve: each rule of a single result, or each of two results by the picked rule. */
const curves = () => (hasBothRules()
  ? first.rules.map((rule) => ({r: 0, rule, colour: RULE_COLOURS[rule], name: ruleName(rule)}))
  : results.map(({facts: own}, r) => ({r, rule: first.rules[state.rule], colour: results.length > 1 ? COLOURS[r] : RULE_COLOURS[first.rules[state.rule]],
    name: results.length > 1 ? own.name : "", dash: r ? "7 4" : undefined})));

// ---- Words ----------------------------------------------------------------------------------------------------------

const ruleName = (rule) => (rule === "all" ? "all contacts rub" : "only climbing contacts rub");
const dimensionName = (value) => (isMeasured ? (value > 0 ? `cut-off ${withUnit(value, "um")}` : "no cut-off") : `D = ${value.toFixed(3)}`);
const loadName = (l) => withUnit(loads[l], "mN") + (first.area ? ` (${withUnit(loads[l] / first.area, "GPa")})` : "");
const lengthName = (value) => withUnit(value, "um");
const materialName = () => `μ0 = ${state.mu0}, τ0 = ${state.tau0} MPa`;
const dimensionIfAny = () => (first.dimensions.length > 1 || !isMeasured ? [dimensionName(first.dimensions[state.dimension])] : []);
const amplitudeIfAny = () => (isMeasured ? [] : [`amplitude ${lengthName(first.amplitudes[state.amplitude])}`]);
const wayName = () => `the upper body moves ${first.ways[state.way].words}`;
const motionWords = () => (first.ways[state.way].directions.length > 1 ? first.ways[state.way].words : wayName());
const counted = (count, thing) => `${count} ${thing}${count === 1 ? "" : "s"}`;

function sayParameters() {
  byId("parameters").textContent = [`${materialName()}`, ...(loads.length ? [`load ${loadName(state.load)}`] : []),
    ...dimensionIfAny(), ...amplitudeIfAny(), motionWords()].join(", ") + ".";
}

// ---- The answer -----------------------------------------------------------------------------------------------------

function showReadout() {
  sayParameters();
  const load = loads[state.pointed?.[1] ?? state.load];
  const dimension = first.dimensions[state.pointed?.[0] ?? state.dimension];
  const where = [...(isMeasured && first.dimensions.length < 2 ? [] : [dimensionName(dimension)]), loadName(state.pointed?.[1] ?? state.load), motionWords()];
  const answers = [element("p", {class: "hint"}, `${state.pointed ? "Under the pointer" : "At"}: ${where.join(", ")}`)];
  const points = curves().map((curve) => {
    const {result, d, a, directions} = picked(curve.r, curve.rule);
    return {...curve, result, d, a, at: readOff(result, "friction", d, a, [load], state.mu0, tau0())[0],
      alone: slopesAlone(result, d, directions, curve.rule, state.mu0, tau0())};
  });
  const judged = judgement(points, load, dimension);
  for (const [i, {at, colour, name, rule, alone}] of points.entries()) {
    const words = results.length > 1 ? name : facts.ruleWords[rule];
    answers.push(element("p", {class: i && results.length < 2 ? "of other" : "of", style: `color: ${colour}`}, words), ...answerOf(at, rule, judged.saysSlopes ? NaN : alone, knownOf(judged, rule)));
    if (judged.said?.parts && rule === "all" && knownOf(judged, rule)) answers.push(barOf(judged.said, at.value), ...(judged.said.most ? [element("p", {class: "hint"}, judged.said.most)] : []));
  }
  const [{at}] = points;
  const [lower, upper] = knownOf(judged, points[0].rule) ?? [at.lower, at.upper];
  Object.assign(byId("readout").dataset, {dimension, load, mu0: state.mu0, tau0: tau0(), status: at.status, value: at.value, lower, upper});
  byId("answer").replaceChildren(...answers);
  byId("judgement").replaceChildren(...judged.elements);
  byId("sentence").replaceChildren(...judged.more);
  byId("figures").replaceChildren(...points.filter(({r}, i) => i === points.findIndex((each) => each.r === r)).flatMap(
    (point) => [...(results.length > 1 ? [element("p", {class: "of", style: `color: ${point.colour}`}, point.name)] : []),
      figuresOf(point, load)]));
}

/** Ends of the interval of everything known, where the library has said them; two members have none. */
function knownOf({said}, rule) {
  const ends = said?.intervals[rule];
  return ends?.every(Number.isFinite) ? ends : undefined;
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
  const said = parts.map((part, index) => `${index ? (part <= -0.0005 ? " \u2212 " : " + ") : ""}${Math.abs(part).toFixed(3)} ${names[index]}`);
  bar.setAttribute("aria-label", `${said.join("")}; interval ${low.toFixed(3)} to ${high.toFixed(3)}`);
  return element("div", {}, bar, element("p", {class: "hint"}, ...said.map((text, index) => element("span", {style: `color: ${colours[index]}; font-weight: 600`}, text))));
}

function answerOf(at, rule, alone, known) {
  if (at.status !== "ok")
    return [element("p", {class: "value"}, at.status), element("p", {class: "interval"}, facts.statuses[at.status]?.why ?? "")];
  const [lower, upper] = known ?? [at.lower, at.upper];
  const text = quoted(at.value, lower, upper);
  const [value, ends] = text.split(/ (?=\[)/);
  const of = known ? `${PERCENT} interval of all that is known ` : `${PERCENT} interval${isMeasured ? " of positions alone" : ""} `;
  return [
    element("p", {class: "value", "data-rule": rule}, element("i", {}, "μ"), element("sub", {}, "s"), " = ", data(at.value, value)),
    element("p", {class: "interval"}, ...(ends
      ? [of, element("span", {"data-lower": lower, "data-upper": upper}, ends)]
      : [`No interval: ${whyNoInterval()}`])),
    ...(Number.isFinite(alone) ? [element("p", {class: "hint"}, "The slopes alone predict ", data(alone, quoted(alone)))] : []),
  ];
}

function whyNoInterval() {
  if (isMeasured) return "too few members have an answer, or all are equal";
  if (first.repetitions === 1) return "there is one repetition";
  if (!first.hasIntervals) return "there are too many repetitions for a page; the library has it";
  return "fewer than two repetitions carry load";
}

/** The verdict, and its reasons: the library's where it has spoken, at the points that were asked for. */
function judgement(points, load, dimension) {
  const saying = (elements, saysSlopes = false, said = null) => ({elements, saysSlopes, said,
    more: said ? [element("p", {class: "sentence"}, said.sentence), ...(saysSlopes ? [element("p", {class: "hint"}, said.slopes)] : [])] : []});
  if (results.length > 1) return saying([]);
  if (!isMeasured) {
    const {result, d, a, at} = points.find(({rule}) => rule === first.quotedRule) ?? points[0];
    if (!first.hasIntervals && first.repetitions > 1)
      return saying([element("p", {class: "hint"}, "There are too many repetitions for intervals on a page; `stiction at` has them and the verdict.")]);
    const area = readOff(result, "area", d, a, [load], state.mu0, tau0())[0].value;
    const doubts = doubtsOfEnsemble({...facts, ...first}, at, area);
    return saying(saidVerdict(verdictOf(facts, doubts), doubts));
  }
  const isNear = (one, other) => Math.abs(one - other) <= 1e-9 * Math.max(Math.abs(one), Math.abs(other), 1e-300);
  const said = first.answers.find(({at}) => isNear(at.load, load) && isNear(at.mu0, state.mu0) && isNear(at.tau0, tau0()) &&
    (at.cut_off === undefined || isNear(at.cut_off, dimension)));
  const isAllRound = first.ways[state.way].directions.length === first.directions.length;
  if (said) return saying(saidVerdict(said.verdict, said.doubts), isAllRound && said.slopes !== "", isAllRound ? said : null);
  const near = first.answers.reduce((best, each) => {
    const apart = ({at}) => Math.abs(Math.log(at.load / load)) + (at.cut_off !== undefined && !isNear(at.cut_off, dimension) ? 10 : 0);
    return !best || apart(each) < apart(best) ? each : best;
  }, null);
  const back = element("button", {type: "button"}, "Back to what was asked for");
  back.addEventListener("click", () => goTo(near.at));
  return saying(near ? [element("p", {class: "hint"}, `The verdict is about the loads, μ0 and τ0 that the study asks for; at ` +
    `${withUnit(near.at.load, "mN")} it is: ${near.verdict}. `, back)] : []);
}

const MOST_DOUBTS = 3; // that are open below the verdict

function saidVerdict(verdict, doubts) {
  const kind = {"Quote it": "good", "Quote with care": "care", "Do not quote": "bad"}[verdict];
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
  const {facts: own} = result;
  if (at.status !== "ok") list.append(element("dt", {}, "Status"), element("dd", {class: "status"}, at.status));
  if (isMeasured) {
    for (const {name, words, unit, limit} of own.quantities) {
      const of = readOff(result, name, d, a, [load], state.mu0, tau0())[0];
      if (Number.isFinite(of.value)) row(words, of.value, intervalWithUnit(of.value, of.lower, of.upper, unit), limit !== null && of.value > limit);
    }
    row("Members with an answer", at.answered, `${at.answered} of ${at.all}`);
    return list;
  }
  if (at.status === "ok") for (const [quantity, words, unit] of [["area", "True contact area", "µm²"], ["stiffness", "Normal stiffness", "mN/µm"]]) {
    if (quantity === "stiffness" && !own.hasStiffness) continue;
    const of = readOff(result, quantity, d, a, [load], state.mu0, tau0())[0];
    row(words, of.value, `${quoted(of.value, of.lower, of.upper)}\u00a0${unit}`);
  }
  for (const [name, value] of Object.entries(at.validity ?? {})) {
    const {words, limit, isShare} = own.validity[name];
    row(words, value, isShare && Number.isFinite(value) ? `${(100 * value).toFixed(0)} %` : shown(value, 2), value > limit);
  }
  return list;
}

// ---- The map --------------------------------------------------------------------------------------------------------

const TITLES = {friction: "_μ_~s~", width: "±", area: "_A_ (µm²)", stiffness: "mN/µm"};

function showMaps() {
  const entries = new Map();
  maps = results.map((_, r) => {
    const {result, a} = picked(r);
    return mapOf(result, state.quantity, a, loads, state.mu0, tau0());
  });
  results.forEach(({facts: own}, r) => {
    const {d} = picked(r, undefined, false);
    const legend = drawMap(byId(`map-${r}`), {
      facts: own, map: maps[r], loads, colours: state.colours, picked: [d, state.load],
      ticks: state.quantity === "friction" ? facts.ticks : null, title: TITLES[state.quantity],
    });
    for (const [picture, words] of legend) entries.set(words, picture);
  });
  byId("legend").replaceChildren(...[...entries].map(([words, picture]) => element("li", {}, picture, words)));
}

const fitColours = () => colourRange(facts, maps);

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

const hasQuantity = ({facts: own}, id) => id === "friction" || (isMeasured
  ? own.quantities.some(({name}) => name === QUANTITY[id].of) : id !== "stiffness" || own.hasStiffness);

/** One curve for each of `curves`; of what has nothing to do with friction, one for each result. */
function seriesOf(id, points) {
  const isFree = isMeasured && id !== "friction";
  return curves().filter(({r}, i, all) => hasQuantity(results[r], id) && !(isFree && all.findIndex((each) => each.r === r) < i))
    .map((curve) => ({...curve, name: isFree && results.length < 2 ? "" : curve.name, colour: isFree && results.length < 2 ? "var(--area)" : curve.colour,
      points: points(curve).map((point) => ({...point, value: QUANTITY[id].factor * point.value, lower: QUANTITY[id].factor * point.lower,
        upper: QUANTITY[id].factor * point.upper}))}));
}

function showCurve(id) {
  const series = seriesOf(id, ({r, rule}) => {
    const {result, d, a} = picked(r, rule, false);
    return readOff(result, QUANTITY[id].of, d, a, loads, state.mu0, tau0()).map((point) => ({...point, x: point.load}));
  });
  const levels = id === "friction" && isMeasured && results.length === 1 ? series.map(({r, rule, colour}) => {
    const {result, d, directions} = picked(r, rule, false);
    return {value: slopesAlone(result, d, directions, rule, state.mu0, tau0()), colour, name: `by slope alone, ${rule}`};
  }).filter(({value}) => Number.isFinite(value)) : [];
  const room = isMeasured ? 1.15 : 1;
  const x = {low: loads[0] / room, high: loads.at(-1) * room, isLog: true, title: `normal load _F_~N~ (mN)${isMeasured ? `; 1 mN is ${shown(1000 / first.area)} MPa` : ""}`};
  const drawn = drawCurves(byId(id), series, x, {...QUANTITY[id], picked: loads[state.load], levels});
  byId(`${id}-caption`).textContent = curveCaption(series, [...dimensionIfAny(), ...amplitudeIfAny()], drawn, "load");
}

function showOver() {
  const load = loads[state.load];
  const series = seriesOf("friction", ({r, rule}) => {
    const {result, a} = picked(r, rule, false);
    return overDimensions(result, "friction", a, load, state.mu0, tau0()).map((point) => ({...point, x: point.dimension}));
  });
  const ends = isMeasured ? [first.dimensions[0], first.dimensions.at(-1)] : [edges(first.dimensions)[0], edges(first.dimensions).at(-1)];
  const drawn = drawCurves(byId("over"), series, {low: ends[0], high: ends[1], title: first.cell.title},
    {...QUANTITY.friction, picked: first.dimensions[state.dimension]});
  byId("over-caption").textContent = curveCaption(series, [loadName(state.load), ...amplitudeIfAny()], drawn, isMeasured ? "cut-off" : "dimension");
}

function curveCaption(series, where, [low, high], of) {
  const points = series.flatMap((each) => each.points);
  const ok = points.filter((point) => point.status === "ok");
  const words = [`At ${[...where, materialName()].join(", ")}; ${motionWords()}${results.length > 1 || !hasBothRules() ? `, ${ruleName(first.rules[state.rule])}` : ""}.`];
  if (ok.length && ok.every((point) => Number.isFinite(point.lower))) {
    words.push(`Shaded: ${PERCENT} interval.`);
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

const isByOffset = () => first.interval === "neighbours" && new Set(first.lines).size === 1 && first.repetitions > 1;

function showPositions() {
  const step = stepOf(first, loads[state.load]);
  const series = curves().map((curve) => {
    const {result, d, a} = picked(curve.r, curve.rule, false);
    const each = result.chosen.map((motion) => memberValues({...result, chosen: [motion]}, "friction", d, a, step, state.mu0, tau0()));
    const values = each.flat();
    const found = isByOffset() ? each.flatMap((one) => one.map((value, i) => ({x: first.offsets[0][result.members[i]], value})))
      : values.filter(Number.isFinite).sort((one, other) => one - other).map((value, i) => ({x: i + 1, value}));
    return {...curve, points: found.map((point) => ({...point, lower: NaN, upper: NaN, trusted: false}))};
  });
  const levels = curves().map((curve) => {
    const {result, d, a} = picked(curve.r, curve.rule, false);
    return {value: meanOfMembers(result, "friction", d, a, loads[state.load], state.mu0, tau0()).value, colour: curve.colour, name: ""};
  }).filter(({value}) => Number.isFinite(value));
  const xs = series.flatMap(({points}) => points.map(({x}) => x));
  const [low, high] = xs.length ? [Math.min(...xs), Math.max(...xs)] : [0, 1];
  const room = isByOffset() ? 0.02 * (high - low || 1) : 0.5;
  drawCurves(byId("positions"), series, {low: low - room, high: high + room, title: isByOffset() ? "offset of the upper body (µm)" : "members and directions, in order"},
    {...QUANTITY.friction, isScatter: true, levels, said: ({x, value}, name) => `${shown(value, 3)}${isByOffset() ? ` at ${shown(x, 3)} µm` : ""}${name ? `, ${name}` : ""}`});
  byId("positions-caption").textContent = `Each point is one ${isByOffset() ? "position" : "pair of pieces"} in one direction, at ${loadName(state.load)}, ${materialName()}; ${motionWords()}. Dashed: the mean.`;
}

function showCompass() {
  const series = curves().map((curve) => {
    const {result, d, a} = picked(curve.r, curve.rule, false);
    const {r} = motionOf(result.facts, curve.rule);
    return {...curve, points: first.directions.map((_, way) => readOff({...result, ...result.motions[r * first.directions.length + way],
      chosen: [r * first.directions.length + way]}, "friction", d, a, [loads[state.load]], state.mu0, tau0())[0])};
  });
  const {directions} = first.ways[state.way];
  drawCompass(byId("compass"), first.directions, series, directions.length === 1 ? directions[0] : null,
    ({value, lower, upper}, angle, name) => `${angle}°: ${quoted(value, lower, upper)}${name ? `, ${name}` : ""}`);
  byId("compass-caption").textContent = `At ${[loadName(state.load), ...dimensionIfAny(), materialName()].join(", ")}. Angle: motion of the upper body. ` +
    `Shaded: ${PERCENT} intervals. Click, or use the arrow keys, to pick a direction; double-click for the mean over all.`;
}

function showContacts() {
  const {contacts: {columns, count, all}, load, moved, lines} = first.picture;
  const contacts = Array.from({length: count}, (_, i) => Object.fromEntries(columns.map((name, c) => [name, contactColumns[c * count + i]])));
  const way = first.ways[state.way].directions;
  const degrees = first.directions[way.length === 1 ? way[0] : 0];
  const angle = (degrees * Math.PI) / 180;
  for (const each of contacts) each.opposes = each.slope_x * Math.cos(angle) + each.slope_y * Math.sin(angle) > 0;
  const said = ({force, patch_area: area, opposes, at_edge: isCut}) =>
    `${withUnit(force, "mN")} on ${shown(area, 3)} µm²${opposes ? ", has to climb" : ""}${isCut ? ", cut by the edge" : ""}`;
  if (lines) drawLines(byId("contacts"), lines, contacts, said);
  else drawContacts(byId("contacts"), {...first.picture, bytes: heights, patches}, contacts, said);
  const climbing = contacts.filter(({opposes}) => opposes).length;
  const total = contacts.reduce((sum, {force}) => sum + force, 0);
  const cut = contacts.reduce((sum, {force, at_edge: isCut}) => sum + (isCut ? force : 0), 0);
  byId("contacts-caption").textContent = `The position whose true area is nearest to the mean${first.dimensions.length > 1 ? `, ${dimensionName(first.dimensions[0])}` : ""}: ${counted(all, "contact")} at ${withUnit(load, "mN")}; ` +
    `pushed ${lines ? first.ways.find(({directions}) => directions.length === 1 && first.directions[directions[0]] === degrees).words : `at ${degrees}°`}, ${climbing} of them ${climbing === 1 ? "has" : "have"} to climb.` +
    (cut ? ` The edge cuts contacts with ${percent(cut / total)} of the load.` : "") +
    (lines ? " The upper line stands as it is pressed." : ` The upper map is moved by ${shown(moved[0], 3)} and ${shown(moved[1], 3)} µm.`) +
    (all > count ? ` The ${all - count} weakest are not drawn.` : "");
  byId("contacts").drawn = {contacts};
}

function showSpectra() {
  const series = first.spectra.map(({name, waveNumber, density}, s) => ({colour: COLOURS[s], name, dash: s ? "7 4" : undefined,
    points: waveNumber.map((x, i) => ({x, value: density[i], lower: NaN, upper: NaN, trusted: true}))}));
  const all = first.spectra.flatMap(({waveNumber}) => waveNumber);
  drawCurves(byId("spectra"), series, {low: Math.min(...all), high: Math.max(...all), isLog: true, title: "wave number _q_ (1/µm)"},
    {title: "density (µm⁴)", isLog: true, said: ({x, value}, name) => `${shown(value, 3)} µm⁴ at wavelength ${withUnit((2 * Math.PI) / x, "um")}, ${name}`});
}

// ---- Tables ---------------------------------------------------------------------------------------------------------

const material = () => [state.mu0, state.tau0];

function curveRows(id, head) {
  const names = ["result", head, ["area", "stiffness", "unloading"].includes(id) ? QUANTITY[id].title.replaceAll(/[_~]/g, "") : "mu_s", "lower", "upper", "status",
    "mu0", "tau0 (MPa)"];
  return () => [names, ...byId(id).drawn.series.flatMap(({name, points}) => points.map(({x, value, lower, upper, status}) =>
    [name || first.name, x, value, lower, upper, status ?? "", ...material()]))];
}

function mapRows(r) {
  const {dimensions} = results[r].facts;
  return [["fractal dimension", "load (mN)", state.quantity, "status", "within validity", "mu0", "tau0 (MPa)"],
    ...loads.flatMap((load, l) => dimensions.map((dimension, d) => [dimension, load, maps[r].value[l][d] ?? NaN,
      maps[r].status[l][d], maps[r].trusted[l][d] ?? "", ...material()]))];
}

function contactRows() {
  const names = first.picture.contacts.columns;
  return [[...names, "opposes"], ...byId("contacts").drawn.contacts.map((each) => [...names.map((name) => each[name]), each.opposes])];
}

// ---- Controls -------------------------------------------------------------------------------------------------------

let sliders = {}; // of load and dimension
let setLoads = () => {};

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
  pick(cutOff === undefined ? state.dimension : nearest(first.dimensions, cutOff), nearest(loads, load));
}

function connect() {
  const said = addressed();
  const whole = (text, count, otherwise) => Math.floor(numberOf(text, 0, count - 1, otherwise));
  state.mu0 = numberOf(said.mu0, 0, 1e3, state.mu0);
  state.tau0 = numberOf(said.tau0, 0, 1e9, state.tau0);
  for (const [key, count] of [["rule", first.rules.length], ["way", first.ways.length], ["amplitude", first.amplitudes.length],
    ["kind", first.kinds.length]]) state[key] = whole(said[key], count, state[key]);
  const changed = () => {
    sayIfStrong();
    redraw(...FRICTION);
  };
  amount("mu0", {value: state.mu0, most: facts.mu0Most, step: 0.01, unit: "",
    changed: (value) => { state.mu0 = value; changed(); }});
  amount("tau0", {value: state.tau0, most: facts.tau0Most, step: Number((facts.tau0Most / 200).toPrecision(1)), unit: " MPa",
    changed: (value) => { state.tau0 = value; changed(); }});
  sayIfStrong();
  const set = (key, ...places) => (value) => {
    state[key] = value;
    redraw(...(places.length ? places : [...FRICTION, "contacts"]));
  };
  choice("rule", hasBothRules() && !drawings.maps ? [] : first.rules.map(ruleName), state.rule, set("rule"));
  choice("way", first.ways.map(({words}) => words), state.way, set("way"));
  choice("kind", first.kinds.map(({words}) => words), state.kind, set("kind"));
  byId("amplitude-label").textContent = `Amplitude (${first.measure === "height" ? "total height" : first.measure})`;
  choice("amplitude", first.amplitudes.map(lengthName), state.amplitude, set("amplitude"));
  byId("dimension-label").textContent = isMeasured ? "Cut-off wavelength" : `Fractal dimension D${first.convention}`;
  byId("dimension-control").hidden = first.dimensions.length < 2;
  const d = Number(said.d ?? NaN);
  if (Number.isFinite(d)) state.dimension = nearest(first.dimensions, d);
  const dimension = index("dimension", {value: state.dimension, count: first.dimensions.length,
    name: (at) => dimensionName(first.dimensions[at]), changed: (at) => { state.dimension = at; redraw(...FRICTION); }});
  dimension.show();
  sliders.dimension = dimension;
  byId("link").addEventListener("click", async () => {
    await navigator.clipboard.writeText(location.href).then(() => { byId("link").textContent = "Copied"; }, () => { byId("link").textContent = location.href; });
  });
  window.addEventListener("resize", () => redraw(...Object.keys(drawings)));
  connectLoads(said);
  if (!allLoads.length) return;
  connectMap(said);
  for (const id of ["friction", "area", "stiffness", "unloading", "over"]) if (drawings[id]) connectCurve(id);
  connectOthers();
  atRest = () => {
    if (drawings.maps) settleMap();
    address(addressOf());
  };
  if (drawings.maps) beginMap(said, Number.isFinite(d));
  sayParameters();
}

function connectLoads(said) {
  if (!allLoads.length) return;
  const load = index("load", {value: 0, count: 1, name: (l) => loadName(l),
    changed: (l) => { state.load = l; redraw(...FRICTION); }});
  sliders.load = load;
  const count = () => { byId("load").max = loads.length - 1; byId("load").disabled = loads.length < 2; };
  if (isMeasured) {
    loads = first.steps;
    state.load = nearest(loads.map(Math.log), Math.log(numberOf(said.load, 1e-300, 1e300, first.asked[0])));
    count();
    load.set(state.load);
    return;
  }
  const showRange = range("load", (ends) => setLoads(ends, false));
  setLoads = (ends, isShown = true) => {
    const now = loads[state.load];
    state.range = ends;
    loads = geometric(...ends, facts.loadSteps);
    for (const [r] of results.entries()) if (byId(`map-${r}`)) byId(`map-${r}`).view = null;
    count();
    load.set(state.load = now === undefined ? Math.floor(loads.length / 2) : nearest(loads.map(Math.log), Math.log(now)));
    if (isShown) showRange(ends);
    redraw(...FRICTION);
  };
  const low = numberOf(said.low, 1e-300, 1e300, NaN);
  const high = numberOf(said.high, NARROWEST * low, 1e300, NaN);
  setLoads(Number.isFinite(high) ? [low, high] : allLoads);
  byId("all-loads").addEventListener("click", () => setLoads(allLoads));
  const at = numberOf(said.load, 1e-300, 1e300, NaN);
  if (Number.isFinite(at)) load.set(state.load = nearest(loads.map(Math.log), Math.log(at)));
}

let showColours = () => {};

function connectMap(said) {
  if (!drawings.maps) return;
  const quantities = ["friction", "width", "area", "stiffness"];
  const lacking = results.flatMap(({facts: own}) => [...(own.hasIntervals ? [] : ["width"]), ...(own.hasStiffness ? [] : ["stiffness"])]);
  for (const option of [...byId("quantity").options]) if (lacking.includes(option.value)) option.remove();
  if (quantities.includes(said.show) && !lacking.includes(said.show)) state.quantity = said.show;
  byId("quantity").value = state.quantity;
  byId("quantity").addEventListener("change", () => {
    state.quantity = byId("quantity").value;
    byId("lock").checked = state.isLocked = false;
    redraw("maps");
  });
  slow = (place) => place === "maps" && state.quantity === "width";
  showColours = range("colour", (ends) => {
    state.colours = ends;
    byId("lock").checked = state.isLocked = true;
    redraw("maps");
  });
  byId("lock").addEventListener("change", () => {
    state.isLocked = byId("lock").checked;
    redraw("maps");
  });
  results.forEach(({facts: own}, r) => connectOneMap(own, r));
}

/** What arrow keys do on a plot: a step for each. */
function onArrows(place, steps, move) {
  place.addEventListener("keydown", (event) => {
    if (!(event.key in steps)) return;
    event.preventDefault();
    move(steps[event.key]);
  });
}

function connectOneMap(own, r) {
  const place = element("div", {id: `map-${r}`, class: "plot tall", role: "application", tabindex: 0, "data-drawing": "maps",
    "aria-label": `Map over fractal dimension and load${results.length > 1 ? ` of ${own.name}` : ""}; ` +
      "arrow keys move the picked point, whose values are said; plus and minus look closer, 0 shows all"});
  byId("maps").append(results.length > 1 ? element("h3", {style: `color: ${COLOURS[r]}`}, own.name) : "", place);
  toolbar(place, () => mapRows(r));
  const cell = (x, y) => {
    const d = edges(own.dimensions).findLastIndex((edge) => edge <= x);
    const l = edges(loads.map(Math.log)).findLastIndex((edge) => edge <= Math.log(y));
    const clamped = Math.min(Math.max(d, 0), own.dimensions.length - 1);
    return [nearest(first.dimensions, own.dimensions[clamped]), Math.min(Math.max(l, 0), loads.length - 1)];
  };
  const leave = () => {
    tip(place, "");
    if (state.pointed) { state.pointed = null; redraw("readout"); }
  };
  interactive(place, {
    point: (x, y, here) => {
      state.pointed = cell(x, y);
      redraw("readout");
      const d = nearest(own.dimensions, first.dimensions[state.pointed[0]]);
      const value = maps[r].value[state.pointed[1]][d];
      tip(place, `${value === null ? maps[r].status[state.pointed[1]][d] : shown(value, 3)} at ${dimensionName(own.dimensions[d])}, ${withUnit(loads[state.pointed[1]], "mN")}`, here);
    },
    leave,
    pick: (x, y) => pick(...cell(x, y)),
    redrawn: () => redraw("maps"),
  });
  onArrows(place, {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}, (step) => {
    pick(Math.min(Math.max(state.dimension + step[0], 0), first.dimensions.length - 1),
      Math.min(Math.max(state.load + step[1], 0), loads.length - 1));
  });
}

/** Where the map begins: at what the address says, or at the sound cell whose interval is narrowest. */
function beginMap(said, isAddressed) {
  showMaps();
  const {result, a} = picked(0);
  const widths = first.hasIntervals ? mapOf(result, "width", a, loads, state.mu0, tau0()).value : null;
  const [d, l] = beginning(maps[0], widths);
  if (!isAddressed) sliders.dimension.set(state.dimension = d);
  if (said.load === undefined) sliders.load.set(state.load = l);
  const ends = [numberOf(said.dark, 1e-300, 1e300, NaN), numberOf(said.light, 1e-300, 1e300, NaN)];
  if (ends[1] >= NARROWEST * ends[0]) {
    state.colours = ends;
    byId("lock").checked = state.isLocked = true;
  } else state.colours = fitColours();
  showColours(state.colours);
}

function settleMap() {
  if (wanted.has("maps")) showMaps();
  wanted.delete("maps");
  const fitted = state.isLocked || !maps.length ? state.colours : fitColours();
  if (String(fitted) !== String(state.colours)) {
    state.colours = fitted;
    showMaps();
  }
  if (!state.isLocked) showColours(state.colours);
}

function connectCurve(id) {
  const place = byId(id);
  const over = id === "over";
  toolbar(place, curveRows(id, over ? first.cell.name : "load (mN)"), {hasScales: true});
  const all = () => (over ? first.dimensions : loads.map(Math.log));
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

function connectOthers() {
  for (const [id, head] of [["positions", isByOffset() ? "offset (um)" : "member in order"], ["spectra", "wave number (1/um)"],
    ["compass", "direction (degrees)"], ["contacts", ""]]) {
    if (!drawings[id]) continue;
    const [place, hasAxes] = [byId(id), id !== "compass"];
    toolbar(place, head ? curveRows(id, head) : contactRows, {hasAxes, hasScales: id === "positions"});
    if (hasAxes) interactive(place, {point: (_, __, here) => tipOfNearest(place, here), leave: () => tip(place, ""), redrawn: () => redraw(id)});
  }
  if (drawings.compass) connectCompass();
}

function connectCompass() {
  const compass = byId("compass");
  const count = first.directions.length;
  const set = (way) => {
    state.way = byId("way").value = way;
    redraw(...FRICTION, "contacts");
  };
  const wayOf = (d) => first.ways.findIndex(({directions}) => directions.length === 1 && directions[0] === d);
  onArrows(compass, {ArrowLeft: 1, ArrowUp: 1, ArrowRight: -1, ArrowDown: -1}, (step) => {
    const now = first.ways[state.way].directions;
    set(wayOf(now.length > 1 ? 0 : (now[0] + step + count) % count));
  });
  const at = (event) => {
    const {left, top} = compass.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  };
  compass.addEventListener("pointermove", (event) => tipOfNearest(compass, at(event)));
  compass.addEventListener("pointerleave", () => tip(compass, ""));
  compass.addEventListener("click", (event) => {
    const [x, y] = at(event);
    const {centre} = compass.axes;
    const angle = (Math.atan2(centre[1] - y, x - centre[0]) * 180) / Math.PI;
    const apart = (one) => Math.abs(((one - angle + 540) % 360) - 180);
    set(wayOf(first.directions.reduce((best, each, d) => (apart(each) < apart(first.directions[best]) ? d : best), 0)));
  });
  compass.addEventListener("dblclick", () => { if (first.ways[0].directions.length > 1) set(0); });
}

function addressOf() {
  const values = {mu0: state.mu0, tau0: state.tau0, d: first.dimensions[state.dimension], load: loads[state.load]};
  for (const [key, list] of [["rule", first.rules], ["way", first.ways], ["amplitude", first.amplitudes], ["kind", first.kinds]])
    if (list.length > 1) values[key] = state[key];
  if (state.range && String(state.range) !== String(allLoads)) [values.low, values.high] = state.range;
  if (state.quantity !== "friction") values.show = state.quantity;
  if (state.isLocked) [values.dark, values.light] = state.colours;
  return values;
}

// ---- Beginning ------------------------------------------------------------------------------------------------------

async function unpackAll() {
  for (const [r, result] of results.entries()) {
    const {variables, perRepetition, rules, directions, picture} = result.facts;
    const motions = rules.length * directions.length;
    const [means, sums] = [
      parts(variables, motions, await unpacked(`means-${r}`, isMeasured ? 8 : facts.bytes.means)),
      parts(perRepetition, motions, await unpacked(`sums-${r}`, isMeasured ? 8 : facts.bytes.sums)),
    ];
    result.motions = means.map((each, m) => ({means: each, sums: sums[m]}));
    if (picture) {
      contactColumns = await unpacked(`contacts-${r}`, facts.pictureBytes);
      if (!picture.lines) [heights, patches] = [await inflated(`lower-${r}`), new Uint16Array((await inflated(`patches-${r}`)).buffer)];
    }
  }
}

/** Take away what a result has nothing for. */
function hideOthers() {
  const hide = (id) => {
    byId(id).closest("section, .panel").hidden = true;
    delete drawings[id];
  };
  const lacking = {
    maps: isMeasured || !allLoads.length,
    readout: !allLoads.length,
    over: first.dimensions.length < 2 || !allLoads.length,
    friction: !allLoads.length,
    area: !allLoads.length || !results.some((result) => hasQuantity(result, "area")),
    stiffness: !allLoads.length || !results.some((result) => hasQuantity(result, "stiffness")),
    unloading: !isMeasured || !results.some((result) => hasQuantity(result, "unloading")),
    compass: first.directions.length < 3 || !allLoads.length,
    positions: !isMeasured || first.repetitions < 2,
    contacts: !first.picture,
    spectra: !first.spectra,
  };
  if (lacking.maps) {
    byId("map-panel").hidden = true;
    delete drawings.maps;
  }
  byId("top").classList.toggle("alone", lacking.maps && lacking.contacts);
  if (isMeasured) {
    byId("main").classList.add("pair");
    byId("top").after(byId("controls"));
    byId("numbers").hidden = false;
    byId("numbers").append(byId("figures"), byId("sentence"));
  }
  byId("more").addEventListener("toggle", () => redraw(...Object.keys(drawings)));
  for (const [id, isLacking] of Object.entries(lacking)) if (isLacking && id !== "maps") id === "readout" ? (byId("top").hidden = true, delete drawings[id]) : hide(id);
  byId(isMeasured ? "of-ensembles" : "of-members").hidden = true;
  byId("over-title").textContent = `Friction coefficient over ${isMeasured ? "cut-off wavelength" : "fractal dimension"}`;
}

start(async () => {
  await unpackAll();
  const ranges = results.map(({facts: own}) => own.loads).filter((ends) => ends.length);
  if (ranges.length) allLoads = [Math.min(...ranges.map(([low]) => low)), Math.max(...ranges.map(([, high]) => high))];
  drawings = {maps: showMaps, readout: showReadout, over: showOver, friction: () => showCurve("friction"),
    area: () => showCurve("area"), stiffness: () => showCurve("stiffness"), unloading: () => showCurve("unloading"), compass: showCompass, contacts: showContacts,
    positions: showPositions, spectra: showSpectra};
  hideOthers();
  if (!allLoads.length) {
    say("No pair of this study touches within its approaches: there is no load, no area and no friction to show.");
    byId("controls").hidden = true;
  } else if (results.every(({facts: own}) => own.steps.length === 1 && own.reading === "mean")) {
    say("This study has one approach. Values at a load are read off between two, so there are none to show.");
  }
  connect();
  Object.keys(drawings).forEach((place) => drawings[place]());
});
