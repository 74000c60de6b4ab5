"use strict";

// Page of the app: form, uploads, jobs and results. The server sends numbers as text.

const byId = (id) => document.getElementById(id);
const AT_REST = 400; // ms without a change before the values are updated
const POLL = 500; // ms between two requests for the progress of jobs
const sides = ["upper", "lower"];
const scans = {upper: null, lower: null};
const arriving = {upper: 0, lower: 0}; // number of files per side being uploaded or read
const form = byId("pair");
let jobs = [];
let current = null; // number of the job that is shown
let framed = ""; // address of the report shown for it
let told = null; // values selected in its report if they differ from the inputs

const node = (tag, set = {}, ...children) => {
  const made = Object.assign(document.createElement(tag), set);
  made.append(...children);
  return made;
};

// Only this page has the key; a browser also sends cookies to other servers of this computer.
if (location.hash) {
  localStorage.setItem("key", location.hash.slice(1));
  history.replaceState(null, "", "/");
}
const key = localStorage.getItem("key") ?? "";
/** Return an address with the key, for requests by the browser itself. */
const keyed = (address) => `${address}${address.includes("?") ? "&" : "?"}key=${key}`;

/** Return the JSON response of the server; throw an error with its message if it rejects the request. */
async function fetched(address, options = {}) {
  const response = await fetch(address, {...options, headers: {"x-stiction-key": key}}).catch(() => { throw new Error("the server does not answer"); });
  if (!response.ok) throw new Error(await response.text());
  return response.json();
}
const posted = (address, body = {}) => fetched(address, {method: "POST", body: JSON.stringify(body)});

function complain(place, text) {
  place.hidden = !text;
  place.textContent = text;
}

/** Show the error of a job at the scan that it names, or at the field of the option at its start. */
function complainOf(job) {
  for (const marked of document.querySelectorAll("[aria-invalid]")) marked.removeAttribute("aria-invalid");
  const text = job.error;
  const side = sides.find((each) => scans[each] && (text.startsWith(`${scans[each].name}:`) || text.endsWith(`, for ${each.toUpperCase()}`)));
  if (side) complain(byId(`${side}-drop`).querySelector(".wrong"), text);
  complain(byId(job.command.startsWith("stiction run") ? "run-wrong" : "pair-wrong"), side ? "" : text);
  complain(byId("job-wrong"), text);
  const input = (side ? byId(`${side}-drop`) : form).querySelector(`[name="${job.option}"]`);
  input?.setAttribute("aria-invalid", "true");
  if (input?.closest("details")) input.closest("details").open = true;
  input?.focus();
}

function connectDrop(side) {
  const place = byId(`${side}-drop`);
  place.append(byId("drop").content.cloneNode(true));
  place.querySelector("b").textContent = side === "upper" ? "Upper, the slider" : "Lower";
  const input = place.querySelector("input[type=file]");
  input.id = `${side}-file`;
  input.addEventListener("change", () => input.files.length && take(side, input.files[0]));
  for (const name of ["dragenter", "dragover", "dragleave", "drop"])
    place.addEventListener(name, (event) => {
      event.preventDefault();
      place.classList.toggle("aim", name.startsWith("dragen") || name === "dragover");
      if (name === "drop" && event.dataTransfer.files.length) take(side, event.dataTransfer.files[0]);
    });
  for (const each of place.querySelectorAll("[name]")) each.addEventListener("change", () => look(side));
}

async function take(side, file) {
  const place = byId(`${side}-drop`);
  place.querySelector(".hint").textContent = `${file.name} …`;
  complain(place.querySelector(".wrong"), "");
  arriving[side] += 1;
  try {
    if (file.size > document.body.dataset.most) throw new Error(`The limit for a scan is ${document.body.dataset.most / 1e6} MB.`);
    const {scan} = await fetched(`/scans?name=${encodeURIComponent(file.name)}`, {method: "PUT", body: file});
    scans[side] = {scan, name: file.name};
    await look(side);
  } catch (error) {
    scans[side] = null;
    place.querySelector(".hint").textContent = file.name;
    complain(place.querySelector(".wrong"), error.message);
  } finally {
    arriving[side] -= 1;
  }
}

async function look(side) {
  const [place, own] = [byId(`${side}-drop`), scans[side]];
  if (!own) return;
  const [hint, wrong, image, save] = [".hint", ".wrong", "img", ".save"].map((each) => place.querySelector(each));
  hint.textContent = `${own.name} …`;
  const reading = new URLSearchParams([...place.querySelectorAll("[name]")].map(({name, value}) => [name, value.trim()]));
  arriving[side] += 1;
  const said = await fetched(`/scans/${own.scan}?${reading}`).catch(({message}) => ({error: message}));
  arriving[side] -= 1;
  if (scans[side] !== own) return;
  own.holds = said.holds;
  hint.textContent = said.error ? own.name : `${own.name}: ${said.words}`;
  complain(wrong, said.error ?? said.warning);
  if (said.error) place.querySelector("details").open = true;
  Object.assign(image, {hidden: Boolean(said.error), src: said.picture ?? "data:,", alt: `Heights of ${own.name}`});
  Object.assign(save, {hidden: !own.isSample, href: keyed(`/scans/${own.scan}/${own.name}`)});
  remember();
}

