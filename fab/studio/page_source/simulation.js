// The simulation of the sheet: whether it folds, what is in its way, and its states.

import { HowFar } from "./how_far.js";
import { ask } from "./messages.js";

const find = (selector) => document.querySelector(selector);

export class Simulation {
  /**
   * sheet : returns the sheet that is shown, whose `source` is simulated. use : takes an answer.
   * busy : called with whether it is at work.
   */
  constructor({ sheet, use, busy }) {
    Object.assign(this, { sheet, use, busy });
    this.howFar = new HowFar(find("#simulating"));
    this.allowed = false;
    find("#simulate").addEventListener("click", () => this.#simulate());
  }

  /** Whether there is a sheet to simulate, and nothing else is made. */
  allow(allowed) {
    this.allowed = allowed;
    find("#simulate").disabled = !allowed || this.howFar.busy;
  }

  /** Say nothing: there is another sheet. */
  forget() {
    this.#say([]);
  }

  async #simulate() {
    const asked = this.sheet();
    this.forget();
    this.#setBusy(true);
    const answer = await ask("simulate", { ...asked.source, contact: find("#contact").checked });
    this.#setBusy(false);
    if (asked !== this.sheet()) this.#say(["The sheet has changed since: simulate it again."]);
    else if (answer.stopped) this.#say(["Cancelled."]);
    else if (!answer.states) this.#say([answer.refused ?? answer.lost], true);
    else {
      this.#say(answer.sentences, answer.wrong);
      this.use(answer);
    }
  }

  #setBusy(busy) {
    this.howFar.set(busy);
    this.allow(this.allowed);
    this.busy(busy);
  }

  #say(texts, wrong = false) {
    const lines = texts.map((text, k) => {
      const line = document.createElement("p");
      if (k === 0) line.className = wrong ? "verdict error" : "verdict";
      line.textContent = text[0].toUpperCase() + text.slice(1);
      return line;
    });
    find("#simulated").replaceChildren(...lines);
  }
}

/** The share of the fold at a place among its states, 0 for the first one. */
export function shareAt(shares, place) {
  const first = Math.min(Math.floor(place), shares.length - 1);
  const second = Math.min(first + 1, shares.length - 1);
  return shares[first] + (place - first) * (shares[second] - shares[first]);
}
