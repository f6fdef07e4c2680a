// @ts-check
import { millimetres } from "../page/format.js";

/** @typedef {[number, number]} Point [m] */

/** A drag shorter than this [CSS px] is a press: the second press is the other end. */
const SHORTEST = 8;

/** Measures between two points of the map: by a drag, or by two presses. */
export class MeasureTool {
  armed = false;
  /** @type {Point | null} */
  from = null;
  /** @type {Point | null} */
  end = null;

  /** @param {() => number} scale [CSS px/m] @param {() => void} finished */
  constructor(scale, finished) {
    this.scale = scale;
    this.finished = finished;
  }

  /** Begin anew. @param {boolean} armed whether presses are for this tool */
  arm(armed) {
    this.armed = armed;
    if (armed) this.clear();
  }

  clear() {
    this.from = this.end = null;
  }

  wants() {
    return this.armed;
  }

  /** @param {number} x @param {number} y */
  press(x, y) {
    this.from ??= [x, y];
    this.end = [x, y];
  }

  /** @param {number} x @param {number} y */
  drag(x, y) {
    if (this.from) this.end = [x, y];
  }

  release() {
    if (!this.from || !this.end) return;
    const way = Math.hypot(this.end[0] - this.from[0], this.end[1] - this.from[1]);
    if (way * this.scale() >= SHORTEST) this.finished();
  }

  cancel() {
    this.clear();
  }

  /** The length in words; "" while nothing is measured. */
  get words() {
    if (!this.line) return "";
    const [[x, y], [u, v]] = this.line;
    return millimetres(Math.hypot(u - x, v - y));
  }

  /** The two ends, as soon as both are there. @returns {[Point, Point] | null} */
  get line() {
    return this.from && this.end ? [this.from, this.end] : null;
  }
}
