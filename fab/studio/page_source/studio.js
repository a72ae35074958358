// The studio's page: a gallery, and a job whose sheet is shown as its values change.

import { canDraw } from "../../viewing/page_source/form_view.js";
import { Exports } from "./exports.js";
import { HandGrowth } from "./hand_growth.js";
import { fillForm, markFaults } from "./job_form.js";
import { LiveForm, LivePattern, toForm } from "./live_view.js";
import { remember, remembered } from "./memory.js";
import { Newest, ask, leave, post } from "./messages.js";
import { Simulation, shareAt } from "./simulation.js";

const STRIPS = JSON.stringify(["design", "strips"]); // as changes are kept by
const STUDIO = "quadfold studio";
const FOLD_AFTER = 250; // milliseconds without a change
const find = (selector) => document.querySelector(selector);

const start = await (await fetch("start")).json();
const pattern = new LivePattern(find("#pattern"), start.colours.edges);
const queue = new Newest(show);
const files = new Exports(
  () => (job ? { text: job.text } : { file: sheet.source.file }),
  (busy) => simulation.allow(!busy && grown),
);
const simulation = new Simulation({ sheet: () => sheet, use: showSimulated, busy: (busy) => files.allow(!busy && grown) });
const hand = new HandGrowth({
  pattern,
  notice,
  asked: () => job && { text: job.text, changes: [...job.unsettled.values()] },
  put: (strips) => {
    change(["design", "strips"], strips);
    grow();
  },
  reopen: edited,
});
let view; // of the form, made with the first sheet
let sheet; // the last good one
let grown = false; // whether it is of the job as it is now
let job; // its text, and changes that were not accepted yet
let foldTimer;
const pictures = new Set(); // those in sight that are not drawn yet
let painting = false;

find("#place").textContent = start.folder;
buildGallery();
wire();
begin(remembered());

/** Go on where this tab was, or begin with the file that the studio was started with. */
function begin(work) {
  if (work?.gallery || (!work && start.file === null)) showGallery();
  else if (work?.text) openJob({ text: work.text }, work.file, work);
  else if (work || start.text === null) openPattern((work ?? start).file);
  else openJob({ text: start.text }, start.file, { saved: start });
}

function buildGallery() {
  const seen = new IntersectionObserver((entries) => {
    for (const { isIntersecting, target } of entries) {
      if (isIntersecting) pictures.add(target);
      else pictures.delete(target);
    }
    drawPictures();
  });
  for (const { name, design, description } of start.templates) {
    const card = document.createElement("button");
    card.type = "button";
    card.className = "card";
    card.dataset.template = name;
    const picture = document.createElement("span");
    picture.className = "picture";
    const image = document.createElement("img");
    image.alt = "";
    image.dataset.name = name;
    picture.append(image);
    const texts = [["strong", name], ["small", design.replaceAll("_", " ")], ["span", description]];
    card.append(picture, ...texts.map(([tag, textContent]) => Object.assign(document.createElement(tag), { textContent })));
    card.addEventListener("click", () => openJob({ template: name }, `${name}.toml`));
    find(".cards").append(card);
    seen.observe(image);
  }
}

/** Ask for the pictures in sight, one at a time: a browser has few connections. */
async function drawPictures() {
  if (painting) return;
  painting = true;
  while (pictures.size && !find("#gallery").hidden) {
    const [image] = pictures;
    pictures.delete(image);
    if (image.src || image.dataset.without) continue;
    const response = await fetch(`pictures/${image.dataset.name}`).catch(() => undefined);
    if (response?.status === 200) image.src = URL.createObjectURL(await response.blob());
    else image.dataset.without = "it takes too long";
  }
  painting = false;
}

function wire() {
  find("#to-gallery").addEventListener("click", showGallery);
  find("#apply").addEventListener("click", () => edited(find("#text").value));
  find("#stop").addEventListener("click", () => ask("stop", {}));
  find("#save").addEventListener("click", () => save(false));
  find("#again").addEventListener("click", () => (job ? grow() : openPattern(sheet?.source.file ?? find("#title").textContent)));
  find("#save-name").addEventListener("input", keepWork);
  find("#notice").addEventListener("click", () => getSelection().isCollapsed && notice("")); // copied, it stays
  window.addEventListener("keydown", ({ key }) => key === "Escape" && notice(""));
  window.addEventListener("pagehide", leave);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => view?.pick(view.picked));
  find("#fold").addEventListener("input", foldTo);
  find("#creases").addEventListener("change", (event) => view?.showCreases(event.target.checked));
  find("#whole").addEventListener("click", () => view?.reset());
  window.addEventListener("dragover", (event) => event.preventDefault());
  window.addEventListener("drop", (event) => {
    event.preventDefault();
    if (event.dataTransfer.files.length) openFile(event.dataTransfer.files[0]);
  });
  find("#file").addEventListener("change", (event) => openFile(event.target.files[0]));
}

