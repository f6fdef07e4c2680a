// @ts-check
import { t } from "../page/language.js";

/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */

/** Places that look alike for so long [s of the robot's clock] will not be told apart by waiting. */
const LONG_S = 8;

/** Says what could be done next where the map alone leaves one waiting. */
export class NextStep {
  #moved = false;
  /** Since when places look alike; null while they do not. @type {number | null} */
  #alike = null;

  /** Note that the robot was put elsewhere, which the filter is not told. */
  robotMoved() {
    this.#moved = true;
  }

  /** @param {TelemetryMessage} telemetry @returns {string} "" if nothing is to be said */
  words({ stamp, twist, integrity, particles, replay }) {
    if (twist.v !== 0 || twist.omega !== 0) this.#moved = false;
    const alike = integrity.state === "ambiguous" && particles.alike > 1;
    if (!alike || replay || (this.#alike !== null && this.#alike > stamp)) this.#alike = null;
    else this.#alike ??= stamp;
    if (this.#moved) return t("The filter does not know: drive, and see whether it notices.");
    if (this.#alike === null || stamp - this.#alike < LONG_S) return "";
    return t("The camera sees the same at each: drive to where it differs, or “set pose”.");
  }
}
