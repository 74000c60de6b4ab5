"use strict";

// Script of the app's page: form, uploads, jobs and results. The server sends numbers as text.

const byId = (id) => document.getElementById(id);
const UPDATE_DELAY = 400; // time (ms) between the last change of a control and the update of the displayed values
const POLL_INTERVAL = 500; // time (ms) between two requests for the progress of jobs
const sides = ["upper", "lower"];
const scans = {upper: null, lower: null};
const interfaceFiles = []; // uploaded interface files, which are added to the list of interfaces
const arriving = {upper: 0, lower: 0}; // number of files that are being uploaded or read, for each side
// Number of the latest upload or preview request for each side. Responses to earlier requests are ignored.
const latestRequests = {upper: 0, lower: 0};
const form = byId("pair");
let jobs = [];
let current = null; // number of the displayed job
let reportAddress = ""; // address of the report that the frame displays
let selection = null; // values selected in the report, or null if they equal the inputs

const createNode = (tag, properties = {}, ...children) => {
  const node = Object.assign(document.createElement(tag), properties);
  node.append(...children);
  return node;
};

// The key is kept in the local storage of this page.
// A cookie would also be sent to other servers on this computer.
if (location.hash) {
  localStorage.setItem("key", location.hash.slice(1));
  history.replaceState(null, "", "/");
}
const key = localStorage.getItem("key") ?? "";
/** Return an address that contains the key, for links and frames that the browser loads itself. */
const withKey = (address) => `${address}${address.includes("?") ? "&" : "?"}key=${key}`;

/** Return the JSON response of the server. If the server rejects the request, throw its error message. */
async function requestJson(address, options = {}) {
  const response = await fetch(address, {...options, headers: {"x-stiction-key": key}}).catch(() => { throw new Error("the server does not respond"); });
  if (!response.ok) throw new Error(await response.text());
  return response.json();
}
const postJson = (address, body = {}) => requestJson(address, {method: "POST", body: JSON.stringify(body)});

/** Show an error message in an element, and scroll it into view. An empty message hides the element. */
function showError(element, text) {
  element.hidden = !text;
  element.textContent = text;
  if (text) element.scrollIntoView({block: "nearest"});
}

/** Remove the messages beside all fields. */
function clearFieldErrors() {
  for (const input of document.querySelectorAll("[aria-invalid]")) {
    for (const name of ["aria-invalid", "aria-describedby"]) input.removeAttribute(name);
  }
  for (const message of document.querySelectorAll(".field-wrong")) message.remove();
}

/** Show an error message beside the scan or the field of an option that is named in the message. */
function showEntryError(text, option, errorId) {
  clearFieldErrors();
  const side = sides.find((name) => scans[name] && (text.startsWith(`${scans[name].name}:`) || RegExp(`\\b(for|of) ${name.toUpperCase()}\\b`).test(text)));
  const input = option && (side ? byId(`${side}-drop`) : form).querySelector(`[name="${option}"]`);
  showError(byId(errorId), side || input ? "" : text);
  if (!input) return side && showError(byId(`${side}-drop`).querySelector(".wrong"), text);
  const message = createNode("p", {className: "wrong field-wrong", id: "field-wrong", role: "alert"}, text);
  input.closest("label").after(message);
  input.setAttribute("aria-invalid", "true");
  input.setAttribute("aria-describedby", message.id);
  for (let section = input.closest("details"); section; section = section.parentElement.closest("details")) section.open = true;
  input.focus();
  message.scrollIntoView({block: "nearest"});
}

/** Show the error message of a job with its result, and beside the scan or the field that is named in the message. */
function showJobError(job) {
  showError(byId("job-wrong"), job.error);
  const [, command] = job.command.split(" ");
  if (job.error) showEntryError(job.error, job.option, {run: "run-wrong", shear: "shear-wrong"}[command] ?? "pair-wrong");
}

