// Growing by hand: strips added on any side, turned about their fronts, and taken off again.

import { FlapCircle, isFree, turn } from "./flap_circle.js";
import { Newest, ask } from "./messages.js";

const KIND = "strip_by_strip";
const SVG = "http://www.w3.org/2000/svg";
const LONGEST = 60; // letters that another name is added to
const SIDES = ["top", "right", "bottom", "left"];
const find = (selector) => document.querySelector(`#hand ${selector}`);
const shown = (value) => String(Number(Number(value).toPrecision(6)));

/** The place beside the middle of a side, and the direction away from the sheet, in the drawing. */
function beside(points) {
  // growth is on the left of the side, and y runs downwards
  const [[x0, y0], [x1, y1]] = [points[0], points.at(-1)];
  const long = Math.hypot(x1 - x0, y1 - y0) || 1;
  const [dx, dy] = [(y1 - y0) / long, (x0 - x1) / long];
  const [x, y] = [(x0 + x1) / 2, (y0 + y1) / 2];
  const reach = Math.max(...points.map(([px, py]) => (px - x) * dx + (py - y) * dy));
  return { x: x + dx * reach, y: y + dy * reach, dx, dy };
}

export class HandGrowth {
  /**
   * pattern : the drawing of the crease pattern, on whose sides strips are grown.
   * asked : returns text and changes of the job. put : takes the strips. reopen : takes another text.
   * notice : shows a text.
   */
  constructor({ pattern, asked, put, reopen, notice }) {
    Object.assign(this, { pattern, asked, put, reopen, notice });
    this.queue = new Newest((answer) => this.#take(answer));
    this.circle = new FlapCircle(find(".circle"), find(".landscape"), (angle) => this.#set({ flap_angle_deg: angle }));
    this.over = document.createElementNS(SVG, "g");
    this.over.setAttribute("class", "hand");
    pattern.svg.append(this.over);
    for (const button of find(".sides").querySelectorAll("button")) {
      const { side } = button.dataset;
      button.addEventListener("click", () => this.add(side));
      for (const [event, lit] of [["pointerenter", true], ["focus", true], ["pointerleave", false], ["blur", false]]) {
        button.addEventListener(event, () => this.over.querySelector(`[data-side="${side}"]`)?.classList.toggle("lit", lit));
      }
    }
    find(".undo").addEventListener("click", () => this.undo());
    find(".redo").addEventListener("click", () => this.redo());
    find(".begin button").addEventListener("click", () => this.begin());
    find(".strip").addEventListener("change", (event) => this.select(Number(event.target.value)));
    find(".angle").addEventListener("input", ({ target }) => {
      if (target.value === "" || target.validity.badInput) return;
      this.circle.turnTo(Number(target.value));
      this.#set({ flap_angle_deg: Number(target.value) });
    });
    find(".special").addEventListener("change", ({ target }) => {
      if (target.value !== "") this.circle.choose(Number(target.value));
    });
    find(".one").addEventListener("input", ({ target }) => {
      if (target.value !== "" && !target.validity.badInput) this.#set({ lengths: Number(target.value) });
    });
    const ends = [find(".first-end"), find(".last-end")];
    for (const input of ends) {
      input.addEventListener("input", () => {
        const angles = ends.map((each) => Number(each.value));
        if (ends.some((each) => each.value === "" || each.validity.badInput)) return;
        this.#set({ boundary_angles_deg: angles });
      });
    }
    find(".parallel").addEventListener("click", () => this.#set({ boundary_angles_deg: undefined }));
    this.close();
  }

  /** Take a job that was opened; design : its table; strips : those that it was not given yet. */
  open(design, strips) {
    this.grown = design.kind === KIND;
    this.pattern.margin = this.grown ? 0.15 : 0.02;
    const given = this.grown ? (strips ?? design.strips ?? []) : []; // others count theirs
    this.strips = given.map((strip) => ({ ...strip }));
    this.taken = []; // strips that were undone, the last one first
    this.number = this.strips.length - 1;
    this.state = this.sides = undefined;
    this.over.replaceChildren();
    this.#fill();
  }

  close() {
    this.grown = false;
    this.strips = [];
    this.taken = [];
    this.number = -1;
    this.state = this.sides = undefined;
    this.over.replaceChildren();
    document.querySelector("#hand").hidden = true;
  }

  /** Ask anew what may be chosen; the sheet was grown, or refused. */
  refresh() {
    if (!this.asked()) return;
    this.draw();
    this.queue.ask(async () => {
      const known = { strip: this.number < 0 ? null : this.number, landscape: this.state?.landscape ?? "" };
      const { text, changes } = this.asked();
      return { ...(await ask("hand", { text, changes, ...known })), of: this.strips };
    });
  }

  #take(answer) {
    const panel = document.querySelector("#hand");
    if (!this.asked() || answer.of !== this.strips) return;
    if (answer.refused || answer.lost) return;
    panel.hidden = !this.grown && !answer.seedable;
    const keys = document.querySelector("#keys"); // first where it is in use, after all keys elsewhere
    if (this.grown && panel.nextElementSibling !== keys) keys.before(panel);
    if (!this.grown && panel.previousElementSibling !== keys) keys.after(panel);
    find(".begin").hidden = this.grown;
    find(".growing").hidden = !this.grown;
    if (answer.sides) this.sides = answer.sides;
    if (answer.strip?.number === this.number) {
      const { cost, constraint } = answer.numbers;
      const before = this.state;
      this.state = { ...answer.strip, cost: cost ?? before.cost, constraint: constraint ?? before.constraint };
    } else this.state = undefined;
    this.#fill();
    this.draw();
  }

  /** Begin to grow on the sheet of another design. */
  async begin() {
    const answer = await ask("by_hand", this.asked());
    if (answer.text) await this.reopen(answer.text);
    else this.notice(answer.refused ?? answer.lost);
  }

  async add(side) {
    if (this.adding) return; // the next one needs the sheet with this one
    this.adding = true;
    const answer = await ask("next_strip", { ...this.asked(), side });
    this.adding = false;
    if (!answer.strip) return this.notice(answer.refused ?? answer.lost);
    this.taken = [];
    this.number = this.strips.length;
    this.#put([...this.strips, answer.strip]);
    this.circle.handle.focus({ preventScroll: true });
  }

  undo() {
    if (!this.strips.length) return;
    this.taken = [this.strips.at(-1), ...this.taken];
    this.number = this.strips.length - 2;
    this.#put(this.strips.slice(0, -1));
  }

  redo() {
    if (!this.taken.length) return;
    const [strip, ...others] = this.taken;
    this.taken = others;
    this.number = this.strips.length;
    this.#put([...this.strips, strip]);
  }

  select(number) {
    this.number = number;
    this.state = undefined;
    this.#fill();
    this.refresh();
  }

  #set(changes) {
    const strips = this.strips.map((strip, n) => (n === this.number ? { ...strip, ...changes } : strip));
    this.#put(strips);
  }

  #put(strips) {
    this.strips = strips;
    this.#fill();
    this.put(strips);
  }