function showGallery() {
  notice("");
  remember({ gallery: true });
  find("#gallery").hidden = false;
  drawPictures();
  find("#work").hidden = true;
  find("#to-gallery").hidden = true;
  heading(STUDIO);
}

function showWork(name) {
  find("#gallery").hidden = true;
  find("#work").hidden = false;
  find("#to-gallery").hidden = false;
  heading(name);
  window.scrollTo(0, 0);
}

/** Say what is shown now, also to those who do not see it: the keyboard goes on from there. */
function heading(text) {
  title(text);
  find("#title").focus({ preventScroll: true });
}

/** Name the page and its tab. */
function title(text) {
  find("#title").textContent = text;
  document.title = text === STUDIO ? STUDIO : `${text} - ${STUDIO}`;
}

/** Show no sheet: that of another job is not one of this. */
function clear() {
  sheet = undefined;
  simulation.forget();
  find(".views").classList.add("empty");
  find("#sizes").textContent = "";
  find("#findings").replaceChildren();
  find("#state").textContent = "";
  find("#fold").disabled = true;
  showDetail("");
}

/**
 * Open the job of a template or of a text; file : what it is saved as; unsettled : changes to it;
 * saved : what the file has, where this tab knows that; keeps : leave the last sheet in sight.
 */
async function openJob(message, file, { unsettled = [], saved, keeps = false } = {}) {
  const before = grown;
  allowFiles(false); // until it is grown: they are not to be of the job before
  const answer = await ask("open", message);
  if (!answer.fields) {
    allowFiles(before);
    return refuse(answer);
  }
  notice("");
  job = { text: answer.text, unsettled: new Map(unsettled), saved };
  if (keeps) sheet = undefined;
  else clear();
  showWork(answer.name);
  find("#keys").hidden = find("#save-job").hidden = false;
  find("#save-name").value = file;
  files.begin({ isJob: true });
  keepWork();
  fillForm(find("#form"), answer.fields, answer.values, (path, value) => {
    change(path, value);
    if (path[0] === "sheet" && value !== null) dropOtherSizes(path, answer.fields);
    grow();
  });
  for (const [path, value] of job.unsettled.values()) put(path, value);
  hand.open(answer.values.design, job.unsettled.get(STRIPS)?.[1]);
  return grow();
}

/** Go on with another text of the same job. */
function edited(text) {
  return openJob({ text }, find("#save-name").value, { saved: job.saved, keeps: true });
}

/** Say why a job was not opened; where there is none yet, choose another. */
function refuse(answer) {
  if (find("#work").hidden) showGallery();
  notice(answer.refused ?? answer.lost ?? "It was stopped.");
}

function keepWork() {
  const file = find("#save-name").value;
  if (job) remember({ text: job.text, file, unsettled: [...job.unsettled], saved: job.saved });
}

/** Show a value in its field. */
function put(path, value) {
  const field = find(`[data-key="${path.join(".")}"]`);
  if (!field) return;
  if (field.type === "checkbox") field.checked = value === true;
  else field.value = value ?? "";
}

/** Open a file of the user's: a job, a pattern, or a surface with a job that follows it. */
async function openFile(chosen) {
  if (/\.toml$/i.test(chosen.name)) return openJob({ text: await chosen.text() }, chosen.name);
  const answer = await post(`drop?name=${encodeURIComponent(chosen.name)}`, chosen);
  if (!answer.file) return notice(answer.refused ?? answer.lost);
  notice("");
  if (answer.text === null) return openPattern(answer.file);
  return openJob({ text: answer.text }, answer.file.replace(/\.\w+$/, ".toml"));
}

function change(path, value) {
  job.unsettled.set(JSON.stringify(path), [path, value]);
  keepWork();
}

/** A sheet has one size: the others are left out. */
function dropOtherSizes(path, fields) {
  for (const { path: other } of fields) {
    if (other[0] !== "sheet" || other[1] === path[1]) continue;
    change(other, null);
    put(other, null);
  }
}

