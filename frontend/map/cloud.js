// @ts-check
import { palette } from "../page/palette.js";

/** @typedef {import("../messages").ParticlesMessage} ParticlesMessage */
/** @typedef {import("./view.js").MapView} MapView */
/**
 * @typedef {{xs: Float32Array, ys: Float32Array, thetas: Float32Array, weights: Uint8Array}}
 *   Cloud
 */

const BYTES = 8;
/** Particles are drawn in this many steps of weight. */
const STEPS = 6;
const MOST_HEADINGS = 120;

/**
 * Unpack the particles; ParticlesMessage describes the layout.
 * @param {Pick<ParticlesMessage, "cloud" | "extent">} message
 * @returns {Cloud}
 */
export function decodeCloud({ cloud, extent: [xmin, ymin, xmax, ymax] }) {
  const text = atob(cloud);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  const view = new DataView(bytes.buffer);
  const count = Math.floor(bytes.length / BYTES);
  const xs = new Float32Array(count);
  const ys = new Float32Array(count);
  const thetas = new Float32Array(count);
  const weights = new Uint8Array(count);
  for (let i = 0; i < count; i++) {
    const at = i * BYTES;
    xs[i] = xmin + share(view.getUint16(at, true)) * (xmax - xmin);
    ys[i] = ymin + share(view.getUint16(at + 2, true)) * (ymax - ymin);
    thetas[i] = (view.getInt16(at + 4, true) / 32768) * Math.PI;
    weights[i] = view.getUint8(at + 6);
  }
  return { xs, ys, thetas, weights };
}

/** A particle on the rim may lie anywhere beyond it: NaN is not drawn. @param {number} word */
const share = (word) => (word === 0 || word === 65535 ? NaN : word / 65535);

/**
 * Draw particles as dots: heavier ones are larger, stronger and on top.
 * @param {CanvasRenderingContext2D} context @param {MapView} view @param {Cloud} cloud
 */
export function drawCloud(context, view, cloud) {
  const paths = Array.from({ length: STEPS }, () => new Path2D());
  const mean = cloud.weights.reduce((sum, weight) => sum + weight, 1) / cloud.weights.length;
  cloud.xs.forEach((x, i) => {
    // Compare with the mean: if all weights are equal, no particle is heavy.
    const heavy = cloud.weights[i] / (cloud.weights[i] + mean);
    const step = Math.min(STEPS - 1, Math.floor(heavy ** 2 * STEPS));
    const [u, v] = view.toScreen(x, cloud.ys[i]);
    const side = 2.5 + step * 0.5;
    paths[step].rect(u - side / 2, v - side / 2, side, side);
  });
  context.fillStyle = palette["floor-estimate"];
  paths.forEach((path, step) => {
    context.globalAlpha = 0.3 + (0.6 * step) / (STEPS - 1);
    context.fill(path);
  });
  context.globalAlpha = 1;
  drawHeadings(context, view, cloud);
}

/**
 * Draw short lines along the headings of some particles.
 * @param {CanvasRenderingContext2D} context
 * @param {MapView} view
 * @param {Cloud} cloud
 */
function drawHeadings(context, view, cloud) {
  const stride = Math.ceil(cloud.xs.length / MOST_HEADINGS) || 1;
  context.beginPath();
  for (let i = 0; i < cloud.xs.length; i += stride) {
    const [u, v] = view.toScreen(cloud.xs[i], cloud.ys[i]);
    context.moveTo(u, v);
    context.lineTo(u + 9 * Math.cos(cloud.thetas[i]), v - 9 * Math.sin(cloud.thetas[i]));
  }
  context.strokeStyle = palette["floor-estimate"];
  context.globalAlpha = 0.35;
  context.lineWidth = 1;
  context.stroke();
  context.globalAlpha = 1;
}
