// The circle of a strip's flap angle, with a handle to turn it, and the landscape of its cost.

const SVG = "http://www.w3.org/2000/svg";
const RADIUS = 80;
const CLEAR = 0.01; // degrees that a handle stays within a free arc
const STEP = 0.1; // of a handle that is dragged
const KEYS = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1, PageUp: 10, PageDown: -10 };
const [WIDE, HIGH] = [360, 84]; // of the landscape

/** An angle in [0, 360), in degrees, of 10 digits after the point at most. */
export const turn = (angle) => Number((((angle % 360) + 360) % 360).toFixed(10)) % 360;

/** The span of an arc (start, end) of degrees; the whole circle is (0, 360). */
const span = ([start, end]) => turn(end - start) || 360;

/** Whether an angle is within one of some free arcs. */
export const isFree = (arcs, angle) =>
  arcs.some((arc) => span(arc) === 360 || (turn(angle - arc[0]) > 0 && turn(angle - arc[0]) < span(arc)));

/** The ends of an arc that a handle may reach. */
function reach(arc) {
  const inset = Math.min(CLEAR, span(arc) / 3);
  return [turn(arc[0] + inset), turn(arc[1] - inset)];
}

const apart = (a, b) => Math.min(turn(a - b), turn(b - a));

/** The angle itself where it is free, or the nearest one that is. */
export function nearestFree(arcs, angle) {
  if (isFree(arcs, angle) || !arcs.length) return angle;
  return arcs.flatMap(reach).reduce((best, each) => (apart(each, angle) < apart(best, angle) ? each : best));
}

/** The first of some angles that comes after this one, upwards or, for a step below 0, downwards. */
function nextOf(angles, angle, step) {
  const onward = (each) => turn(Math.sign(step) * (each - angle)) || 360;
  return angles.reduce((best, each) => (onward(each) < onward(best) ? each : best));
}

/** The next free angle some degrees on, or beyond the arc where that is forbidden. */
export function stepFree(arcs, angle, step) {
  const next = turn(angle + step);
  if (isFree(arcs, next) || !arcs.length) return next;
  return nextOf(arcs.map((arc) => reach(arc)[step > 0 ? 0 : 1]), angle, step);
}

function element(tag, attributes = {}, parent = undefined) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  parent?.append(made);
  return made;
}

const place = (angle, radius = RADIUS) => {
  const radians = (angle * Math.PI) / 180;
  return [radius * Math.cos(radians), -radius * Math.sin(radians)].map((x) => Number(x.toFixed(3)));
};

/** The path of an arc along the circle, from start counterclockwise. */
function arcPath([start, end], radius = RADIUS) {
  const size = span([start, end]);
  const parts = Math.ceil(size / 120);
  const points = Array.from({ length: parts + 1 }, (_, n) => place(start + (size * n) / parts, radius).join(" "));
  return `M${points[0]}` + points.slice(1).map((point) => `A${radius} ${radius} 0 0 0 ${point}`).join("");
}