  #fill() {
    const count = this.strips.length;
    find(".undo").disabled = !count;
    find(".redo").disabled = !this.taken.length;
    const reasons = new Set();
    for (const side of SIDES) {
      const why = this.sides?.[side]?.why ?? "";
      find(`.sides [data-side="${side}"]`).disabled = why !== "";
      if (why) reasons.add(why[0].toUpperCase() + why.slice(1));
    }
    find(".why").hidden = !reasons.size;
    find(".why").textContent = [...reasons].join(" ");
    const choice = find(".strip");
    choice.replaceChildren(
      ...this.strips.map(({ side, flap_angle_deg: angle }, n) =>
        Object.assign(document.createElement("option"), { value: n, textContent: `${n + 1}: ${side}, ${shown(angle)}°` }),
      ),
    );
    choice.value = this.number;
    find(".none").hidden = count > 0;
    find(".choices").hidden = !count;
    const strip = this.strips[this.number];
    if (!strip) return;
    const angle = find(".angle");
    if (document.activeElement !== angle) angle.value = shown(strip.flap_angle_deg);
    if (!this.state) return this.circle.turnTo(strip.flap_angle_deg);
    this.circle.angle = turn(strip.flap_angle_deg);
    this.circle.show(this.state, `Flap angle of strip ${this.number + 1}`);
    find(".k-forbidden").textContent = this.state.closings ? "the ring stays open" : "faces cross";
    this.#fillSpecial(strip);
    this.#fillLengths(strip);
    find(".note").textContent = this.#note(strip);
  }

  /** What is said of the flap angle that is chosen. */
  #note({ flap_angle_deg: angle }) {
    const { free, closings, cost, constraint } = this.state;
    if (!closings && !isFree(free, turn(angle))) return "New faces would cross old ones there.";
    const at = Math.round((turn(angle) * cost.length) / 360) % cost.length;
    const broken = constraint[at];
    const over = broken ? ` Near it ${broken === 1 ? "1 constraint is" : `${broken} constraints are`} broken.` : "";
    return `Cost S30: ${cost[at].toPrecision(3)}.${over}`;
  }

  #fillSpecial(strip) {
    const { free, closings, special } = this.state;
    const open = closings ? [] : special.filter(({ angle }) => isFree(free, angle));
    const listed = closings ? closings.map((angle) => ({ name: "closes the ring", angle })) : open;
    if (this.state.best !== null) listed.unshift({ name: "least cost S30", angle: this.state.best });
    const seen = new Map();
    for (const { name, vertex, angle } of listed) {
      const key = angle.toFixed(6);
      const words = `${name}${vertex === undefined ? "" : ` at vertex ${vertex}`}`;
      const before = seen.get(key)?.text ?? `${angle.toFixed(2)}°: `;
      if (before.length < LONGEST) seen.set(key, { angle, text: `${before}${seen.has(key) ? ", " : ""}${words}` });
    }
    const options = [...seen.values()].sort((a, b) => a.angle - b.angle);
    find(".special").replaceChildren(
      Object.assign(document.createElement("option"), { value: "", textContent: `${options.length} of them` }),
      ...options.map(({ angle, text }) => Object.assign(document.createElement("option"), { value: angle, textContent: text })),
    );
    const now = options.find(({ angle }) => Math.abs(angle - turn(strip.flap_angle_deg)) < 1e-6);
    find(".special").value = now ? String(now.angle) : "";
  }

  #fillLengths(strip) {
    const { bounds } = this.state;
    const each = (n) => (Array.isArray(strip.lengths) ? strip.lengths[n] : strip.lengths);
    const least = bounds.reduce((low, bound) => Math.min(low, bound ?? Infinity), Infinity);
    const one = find(".one");
    if (document.activeElement !== one) one.value = Array.isArray(strip.lengths) ? "" : shown(strip.lengths);
    find(".one-bound").textContent = Number.isFinite(least) ? `below ${shown(least)}` : "";
    find(".ends").hidden = !this.state.boundary;
    [find(".first-end"), find(".last-end")].forEach((input, n) => {
      if (document.activeElement !== input) input.value = shown(strip.boundary_angles_deg?.[n] ?? this.state.boundary?.[n] ?? "");
    });
    find(".parallel").disabled = !strip.boundary_angles_deg;
    const list = find(".lengths");
    if (list.children.length !== bounds.length) list.replaceChildren(...bounds.map((_, n) => this.#length(n)));
    bounds.forEach((bound, n) => {
      const [input, text] = [list.children[n].querySelector("input"), list.children[n].querySelector(".bound")];
      const value = each(n);
      if (document.activeElement !== input) input.value = value === undefined ? "" : shown(value);
      input.setAttribute("aria-invalid", !(value > this.state.least) || (bound !== null && value >= bound));
      text.textContent = bound === null ? "any" : `below ${shown(bound)}`;
    });
  }

  #length(n) {
    const row = document.createElement("li");
    const label = document.createElement("label");
    const input = Object.assign(document.createElement("input"), { type: "number", step: "any", min: 0 });
    const bound = Object.assign(document.createElement("span"), { className: "bound", id: `bound-${n}` });
    input.setAttribute("aria-describedby", bound.id);
    input.addEventListener("input", () => {
      if (input.value === "" || input.validity.badInput) return;
      const { lengths } = this.strips[this.number];
      const all = this.state.bounds.map((_, i) => (Array.isArray(lengths) ? (lengths[i] ?? lengths[0]) : lengths));
      all[n] = Number(input.value);
      this.#set({ lengths: all });
    });
    input.addEventListener("keydown", (event) => {
      const step = { ArrowUp: 0.05, ArrowDown: -0.05 }[event.key];
      if (!step || input.value === "") return;
      event.preventDefault();
      input.value = shown(Math.max(Number(input.value) * (1 + step), 1e-6));
      input.dispatchEvent(new Event("input"));
    });
    for (const [event, crease] of [["focus", n], ["blur", undefined]]) {
      input.addEventListener(event, () => {
        this.crease = crease;
        this.draw();
      });
    }
    label.append(`vertex ${n} `, input);
    row.append(label, " ", bound);
    return row;
  }

  /** Draw over the crease pattern: its sides to grow on, and the front of the strip that is chosen. */
  draw() {
    const { data } = this.pattern;
    const { crease } = this;
    this.over.replaceChildren();
    if (!this.grown || !data || !this.sides) return;
    const count = data.coords.length / 2;
    const at = (v) => [data.coords[2 * v], data.height - data.coords[2 * v + 1]];
    const line = (vertices) => `M${vertices.map((v) => at(v).join(" ")).join("L")}`;
    const known = (vertices) => vertices.length > 1 && vertices.every((v) => v < count);
    const path = (vertices, name) => {
      const made = document.createElementNS(SVG, "path");
      made.setAttribute("d", line(vertices));
      made.setAttribute("class", name);
      this.over.append(made);
      return made;
    };
    const { front, row, closed } = this.state ?? {};
    if (front && known(front) && known(row)) {
      path(front, "front");
      path([row[closed ? 0 : 1], front[closed ? 0 : 1]], "first");
      if (crease !== undefined) path([front[crease], row[crease]], "crease");
    }
    for (const [side, { vertices, why }] of Object.entries(this.sides)) {
      if (!known(vertices)) continue;
      const outward = beside(vertices.map(at));
      if (side === SIDES[0]) this.#arrange(outward);
      if (why) continue;
      const hit = path(vertices, "side");
      hit.dataset.side = side;
      const title = document.createElementNS(SVG, "title");
      title.textContent = `Grow a strip on the ${side} side`;
      hit.append(title);
      hit.addEventListener("pointerdown", (event) => event.stopPropagation());
      hit.addEventListener("click", () => this.add(side));
      this.#name(side, outward, data);
    }
  }

  /** Put the buttons where their sides are in the drawing; outward : from the first one. */
  #arrange({ dx, dy }) {
    const turns = Math.abs(dx) > Math.abs(dy) ? (dx > 0 ? 1 : 3) : dy < 0 ? 0 : 2;
    SIDES.forEach((side, n) => (find(`.sides [data-side="${side}"]`).dataset.place = SIDES[(n + turns) % 4]));
  }

  /** The name of a side, beside its middle. */
  #name(side, { x, y, dx, dy }, { coords }) {
    const text = document.createElementNS(SVG, "text");
    const wide = coords.reduce((most, value) => Math.max(most, value), 0);
    text.setAttribute("x", x + 0.03 * wide * dx);
    text.setAttribute("y", y + 0.03 * wide * dy);
    text.style.textAnchor = Math.abs(dx) < 0.5 ? "middle" : dx > 0 ? "start" : "end";
    text.setAttribute("font-size", 0.03 * wide);
    text.textContent = side;
    this.over.append(text);
  }
}
