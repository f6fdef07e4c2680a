// @ts-check
import { QUANTITIES } from "./quantities.js";

/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */

const NAMES = Object.keys(QUANTITIES);
/** Shortest interval between samples [s]; it grows with a long run. */
const SHORTEST_S = 0.05;
/** When there are so many samples, every second one is dropped: an hour fits as well as a minute. */
const MOST = 24_000;
/** So many samples are kept over a reload. */
const MOST_KEPT = 3000;
const KEY = "brickpose.plots";

/** The whole run of the numbers that can be plotted; NaN where a number is not known. */
export class History {
  /** Stamps on the robot's clock [s], oldest first. @type {number[]} */
  stamps = [];
  /** @type {Record<string, number[]>} */
  values = Object.fromEntries(NAMES.map((name) => [name, /** @type {number[]} */ ([])]));
  #shortest = SHORTEST_S;
  #field = "";

  constructor() {
    this.#restore();
    addEventListener("pagehide", () => this.#keep());
  }

  /**
   * @param {TelemetryMessage} telemetry
   * @param {number | null} delay [ms]
   * @returns {boolean} whether it was added; false too soon after the last one
   */
  add(telemetry, delay) {
    // While a replay seeks, it has nothing to plot yet.
    if (typeof telemetry.replay?.catching_up === "number") return false;
    this.#begin(telemetry);
    const newest = this.stamps.at(-1) ?? -Infinity;
    if (telemetry.stamp < newest + this.#shortest) return false;
    this.stamps.push(telemetry.stamp);
    for (const name of NAMES) {
      const value = QUANTITIES[name].of(telemetry, delay);
      this.values[name].push(typeof value === "number" && Number.isFinite(value) ? value : NaN);
    }
    if (this.stamps.length > MOST) this.#thin();
    return true;
  }

  /** Index of the sample nearest to a stamp; -1 without samples. @param {number} stamp */
  nearest(stamp) {
    const after = this.after(stamp);
    if (after === 0 || after === this.stamps.length) return Math.min(after, this.stamps.length - 1);
    return this.stamps[after] - stamp < stamp - this.stamps[after - 1] ? after : after - 1;
  }

  /** Index of the first sample at a stamp or later; the number of samples without one. @param {number} stamp */
  after(stamp) {
    let [low, high] = [0, this.stamps.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.stamps[middle] < stamp) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** Another field, or an earlier time, begins another run. @param {TelemetryMessage} telemetry */
  #begin({ stamp, map, replay }) {
    const field = `${map} ${replay?.file ?? ""}`;
    if (field !== this.#field) this.#cut(0);
    this.#field = field;
    const place = this.after(stamp);
    // A step back of a live robot is another start; in a replay, what comes later is seen again.
    if (place < this.stamps.length) this.#cut(replay ? place : 0);
  }

  /** @param {number} length */
  #cut(length) {
    this.stamps.length = length;
    for (const name of NAMES) this.values[name].length = length;
    if (length === 0) this.#shortest = SHORTEST_S;
  }

  #thin() {
    const half = (/** @type {number[]} */ list) => list.filter((_, i) => i % 2 === 0);
    this.stamps = half(this.stamps);
    for (const name of NAMES) this.values[name] = half(this.values[name]);
    this.#shortest *= 2;
  }

  /** Keep the run for this tab's next page, more coarsely. */
  #keep() {
    const every = Math.ceil(this.stamps.length / MOST_KEPT);
    const some = (/** @type {number[]} */ list) =>
      list.filter((_, i) => i % every === 0).map((value) => Number(value.toPrecision(6)));
    const values = Object.fromEntries(NAMES.map((name) => [name, some(this.values[name])]));
    try {
      const run = { field: this.#field, stamps: some(this.stamps), values };
      sessionStorage.setItem(KEY, JSON.stringify(run));
    } catch {
      // Storage is full or switched off: the run is not kept.
    }
  }

  #restore() {
    try {
      const run = JSON.parse(sessionStorage.getItem(KEY) ?? "null");
      if (!run) return;
      this.#field = run.field;
      this.stamps = run.stamps;
      const unknown = this.stamps.map(() => NaN);
      for (const name of NAMES) {
        const kept = run.values[name] ?? unknown;
        this.values[name] = kept.map((/** @type {number | null} */ value) => value ?? NaN);
      }
    } catch {
      this.#cut(0);
    }
  }
}