export class FlapCircle {
  /** change : called with an angle in degrees whenever the handle is moved. */
  constructor(circle, landscape, change) {
    this.svg = circle;
    this.chart = landscape;
    this.change = change;
    circle.setAttribute("viewBox", "-112 -104 224 208");
    landscape.setAttribute("viewBox", `-12 -2 ${WIDE + 24} ${HIGH + 20}`);
    const group = (name) => element("g", { class: name }, circle);
    element("circle", { r: RADIUS, class: "forbidden" }, circle);
    this.arcs = group("free");
    this.marks = group("marks");
    this.#scale();
    this.old = element("line", { class: "old-face", x1: 0, y1: 0 }, circle);
    this.flap = element("line", { class: "flap", x1: 0, y1: 0 }, circle);
    element("circle", { r: 3, class: "hub" }, circle);
    this.handle = element("g", { class: "handle", role: "slider", tabindex: 0 }, circle);
    element("circle", { r: 14, class: "touch" }, this.handle);
    element("circle", { r: 8 }, this.handle);
    this.handle.setAttribute("aria-valuemin", 0);
    this.handle.setAttribute("aria-valuemax", 360);
    this.handle.addEventListener("keydown", (event) => this.#key(event));
    for (const [svg, angleAt] of [
      [circle, (x, y) => (Math.atan2(-y, x) * 180) / Math.PI],
      [landscape, (x) => Math.min(Math.max(x, 0), WIDE - CLEAR)],
    ]) {
      svg.addEventListener("pointerdown", (event) => this.#down(event, svg, angleAt));
      svg.addEventListener("pointermove", (event) => this.#move(event, svg, angleAt));
      for (const end of ["pointerup", "pointercancel"]) svg.addEventListener(end, () => (this.held = undefined));
    }
    this.state = { free: [[0, 360]], closings: null, special: [] };
    this.angle = 0;
  }

  #scale() {
    for (let angle = 0; angle < 360; angle += 30) {
      const [[x1, y1], [x2, y2]] = [place(angle, RADIUS - 11), place(angle, RADIUS - 15)];
      element("line", { x1, y1, x2, y2, class: "tick" }, this.svg);
      if (angle % 90) continue;
      const [x, y] = place(angle, RADIUS - 29);
      element("text", { x, y }, this.svg).textContent = `${angle}°`;
    }
  }

  /** What may be chosen (`hand_state` of the studio), and the landscape: cost and constraint. */
  show(state, name) {
    this.state = state;
    this.handle.setAttribute("aria-label", name);
    this.arcs.replaceChildren();
    for (const arc of state.closings ? [] : state.free) element("path", { d: arcPath(arc) }, this.arcs);
    for (const angle of state.closings ?? []) {
      const [cx, cy] = place(angle);
      element("circle", { cx, cy, r: 5, class: "closing" }, this.arcs);
    }
    this.marks.replaceChildren();
    for (const { name: kind, vertex, angle } of state.special) {
      const far = vertex === state.special[0].vertex ? 13 : 9;
      const [[x1, y1], [x2, y2]] = [place(angle, RADIUS + 6), place(angle, RADIUS + 6 + far)];
      const mark = element("line", { x1, y1, x2, y2, class: kind.replaceAll(" ", "-") }, this.marks);
      element("title", {}, mark).textContent = `${kind} at vertex ${vertex}: ${angle.toFixed(2)}°`;
    }
    const [x2, y2] = place(state.oldFace, RADIUS - 34);
    for (const [key, value] of Object.entries({ x2, y2 })) this.old.setAttribute(key, value);
    this.#draw(state);
  }

  /** The landscape as a curve of the cost over bars of broken constraints, forbidden arcs shaded. */
  #draw({ free, closings, cost, constraint }) {
    this.chart.replaceChildren();
    const inside = element("g", {}, this.chart);
    element("rect", { width: WIDE, height: HIGH, class: "forbidden" }, inside);
    for (const [start, end] of closings ? [] : free) {
      const parts = span([start, end]) === 360 ? [[0, 360]] : end < start ? [[start, 360], [0, end]] : [[start, end]];
      for (const [x, until] of parts) element("rect", { x, width: until - x, height: HIGH, class: "free" }, inside);
    }
    for (const angle of closings ?? []) element("rect", { x: angle - 1, width: 2, height: HIGH, class: "free" }, inside);
    const step = WIDE / cost.length;
    const most = Math.max(1, ...constraint);
    const bars = [...constraint].map((count, n) => `L${n * step} ${HIGH - (0.5 * HIGH * count) / most}`);
    element("path", { d: `M0 ${HIGH}${bars.join("")}L${WIDE} ${HIGH}Z`, class: "constraint" }, inside);
    const [low, high] = [Math.min(...cost), Math.max(...cost)];
    const level = (value) => 4 + (HIGH - 8) * (1 - (value - low) / (high - low || 1));
    const points = [...cost, cost[0]].map((value, n) => `${n * step} ${level(value).toFixed(2)}`);
    element("path", { d: `M${points.join("L")}`, class: "cost" }, inside);
    this.cursor = element("line", { y1: 0, y2: HIGH, class: "cursor" }, inside);
    for (let angle = 0; angle <= 360; angle += 90) {
      element("text", { x: angle, y: HIGH + 12 }, inside).textContent = `${angle}°`;
    }
    this.turnTo(this.angle);
  }

  /** Move the handle without telling. */
  turnTo(angle) {
    this.angle = turn(angle);
    const [x, y] = place(this.angle);
    this.handle.setAttribute("transform", `translate(${x} ${y})`);
    this.flap.setAttribute("x2", x);
    this.flap.setAttribute("y2", y);
    this.cursor?.setAttribute("x1", this.angle);
    this.cursor?.setAttribute("x2", this.angle);
    const { free, closings } = this.state;
    const fits = closings ? closings.some((each) => apart(each, this.angle) < 1e-6) : isFree(free, this.angle);
    this.handle.setAttribute("aria-valuenow", Number(this.angle.toFixed(2)));
    this.handle.setAttribute("aria-valuetext", `${Number(this.angle.toFixed(2))} degrees, ${fits ? "free" : "forbidden"}`);
    this.svg.classList.toggle("refused", !fits);
  }

  /** Move the handle to the nearest free angle, and tell. */
  choose(angle) {
    const { free, closings } = this.state;
    const wanted = closings?.length
      ? closings.reduce((best, each) => (apart(each, angle) < apart(best, angle) ? each : best))
      : nearestFree(free, turn(angle));
    if (wanted === this.angle) return;
    this.turnTo(wanted);
    this.change(this.angle);
  }

  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { free, closings } = this.state;
    let wanted;
    if (event.key in KEYS) {
      const step = KEYS[event.key] * (event.shiftKey ? STEP : 1);
      wanted = closings?.length
        ? nextOf(closings, this.angle, step)
        : stepFree(free, this.angle, step);
    } else if (event.key === "Home" || event.key === "End") {
      const arc = free.find((each) => isFree([each], this.angle));
      if (arc) wanted = reach(arc)[event.key === "Home" ? 0 : 1];
    }
    if (wanted === undefined) return;
    event.preventDefault();
    this.choose(wanted);
  }

  #down(event, svg, angleAt) {
    event.preventDefault();
    this.handle.focus({ preventScroll: true });
    svg.setPointerCapture(event.pointerId);
    this.held = event.pointerId;
    this.#move(event, svg, angleAt);
  }

  #move(event, svg, angleAt) {
    if (event.pointerId !== this.held) return;
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    const angle = angleAt(point.x, point.y);
    this.choose(Math.round(angle / STEP) * STEP);
  }
}
