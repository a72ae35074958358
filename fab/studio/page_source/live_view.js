// The folded form and the crease pattern, which change while they are looked at.

import { Drawing, mark } from "../../viewing/page_source/drawings.js";
import { FormView, sheetForm } from "../../viewing/page_source/form_view.js";

/** A view of a sheet that is replaced by the next one, from where the user looks at it. */
export class LiveForm extends FormView {
  /** Another sheet, or other states of the same; data as of result pages. */
  replace(data, sameFaces) {
    if (sameFaces) this.form.states = [...data.states];
    else {
      for (const object of [...this.form.objects, ...this.form.lit]) {
        object.geometry.dispose();
        object.material.dispose();
      }
      this.forms.sheet = this.form = sheetForm(toForm(data));
      this.direction.set(...data.view);
      this.distances = undefined;
      this.pick({ creases: [], panels: [] });
    }
    this.fold(Math.min(this.place, data.states.length - 1));
    if (!this.moved) this.reset();
  }
}

/** Data of a sheet as result pages have them. */
export function toForm({ states, triangles, trianglesFace, edges, letters, colours, view }) {
  const positions = new Float32Array(states.length * states[0].length);
  states.forEach((coords, k) => positions.set(coords, k * coords.length));
  const sheet = { positions, triangles, trianglesFace, edges, letters };
  return { states: states.map(() => ""), sheet, bodies: null, colours, view };
}

export class LivePattern {
  constructor(figure, colours) {
    this.svg = figure.querySelector("svg");
    this.drawing = new Drawing(figure);
    this.margin = 0.02; // around the sheet, as a share of its size
    for (const group of this.svg.querySelectorAll("g[data-layer]")) {
      group.setAttribute("stroke", colours[group.dataset.layer]);
    }
  }

  show({ flat, edges, letters, corners, offsets }) {
    let [width, height] = [0, 0];
    for (let i = 0; i < flat.length; i += 2) {
      width = Math.max(width, flat[i]);
      height = Math.max(height, flat[i + 1]);
    }
    this.data = { coords: flat, edges, corners, offsets, height };
    const paths = {};
    for (let e = 0; e < letters.length; e++) {
      const [a, b] = [2 * edges[2 * e], 2 * edges[2 * e + 1]];
      const line = `M${at(flat[a])} ${at(height - flat[a + 1])}L${at(flat[b])} ${at(height - flat[b + 1])}`;
      (paths[letters[e]] ??= []).push(line);
    }
    for (const group of this.svg.querySelectorAll("g[data-layer]")) {
      group.firstElementChild.setAttribute("d", (paths[group.dataset.layer] ?? []).join(""));
    }
    const edge = this.margin * Math.max(width, height, 1e-9);
    const box = [-edge, -edge, width + 2 * edge, height + 2 * edge];
    const zoomed = this.drawing.box.join() !== this.drawing.whole.join();
    this.drawing.whole = box;
    if (!zoomed) this.drawing.reset();
    this.mark({ creases: [], panels: [] });
  }

  mark({ creases, panels }) {
    mark(this.svg, creases, panels, this.data);
  }
}

function at(value) {
  return Math.round(value * 100) / 100;
}
