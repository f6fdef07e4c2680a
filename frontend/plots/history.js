// @ts-check
import { distance } from "../page/format.js";

/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */

/** The numbers kept for each moment; NaN where a number is not known. */
export const QUANTITIES = /** @type {const} */ ([
  "odometryError", // [mm]
  "estimateError", // [mm]
  "thenError", // [mm] of the recorded estimate
  "effective", // particles
  "count", // particles
  "loop", // steps a second
  "delay", // exposure to pixel [ms]
]);
/** @typedef {typeof QUANTITIES[number]} Quantity */

export const SPAN_S = 30;
const SHORTEST_S = 0.05;

/** The last half minute of the numbers that are plotted. */
export class History {
  /** Stamps on the robot's clock [s], oldest first. @type {number[]} */
  stamps = [];
  /** @type {Record<Quantity, number[]>} */
  values = {
    odometryError: [],
    estimateError: [],
    thenError: [],
    effective: [],
    count: [],
    loop: [],
    delay: [],
  };

  /**
   * @param {TelemetryMessage} telemetry
   * @param {number | null} delay [ms]
   * @returns {boolean} whether it was added; false too soon after the last one
   */
  add(telemetry, delay) {
    const newest = this.stamps.at(-1) ?? -Infinity;
    // While a replay seeks, it has nothing to plot yet.
    if (typeof telemetry.replay?.catching_up === "number") return false;
    if (telemetry.stamp < newest) this.#drop(this.stamps.length);
    else if (telemetry.stamp < newest + SHORTEST_S) return false;
    this.stamps.push(telemetry.stamp);
    const { truth, odometry, particles, loop } = telemetry;
    // While places look alike, the likeliest one keeps changing: no single error is right.
    const estimate = particles.alike < 2 ? telemetry.estimate : null;
    this.values.odometryError.push(truth && odometry ? distance(truth, odometry) * 1000 : NaN);
    this.values.estimateError.push(truth && estimate ? distance(truth, estimate) * 1000 : NaN);
    const then = telemetry.replay?.estimate_then;
    this.values.thenError.push(truth && then ? distance(truth, then) * 1000 : NaN);
    this.values.effective.push(particles.effective);
    this.values.count.push(particles.count);
    this.values.loop.push(loop.step_hz);
    this.values.delay.push(delay ?? NaN);
    const old = this.stamps.findIndex((stamp) => stamp >= telemetry.stamp - SPAN_S);
    this.#drop(old);
    return true;
  }

  /** Times relative to the newest moment [s], zero or negative. @returns {number[]} */
  ages() {
    const newest = this.stamps.at(-1) ?? 0;
    return this.stamps.map((stamp) => stamp - newest);
  }

  /** Index of the moment nearest to an age. @param {number} age [s], negative @returns {number} */
  nearest(age) {
    const ages = this.ages();
    const after = ages.findIndex((one) => one >= age);
    if (after <= 0) return after === 0 ? 0 : ages.length - 1;
    return ages[after] - age < age - ages[after - 1] ? after : after - 1;
  }

  /** @param {number} count of the oldest */
  #drop(count) {
    if (count <= 0) return;
    this.stamps.splice(0, count);
    for (const quantity of QUANTITIES) this.values[quantity].splice(0, count);
  }
}