/** Add the controls and event handlers of a drop area. */
function connectDrop(side) {
  const place = byId(`${side}-drop`);
  place.append(byId("drop").content.cloneNode(true));
  place.querySelector("b").textContent = side === "upper" ? "Upper, the slider" : "Lower";
  const input = place.querySelector("input[type=file]");
  input.id = `${side}-file`;
  input.addEventListener("change", () => {
    const [file] = input.files;
    input.value = ""; // or else the browser would ignore a second choice of the same file
    if (file) uploadScan(side, file);
  });
  for (const name of ["dragenter", "dragover", "dragleave", "drop"])
    place.addEventListener(name, (event) => {
      event.preventDefault();
      place.classList.toggle("aim", name.startsWith("dragen") || name === "dragover");
      if (name === "drop" && event.dataTransfer.files.length) uploadScan(side, event.dataTransfer.files[0]);
    });
  for (const option of place.querySelectorAll("[name]")) option.addEventListener("change", () => {
    if (!SHARED.includes(option.name)) return previewScan(side);
    for (const name of sides) byId(`${name}-drop`).querySelector(`[name=${option.name}]`).value = option.value;
    sides.forEach(previewScan);
  });
}

/** Upload a file, and return its identifier. */
async function uploadFile(file) {
  if (file.size > document.body.dataset.maxBytes) throw new Error(`The limit for a file is ${document.body.dataset.maxBytes / 1e6} MB.`);
  return (await requestJson(`/scans?name=${encodeURIComponent(file.name)}`, {method: "PUT", body: file})).scan;
}

/** Upload a scan and show its preview. */
async function uploadScan(side, file) {
  const place = byId(`${side}-drop`);
  place.querySelector(".hint").textContent = `${file.name} …`;
  showError(place.querySelector(".wrong"), "");
  arriving[side] += 1;
  const request = (latestRequests[side] += 1);
  scans[side] = null;
  try {
    const scan = await uploadFile(file);
    if (request !== latestRequests[side]) return;
    scans[side] = {scan, name: file.name};
    await previewScan(side);
  } catch (error) {
    if (request !== latestRequests[side]) return;
    place.querySelector(".hint").textContent = file.name;
    showError(place.querySelector(".wrong"), error.message);
  } finally {
    arriving[side] -= 1;
  }
}

/** Read a scan with the options of its form, and show its preview or the error. */
async function previewScan(side) {
  const [place, scan] = [byId(`${side}-drop`), scans[side]];
  if (!scan) return;
  const [hint, wrong, image, save] = [".hint", ".wrong", "img", ".save"].map((selector) => place.querySelector(selector));
  hint.textContent = `${scan.name} …`;
  const readingOptions = new URLSearchParams([...place.querySelectorAll("[name]")].map(({name, value}) => [name, value.trim()]));
  arriving[side] += 1;
  const request = (latestRequests[side] += 1);
  const preview = await requestJson(`/scans/${scan.scan}?${readingOptions}`).catch(({message}) => ({error: message}));
  arriving[side] -= 1;
  if (request !== latestRequests[side]) return;
  scan.holds = preview.holds;
  hint.textContent = preview.error ? scan.name : `${scan.name}: ${preview.words}`;
  showError(wrong, preview.error ?? preview.warning);
  const reading = place.querySelector("details");
  if (preview.error && !reading.open) reading.dataset.opened = "by an error";
  if (preview.error) reading.open = true;
  else if (reading.dataset.opened) {
    delete reading.dataset.opened;
    reading.open = false;
  }
  Object.assign(image, {hidden: Boolean(preview.error), src: preview.picture ?? "data:,", alt: `Heights of ${scan.name}`});
  Object.assign(save, {hidden: !scan.isSample, href: withKey(`/scans/${scan.scan}/${scan.name}`)});
  saveState();
  offerShearTest();
}

let latestFit = 0; // number of the latest comparison of the scans; responses to earlier requests are ignored

