// @ts-check
/** @typedef {import("../messages").ViewCameraMessage} ViewCameraMessage */
/** @typedef {[number, number]} Point of the floor [m], or of the picture [CSS px] from its top left */
/** @typedef {[number, number, number]} Vector in the map */

/** Nearer to the camera than this [m], nothing is drawn. */
const NEAREST = 0.01;
/** Floor that is farther away [m] counts as horizon. */
const FARTHEST = 1000;

/** How a camera of the 3D view sees the floor: from points of its picture to points of the floor, and back. */
export class FloorView {
  /** @type {[Vector, Vector, Vector]} to the right, down and ahead */
  #axes;

  /**
   * @param {ViewCameraMessage} camera
   * @param {number} width of the picture [CSS px] @param {number} height [CSS px]
   */
  constructor({ position, wxyz, fov }, width, height) {
    this.eye = position;
    this.#axes = axes(wxyz);
    this.middle = [width / 2, height / 2];
    /** Distance of the picture from the eye [CSS px]. */
    this.focal = height / 2 / Math.tan(fov / 2);
  }

  /** @param {Point} point of the picture @returns {Point | null} of the floor; null where there is none */
  toFloor(point) {
    const [x, y, z] = this.#ray(point);
    const far = -this.eye[2] / z;
    return far > 0 && far < FARTHEST ? [this.eye[0] + far * x, this.eye[1] + far * y] : null;
  }

  /** @param {Point} point of the floor @returns {Point | null} of the picture; null behind the camera */
  toPicture([x, y]) {
    const from = /** @type {Vector} */ ([x - this.eye[0], y - this.eye[1], -this.eye[2]]);
    const [right, down, ahead] = this.#axes.map((axis) => dot(axis, from));
    if (ahead < NEAREST) return null;
    const size = this.focal / ahead;
    return [this.middle[0] + size * right, this.middle[1] + size * down];
  }

  /**
   * The direction on the floor from one of its points to where a point of the picture shows, also
   * above the horizon: a line on the floor leads on straight in the picture.
   * @param {Point} from of the floor @param {Point} point of the picture
   * @returns {number} [rad]
   */
  heading([x, y], point) {
    const ray = this.#ray(point);
    const [dx, dy, height] = [x - this.eye[0], y - this.eye[1], this.eye[2]];
    // The way to the floor's point below the ray, times how steeply that goes down.
    const side = Math.sign(height);
    return Math.atan2(side * (height * ray[1] + ray[2] * dy), side * (height * ray[0] + ray[2] * dx));
  }

  /** How large a metre is there, across the line of sight. @param {Point} place of the floor @returns {number} [CSS px] */
  scale([x, y]) {
    const from = /** @type {Vector} */ ([x - this.eye[0], y - this.eye[1], -this.eye[2]]);
    return this.focal / Math.max(NEAREST, dot(this.#axes[2], from));
  }

  /** The direction in which a point of the picture is seen. @param {Point} point @returns {Vector} */
  #ray([u, v]) {
    const [right, down, ahead] = this.#axes;
    const [across, below] = [(u - this.middle[0]) / this.focal, (v - this.middle[1]) / this.focal];
    return /** @type {Vector} */ (ahead.map((each, i) => each + across * right[i] + below * down[i]));
  }
}

/** The columns of a rotation. @param {[number, number, number, number]} wxyz @returns {[Vector, Vector, Vector]} */
function axes([w, x, y, z]) {
  return [
    [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
    [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
    [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
  ];
}

/** @param {Vector} a @param {Vector} b */
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