/** Show the pattern in a file; there is no job to change. */
function openPattern(file) {
  job = undefined;
  clear();
  showWork(file);
  find("#keys").hidden = find("#save-job").hidden = true;
  files.begin({ isJob: false });
  remember({ file });
  hand.close();
  busy();
  queue.ask(async () => ({ ...(await ask("read", { file, topology: "" })), file }));
}

function grow() {
  busy();
  const current = job;
  queue.ask(async () => {
    const changes = [...current.unsettled.values()];
    const answer = await ask("grow", { text: current.text, changes, topology: sheet?.topology ?? "" });
    return { ...answer, job: current, changes };
  });
}

/** Use an answer; later : whether another question waits. */
function show(answer, later) {
  if (answer.job && answer.job !== job) return; // another job was opened meanwhile
  if (!later) find("#stop").hidden = true;
  if (!answer.topology) {
    if (later) return;
    keepLast(answer);
    hand.refresh();
    return;
  }
  notice("");
  markFaults(find("#form"), "");
  if (job) settle(answer);
  const { numbers } = answer;
  const same =
    sheet?.topology === answer.topology && !numbers.triangles && sheet.letters === answer.letters && !sheet.simulated;
  sheet = {
    ...sheet,
    ...numbers,
    topology: answer.topology,
    letters: answer.letters,
    view: answer.view ?? sheet.view,
    states: [numbers.folded],
    simulated: undefined,
    findings: answer.findings,
    more: answer.findingsCount - answer.findings.length,
    folds: "folded" in answer.boxes,
    colours: start.colours,
    source: answer.job ? { text: answer.text } : { file: answer.file },
  };
  simulation.forget();
  find(".views").classList.remove("empty");
  showDetail(answer.detail);
  drawForm(same);
  pattern.show(sheet);
  hand.draw();
  tell(answer);
  allowFiles(true);
  if (later) return;
  hand.refresh();
  askFold();
}

/** Say why there is no new sheet; the last good one stays. */
function keepLast({ refused, lost, stopped }) {
  const what = refused ? "Not grown" : stopped ? "Stopped" : "Lost";
  verdict("error", sheet ? `${what}: the last good form is shown` : what);
  notice(refused ?? lost ?? "");
  markFaults(find("#form"), refused ?? "");
  find("#again").hidden = Boolean(refused);
  if (sheet?.states.length === 1) askFold();
  allowFiles(false);
}

/** Take the text that has the changes, and keep those that came since. */
function settle({ text, name, changes }) {
  job.text = text;
  for (const [path, value] of changes) {
    const key = JSON.stringify(path);
    if (job.unsettled.get(key)?.[1] === value) job.unsettled.delete(key);
  }
  find("#text").value = text;
  title(name);
  keepWork();
}

/** Show the states of a simulation in place of those that were predicted. */
function showSimulated({ states, shares, letters, view, findings, findingsCount, numbers }) {
  const { triangles, trianglesFace, edges, edgesSource } = numbers;
  sheet.simulated = {
    ...{ triangles, trianglesFace, edges, edgesSource, letters, view, shares },
    states: divided(numbers.positions, states),
    colours: start.colours,
  };
  drawForm(false);
  listFindings([...sheet.findings, ...findings], sheet.more + findingsCount - findings.length);
}

function drawForm(same) {
  const shown = sheet.simulated ?? sheet;
  find("#fold").disabled = shown.states.length < 2;
  if (!canDraw()) {
    find("#form-view .without").hidden = false;
    find("#form-view .live").hidden = true;
    return;
  }
  if (view) view.replace(shown, same);
  else view = new LiveForm(find("#form-view canvas"), toForm(shown));
  view.showCreases(find("#creases").checked);
  foldTo();
}

/** Say what is left out of a large sheet; its lines are off at first. */
function showDetail(note) {
  const hint = find("#detail");
  if (Boolean(note) === hint.hidden) find("#creases").checked = !note;
  hint.hidden = !note;
  hint.textContent = note;
}

function foldTo() {
  const share = Number(find("#fold").value);
  const name = nameOf(share);
  find("#state").textContent = name;
  find("#fold").setAttribute("aria-valuetext", name);
  if (sheet && view) view.fold(share * ((sheet.simulated ?? sheet).states.length - 1));
}

/** What the state at a share of the slider is called. */
function nameOf(share) {
  const shares = sheet?.simulated?.shares;
  if (!shares && sheet && !sheet.folds && sheet.states.length < 2) return "flat: the file has no folded form";
  if (share === 0) return "flat";
  const done = shares ? shareAt(shares, share * (shares.length - 1)) : share;
  return done === 1 ? "folded" : `${Math.round(100 * done)}% of the fold`;
}

