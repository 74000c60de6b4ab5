// The page of two measured surfaces: its state, its controls, and its words.
//
// Of maps the page has the sums that normal and tangential load are made of, at every position, so every mu0 and tau0 is
// at hand. Of lines, where each position carries the load with its friction, it has the values that were computed.

const isMaps = facts.kind === "maps";
const state = {
  mu0: facts.mu0[0], tau0: facts.tau0[0] * 1000, material: 0, load: facts.asked, direction: 0, mechanics: 0, kind: 0, side: 0,
};
const COLOURS = ["var(--accent)", "var(--opposing)"];
let sums = null;
const heights = [];
let contactColumns = null;
const EVERYTHING = ["answer", "compass", "contacts", "friction", "area", "positions"];

const material = () => (isMaps
  ? {mu0: state.mu0, tau0: state.tau0 / 1000}
  : {mu0: facts.mu0[Math.floor(state.material / facts.tau0.length)], tau0: facts.tau0[state.material % facts.tau0.length]});
const materialName = ({mu0, tau0}) => `μ0 = ${mu0}, τ0 = ${Number((1000 * tau0).toPrecision(9))} MPa`;
const kindNow = () => facts.kinds[state.kind];

// ---- Numbers --------------------------------------------------------------------------------------------------------

/** The friction coefficient at each position of the kind: of a rule (or, of lines, of a direction of motion). */
function coefficients(series, load, direction = state.direction) {
  if (!isMaps) return facts.coefficients[series][load][state.material];
  const {mu0, tau0} = material();
  const [rules, directions, shifts, loads] = facts.shape;
  const size = facts.mechanics.length * rules * directions * shifts * loads;
  return kindNow().places.map((shift) => {
    const at = (((state.mechanics * rules + series) * directions + direction) * shifts + shift) * loads + load;
    return coefficientOf(Array.from({length: 6}, (_, i) => sums[i * size + at]), mu0, tau0);
  });
}

/** Mean of a friction coefficient over the positions, with its interval. */
function friction(series, load, direction) {
  if (!isMaps) return triple(facts.means.friction_coefficient[series][load][state.material]);
  return triple(ofSample(coefficients(series, load, direction), facts.confidence, facts.fewest));
}

/** Mean of another quantity over the positions, with its interval. */
function contactMean(name, load, series = 0) {
  if (!isMaps) return triple(facts.means[name][series][load][state.material]);
  const all = facts.contact[name][state.mechanics];
  const found = ofSample(kindNow().places.map((shift) => all[shift][load] ?? NaN), facts.confidence, facts.fewest);
  return triple(name.startsWith("share_") ? found.map((value) => Math.min(value, 1)) : found);
}

const triple = ([value, lower, upper]) => ({value: value ?? NaN, lower: lower ?? NaN, upper: upper ?? NaN, trusted: true});

/** What the slopes of the gap alone say, on the mean over positions. */
function alone(series) {
  if (!facts.gap) return NaN;
  const {mu0, tau0} = material();
  const values = kindNow().places.map((shift) => gentleFriction(mu0, tau0, {
    gradient: facts.gap.gradient[shift], slope: facts.gap.slope[state.direction][shift], modulus: facts.modulus,
    kappa: facts.gap.kappa,
  }, facts.series[series].name));
  return ofSample(values, facts.confidence, facts.fewest)[0];
}

// ---- Words ----------------------------------------------------------------------------------------------------------

const loadName = (l) => `${shown(facts.loads[l])} mN, ${shown(facts.pressures[l])} MPa`;
const between = ({lower, upper}, factor = 1, digits = 3) =>
  (Number.isFinite(lower) ? ` [${shown(factor * lower, digits)}, ${shown(factor * upper, digits)}]` : "");
const wayName = (angle) => ({0: "+x", 90: "+y", 180: "−x", 270: "−y"})[angle] ?? `${angle}° from +x`;

