// @ts-check

/** A smaller zone is a slip of the hand [CSS px]. */
const SHORTEST = 8;

/** Drags a rectangle on the map: a zone that the robot does not enter. */
export class ZoneTool {
  armed = false;
  /** The zone that is being drawn [m]. @type {[number, number][] | null} */
  corners = null;
  /** @type {[number, number]} */
  #from = [0, 0];

  /**
   * @param {() => number} scale [CSS px/m]
   * @param {(corners: [number, number][]) => void} finished
   */
  constructor(scale, finished) {
    this.scale = scale;
    this.finished = finished;
  }

  wants() {
    return this.armed;
  }

  /** @param {number} x @param {number} y */
  press(x, y) {
    this.#from = [x, y];
    this.corners = null;
  }

  /** @param {number} x @param {number} y */
  drag(x, y) {
    const [left, bottom] = this.#from;
    const small = Math.min(Math.abs(x - left), Math.abs(y - bottom)) * this.scale() < SHORTEST;
    this.corners = small ? null : [[left, bottom], [x, bottom], [x, y], [left, y]];
  }

  release() {
    const corners = this.corners;
    this.corners = null;
    if (corners) this.finished(corners);
  }

  cancel() {
    this.corners = null;
  }
}