async function demo() {
  const made = await posted("/demo");
  sides.forEach((side, i) => { scans[side] = {...made[i], isSample: true}; form[side].value ||= "mild steel"; });
  form.tau0.value ||= "20";
  form.hardness.value ||= "2";
  await Promise.all(sides.map(look));
  form.requestSubmit();
}

const {units: UNITS, texts: TEXTS} = JSON.parse(document.body.dataset.numbers); // units of bare numbers; fields where a comma separates values
const number = (name) => form[name].value.trim().replace(",", ".");

/** Return the options of `stiction pair` for the form. Fields for both bodies occur twice. */
function optionsOfPair() {
  const found = {};
  for (const [name, text] of new FormData(form)) {
    const given = TEXTS.includes(name) ? text.trim() : text.trim().replaceAll(",", ".");
    const hasUnit = /\p{L}{2}|[A-Z]/u.test(given); // true for "150 HV", false for "1e-3"
    (found[name] ??= []).push(given && !hasUnit ? given + (UNITS[name] ?? "") : given);
  }
  found.missing = [found.missing.find(Boolean)]; // one value for both scans
  if (found.young) {
    for (const side of sides) delete found[side];
    for (const name of ["young", "poisson"]) found[name] = [found[name].join(",")];
  }
  return Object.entries(found).filter(([, [one, other]]) => one || other)
    .flatMap(([name, [one, other = one]]) => (one === other ? [[name, one]] : [[name, one], [name, other]]));
}

/** Return the reason why a scan is not ready; empty if it is. */
function scanProblem(side) {
  if (arriving[side]) return `the ${side} scan is still being read`;
  if (!scans[side]) return `the ${side} scan is missing`;
  return scans[side].holds ? "" : `the ${side} scan could not be read, see above`;
}

async function press(event) {
  event.preventDefault();
  const lacking = [...sides.filter(scanProblem).map((side) => [byId(`${side}-file`), scanProblem(side)]),
    ...[...form.querySelectorAll("[required]:enabled")].filter((each) => !each.value.trim())
      .map((each) => [each, `${each.dataset.name ?? each.closest("label").textContent.trim()} is missing`])];
  complain(byId("pair-wrong"), lacking.length ? `Not yet: ${lacking.map(([, words]) => words).join(", ")}.` : "");
  if (lacking.length) {
    lacking[0][0].focus();
    return byId("pair-wrong").scrollIntoView({block: "nearest"});
  }
  await ask("pair-wrong", {command: "pair", upper: scans.upper.scan, lower: scans.lower.scan, options: optionsOfPair()});
}

async function ask(wrong, body) {
  complain(byId(wrong), "");
  try {
    [current, framed, told] = [(await posted("/jobs", body)).job, "", null];
    byId("page").hidden = true;
    remember();
    await poll();
    byId("job").scrollIntoView({block: "nearest"}); // the result is below the form on a phone
  } catch (error) {
    complain(byId(wrong), error.message);
  }
}

let polling = 0;

/** Request the progress of all jobs periodically. Requests are short, because a browser has few connections. */
async function poll() {
  clearTimeout(polling);
  const found = await fetched("/jobs").catch(() => null);
  byId("gone").hidden = found !== null;
  if (found) jobs = found;
  render();
  clearTimeout(polling);
  polling = setTimeout(poll, POLL);
}

function render() {
  const job = jobs.find(({number: each}) => each === current);
  byId("start").hidden = Boolean(job);
  byId("job").hidden = !job;
  if (!job) delete byId("job").dataset.state;
  if (!job) return;
  const isGoing = ["waiting", "running"].includes(job.state);
  byId("title").textContent = job.title;
  byId("job").dataset.state = job.state;
  byId("going").hidden = !isGoing;
  byId("words").textContent = job.words + (job.total && isGoing ? ` – ${job.finished} of ${job.total}` : "");
  byId("progress").max = job.total || 1;
  if (job.total) byId("progress").value = job.finished;
  else byId("progress").removeAttribute("value");
  if (byId("job").dataset.error !== job.error) complainOf(job);
  byId("job").dataset.error = job.error;
  const stopped = job.state !== "stopped" ? "" : job.total ? `stopped: ${job.finished} of ${job.total} are finished and kept` : "stopped";
  if (!told) say(job.answer, [stopped, job.by].filter(Boolean).join("; "), !job.by);
  byId("command").textContent = commandOf(job);
  byId("share").hidden = !job.versions || isGoing || Boolean(job.by);
  for (const link of byId("share").querySelectorAll("a")) link.href = keyed(`/jobs/${job.number}/${link.dataset.file}?save`);
  const page = keyed(`/jobs/${job.number}/page.html?${job.versions}`);
  if (!job.versions || page === framed) return;
  const frame = byId("page");
  const before = framed && frame.contentWindow.location.hash;
  framed = page;
  frame.hidden = false;
  frame.contentWindow.location.replace(page + (before || (job.command.startsWith("stiction run") ? `#d=${dimension()}` : "")));
}