function showAnswer() {
  const l = state.load;
  const children = [element("p", {class: "hint"}, `At ${loadName(l)}${isMaps ? `, to ${wayName(facts.directions[state.direction])}` : ""}; ` +
    `${materialName(material())}`)];
  facts.series.forEach((each, s) => {
    const at = friction(s, l);
    children.push(
      element("p", {class: "of", style: `color: ${COLOURS[s]}`}, each.words),
      element("p", {class: "value", "data-series": each.name}, element("i", {}, "μ"), element("sub", {}, "s"), " = ",
        data(at.value, shown(at.value, 3))),
      element("p", {class: "interval"}, ...(Number.isFinite(at.lower)
        ? [`${PERCENT} interval [`, data(at.lower, shown(at.lower, 3)), ", ", data(at.upper, shown(at.upper, 3)), "]"]
        : [Number.isFinite(at.value) ? "No interval: too few positions" : "No position has an answer"])),
    );
    if (facts.gap) children.push(element("p", {class: "hint"}, "By its slope alone: ",
      data(alone(s), shown(alone(s), 3))));
  });
  byId("answer").replaceChildren(...children);
  const list = element("dl", {});
  for (const {name, words, unit, factor, limit} of facts.quantities) {
    const values = (isMaps ? [0] : facts.series.map((_, s) => s)).map((s) => contactMean(name, l, s));
    if (values.every(({value}) => !Number.isFinite(value))) continue;
    const beyond = limit !== null && values.some(({value}) => value > limit);
    const texts = values.map((at) => `${shown(factor * at.value, 3)}${between(at, factor)}`);
    list.append(element("dt", {}, `${words}${unit ? ` (${unit})` : ""}`),
      element("dd", {"data-name": name, ...(beyond ? {class: "beyond"} : {})}, beyond ? "⚠ " : "",
        data(values[0].value, texts.join(" | "))));
  }
  const answered = facts.series.map((_, s) => coefficients(s, l).filter((value) => Number.isFinite(value ?? NaN)).length);
  list.append(element("dt", {}, "Positions with an answer"),
    element("dd", {}, `${[...new Set(answered)].join(" | ")} of ${coefficients(0, l).length}`));
  byId("figures").replaceChildren(list);
}

function seriesOver(of) {
  return facts.series.map(({short}, s) => ({colour: COLOURS[s], name: short, points: facts.loads.map((load, l) => ({x: load, ...of(s, l)}))}));
}

const loadAxis = () => ({low: facts.loads[0] / 1.15, high: facts.loads.at(-1) * 1.15, isLog: true, title: "load (mN)"});

function showFriction() {
  const levels = facts.gap ? facts.series.map(({short}, s) => ({value: alone(s), colour: COLOURS[s], name: `${short}, by slope alone`})) : [];
  drawCurves(byId("friction"), seriesOver((s, l) => friction(s, l)), loadAxis(),
    {title: "friction coefficient _μ_~s~", isLog: false, picked: facts.loads[state.load],
      levels: levels.filter(({value}) => Number.isFinite(value))});
  byId("friction-caption").textContent = `${materialName(material())}. Shaded: ${PERCENT} intervals over ${kindNow().words}.`;
}

function showArea() {
  const [{points}, other] = seriesOver((s, l) => contactMean("contact_area_fraction", l, s));
  const percent = (list) => list.map((p) => ({...p, value: 100 * p.value, lower: 100 * p.lower, upper: 100 * p.upper}));
  const series = [{colour: COLOURS[0], name: isMaps ? "" : facts.series[0].short, points: percent(points)}];
  if (!isMaps) series.push({...other, points: percent(other.points)});
  drawCurves(byId("area"), series, loadAxis(), {title: "true area _A_/_A_~0~ (%)", isLog: true, picked: facts.loads[state.load]});
  byId("area-caption").textContent = isMaps ? "It does not depend on μ0, τ0 and the direction: the load is that before sliding." :
    `${materialName(material())}.`;
}

function showPositions() {
  const series = facts.series.map(({short}, s) => ({colour: COLOURS[s], name: short,
    points: coefficients(s, state.load).map((value, i) => ({x: i + 1, value: value ?? NaN, lower: NaN, upper: NaN, trusted: false}))}));
  const count = series[0].points.length;
  drawCurves(byId("positions"), series, {low: 0.5, high: count + 0.5, title: facts.positionsAre}, {title: "friction coefficient _μ_~s~", isLog: false, isScatter: true});
  byId("positions-caption").textContent = `At ${loadName(state.load)}; ${materialName(material())}.`;
}

