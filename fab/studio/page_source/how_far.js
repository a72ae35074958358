// How far something is that the studio makes, with the time that is left.

import { ask } from "./messages.js";

const LOOK_AFTER = 400; // milliseconds between two looks

export class HowFar {
  /** place : shown while it lasts, with a bar, a text of the class "stage" and a button that ends it. */
  constructor(place) {
    this.place = place;
    this.bar = place.querySelector("progress");
    this.stage = place.querySelector(".stage");
    this.busy = false;
    place.querySelector("button").addEventListener("click", () => ask("stop", {}));
  }

  set(busy) {
    this.busy = busy;
    this.place.hidden = !busy;
    clearTimeout(this.timer);
    if (!busy) return;
    this.bar.removeAttribute("value");
    this.stage.textContent = "begins …";
    this.timer = setTimeout(() => this.#look(), LOOK_AFTER);
  }

  async #look() {
    const { step } = await ask("progress", {});
    if (!this.busy) return;
    if (step) {
      const { stage, done, total, left } = step;
      const share = total > 1 ? ` ${done} of ${total}` : "";
      this.stage.textContent = stage + share + (left === null ? "" : `, ${timeOf(left)} left`);
      if (total > 1) this.bar.value = done / total;
      else this.bar.removeAttribute("value");
    }
    this.timer = setTimeout(() => this.#look(), LOOK_AFTER);
  }
}

function timeOf(seconds) {
  return seconds < 90 ? `about ${Math.max(1, Math.round(seconds))} s` : `about ${Math.round(seconds / 60)} min`;
}
