// @ts-check
import { palette } from "../../page/palette.js";
import { stroke } from "../../map/drawing.js";
import { ends } from "./end_tool.js";

/** @typedef {import("../../messages").MapDrawingMessage} MapDrawingMessage */
/** @typedef {import("./end_tool.js").HeldEnd} HeldEnd */

/** Width of the tape's line on the screen [CSS px]. */
const LINE = 4;
/** Intervals are drawn if they are wider than this on the screen [CSS px]. */
const SEEN = 2;

/**
 * Draw a map that is drawn by driving: edges that were seen, path, tape, and how certain it is.
 * @param {CanvasRenderingContext2D} context in metres
 * @param {MapDrawingMessage} drawing
 * @param {number} pixel [m]
 * @param {number} chosen number of a stroke that stands out
 */
export function drawMapping(context, { strokes, path, edges, unseen_ends }, pixel, chosen) {
  context.lineJoin = "round";
  context.fillStyle = palette["floor-rays"];
  for (const [x, y] of edges) context.fillRect(x - 0.75 * pixel, y - 0.75 * pixel, 1.5 * pixel, 1.5 * pixel);
  stroke(context, line(path), palette["floor-estimate"], 1.5 * pixel, 0.7);
  for (const [number, { points, interval }] of strokes.entries()) {
    const tape = line(points);
    if (number === chosen) stroke(context, tape, palette["floor-beam"], 4 * LINE * pixel, 1);
    if (interval > SEEN * pixel) stroke(context, tape, palette["floor-drawn"], 2 * interval, 0.25);
    stroke(context, tape, palette["floor-halo"], (LINE + 3) * pixel, 0.8);
    stroke(context, tape, palette["floor-drawn"], LINE * pixel, 1);
  }
  for (const [x, y] of unseen_ends) {
    const ring = new Path2D();
    ring.arc(x, y, 7 * pixel, 0, 2 * Math.PI);
    stroke(context, ring, palette["floor-halo"], 5 * pixel, 0.8);
    stroke(context, ring, palette["floor-odometry"], 2 * pixel, 1);
  }
}

/**
 * Draw the ends of a finished map's strokes, which can be dragged, and where one is dragged to.
 * @param {CanvasRenderingContext2D} context in metres
 * @param {MapDrawingMessage} drawing
 * @param {number} pixel [m]
 * @param {HeldEnd | null} held
 */
export function drawEnds(context, drawing, pixel, held) {
  for (const { stroke: number, last, place } of ends(drawing)) {
    const isHeld = held !== null && held.stroke === number && held.last === last;
    const handle = new Path2D();
    handle.arc(...(isHeld ? held.place : place), 4 * pixel, 0, 2 * Math.PI);
    if (isHeld) stroke(context, line([place, held.place]), palette["floor-drawn"], 2 * pixel, 1);
    context.fillStyle = palette["floor-halo"];
    context.fill(handle);
    stroke(context, handle, palette["floor-drawn"], 1.5 * pixel, 1);
  }
}

/** @param {[number, number][]} points */
function line(points) {
  const path = new Path2D();
  points.forEach(([x, y], i) => (i ? path.lineTo(x, y) : path.moveTo(x, y)));
  return path;
}
