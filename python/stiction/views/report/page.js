// The page itself: its state, its controls, and its words.

const facts = JSON.parse(document.getElementById("facts").textContent);
const byId = (id) => document.getElementById(id);
const result = {facts, means: null, sums: null};
const example = {profiles: null, contacts: null};

// ---- State ----------------------------------------------------------------------------------------------------------

const middle = (list) => list[Math.floor(list.length / 2)];
const state = {
  mu0: middle(facts.mu0),
  tau0: facts.tau0[0], // MPa
  amplitude: 0,
  dimension: Math.floor(facts.dimensions.length / 2),
  load: Math.floor(facts.loadSteps / 2),
  example: 0,
  range: facts.loads,
  colours: null,
  pointed: null, // (dimension, load) under the pointer
};
let loads = [];
const tau0 = () => state.tau0 / 1000; // GPa

// What is drawn, by the id of its place on the page.
const drawings = {
  map: showMap,
  readout: showReadout,
  friction: () => showCurve("friction"),
  area: () => showCurve("area"),
  profiles: showExample,
};
const FRICTION = ["map", "readout", "friction", "area"];
const REST = 150; // ms without a change, after which what nobody sees is drawn as well
const wanted = new Set();
let frame = 0;
let rest = 0;

function redraw(...places) {
  if (!facts.loads.length) places = places.filter((place) => !FRICTION.includes(place));
  places.forEach((place) => wanted.add(place));
  cancelAnimationFrame(frame);
  frame = requestAnimationFrame(drawSeen);
}

function drawSeen() {
  drawSome((place) => {
    const {top, bottom} = byId(place).getBoundingClientRect();
    return top < innerHeight && bottom > 0;
  });
  clearTimeout(rest);
  rest = setTimeout(drawSome, REST, () => true);
}

function drawSome(isChosen) {
  for (const place of [...wanted].filter(isChosen)) {
    drawings[place]();
    wanted.delete(place);
  }
}

// ---- Words and figures ----------------------------------------------------------------------------------------------

const PERCENT = `${shown(100 * facts.confidence, 2)} %`;
const dimensionName = (d) => `D = ${facts.dimensions[d].toFixed(3)}`;

// A number that people see shortened, and programs in full.
const data = (value, text) => element("data", {value: String(value)}, text);

function showReadout() {
  const [d, l] = state.pointed ?? [state.dimension, state.load];
  const [at] = frictionAt(result, d, state.amplitude, [loads[l]], state.mu0, tau0());
  const readout = byId("readout");
  Object.assign(readout.dataset, {
    dimension: facts.dimensions[d], load: at.load, mu0: state.mu0, tau0: tau0(), status: at.status,
    value: at.value, lower: at.lower, upper: at.upper,
  });
  const children = [
    element("p", {class: "hint"}, `${state.pointed ? "Under the pointer" : "Picked"}: ${dimensionName(d)}, F`,
      element("sub", {}, "N"), ` = ${shown(at.load)} mN`),
  ];
  if (at.status === "ok") {
    children.push(
      element("p", {class: "value"}, element("i", {}, "μ"), element("sub", {}, "s"), " = ",
        data(at.value, shown(at.value))),
      element("p", {class: "interval"}, ...intervalText(at)),
    );
  } else {
    children.push(element("p", {class: "value"}, at.status), element("p", {class: "interval"}, facts.statuses[at.status].why));
  }
  const list = element("dl", {}, element("dt", {}, "Status"), element("dd", {class: "status"}, at.status));
  for (const [name, value] of Object.entries(at.validity ?? {})) {
    const {words, limit, isShare} = facts.validity[name];
    const text = isShare ? `${(100 * value).toFixed(0)} %` : shown(value, 2);
    const beyond = value > limit;
    list.append(
      element("dt", {}, words),
      element("dd", beyond ? {class: "beyond"} : {}, beyond ? "⚠ " : "", data(value, text)),
    );
  }
  const figures = [list];
  if (at.status === "ok") {
    const inFull = (value) => (Number.isFinite(value) ? value.toPrecision(9) : "none");
    const full = [at.value, at.lower, at.upper].map(inFull);
    figures.push(element("p", {class: "full"},
      `In full: ${full[0]} [${full[1]}, ${full[2]}] at D = ${facts.dimensions[d]}, ${at.load} mN, ` +
      `μ0 = ${state.mu0}, τ0 = ${state.tau0} MPa`));
  }
  byId("answer").replaceChildren(...children);
  byId("figures").replaceChildren(...figures);
}

