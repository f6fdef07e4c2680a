// @ts-check
import { t } from "./language.js";

/** @typedef {import("../messages").Command} Command */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {{order: (command: Command) => Promise<boolean>}} Program what a panel may use */
/** @typedef {{show: (telemetry: TelemetryMessage) => void}} AddedPanel */
/** @typedef {import("./toasts.js").Toasts} Toasts */

/**
 * @param {Element} section @param {Element | null} body in place of what is in it
 * @param {unknown} error for its author also in the browser's console, with file and line
 * @returns {string} in words
 */
function tellFailure(section, body, error) {
  const script = section.getAttribute("data-script") ?? "";
  console.error(script, error);
  const why = error instanceof Error ? `${error.name}: ${error.message}` : String(error);
  const title = section.querySelector("h2")?.textContent ?? "";
  const words = t("The panel {title} has failed ({script}): {why}", { title, script, why });
  if (body) body.textContent = words;
  return words;
}

const BELOW_EACH_OTHER = {
  display: "flex",
  flexDirection: "column",
  gap: "0.5rem",
  alignItems: "flex-start",
};

/** Panels of features: each is filled by a script of its own, and harms no other if that fails. */
export class AddedPanels {
  /** @type {Map<Element, AddedPanel>} */
  #panels = new Map();

  #toasts;

  /** @param {Program} program @param {Toasts} toasts for failures: the panel may be closed */
  constructor(program, toasts) {
    this.#toasts = toasts;
    for (const section of document.querySelectorAll("main > [data-script]")) {
      const body = section.querySelector(".added");
      if (!(body instanceof HTMLElement)) continue;
      Object.assign(body.style, BELOW_EACH_OTHER);
      this.#open(section, body, program).catch((error) =>
        toasts.show(tellFailure(section, body, error)),
      );
    }
  }

  /** @param {Element} section @param {HTMLElement} body @param {Program} program */
  async #open(section, body, program) {
    /** @type {{panel: (body: HTMLElement, program: Program) => AddedPanel}} */
    const script = await import(
      new URL(section.getAttribute("data-script") ?? "", document.baseURI).href
    );
    const panel = script.panel(body, program);
    if (typeof panel?.show !== "function") throw new Error("panel() returns no show()");
    this.#panels.set(section, panel);
  }

  /** @param {TelemetryMessage} telemetry */
  show(telemetry) {
    for (const [section, panel] of this.#panels) {
      try {
        panel.show(telemetry);
      } catch (error) {
        this.#panels.delete(section);
        this.#toasts.show(tellFailure(section, section.querySelector(".added"), error));
      }
    }
  }
}
