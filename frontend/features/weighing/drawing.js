// @ts-check
import { drawAim, drawRobot, label, stroke } from "../../map/drawing.js";
import { palette } from "../../page/palette.js";
import { moved } from "./poses.js";

/** @typedef {import("../../messages").PoseFitsMessage} PoseFitsMessage */
/** @typedef {import("../../messages").PoseFitMessage} PoseFitMessage */
/** @typedef {import("../../messages").PoseMessage} PoseMessage */
/** @typedef {import("../../map/view.js").MapView} MapView */
/** @typedef {CanvasRenderingContext2D} Context */

/** A share that much worse than the best ray's is drawn as the largest ring. */
const WORST = 5;

/**
 * Where a pose thinks the tape is: each ray's measured end from there, the larger the ring the less it fits.
 * @param {Context} context in metres
 * @param {PoseFitsMessage} fits
 * @param {PoseMessage} pose that is drawn
 * @param {number} pixel [m]
 * @param {number | null} chosen ray that stands out
 */
export function drawFit(context, fits, pose, pixel, chosen) {
  const { ranges, bearings, asked } = fits;
  const start = moved(pose, fits.robot_from_scan);
  const good = Math.max(-Infinity, ...(asked.shares ?? []).map((share) => share ?? -Infinity));
  ranges.forEach((range, ray) => {
    if (range === null) return;
    const [x, y] = end(start, bearings[ray], range);
    const share = asked.shares?.[ray] ?? null;
    const bad = share === null ? 0 : Math.min(1, (good - share) / WORST);
    ring(context, x, y, (1.5 + 4.5 * bad) * pixel, pixel, bad < 0.2);
  });
  if (chosen !== null) drawChosen(context, fits, start, pixel, chosen);
}

/** @param {PoseMessage} start @param {number} bearing @param {number} range @returns {[number, number]} */
const end = (start, bearing, range) => [
  start.x + range * Math.cos(start.theta + bearing),
  start.y + range * Math.sin(start.theta + bearing),
];

/** @param {Context} context @param {number} x @param {number} y @param {number} radius [m] @param {number} pixel [m] @param {boolean} full */
function ring(context, x, y, radius, pixel, full) {
  const path = new Path2D();
  path.arc(x, y, radius, 0, 2 * Math.PI);
  stroke(context, path, palette["floor-halo"], 3.5 * pixel, 0.8);
  stroke(context, path, palette["floor-draft"], 1.5 * pixel, 1);
  context.fillStyle = palette["floor-draft"];
  if (full) context.fill(path);
}

/** One ray from its start to where it was measured, and a bar across where it was expected. @param {Context} context @param {PoseFitsMessage} fits @param {PoseMessage} start @param {number} pixel @param {number} ray */
function drawChosen(context, { ranges, bearings, asked }, start, pixel, ray) {
  const [range, expected] = [ranges[ray], asked.expected[ray]];
  const line = new Path2D();
  line.moveTo(start.x, start.y);
  line.lineTo(...end(start, bearings[ray], range ?? expected ?? 0));
  stroke(context, line, palette["floor-halo"], 4 * pixel, 0.9);
  stroke(context, line, palette["floor-rays"], 2 * pixel, 1);
  if (expected === null || expected === undefined) return;
  const [x, y] = end(start, bearings[ray], expected);
  const across = start.theta + bearings[ray] + Math.PI / 2;
  const [dx, dy] = [8 * pixel * Math.cos(across), 8 * pixel * Math.sin(across)];
  const bar = new Path2D();
  bar.moveTo(x - dx, y - dy);
  bar.lineTo(x + dx, y + dy);
  stroke(context, bar, palette["floor-halo"], 5 * pixel, 0.9);
  stroke(context, bar, palette["floor-draft"], 2.5 * pixel, 1);
}

/** The pose that is asked, with an arrow to turn it by. @param {Context} context in metres @param {PoseMessage} pose @param {[number, number][]} outline @param {number} pixel */
export function drawGhost(context, pose, outline, pixel) {
  drawRobot(context, pose, outline, pixel, { colour: palette["floor-draft"], dash: [5, 3], fill: 0.06 });
  drawAim(context, pose, pixel, palette["floor-draft"]);
}

/** @param {Context} context in CSS pixels @param {MapView} view @param {PoseMessage} pose @param {string} words */
export function drawWords(context, view, pose, words) {
  const [u, v] = view.toScreen(pose.x, pose.y);
  context.font = `bold ${palette.font}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  label(context, words, u, v + 26);
}
