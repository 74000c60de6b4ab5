// The page of studies: its state, its controls, and its words.

// ---- State ----------------------------------------------------------------------------------------------------------

const middle = (list) => list[Math.floor(list.length / 2)];
const results = facts.results.map((own) => ({facts: {...facts, ...own}, motions: []}));
const first = results[0].facts; // its dimensions, amplitudes and motions are picked from, and the other's nearest are shown
const state = {
  mu0: middle(facts.mu0),
  tau0: facts.tau0[0], // MPa
  motion: 0,
  amplitude: 0,
  dimension: Math.floor(first.dimensions.length / 2),
  load: Math.floor(facts.loadSteps / 2),
  pair: 0,
  approach: 0,
  range: null,
  seen: [0, first.dimensions.length - 1],
  quantity: "friction",
  colours: [0.1, 1],
  isLocked: false,
  pointed: null, // (dimension, load) under the pointer
};
let loads = [];
let allLoads = [];
let maps = [];
const tau0 = () => state.tau0 / 1000; // GPa
const COLOURS = ["var(--accent)", "var(--second)"];

const FRICTION = ["maps", "readout", "over", "friction", "area", "stiffness"];

/** The result of the motion that is picked, and where in it what is picked lies. */
function picked(r) {
  const {facts: own, motions} = results[r];
  const wanted = first.motions[state.motion];
  const motion = Math.max(0, own.motions.findIndex(
    ({sliding, direction}) => sliding === wanted.sliding && direction === wanted.direction));
  const near = (list, value) => nearest(list, value);
  const dimension = first.dimensions[state.pointed?.[0] ?? state.dimension];
  return {
    result: {facts: own, ...motions[motion]}, motion: own.motions[motion],
    d: near(own.dimensions, dimension), a: near(own.amplitudes, first.amplitudes[state.amplitude]),
  };
}

// ---- Words and figures ----------------------------------------------------------------------------------------------

const dimensionName = (value) => `D = ${value.toFixed(3)}`;

function showReadout() {
  const load = loads[state.pointed?.[1] ?? state.load];
  const answers = [];
  const figures = [];
  results.forEach((_, r) => {
    const {result, d, a} = picked(r);
    const [at] = readOff(result, "friction", d, a, [load], state.mu0, tau0());
    const dimension = result.facts.dimensions[d];
    if (r === 0) {
      answers.push(element("p", {class: "hint"}, `${state.pointed ? "Under the pointer" : "Picked"}: ${dimensionName(dimension)}, F`,
        element("sub", {}, "N"), ` = ${shown(load)} mN`));
      Object.assign(byId("readout").dataset, {dimension, load, mu0: state.mu0, tau0: tau0(), status: at.status,
        value: at.value, lower: at.lower, upper: at.upper});
    }
    const name = results.length > 1 ? [element("p", {class: "of", style: `color: ${COLOURS[r]}`}, result.facts.name)] : [];
    answers.push(...name, ...answer(at));
    figures.push(...name.map((each) => each.cloneNode(true)), ...figuresOf(result, at, dimension));
  });
  byId("answer").replaceChildren(...answers);
  byId("figures").replaceChildren(...figures);
}

function answer(at) {
  if (at.status !== "ok")
    return [element("p", {class: "value"}, at.status), element("p", {class: "interval"}, facts.statuses[at.status].why)];
  return [
    element("p", {class: "value"}, element("i", {}, "μ"), element("sub", {}, "s"), " = ", data(at.value, shown(at.value))),
    element("p", {class: "interval"}, ...(Number.isFinite(at.lower)
      ? [`${PERCENT} interval [`, data(at.lower, shown(at.lower)), ", ", data(at.upper, shown(at.upper)), "]"]
      : [`No interval: ${whyNoInterval()}`])),
  ];
}