/** Show the form of a shear test if the two scans fit into each other. */
async function offerShearTest() {
  const request = (latestFit += 1);
  const shearForm = byId("shear");
  shearForm.hidden = true;
  if (!sides.every((side) => scans[side]?.holds)) return;
  const query = new URLSearchParams(sides.map((side) => [side, scans[side].scan]));
  for (const side of sides) for (const {name, value} of byId(`${side}-drop`).querySelectorAll("[name]")) query.set(`${side}.${name}`, value.trim());
  const {fits, path} = await requestJson(`/fit?${query}`).catch(() => ({fits: false}));
  if (request !== latestFit || !fits) return;
  shearForm.path.value ||= path;
  shearForm.hidden = false;
}

/** Add an uploaded interface file to the list of interfaces. */
function addInterface(file) {
  if (interfaceFiles.some(({scan}) => scan === file.scan)) return;
  interfaceFiles.push(file);
  form.interface.append(createNode("option", {value: file.scan}, file.name));
}

/** Upload an interface file and select it. */
async function uploadInterface(file) {
  clearFieldErrors();
  try {
    const scan = await uploadFile(file);
    addInterface({scan, name: file.name});
    form.interface.value = scan;
    showInterface();
    saveState();
  } catch (error) {
    showEntryError(error.message, "interface", "pair-wrong");
  }
}

/** Load both sample surfaces and submit the form. */
async function loadSamples() {
  const samples = await postJson("/demo");
  sides.forEach((side, i) => { scans[side] = {...samples[i], isSample: true}; form[side].value ||= "mild steel"; });
  form.tau0.value ||= "20";
  form.hardness.value ||= "2";
  await Promise.all(sides.map(previewScan));
  form.requestSubmit();
}

// Units for numbers without a unit, options with one value for both scans, and descriptions of the sliding rules.
const {units: UNITS, shared: SHARED, shear: SHEAR, ruleDescriptions: RULE_DESCRIPTIONS} = JSON.parse(document.body.dataset.facts);
const entry = (name) => form[name].value.trim();

/** Convert the entries of the form to options of `stiction pair`. A field for both bodies has two entries. */
function pairOptions() {
  const options = {};
  for (const [name, text] of new FormData(form)) {
    const value = text.trim();
    const hasUnit = /\p{L}{2}|[A-Z]/u.test(value); // true for "150 HV", false for "1e-3"
    (options[name] ??= []).push(value && !hasUnit ? value + (UNITS[name] ?? "") : value);
  }
  for (const name of SHARED) options[name] = options[name].slice(0, 1); // the same value applies to both scans
  if (options.young) {
    for (const side of sides) delete options[side];
    for (const name of ["young", "poisson"]) options[name] = [options[name].join(",")];
  }
  return Object.entries(options).filter(([, [first, second]]) => first || second)
    .flatMap(([name, [first, second = first]]) => (first === second ? [[name, first]] : [[name, first], [name, second]]));
}

/** Return the reason why a scan is not ready. The text is empty if the scan is ready. */
function scanProblem(side) {
  if (arriving[side]) return `the ${side} scan is still being read`;
  if (!scans[side]) return `the ${side} scan is missing`;
  return scans[side].holds ? "" : `the ${side} scan could not be read, see above`;
}

/** List the missing entries of the form for two scans. Return whether there are none. */
function isComplete(errorId) {
  clearFieldErrors();
  const problems = [...sides.filter(scanProblem).map((side) => [byId(`${side}-file`), scanProblem(side)]),
    ...[...form.querySelectorAll("[required]:enabled")].filter((field) => !field.value.trim())
      .map((field) => [field, `${field.dataset.name ?? field.closest("label").textContent.trim()} is missing`])];
  showError(byId(errorId), problems.length ? `Not yet: ${problems.map(([, text]) => text).join(", ")}.` : "");
  if (!problems.length) return true;
  problems[0][0].focus();
  byId(errorId).scrollIntoView({block: "nearest"});
  return false;
}

