// @ts-check
import { palette } from "../page/palette.js";

/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../messages").PoseMessage} PoseMessage */
/** @typedef {"truth" | "odometry" | "estimate" | "then"} Who */

const STEP_M = 0.004;
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

  /** @param {PoseMessage} pose @param {number} stamp [s] @param {number} longest step [m] */
  add({ x, y }, stamp, longest) {
    const last = this.#points.at(-1);
    const moved = last ? Math.hypot(x - last.x, y - last.y) : Infinity;
    if (moved < STEP_M) return;
    const jump = moved > longest;
    this.#points.push({ x, y, jump, stamp });
    this.#trace({ x, y, jump });
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
  /** A longer step [m] is a jump, not part of a path. */
  longestStep = Infinity;

  /** @param {TelemetryMessage} telemetry */
  add(telemetry) {
    const { stamp, truth, odometry, estimate, particles, replay } = telemetry;
    // While a replay seeks, it has no estimate yet.
    if (typeof replay?.catching_up === "number") return;
    if (stamp < this.#stamp) {
      for (const trail of Object.values(this.#trails)) trail.rewind(stamp);
    }
    this.#stamp = stamp;
    // While places look alike, the likeliest one keeps changing: that is not a path.
    const settled = particles.alike < 2 ? estimate : null;
    const poses = { truth, odometry, then: replay?.estimate_then, estimate: settled };
    for (const who of /** @type {Who[]} */ (Object.keys(poses))) {
      const pose = poses[who];
      if (pose) this.#trails[who].add(pose, stamp, this.longestStep);
    }
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