function intervalText(at) {
  if (Number.isFinite(at.lower)) {
    return [`${PERCENT} interval [`, data(at.lower, shown(at.lower)), ", ", data(at.upper, shown(at.upper)), "]"];
  }
  return [`No interval: ${whyNoInterval()}`];
}

function whyNoInterval() {
  if (facts.repetitions === 1) return "there is one repetition";
  if (!facts.hasIntervals) return "there are too many repetitions for a page; the library has it";
  return "fewer than two repetitions carry load";
}

function showMap() {
  const map = frictionMap(result, state.amplitude, loads, state.mu0, tau0());
  drawMap(byId("map"), byId("legend"), facts, map, loads, state.colours, [state.dimension, state.load]);
}

const CURVES = {
  friction: {at: frictionAt, title: "friction coefficient <i>μ</i><sub>s</sub>", wantsLog: false},
  area: {at: areaAt, title: "true contact area <i>A</i> (µm²)", wantsLog: true},
};

function showCurve(id) {
  const {at, title, wantsLog} = CURVES[id];
  const points = at(result, state.dimension, state.amplitude, loads, state.mu0, tau0());
  const drawn = drawCurve(byId(id), facts, points, state.load, title, wantsLog);
  byId(`${id}-caption`).textContent = curveCaption(points, ...drawn);
}

function curveCaption(points, low, high) {
  const ok = points.filter((point) => point.status === "ok");
  const amplitude = lengthName(facts.amplitudes[state.amplitude]);
  const words = [
    `At ${dimensionName(state.dimension)}, amplitude ${amplitude}, μ0 = ${state.mu0}, τ0 = ${state.tau0} MPa.`,
  ];
  if (ok.length && ok.every((point) => Number.isFinite(point.lower))) {
    words.push(`Shaded: ${PERCENT} interval.`);
    const cut = [];
    if (ok.some((point) => point.upper > high)) cut.push("above");
    if (ok.some((point) => point.lower < low)) cut.push("below");
    if (cut.length) words.push(`It is cut off ${cut.join(" and ")}; pointing at the curve tells its ends.`);
  }
  else if (ok.length) words.push(`No interval: ${whyNoInterval()}.`);
  if (ok.some((point) => point.validity.share_beyond_hertz > facts.validity.share_beyond_hertz.limit))
    words.push("Dotted: over half of the load on overlaps above a tenth of the radius.");
  const counts = new Map();
  for (const point of points) if (point.status !== "ok") counts.set(point.status, (counts.get(point.status) ?? 0) + 1);
  for (const [status, count] of counts)
    words.push(`No value at ${count} of ${points.length} loads (${status}): ${facts.statuses[status].why}.`);
  return words.join(" ");
}

function showExample() {
  const {profiles, contacts} = example;
  const seen = exampleAt(facts, profiles, contacts, state.dimension, state.amplitude, state.example);
  const exaggeration = drawExample(byId("profiles"), facts, seen);
  byId("profiles-caption").textContent = exampleCaption(seen, exaggeration);
}

