// @ts-check
import { t } from "./language.js";
/** @typedef {"light" | "dark"} Theme */

const SYSTEM = matchMedia("(prefers-color-scheme: dark)");

/**
 * Theme and text size. The system's theme is used until the user switches it; this browser keeps
 * the choice.
 */
export class Appearance {
  /** @type {Set<() => void>} */
  #listeners = new Set();

  /** @param {HTMLButtonElement} themeButton @param {HTMLButtonElement} textButton */
  constructor(themeButton, textButton) {
    this.themeButton = themeButton;
    this.textButton = textButton;
    themeButton.onclick = () => this.#keep("theme", this.theme === "dark" ? "light" : "dark");
    textButton.onclick = () => this.#keep("text", this.large ? "normal" : "large");
    SYSTEM.addEventListener("change", () => this.#apply());
    this.#apply();
  }

  /** @returns {Theme} */
  get theme() {
    const chosen = document.documentElement.dataset.theme;
    if (chosen === "dark" || chosen === "light") return chosen;
    return SYSTEM.matches ? "dark" : "light";
  }

  get large() {
    return document.documentElement.dataset.text === "large";
  }

  /** @param {() => void} listener called after every change of colours or text size */
  onChange(listener) {
    this.#listeners.add(listener);
  }

  /** @param {"theme" | "text"} what @param {string} value */
  #keep(what, value) {
    document.documentElement.dataset[what] = value;
    try {
      localStorage.setItem(`brickpose.${what}`, value);
    } catch {
      // Storage is switched off: the choice lasts until the page is closed.
    }
    this.#apply();
  }

  #apply() {
    const dark = this.theme === "dark";
    this.themeButton.textContent = dark ? t("Light") : t("Dark");
    const words = dark ? t("Switch to the light theme") : t("Switch to the dark theme");
    this.themeButton.setAttribute("aria-label", words);
    this.textButton.setAttribute("aria-pressed", String(this.large));
    for (const listener of this.#listeners) listener();
  }
}
