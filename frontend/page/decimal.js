// @ts-check
import { find } from "./elements.js";
import { plain, readNumber } from "./format.js";
import { t } from "./language.js";

/**
 * A field for a number with a decimal point or comma. A browser's own field for numbers makes 35 of
 * "3,5" in some languages, and says nothing; here the form refuses what is no number. Limits stand
 * in `data-low` and `data-high`.
 */
export class DecimalField {
  #input;

  /** @param {string} id */
  constructor(id) {
    this.#input = find(id, HTMLInputElement);
    this.#input.addEventListener("input", () => this.#check());
  }

  /** NaN if it is none. */
  get value() {
    return readNumber(this.#input.value);
  }

  /** @param {number} value written with at most three decimals */
  set value(value) {
    const decimals = String(Math.abs(+value.toFixed(3))).split(".")[1]?.length ?? 0;
    this.#input.value = plain(value, decimals);
    this.#check();
  }

  #check() {
    this.#input.setCustomValidity(this.#fault);
  }

  get #fault() {
    const { low = "-Infinity", high = "Infinity" } = this.#input.dataset;
    if (this.#input.value === "") return "";
    if (Number.isNaN(this.value)) return t("Type a number, as 3.5 or 3,5.");
    const valid = this.value >= Number(low) && this.value <= Number(high);
    return valid ? "" : t("Valid is {low} to {high}.", { low, high });
  }
}