function exampleCaption({dimension, amplitude, x, contacts, leftOut}, exaggeration) {
  const words = [
    `The first pair at ${dimensionName(dimension)}, amplitude ${lengthName(facts.amplitudes[amplitude])}:`,
    `${x.length} points of it around where the two first touch. Vertical exaggeration: ${shown(exaggeration, 2)}.`,
  ];
  const opposing = contacts.filter((contact) => contact.opposes).length;
  const count = contacts.length + leftOut;
  if (count) {
    const strongest = Math.max(...contacts.map((contact) => contact.force));
    words.push(
      `${count} ${count === 1 ? "contact" : "contacts"} here at this approach; diamonds are on slopes that oppose`,
      `the motion (${opposing}), circles are not (${contacts.length - opposing}). Arrows: the normal force on the upper`,
      `body, in its true direction; lengths go with its square root, and the strongest is ${shown(strongest, 3)} mN.`,
    );
  } else words.push("No contacts here at this approach.");
  if (leftOut) words.push(`The ${leftOut} weakest are not drawn.`);
  return words.join(" ");
}

// ---- Controls -------------------------------------------------------------------------------------------------------

/** A slider and a number that mean the same; the number takes any value from 0 on. */
function friction(id, most, step) {
  const [slider, number] = [byId(id), byId(`${id}-number`)];
  Object.assign(slider, {min: 0, max: most, step});
  slider.value = number.value = state[id];
  slider.addEventListener("input", () => {
    number.value = slider.value;
    byId(`${id}-wrong`).hidden = true;
    state[id] = Number(slider.value);
    changed();
  });
  number.addEventListener("input", () => {
    byId(`${id}-wrong`).hidden = number.validity.valid;
    if (!number.validity.valid) return;
    state[id] = Number(number.value);
    slider.value = number.value;
    changed();
  });
  const changed = () => {
    sayIfStrong();
    redraw(...FRICTION);
  };
}

function sayIfStrong() {
  const isStrong = state.tau0 > facts.tau0Sane;
  byId("strong").hidden = !isStrong;
  byId("strong").textContent = `τ0 is above a tenth of the effective modulus, ${shown(facts.tau0Sane, 3)} MPa.`;
}

/** A slider over the indices of a list. */
function index(id, key, count, name, ...changes) {
  const slider = byId(id);
  slider.max = count - 1;
  slider.value = state[key];
  slider.disabled = count < 2;
  const show = () => {
    byId(`${id}-text`).textContent = name(state[key]);
    slider.setAttribute("aria-valuetext", name(state[key]));
  };
  slider.addEventListener("input", () => {
    state[key] = Number(slider.value);
    state.pointed = null;
    show();
    redraw(...changes);
  });
  return {show, set: (value) => { slider.value = state[key] = value; show(); }};
}

const NARROWEST = 1.01; // of a range: the loads in it are told apart by five digits

/** Two numbers, the lower and the higher end of a range. */
function range(id, taken) {
  const [low, high, wrong] = ["low", "high", "wrong"].map((part) => byId(`${id}-${part}`));
  const setWrong = (isWrong) => {
    wrong.hidden = !isWrong;
    for (const each of [low, high]) each.setCustomValidity(isWrong ? wrong.textContent : "");
  };
  for (const end of [low, high]) {
    end.addEventListener("input", () => {
      const ends = [Number(low.value), Number(high.value)];
      const ordered = ends[0] > 0 && ends[1] >= NARROWEST * ends[0] && ends.every(Number.isFinite);
      setWrong(!ordered);
      if (ordered) taken(ends);
    });
  }
  return (ends) => {
    [low.value, high.value] = ends.map((end) => (end < 1e-3 ? end.toExponential() : end));
    setWrong(false);
    taken(ends);
  };
}

