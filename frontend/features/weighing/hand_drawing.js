// @ts-check
import { stroke } from "../../map/drawing.js";
import { palette } from "../../page/palette.js";

/** @typedef {import("../../map/cloud.js").Cloud} Cloud */
/** @typedef {import("../../map/view.js").MapView} MapView */
/** @typedef {import("./hand.js").Shown} Shown */
/** @typedef {CanvasRenderingContext2D} Context in CSS pixels */

/** Lines are drawn from so many particles: more would be a smear. */
const MOST_LINES = 600;
/** Steps of shade. */
const SHADES = 8;
/** Largest radius of a particle [CSS px]. */
const LARGEST = 9;

/** What the last step by hand did. @param {Context} context @param {MapView} view @param {Shown} shown */
export function drawStep(context, view, { message, before, after, noiseless }) {
  if (message.last === "predict") lines(context, view, noiseless, after, (i) => i);
  if (message.last === "resample") {
    dead(context, view, before, new Set(message.parents));
    lines(context, view, before, after, (i) => message.parents[i]);
  }
  particles(context, view, after);
}

/**
 * Particles by weight, as size and as shade; the heaviest on top.
 * @param {Context} context @param {MapView} view @param {Cloud} cloud
 */
function particles(context, view, { xs, ys, weights }) {
  const mean = weights.reduce((sum, weight) => sum + weight, 0) / Math.max(1, weights.length) || 1;
  const paths = Array.from({ length: SHADES }, () => new Path2D());
  xs.forEach((x, i) => {
    const times = weights[i] / mean;
    // The area is the weight; of the mean, 2.5 pixels.
    const radius = Math.min(LARGEST, Math.max(0.7, 2.5 * Math.sqrt(times)));
    const shade = Math.min(SHADES - 1, Math.floor((radius / LARGEST) * SHADES));
    const [u, v] = view.toScreen(x, ys[i]);
    paths[shade].moveTo(u + radius, v);
    paths[shade].arc(u, v, radius, 0, 2 * Math.PI);
  });
  paths.forEach((path, shade) => {
    context.fillStyle = palette["floor-estimate"];
    context.globalAlpha = 0.25 + (0.6 * shade) / (SHADES - 1);
    context.fill(path);
    // Rims keep large ones apart; on many small ones they would be all that is seen.
    if (shade > 2) stroke(context, path, palette["floor-halo"], 0.8, 0.8);
  });
  context.globalAlpha = 1;
}

/** A cross where a particle has no copy. @param {Context} context @param {MapView} view @param {Cloud} cloud @param {Set<number>} parents */
function dead(context, view, { xs, ys }, parents) {
  const crosses = new Path2D();
  xs.forEach((x, i) => {
    if (parents.has(i)) return;
    const [u, v] = view.toScreen(x, ys[i]);
    crosses.moveTo(u - 2.5, v - 2.5);
    crosses.lineTo(u + 2.5, v + 2.5);
    crosses.moveTo(u + 2.5, v - 2.5);
    crosses.lineTo(u - 2.5, v + 2.5);
  });
  stroke(context, crosses, palette["floor-odometry"], 1, 0.55);
}

/**
 * Lines from where particles were to where they are.
 * @param {Context} context @param {MapView} view @param {Cloud} from @param {Cloud} to
 * @param {(i: number) => number} origin which of `from` one of `to` comes from
 */
function lines(context, view, from, to, origin) {
  const path = new Path2D();
  const stride = Math.max(1, Math.ceil(to.xs.length / MOST_LINES));
  for (let i = 0; i < to.xs.length; i += stride) {
    const before = origin(i);
    if (before < 0) continue;
    path.moveTo(...view.toScreen(from.xs[before], from.ys[before]));
    path.lineTo(...view.toScreen(to.xs[i], to.ys[i]));
  }
  stroke(context, path, palette["floor-draft"], 0.8, 0.5);
}
