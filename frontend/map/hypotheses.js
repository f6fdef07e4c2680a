// @ts-check
import { palette } from "../page/palette.js";
import { label, stroke } from "./drawing.js";
import { percent } from "./places.js";

/** @typedef {import("../messages").HypothesisMessage} HypothesisMessage */
/** @typedef {import("./view.js").MapView} MapView */
/** @typedef {[number, number]} Point [CSS px] */

/** An arrowhead around the origin, pointing right [CSS px]. */
const ARROW = new Path2D("M13 0L-7 8L-3 0L-7 -8Z");
/** Positions for a weight beside its arrow [CSS px]; the first free one is used. */
const BESIDE = /** @type {const} */ ([
  [0, 22],
  [0, -22],
  [36, 0],
  [-36, 0],
  [32, 22],
  [-32, 22],
  [32, -22],
  [-32, -22],
]);
/** Room for a weight to each side of its centre [CSS px]. */
const HALF_WIDTH = 22;
const HALF_HEIGHT = 9;
const ARROW_RADIUS = 12;

/**
 * Draw places where the robot may be, as arrows with their weights.
 * @param {CanvasRenderingContext2D} context
 * @param {MapView} view
 * @param {HypothesisMessage[]} hypotheses heaviest first
 * @param {boolean} clear whether the first is drawn to stand out
 */
export function drawHypotheses(context, view, hypotheses, clear) {
  const points = hypotheses.map(({ x, y }) => view.toScreen(x, y));
  // The heaviest is drawn last, so that none covers it.
  hypotheses.forEach((_, i) => {
    const last = hypotheses.length - 1 - i;
    drawArrow(context, points[last], hypotheses[last].theta, clear && last === 0);
  });
  context.textBaseline = "middle";
  context.textAlign = "center";
  /** @type {Point[]} */
  const taken = [];
  hypotheses.forEach(({ weight }, i) => {
    const place = free(points[i], points, taken);
    taken.push(place);
    context.font = clear && i === 0 ? `bold ${palette.font}` : palette.font;
    label(context, percent(weight), ...place);
  });
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Point} at
 * @param {number} theta
 * @param {boolean} first whether it is clearly the likeliest: then it is filled, not hollow
 */
function drawArrow(context, at, theta, first) {
  context.save();
  context.translate(...at);
  context.rotate(-theta);
  context.lineJoin = "round";
  stroke(context, ARROW, palette["floor-halo"], first ? 6 : 5, 1);
  stroke(context, ARROW, palette["floor-estimate"], first ? 3 : 2, 1);
  context.fillStyle = first ? palette["floor-estimate"] : palette["floor-halo"];
  context.fill(ARROW);
  context.restore();
}

/**
 * Find a position beside an arrow where a weight hides neither arrows nor other weights.
 * @param {Point} at
 * @param {Point[]} arrows
 * @param {Point[]} taken
 * @returns {Point}
 */
function free(at, arrows, taken) {
  const places = BESIDE.map(([u, v]) => /** @type {Point} */ ([at[0] + u, at[1] + v]));
  const clear = (/** @type {Point} */ place) =>
    !taken.some((other) => near(place, other, 2 * HALF_WIDTH, 2 * HALF_HEIGHT)) &&
    !arrows.some((other) =>
      near(place, other, HALF_WIDTH + ARROW_RADIUS, HALF_HEIGHT + ARROW_RADIUS),
    );
  return places.find(clear) ?? places[0];
}

/** @param {Point} a @param {Point} b @param {number} across @param {number} down */
const near = (a, b, across, down) => Math.abs(a[0] - b[0]) < across && Math.abs(a[1] - b[1]) < down;