function showCompass() {
  drawCompass(byId("compass"), facts.directions, facts.series.map(({short}, s) => ({colour: COLOURS[s], name: short,
    points: facts.directions.map((_, d) => friction(s, state.load, d))})), state.direction);
}

const shownContacts = () => facts.contacts.lists.find(({mechanics, load}) => mechanics === state.mechanics && load === state.load);

function showContacts() {
  const found = shownContacts();
  const columns = facts.contacts.columns.length;
  const total = contactColumns.length / columns;
  const contacts = found ? Array.from({length: found.count}, (_, i) => Object.fromEntries(
    facts.contacts.columns.map((name, c) => [name, contactColumns[c * total + found.first + i]]))) : [];
  const angle = (facts.directions[state.direction] * Math.PI) / 180;
  for (const each of contacts) each.opposes = each.slope_x * Math.cos(angle) + each.slope_y * Math.sin(angle) > 0;
  drawContacts(byId("contacts"), {...facts.picture, bytes: heights[state.side], range: facts.picture.ranges[state.side]}, contacts);
  const opposing = contacts.filter(({opposes}) => opposes).length;
  const words = found
    ? `${found.all} contacts at position ${facts.picture.shift + 1}, at ${loadName(state.load)}: diamonds are on slopes that oppose the motion to ` +
      `${wayName(facts.directions[state.direction])} (${opposing}), circles are not (${contacts.length - opposing}). Their size goes with the ` +
      `square root of the force, the largest ${shown(Math.max(...contacts.map(({force}) => force), 0), 3)} mN.` +
      (found.all > found.count ? ` The ${found.all - found.count} weakest are not drawn.` : "")
    : "Contacts are kept at the loads that were asked for: move the load there.";
  byId("contacts-caption").textContent = `Heights from ${shown(1000 * facts.picture.ranges[state.side][0], 3)} (dark) to ` +
    `${shown(1000 * facts.picture.ranges[state.side][1], 3)} nm (light). ${words}`;
  byId("contacts").drawn = {contacts};
}

function showSpectra() {
  const series = facts.spectra.map(({name, wavelength, density}, s) => ({colour: COLOURS[s], name,
    points: wavelength.map((x, i) => ({x, value: density[i], lower: NaN, upper: NaN, trusted: true}))}));
  const all = facts.spectra.flatMap(({wavelength}) => wavelength);
  drawCurves(byId("spectra"), series, {low: Math.min(...all), high: Math.max(...all), isLog: true, title: "wavelength (µm)"},
    {title: "density (µm⁴)", isLog: true});
}

// ---- Tables ---------------------------------------------------------------------------------------------------------

const curveRows = (id, of, quantity) => () => [[of, "rule", quantity, "lower", "upper", "mu0", "tau0 (GPa)"],
  ...byId(id).drawn.series.flatMap(({name, points}) => points.map(({x, value, lower, upper}) =>
    [x, name, value, lower, upper, material().mu0, material().tau0]))];

function contactRows() {
  const names = facts.contacts.columns;
  return [[...names, "opposes"], ...byId("contacts").drawn.contacts.map((each) => [...names.map((name) => each[name]), each.opposes])];
}

// ---- Controls -------------------------------------------------------------------------------------------------------

