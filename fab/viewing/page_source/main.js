// The result page comes alive: without this script it shows pictures, drawings and numbers.

import { unpacked } from "./arrays.js";
import { Drawing, mark } from "./drawings.js";
import { FormView, canDraw } from "./form_view.js";

const SECONDS = 4; // from flat to folded
const find = (selector) => document.querySelector(selector);
const findAll = (selector) => [...document.querySelectorAll(selector)];

const data = await unpacked(JSON.parse(document.getElementById("data").textContent));
const pattern = find("#pattern svg");
const view = startView();
findAll(".drawing").forEach((figure) => new Drawing(figure));
startFindings();
startTheme();
window.addEventListener("beforeprint", () => findAll("details").forEach((each) => (each.open = true)));

function startView() {
  const figure = find("#form");
  if (!figure || !(data.sheet || data.bodies)) return undefined;
  if (!canDraw()) {
    figure.querySelector(".without").hidden = false;
    return undefined;
  }
  figure.querySelector(".live-view").hidden = false;
  figure.querySelector(".still").open = false;
  const made = new FormView(figure.querySelector("canvas"), data);
  const set = startSlider(figure, made);
  for (const radio of figure.querySelectorAll("input[name=shown]")) {
    radio.addEventListener("change", () => {
      made.show(radio.value);
      set(figure.querySelector("#fold").value);
    });
  }
  for (const radio of figure.querySelectorAll("input[name=coloured]")) {
    radio.addEventListener("change", () => {
      made.showValues(radio.value === "values");
      figure.querySelector(".scale").hidden = radio.value !== "values";
    });
  }
  const creases = figure.querySelector("#creases");
  creases.addEventListener("change", () => made.showCreases(creases.checked));
  made.showCreases(creases.checked);
  const steps = {
    in: () => made.zoom(1.25),
    out: () => made.zoom(1 / 1.25),
    left: () => made.turn(-Math.PI / 12, 0),
    right: () => made.turn(Math.PI / 12, 0),
    whole: () => made.reset(),
  };
  for (const button of figure.querySelectorAll("button[data-step]")) {
    button.addEventListener("click", steps[button.dataset.step]);
  }
  return made;
}

function startSlider(figure, made) {
  const slider = figure.querySelector("#fold");
  const label = figure.querySelector("#state");
  const play = figure.querySelector("#play");
  let running;
  const set = (place) => {
    slider.value = place;
    const stops = made.shown === "panels" && place > data.panelsState;
    const name = stops ? `panels stop ${data.states[data.panelsState]}` : placeName(place);
    label.textContent = name;
    slider.setAttribute("aria-valuetext", name);
    made.fold(Number(place));
  };
  const stop = () => {
    cancelAnimationFrame(running);
    running = undefined;
    play.textContent = "Fold";
  };
  const run = (before, now) => {
    const last = data.states.length - 1;
    const place = Math.min(Number(slider.value) + ((now - before) / 1000 / SECONDS) * last, last);
    set(place);
    if (place < last) running = requestAnimationFrame((next) => run(now, next));
    else stop();
  };
  slider.addEventListener("input", () => {
    stop();
    set(slider.value);
  });
  play.addEventListener("click", () => {
    if (running !== undefined) return stop();
    if (Number(slider.value) >= data.states.length - 1) set(0);
    play.textContent = "Stop";
    running = requestAnimationFrame((now) => run(now, now));
    return undefined;
  });
  set(slider.max);
  return set;
}

/** What a place on the slider is called: of panels by the nearest state, else by its share of the fold. */
function placeName(place) {
  if (data.bodies) return data.states[Math.round(place)];
  const first = Math.min(Math.floor(place), data.shares.length - 1);
  const second = Math.min(first + 1, data.shares.length - 1);
  const share = data.shares[first] + (place - first) * (data.shares[second] - data.shares[first]);
  return share === 0 ? "flat" : `${Math.round(100 * share)}% of the fold`;
}

function startFindings() {
  const nothing = { creases: [], panels: [] };
  const buttons = findAll("button[data-finding]");
  for (const button of buttons) {
    button.hidden = false;
    button.addEventListener("click", () => {
      const chosen = button.getAttribute("aria-pressed") !== "true";
      for (const each of buttons) each.setAttribute("aria-pressed", each === button && chosen);
      const finding = chosen ? data.findings[button.dataset.finding] : nothing;
      view?.pick(finding);
      mark(pattern, finding.creases, finding.panels, data.pattern);
    });
  }
}

function startTheme() {
  const button = find("#theme");
  const root = document.documentElement;
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const isDark = () => (root.dataset.theme ?? (dark.matches ? "dark" : "light")) === "dark";
  const name = () => {
    button.textContent = isDark() ? "Light" : "Dark";
    view?.pick(view.picked); // takes the colours of the page
  };
  button.hidden = false;
  button.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
    name();
  });
  dark.addEventListener("change", name);
  name();
}