/** Submit the form for a pair of scans. */
async function submitPair(event) {
  event.preventDefault();
  if (isComplete("pair-wrong")) await submitJob("pair-wrong", {command: "pair", upper: scans.upper.scan, lower: scans.lower.scan, options: pairOptions()});
}

/** Submit a shear test of both scans, with the materials, the load and the friction of the form for a pair. */
async function submitShear(event) {
  event.preventDefault();
  if (!isComplete("shear-wrong")) return;
  const options = pairOptions().filter(([name]) => SHEAR.includes(name));
  for (const [name, text] of new FormData(byId("shear"))) if (text.trim()) options.push([name, text.trim()]);
  await submitJob("shear-wrong", {command: "shear", upper: scans.upper.scan, lower: scans.lower.scan, options});
}

/** Add a job to the queue and show it; `errorId` is the element for an error message. */
async function submitJob(errorId, body) {
  showError(byId(errorId), "");
  clearFieldErrors();
  try {
    const {job, error, option} = await postJson("/jobs", body);
    if (error) return showEntryError(error, option, errorId);
    [current, reportAddress, selection] = [job, "", null];
    byId("page").hidden = true;
    saveState();
    await poll();
    byId("job").scrollIntoView({block: "nearest"}); // on a phone, the result is below the form
  } catch (error) {
    showError(byId(errorId), error.message);
  }
}

let pollTimer = 0;
let latestPoll = 0; // number of the latest progress request; responses to earlier requests are ignored

/** Request the progress of all jobs periodically. Each request is short, because browsers open few connections. */
async function poll() {
  clearTimeout(pollTimer);
  const request = (latestPoll += 1);
  const response = await requestJson("/jobs").catch(() => null);
  if (request !== latestPoll) return;
  byId("gone").hidden = response !== null;
  if (response) jobs = response;
  render();
  pollTimer = setTimeout(poll, POLL_INTERVAL);
}

/** Show the progress, result and report of the current job. */
function render() {
  const job = jobs.find(({number}) => number === current);
  byId("start").hidden = Boolean(job);
  byId("job").hidden = !job;
  if (!job) delete byId("job").dataset.state;
  if (!job) return;
  const isActive = ["waiting", "running"].includes(job.state);
  byId("title").textContent = job.title;
  byId("job").dataset.state = job.state;
  byId("going").hidden = !isActive;
  byId("words").textContent = job.words + (job.total && isActive ? ` – ${job.finished} of ${job.total}` : "");
  byId("progress").max = job.total || 1;
  if (job.total) byId("progress").value = job.finished;
  else byId("progress").removeAttribute("value");
  if (byId("job").dataset.error !== job.error) showJobError(job);
  byId("job").dataset.error = job.error;
  const isReading = job.state === "stopped" && Boolean(job.words);
  const keptText = isReading ? `: ${job.words}` : job.total ? `: ${job.finished} of ${job.total} are finished and kept` : "";
  const stopText = job.state === "stopped" ? `stopped${keptText}` : "";
  if (!selection) showResult(job.answer, [stopText, job.by, loadText(job)].filter(Boolean).join("; "), !job.by && !isReading);
  byId("command").textContent = equivalentCommand(job);
  byId("share").hidden = !job.versions || isActive || isReading || Boolean(job.by);
  const isShear = job.command.startsWith("stiction shear");
  for (const item of byId("share").querySelectorAll("#quote, [data-file='study.toml']")) item.hidden = isShear;
  for (const link of byId("share").querySelectorAll("a")) link.href = withKey(`/jobs/${job.number}/${link.dataset.file}?save`);
  const page = withKey(`/jobs/${job.number}/page.html?${job.versions}`);
  const frame = byId("page");
  frame.hidden = !job.versions; // without files, the displayed values have no report
  if (!job.versions || page === reportAddress) return;
  const hash = reportAddress && frame.contentWindow.location.hash;
  reportAddress = page;
  frame.contentWindow.location.replace(page + (hash || (job.command.startsWith("stiction run") ? `#d=${dimension()}` : "")));
}