function figuresOf(result, at, dimension) {
  const list = element("dl", {}, element("dt", {}, "Status"), element("dd", {class: "status"}, at.status));
  for (const [name, value] of Object.entries(at.validity ?? {})) {
    const {words, limit, isShare} = result.facts.validity[name];
    const text = isShare && Number.isFinite(value) ? `${(100 * value).toFixed(0)} %` : shown(value, 2);
    const beyond = value > limit;
    list.append(
      element("dt", {}, words),
      element("dd", beyond ? {class: "beyond"} : {}, beyond ? "⚠ " : "", data(value, text)),
    );
  }
  if (at.status !== "ok") return [list];
  const inFull = (value) => (Number.isFinite(value) ? value.toPrecision(9) : "none");
  const full = [at.value, at.lower, at.upper].map(inFull);
  return [list, element("p", {class: "full"},
    `In full: ${full[0]} [${full[1]}, ${full[2]}] at D = ${dimension}, ${at.load} mN, ` +
    `μ0 = ${state.mu0}, τ0 = ${state.tau0} MPa`)];
}

function whyNoInterval() {
  if (first.repetitions === 1) return "there is one repetition";
  if (!first.hasIntervals) return "there are too many repetitions for a page; the library has it";
  return "fewer than two repetitions carry load";
}

const TITLES = {friction: "_μ_~s~", width: "±", area: "_A_ (µm²)", stiffness: "mN/µm"};

function showMaps() {
  const entries = new Map();
  const amount = state.quantity;
  maps = results.map((_, r) => {
    const {result, a} = picked(r);
    return mapOf(result, amount, a, loads, state.mu0, tau0());
  });
  results.forEach(({facts: own}, r) => {
    const {d} = pickedStill(r);
    const [from, to] = seenOf(r);
    const legend = drawMap(byId(`map-${r}`), {
      facts: own, map: maps[r], loads, seen: [from, to], colours: state.colours, picked: [d, state.load],
      ticks: amount === "friction" ? facts.ticks : null, title: TITLES[amount],
    });
    for (const [picture, words] of legend) entries.set(words, picture);
  });
  byId("legend").replaceChildren(...[...entries].map(([words, picture]) => element("li", {}, picture, words)));
}

function pickedStill(r) {
  const pointed = state.pointed;
  state.pointed = null;
  const at = picked(r);
  state.pointed = pointed;
  return at;
}

/** First and last dimension that are seen, of a result. */
const seenOf = (r) => state.seen.map((d) => nearest(results[r].facts.dimensions, first.dimensions[d]));

function fitColours() {
  const shownMaps = maps.map((map, r) => ({value: map.value.map((row) => row.slice(seenOf(r)[0], seenOf(r)[1] + 1))}));
  return colourRange(facts, shownMaps);
}

const CURVES = {
  friction: {title: "friction coefficient _μ_~s~", isLog: false},
  area: {title: "true contact area _A_ (µm²)", isLog: true},
  stiffness: {title: "normal stiffness (mN/µm)", isLog: true},
};

function showCurve(id) {
  const series = results.flatMap(({facts: own}, r) => {
    if (id === "stiffness" && !own.hasStiffness) return [];
    const {result, d, a} = pickedStill(r);
    const points = readOff(result, id, d, a, loads, state.mu0, tau0()).map((point) => ({...point, x: point.load}));
    return [{points, colour: COLOURS[r], name: own.name}];
  });
  const x = {low: loads[0], high: loads.at(-1), isLog: true, title: "normal load _F_~N~ (mN)"};
  const drawn = drawCurves(byId(id), series, x, {...CURVES[id], picked: loads[state.load]});
  byId(`${id}-caption`).textContent = curveCaption(series, dimensionName(first.dimensions[state.dimension]), drawn, "load");
}