const KIND = {"Quote it": "good", "Quote with care": "care", "Do not quote": "bad"}; // CSS class of each assessment
const WORDS = {all: "friction at all contacts", opposing: "friction at opposing contacts only (the paper's rule)"};

/** Show values, assessment and caveats. Intermediate results are grey and have no assessment. */
function say(answer, by, isLast) {
  const place = byId("answer");
  const text = JSON.stringify([answer, by, isLast]);
  if (place.dataset.text === text) return;
  place.dataset.text = text;
  place.replaceChildren(...(by ? [node("p", {className: "hint"}, by)] : []));
  if (!answer) return;
  for (const {rule, text: words, value: mean, lower, upper} of answer.rules.filter(({value: mean}) => mean !== null)) {
    const line = node("p", {className: `value ${isLast ? "" : "hint"}`}, node("i", {}, "μ"), node("sub", {}, "s"),
      ` = ${words} `, node("small", {className: "hint"}, WORDS[rule]));
    Object.assign(line.dataset, {rule, value: mean, lower, upper});
    place.append(line);
  }
  if (isLast) place.append(node("p", {className: `verdict ${KIND[answer.verdict]}`}, answer.verdict),
    node("ul", {className: "doubts", tabIndex: 0}, ...answer.doubts.map(({text: words, cure, severity}) => node("li", {className: severity}, `${words}; ${cure}`))),
    node("p", {className: "sentence", id: "sentence", hidden: true}, answer.sentence));
}

/** Return the command line that gives the same numbers. */
function commandOf({command}) {
  if (!told) return command;
  const [, what, name] = command.split(" ");
  if (what === "pair" && told.isAskedLoad)
    return command.replace(/--mu0=\S+/, `--mu0=${told.mu0}`).replace(/'--tau0=[^']*'/, `'--tau0=${told.tau0} MPa'`);
  const folder = what === "info" ? name : `${command} && stiction at ${what === "run" ? "quick" : "pair"}`;
  return `${what === "info" ? "stiction at " : ""}${folder} --load='${told.load} mN' --mu0=${told.mu0} --tau0='${told.tau0} MPa'${told.d ? ` --d=${told.d}` : ""}`;
}

let resting = 0;
const paged = () => byId("page").contentDocument;

function connectPage() {
  const inside = paged();
  if (!inside?.getElementById("readout")) return;
  inside.head.append(Object.assign(inside.createElement("style"), {textContent:
    "body { padding: 0; max-width: none } header .over, header h1, #judgement, " +
    ".pair #answer > :is(.of, .value, .interval) { display: none } #controls { top: 0 }"}));
  for (const name of ["input", "click", "keyup"]) inside.addEventListener(name, () => { clearTimeout(resting); resting = setTimeout(follow, AT_REST); });
  const fit = () => { byId("page").style.height = matchMedia("(min-width: 60rem)").matches ? "" : `${inside.documentElement.scrollHeight}px`; };
  new ResizeObserver(fit).observe(inside.documentElement);
}

/** Update the values when others are selected in the report. */
async function follow() {
  const job = jobs.find(({number: each}) => each === current);
  const {load, mu0, tau0, dimension: d} = paged()?.getElementById("readout")?.dataset ?? {};
  if (!job?.answer || job.by || load === undefined) return; // during the computation only the report is updated
  const isNear = (one, other) => Math.abs(one - other) <= 1e-9 * Math.abs(other);
  const {at} = job.answer;
  const wanted = {load, mu0, tau0: Number((1000 * tau0).toPrecision(12)), d: job.command.startsWith("stiction pair") ? "" : d, isAskedLoad: isNear(load, at.load)};
  for (const name of ["mu0", "tau0"]) if (Number(number(name)) !== Number(wanted[name])) form[name].value = wanted[name];
  const isAsked = wanted.isAskedLoad && isNear(mu0, at.mu0) && Math.abs(tau0 - at.tau0) < 1e-12 && !wanted.d;
  if (isAsked) told = null;
  else if (JSON.stringify(wanted) !== JSON.stringify(told)) {
    told = wanted;
    const {answers} = await fetched(`/jobs/${job.number}/at?${new URLSearchParams({load, mu0, tau0, ...(wanted.d ? {d} : {})})}`).catch(() => ({answers: []}));
    if (told === wanted) say(answers[0] ?? null, "", true);
  }
  render();
}

