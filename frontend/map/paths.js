// @ts-check
import { palette } from "../page/palette.js";

/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../messages").PoseMessage} PoseMessage */
/** @typedef {"truth" | "odometry" | "estimate"} Who */

const STEP_M = 0.004;
/** Farther than this in one step is a jump, not a way. */
const JUMP_M = 0.12;
const MOST = 4000;
/**
 * Dashes and width in CSS pixels: the three differ without colour too.
 * @type {Record<Who, {dash: number[], width: number}>}
 */
const STYLES = {
  truth: { dash: [], width: 3 },
  odometry: { dash: [7, 5], width: 2 },
  estimate: { dash: [2, 3], width: 2 },
};

/** One way travelled, in the map [m]. */
class Trail {
  path = new Path2D();
  /** @type {{x: number, y: number, jump: boolean}[]} */
  #points = [];

  /** @param {PoseMessage} pose */
  add({ x, y }) {
    const last = this.#points.at(-1);
    const moved = last ? Math.hypot(x - last.x, y - last.y) : Infinity;
    if (moved < STEP_M) return;
    this.#points.push({ x, y, jump: moved > JUMP_M });
    this.#trace({ x, y, jump: moved > JUMP_M });
    if (this.#points.length > MOST) this.#shorten();
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

  #shorten() {
    const kept = this.#points.slice(-MOST * 0.75);
    this.clear();
    this.#points = kept;
    for (const point of kept) this.#trace(point);
  }
}

/** The ways of truth, odometry and estimate since the page was opened. */
export class Paths {
  #trails = { truth: new Trail(), odometry: new Trail(), estimate: new Trail() };

  /** @param {TelemetryMessage} telemetry */
  add({ truth, odometry, estimate, filter }) {
    if (truth) this.#trails.truth.add(truth);
    if (odometry) this.#trails.odometry.add(odometry);
    // While places look alike, now one and now another is the likeliest: that is no way.
    if (estimate && filter.alike < 2) this.#trails.estimate.add(estimate);
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
    for (const who of /** @type {Who[]} */ (["truth", "odometry", "estimate"])) {
      const { dash, width } = STYLES[who];
      context.strokeStyle = palette[`floor-${who}`];
      context.lineWidth = width * pixel;
      context.setLineDash(dash.map((length) => length * pixel));
      context.stroke(this.#trails[who].path);
    }
    context.setLineDash([]);
  }
}
