// @ts-check
import { palette } from "../page/palette.js";

/** @typedef {import("../messages").EdgesMessage} EdgesMessage */
/** @typedef {[number, number]} Point */
/**
 * @typedef {{left: number, top: number, scale: number}} Placement where the picture lies on the
 *   canvas
 */

const MOST_POINTS = 16;
/** Radius of a mark [CSS px]. */
const RING = 2.8;
/** One of so many rays is drawn with its marks: all of them would hide the floor. */
const EVERY = 3;

/** Drop points of a ray, but keep enough for its bend by the lens. @param {Point[]} ray */
export function thin(ray) {
  const stride = Math.max(1, Math.ceil((ray.length - 1) / MOST_POINTS));
  return ray.filter((_, i) => i % stride === 0 || i === ray.length - 1);
}

/**
 * The part of a ray up to a point on it.
 * @param {Point[]} ray
 * @param {Point} end
 * @returns {Point[]}
 */
export function cut(ray, end) {
  const [u, v] = ray[0];
  const reach = Math.hypot(end[0] - u, end[1] - v);
  return [...ray.filter((point) => Math.hypot(point[0] - u, point[1] - v) < reach), end];
}

/** Index of the ray nearest to a pixel. @param {Point[][]} rays @param {Point} pixel */
export function nearestRay(rays, [u, v]) {
  const gaps = rays.map((ray) => Math.min(...ray.slice(1).map((end, i) => gap(ray[i], end, u, v))));
  return gaps.indexOf(Math.min(...gaps));
}

/**
 * Distance of (u, v) from the segment a-b [px].
 * @param {Point} a
 * @param {Point} b
 * @param {number} u
 * @param {number} v
 */
function gap(a, b, u, v) {
  const [du, dv] = [b[0] - a[0], b[1] - a[1]];
  const along = ((u - a[0]) * du + (v - a[1]) * dv) / (du * du + dv * dv || 1);
  const t = Math.min(1, Math.max(0, along));
  return Math.hypot(u - a[0] - t * du, v - a[1] - t * dv);
}

/**
 * Draw rays up to their hits, a ring where each enters the tape and a bar where it leaves.
 * @param {CanvasRenderingContext2D} context @param {Placement} placement
 * @param {Point[][]} rays @param {EdgesMessage} edges @param {number | null} selected
 */
export function drawOverlay(context, placement, rays, edges, selected) {
  context.save();
  context.translate(placement.left, placement.top);
  context.scale(placement.scale, placement.scale);
  const pixel = 1 / placement.scale;
  context.lineCap = "round";
  drawRays(context, rays, edges, pixel);
  if (selected !== null && rays[selected]) drawSelected(context, rays[selected], pixel);
  drawExits(context, edges, pixel);
  drawEntries(context, edges, pixel);
  context.restore();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Point[][]} rays
 * @param {EdgesMessage} edges
 * @param {number} pixel
 */
function drawRays(context, rays, edges, pixel) {
  const hits = new Path2D();
  const misses = new Path2D();
  rays.forEach((ray, i) => {
    if (i % EVERY !== 0) return;
    const entry = edges.entry_px[i];
    trace(entry ? hits : misses, entry ? cut(ray, entry) : ray);
  });
  context.strokeStyle = palette["floor-beam"];
  context.lineWidth = 0.9 * pixel;
  context.globalAlpha = 0.8;
  context.stroke(hits);
  context.globalAlpha = 0.35;
  context.lineWidth = 0.7 * pixel;
  context.stroke(misses);
  context.globalAlpha = 1;
}

/** @param {CanvasRenderingContext2D} context @param {Point[]} ray @param {number} pixel */
function drawSelected(context, ray, pixel) {
  const path = new Path2D();
  trace(path, ray);
  context.strokeStyle = "#fff";
  context.lineWidth = 5 * pixel;
  context.stroke(path);
  context.strokeStyle = palette["floor-estimate"];
  context.lineWidth = 2.5 * pixel;
  context.stroke(path);
}

/** @param {CanvasRenderingContext2D} context @param {EdgesMessage} edges @param {number} pixel */
function drawEntries(context, edges, pixel) {
  const rings = new Path2D();
  for (const [i, point] of edges.entry_px.entries()) {
    if (!point || i % EVERY !== 0) continue;
    rings.moveTo(point[0] + RING * pixel, point[1]);
    rings.arc(point[0], point[1], RING * pixel, 0, 2 * Math.PI);
  }
  twice(context, rings, pixel, "#fff", palette["floor-hits"]);
}

/** @param {CanvasRenderingContext2D} context @param {EdgesMessage} edges @param {number} pixel */
function drawExits(context, edges, pixel) {
  const bars = new Path2D();
  for (const [i, point] of edges.exit_px.entries()) {
    if (!point || i % EVERY !== 0) continue;
    bars.moveTo(point[0], point[1] - RING * pixel);
    bars.lineTo(point[0], point[1] + RING * pixel);
  }
  twice(context, bars, pixel, "#000", palette["floor-beam"]);
}

/**
 * Draw a line with a rim, so that it is visible on tape and on floor.
 * @param {CanvasRenderingContext2D} context
 * @param {Path2D} path
 * @param {number} pixel
 * @param {string} rim
 * @param {string} colour
 */
function twice(context, path, pixel, rim, colour) {
  context.strokeStyle = rim;
  context.lineWidth = 2.4 * pixel;
  context.stroke(path);
  context.strokeStyle = colour;
  context.lineWidth = 1.4 * pixel;
  context.stroke(path);
}

/** @param {Path2D} path @param {Point[]} points */
function trace(path, points) {
  path.moveTo(...points[0]);
  for (const point of points.slice(1)) path.lineTo(...point);
}