/** Ask for the states between flat and folded once nothing has changed for a while. */
function askFold() {
  clearTimeout(foldTimer);
  const asked = sheet;
  foldTimer = setTimeout(async () => {
    if (asked !== sheet) return;
    const { text, file } = asked.source;
    const answer = await (file ? ask("read", { file, states: true }) : ask("fold", { text }));
    if (asked !== sheet || !answer.states) return;
    sheet.states = divided(answer.numbers.positions, answer.states);
    if (!sheet.simulated) drawForm(true);
  }, FOLD_AFTER);
}

/** Positions of each of so many states. */
function divided(all, count) {
  const size = all.length / count;
  return Array.from({ length: count }, (_, k) => all.subarray(k * size, (k + 1) * size));
}

function busy() {
  clearTimeout(foldTimer); // what is folded is the sheet to come
  allowFiles(false); // and so are files
  verdict("busy", "Growing …");
  find("#stop").hidden = false;
  find("#again").hidden = true;
}

function verdict(kind, text) {
  find("#verdict").className = `verdict ${kind}`;
  find("#verdict").textContent = text;
}

function tell(answer) {
  const worst = answer.findings.some(({ severity }) => severity === "error") ? "error" : "";
  const ended = answer.status === "grown" || answer.status === "read" ? "" : ` ${answer.advice}`;
  verdict(worst, `${answer.status.replaceAll("_", " ")}: ${answer.faces} faces.${ended}`);
  const box = (sides) => `${sides.map((side) => Number(side.toPrecision(4))).join(" × ")} mm`;
  const sizes = Object.entries(answer.boxes).map(([name, sides]) => `${name} ${box(sides)}`);
  find("#sizes").textContent = sizes.join("; ");
  listFindings(sheet.findings, sheet.more);
}

function listFindings(findings, more) {
  const items = findings.map((finding) => {
    const item = document.createElement("li");
    const severity = document.createElement("span");
    severity.className = `severity ${finding.severity}`;
    severity.textContent = `${finding.severity}: ${finding.code} `;
    item.append(severity, finding.text);
    if (finding.creases.length || finding.panels.length) item.append(" ", lighter(finding));
    return item;
  });
  if (more > 0) items.push(Object.assign(document.createElement("li"), { textContent: `and ${more} more` }));
  find("#findings").replaceChildren(...items);
}

function lighter(finding) {
  const button = Object.assign(document.createElement("button"), { type: "button", textContent: "Show" });
  button.setAttribute("aria-pressed", false);
  button.setAttribute("aria-label", `Show ${finding.code}`);
  button.addEventListener("click", () => {
    const lit = button.getAttribute("aria-pressed") !== "true";
    for (const each of document.querySelectorAll("#findings button")) each.setAttribute("aria-pressed", each === button && lit);
    const picked = lit ? finding : { creases: [], panels: [] };
    view?.pick(inForm(picked));
    pattern.mark(picked);
  });
  return button;
}

/** The same with numbers of the form, whose cuts are open where it was simulated. */
function inForm({ creases, panels }) {
  const source = sheet.simulated?.edgesSource;
  if (!source) return { creases, panels };
  const wanted = new Set(creases);
  return { creases: [...source.keys()].filter((e) => wanted.has(source[e])), panels };
}

function notice(text) {
  find("#notice").textContent = text;
  find("#notice").hidden = !text;
}

function allowFiles(allowed) {
  grown = allowed;
  find("#save").disabled = !allowed;
  files.allow(allowed && !simulation.howFar.busy);
  simulation.allow(allowed && !files.howFar.busy);
}

/** Save the job; a file that is there already is replaced if it is as this tab knows it. */
async function save(replace) {
  const file = find("#save-name").value;
  const { text } = job;
  const before = job.saved?.file === file ? job.saved.text : null;
  const answer = await ask("save", { text, file, before, replace });
  if (answer.exists) {
    const why = before === null ? "exists" : "was changed by another tab or program since";
    if (confirm(`${answer.exists} ${why}. Replace it?`)) await save(true);
    return;
  }
  if (answer.saved) job.saved = { file, text };
  keepWork();
  find("#saved").textContent = answer.saved ? `saved ${answer.saved}` : "";
  notice(answer.refused ?? answer.lost ?? "");
}
