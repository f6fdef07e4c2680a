// @ts-check
import { palette } from "../page/palette.js";

/** @typedef {import("../messages").FloorGridMessage} FloorGridMessage */
/** @typedef {import("./overlay.js").Placement} Placement */

/**
 * Draw the floor's grid over a picture; loaded when it is first shown.
 * @param {CanvasRenderingContext2D} context
 * @param {FloorGridMessage} grid
 * @param {Placement} placement
 * @param {{width: number, height: number}} picture
 */
export function drawGrid(context, grid, { left, top, scale }, { width, height }) {
  const [across, ahead] = [new Path2D(), new Path2D()];
  for (const line of grid.lines) {
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
  drawLabels(context, grid.labels, 1 / scale);
  context.restore();
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