// CSS classes by assessment
const ASSESSMENT_CLASSES = {"Quote it": "good", "Quote with care": "care", "Do not quote": "bad"};

/** Show values, assessment and caveats. Intermediate results are grey and have no assessment. */
function showResult(answer, scope, isFinal) {
  const place = byId("answer");
  const text = JSON.stringify([answer, scope, isFinal]);
  if (place.dataset.text === text) return;
  place.dataset.text = text;
  place.replaceChildren(...(scope ? [createNode("p", {className: "hint"}, scope)] : []));
  if (!answer) return;
  if (answer.lines) {
    place.append(...answer.lines.map(({place: where, text: words, value}) => {
      const line = createNode("p", {className: "value"}, createNode("i", {}, "μ"), ` = ${words} `, createNode("small", {className: "hint"}, where));
      Object.assign(line.dataset, {place: where, value});
      return line;
    }), createNode("ul", {className: "caveats", tabIndex: 0}, ...answer.caveats.map((words) => createNode("li", {}, words))));
    return;
  }
  for (const {rule, text: words, coefficient: {value, lower, upper}} of answer.rules.filter(({coefficient}) => coefficient.value !== null)) {
    const line = createNode("p", {className: `value ${isFinal ? "" : "hint"}`}, createNode("i", {}, "μ"), createNode("sub", {}, "s"),
      ` = ${words} `, createNode("small", {className: "hint"}, RULE_DESCRIPTIONS[rule]));
    Object.assign(line.dataset, {rule, value, lower, upper});
    place.append(line);
  }
  if (isFinal) place.append(createNode("p", {className: `assessment ${ASSESSMENT_CLASSES[answer.assessment]}`}, answer.assessment),
    createNode("ul", {className: "caveats", tabIndex: 0}, ...answer.caveats.map(({text: words, remedy, severity}) => createNode("li", {className: severity}, `${words}; ${remedy}`))),
    createNode("p", {className: "sentence", id: "sentence", hidden: true}, answer.sentence));
}

/** Return the load of the displayed values if the job has several loads, or an empty text. */
function loadText({answer, command}) {
  if (!answer?.at.load || !/ '?--load=[^']*,/.test(command)) return "";
  return `at the lowest load, ${Number(answer.at.load.toPrecision(4))} mN; the report and the table contain all loads`;
}

/** Return the command line that gives the same numbers. */
function equivalentCommand({command}) {
  if (!selection) return command;
  const [, subcommand, name] = command.split(" ");
  if (subcommand === "pair" && selection.isStudyLoad && command.includes("--mu0="))
    return command.replace(/--mu0=\S+/, `--mu0=${selection.mu0}`).replace(/'--tau0=[^']*'/, `'--tau0=${selection.tau0} MPa'`);
  const folder = subcommand === "info" ? name : `${command} && stiction at ${subcommand === "run" ? "quick" : "pair"}`;
  return `${subcommand === "info" ? "stiction at " : ""}${folder} --load='${selection.load} mN' --mu0=${selection.mu0} --tau0='${selection.tau0} MPa'${selection.d ? ` --d=${selection.d}` : ""}`;
}

let updateTimer = 0;
const reportDocument = () => byId("page").contentDocument;

/** Adapt the style of the report and listen to its events. */
function connectReport() {
  const report = reportDocument();
  if (!report?.getElementById("main")) return;
  const fit = () => { byId("page").style.height = matchMedia("(min-width: 60rem)").matches ? "" : `${report.documentElement.scrollHeight}px`; };
  new ResizeObserver(fit).observe(report.documentElement);
  if (!report.getElementById("readout")) return;
  report.head.append(Object.assign(report.createElement("style"), {textContent:
    "body { padding: 0; max-width: none } header .over, header h1, #judgement, " +
    ".pair #answer > :is(.of, .value, .interval) { display: none } #controls { top: 0 }"}));
  for (const name of ["input", "click", "keyup"]) report.addEventListener(name, () => { clearTimeout(updateTimer); updateTimer = setTimeout(updateValues, UPDATE_DELAY); });
}

