// @ts-check
import { palette } from "../../page/palette.js";
import { stroke } from "../../map/drawing.js";

/** Length of a dash and of a gap [CSS px]. */
const DASH = 4;

/**
 * Mark tape that does not lie where it is drawn: dashed, in the colour of what is wrong.
 * @param {CanvasRenderingContext2D} context in metres
 * @param {[number, number, number, number][]} edges of the drawing [m]
 * @param {number} pixel [m]
 */
export function drawMisplaced(context, edges, pixel) {
  const outline = new Path2D();
  for (const [x1, y1, x2, y2] of edges) {
    outline.moveTo(x1, y1);
    outline.lineTo(x2, y2);
  }
  stroke(context, outline, palette["floor-halo"], 4 * pixel, 0.9);
  context.save();
  context.setLineDash([DASH * pixel, DASH * pixel]);
  stroke(context, outline, palette["floor-rays"], 2 * pixel, 1);
  context.restore();
}
