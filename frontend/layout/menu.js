// @ts-check
import { find, findButton, findInput, make } from "../page/elements.js";
import { t } from "../page/language.js";
import { takeFiles } from "../page/dropped.js";
import { Popover } from "../page/popover.js";
import { written } from "./layouts.js";

/** @typedef {import("./layout.js").Layout} Layout */
/** @typedef {import("./layouts.js").ReadyName} ReadyName */
/** @typedef {import("../page/toasts.js").Toasts} Toasts */

/** The menu of layouts: ready ones, which panels are shown, and how a layout is shared. */
export class LayoutMenu {
  #ready = [...document.querySelectorAll("button[data-layout]")].map(
    (button) => /** @type {HTMLButtonElement} */ (button),
  );
  /** In the page's head: panels that belong together. */
  #quick = [...document.querySelectorAll("button[data-panels]")].map((button) => /** @type {HTMLButtonElement} */ (button));
  #list = find("layout-panels", HTMLElement);
  #file = findInput("layout-file");

  /** @param {Layout} layout @param {Toasts} toasts */
  constructor(layout, toasts) {
    this.layout = layout;
    this.popover = new Popover("layout");
    for (const button of this.#ready) {
      button.onclick = () => layout.choose(/** @type {ReadyName} */ (button.dataset.layout));
    }
    for (const button of this.#quick) {
      button.onclick = () => layout.showAll(panelsOfButton(button), button.getAttribute("aria-pressed") !== "true");
    }
    findButton("layout-link").onclick = () => this.#copy(toasts);
    findButton("layout-save").onclick = () => save(written(layout.tree));
    findButton("layout-open-file").onclick = () => this.#file.click();
    this.#file.onchange = () => this.#open();
    takeFiles([".json"], () => t("layouts (.json)"), async ([file]) => layout.open(await file.text()));
    layout.onChange(() => this.#show());
    this.#show();
  }

  #show() {
    const { ready, panels } = this.layout;
    for (const button of this.#ready) {
      button.setAttribute("aria-pressed", String(button.dataset.layout === ready));
    }
    for (const button of this.#quick) {
      button.setAttribute("aria-pressed", String(panelsOfButton(button).every((name) => this.layout.shows(name))));
    }
    const focused = document.activeElement?.getAttribute("data-panel");
    this.#list.replaceChildren(...panels.map(([name, title]) => this.#switch(name, title)));
    if (focused) this.#list.querySelector(`[data-panel="${focused}"]`)?.closest("button")?.focus();
  }

  /** @param {string} name @param {string} title */
  #switch(name, title) {
    const shown = this.layout.shows(name);
    const button = make(
      "button",
      { type: "button", "data-panel": name, "aria-pressed": String(shown) },
      title,
    );
    button.onclick = () => this.layout.show(name, !shown);
    return button;
  }

  /** @param {Toasts} toasts */
  async #copy(toasts) {
    const { link } = this.layout;
    try {
      await navigator.clipboard.writeText(link);
      toasts.show(t("The link to this layout is copied."), "note");
    } catch {
      // Browsers copy only on pages that came by HTTPS or from this computer.
      prompt(t("The link to this layout:"), link);
    }
  }

  async #open() {
    const file = this.#file.files?.[0];
    this.#file.value = "";
    if (file) this.layout.open(await file.text());
  }
}

/** @param {string} text */
function save(text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "application/json" }));
  link.download = "layout.json";
  link.click();
  URL.revokeObjectURL(link.href);
}

/** @param {HTMLButtonElement} button */
const panelsOfButton = (button) => (button.dataset.panels ?? "").split(" ");