/** Update the values after a selection in the report. `typed` contains mu0 and tau0 (GPa) of the form that the report does not have. */
async function updateValues(typed = {}) {
  const job = jobs.find(({number}) => number === current);
  const {load, mu0, tau0, dimension: d} = {...reportDocument()?.getElementById("readout")?.dataset, ...typed};
  if (!job?.answer || job.by || load === undefined) return; // only the report shows other values while the computation continues
  const isNear = (value, reference) => Math.abs(value - reference) <= 1e-9 * Math.abs(reference);
  const {at} = job.answer;
  const wanted = {load, mu0, tau0: Number((1000 * tau0).toPrecision(12)), d: job.command.startsWith("stiction pair") ? "" : d, isStudyLoad: isNear(load, at.load)};
  for (const name of ["mu0", "tau0"]) if (Number(entry(name)) !== Number(wanted[name])) form[name].value = wanted[name];
  const isStudyPoint = wanted.isStudyLoad && isNear(mu0, at.mu0) && Math.abs(tau0 - at.tau0) < 1e-12 && !wanted.d;
  if (isStudyPoint) selection = null;
  else if (JSON.stringify(wanted) !== JSON.stringify(selection)) {
    selection = wanted;
    const {points} = await requestJson(`/jobs/${job.number}/at?${new URLSearchParams({load, mu0, tau0, ...(wanted.d ? {d} : {})})}`).catch(() => ({points: []}));
    if (selection === wanted) showResult(points[0] ?? null, "", true);
  }
  render();
}

/** Select mu0 and tau0 of the form in the report, which has only some values, and update the values. */
function transferToReport() {
  const numbers = {mu0: Number(entry("mu0") || NaN), tau0: Number(entry("tau0") || NaN)};
  if (byId("page").hidden || !reportDocument()?.getElementById("readout") || !Object.values(numbers).every((number) => number >= 0)) return;
  const isShown = Object.entries(numbers).map(([name, number]) => byId("page").contentWindow.selectParameter(name, number));
  clearTimeout(updateTimer);
  updateTimer = setTimeout(updateValues, UPDATE_DELAY, isShown.every(Boolean) ? {} : {mu0: numbers.mu0, tau0: Number((numbers.tau0 / 1000).toPrecision(12))});
}

const dimension = () => (1 + 0.05 * Number(byId("d").value)).toFixed(2);
const length = (id) => `${Number((10 ** Number(byId(id).value)).toPrecision(2))} um`;
const studyChanges = () => ({"surfaces.amplitude": [length("height")], "surfaces.length_scale": length("length"),
  "surfaces.convention": byId("measure").value, "ensemble.seed": Number(byId("seed").value)});
let profileTimer = 0;

/** Show the values of the sliders and the generated profiles. */
function updateProfiles() {
  byId("d-text").textContent = byId("measure").value === "paper" ? `D = ${dimension()}` : `H = ${(2 - dimension()).toFixed(2)}`;
  for (const id of ["height", "length"]) byId(`${id}-text`).textContent = length(id).replace("um", "µm");
  byId("seed-text").textContent = byId("seed").value;
  clearTimeout(profileTimer);
  profileTimer = setTimeout(() => {
    byId("profile").src = withKey(`/profiles?${new URLSearchParams({set: JSON.stringify({...studyChanges(), "surfaces.fractal_dimension": [Number(dimension())]})})}`);
  }, UPDATE_DELAY / 2);
}

/** Submit the study of the sliders. */
function submitRun(event) {
  event.preventDefault();
  const options = Object.entries(studyChanges()).map(([key, value]) => ["set", `${key}=${Array.isArray(value) ? JSON.stringify(value) : value}`]);
  submitJob("run-wrong", {command: "run", options});
}

let listTimer = 0;
let latestList = 0; // number of the latest request for the list; responses to earlier requests are ignored

