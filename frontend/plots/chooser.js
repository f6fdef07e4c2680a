// @ts-check
import { dismissable, raise } from "../page/boxes.js";
import { find, findButton, make } from "../page/elements.js";
import { QUANTITIES } from "./quantities.js";

/** The list from which values are chosen, in groups of one unit. */
export class ValueChooser {
  #button = findButton("plots-values");
  #box = find("plots-chooser", HTMLElement);
  /** @type {Map<string, HTMLInputElement>} */
  #checks = new Map();

  /** @param {(names: string[]) => void} changed gets the names of the values that are chosen */
  constructor(changed) {
    const units = [...new Set(Object.values(QUANTITIES).map(({ unit }) => unit))];
    this.#box.append(...units.map((unit) => this.#group(unit)));
    this.#box.onchange = () => changed(this.chosen);
    this.#button.onclick = () => this.#show(Boolean(this.#box.hidden));
    dismissable({ element: this.#box, openers: [this.#button], close: (focus) => this.#close(focus) });
  }

  get chosen() {
    return [...this.#checks].filter(([, check]) => check.checked).map(([name]) => name);
  }

  /** @param {string[]} names */
  choose(names) {
    for (const [name, check] of this.#checks) check.checked = names.includes(name);
  }

  /** @param {string} unit */
  #group(unit) {
    const rows = Object.entries(QUANTITIES)
      .filter(([, quantity]) => quantity.unit === unit)
      .map(([name, quantity]) => {
        const check = /** @type {HTMLInputElement} */ (make("input", { type: "checkbox" }));
        this.#checks.set(name, check);
        return make("label", {}, check, ` ${quantity.name}`);
      });
    return make("fieldset", {}, make("legend", {}, unit), ...rows);
  }

  /** @param {boolean} open */
  #show(open) {
    this.#box.hidden = !open;
    this.#button.setAttribute("aria-expanded", String(open));
    if (open) raise(this.#box);
  }

  /** @param {boolean} focus */
  #close(focus) {
    this.#show(false);
    if (focus) this.#button.focus();
  }
}
