// How numbers are drawn, as SVG: every function takes the element it draws in and what it draws, and knows nothing of the
// state of the page. Colours are variables of the style sheet, so that dark and print need no drawing anew.

// ---- Elements -------------------------------------------------------------------------------------------------------

/** An element with attributes and children; text is never markup. */
function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

function shape(name, attributes = {}, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

/** Words of an axis: _F_ is in italics, ~N~ below the line. */
function rich(words, attributes) {
  const text = shape("text", attributes);
  let drop = 0;
  for (const part of words.split(/(_[^_]+_|~[^~]+~)/).filter(Boolean)) {
    const isSub = part.startsWith("~");
    const style = isSub ? {"font-size": "75%"} : part.startsWith("_") ? {"font-style": "italic"} : {};
    const dy = isSub ? 0.3 : -drop;
    text.append(shape("tspan", {...style, dy: `${dy * (isSub ? 1 : 0.75)}em`}, part.replaceAll(/^[_~]|[_~]$/g, "")));
    drop = isSub ? 0.3 : 0;
  }
  return text;
}

const rem = () => parseFloat(getComputedStyle(document.documentElement).fontSize);

const path = (points) => points.map(([x, y], i) => `${i ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");

/** Runs of points that are all known. */
function runs(points, isKnown) {
  const found = [[]];
  for (const point of points) isKnown(point) ? found.at(-1).push(point) : found.push([]);
  return found.filter((run) => run.length);
}

// ---- Axes -----------------------------------------------------------------------------------------------------------

/** Positions of values on an axis {low, high, isLog} between two ends, pixels. */
function scaleOf({low, high, isLog}, from, to) {
  const on = isLog ? Math.log : (value) => value;
  const off = isLog ? Math.exp : (value) => value;
  const [first, span] = [on(low), on(high) - on(low) || 1];
  const at = (value) => from + ((on(value) - first) / span) * (to - from);
  at.value = (position) => off(first + ((position - from) / (to - from)) * span);
  return at;
}

/** Axes {low, high, isLog, title} in an element: what is drawn with the scales x and y into `inside` is clipped. */
function axes(place, x, y, top = 0) {
  const unit = rem();
  const [width, height] = [Math.max(place.clientWidth, 8 * unit), Math.max(place.clientHeight, 8 * unit)];
  const box = {left: 4.4 * unit, right: width - unit, top: (0.6 + top) * unit, bottom: height - 3.2 * unit};
  const small = 0.8125 * unit;
  const picture = shape("svg", {width, height, viewBox: `0 0 ${width} ${height}`, "font-size": small,
    "font-family": "system-ui, 'DejaVu Sans', sans-serif", style: "fill: var(--ink)", "aria-hidden": "true"});
  const [X, Y] = [scaleOf(x, box.left, box.right), scaleOf(y, box.bottom, box.top)];
  const frame = {x: box.left, y: box.top, width: box.right - box.left, height: box.bottom - box.top};
  const lines = shape("g", {style: "stroke: var(--muted)", fill: "none"});
  const texts = shape("g");
  for (const {value, text} of ticksOf(x.low, x.high, x.isLog, Math.max(2, Math.floor(frame.width / (3.6 * unit))))) {
    const at = X(value);
    lines.append(shape("path", {d: `M${at} ${box.bottom}v${(text ? 0.35 : 0.2) * unit}`}));
    if (text) texts.append(shape("text", {x: at, y: box.bottom + 1.25 * unit, "text-anchor": "middle"}, text));
  }
  for (const {value, text} of ticksOf(y.low, y.high, y.isLog, Math.max(2, Math.floor(frame.height / (2.2 * unit))))) {
    const at = Y(value);
    lines.append(shape("path", {d: `M${box.left} ${at}h${-(text ? 0.35 : 0.2) * unit}`}));
    if (text) texts.append(shape("text", {x: box.left - 0.5 * unit, y: at + 0.3 * small, "text-anchor": "end"}, text));
  }
  texts.append(
    rich(x.title, {x: (box.left + box.right) / 2, y: height - 0.5 * unit, "text-anchor": "middle"}),
    rich(y.title, {transform: `translate(${unit} ${(box.top + box.bottom) / 2}) rotate(-90)`, "text-anchor": "middle"}),
  );
  const clip = `${place.id}-clip`;
  const inside = shape("g", {"clip-path": `url(#${clip})`});
  picture.append(
    shape("defs", {}, shape("clipPath", {id: clip}, shape("rect", frame))),
    inside, lines, shape("rect", {...frame, style: "fill: none; stroke: var(--muted)"}), texts);
  place.replaceChildren(picture);
  return Object.assign(place, {axes: {X, Y, box, frame, picture, inside, unit, small}}).axes;
}

/** What people do on axes: point, leave, pick, drag a rectangle, double-click. Called once; the axes may change. */
function interactive(place, {point, leave, pick, zoom, all}) {
  let from = null;
  let rectangle = null;
  const at = (event) => {
    const {left, top} = place.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  };
  const isInside = ([x, y]) => {
    const {box} = place.axes ?? {};
    return box && x >= box.left && x <= box.right && y >= box.top && y <= box.bottom;
  };
  const values = ([x, y]) => [place.axes.X.value(x), place.axes.Y.value(y)];
  place.addEventListener("pointerdown", (event) => {
    from = isInside(at(event)) && event.isPrimary && event.button === 0 ? at(event) : null;
  });
  place.addEventListener("pointermove", (event) => {
    const here = at(event);
    if (from && zoom && event.pointerType !== "touch" && Math.hypot(here[0] - from[0], here[1] - from[1]) > 8) {
      const {box, picture} = place.axes;
      const [x, y] = [Math.min(Math.max(here[0], box.left), box.right), Math.min(Math.max(here[1], box.top), box.bottom)];
      rectangle?.remove();
      rectangle = shape("rect", {x: Math.min(x, from[0]), y: Math.min(y, from[1]), width: Math.abs(x - from[0]),
        height: Math.abs(y - from[1]), style: "fill: var(--accent); fill-opacity: 0.2; stroke: var(--accent)"});
      rectangle.to = [x, y];
      picture.append(rectangle);
    }
    else if (isInside(here) && event.pointerType !== "touch") point?.(...values(here));
    else leave?.();
  });
  place.addEventListener("pointerleave", () => leave?.());
  window.addEventListener("pointerup", (event) => {
    if (from && rectangle) zoom(values(from), values(rectangle.to));
    else if (from && event.target instanceof Node && place.contains(event.target)) pick?.(...values(from));
    rectangle?.remove();
    from = rectangle = null;
  });
  place.addEventListener("dblclick", () => all?.());
}

// ---- Colours --------------------------------------------------------------------------------------------------------

// Sixteenths of viridis and eighths of cividis, which are in the public domain.
const VIRIDIS = ["440154", "48186a", "472d7b", "424086", "3b528b", "33638d", "2c728e", "26828e", "21918c", "1fa088",
  "28ae80", "3fbc73", "5ec962", "84d44b", "addc30", "d8e219", "fde725"];
const GREYS = ["202428", "f4f5f6"];

/** A colour, [red, green, blue], at a share of a scale. */
function colourAt(scale, share) {
  const place = Math.min(Math.max(share, 0), 1) * (scale.length - 1);
  const [i, part] = [Math.min(Math.floor(place), scale.length - 2), place - Math.min(Math.floor(place), scale.length - 2)];
  const bytes = (hex) => [0, 2, 4].map((k) => parseInt(hex.slice(k, k + 2), 16));
  const [one, other] = [bytes(scale[i]), bytes(scale[i + 1])];
  return one.map((byte, k) => Math.round(byte + part * (other[k] - byte)));
}

const LEVELS = 96;
const LEVEL_COLOURS = Array.from({length: LEVELS}, (_, i) => `rgb(${colourAt(VIRIDIS, i / (LEVELS - 1))})`);

// ---- The map ---------------------------------------------------------------------------------------------------------

const HATCHES = {
  "not-reached": ["var(--paper)", "M-2 2L2 -2M0 8L8 0M6 10L10 6"],
  "below-range": ["var(--line)", "M-2 6L2 10M0 0L8 8M6 -2L10 2"],
  "no-contact": ["var(--paper)", "M3.9 4h.2"],
  "self-locked": ["#7a0019", ""],
};

function hatch(name, id) {
  const [ground, lines] = HATCHES[name];
  return shape("pattern", {id, width: 8, height: 8, patternUnits: "userSpaceOnUse"},
    shape("rect", {width: 8, height: 8, style: `fill: ${ground}`}),
    shape("path", {d: lines, "stroke-width": 1.3, "stroke-linecap": "round", style: "stroke: var(--muted); fill: none"}));
}

function swatch(...shapes) {
  const frame = {x: 0.5, y: 0.5, width: 23, height: 15};
  return shape("svg", {width: 24, height: 16, "aria-hidden": "true"}, ...shapes.map((each) => each(frame)),
    shape("rect", {...frame, style: "fill: none; stroke: var(--muted)"}));
}

const ringed = (x, y, size, width = 2.5) => [["var(--paper)", 2 * width + 1], ["var(--ring)", width]].map(([colour, w]) =>
  shape("circle", {cx: x, cy: y, r: size, "stroke-width": w, style: `fill: none; stroke: ${colour}`}));

/** A quantity over dimension and load: map of `mapOf` between dimensions [first, last], colours between low and high, and
 * the picked cell [d, l]. Returns the entries of the legend. */
function drawMap(place, {facts, map, loads, seen: [first, last], colours: [low, high], ticks, picked, title}) {
  const x = edges(facts.dimensions);
  const y = edges(loads.map(Math.log)).map(Math.exp);
  const {X, Y, box, frame, inside, picture, unit} = axes(
    place, {low: x[first], high: x[last + 1], title: `fractal dimension _D_${facts.convention}`},
    {low: y[0], high: y.at(-1), isLog: true, title: "normal load _F_~N~ (mN)"}, 2.4);
  const [xs, ys] = [x.map(X), y.map(Y)];
  const cell = (d, l) =>
    `M${xs[d].toFixed(1)} ${ys[l].toFixed(1)}V${ys[l + 1].toFixed(1)}H${xs[d + 1].toFixed(1)}V${ys[l].toFixed(1)}z`;
  const levels = Array.from({length: LEVELS}, () => []);
  const others = {};
  const veiled = [];
  const scale = (LEVELS - 1) / Math.log(high / low);
  map.value.forEach((row, l) => row.forEach((value, d) => {
    if (value === null || (map.status[l][d] !== "ok")) {
      (others[map.status[l][d]] ??= []).push(cell(d, l));
      return;
    }
    const level = value > 0 ? Math.round(Math.log(value / low) * scale) : 0;
    levels[Math.min(Math.max(level, 0), LEVELS - 1)].push(cell(d, l));
    if (!map.trusted[l][d]) veiled.push(cell(d, l));
  }));
  const legend = [];
  levels.forEach((cells, i) => {
    if (cells.length) inside.append(shape("path", {d: cells.join(""), fill: LEVEL_COLOURS[i], stroke: LEVEL_COLOURS[i],
      "stroke-width": 0.4}));
  });
  for (const [name, cells] of Object.entries(others)) {
    if (name === "ok") continue; // a value without an interval
    const id = `${place.id}-${name}`;
    inside.append(hatch(name, id), shape("path", {d: cells.join(""), fill: `url(#${id})`}));
    legend.push([swatch(() => hatch(name, `${id}-legend`), (each) => shape("rect", {...each, fill: `url(#${id}-legend)`})),
      facts.statuses[name].short]);
  }
  if (veiled.length) {
    const veil = {style: "fill: var(--paper); fill-opacity: 0.5"};
    const lines = boundary(map.trusted, xs, ys).map(([x0, y0, x1, y1]) => `M${x0} ${y0}L${x1} ${y1}`).join("");
    inside.append(shape("path", {d: veiled.join(""), ...veil}));
    for (const [colour, width] of [["var(--paper)", 3.5], ["var(--ink)", 1.5]])
      inside.append(shape("path", {d: lines, "stroke-width": width, style: `fill: none; stroke: ${colour}`}));
    legend.push([swatch((each) => shape("rect", {...each, fill: LEVEL_COLOURS[48]}), (each) => shape("rect", {...each, ...veil})),
      "veiled: over half of the load beyond Hertz (overlap > radius / 10) or on radii below the grid spacing"]);
  }
  inside.append(...ringed((xs[picked[0]] + xs[picked[0] + 1]) / 2, (ys[picked[1]] + ys[picked[1] + 1]) / 2, 0.42 * unit));
  legend.push([swatch(() => shape("rect"), () => ringed(12, 8, 5)[1]), "picked point"]);
  const values = map.value.flat().filter((value) => value !== null);
  if (values.some((value) => value > high))
    legend.push([swatch((each) => shape("rect", {...each, fill: LEVEL_COLOURS.at(-1)})), `${shown(high, 2)} and above`]);
  if (values.some((value) => value < low))
    legend.push([swatch((each) => shape("rect", {...each, fill: LEVEL_COLOURS[0]})), `${shown(low, 2)} and below`]);
  picture.append(...colourBar(`${place.id}-scale`, {...frame, y: 0.9 * unit, height: 0.8 * unit}, low, high, ticks, title, unit));
  return legend;
}

function colourBar(id, frame, low, high, ticks, title, unit) {
  const stops = VIRIDIS.map((hex, i) => shape("stop", {offset: i / (VIRIDIS.length - 1), "stop-color": `#${hex}`}));
  const at = scaleOf({low, high, isLog: true}, frame.x, frame.x + frame.width);
  let last = -Infinity;
  const inside = (ticks ?? []).filter((tick) => tick >= low * 0.999 && tick <= high * 1.001);
  const marks = (inside.length > 2 ? inside : ticksOf(low, high, true, 8).filter(({text}) => text).map(({value}) => value))
    .filter((tick) => at(tick) - last >= 2.6 * unit && (last = at(tick), true));
  return [
    shape("linearGradient", {id}, ...stops),
    shape("rect", {...frame, fill: `url(#${id})`}),
    ...marks.flatMap((tick) => [
      shape("path", {d: `M${at(tick)} ${frame.y + frame.height}v${0.25 * unit}`, style: "stroke: var(--muted)"}),
      shape("text", {x: at(tick), y: frame.y + frame.height + 1.1 * unit, "text-anchor": "middle"}, tickText(tick)),
    ]),
    rich(title, {x: frame.x - 0.5 * unit, y: frame.y + 0.7 * unit, "text-anchor": "end"}),
  ];
}

// ---- Curves ---------------------------------------------------------------------------------------------------------

const MOST_BAND = 2.5; // times the highest value, of a band on a linear scale
const MOST_BAND_LOG = 100; // times the highest or lowest value, on a logarithmic one
const LEAST_LOG = 10; // of a logarithmic scale, its ends' ratio

/** Range of an axis of values with intervals: a band may be cut off, or a wide one would make a flat line of the rest. */
function rangeOf(points, isLog) {
  const ok = points.filter((point) => Number.isFinite(point.value));
  const ends = ok.flatMap((point) => [point.value, point.lower, point.upper]).filter((value) => value > 0);
  const values = ok.map((point) => point.value).filter((value) => value > 0);
  if (!values.length) return [isLog ? 0.1 : 0, 1];
  const [least, most] = [Math.min(...values), Math.max(...values)];
  if (!isLog) return [0, Math.min(1.05 * Math.max(...ends), MOST_BAND * most)];
  const low = Math.max(Math.min(...ends) / 1.3, least / MOST_BAND_LOG);
  const high = Math.min(Math.max(...ends) * 1.3, most * MOST_BAND_LOG);
  const missing = Math.max(1, Math.sqrt((1.01 * LEAST_LOG) / (high / low)));
  return [low / missing, high * missing];
}

/** Series {points of {x, value, lower, upper, trusted}, colour, name} with bands over an axis, one x of them ringed. The
 * points that are known are marked if there are few. Returns the range of values that is drawn. */
function drawCurves(place, series, x, {title, isLog, picked, levels = [], isScatter = false}) {
  const all = series.flatMap(({points}) => points);
  const isUsed = isLog && all.some(({value}) => value > 0);
  const [low, high] = rangeOf([...all, ...levels.map((each) => ({...each, lower: NaN, upper: NaN}))], isUsed);
  const {X, Y, box, inside, unit, small} = axes(place, x, {low, high, isLog: isUsed, title});
  const at = ({x: value}, y) => [X(value), Y(Math.min(Math.max(y, low), high))];
  const isDrawn = ({value}) => Number.isFinite(value) && !(isUsed && value <= 0);
  for (const {points, colour} of series)
    for (const run of runs(points, ({lower, value}) => Number.isFinite(lower) && isDrawn({value})))
      inside.append(shape("path", {
        d: `${path([...run.map((p) => at(p, p.lower)), ...run.map((p) => at(p, p.upper)).reverse()])}z`,
        style: `fill: ${colour}; fill-opacity: 0.2`,
      }));
  for (const {value, name, colour} of levels) {
    inside.append(shape("path", {d: path([[box.left, Y(value)], [box.right, Y(value)]]), "stroke-width": 1.5,
      "stroke-dasharray": "7 4", style: `fill: none; stroke: ${colour}`}),
    shape("text", {x: box.left + 0.5 * unit, y: Y(value) - 0.3 * unit,
      style: "paint-order: stroke; stroke: var(--paper); stroke-width: 3px"}, name));
  }
  const taken = [];
  for (const {points, colour, name} of series) {
    const stroke = (d, more) => shape("path", {d, "stroke-width": 2.2, style: `fill: none; stroke: ${colour}`, ...more});
    for (const run of runs(points, isDrawn)) {
      if (!isScatter) inside.append(stroke(path(run.map((p) => at(p, p.value))), {"stroke-dasharray": "2 4"}));
      for (const solid of runs(run, ({trusted}) => trusted)) inside.append(stroke(path(solid.map((p) => at(p, p.value)))));
      if (isScatter || points.length <= 30) inside.append(...run.map((p) => at(p, p.value)).map(([cx, cy]) =>
        shape("circle", {cx, cy, r: 3, style: `fill: ${colour}`})));
    }
    const here = points.find((point) => point.x === picked && isDrawn(point));
    if (here) inside.append(...ringed(...at(here, here.value), 0.35 * unit));
    const last = points.findLast(isDrawn);
    if (series.length < 2 || !last) continue;
    let y = Math.max(Y(last.value) - 0.5 * unit, box.top + small);
    if (taken.some((other) => Math.abs(other - y) < 1.2 * unit)) y = taken[0] + 1.3 * unit;
    taken.push(y);
    inside.append(shape("text", {x: Math.min(at(last, 0)[0], box.right) - 0.4 * unit, y, "text-anchor": "end",
      style: `fill: ${colour}; font-weight: 600; paint-order: stroke; stroke: var(--paper); stroke-width: 3px`}, name));
  }
  if (!all.some(isDrawn)) inside.append(shape("text", {x: (box.left + box.right) / 2, y: (box.top + box.bottom) / 2,
    "text-anchor": "middle"}, "no value in this range"));
  place.drawn = {series, low, high, x};
  return [low, high];
}

/** Words in the upper right corner of axes, in place of those that were there. */
function note(place, words) {
  const {picture, box, unit} = place.axes;
  picture.querySelector(".note")?.remove();
  if (words) picture.append(shape("text", {class: "note", x: box.right - 0.5 * unit, y: box.top + 1.2 * unit,
    "text-anchor": "end", style: "paint-order: stroke; stroke: var(--paper); stroke-width: 4px"}, words));
}

// ---- Example profiles ----------------------------------------------------------------------------------------------

/** The bodies and contacts of `exampleAt`; returns how many times heights are drawn larger than lengths. */
function drawExample(place, shear, spacing, {x, lower, upper, approach, contacts}) {
  const bottom = Math.min(...lower, ...upper);
  const top = Math.max(...upper) + approach;
  const pad = 0.06 * (top - bottom || 1);
  const {X, Y, box, frame, inside, unit} = axes(place,
    {low: x[0], high: Math.max(x.at(-1), x[0] + spacing), title: "position _x_ (µm)"},
    {low: bottom - pad, high: top + pad, title: "height (nm)"});
  const line = (heights) => path(heights.map((z, i) => [X(x[i]), Y(z)]));
  for (const [heights, end, colour] of [[lower, box.bottom, "var(--lower)"], [upper, box.top, "var(--upper)"]])
    inside.append(shape("path", {d: `${line(heights)}V${end}H${box.left}z`, style: `fill: ${colour}; fill-opacity: 0.25`}),
      shape("path", {d: line(heights), style: `fill: none; stroke: ${colour}`}));
  const perPixel = [(X.value(box.right) - x[0]) / frame.width, (top - bottom + 2 * pad) / frame.height]; // µm and nm
  const strongest = Math.max(...contacts.map((contact) => contact.force));
  for (const {x: cx, z, normal, force, opposes} of contacts) {
    const length = (0.9 + 2.9 * Math.sqrt(force / strongest)) * unit; // in the direction that the force has in truth
    const [fromX, fromY] = [X(x[0] + cx), Y(1000 * z)];
    const [dx, dy] = [normal, -Math.sqrt(1 - normal ** 2)];
    const [toX, toY] = [fromX + length * dx, fromY + length * dy];
    const colour = opposes ? "var(--opposing)" : "var(--accent)";
    const head = [[-0.6 * dx - 0.35 * dy, -0.6 * dy + 0.35 * dx], [-0.6 * dx + 0.35 * dy, -0.6 * dy - 0.35 * dx]]
      .map(([px, py]) => [toX + unit * px, toY + unit * py]);
    const r = 0.32 * unit;
    const words = `${shown(force, 3)} mN, slope ${shown((Math.asin(-shear * normal) * 180) / Math.PI, 3)}°`;
    inside.append(shape("g", {style: `fill: ${colour}; stroke: ${colour}; stroke-width: 2px`},
      shape("title", {}, words),
      shape("path", {d: path([[fromX, fromY], [toX, toY]])}),
      shape("path", {d: `${path([[toX, toY], ...head])}z`, "stroke-width": 0.5}),
      opposes
        ? shape("path", {d: `M${fromX - 1.2 * r} ${fromY}l${1.2 * r} ${-1.2 * r}l${1.2 * r} ${1.2 * r}l${-1.2 * r} ${1.2 * r}z`,
          style: "stroke: var(--paper)"})
        : shape("circle", {cx: fromX, cy: fromY, r, style: "stroke: var(--paper)"})));
  }
  const label = (words, y, colour) => inside.append(shape("text", {x: box.left + 0.6 * unit, y,
    style: `fill: ${colour}; paint-order: stroke; stroke: var(--paper); stroke-width: 4px; font-weight: 600`}, words));
  label(`upper body, about to move ${shear > 0 ? "right →" : "left ←"}`, box.top + 1.2 * unit, "var(--upper)");
  label("lower body", box.bottom - 0.6 * unit, "var(--lower)");
  return perPixel[0] / (perPixel[1] / 1000);
}

// ---- Measured surfaces ----------------------------------------------------------------------------------------------

/** Friction in every direction, by series {points of {value, lower, upper}, colour, name}; one direction is ringed. */
function drawCompass(place, directions, series, picked) {
  const unit = rem();
  const [width, height] = [Math.max(place.clientWidth, 12 * unit), Math.max(place.clientHeight, 12 * unit)];
  const [x, y, radius] = [width / 2, height / 2, Math.min(width, height) / 2 - 2.2 * unit];
  const [, most] = rangeOf(series.flatMap(({points}) => points), false);
  const picture = shape("svg", {width, height, viewBox: `0 0 ${width} ${height}`, "font-size": 0.8125 * unit,
    "font-family": "system-ui, 'DejaVu Sans', sans-serif", style: "fill: var(--ink)", "aria-hidden": "true"});
  const at = (angle, value) => {
    const r = (radius * Math.min(Math.max(value, 0), most)) / most;
    return [x + r * Math.cos((angle * Math.PI) / 180), y - r * Math.sin((angle * Math.PI) / 180)];
  };
  const grid = {style: "fill: none; stroke: var(--line)"};
  const ticks = ticksOf(0, most, false, 4).filter(({value}) => value > 0);
  for (const {value} of ticks) picture.append(shape("circle", {cx: x, cy: y, r: (radius * value) / most, ...grid}));
  for (const [angle, name] of [[0, "+x"], [90, "+y"], [180, "−x"], [270, "−y"]]) {
    const [tx, ty] = [x + (radius + unit) * Math.cos((angle * Math.PI) / 180), y - (radius + unit) * Math.sin((angle * Math.PI) / 180)];
    picture.append(shape("path", {d: path([[x, y], at(angle, most)]), ...grid}),
      shape("text", {x: tx, y: ty + 0.3 * unit, "text-anchor": "middle"}, name));
  }
  series.forEach(({points, colour, name}, s) => {
    const round = (pick) => `${path(directions.map((angle, d) => at(angle, pick(points[d]))))}z`;
    if (points.every(({lower}) => Number.isFinite(lower))) picture.append(shape("path", {
      d: round(({upper}) => upper) + round(({lower}) => lower), "fill-rule": "evenodd", style: `fill: ${colour}; fill-opacity: 0.2`}));
    if (points.every(({value}) => Number.isFinite(value))) picture.append(shape("path", {d: round(({value}) => value),
      "stroke-width": 2.2, "stroke-dasharray": s ? "7 4" : "none", style: `fill: none; stroke: ${colour}`}));
    directions.forEach((angle, d) => {
      if (!Number.isFinite(points[d].value)) return;
      const [cx, cy] = at(angle, points[d].value);
      picture.append(shape("circle", {cx, cy, r: 3, style: `fill: ${colour}`}));
      if (d === picked) picture.append(...ringed(cx, cy, 0.35 * unit));
    });
    picture.append(shape("text", {x: 0.5 * unit, y: (1.2 + 1.3 * s) * unit, style: `fill: ${colour}; font-weight: 600`}, name));
  });
  for (const {value, text} of ticks) {
    const [tx, ty] = at(45, value);
    picture.append(shape("text", {x: tx, y: ty, style: "paint-order: stroke; stroke: var(--paper); stroke-width: 3px"}, text));
  }
  place.replaceChildren(picture);
  place.axes = {centre: [x, y], radius, most};
  place.drawn = {series: series.map((each) => ({...each, points: each.points.map((p, d) => ({...p, x: directions[d]}))}))};
}

/** Heights {bytes, rows, columns, extent} from the first row at the bottom on, with contacts {x, y, force, opposes}. */
function drawContacts(place, {bytes, rows, columns, extent: [alongY, alongX]}, contacts) {
  const unit = rem();
  const wide = Math.max(place.clientWidth, 8 * unit) - 5.4 * unit;
  place.style.height = `${Math.min((wide * alongY) / alongX, 40 * unit) + 3.8 * unit}px`;
  const {X, Y, frame, inside} = axes(place, {low: 0, high: alongX, title: "_x_ (µm)"}, {low: 0, high: alongY, title: "_y_ (µm)"});
  const canvas = element("canvas", {width: columns, height: rows});
  const image = new ImageData(columns, rows);
  for (let row = 0; row < rows; row++) for (let column = 0; column < columns; column++) {
    const level = bytes[(rows - 1 - row) * columns + column];
    image.data.set([...colourAt(GREYS, level / 255), 255], 4 * (row * columns + column));
  }
  canvas.getContext("2d").putImageData(image, 0, 0);
  inside.append(shape("image", {...frame, href: canvas.toDataURL("image/png"), preserveAspectRatio: "none"}));
  const strongest = Math.max(...contacts.map(({force}) => force));
  for (const {x, y, force, opposes} of contacts) {
    const r = (0.15 + 0.65 * Math.sqrt(force / strongest)) * unit;
    const [cx, cy] = [X(x), Y(y)];
    const style = {"stroke-width": 2, style: `fill: none; stroke: ${opposes ? "#ff8c33" : "#3fa2ff"}`};
    inside.append(shape("g", {}, shape("title", {}, `${shown(force, 3)} mN`), opposes
      ? shape("path", {d: `M${cx - r} ${cy}l${r} ${-r}l${r} ${r}l${-r} ${r}z`, ...style})
      : shape("circle", {cx, cy, r: 0.8 * r, ...style})));
  }
}

// ---- Files ----------------------------------------------------------------------------------------------------------

/** A picture of axes as text of SVG that stands by itself, in the colours of paper. */
function pictureText(place) {
  const picture = place.querySelector("svg").cloneNode(true);
  picture.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  picture.querySelector(".note")?.remove();
  picture.prepend(shape("rect", {width: "100%", height: "100%", fill: "#ffffff"}));
  const paper = [...document.styleSheets[0].cssRules].find((rule) => rule.selectorText === ":root").style;
  return new XMLSerializer().serializeToString(picture)
    .replaceAll(/var\((--\w+)\)/g, (_, name) => paper.getPropertyValue(name).trim());
}

/** A picture of axes as PNG, so many times as fine as the screen. */
async function pictureBytes(place, times) {
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(pictureText(place))}`;
  await image.decode();
  const canvas = element("canvas", {width: Math.round(times * image.width), height: Math.round(times * image.height)});
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((done) => canvas.toBlob(done, "image/png"));
}

/** A table as CSV; no text of it can be taken for a formula. */
function csvText(rows) {
  const field = (value) => {
    if (typeof value === "number") return Number.isFinite(value) ? String(value) : "";
    const text = String(value ?? "").replace(/^([=+\-@\t\r])/, "'$1");
    return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  return rows.map((row) => row.map(field).join(",")).join("\n") + "\n";
}
