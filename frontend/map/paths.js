// @ts-check
import { palette } from "../page/palette.js";
import { alike } from "./places.js";

/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../messages").PoseMessage} PoseMessage */
/** @typedef {"truth" | "odometry" | "estimate" | "then"} Who */

const STEP_M = 0.004;
/** A longer step is a jump, not part of a path. */
const JUMP_M = 0.12;
const MOST = 4000;
/**
 * Dashes and widths in CSS pixels: the paths differ even without colour.
 * @type {Record<Who, {dash: number[], width: number}>}
 */
const STYLES = {
  truth: { dash: [], width: 3 },
  odometry: { dash: [7, 5], width: 2 },
  then: { dash: [9, 3, 2, 3], width: 2 },
  estimate: { dash: [2, 3], width: 2 },
};

/** One path in the map [m]. */
class Trail {
  path = new Path2D();
  /** @type {{x: number, y: number, jump: boolean, stamp: number}[]} */
  #points = [];

  /** @param {PoseMessage} pose @param {number} stamp [s] */
  add({ x, y }, stamp) {
    const last = this.#points.at(-1);
    const moved = last ? Math.hypot(x - last.x, y - last.y) : Infinity;
    if (moved < STEP_M) return;
    this.#points.push({ x, y, jump: moved > JUMP_M, stamp });
    this.#trace({ x, y, jump: moved > JUMP_M });
    if (this.#points.length > MOST) this.#keep(this.#points.slice(-MOST * 0.75));
  }

  /** Drop points after a time to which a replay went back. @param {number} stamp [s] */
  rewind(stamp) {
    this.#keep(this.#points.filter((point) => point.stamp <= stamp));
  }

  clear() {
    this.#points = [];
    this.path = new Path2D();
  }

  /** @param {{x: number, y: number, jump: boolean}} point */
  #trace({ x, y, jump }) {
    if (jump) this.path.moveTo(x, y);
    else this.path.lineTo(x, y);
  }

  /** @param {{x: number, y: number, jump: boolean, stamp: number}[]} kept */
  #keep(kept) {
    this.clear();
    this.#points = kept;
    for (const point of kept) this.#trace(point);
  }
}

/** The paths of truth, odometry and estimates since the page was opened. */
export class Paths {
  #trails = {
    truth: new Trail(),
    odometry: new Trail(),
    then: new Trail(),
    estimate: new Trail(),
  };
  #stamp = -Infinity;

  /** @param {TelemetryMessage} telemetry */
  add(telemetry) {
    const { stamp, truth, odometry, estimate, replay } = telemetry;
    // While a replay seeks, it has no estimate yet.
    if (typeof replay?.catching_up === "number") return;
    if (stamp < this.#stamp) {
      for (const trail of Object.values(this.#trails)) trail.rewind(stamp);
    }
    this.#stamp = stamp;
    if (truth) this.#trails.truth.add(truth, stamp);
    if (odometry) this.#trails.odometry.add(odometry, stamp);
    if (replay?.estimate_then) this.#trails.then.add(replay.estimate_then, stamp);
    // While places look alike, the likeliest one keeps changing: that is not a path.
    if (estimate && alike(telemetry) < 2) this.#trails.estimate.add(estimate, stamp);
  }

  clear() {
    for (const trail of Object.values(this.#trails)) trail.clear();
  }

  /**
   * @param {CanvasRenderingContext2D} context drawing in metres
   * @param {number} pixel one CSS pixel [m]
   */
  draw(context, pixel) {
    context.lineJoin = "round";
    for (const who of /** @type {Who[]} */ (Object.keys(STYLES))) {
      const { dash, width } = STYLES[who];
      context.strokeStyle = palette[`floor-${who}`];
      context.lineWidth = width * pixel;
      context.setLineDash(dash.map((length) => length * pixel));
      context.stroke(this.#trails[who].path);
    }
    context.setLineDash([]);
  }
}
