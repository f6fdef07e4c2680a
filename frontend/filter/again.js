// @ts-check
import { findButton } from "../page/elements.js";
import { t } from "../page/language.js";

/** @typedef {import("../messages").Command} Command */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../page/toasts.js").Toasts} Toasts */

/**
 * Runs the recorded drive again with the parameters as they are now: map and plot then show the
 * estimate before beside the one now.
 */
export class RunAgain {
  /** @type {TelemetryMessage | null} */
  #now = null;

  /** @param {(command: Command) => Promise<boolean>} order @param {Toasts} toasts */
  constructor(order, toasts) {
    this.order = order;
    this.toasts = toasts;
    findButton("again").onclick = () => this.#press();
  }

  /** @param {TelemetryMessage} telemetry */
  follow(telemetry) {
    this.#now = telemetry;
  }

  async #press() {
    if (this.#now?.replay) return this.order({ type: "replay", position_s: 0, paused: false });
    if (this.#now?.recording) return this.#run();
    if (await this.order({ type: "record", on: true })) {
      this.toasts.show(t("From now on the drive is recorded. Drive, change a parameter, and run it again."), "note");
    }
  }

  async #run() {
    if (await this.order({ type: "run_again" })) {
      this.toasts.show(t("The same drive, with the parameters as they are now. Violet is the estimate before."), "note");
    }
  }
}
