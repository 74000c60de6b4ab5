// The page of one measured profile or surface: its heights, and curves of them.

const CURVES = ["var(--accent)", "var(--second)", "var(--area)", "var(--all)"];
let levels = null; // heights of a map, one byte each

const numbers = (list) => list.map((value) => value ?? NaN);

function showCurves({id, series, x, y}) {
  const drawn = series.map(({name, dash, ...columns}, s) => {
    const [at, value, lower, upper] = ["x", "value", "lower", "upper"].map((key) => numbers(columns[key] ?? columns.x.map(() => null)));
    return {name, dash, colour: CURVES[s], points: at.map((each, i) => ({x: each, value: value[i], lower: lower[i], upper: upper[i], trusted: true}))};
  });
  drawCurves(byId(id), drawn, x, {...y, said: (point, name) => `${shown(point.value, 3)} at ${shown(point.x, 3)}${name ? `, ${name}` : ""}`});
}

const plain = (title) => title.replaceAll(/[_~]/g, "");

function curveRows({id, x, y}) {
  return () => [["curve", plain(x.title), plain(y.title), "lowest", "highest"], ...byId(id).drawn.series.flatMap(
    ({name, points}) => points.map((point) => [name, point.x, point.value, point.lower, point.upper]))];
}

function heightRows() {
  const {rows, columns, extent: [alongY, alongX], range: [low, high]} = facts.map;
  return [["x (um)", "y (um)", "z (nm)"], ...Array.from(levels, (level, i) =>
    [((i % columns) * alongX) / columns, (Math.floor(i / columns) * alongY) / rows, 1000 * (low + ((high - low) * level) / 255)])];
}

start(async () => {
  if (facts.map) {
    levels = await inflated("levels");
    drawings.heights = () => drawContacts(byId("heights"), {...facts.map, bytes: levels}, [], () => "");
  }
  for (const each of facts.plots) drawings[each.id] = () => showCurves(each);
  for (const id of Object.keys(drawings)) {
    const place = byId(id);
    const curve = facts.plots.find((each) => each.id === id);
    drawings[id]();
    toolbar(place, curve ? curveRows(curve) : heightRows);
    interactive(place, {point: (_, __, here) => tipOfNearest(place, here), leave: () => tip(place, ""), redrawn: () => redraw(id)});
  }
  window.addEventListener("resize", () => redraw(...Object.keys(drawings)));
});
