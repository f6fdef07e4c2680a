// @ts-check
import { dismissable, raise } from "./boxes.js";
import { find, findButton } from "./elements.js";

/** @type {Popover[]} */
const all = [];

/**
 * A box that a button opens and closes; so do Escape, which gives the focus back, and a press beside. What it
 * would lie on closes.
 */
export class Popover {
  /**
   * @param {string} name the box's id; the button in it is `name`-close
   * @param {string[]} openers ids of the buttons that open and close it: a phone may have another one
   * @param {() => void} onShown called each time it opens
   */
  constructor(name, openers = [`${name}-open`], onShown = () => {}) {
    this.box = find(name, HTMLElement);
    this.openers = openers.map(findButton);
    this.onShown = onShown;
    for (const opener of this.openers) opener.onclick = () => this.show(!this.shown);
    findButton(`${name}-close`).onclick = () => this.#leave();
    dismissable({
      element: this.box,
      openers: this.openers,
      close: (focus) => (focus ? this.#leave() : this.show(false)),
    });
    all.push(this);
  }

  get shown() {
    return !this.box.hidden;
  }

  /** @param {boolean} shown */
  show(shown) {
    this.box.hidden = !shown;
    for (const opener of this.openers) opener.setAttribute("aria-expanded", String(shown));
    if (!shown) return;
    for (const other of all) {
      if (other !== this && other.shown && overlap(this.box, other.box)) other.show(false);
    }
    raise(this.box);
    this.onShown();
  }

  #leave() {
    this.show(false);
    this.openers.find((opener) => opener.checkVisibility())?.focus();
  }
}

/** @param {Element} one @param {Element} other */
function overlap(one, other) {
  const [a, b] = [one.getBoundingClientRect(), other.getBoundingClientRect()];
  return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}