/** List the results in the directory while their panel is open. */
async function listResults() {
  clearTimeout(listTimer);
  if (!byId("there").open) return;
  const request = (latestList += 1);
  const list = await requestJson("/results").catch(() => []);
  if (request !== latestList) return;
  const text = JSON.stringify(list);
  if (byId("results").dataset.text !== text) byId("results").replaceChildren(...list.map(({name, finished, total, kind, error}) => {
    const words = error ?? `${kind === "measured" ? "a pair" : "a study"}, ${finished} of ${total}`;
    const button = createNode("button", {type: "button", disabled: Boolean(error) || !finished, onclick: () => submitJob("open-wrong", {command: "open", name})}, name);
    return createNode("li", {}, button, ` ${words}`);
  }), ...(list.length ? [] : [createNode("li", {}, "There are no results in the directory where stiction was started.")]));
  byId("results").dataset.text = text;
  listTimer = setTimeout(listResults, 2000);
}

const formFields = () => [...form.querySelectorAll("[name]")];
/** Store the state of the page, which a reload restores. */
function saveState() {
  sessionStorage.setItem("state", JSON.stringify({scans, interfaceFiles, current, fields: formFields().map(({value}) => value)}));
}

function restoreState() {
  const state = JSON.parse(sessionStorage.getItem("state") ?? "null");
  if (!state) return;
  current = state.current;
  Object.assign(scans, state.scans);
  state.interfaceFiles.forEach(addInterface);
  formFields().forEach((field, i) => { field.value = state.fields[i]; });
  sides.forEach(previewScan);
}

/** Show the fields of elastic constants if a material is given by numbers. */
function showNumbers() {
  const isByNumbers = sides.some((side) => form[side].value === "numbers");
  Object.assign(byId("numbers"), {hidden: !isByNumbers, disabled: !isByNumbers});
  sides.forEach((side, i) => {
    for (const name of ["young", "poisson"]) form[name][i].value = form[side].selectedOptions[0].dataset[name] ?? form[name][i].value;
  });
}

/** Disable the fields of μ0 and τ0 if an interface contains their values. */
function showInterface() {
  for (const name of ["mu0", "tau0"]) form[name].disabled = Boolean(form.interface.value);
}

/** Copy a text to the clipboard and confirm it on the button. */
async function copy(button, text) {
  const label = (button.dataset.label ??= button.textContent);
  await navigator.clipboard.writeText(text).then(() => { button.textContent = "Copied"; }, () => { button.textContent = "Press Ctrl-C"; });
  setTimeout(() => { button.textContent = label; }, 2000);
}

sides.forEach(connectDrop);
restoreState();
showNumbers();
showInterface();
updateProfiles();
form.addEventListener("submit", submitPair);
byId("shear").addEventListener("submit", submitShear);
form.addEventListener("change", () => { showNumbers(); showInterface(); saveState(); });
form.addEventListener("input", ({target}) => { if (target.ariaInvalid) clearFieldErrors(); });
for (const name of ["mu0", "tau0"]) form[name].addEventListener("input", transferToReport);
byId("interface-file").addEventListener("change", ({target}) => {
  const [file] = target.files;
  target.value = ""; // or else the browser would ignore a second choice of the same file
  if (file) uploadInterface(file);
});
byId("run").addEventListener("input", updateProfiles);
byId("run").addEventListener("submit", submitRun);
byId("page").addEventListener("load", connectReport);
byId("there").addEventListener("toggle", listResults);
for (const [id, action] of Object.entries({
  demo: loadSamples,
  stop: () => postJson(`/jobs/${current}/stop`),
  quote: () => copy(byId("quote"), byId("sentence").textContent),
  copy: () => copy(byId("copy"), byId("command").textContent),
  menu: () => postJson("/menu").then(({file}) => `Added: ${file}`, ({message}) => message).then((text) => { byId("menu-said").textContent = text; }),
})) byId(id).addEventListener("click", action);
if (document.body.dataset.demo && !scans.upper) loadSamples();
poll();
