// @ts-check
import { palette } from "../page/palette.js";
import { millimetres } from "../page/format.js";
import { ellipse, RADII_95 } from "./places.js";
import { roundUp } from "../plots/scale.js";

/** @typedef {import("../messages").EstimateMessage} EstimateMessage */
/** @typedef {import("../messages").HypothesisMessage} HypothesisMessage */
/** @typedef {import("../messages").PoseMessage} PoseMessage */
/** @typedef {import("../messages").ScanMessage} ScanMessage */
/** @typedef {import("./view.js").MapView} MapView */
/** @typedef {import("../messages").IntegrityMessage} IntegrityMessage */
/** @typedef {CanvasRenderingContext2D} Context */

/** A smaller bound on the screen [CSS px] cannot be distinguished from the place itself. */
const SEEN = 4;
/** One of so many rays is drawn, as in the camera's picture. */
const EVERY = 3;
/** Largest length of the wedge of headings [CSS px] and [m]. */
const WEDGE = 70;
const WEDGE_M = 0.3;

/**
 * Draw rays to their hits, from the estimate at the scan's stamp.
 * @param {Context} context
 * @param {ScanMessage} scan
 * @param {number} pixel [m]
 */
export function drawScan(context, { robot, robot_from_scan: offset, bearings, ranges }, pixel) {
  if (!robot) return;
  context.save();
  enter(context, robot);
  enter(context, offset);
  const rays = new Path2D();
  const hits = new Path2D();
  bearings.forEach((bearing, i) => {
    const range = ranges[i];
    if (range === null || range === undefined) return;
    const [x, y] = [range * Math.cos(bearing), range * Math.sin(bearing)];
    if (i % EVERY === 0) {
      rays.moveTo(0, 0);
      rays.lineTo(x, y);
    }
    hits.moveTo(x + 1.8 * pixel, y);
    hits.arc(x, y, 1.8 * pixel, 0, 2 * Math.PI);
  });
  stroke(context, rays, palette["floor-rays"], 0.7 * pixel, 0.35);
  stroke(context, hits, palette["floor-halo"], 2 * pixel, 0.9);
  context.fillStyle = palette["floor-hits"];
  context.fill(hits);
  context.restore();
}

/**
 * Draw a robot's outline with its heading.
 * @param {Context} context
 * @param {PoseMessage} pose
 * @param {[number, number][]} outline [m]
 * @param {number} pixel [m]
 * @param {{colour: string, dash?: number[], fill?: number}} style
 */
export function drawRobot(context, pose, outline, pixel, { colour, dash = [], fill = 0 }) {
  context.save();
  enter(context, pose);
  const body = new Path2D();
  outline.forEach(([x, y], i) => (i ? body.lineTo(x, y) : body.moveTo(x, y)));
  body.closePath();
  const nose = Math.max(0.02, ...outline.map(([x]) => x));
  const arrow = new Path2D();
  arrow.moveTo(0, 0);
  arrow.lineTo(nose * 1.5, 0);
  context.fillStyle = colour;
  context.globalAlpha = fill;
  context.fill(body);
  context.setLineDash(dash.map((length) => length * pixel));
  stroke(context, body, colour, 2 * pixel, 1);
  context.setLineDash([]);
  stroke(context, arrow, colour, 2.5 * pixel, 1);
  context.restore();
}

/**
 * Draw a pose that the user is pointing out, as an arrow of a fixed length on the screen.
 * @param {Context} context
 * @param {PoseMessage} pose
 * @param {number} pixel [m]
 * @param {string} colour
 */
export function drawAim(context, pose, pixel, colour) {
  context.save();
  enter(context, pose);
  context.scale(pixel, pixel);
  const arrow = new Path2D("M0 0H48M36 -9L49 0L36 9");
  context.lineCap = "round";
  context.lineJoin = "round";
  stroke(context, arrow, palette["floor-halo"], 7, 1);
  stroke(context, arrow, colour, 3.5, 1);
  context.restore();
}

/**
 * Draw where the robot is with 95 % certainty, if it is at this place.
 * @param {Context} context
 * @param {EstimateMessage | HypothesisMessage} place
 * @param {number} pixel [m]
 * @param {boolean} faint for places that are not the likeliest
 */
export function drawCertainty(context, { x, y, covariance }, pixel, faint) {
  const { sds, angle } = ellipse(covariance);
  const radii = sds.map((sd) => RADII_95 * sd);
  context.setLineDash(faint ? [4 * pixel, 3 * pixel] : []);
  drawEllipse(context, x, y, radii, angle, palette["floor-estimate"], pixel);
  context.setLineDash([]);
}

