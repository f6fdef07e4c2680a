// @ts-check
/** A field's drawing as it is edited: lengths in mm, y up, angles in degrees. */

import { arcOf, rounded } from "./bends.js";

/** @typedef {import("../../messages").EditableDrawingMessage} EditableDrawingMessage */
/** @typedef {import("./bends.js").Node} Node */
/**
 * @typedef {object} Stroke
 * @property {Node[]} nodes @property {boolean} closed
 * @property {number} width @property {number} grey @property {number[]} dashes
 */
/**
 * @typedef {object} Drawing
 * @property {number} left @property {number} bottom @property {number} width @property {number} height
 * @property {[number, number, number]} start x, y, heading
 * @property {number} tape width of new tape
 * @property {number} floor brightness of the floor
 * @property {Stroke[]} strokes
 * @property {EditableDrawingMessage["fills"]} fills
 * @property {Record<string, string>} kept
 */

/** Brightness of tape and floor. */
export const LOOKS = /** @type {const} */ ({ dark: { tape: 34, floor: 214 }, light: { tape: 235, floor: 58 } });
/** Widths that tape may have [mm]: of others the program asks whether they are meant. */
export const TAPE = /** @type {[number, number]} */ ([15, 100]);
/** Sides that a floor may have [mm]. */
export const FLOOR = /** @type {[number, number]} */ ([300, 20_000]);

/** @returns {Drawing} */
export function emptyDrawing() {
  return {
    left: -750, bottom: -750, width: 1500, height: 1500, start: [0, 0, 0],
    tape: 50, floor: LOOKS.dark.floor, strokes: [], fills: [], kept: {},
  };
}

/** @param {EditableDrawingMessage} message @returns {Drawing} */
export function openedDrawing({ remarks: _, strokes, fills, ...rest }) {
  const [first] = fills;
  const whole = first && first.opacity === 1 && covers(first.rings, rest);
  return {
    ...rest,
    tape: strokes[0]?.width ?? 50,
    floor: whole ? first.grey : 255,
    strokes: strokes.map((stroke) => ({ ...stroke, nodes: stroke.nodes.map((node) => [...node]) })),
    fills: whole ? fills.slice(1) : fills,
  };
}

/** @param {number[][][]} rings @param {{left: number, bottom: number, width: number, height: number}} floor */
function covers(rings, { left, bottom, width, height }) {
  const [ring] = rings;
  if (rings.length !== 1 || ring.length !== 4) return false;
  const xs = ring.map(([x]) => x);
  const ys = ring.map(([, y]) => y);
  const low = Math.min(...xs) <= left + 0.5 && Math.min(...ys) <= bottom + 0.5;
  return low && Math.max(...xs) >= left + width - 0.5 && Math.max(...ys) >= bottom + height - 0.5;
}

/** Data of an SVG path, y up. @param {Stroke} stroke */
export function pathOf({ nodes, closed }) {
  if (nodes.length === 0) return "";
  const words = [`M ${rounded(nodes[0][0])} ${rounded(nodes[0][1])}`];
  const last = closed ? nodes.length : nodes.length - 1;
  for (let i = 0; i < last; i++) {
    const [x, y] = nodes[(i + 1) % nodes.length];
    const arc = arcOf(nodes[i], nodes[(i + 1) % nodes.length]);
    const to = `${rounded(x)} ${rounded(y)}`;
    words.push(arc ? `A ${rounded(arc.radius)} ${rounded(arc.radius)} 0 ${Number(arc.large)} ${Number(arc.left)} ${to}` : `L ${to}`);
  }
  return words.join(" ") + (closed ? " Z" : "");
}

/** The floor's colour, or tape's. @param {number} grey */
export const colourOf = (grey) => `#${Math.round(grey).toString(16).padStart(2, "0").repeat(3)}`;

/** The drawing's file. @param {Drawing} drawing @param {string} title */
export function svgOf(drawing, title) {
  const { left, bottom, width, height, start, floor, strokes, fills, kept } = drawing;
  const box = [left, -(bottom + height), width, height].map(rounded).join(" ");
  const notes = Object.entries(kept).map(([name, text]) => ` ${name}="${escaped(text)}"`);
  const lines = [
    `<svg xmlns="http://www.w3.org/2000/svg" width="${rounded(width)}mm" height="${rounded(height)}mm" viewBox="${box}" data-start="${start.map(rounded).join(" ")}"${notes.join("")}>`,
    `  <title>${escaped(title)}</title>`,
    `  <rect x="${rounded(left)}" y="${rounded(-(bottom + height))}" width="${rounded(width)}" height="${rounded(height)}" fill="${colourOf(floor)}"/>`,
    '  <g transform="scale(1 -1)" fill="none">',
    ...fills.map(
      ({ rings, grey, opacity }) =>
        `    <path fill="${colourOf(grey)}" fill-rule="evenodd"${opacity < 1 ? ` fill-opacity="${opacity}"` : ""} d="${rings.map((ring) => `M ${ring.map((place) => place.map(rounded).join(" ")).join(" L ")} Z`).join(" ")}"/>`,
    ),
    ...strokes.map(
      (stroke) =>
        `    <path stroke="${colourOf(stroke.grey)}" stroke-width="${rounded(stroke.width)}"${stroke.dashes.length ? ` stroke-dasharray="${stroke.dashes.map(rounded).join(" ")}"` : ""} d="${pathOf(stroke)}"/>`,
    ),
    "  </g>",
    "</svg>",
  ];
  return `${lines.join("\n")}\n`;
}

/** @param {string} text */
const escaped = (text) =>
  text.replace(/[&<>"]/g, (sign) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[sign] ?? sign);
