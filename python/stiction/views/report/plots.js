// SVG plots. Each function draws given data in a given element.
// No function uses the state of the page.
// Colours are variables of the style sheet, so that plots need not be redrawn for dark mode or print.

// ---- Elements -------------------------------------------------------------------------------------------------------

/** Return a function that creates elements with attributes and children. Text is never interpreted as markup. */
const maker = (space) => (name, attributes = {}, ...children) => {
  const node = document.createElementNS(`http://www.w3.org/${space}`, name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
};
const [element, shape] = [maker("1999/xhtml"), maker("2000/svg")];

/** Return an empty SVG of a size in pixels. */
const pictureOf = (width, height) => shape("svg", {width, height, viewBox: `0 0 ${width} ${height}`,
  "font-size": 0.8125 * rem(), "font-family": "system-ui, 'DejaVu Sans', sans-serif", style: "fill: var(--ink)",
  "aria-hidden": "true"});

/** Return the position of a pointer event within an element, in pixels. */
function positionIn(place, {clientX, clientY}) {
  const {left, top} = place.getBoundingClientRect();
  return [clientX - left, clientY - top];
}

/** Return a text element. It shows the text _F_ in italics and the text ~N~ as a subscript. */
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

/** Split a list of points into runs of consecutive known points. */
function runs(points, isKnown) {
  const found = [[]];
  for (const point of points) isKnown(point) ? found.at(-1).push(point) : found.push([]);
  return found.filter((run) => run.length);
}

// ---- Ticks and cells ----------------------------------------------------------------------------------------------

const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";

function superscript(exponent) {
  const digits = [...String(Math.abs(exponent))].map((digit) => SUPERSCRIPTS[digit]).join("");
  return (exponent < 0 ? "⁻" : "") + digits;
}


/** Return the ticks of an axis with their labels. A logarithmic axis also has ticks without labels. */
function ticksOf(low, high, isLog, most) {
  if (!(high > low)) return [{value: low, text: tickText(low)}];
  if (isLog && high / low > 4) {
    const first = Math.ceil(Math.log10(low) - 1e-9); // ticks are also needed in the decade below the first power of ten
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

function edges(centres) {
  if (centres.length === 1) return [centres[0] - 0.05, centres[0] + 0.05];
  const middles = centres.slice(1).map((centre, i) => (centre + centres[i]) / 2);
  return [2 * centres[0] - middles[0], ...middles, 2 * centres.at(-1) - middles.at(-1)];
}

/** Return the edges [x, y, x, y] between true cells and false cells. Cells with other values have no edges. */
function boundary(cells, x, y) {
  const lines = [];
  const differ = (first, second) => typeof first === "boolean" && typeof second === "boolean" && first !== second;
  cells.forEach((row, l) => row.forEach((cell, d) => {
    if (differ(cell, row[d + 1])) lines.push([x[d + 1], y[l], x[d + 1], y[l + 1]]);
    if (differ(cell, cells[l + 1]?.[d])) lines.push([x[d], y[l + 1], x[d + 1], y[l + 1]]);
  }));
  return lines;
}

/** Return the index of the nearest number in a list. */
function nearest(list, value) {
  const distances = list.map((item) => Math.abs(item - value));
  return distances.indexOf(Math.min(...distances));
}

// ---- Axes -----------------------------------------------------------------------------------------------------------

/** Return a function that converts values on an axis {low, high, isLog} to positions in pixels between two ends. */
function createScale({low, high, isLog}, from, to) {
  const on = isLog ? Math.log : (value) => value;
  const off = isLog ? Math.exp : (value) => value;
  const [first, span] = [on(low), on(high) - on(low) || 1];
  const at = (value) => from + ((on(value) - first) / span) * (to - from);
  at.value = (position) => off(first + ((position - from) / (to - from)) * span);
  return at;
}

/** Return an axis that is limited to its zoomed view, or the whole axis if there is no view. */
const viewed = (axis, view) => (view ? {...axis, low: view[0], high: view[1]} : axis);

/** Draw axes {low, high, isLog, title} in an element, and return their scales. The group `inside` is clipped. */
function axes(place, wholeX, wholeY, top = 0) {
  const unit = rem();
  const [x, y] = [viewed(wholeX, place.view?.x), viewed(wholeY, place.view?.y)];
  const [width, height] = [Math.max(place.clientWidth, 8 * unit), Math.max(place.clientHeight, 8 * unit)];
  const box = {left: 4.4 * unit, right: width - unit, top: (0.6 + top) * unit, bottom: height - 3.2 * unit};
  const small = 0.8125 * unit;
  const picture = pictureOf(width, height);
  const [X, Y] = [createScale(x, box.left, box.right), createScale(y, box.bottom, box.top)];
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
  if (place.tip) place.append(place.tip);
  return Object.assign(place, {axes: {X, Y, x, y, wholeX, wholeY, box, frame, picture, inside, unit, small}}).axes;
}

// ---- Zoom -----------------------------------------------------------------------------------------------------------

const CLOSEST = 1e-3; // smallest fraction of an axis to which the view can be zoomed

/** Return the ends of an axis view after zooming about a position (0 to 1) or moving by a fraction of the view. */
function zoomedEnds({low, high, isLog}, {low: from, high: to}, times, about, move = 0) {
  const [on, off] = isLog ? [Math.log, Math.exp] : [(value) => value, (value) => value];
  const [start, span] = [on(from), on(to) - on(from)];
  const whole = on(high) - on(low);
  const size = Math.min(Math.max(span / times, CLOSEST * whole), whole);
  const begin = Math.min(Math.max(start + about * (span - size) + move * span, on(low)), on(high) - size);
  return size >= whole * (1 - 1e-9) ? null : [off(begin), off(begin + size)];
}

/** Zoom the axes of a plot, or move along them. */
function zoom(place, redrawn, {times = 1, x = 0.5, y = 0.5, moveX = 0, moveY = 0}) {
  if (!place.axes?.X) return;
  const {wholeX, wholeY} = place.axes;
  const {view} = place; // this view may be newer than the drawn view, because several events may occur before a frame is drawn
  place.view = {x: zoomedEnds(wholeX, viewed(wholeX, view?.x), times, x, moveX), y: zoomedEnds(wholeY, viewed(wholeY, view?.y), times, y, moveY)};
  redrawn();
}

const isNear = (event) => event.ctrlKey || event.metaKey; // browsers send a pinch on a touch pad as a wheel event with Ctrl

/** Connect the pointer, wheel and key events of a plot. One call per plot is enough, even if its axes change later.
 * The function `pick` returns a function that undoes the choice of a point.
 * The user zooms or moves a plot with a drawn rectangle, Ctrl and wheel, two fingers, Shift and dragging, or keys. */
function interactive(place, {point, leave, pick, redrawn}) {
  let from = null;
  let rectangle = null;
  let pressed = null; // position of a press of the pointer that was not followed by a move
  let undo = null;
  const fingers = new Map();
  const at = (event) => positionIn(place, event);
  const isInside = ([x, y]) => {
    const {box} = place.axes ?? {};
    return box && x >= box.left && x <= box.right && y >= box.top && y <= box.bottom;
  };
  const parts = ([x, y]) => {
    const {frame} = place.axes;
    return {x: (x - frame.x) / frame.width, y: 1 - (y - frame.y) / frame.height};
  };
  const values = ([x, y]) => [place.axes.X.value(x), place.axes.Y.value(y)];
  place.addEventListener("pointerdown", (event) => {
    if (event.pointerType === "touch") fingers.set(event.pointerId, at(event));
    from = isInside(at(event)) && event.isPrimary && event.button === 0 ? at(event) : null;
  });
  const pinch = (event) => {
    const before = [...fingers.values()];
    fingers.set(event.pointerId, at(event));
    const after = [...fingers.values()];
    const size = ([first, second]) => Math.hypot(first[0] - second[0], first[1] - second[1]) || 1;
    const middle = ([first, second]) => parts([(first[0] + second[0]) / 2, (first[1] + second[1]) / 2]);
    const [was, is] = [middle(before), middle(after)];
    zoom(place, redrawn, {times: size(after) / size(before), ...is, moveX: was.x - is.x, moveY: was.y - is.y});
  };
  const rectangleTo = (here) => {
    const {box, picture} = place.axes;
    const [x, y] = [Math.min(Math.max(here[0], box.left), box.right), Math.min(Math.max(here[1], box.top), box.bottom)];
    rectangle?.remove();
    rectangle = shape("rect", {x: Math.min(x, from[0]), y: Math.min(y, from[1]), width: Math.abs(x - from[0]),
      height: Math.abs(y - from[1]), style: "fill: var(--accent); fill-opacity: 0.2; stroke: var(--accent)"});
    rectangle.to = [x, y];
    picture.append(rectangle);
  };
  place.addEventListener("pointermove", (event) => {
    const here = at(event);
    if (fingers.size === 2 && fingers.has(event.pointerId)) return pinch(event);
    if (from && event.pointerType !== "touch" && Math.hypot(here[0] - from[0], here[1] - from[1]) > 8) {
      leave?.();
      if (!event.shiftKey) return rectangleTo(here);
      const [was, is] = [parts(from), parts(here)];
      from = here;
      from.moved = true;
      return zoom(place, redrawn, {moveX: was.x - is.x, moveY: was.y - is.y});
    }
    if (isInside(here) && event.pointerType !== "touch") point?.(...values(here), here);
    else leave?.();
  });
  place.addEventListener("pointerleave", () => leave?.());
  const release = (event) => {
    fingers.delete(event.pointerId);
    if (from && rectangle) {
      const [[x0, y0], [x1, y1]] = [values(from), values(rectangle.to)];
      const ends = (first, second) => [Math.min(first, second), Math.max(first, second)];
      place.view = {x: ends(x0, x1), y: ends(y0, y1)};
      rectangle.remove();
      redrawn();
    }
    const isClick = from && !rectangle && !from.moved && fingers.size === 0;
    pressed = isClick && event.target instanceof Node && place.contains(event.target) ? from : null;
    from = rectangle = null;
  };
  window.addEventListener("pointerup", release);
  window.addEventListener("pointercancel", (event) => {
    fingers.delete(event.pointerId);
    rectangle?.remove();
    from = rectangle = null;
  });
  place.addEventListener("click", (event) => {
    if (pressed && event.detail === 1) undo = pick?.(...values(pressed)); // the second click of a double click has detail 2
    pressed = null;
  });
  place.addEventListener("dblclick", () => {
    undo?.(); // a double click resets the view and picks nothing
    undo = null;
    place.view = null;
    redrawn();
  });
  place.addEventListener("wheel", (event) => {
    if (!isNear(event) || !isInside(at(event))) return;
    event.preventDefault();
    zoom(place, redrawn, {times: Math.exp(-event.deltaY / 300), ...parts(at(event))});
  }, {passive: false});
  place.addEventListener("keydown", (event) => {
    const times = {"+": 1.5, "=": 1.5, "-": 1 / 1.5}[event.key];
    const move = event.shiftKey && {ArrowLeft: [-0.2, 0], ArrowRight: [0.2, 0], ArrowUp: [0, 0.2], ArrowDown: [0, -0.2]}[event.key];
    if (isNear(event) || event.altKey || !(times || move || event.key === "0")) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (event.key === "0") { place.view = null; redrawn(); }
    else zoom(place, redrawn, times ? {times} : {moveX: move[0], moveY: move[1]});
  });
}

/** Show a tooltip at a position in a plot. An empty text removes the tooltip. */
function tip(place, words, [x, y] = [0, 0]) {
  place.tip ??= element("div", {class: "tip", "aria-hidden": "true"});
  place.tip.hidden = !words;
  if (!words) return;
  if (place.tip.parentNode !== place) place.append(place.tip);
  place.tip.textContent = words;
  const {width, height} = place.tip.getBoundingClientRect();
  place.tip.style.left = `${Math.max(0, Math.min(x + 14, place.clientWidth - width))}px`;
  place.tip.style.top = `${Math.max(0, y - height - 10)}px`;
}

/** Show the tooltip of the point nearest to the pointer, if this point is close. `place.hits` lists {x, y, words}. */
function tipOfNearest(place, here) {
  const hits = place.hits ?? [];
  const apart = ({x, y}) => Math.hypot(x - here[0], y - here[1]);
  const best = hits.reduce((found, hit) => (!found || apart(hit) < apart(found) ? hit : found), null);
  tip(place, best && apart(best) < 3 * rem() ? best.words : "", here);
}

// ---- Colours --------------------------------------------------------------------------------------------------------

// Colours of the colour map plasma (public domain) at multiples of 1/16.
const PLASMA = ["0d0887", "310597", "4c02a1", "6600a7", "7e03a8", "9511a1", "aa2395", "bc3587", "cc4778", "da5a6a",
  "e66c5c", "f0804e", "f89540", "fdac33", "fdc527", "f8df25", "f0f921"];

/** Return the colour [red, green, blue] of the colour map plasma at a fraction of its length. */
function colourAt(share) {
  const place = share * (PLASMA.length - 1);
  const i = Math.min(Math.floor(place), PLASMA.length - 2);
  const part = place - i;
  const bytes = (hex) => [0, 2, 4].map((k) => parseInt(hex.slice(k, k + 2), 16));
  const [one, other] = [bytes(PLASMA[i]), bytes(PLASMA[i + 1])];
  return one.map((byte, k) => Math.round(byte + part * (other[k] - byte)));
}

const LEVELS = 96;
const LEVEL_COLOURS = Array.from({length: LEVELS}, (_, i) => `rgb(${colourAt(i / (LEVELS - 1))})`);

// ---- The map ---------------------------------------------------------------------------------------------------------

const HATCHES = {
  "not-reached": ["var(--paper)", "M-2 2L2 -2M0 8L8 0M6 10L10 6"],
  "below-range": ["var(--line)", "M-2 6L2 10M0 0L8 8M6 -2L10 2"],
  "no-contact": ["var(--paper)", "M3.9 4h.2"],
  "self-locked": ["#7a0019", ""],
  "not-solved": ["var(--line)", "M3.9 4h.2"],
  seizure: ["#7a0019", "M-2 2L2 -2M0 8L8 0M6 10L10 6"],
  "bulk-shear": ["var(--paper)", "M-2 6L2 10M0 0L8 8M6 -2L10 2"],
  downhill: ["var(--line)", "M-2 2L2 -2M0 8L8 0M6 10L10 6"],
};

const pattern = (id, ...shapes) =>
  shape("pattern", {id, width: 8, height: 8, patternUnits: "userSpaceOnUse"}, ...shapes);

function hatch(name, id) {
  const [ground, lines] = HATCHES[name];
  return pattern(id, shape("rect", {width: 8, height: 8, style: `fill: ${ground}`}),
    shape("path", {d: lines, "stroke-width": 1.3, "stroke-linecap": "round", style: "stroke: var(--muted); fill: none"}));
}

/** Return a hatch pattern for values outside the range of the model: white lines with dark edges. */
function beyondModel(id) {
  const d = "M-2 6L2 10M0 0L8 8M6 -2L10 2";
  return pattern(id,
    shape("path", {d, "stroke-width": 2.6, style: "stroke: #000000; stroke-opacity: 0.55; fill: none"}),
    shape("path", {d, "stroke-width": 1.3, style: "stroke: #ffffff; fill: none"}));
}

function swatch(...shapes) {
  const frame = {x: 0.5, y: 0.5, width: 23, height: 15};
  return shape("svg", {width: 24, height: 16, "aria-hidden": "true"}, ...shapes.map((each) => each(frame)),
    shape("rect", {...frame, style: "fill: none; stroke: var(--muted)"}));
}

const ringed = (x, y, size, width = 2.5) => [["var(--paper)", 2 * width + 1], ["var(--ring)", width]].map(([colour, w]) =>
  shape("circle", {cx: x, cy: y, r: size, "stroke-width": w, style: `fill: none; stroke: ${colour}`}));

/** Draw a map of a quantity against fractal dimension and load, and return the entries of the legend.
 * `map` is {status, value, trusted}, `colours` are the ends {value, text} of the scale, and `picked` is the chosen cell [d, l]. */
function drawMap(place, {facts, map, loads, colours, ticks, picked, title}) {
  const [low, high] = colours.map(({value}) => value);
  const x = edges(facts.cells.values);
  const y = edges(loads.map(Math.log)).map(Math.exp);
  const {X, Y, box, frame, inside, picture, unit} = axes(
    place, {low: x[0], high: x.at(-1), title: facts.cell.title},
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
    if (name === "ok") continue; // friction without an interval has no width that could be drawn
    const id = `${place.id}-${name}`;
    inside.append(hatch(name, id), shape("path", {d: cells.join(""), fill: `url(#${id})`}));
    legend.push([swatch(() => hatch(name, `${id}-legend`), (each) => shape("rect", {...each, fill: `url(#${id}-legend)`})),
      facts.why[name].short]);
  }
  if (veiled.length) {
    const id = `${place.id}-beyond`;
    const lines = boundary(map.trusted, xs, ys).map(([x0, y0, x1, y1]) => `M${x0} ${y0}L${x1} ${y1}`).join("");
    inside.append(beyondModel(id), shape("path", {d: veiled.join(""), fill: `url(#${id})`}));
    for (const [colour, width] of [["#ffffff", 3.5], ["#000000", 1.5]])
      inside.append(shape("path", {d: lines, "stroke-width": width, style: `fill: none; stroke: ${colour}`}));
    legend.push([swatch(() => beyondModel(`${id}-legend`), (each) => shape("rect", {...each, fill: LEVEL_COLOURS[48]}),
      (each) => shape("rect", {...each, fill: `url(#${id}-legend)`})),
      facts.beyondModel]);
  }
  inside.append(...ringed((xs[picked[0]] + xs[picked[0] + 1]) / 2, (ys[picked[1]] + ys[picked[1] + 1]) / 2, 0.42 * unit));
  legend.push([swatch(() => shape("rect"), () => ringed(12, 8, 5)[1]), "picked point"]);
  const values = map.value.flat().filter((value) => value !== null);
  if (values.some((value) => value > high))
    legend.push([swatch((each) => shape("rect", {...each, fill: LEVEL_COLOURS.at(-1)})), `${colours[1].text} and above`]);
  if (values.some((value) => value < low))
    legend.push([swatch((each) => shape("rect", {...each, fill: LEVEL_COLOURS[0]})), `${colours[0].text} and below`]);
  picture.append(...colourBar(`${place.id}-scale`, {...frame, y: 0.9 * unit, height: 0.8 * unit}, low, high, ticks, title, unit));
  return legend;
}

function colourBar(id, frame, low, high, ticks, title, unit) {
  const stops = PLASMA.map((hex, i) => shape("stop", {offset: i / (PLASMA.length - 1), "stop-color": `#${hex}`}));
  const at = createScale({low, high, isLog: true}, frame.x, frame.x + frame.width);
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

const MAX_BAND = 2.5; // maximum ratio of the upper limit of a band to the highest value on a linear scale
const MAX_LOG_BAND = 100; // maximum ratio of a limit of a band to the highest or lowest value on a logarithmic scale
const MIN_LOG_RANGE = 10; // minimum ratio of the limits of a logarithmic scale

/** Return the axis range for values with intervals. Wide bands are cut off, so that the curves remain visible. */
function rangeOf(points, isLog) {
  const ok = points.filter((point) => Number.isFinite(point.value));
  const ends = ok.flatMap((point) => [point.value, point.lower, point.upper]).filter((value) => value > 0);
  const values = ok.map((point) => point.value).filter((value) => value > 0);
  if (!values.length) return [isLog ? 0.1 : 0, 1];
  const [least, most] = [Math.min(...values), Math.max(...values)];
  if (!isLog) return [0, Math.min(1.05 * Math.max(...ends), MAX_BAND * most)];
  const low = Math.max(Math.min(...ends) / 1.3, least / MAX_LOG_BAND);
  const high = Math.min(Math.max(...ends) * 1.3, most * MAX_LOG_BAND);
  const missing = Math.max(1, Math.sqrt((1.01 * MIN_LOG_RANGE) / (high / low)));
  return [low / missing, high * missing];
}

/** Arrange the names of series in rows above the axes, and return these rows. */
function legendRows(place, series) {
  const [unit, wide] = [rem(), Math.max(place.clientWidth, 8 * rem()) - 5.4 * rem()];
  const rows = [[]];
  let used = 0;
  for (const each of series.filter(({name}) => name)) {
    const width = Math.min((2.6 + 0.47 * each.name.length) * unit, wide);
    if (used + width > wide && rows.at(-1).length) {
      rows.push([]);
      used = 0;
    }
    rows.at(-1).push({...each, x: used});
    used += width;
  }
  return rows.filter((row) => row.length);
}

function drawLegend({picture, box, unit}, rows) {
  rows.forEach((row, r) => row.forEach(({name, colour, dash, x}) => {
    const [left, y] = [box.left + x, box.top - (0.55 + 1.25 * (rows.length - 1 - r)) * unit];
    picture.append(
      shape("path", {d: `M${left} ${y - 0.3 * unit}h${1.4 * unit}`, "stroke-width": 2.4, "stroke-dasharray": dash ?? "none", style: `fill: none; stroke: ${colour}`}),
      shape("text", {x: left + 1.8 * unit, y}, name));
  }));
}

/** Draw series {points of {x, value, lower, upper, trusted}, colour, name} as curves with bands.
 * A ring marks the picked x. Horizontal lines are drawn at `levels` {value, name, colour}.
 * Single points are marked if there are few points. The function returns the range of the values. */
function drawCurves(place, series, x, {title, isLog, picked, levels = []}) {
  const all = series.flatMap(({points}) => points);
  const isUsed = (place.isLog ?? isLog) && all.some(({value}) => value > 0);
  const [low, high] = rangeOf([...all, ...levels.map((each) => ({...each, lower: NaN, upper: NaN}))], isUsed);
  const rows = legendRows(place, [...series, ...levels.map((each) => ({...each, dash: "7 4"}))]);
  const drawn = axes(place, x, {low, high, isLog: isUsed, title}, rows.length ? 0.4 + 1.25 * rows.length : 0);
  const {X, Y, y: shownY, box, inside, unit} = drawn;
  drawLegend(drawn, rows);
  const room = 0.05 * (isUsed ? 1 : shownY.high - shownY.low); // curves and bands are cut off beyond this margin
  const inRange = (value) => (isUsed ? Math.min(Math.max(value, low / 2), high * 2) : Math.min(Math.max(value, low - room), high + room));
  const at = ({x: value}, y) => [X(value), Y(inRange(y))];
  const isDrawn = ({value}) => Number.isFinite(value) && !(isUsed && value <= 0);
  for (const {points, colour} of series)
    for (const run of runs(points, ({lower, value}) => Number.isFinite(lower) && isDrawn({value})))
      inside.append(shape("path", {
        d: `${path([...run.map((p) => at(p, p.lower)), ...run.map((p) => at(p, p.upper)).reverse()])}z`,
        style: `fill: ${colour}; fill-opacity: 0.2`,
      }));
  for (const {value, colour} of levels)
    inside.append(shape("path", {d: path([[box.left, Y(value)], [box.right, Y(value)]]), "stroke-width": 1.5,
      "stroke-dasharray": "7 4", style: `fill: none; stroke: ${colour}`}));
  for (const {points, colour} of series) {
    const stroke = (d, more) => shape("path", {d, "stroke-width": 2.2, style: `fill: none; stroke: ${colour}`, ...more});
    for (const run of runs(points, isDrawn)) {
      inside.append(stroke(path(run.map((p) => at(p, p.value))), {"stroke-dasharray": "2 4"}));
      for (const solid of runs(run, ({trusted}) => trusted)) inside.append(stroke(path(solid.map((p) => at(p, p.value)))));
      if (points.length <= 30) inside.append(...run.map((p) => at(p, p.value)).map(([cx, cy]) =>
        shape("circle", {cx, cy, r: 3, style: `fill: ${colour}`})));
    }
    const here = points.find((point) => point.x === picked && isDrawn(point));
    if (here) inside.append(...ringed(...at(here, here.value), 0.35 * unit));
  }
  if (!all.some(isDrawn)) inside.append(shape("text", {x: (box.left + box.right) / 2, y: (box.top + box.bottom) / 2,
    "text-anchor": "middle"}, "no value in this range"));
  place.drawn = {series, low, high, x};
  return [low, high];
}

// ---- Measured surfaces ----------------------------------------------------------------------------------------------

/** Return a smooth closed path through points (Catmull-Rom), so that no corner can be mistaken for data. */
function smooth(points) {
  const at = (i) => points[(i + points.length) % points.length];
  const bend = (from, before, after) => [from[0] + (after[0] - before[0]) / 6, from[1] + (after[1] - before[1]) / 6];
  const text = (point) => point.map((each) => each.toFixed(1)).join(" ");
  return `M${text(at(0))}${points.map((_, i) =>
    `C${text(bend(at(i), at(i - 1), at(i + 1)))} ${text(bend(at(i + 1), at(i + 2), at(i)))} ${text(at(i + 1))}`).join("")}z`;
}

/** Draw friction against direction for series {points of {value, lower, upper}, colour, name}.
 * A ring marks the picked direction. */
function drawCompass(place, directions, series, picked, describe) {
  const unit = rem();
  const [width, height] = [Math.max(place.clientWidth, 12 * unit), Math.max(place.clientHeight, 12 * unit)];
  // Names of curves are above the circle in a narrow plot, where they would otherwise cover the label "+y".
  const top = width < 28 * unit ? 1.3 * unit * series.length : 0;
  const [x, y, radius] = [width / 2, (height + top) / 2, Math.min(width, height - top) / 2 - 2.2 * unit];
  const [, most] = rangeOf(series.flatMap(({points}) => points), false);
  const picture = pictureOf(width, height);
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
  const hits = [];
  series.forEach(({points, colour, name}, s) => {
    const round = (pick) => smooth(directions.map((angle, d) => at(angle, pick(points[d]))));
    if (points.every(({lower}) => Number.isFinite(lower))) picture.append(shape("path", {
      d: round(({upper}) => upper) + round(({lower}) => lower), "fill-rule": "evenodd", style: `fill: ${colour}; fill-opacity: 0.2`}));
    if (points.every(({value}) => Number.isFinite(value))) picture.append(shape("path", {d: round(({value}) => value),
      "stroke-width": 2.2, "stroke-dasharray": s ? "7 4" : "none", style: `fill: none; stroke: ${colour}`}));
    directions.forEach((angle, d) => {
      if (!Number.isFinite(points[d].value)) return;
      const [cx, cy] = at(angle, points[d].value);
      hits.push({x: cx, y: cy, words: describe(points[d], angle, name)});
      picture.append(shape("circle", {cx, cy, r: 3, style: `fill: ${colour}`}));
      if (d === picked) picture.append(...ringed(cx, cy, 0.35 * unit));
    });
    picture.append(shape("text", {x: 0.5 * unit, y: (1.2 + 1.3 * s) * unit, style: `fill: ${colour}; font-weight: 600`}, name));
  });
  // Labels of circles are in the direction that is farthest from points and axes.
  const distance = (angle, other) => Math.abs(((((angle - other + 180) % 360) + 360) % 360) - 180);
  const space = (angle) => Math.min(...[...directions, 0, 90].map((other) => distance(angle, other)));
  const clear = [67.5, 75, 60, 52.5, 45, 22.5, 15, 30].reduce((best, angle) => (space(angle) > space(best) ? angle : best));
  for (const {value, text} of ticks) {
    const [tx, ty] = at(clear, value);
    picture.append(shape("text", {x: tx, y: ty + 0.3 * unit, "text-anchor": "middle",
      style: "paint-order: stroke; stroke: var(--paper); stroke-width: 5px"}, text));
  }
  place.replaceChildren(picture);
  if (place.tip) place.append(place.tip);
  place.hits = hits;
  place.axes = {centre: [x, y], radius, most};
  place.drawn = {series: series.map((each) => ({...each, points: each.points.map((p, d) => ({...p, x: directions[d]}))}))};
}

// ---- Files ----------------------------------------------------------------------------------------------------------

/** Wrap a text into lines of limited length. */
function wrapped(words, maxLength) {
  const lines = [""];
  for (const word of words.split(/\s+/).filter(Boolean)) {
    if (lines.at(-1) && lines.at(-1).length + word.length >= maxLength) lines.push("");
    lines[lines.length - 1] += `${lines.at(-1) ? " " : ""}${word}`;
  }
  return lines.filter(Boolean);
}

/** Return the text of an SVG file of a plot in print colours, with a title, a caption and the address of the view. */
function pictureText(place, title, words) {
  const picture = place.querySelector("svg").cloneNode(true);
  const [width, height] = ["width", "height"].map((name) => Number(picture.getAttribute(name)));
  const unit = rem();
  const letters = Math.max(20, Math.floor(width / (0.44 * unit)));
  const [above, below] = [wrapped(title, Math.floor(0.8 * letters)), wrapped(words, letters)];
  const head = (0.6 + 1.3 * above.length) * unit;
  const inner = shape("g", {transform: `translate(0 ${head})`});
  inner.append(...picture.childNodes);
  const whole = height + head + (0.6 + 1.15 * below.length) * unit;
  for (const [name, value] of Object.entries({xmlns: "http://www.w3.org/2000/svg", width, height: whole, viewBox: `0 0 ${width} ${whole}`}))
    picture.setAttribute(name, value);
  picture.removeAttribute("aria-hidden");
  const line = (text, y, more) => shape("text", {x: 0.6 * unit, y, ...more}, text);
  picture.append(shape("title", {}, title), shape("desc", {}, `${words} View: ${location.hash}`),
    shape("rect", {width: "100%", height: "100%", fill: "#ffffff"}),
    ...above.map((text, i) => line(text, (1.4 + 1.3 * i) * unit, {"font-weight": "600", "font-size": 0.9375 * unit})),
    inner, ...below.map((text, i) => line(text, head + height + (0.8 + 1.15 * i) * unit, {"font-size": 0.75 * unit})));
  const paper = [...document.styleSheets[0].cssRules].find((rule) => rule.selectorText === ":root").style;
  return new XMLSerializer().serializeToString(picture)
    .replaceAll(/var\((--\w+)\)/g, (_, name) => paper.getPropertyValue(name).trim());
}

/** Render the text of an SVG file as PNG, at a multiple of the screen resolution. */
async function pictureBytes(text, times) {
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(text)}`;
  await image.decode();
  const canvas = element("canvas", {width: Math.round(times * image.width), height: Math.round(times * image.height)});
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((done) => canvas.toBlob(done, "image/png"));
}

/** Return a table as CSV. Spreadsheets do not interpret any of its texts as a formula. */
function csvText(rows) {
  const field = (value) => {
    if (typeof value === "number") return Number.isFinite(value) ? String(value) : "";
    const text = String(value ?? "").replace(/^([=+\-@\t\r])/, "'$1");
    return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  return rows.map((row) => row.map(field).join(",")).join("\n") + "\n";
}
