// Files of the job: which are made, how far that is, and where they go.

import { HowFar } from "./how_far.js";
import { ask } from "./messages.js";

const STOCK = { material: "sheet", machine: "cutter", printer: "printer", print_material: "print" };
const COMMON = { material: "card_300gsm", machine: "co2_60w_600x400" }; // where the user has set none
const find = (selector) => document.querySelector(selector);

export class Exports {
  /** source : says what files are made of, { text } or { file }. busy : called with whether it is at work. */
  constructor(source, busy) {
    this.source = source;
    this.busy = busy;
    this.howFar = new HowFar(find("#making"));
    this.allowed = false;
    for (const radio of document.querySelectorAll("input[name=command]")) {
      radio.addEventListener("change", () => this.#choose());
    }
    find("#make").addEventListener("click", () => this.#make());
    find("#keep").addEventListener("click", () => this.#keep());
  }

  /** Begin with another job or pattern: nothing is made of it yet. */
  async begin({ isJob }) {
    this.isJob = isJob;
    this.#forget();
    for (const radio of document.querySelectorAll("input[name=command]")) {
      radio.disabled = radio.value === "run" && !isJob;
    }
    find(`input[name=command][value=${isJob ? "run" : "fabricate"}]`).checked = true;
    this.#choose();
    const { stock, usual } = await ask("stock", {});
    if (!stock) return;
    for (const [id, kind] of Object.entries(STOCK)) {
      fill(find(`#${id}`), stock[kind], usual[id] ?? COMMON[id], id.startsWith("print"));
    }
  }

  /** Whether there is a sheet that files can be made of. */
  allow(allowed) {
    this.allowed = allowed;
    find("#make").disabled = !allowed || this.howFar.busy;
  }

  #forget() {
    this.key = undefined;
    say("");
    find("#made-files").replaceChildren();
    find("#made-of").hidden = find("#result").hidden = true;
    find("#result iframe").removeAttribute("src");
  }

  #choose() {
    this.command = find("input[name=command]:checked").value;
    find("#of-fabricate").hidden = this.command !== "fabricate";
    find("#of-thicken").hidden = this.command !== "thicken" || this.isJob;
    find("#by-job").hidden = this.command !== "thicken" || !this.isJob;
  }

  #request() {
    const { command } = this;
    if (command === "run") return {};
    const value = (id) => find(`#${id}`).value;
    if (command === "thicken") return this.isJob ? {} : { printer: value("printer"), print_material: value("print_material") };
    const copies = find("#copies").valueAsNumber;
    const two_sided = find("#two-sided").checked;
    return { material: value("material"), machine: value("machine"), copies: Number.isNaN(copies) ? 0 : copies, two_sided };
  }

  async #make() {
    const source = this.source();
    this.#forget();
    this.#setBusy(true);
    const answer = await ask("make", { ...source, command: this.command, ...this.#request() });
    this.#setBusy(false);
    if (answer.key) this.#show(answer);
    else if (answer.stopped) say("Cancelled: no file was made.");
    else say(answer.refused ?? answer.lost, true);
  }

  #setBusy(busy) {
    this.howFar.set(busy);
    this.allow(this.allowed);
    this.busy(busy);
  }

  #show({ key, name, files, page, sound, findings, findingsCount }) {
    this.key = key;
    const place = `made/${key}/`;
    const errors = sound ? "" : ", with findings that are errors";
    say(`made ${count(files.length, "file")}${errors}`);
    const items = files.map(([file, bytes]) => {
      const item = document.createElement("li");
      item.append(loading(place + encodeURIComponent(file), file), ` ${size(bytes)}`);
      return item;
    });
    find("#made-files").replaceChildren(...items);
    const told = findings.map(({ severity, code, text }) => `${severity}: ${code}: ${text}`);
    if (findingsCount > findings.length) told.push(`and ${findingsCount - findings.length} more`);
    find("#made-findings").replaceChildren(
      ...told.map((textContent) => Object.assign(document.createElement("li"), { textContent })),
    );
    find("#made-of").hidden = false;
    Object.assign(find("#zip"), { href: `${place}all.zip`, download: `${name}.zip` });
    find("#result").hidden = page === null;
    if (page === null) return;
    const address = place + encodeURIComponent(page);
    find("#result-title").textContent = page;
    find("#result iframe").src = find("#alone").href = address;
  }

  async #keep() {
    const answer = await ask("keep", { key: this.key, into: find("#into").value });
    if (answer.into) say(`wrote into ${answer.into}`);
    else say(answer.refused ?? answer.lost, true);
  }
}

function say(text, wrong = false) {
  find("#made").textContent = text;
  find("#made").className = wrong ? "verdict error" : "";
}

/** Choices of a select, those of the folder apart; the one that is chosen stays, the usual one is first chosen. */
function fill(select, stock, usual, optional) {
  const before = select.options.length ? select.value : undefined;
  const groups = [false, true].map((own) => {
    const group = Object.assign(document.createElement("optgroup"), { label: own ? "in the folder" : "known by name" });
    const chosen = stock.filter((each) => each.own === own);
    group.append(...chosen.map(({ name, text }) => new Option(text ? `${name}: ${text}` : name, name)));
    return group;
  });
  const none = optional ? [new Option("none", "")] : [];
  select.replaceChildren(...none, ...groups.filter((group) => group.children.length));
  const chosen = [before, usual].find((name) => [...select.options].some(({ value }) => value === name));
  if (chosen !== undefined) select.value = chosen;
}

function loading(href, name) {
  return Object.assign(document.createElement("a"), { href, download: name, textContent: name });
}

function size(bytes) {
  return bytes < 1e6 ? `${Math.max(1, Math.round(bytes / 1e3))} kB` : `${(bytes / 1e6).toPrecision(3)} MB`;
}

function count(number, what) {
  return `${number} ${what}${number === 1 ? "" : "s"}`;
}
