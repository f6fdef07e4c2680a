// @ts-check
import { palette } from "../page/palette.js";

/** @typedef {import("./view.js").MapView} MapView */

/** Largest scaled copy [px]: a larger one would not be smaller than the source, which is drawn. */
const LARGEST = 2500;

/**
 * The picture of the field. A copy in the shown size is kept, as scaling is most of the work of
 * drawing.
 */
export class Floor {
  /** @type {HTMLCanvasElement} */
  #scaled = document.createElement("canvas");

  /** @param {number[]} extent xmin, ymin, xmax, ymax [m] @param {ImageBitmap} picture */
  constructor(extent, picture) {
    this.extent = extent;
    this.picture = picture;
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {MapView} view
   * @param {number} ratio device pixels in a CSS pixel
   */
  draw(context, view, ratio) {
    const [xmin, ymin, xmax, ymax] = this.extent;
    const [left, top] = view.toScreen(xmin, ymax);
    const [right, bottom] = view.toScreen(xmax, ymin);
    const source = this.#inSize(
      Math.round((right - left) * ratio),
      Math.round((bottom - top) * ratio),
    );
    context.drawImage(source, left, top, right - left, bottom - top);
    context.strokeStyle = palette.line;
    context.lineWidth = 1;
    context.strokeRect(left, top, right - left, bottom - top);
  }

  /** @param {number} width [px] @param {number} height [px] @returns {CanvasImageSource} */
  #inSize(width, height) {
    if (Math.max(width, height) > LARGEST) return this.picture;
    if (this.#scaled.width !== width || this.#scaled.height !== height) {
      this.#scaled.width = width;
      this.#scaled.height = height;
      const context = this.#scaled.getContext("2d");
      if (!context || width === 0 || height === 0) return this.picture;
      context.imageSmoothingQuality = "high";
      context.drawImage(this.picture, 0, 0, width, height);
    }
    return this.#scaled;
  }
}
