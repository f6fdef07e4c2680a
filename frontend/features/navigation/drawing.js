// @ts-check
import { palette } from "../../page/palette.js";
import { drawAim, drawRobot, stroke } from "../../map/drawing.js";

/** @typedef {import("../../messages").NavigationPathMessage} NavigationPathMessage */
/** @typedef {import("../../messages").PoseMessage} PoseMessage */

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
 * @param {CanvasRenderingContext2D} context
 * @param {number} x [m] @param {number} y [m] @param {number} radius [m] @param {number} pixel [m]
 */
function ring(context, x, y, radius, pixel) {
  const path = new Path2D();
  path.arc(x, y, radius, 0, 2 * Math.PI);
  stroke(context, path, palette["floor-halo"], 4 * pixel, 0.8);
  stroke(context, path, palette["floor-beam"], 2 * pixel, 1);
}
