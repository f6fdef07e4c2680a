// @ts-check
import { millimetres } from "../page/format.js";

/** @typedef {[number, number]} Point [m] */

/** A drag shorter than this [CSS px] is a press: the second press is the other end. */
const SHORTEST = 8;

/** Way of the end by one arrow key [CSS px]. */
const STEP = 10;
/** @type {Record<string, Point>} to the right, and up */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/** Measures between two points of the map: by a drag, by two presses, or by keys. */
export class MeasureTool {
  armed = false;
  /** @type {Point | null} */
  from = null;
  /** @type {Point | null} */
  end = null;
  /** Whether the first end lies where it shall; until then, keys move both. */
  #fixed = false;

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
    this.#fixed = false;
  }

  wants() {
    return this.armed;
  }

  /** @param {number} x @param {number} y */
  press(x, y) {
    this.from ??= [x, y];
    this.#fixed = true;
    this.end = [x, y];
  }

  /** @param {number} x @param {number} y */
  drag(x, y) {
    if (this.from) this.end = [x, y];
  }

  /**
   * Arrows move an end, Enter lays it down.
   * @param {KeyboardEvent} event @param {Point} middle of what is seen, where keys begin
   * @returns {boolean} whether the key was for this
   */
  key(event, middle) {
    const way = ARROWS[event.key];
    if (!this.armed || event.shiftKey || (!way && event.key !== "Enter")) return false;
    const [x, y] = this.end ?? middle;
    const step = STEP / this.scale();
    this.end = way ? [x + way[0] * step, y + way[1] * step] : [x, y];
    if (!this.#fixed) this.from = this.end;
    if (event.key === "Enter" && this.#fixed) this.finished();
    else if (event.key === "Enter") this.#fixed = true;
    event.preventDefault();
    return true;
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
