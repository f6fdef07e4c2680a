// @ts-check
import { find } from "../../../page/elements.js";
import { palette } from "../../../page/palette.js";
import { Surface } from "../../../page/surface.js";

/** @typedef {import("../../../camera/stream.js").Picture} Picture */
/** @typedef {import("../../../messages").LensStatusMessage} LensStatusMessage */
/** @typedef {[number, number]} Point */

/** Radius of a corner's mark [CSS px]. */
const RING = 4;
/** How long the picture lights up that was taken [ms]. */
const FLASH_MS = 350;

/** The live picture, with the corners that were found, and where boards were so far. */
export class LivePicture {
  #empty = find("live-empty", HTMLElement);
  /** @type {Picture | null} */
  #picture = null;
  /** @type {LensStatusMessage | null} */
  #status = null;
  #flash = -Infinity;

  /** @param {import("../../../page/draw_loop.js").DrawLoop} loop */
  constructor(loop) {
    const canvas = find("live-canvas", HTMLCanvasElement);
    this.surface = new Surface(canvas, () => this.refresh?.());
    this.refresh = loop.add((now) => this.#paint(now), { visible: () => this.surface.visible });
  }

  /** @param {Picture} picture */
  show(picture) {
    this.#picture?.bitmap.close();
    this.#picture = picture;
    this.#empty.hidden = true;
    this.refresh();
  }

  /** @param {LensStatusMessage} status */
  follow(status) {
    const news = status.look?.stamp !== this.#status?.look?.stamp;
    if (status.look?.verdict === "taken" && news) this.#flash = performance.now();
    this.#status = status;
    this.refresh();
  }

  /** @param {number} now */
  #paint(now) {
    if (!this.#picture) return;
    const { bitmap } = this.#picture;
    const context = this.surface.begin();
    const scale = Math.min(
      this.surface.width / bitmap.width,
      this.surface.height / bitmap.height,
    );
    context.translate(
      (this.surface.width - bitmap.width * scale) / 2,
      (this.surface.height - bitmap.height * scale) / 2,
    );
    context.scale(scale, scale);
    context.drawImage(bitmap, 0, 0);
    if (!this.#status?.board) return;
    shadeParts(context, this.#status.parts, bitmap);
    drawOutlines(context, this.#status.outlines, 1 / scale);
    drawCorners(context, this.#status, 1 / scale);
    const light = 1 - (now - this.#flash) / FLASH_MS;
    if (light <= 0) return;
    context.fillStyle = `rgb(255 255 255 / ${0.6 * light})`;
    context.fillRect(0, 0, bitmap.width, bitmap.height);
    this.refresh();
  }
}

/**
 * Shade the parts of the picture without a board.
 * @param {CanvasRenderingContext2D} context
 * @param {boolean[][]} parts by rows from above
 * @param {{width: number, height: number}} size
 */
export function shadeParts(context, parts, { width, height }) {
  const [across, down] = [width / parts[0].length, height / parts.length];
  context.fillStyle = "rgb(213 94 0 / 0.2)";
  parts.forEach((row, y) =>
    row.forEach((seen, x) => {
      if (!seen) context.fillRect(x * across, y * down, across, down);
    }),
  );
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Point[][]} outlines
 * @param {number} pixel size of a CSS pixel
 */
export function drawOutlines(context, outlines, pixel) {
  context.lineWidth = pixel;
  for (const outline of outlines) {
    const path = new Path2D();
    outline.forEach(([x, y], i) => (i ? path.lineTo(x, y) : path.moveTo(x, y)));
    path.closePath();
    context.fillStyle = "rgb(0 114 178 / 0.08)";
    context.fill(path);
    context.strokeStyle = "rgb(0 114 178 / 0.8)";
    context.stroke(path);
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {LensStatusMessage} status
 * @param {number} pixel size of a CSS pixel
 */
function drawCorners(context, { look }, pixel) {
  if (!look) return;
  const rings = new Path2D();
  for (const [x, y] of look.corners) {
    rings.moveTo(x + RING * pixel, y);
    rings.arc(x, y, RING * pixel, 0, 2 * Math.PI);
  }
  context.strokeStyle = "#fff";
  context.lineWidth = 3.5 * pixel;
  context.stroke(rings);
  context.strokeStyle = look.verdict === "taken" ? palette["floor-truth"] : palette["floor-drawn"];
  context.lineWidth = 2 * pixel;
  context.stroke(rings);
}
