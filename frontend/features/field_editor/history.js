// @ts-check
/** @typedef {import("./drawing.js").Drawing} Drawing */

const MOST = 200;

/** States of a drawing, to go back and forth between. */
export class History {
  /** @type {string[]} */
  #states;
  #at = 0;

  /** @param {Drawing} drawing */
  constructor(drawing) {
    this.#states = [JSON.stringify(drawing)];
  }

  /** Note a change; false if it is none. @param {Drawing} drawing */
  add(drawing) {
    const state = JSON.stringify(drawing);
    if (state === this.#states[this.#at]) return false;
    this.#states.splice(this.#at + 1);
    this.#states.push(state);
    if (this.#states.length > MOST) this.#states.shift();
    this.#at = this.#states.length - 1;
    return true;
  }

  get canUndo() {
    return this.#at > 0;
  }

  get canRedo() {
    return this.#at < this.#states.length - 1;
  }

  /** @param {-1 | 1} step @returns {Drawing} */
  go(step) {
    this.#at = Math.max(0, Math.min(this.#states.length - 1, this.#at + step));
    return JSON.parse(this.#states[this.#at]);
  }
}
