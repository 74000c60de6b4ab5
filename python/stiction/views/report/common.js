// Controls, file output and URL fragment of a report page.

const facts = JSON.parse(document.getElementById("facts").textContent);
const byId = (id) => document.getElementById(id);
const PERCENT = facts.percent;

// Create an element that shows a shortened number, and keeps the full number as its value.
const data = (value, text) => element("data", {value: String(value)}, text);

// ---- Drawing --------------------------------------------------------------------------------------------------------

const REDRAW_DELAY = 150; // time (ms) without changes after which hidden or slow plots are drawn
const pending = new Set();
let drawings = {}; // drawing functions by element id
let slow = () => false; // function that returns true if plots are drawn only after `REDRAW_DELAY`
let atRest = () => {};
let frame = 0;
let redrawTimer = 0;

function redraw(...places) {
  places.filter((place) => drawings[place]).forEach((place) => pending.add(place));
  cancelAnimationFrame(frame);
  frame = requestAnimationFrame(drawVisible);
}

function drawVisible() {
  frame = 0;
  drawPending((place) => {
    const {top, bottom} = byId(place).getBoundingClientRect();
    return top < innerHeight && bottom > 0 && !slow(place);
  });
  clearTimeout(redrawTimer);
  redrawTimer = setTimeout(() => {
    redrawTimer = 0;
    atRest();
    drawPending(() => true);
  }, REDRAW_DELAY);
}

function drawPending(isChosen) {
  for (const place of [...pending].filter(isChosen)) {
    drawings[place]();
    pending.delete(place);
  }
}

// ---- Controls -------------------------------------------------------------------------------------------------------

/** Connect a slider that selects an item of a list by its index. */
function index(id, {value, count, name, changed}) {
  const slider = byId(id);
  slider.max = count - 1;
  slider.value = value;
  slider.disabled = count < 2;
  const show = () => {
    const text = name(Number(slider.value));
    byId(`${id}-text`).textContent = text;
    slider.setAttribute("aria-valuetext", text);
  };
  slider.addEventListener("input", () => {
    changed(Number(slider.value));
    show();
  });
  show();
  return {set: (position) => { slider.value = position; show(); }};
}

/** Fill a list of choices. Hide the list if it has only one choice. */
function choice(id, names, value, changed) {
  const list = byId(id);
  list.append(...names.map((name, i) => element("option", {value: i}, name)));
  list.value = value;
  const around = list.closest(".control") ?? list.closest(".row");
  if (around && names.length < 2) around.hidden = true;
  list.addEventListener("change", () => changed(Number(list.value)));
}

// ---- Files ----------------------------------------------------------------------------------------------------------

function save(name, blob) {
  const link = element("a", {href: URL.createObjectURL(blob), download: name});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** Add the buttons of a plot: zoom, axis scale, download of the figure, and download of its numbers.
 * The figure has a title and a caption, and `rows` returns the table of numbers. */
function toolbar(place, rows, {hasAxes = true, hasScales = false} = {}) {
  const plotName = place.getAttribute("aria-label").split(";")[0];
  const title = () => `${document.title.split(" – ")[0]}: ${plotName}`;
  const words = () => [byId("parameters").textContent, place.parentNode.querySelector(".caption")?.textContent ?? ""].join(" ");
  const name = `${document.title.split(" – ")[0].replaceAll(/[^\w-]+/g, "_")}_${place.id}`;
  const redrawn = () => redraw(place.id);
  const button = (text, label, action) => {
    const control = element("button", {type: "button", "aria-label": `${label}: ${plotName}`, title: label}, text);
    control.addEventListener("click", action);
    return control;
  };
  const list = element("p", {class: "saves"});
  if (hasAxes) list.append(
    button("+", "Look closer", () => zoom(place, redrawn, {times: 1.5})),
    button("−", "Zoom out", () => zoom(place, redrawn, {times: 1 / 1.5})),
    button("⟲", "Show all", () => { place.view = null; redrawn(); }));
  if (hasScales) list.append(button("log", "log or linear scale", () => {
    place.isLog = !(place.axes?.y.isLog ?? false);
    place.view = null;
    redrawn();
  }));
  list.append(
    button("SVG", "Save the figure as SVG", () => save(`${name}.svg`, new Blob([pictureText(place, title(), words())], {type: "image/svg+xml"}))),
    button("PNG", "Save the figure as PNG", async () => save(`${name}.png`, await pictureBytes(pictureText(place, title(), words()), 2))),
    button("CSV", "Save the numbers as CSV", () => save(`${name}.csv`, new Blob([csvText(rows())], {type: "text/csv"}))));
  place.after(list);
}

// ---- URL fragment ---------------------------------------------------------------------------------------------------

/** Return the fields of the URL fragment: a text for each name. */
const addressFields = () => Object.fromEntries(new URLSearchParams(location.hash.slice(1)));

/** Return a number from the URL fragment. If the number is not within limits, return a default number. */
function parseNumber(text, low, high, fallback) {
  const value = text === undefined || text === "" ? NaN : Number(text);
  return value >= low && value <= high ? value : fallback;
}

function address(values) {
  const text = `#${new URLSearchParams(values)}`;
  if (location.hash !== text) history.replaceState(null, "", text);
}

// ---- Start ----------------------------------------------------------------------------------------------------------

/** Show a notice at the top of the page. */
function showNotice(text) {
  byId("trouble").hidden = false;
  byId("trouble").textContent = text;
}

async function unpacked(id) {
  const place = byId(`packed-${id}`);
  const text = atob(place.textContent);
  place.remove();
  const bytes = Uint8Array.from(text, (character) => character.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Run the script of a page. If the script throws an error, show the error. */
function start(main) {
  const isOld = typeof DecompressionStream === "undefined";
  for (const form of document.forms) form.addEventListener("submit", (event) => event.preventDefault());
  if (isOld) showNotice("This page needs a browser of 2023 or later.");
  else main().then(() => byId("main").setAttribute("aria-busy", "false"))
    .catch((error) => showNotice(`This page could not be drawn: ${error.message}`));
}