function showOver() {
  const load = loads[state.load];
  const series = results.map(({facts: own}, r) => {
    const {result, a} = pickedStill(r);
    const points = overDimensions(result, "friction", a, load, state.mu0, tau0());
    return {points: points.map((point) => ({...point, x: point.dimension})), colour: COLOURS[r], name: own.name};
  });
  const ends = edges(first.dimensions);
  const x = {low: ends[state.seen[0]], high: ends[state.seen[1] + 1], title: `fractal dimension _D_${first.convention}`};
  const drawn = drawCurves(byId("over"), series, x, {...CURVES.friction, picked: first.dimensions[state.dimension]});
  byId("over-caption").textContent = curveCaption(series, `${shown(load)} mN`, drawn, "dimension");
}

function curveCaption(series, where, [low, high], of) {
  const points = series.flatMap((each) => each.points);
  const ok = points.filter((point) => point.status === "ok");
  const amplitude = lengthName(first.amplitudes[state.amplitude]);
  const words = [`At ${where}, amplitude ${amplitude}, μ0 = ${state.mu0}, τ0 = ${state.tau0} MPa.`];
  if (first.motions.length > 1) words.push(`${first.motions[state.motion].words}.`);
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
    words.push(`No value at ${count} of ${counted(points.length, of)} (${status}): ${facts.statuses[status].why}.`);
  return words.join(" ");
}

const counted = (count, thing) => `${count} ${thing}${count === 1 ? "" : "s"}`;

function showExample() {
  const {facts: own, profiles, contacts} = results[0];
  const {shear} = own.motions[state.motion];
  const seen = exampleAt(own, profiles, contacts,
    {pair: state.pair, dimension: state.dimension, amplitude: state.amplitude, step: state.approach, shear});
  const exaggeration = drawExample(byId("profiles"), shear, own.example.spacing, seen);
  byId("profiles").drawn = seen;
  byId("profiles-caption").textContent = exampleCaption(seen, exaggeration);
}

