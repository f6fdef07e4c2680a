// @ts-check
import { palette } from "../../page/palette.js";
import { drawAim, drawRobot, stroke } from "../../map/drawing.js";

/** @typedef {import("../../messages").CostsMessage} CostsMessage */
/** @typedef {import("../../messages").GoalMessage} GoalMessage */
/** @typedef {import("../../messages").NavigationPathMessage} NavigationPathMessage */
/** @typedef {import("../../messages").PoseMessage} PoseMessage */

/** nav2's costs of a wall, and of a place where the robot cannot turn. */
const [LETHAL, INSCRIBED] = [254, 253];
/** Radius of a waypoint's disc [CSS px]. */
const NUMBER = 9;
/** Of a zone's hatching: a view that is far away needs no more. */
const MOST_LINES = 400;

/**
 * Draw the way to a goal, the goals, and where the robot shall be next.
 * @param {CanvasRenderingContext2D} context in metres
 * @param {NavigationPathMessage} way
 * @param {PoseMessage | null} target
 * @param {[number, number][]} outline of the robot [m]
 * @param {number} pixel [m]
 */
export function drawJourney(context, { path, goals }, target, outline, pixel) {
  const line = new Path2D();
  path.forEach(([x, y], i) => (i ? line.lineTo(x, y) : line.moveTo(x, y)));
  stroke(context, line, palette["floor-halo"], 5 * pixel, 0.8);
  stroke(context, line, palette["floor-beam"], 2.5 * pixel, 1);
  for (const { x, y, theta } of goals) {
    if (theta === null || theta === undefined) {
      ring(context, x, y, 7 * pixel, pixel);
      continue;
    }
    const pose = { x, y, theta };
    drawRobot(context, pose, outline, pixel, { colour: palette["floor-beam"], dash: [3, 3] });
    drawAim(context, pose, pixel, palette["floor-beam"]);
  }
  if (target) ring(context, target.x, target.y, 4 * pixel, pixel);
}

/**
 * Draw waypoints that wait to be driven to, numbered.
 * @param {CanvasRenderingContext2D} context in metres
 * @param {GoalMessage[]} points
 * @param {number} pixel [m]
 */
export function drawWaypoints(context, points, pixel) {
  const line = new Path2D();
  points.forEach(({ x, y }, i) => (i ? line.lineTo(x, y) : line.moveTo(x, y)));
  stroke(context, line, palette["floor-draft"], 1.5 * pixel, 0.6);
  points.forEach(({ x, y, theta }, i) => {
    if (theta !== null && theta !== undefined) drawAim(context, { x, y, theta }, pixel, palette["floor-draft"]);
    const disc = new Path2D();
    disc.arc(x, y, NUMBER * pixel, 0, 2 * Math.PI);
    stroke(context, disc, palette["floor-halo"], 3 * pixel, 0.9);
    context.fillStyle = palette["floor-draft"];
    context.fill(disc);
    context.save();
    context.translate(x, y);
    // The map's y points up.
    context.scale(pixel, -pixel);
    context.fillStyle = palette["floor-halo"];
    context.font = `bold ${palette.font}`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillText(String(i + 1), 0, 1);
    context.restore();
  });
}

/**
 * Draw a keep-out zone.
 * @param {CanvasRenderingContext2D} context in metres
 * @param {[number, number][]} zone corners
 * @param {number} pixel [m]
 * @param {boolean} draft whether it is being drawn
 */
export function drawZone(context, zone, pixel, draft = false) {
  const path = new Path2D();
  zone.forEach(([x, y], i) => (i ? path.lineTo(x, y) : path.moveTo(x, y)));
  path.closePath();
  const colour = palette[draft ? "floor-draft" : "floor-hits"];
  context.save();
  context.globalAlpha = 0.18;
  context.fillStyle = colour;
  context.fill(path);
  context.clip(path);
  context.globalAlpha = 0.6;
  stroke(context, hatching(zone, 12 * pixel), colour, 1.2 * pixel, 0.7);
  context.restore();
  stroke(context, path, palette["floor-halo"], 4 * pixel, 0.8);
  stroke(context, path, colour, 2 * pixel, 1);
}

/** Slanted lines over a zone. @param {[number, number][]} zone @param {number} step [m] */
function hatching(zone, step) {
  const [xs, ys] = [zone.map(([x]) => x), zone.map(([, y]) => y)];
  const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const lines = new Path2D();
  const count = Math.min(MOST_LINES, (right - left + high - low) / step);
  for (let i = 1; i < count; i++) {
    lines.moveTo(left + i * step, low);
    lines.lineTo(left + i * step - (high - low), high);
  }
  return lines;
}

/** The costs of ways, one pixel a cell, north up. @param {CostsMessage} costs */
export function costPicture({ cells, columns, rows }) {
  const canvas = document.createElement("canvas");
  canvas.width = columns;
  canvas.height = rows;
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const image = context.createImageData(columns, rows);
  const text = atob(cells);
  for (let i = 0; i < text.length; i++) {
    const row = rows - 1 - Math.floor(i / columns);
    image.data.set(shade(text.charCodeAt(i)), 4 * (row * columns + (i % columns)));
  }
  context.putImageData(image, 0, 0);
  return canvas;
}

/** @param {number} cost @returns {number[]} red, green, blue, alpha */
function shade(cost) {
  if (cost >= LETHAL) return [90, 15, 60, 210];
  if (cost === INSCRIBED) return [150, 40, 90, 150];
  return [235, 120, 40, Math.round(190 * (cost / INSCRIBED) ** 0.6)];
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} x [m] @param {number} y [m] @param {number} radius [m] @param {number} pixel [m]
 */
function ring(context, x, y, radius, pixel) {
  const path = new Path2D();
  path.arc(x, y, radius, 0, 2 * Math.PI);
  stroke(context, path, palette["floor-halo"], 4 * pixel, 0.8);
  stroke(context, path, palette["floor-beam"], 2 * pixel, 1);
}
