// @ts-check
import { find, findButton } from "./elements.js";

/** A box that a button opens and closes; Escape closes it, too, and gives the focus back. */
export class Popover {
  /** @param {string} name the box's id; its buttons are `name`-open and `name`-close */
  constructor(name) {
    this.box = find(name, HTMLElement);
    this.opener = findButton(`${name}-open`);
    this.opener.onclick = () => this.show(this.box.hidden !== false);
    findButton(`${name}-close`).onclick = () => this.#leave();
    for (const part of [this.box, this.opener]) {
      part.addEventListener("keydown", (event) => this.#key(event));
    }
  }

  get shown() {
    return !this.box.hidden;
  }

  /** @param {boolean} shown */
  show(shown) {
    this.box.hidden = !shown;
    this.opener.setAttribute("aria-expanded", String(shown));
    if (shown) this.box.dispatchEvent(new Event("shown"));
  }

  #leave() {
    this.show(false);
    this.opener.focus();
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.key !== "Escape" || !this.shown) return;
    event.preventDefault();
    this.#leave();
  }
}
