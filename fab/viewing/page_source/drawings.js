// Drawings in the page: zoom, pan, and layers on and off.

const ZOOM = 1.25;
const STEP = 0.1;

export class Drawing {
  constructor(figure) {
    this.svg = figure.querySelector("svg");
    this.whole = this.svg.getAttribute("viewBox").split(" ").map(Number);
    this.box = [...this.whole];
    this.pointers = new Map();
    const [svg, tools] = [this.svg, figure.querySelector(".tools")];
    svg.tabIndex = 0;
    svg.addEventListener("keydown", (event) => this.#key(event));
    svg.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    svg.addEventListener("pointerdown", (event) => this.#down(event));
    svg.addEventListener("pointermove", (event) => this.#move(event));
    for (const end of ["pointerup", "pointercancel"]) {
      svg.addEventListener(end, (event) => this.pointers.delete(event.pointerId));
    }
    const steps = { in: () => this.zoom(ZOOM), out: () => this.zoom(1 / ZOOM), whole: () => this.reset() };
    for (const button of tools.querySelectorAll("button[data-step]")) {
      button.addEventListener("click", steps[button.dataset.step]);
    }
    for (const box of tools.querySelectorAll("input[data-layer]")) {
      const layer = svg.querySelector(`g[data-layer="${box.dataset.layer}"]`);
      box.addEventListener("change", () => layer.toggleAttribute("hidden", !box.checked));
    }
    tools.hidden = false;
  }

  reset() {
    this.#set([...this.whole]);
  }

  /** Zoom about a place, in units of the drawing; about its middle where none is given. */
  zoom(factor, place) {
    const [x, y, width, height] = this.box;
    const [px, py] = place ?? [x + width / 2, y + height / 2];
    const least = this.whole[2] / 400;
    const share = Math.min(Math.max(width / factor, least), this.whole[2] * 2) / width;
    this.#set([px - (px - x) * share, py - (py - y) * share, width * share, height * share]);
  }

  #set(box) {
    this.box = box;
    this.svg.setAttribute("viewBox", box.join(" "));
  }

  #place(event) {
    const point = new DOMPoint(event.clientX, event.clientY);
    const { x, y } = point.matrixTransform(this.svg.getScreenCTM().inverse());
    return [x, y];
  }

  #wheel(event) {
    if (!event.ctrlKey && document.activeElement !== this.svg) return; // the page scrolls
    event.preventDefault();
    this.zoom(Math.exp(-event.deltaY / 400), this.#place(event));
  }

  #down(event) {
    this.svg.focus({ preventScroll: true });
    this.svg.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, event);
  }

  #move(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const others = [...this.pointers.values()].filter((each) => each !== before);
    const far = (each) => Math.hypot(each.clientX - others[0].clientX, each.clientY - others[0].clientY);
    if (others.length && far(before)) this.zoom(far(event) / far(before), this.#place(others[0]));
    const [[fromX, fromY], [toX, toY]] = [this.#place(before), this.#place(event)];
    if (!others.length) {
      const [x, y, ...size] = this.box;
      this.#set([x + fromX - toX, y + fromY - toY, ...size]);
    }
    this.pointers.set(event.pointerId, event);
  }

  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const [x, y, width, height] = this.box;
    const moves = {
      ArrowLeft: () => this.#set([x - STEP * width, y, width, height]),
      ArrowRight: () => this.#set([x + STEP * width, y, width, height]),
      ArrowUp: () => this.#set([x, y - STEP * height, width, height]),
      ArrowDown: () => this.#set([x, y + STEP * height, width, height]),
      "+": () => this.zoom(ZOOM),
      "=": () => this.zoom(ZOOM),
      "-": () => this.zoom(1 / ZOOM),
      0: () => this.reset(),
    };
    if (!(event.key in moves)) return;
    event.preventDefault();
    moves[event.key]();
  }
}

/** Draw what a finding names over the crease pattern: paths of `data`, by the finding's number. */
export function mark(svg, creases, panels, { coords, edges, corners, offsets, height }) {
  const at = (v) => `${coords[2 * v]},${height - coords[2 * v + 1]}`;
  const lines = creases.map((e) => `M${at(edges[2 * e])}L${at(edges[2 * e + 1])}`);
  const rings = panels.map((f) => {
    const ring = [...corners.subarray(offsets[f], offsets[f + 1])];
    return `M${ring.map(at).join("L")}Z`;
  });
  svg.querySelector(".lit-creases").setAttribute("d", lines.join(""));
  svg.querySelector(".lit-panels").setAttribute("d", rings.join(""));
}
