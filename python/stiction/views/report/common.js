// Controls, files and the address: what every page has.

const facts = JSON.parse(document.getElementById("facts").textContent);
const byId = (id) => document.getElementById(id);
const PERCENT = facts.percent;

// A number that people see shortened, and programs in full.
const data = (value, text) => element("data", {value: String(value)}, text);

// ---- Drawing --------------------------------------------------------------------------------------------------------

const REST = 150; // ms without a change, after which what nobody sees, or what takes long, is drawn as well
const wanted = new Set();
let drawings = {}; // what draws each place on the page, by its id
let slow = () => false; // whether a place is to be drawn at rest alone
let atRest = () => {};
let frame = 0;
let rest = 0;

function redraw(...places) {
  places.filter((place) => drawings[place]).forEach((place) => wanted.add(place));
  cancelAnimationFrame(frame);
  frame = requestAnimationFrame(drawSeen);
}

function drawSeen() {
  drawSome((place) => {
    const {top, bottom} = byId(place).getBoundingClientRect();
    return top < innerHeight && bottom > 0 && !slow(place);
  });
  clearTimeout(rest);
  rest = setTimeout(() => {
    atRest();
    drawSome(() => true);
  }, REST);
}

function drawSome(isChosen) {
  for (const place of [...wanted].filter(isChosen)) {
    drawings[place]();
    wanted.delete(place);
  }
}

// ---- Controls -------------------------------------------------------------------------------------------------------

/** A slider and a number that mean the same, between 0 and the most that was evaluated. */
function amount(id, {value, most, step, unit, changed}) {
  const [slider, number] = [byId(id), byId(`${id}-number`)];
  Object.assign(slider, {min: 0, max: most, step});
  number.max = most;
  byId(`${id}-wrong`).textContent = `Only numbers from 0 to ${tickText(Number(most.toPrecision(4)))}; the last one stands.`;
  const show = (given) => {
    slider.value = given;
    slider.setAttribute("aria-valuetext", `${given}${unit}`);
  };
  number.value = value;
  show(value);
  slider.addEventListener("input", () => {
    number.value = slider.value;
    byId(`${id}-wrong`).hidden = true;
    show(slider.value);
    changed(Number(slider.value));
  });
  number.addEventListener("input", () => {
    byId(`${id}-wrong`).hidden = number.validity.valid;
    if (!number.validity.valid) return;
    show(number.value);
    changed(Number(number.value));
  });
}

/** A slider over the indices of a list. */
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
  return {set: (given) => { slider.value = given; show(); }};
}

/** A list to choose from; hidden where there is nothing to choose. */
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

/** Buttons behind a plot: to look closer or at all of it, between a linear and a logarithmic scale of values, and to save
 * its picture with a title and its caption, and its numbers; `rows` makes the table. */
function toolbar(place, rows, {hasAxes = true, hasScales = false} = {}) {
  const called = place.getAttribute("aria-label").split(";")[0];
  const title = () => `${document.title.split(" – ")[0]}: ${called}`;
  const words = () => [byId("parameters").textContent, place.parentNode.querySelector(".caption")?.textContent ?? ""].join(" ");
  const name = `${document.title.split(" – ")[0].replaceAll(/[^\w-]+/g, "_")}_${place.id}`;
  const redrawn = () => redraw(place.id);
  const button = (text, label, action) => {
    const made = element("button", {type: "button", "aria-label": `${label}: ${called}`, title: label}, text);
    made.addEventListener("click", action);
    return made;
  };
  const list = element("p", {class: "saves"});
  if (hasAxes) list.append(
    button("+", "Look closer", () => look(place, redrawn, {times: 1.5})),
    button("−", "Look from farther", () => look(place, redrawn, {times: 1 / 1.5})),
    button("⟲", "All of it", () => { place.view = null; redrawn(); }));
  if (hasScales) list.append(button("log", "log or linear scale", () => {
    place.isLog = !(place.axes?.y.isLog ?? false);
    place.view = null;
    redrawn();
  }));
  list.append(
    button("SVG", "Save the picture as SVG", () => save(`${name}.svg`, new Blob([pictureText(place, title(), words())], {type: "image/svg+xml"}))),
    button("PNG", "Save the picture as PNG", async () => save(`${name}.png`, await pictureBytes(pictureText(place, title(), words()), 2))),
    button("CSV", "Save the numbers as CSV", () => save(`${name}.csv`, new Blob([csvText(rows())], {type: "text/csv"}))));
  place.after(list);
}

// ---- The address ----------------------------------------------------------------------------------------------------

/** What the address says, name -> text. */
const addressed = () => Object.fromEntries(new URLSearchParams(location.hash.slice(1)));

/** A number of the address, if it is one between two others. */
function numberOf(text, low, high, otherwise) {
  const value = text === undefined || text === "" ? NaN : Number(text);
  return value >= low && value <= high ? value : otherwise;
}

function address(values) {
  const text = `#${new URLSearchParams(values)}`;
  if (location.hash !== text) history.replaceState(null, "", text);
}

// ---- Beginning ------------------------------------------------------------------------------------------------------

function say(text) {
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

function start(begin) {
  const isOld = typeof DecompressionStream === "undefined";
  for (const form of document.forms) form.addEventListener("submit", (event) => event.preventDefault());
  if (isOld) say("This page needs a browser of 2023 or later.");
  else begin().then(() => byId("main").setAttribute("aria-busy", "false"))
    .catch((error) => say(`This page could not be drawn: ${error.message}`));
}