function connect() {
  const said = addressed();
  const whole = (text, count, otherwise) => Math.floor(numberOf(text, 0, count - 1, otherwise));
  state.mu0 = numberOf(said.mu0, 0, 1e3, state.mu0);
  state.tau0 = numberOf(said.tau0, 0, 1e9, state.tau0);
  for (const [key, count] of [["mechanics", facts.mechanics.length], ["kind", facts.kinds.length], ["side", 2],
    ["direction", facts.directions.length], ["load", facts.loads.length], ["material", facts.mu0.length * facts.tau0.length]])
    state[key] = whole(said[key], count, state[key]);
  const set = (key, ...places) => (value) => {
    state[key] = value;
    redraw(...(places.length ? places : EVERYTHING));
  };
  amount("mu0", {value: state.mu0, most: facts.mu0Most, step: 0.01, unit: "", changed: set("mu0")});
  amount("tau0", {value: state.tau0, most: facts.tau0Most, step: Number((facts.tau0Most / 200).toPrecision(1)), unit: " MPa",
    changed: set("tau0")});
  for (const id of ["mu0-control", "tau0-control"]) byId(id).hidden = !isMaps;
  byId("material").closest(".control").hidden = isMaps;
  choice("material", isMaps ? [] : facts.mu0.flatMap((mu0) => facts.tau0.map((tau0) => materialName({mu0, tau0}))), state.material,
    set("material"));
  choice("mechanics", facts.mechanics, state.mechanics, set("mechanics"));
  choice("kind", facts.kinds.map(({words}) => words), state.kind, set("kind"));
  choice("side", ["lower body", "upper body"], state.side, set("side", "contacts"));
  index("load", {value: state.load, count: facts.loads.length, name: loadName, changed: set("load")}).show();
  byId("direction-control").hidden = facts.directions.length < 2;
  const direction = index("direction", {value: state.direction, count: facts.directions.length,
    name: (d) => wayName(facts.directions[d]), changed: set("direction")});
  direction.show();
  const turn = (d) => {
    direction.set(state.direction = (d + facts.directions.length) % facts.directions.length);
    redraw(...EVERYTHING);
  };
  const compass = byId("compass");
  compass.addEventListener("keydown", (event) => {
    const step = {ArrowLeft: 1, ArrowUp: 1, ArrowRight: -1, ArrowDown: -1}[event.key];
    if (!step) return;
    event.preventDefault();
    turn(state.direction + step);
  });
  compass.addEventListener("click", (event) => {
    const {left, top} = compass.getBoundingClientRect();
    const {centre: [x, y]} = compass.axes;
    const angle = (Math.atan2(y - (event.clientY - top), event.clientX - left - x) * 180) / Math.PI;
    const apart = (one) => Math.abs(((one - angle + 540) % 360) - 180);
    turn(facts.directions.reduce((best, each, d) => (apart(each) < apart(facts.directions[best]) ? d : best), 0));
  });
  for (const [id, of, quantity] of [["friction", "load (mN)", "mu_s"], ["area", "load (mN)", "A/A0 (%)"], ["positions", "position", "mu_s"],
    ["compass", "direction (degrees)", "mu_s"], ["spectra", "wavelength (um)", "density (um^4)"]])
    if (drawings[id]) saves(byId(id), curveRows(id, of, quantity));
  if (drawings.contacts) saves(byId("contacts"), contactRows);
  for (const id of ["friction", "area"]) interactive(byId(id), {
    point: (x) => {
      const l = nearest(facts.loads.map(Math.log), Math.log(x));
      const texts = byId(id).drawn.series.map(({points}) => `${shown(points[l].value, 3)}${between(points[l])}`);
      note(byId(id), `${texts.join("; ")} at ${shown(facts.loads[l])} mN`);
    },
    leave: () => byId(id).axes && note(byId(id), ""),
    pick: (x) => {
      const slider = byId("load");
      slider.value = nearest(facts.loads.map(Math.log), Math.log(x));
      slider.dispatchEvent(new Event("input"));
    },
  });
  window.addEventListener("resize", () => redraw(...Object.keys(drawings)));
  atRest = () => address({...(isMaps ? {mu0: state.mu0, tau0: state.tau0, direction: state.direction} : {material: state.material}),
    load: state.load, mechanics: state.mechanics, kind: state.kind, side: state.side});
}

start(async () => {
  drawings = {answer: showAnswer, friction: showFriction, area: showArea, positions: showPositions, compass: showCompass,
    contacts: showContacts, spectra: showSpectra};
  const lacking = [...(facts.directions.length < 3 ? ["compass"] : []), ...(facts.picture ? [] : ["contacts"]), ...(facts.spectra ? [] : ["spectra"])];
  for (const id of lacking) {
    byId(id).closest("section").hidden = true;
    delete drawings[id];
  }
  if (isMaps) sums = await unpacked("sums", 8);
  if (facts.picture) {
    contactColumns = await unpacked("contacts", facts.contactBytes);
    for (const side of ["lower", "upper"]) heights.push(await inflated(side));
  }
  connect();
  Object.values(drawings).forEach((draw) => draw());
});