/** Transfer a number from the form to the report. */
function move(name) {
  const input = paged()?.getElementById(`${name}-number`);
  if (!input || byId("page").hidden || !number(name) || !(Number(number(name)) >= 0)) return;
  input.value = number(name);
  input.dispatchEvent(new Event("input", {bubbles: true}));
}

const dimension = () => (1 + 0.05 * Number(byId("d").value)).toFixed(2);
const length = (id) => `${Number((10 ** Number(byId(id).value)).toPrecision(2))} um`;
const changesOfRun = () => ({"surfaces.amplitude": [length("height")], "surfaces.length_scale": length("length"),
  "surfaces.convention": byId("measure").value, "ensemble.seed": Number(byId("seed").value)});
let sketching = 0;

function sketch() {
  byId("d-text").textContent = byId("measure").value === "paper" ? `D = ${dimension()}` : `H = ${(2 - dimension()).toFixed(2)}`;
  for (const id of ["height", "length"]) byId(`${id}-text`).textContent = length(id).replace("um", "µm");
  byId("seed-text").textContent = byId("seed").value;
  clearTimeout(sketching);
  sketching = setTimeout(() => {
    byId("profile").src = keyed(`/profiles?${new URLSearchParams({set: JSON.stringify({...changesOfRun(), "surfaces.fractal_dimension": [Number(dimension())]})})}`);
  }, AT_REST / 2);
}

function run(event) {
  event.preventDefault();
  const options = Object.entries(changesOfRun()).map(([key, each]) => ["set", `${key}=${Array.isArray(each) ? JSON.stringify(each) : each}`]);
  ask("run-wrong", {command: "run", options});
}

async function listResults() {
  if (!byId("there").open) return;
  const list = await fetched("/results").catch(() => []);
  const text = JSON.stringify(list);
  if (byId("results").dataset.text !== text) byId("results").replaceChildren(...list.map(({name, finished, total, kind, error}) => {
    const words = error ?? `${kind === "measured" ? "a pair" : "a study"}, ${finished} of ${total}`;
    const button = node("button", {type: "button", disabled: Boolean(error) || !finished, onclick: () => ask("open-wrong", {command: "open", name})}, name);
    return node("li", {}, button, ` ${words}`);
  }), ...(list.length ? [] : [node("li", {}, "There are no results in the directory where stiction was started.")]));
  byId("results").dataset.text = text;
  setTimeout(listResults, 2000);
}

const remembered = () => [...form.querySelectorAll("[name]")];
function remember() {
  sessionStorage.setItem("state", JSON.stringify({scans, current, fields: remembered().map(({value}) => value)}));
}

function recall() {
  const state = JSON.parse(sessionStorage.getItem("state") ?? "null");
  if (!state) return;
  current = state.current;
  Object.assign(scans, state.scans);
  remembered().forEach((each, i) => { each.value = state.fields[i]; });
  sides.forEach(look);
}

function showNumbers() {
  const isByNumbers = sides.some((side) => form[side].value === "numbers");
  Object.assign(byId("numbers"), {hidden: !isByNumbers, disabled: !isByNumbers});
  sides.forEach((side, i) => {
    for (const name of ["young", "poisson"]) form[name][i].value = form[side].selectedOptions[0].dataset[name] ?? form[name][i].value;
  });
}

async function copy(button, text) {
  const before = button.textContent;
  await navigator.clipboard.writeText(text).then(() => { button.textContent = "Copied"; }, () => { button.textContent = "Press Ctrl-C"; });
  setTimeout(() => { button.textContent = before; }, 2000);
}

sides.forEach(connectDrop);
recall();
showNumbers();
sketch();
form.addEventListener("submit", press);
form.addEventListener("change", () => { showNumbers(); remember(); });
for (const name of ["mu0", "tau0"]) form[name].addEventListener("input", () => move(name));
byId("run").addEventListener("input", sketch);
byId("run").addEventListener("submit", run);
byId("page").addEventListener("load", connectPage);
byId("there").addEventListener("toggle", listResults);
for (const [id, action] of Object.entries({
  demo,
  stop: () => posted(`/jobs/${current}/stop`),
  quote: () => copy(byId("quote"), byId("sentence").textContent),
  copy: () => copy(byId("copy"), byId("command").textContent),
  menu: () => posted("/menu").then(({file}) => `Added: ${file}`, ({message}) => message).then((text) => { byId("menu-said").textContent = text; }),
})) byId(id).addEventListener("click", action);
if (document.body.dataset.demo && !scans.upper) demo();
poll();
