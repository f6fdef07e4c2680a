// @ts-check
import { stroke } from "../map/drawing.js";
import { palette } from "../page/palette.js";

/** @typedef {import("../map/scene.js").Draft} Draft */
/** @typedef {import("../messages").PoseMessage} PoseMessage */
/** @typedef {import("./floor_view.js").FloorView} FloorView */
/** @typedef {import("./floor_view.js").Point} Point */

/** Corners of a circle. */
const CORNERS = 48;
/** An arrow of the map, ahead and to the left [CSS px]. @type {Point[][]} */
const ARROW = [[[0, 0], [48, 0]], [[36, -9], [49, 0], [36, 9]]];

/**
 * Draw a pose that the user is pointing out on the floor of the scene, as the map draws it.
 * @param {CanvasRenderingContext2D} context
 * @param {FloorView} floor
 * @param {Draft} draft
 * @param {Point[]} outline of the robot [m]
 */
export function drawDraft(context, floor, { pose, spread }, outline) {
  const colour = palette["floor-draft"];
  if (spread !== null) drawShape(context, floor, placed(circle(), pose, 2 * spread), 0.1);
  drawShape(context, floor, placed(outline, pose, 1), 0.2);
  const pixel = 1 / floor.scale([pose.x, pose.y]);
  const arrow = new Path2D();
  for (const line of ARROW) add(arrow, floor, placed(line, pose, pixel));
  context.lineCap = context.lineJoin = "round";
  stroke(context, arrow, palette["floor-halo"], 7, 1);
  stroke(context, arrow, colour, 3.5, 1);
}

/**
 * Draw an area of the floor.
 * @param {CanvasRenderingContext2D} context
 * @param {FloorView} floor
 * @param {Point[]} corners [m]
 * @param {number} fill how much it covers, 0 to 1
 */
export function drawShape(context, floor, corners, fill) {
  const path = new Path2D();
  add(path, floor, corners);
  path.closePath();
  context.fillStyle = palette["floor-draft"];
  context.globalAlpha = fill;
  context.fill(path);
  stroke(context, path, palette["floor-halo"], 4, 0.8);
  stroke(context, path, palette["floor-draft"], 2, 1);
}

/** Add a line on the floor, without what is behind the camera. @param {Path2D} path @param {FloorView} floor @param {Point[]} line [m] */
function add(path, floor, line) {
  const seen = line.map((point) => floor.toPicture(point)).filter((point) => point !== null);
  seen.forEach(([u, v], i) => (i ? path.lineTo(u, v) : path.moveTo(u, v)));
}

/**
 * Points of a figure on the floor.
 * @param {Point[]} points @param {PoseMessage} pose of the figure @param {number} size [m]
 * @returns {Point[]} [m]
 */
function placed(points, { x, y, theta }, size) {
  const [cos, sin] = [size * Math.cos(theta), size * Math.sin(theta)];
  return points.map(([ahead, left]) => [x + cos * ahead - sin * left, y + sin * ahead + cos * left]);
}

/** The unit circle. @returns {Point[]} */
function circle() {
  return Array.from({ length: CORNERS }, (_, i) => {
    const angle = (2 * Math.PI * i) / CORNERS;
    return [Math.cos(angle), Math.sin(angle)];
  });
}
