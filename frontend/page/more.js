// @ts-check
import { t } from "./language.js";

const KEY = "brickpose.more";

/** Parts of the page show at first only what a first visit needs; each has a button for the rest, and this browser keeps the choice. */
export class More {
  #root = document.documentElement;

  constructor() {
    for (const button of document.querySelectorAll("button[data-more-of]")) {
      if (button instanceof HTMLButtonElement) this.#wire(button, button.dataset.moreOf ?? "");
    }
  }

  /** @param {HTMLButtonElement} button @param {string} part */
  #wire(button, part) {
    const show = () => {
      const shown = this.#shown.has(part);
      button.textContent = shown ? t("less") : t("more");
      button.setAttribute("aria-expanded", String(shown));
    };
    button.onclick = () => {
      const parts = this.#shown;
      if (!parts.delete(part)) parts.add(part);
      this.#keep([...parts].join(" "));
      show();
    };
    show();
  }

  /** Names of the parts that show all. */
  get #shown() {
    return new Set((this.#root.dataset.more ?? "").split(" ").filter(Boolean));
  }

  /** @param {string} parts */
  #keep(parts) {
    this.#root.dataset.more = parts;
    try {
      localStorage.setItem(KEY, parts);
    } catch {
      // Storage is switched off: the choice lasts until the page is closed.
    }
  }
}