/**
 * Draw the claimed bounds: the robot is within the circle, its heading within the wedge. A bound
 * that is too small to see is left out.
 * @param {Context} context
 * @param {PoseMessage} pose
 * @param {IntegrityMessage} integrity
 * @param {number} pixel [m]
 */
export function drawClaim(context, pose, { radius, heading_bound: bound }, pixel) {
  context.save();
  enter(context, pose);
  const claim = new Path2D();
  if (radius !== null && radius > SEEN * pixel) claim.arc(0, 0, radius, 0, 2 * Math.PI);
  const reach = Math.min(WEDGE * pixel, WEDGE_M);
  if (bound !== null && reach * bound > SEEN * pixel) {
    claim.moveTo(0, 0);
    claim.arc(0, 0, reach, -bound, bound);
    claim.closePath();
  }
  context.fillStyle = palette["floor-estimate"];
  context.globalAlpha = 0.08;
  context.fill(claim);
  stroke(context, claim, palette["floor-halo"], 3 * pixel, 0.7);
  context.setLineDash([6 * pixel, 3 * pixel]);
  stroke(context, claim, palette["floor-estimate"], 1.5 * pixel, 1);
  context.restore();
}

/**
 * @param {Context} context
 * @param {number} x
 * @param {number} y
 * @param {number[]} radii [m]
 * @param {number} angle
 * @param {string} colour
 * @param {number} pixel [m]
 */
export function drawEllipse(context, x, y, radii, angle, colour, pixel) {
  const path = new Path2D();
  path.ellipse(x, y, radii[0], radii[1], angle, 0, 2 * Math.PI);
  context.fillStyle = colour;
  context.globalAlpha = 0.1;
  context.fill(path);
  stroke(context, path, colour, 1.5 * pixel, 0.9);
}

/** Draw a bar of a round length, bottom right. @param {Context} context @param {MapView} view */
export function drawScaleBar(context, view) {
  // Longer than its words, however large these are.
  const metres = roundUp((4 * palette.fontSize) / view.scale);
  const length = metres * view.scale;
  const [right, bottom] = [view.width - 12, view.height - 12];
  const bar = new Path2D();
  bar.moveTo(right - length, bottom - 5);
  bar.lineTo(right - length, bottom);
  bar.lineTo(right, bottom);
  bar.lineTo(right, bottom - 5);
  stroke(context, bar, palette.panel, 5, 0.8);
  stroke(context, bar, palette.text, 2, 1);
  context.font = palette.font;
  context.textAlign = "right";
  context.textBaseline = "alphabetic";
  label(
    context,
    metres >= 1 ? `${metres} m` : `${Math.round(metres * 1000)} mm`,
    right,
    bottom - 9,
  );
}

/**
 * Draw a line that was measured, with its length.
 * @param {Context} context
 * @param {MapView} view
 * @param {[number, number]} from [m]
 * @param {[number, number]} end [m]
 */
export function drawMeasure(context, view, from, end) {
  const [a, b] = [view.toScreen(...from), view.toScreen(...end)];
  const line = new Path2D();
  line.moveTo(...a);
  line.lineTo(...b);
  for (const [u, v] of [a, b]) {
    line.moveTo(u + 3, v);
    line.arc(u, v, 3, 0, 2 * Math.PI);
  }
  stroke(context, line, palette["floor-halo"], 6, 0.9);
  stroke(context, line, palette["floor-draft"], 2, 1);
  context.font = `bold ${palette.font}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  const way = Math.hypot(end[0] - from[0], end[1] - from[1]);
  label(context, millimetres(way), (a[0] + b[0]) / 2, (a[1] + b[1]) / 2 - 14);
}

/**
 * Draw text with a rim, so that it is readable on floor, tape and page.
 * @param {Context} context
 * @param {string} text
 * @param {number} u
 * @param {number} v
 */
export function label(context, text, u, v) {
  context.lineJoin = "round";
  context.lineWidth = 4;
  context.strokeStyle = palette.panel;
  context.strokeText(text, u, v);
  context.fillStyle = palette.text;
  context.fillText(text, u, v);
}

/** @param {Context} context @param {PoseMessage} pose */
function enter(context, { x, y, theta }) {
  context.translate(x, y);
  context.rotate(theta);
}

/**
 * @param {Context} context
 * @param {Path2D} path
 * @param {string} colour
 * @param {number} width
 * @param {number} alpha
 */
export function stroke(context, path, colour, width, alpha) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.globalAlpha = alpha;
  context.stroke(path);
  context.globalAlpha = 1;
}