function connect() {
  for (const form of document.forms) form.addEventListener("submit", (event) => event.preventDefault());
  friction("mu0", facts.mu0Most, 0.01);
  friction("tau0", facts.tau0Most, Number((facts.tau0Most / 200).toPrecision(1)));
  byId("convention").textContent = facts.convention;

  const amplitude = byId("amplitude");
  amplitude.append(...facts.amplitudes.map((value, a) => element("option", {value: a}, lengthName(value))));
  byId("amplitude-label").textContent = `Amplitude (${facts.measure === "height" ? "total height" : facts.measure})`;
  amplitude.disabled = facts.amplitudes.length < 2;
  amplitude.addEventListener("change", () => {
    state.amplitude = Number(amplitude.value);
    redraw(...FRICTION, "profiles");
  });

  const dimension = index("dimension", "dimension", facts.dimensions.length, dimensionName, ...FRICTION, "profiles");
  const load = index("load", "load", facts.loadSteps, (l) => `${shown(loads[l])} mN`, ...FRICTION);
  const {approaches} = facts.example;
  state.example = Math.floor((2 * approaches.length) / 3);
  const approachName = (k) => lengthName(facts.approaches[approaches[k]]);
  const approach = index("approach", "example", approaches.length, approachName, "profiles");
  [dimension, approach].forEach((slider) => slider.show());
  window.addEventListener("resize", () => redraw("map", "profiles"));
  if (!facts.loads.length) return;

  const setLoads = range("load", (ends) => {
    state.range = ends;
    loads = geometric(...ends, facts.loadSteps);
    load.show();
    redraw(...FRICTION);
  });
  const setColours = range("colour", (ends) => {
    state.colours = ends;
    redraw("map");
  });
  setLoads(facts.loads);
  setColours(colourRange(facts, facts.mu0.flatMap((m) => facts.tau0.flatMap(
    (t) => facts.amplitudes.map((_, a) => frictionMap(result, a, loads, m, t / 1000))))));
  byId("all-loads").addEventListener("click", () => setLoads(facts.loads));
  byId("fit-colours").addEventListener("click", () => {
    setColours(colourRange(facts, [frictionMap(result, state.amplitude, loads, state.mu0, tau0())]));
  });

  showMap(); // which makes it something that says what is pointed at
  const map = byId("map");
  const cell = (event) => {
    const [l, d] = event.points.find((point) => point.data.type === "heatmap")?.pointIndex ?? [];
    return d === undefined ? null : [d, l];
  };
  map.on("plotly_hover", (event) => {
    state.pointed = cell(event);
    redraw("readout");
  });
  map.on("plotly_unhover", () => {
    state.pointed = null;
    redraw("readout");
  });
  map.on("plotly_click", (event) => {
    const [d, l] = cell(event) ?? [state.dimension, state.load];
    state.pointed = null; // a finger that taps never leaves
    dimension.set(d);
    load.set(l);
    redraw(...FRICTION, "profiles");
  });
}

// ---- Beginning ------------------------------------------------------------------------------------------------------

function say(text) {
  byId("trouble").hidden = false;
  byId("trouble").textContent = text;
}

async function inflated(id) {
  const element = byId(`packed-${id}`);
  const text = atob(element.textContent);
  element.remove();
  const bytes = Uint8Array.from(text, (character) => character.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

const unpacked = async (id) => doubles(await inflated(id), facts.bytes[id]);

async function begin() {
  if (typeof DecompressionStream === "undefined") return say("This page needs a browser of 2023 or later.");
  const library = document.createElement("script");
  library.textContent = new TextDecoder().decode(await inflated("plotly"));
  document.head.append(library);
  result.means = parts(facts.variables, await unpacked("means"));
  result.sums = parts(facts.perRepetition, await unpacked("sums"));
  example.profiles = await unpacked("profiles");
  example.contacts = await unpacked("contacts");
  if (!facts.loads.length) {
    say("No pair of this study touches within its approaches: there is no load, no area and no friction to show.");
    for (const id of ["map", "friction", "area"]) byId(id).closest("section").hidden = true;
    byId("controls").hidden = true;
  } else if (facts.approaches.length === 1) {
    say("This study has one approach. Values at a load are read off between two, so there are none to show.");
  }
  connect();
  redraw(...FRICTION, "profiles");
  drawSome(() => true);
  byId("main").setAttribute("aria-busy", "false");
}

begin().catch((error) => say(`This page could not be drawn: ${error.message}`));
