// @ts-check
import { findButton } from "../page/elements.js";
import { palette } from "../page/palette.js";
import { getJson } from "../wire/http.js";

/** @typedef {import("../messages").FloorGridMessage} FloorGridMessage */
/** @typedef {import("./overlay.js").Placement} Placement */

/** The floor's grid over the camera's picture: by it one sees whether the mounting is right. */
export class FloorGrid {
  #button = findButton("camera-grid");
  /** @type {FloorGridMessage | null} */
  #grid = null;

  /** @param {() => void} changed called when it is to be drawn anew */
  constructor(changed) {
    this.changed = changed;
    this.#button.onclick = () => {
      this.#button.setAttribute("aria-pressed", String(!this.#shown));
      this.load();
    };
  }

  get #shown() {
    return this.#button.getAttribute("aria-pressed") === "true";
  }

  /** Ask where the grid lies; again after a calibration. */
  async load() {
    try {
      this.#grid = this.#shown ? await getJson("/api/floor-grid") : null;
    } catch (error) {
      console.warn("The floor's grid could not be read.", error);
    }
    this.changed();
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {Placement} placement
   * @param {{width: number, height: number}} picture
   */
  draw(context, { left, top, scale }, { width, height }) {
    if (!this.#grid) return;
    const [across, ahead] = [new Path2D(), new Path2D()];
    for (const line of this.#grid.lines) {
      const path = line.ahead ? ahead : across;
      line.pixels.forEach(([u, v], i) => (i ? path.lineTo(u, v) : path.moveTo(u, v)));
    }
    context.save();
    context.translate(left, top);
    context.scale(scale, scale);
    context.beginPath();
    context.rect(0, 0, width, height);
    context.clip();
    stroke(context, across, palette["floor-grid"], 1.2 / scale);
    stroke(context, ahead, palette["floor-grid"], 1.8 / scale);
    drawLabels(context, this.#grid.labels, 1 / scale);
    context.restore();
  }
}

/**
 * Write distances beside the line straight ahead, as far as there is room.
 * @param {CanvasRenderingContext2D} context
 * @param {FloorGridMessage["labels"]} labels the nearest first
 * @param {number} pixel size of a CSS pixel
 */
function drawLabels(context, labels, pixel) {
  context.font = `${palette.fontSize * pixel}px system-ui, sans-serif`;
  context.lineWidth = 3 * pixel;
  context.strokeStyle = palette["floor-halo"];
  context.fillStyle = palette["floor-grid"];
  let last = Infinity;
  for (const { u, v, distance } of labels) {
    if (last - v < 1.2 * palette.fontSize * pixel) continue;
    last = v;
    const place = /** @type {const} */ ([u + 5 * pixel, v - 4 * pixel]);
    context.strokeText(`${distance.toFixed(1)} m`, ...place);
    context.fillText(`${distance.toFixed(1)} m`, ...place);
  }
}

/**
 * Draw a line with a rim, so that it is visible on tape and on floor.
 * @param {CanvasRenderingContext2D} context
 * @param {Path2D} path
 * @param {string} colour
 * @param {number} width
 */
function stroke(context, path, colour, width) {
  context.strokeStyle = palette["floor-halo"];
  context.globalAlpha = 0.6;
  context.lineWidth = 2.2 * width;
  context.stroke(path);
  context.globalAlpha = 1;
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.stroke(path);
}