function exampleCaption({dimension, amplitude, x, contacts, leftOut}, exaggeration) {
  const words = [
    `Pair ${state.pair + 1} at ${dimensionName(first.dimensions[dimension])}, amplitude ${lengthName(first.amplitudes[amplitude])}:`,
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

// ---- Tables ---------------------------------------------------------------------------------------------------------

const material = () => [state.mu0, state.tau0];

function curveRows(id) {
  const over = id === "over";
  const head = ["result", over ? "fractal dimension" : "load (mN)", id === "over" ? "friction" : id, "lower", "upper",
    "status", "mu0", "tau0 (MPa)"];
  return [head, ...byId(id).drawn.series.flatMap(({name, points}) => points.map(({x, value, lower, upper, status}) =>
    [name, x, value, lower, upper, status, ...material()]))];
}

function mapRows(r) {
  const {dimensions} = results[r].facts;
  return [["fractal dimension", "load (mN)", state.quantity, "status", "within validity", "mu0", "tau0 (MPa)"],
    ...loads.flatMap((load, l) => dimensions.map((dimension, d) => [dimension, load, maps[r].value[l][d] ?? NaN,
      maps[r].status[l][d], maps[r].trusted[l][d] ?? "", ...material()]))];
}

function exampleRows() {
  const {x, lower, upper} = byId("profiles").drawn;
  return [["x (um)", "lower (nm)", "upper (nm)"], ...x.map((at, i) => [at, lower[i], upper[i]])];
}

// ---- Controls -------------------------------------------------------------------------------------------------------

function sayIfStrong() {
  const isStrong = state.tau0 > facts.tau0Sane;
  byId("strong").hidden = !isStrong;
  byId("strong").textContent = `τ0 is above a tenth of the effective modulus, ${shown(facts.tau0Sane, 3)} MPa.`;
}

function connect() {
  const said = addressed();
  state.mu0 = numberOf(said.mu0, 0, 1e3, state.mu0);
  state.tau0 = numberOf(said.tau0, 0, 1e9, state.tau0);
  state.motion = Math.floor(numberOf(said.motion, 0, first.motions.length - 1, 0));
  state.amplitude = Math.floor(numberOf(said.amplitude, 0, first.amplitudes.length - 1, 0));
  const changed = () => {
    sayIfStrong();
    redraw(...FRICTION);
  };
  amount("mu0", {value: state.mu0, most: facts.mu0Most, step: 0.01, unit: "",
    changed: (value) => { state.mu0 = value; changed(); }});
  amount("tau0", {value: state.tau0, most: facts.tau0Most, step: Number((facts.tau0Most / 200).toPrecision(1)), unit: " MPa",
    changed: (value) => { state.tau0 = value; changed(); }});
  sayIfStrong();
  byId("convention").textContent = first.convention;
  choice("motion", first.motions.map(({words}) => words), state.motion, (m) => {
    state.motion = m;
    redraw(...FRICTION, "profiles");
  });
  byId("amplitude-label").textContent = `Amplitude (${first.measure === "height" ? "total height" : first.measure})`;
  choice("amplitude", first.amplitudes.map(lengthName), state.amplitude, (a) => {
    state.amplitude = a;
    redraw(...FRICTION, "profiles");
  });
  const begun = first.dimensions.length - 1;
  const d = said.d === undefined ? NaN : Number(said.d);
  if (Number.isFinite(d)) state.dimension = nearest(first.dimensions, d);
  state.seen = [numberOf(said.from, 0, begun, 0), numberOf(said.to, 0, begun, begun)].map(Math.floor);
  if (state.seen[0] > state.seen[1]) state.seen = [0, begun];
  const dimension = index("dimension", {value: state.dimension, count: first.dimensions.length,
    name: (value) => dimensionName(first.dimensions[value]), changed: (value) => {
      Object.assign(state, {dimension: value, pointed: null});
      redraw(...FRICTION, "profiles");
    }});
  dimension.show();
  connectExample(said);
  window.addEventListener("resize", () => redraw(...Object.keys(drawings)));
  if (allLoads.length) connectLoads(said, dimension, Number.isFinite(d));
}

function connectExample(said) {
  const {example, steps} = first;
  if (!example) {
    byId("profiles").closest("section").hidden = true;
    delete drawings.profiles;
    return;
  }
  state.pair = Math.floor(numberOf(said.pair, 0, example.pairs - 1, 0));
  state.approach = Math.floor(numberOf(said.step, 0, example.approaches.length - 1, (2 * example.approaches.length) / 3));
  choice("pair", Array.from({length: example.pairs}, (_, i) => String(i + 1)), state.pair, (pair) => {
    state.pair = pair;
    redraw("profiles");
  });
  index("approach", {value: state.approach, count: example.approaches.length,
    name: (k) => lengthName(steps[example.approaches[k]]), changed: (k) => {
      state.approach = k;
      redraw("profiles");
    }}).show();
  saves(byId("profiles"), exampleRows);
}

function connectLoads(said, dimension, isAddressed) {
  const load = index("load", {value: state.load, count: facts.loadSteps, name: (l) => `${shown(loads[l])} mN`,
    changed: (l) => {
      Object.assign(state, {load: l, pointed: null});
      redraw(...FRICTION);
    }});
  const take = (ends) => {
    const before = loads[state.load];
    state.range = ends;
    loads = geometric(...ends, facts.loadSteps);
    if (before) load.set(nearest(loads.map(Math.log), Math.log(before)));
    state.load = Number(byId("load").value);
    load.show();
    redraw(...FRICTION);
  };
  const showLoads = range("load", take);
  const setLoads = (ends) => {
    showLoads(ends);
    take(ends);
  };
  const low = numberOf(said.low, 1e-300, 1e300, allLoads[0]);
  const high = numberOf(said.high, NARROWEST * low, 1e300, NaN);
  setLoads(Number.isFinite(high) ? [low, high] : allLoads);
  byId("all-loads").addEventListener("click", () => setLoads(allLoads));

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

  const showColours = range("colour", (ends) => {
    state.colours = ends;
    byId("lock").checked = state.isLocked = true;
    redraw("maps");
  });
  byId("lock").addEventListener("change", () => {
    state.isLocked = byId("lock").checked;
    redraw("maps");
  });
  atRest = () => {
    if (wanted.has("maps")) showMaps();
    wanted.delete("maps");
    const fitted = state.isLocked || !maps.length ? state.colours : fitColours();
    if (String(fitted) !== String(state.colours)) {
      state.colours = fitted;
      showMaps();
    }
    if (!state.isLocked) showColours(state.colours);
    address(addressOf());
  };

  connectMaps(dimension, load, setLoads);
  // The first map tells where to begin.
  showMaps();
  const begins = beginning(maps[0]);
  if (!isAddressed) dimension.set(state.dimension = begins[0]);
  const at = numberOf(said.load, 1e-300, 1e300, NaN);
  load.set(state.load = Number.isFinite(at) ? nearest(loads.map(Math.log), Math.log(at)) : begins[1]);
  const ends = [numberOf(said.dark, 1e-300, 1e300, NaN), numberOf(said.light, 1e-300, 1e300, NaN)];
  if (ends[1] >= NARROWEST * ends[0]) {
    state.colours = ends;
    byId("lock").checked = state.isLocked = true;
  } else state.colours = fitColours();
  showColours(state.colours);
  for (const id of ["friction", "area", "stiffness", "over"]) connectCurve(id, dimension, load, setLoads);
}

function setSeen(from, to) {
  state.seen = [from, to];
  redraw("maps", "over");
}

function connectMaps(dimension, load, setLoads) {
  const pick = (d, l) => {
    Object.assign(state, {dimension: d, load: l, pointed: null}); // a finger that taps never leaves
    dimension.set(d);
    load.set(l);
    redraw(...FRICTION, "profiles");
  };
  results.forEach(({facts: own}, r) => {
    const place = element("div", {id: `map-${r}`, class: "plot tall", role: "application", tabindex: 0,
      "aria-label": `Map over fractal dimension and load${results.length > 1 ? ` of ${own.name}` : ""}; ` +
        "arrow keys move the picked point, whose values are said"});
    byId("maps").append(results.length > 1 ? element("h3", {style: `color: ${COLOURS[r]}`}, own.name) : "", place);
    saves(place, () => mapRows(r));
    const cell = (x, y) => {
      const d = edges(own.dimensions).findLastIndex((edge) => edge <= x);
      const l = edges(loads.map(Math.log)).findLastIndex((edge) => edge <= Math.log(y));
      const clamped = Math.min(Math.max(d, 0), own.dimensions.length - 1);
      return [nearest(first.dimensions, own.dimensions[clamped]), Math.min(Math.max(l, 0), loads.length - 1)];
    };
    interactive(place, {
      point: (x, y) => { state.pointed = cell(x, y); redraw("readout"); },
      leave: () => { if (state.pointed) { state.pointed = null; redraw("readout"); } },
      pick: (x, y) => pick(...cell(x, y)),
      zoom: (one, other) => {
        const [[d0, l0], [d1, l1]] = [cell(...one), cell(...other)];
        setSeen(Math.min(d0, d1), Math.max(d0, d1));
        if (l0 !== l1) setLoads([loads[Math.min(l0, l1)], loads[Math.max(l0, l1)]]);
      },
      all: () => { setSeen(0, first.dimensions.length - 1); setLoads(allLoads); },
    });
    place.addEventListener("keydown", (event) => {
      const step = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[event.key];
      if (!step) return;
      event.preventDefault();
      pick(Math.min(Math.max(state.dimension + step[0], state.seen[0]), state.seen[1]),
        Math.min(Math.max(state.load + step[1], 0), loads.length - 1));
    });
  });
}

function connectCurve(id, dimension, load, setLoads) {
  const place = byId(id);
  const over = id === "over";
  saves(place, () => curveRows(id));
  interactive(place, {
    point: (x) => {
      const points = place.drawn.series.map(({points: all}) => all[nearest(all.map((p) => (over ? p.x : Math.log(p.x))), over ? x : Math.log(x))]);
      const ends = (p) => (Number.isFinite(p.lower) ? ` [${shown(p.lower)}, ${shown(p.upper)}]` : "");
      note(place, points.map((p) => `${shown(p.value)}${ends(p)}`).join("; ") + ` at ${over ? "D = " : ""}${shown(points[0].x)}${over ? "" : " mN"}`);
    },
    leave: () => place.axes && note(place, ""),
    pick: (x) => {
      if (over) dimension.set(state.dimension = nearest(first.dimensions, x));
      else load.set(state.load = nearest(loads.map(Math.log), Math.log(x)));
      redraw(...FRICTION, "profiles");
    },
    zoom: ([x0], [x1]) => {
      const [low, high] = [Math.min(x0, x1), Math.max(x0, x1)];
      if (over) setSeen(...[low, high].map((x) => nearest(first.dimensions, x)));
      else if (high >= NARROWEST * low) setLoads([low, high].map((x) => Number(x.toPrecision(4))));
    },
    all: () => (over ? setSeen(0, first.dimensions.length - 1) : setLoads(allLoads)),
  });
}

function addressOf() {
  const values = {mu0: state.mu0, tau0: state.tau0, d: first.dimensions[state.dimension], load: loads[state.load]};
  if (first.motions.length > 1) values.motion = state.motion;
  if (first.amplitudes.length > 1) values.amplitude = state.amplitude;
  if (String(state.range) !== String(allLoads)) [values.low, values.high] = state.range;
  if (state.seen[0] > 0 || state.seen[1] < first.dimensions.length - 1) [values.from, values.to] = state.seen;
  if (state.quantity !== "friction") values.show = state.quantity;
  if (state.isLocked) [values.dark, values.light] = state.colours;
  if (first.example) Object.assign(values, {pair: state.pair, step: state.approach});
  return values;
}

// ---- Beginning ------------------------------------------------------------------------------------------------------

start(async () => {
  for (const [r, result] of results.entries()) {
    const {variables, perRepetition, motions, example} = result.facts;
    const [means, sums] = [
      parts(variables, motions.length, await unpacked(`means-${r}`, facts.bytes.means)),
      parts(perRepetition, motions.length, await unpacked(`sums-${r}`, facts.bytes.sums)),
    ];
    result.motions = means.map((each, m) => ({means: each, sums: sums[m]}));
    if (!example) continue;
    result.profiles = await unpacked(`profiles-${r}`, facts.bytes.profiles);
    result.contacts = await unpacked(`contacts-${r}`, facts.bytes.contacts);
  }
  const ranges = results.map(({facts: own}) => own.loads).filter((ends) => ends.length);
  if (ranges.length) allLoads = [Math.min(...ranges.map(([low]) => low)), Math.max(...ranges.map(([, high]) => high))];
  drawings = {maps: showMaps, readout: showReadout, over: showOver, friction: () => showCurve("friction"),
    area: () => showCurve("area"), stiffness: () => showCurve("stiffness"), profiles: showExample};
  const hide = (id) => {
    byId(id).closest("section").hidden = true;
    delete drawings[id];
  };
  if (!allLoads.length) {
    say("No pair of this study touches within its approaches: there is no load, no area and no friction to show.");
    for (const id of ["maps", "over", "friction", "area", "stiffness", "readout"]) hide(id);
    byId("controls").hidden = true;
  } else if (results.every(({facts: own}) => own.steps.length === 1)) {
    say("This study has one approach. Values at a load are read off between two, so there are none to show.");
  }
  if (!results.some(({facts: own}) => own.hasStiffness)) hide("stiffness");
  if (first.dimensions.length < 2) hide("over");
  connect();
  Object.keys(drawings).forEach((place) => drawings[place]());
});
