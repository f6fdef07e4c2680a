// @ts-check

/** Smallest and largest scale [CSS px/m]. */
const FARTHEST = 5;
const NEAREST = 20000;
const MARGIN = 0.96;

/** The part of the map that the canvas shows: a point in the centre and a scale; y points up. */
export class MapView {
  /** CSS pixels per metre. */
  scale = 300;
  /** The map point in the middle of the canvas [m]. */
  x = 0;
  y = 0;
  /** Size of the canvas [CSS px]. */
  width = 0;
  height = 0;

  /** @param {number} x [m] @param {number} y [m] @returns {[number, number]} [CSS px] */
  toScreen(x, y) {
    return [
      this.width / 2 + (x - this.x) * this.scale,
      this.height / 2 - (y - this.y) * this.scale,
    ];
  }

  /** @param {number} u [CSS px] @param {number} v [CSS px] @returns {[number, number]} [m] */
  toMap(u, v) {
    return [
      this.x + (u - this.width / 2) / this.scale,
      this.y - (v - this.height / 2) / this.scale,
    ];
  }

  /** Show a whole rectangle. @param {number[]} extent xmin, ymin, xmax, ymax [m] */
  fit([xmin, ymin, xmax, ymax]) {
    this.x = (xmin + xmax) / 2;
    this.y = (ymin + ymax) / 2;
    const fitting = Math.min(this.width / (xmax - xmin), this.height / (ymax - ymin));
    this.scale = clamp(fitting * MARGIN);
  }

  /** @param {number} du to the right [CSS px] @param {number} dv down [CSS px] */
  pan(du, dv) {
    this.x -= du / this.scale;
    this.y += dv / this.scale;
  }

  /**
   * Zoom so that the point under (u, v) stays.
   * @param {number} factor
   * @param {number} u
   * @param {number} v
   */
  zoom(factor, u = this.width / 2, v = this.height / 2) {
    const [x, y] = this.toMap(u, v);
    this.scale = clamp(this.scale * factor);
    const [afterX, afterY] = this.toMap(u, v);
    this.x += x - afterX;
    this.y += y - afterY;
  }

  /**
   * Draw in metres from here on; restore the context afterwards.
   * @param {CanvasRenderingContext2D} context
   */
  apply(context) {
    context.translate(this.width / 2, this.height / 2);
    context.scale(this.scale, -this.scale);
    context.translate(-this.x, -this.y);
  }
}

/** @param {number} scale */
const clamp = (scale) => Math.min(NEAREST, Math.max(FARTHEST, scale || FARTHEST));
