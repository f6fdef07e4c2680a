// @ts-check
import { t } from "../../page/language.js";
import { make, setText } from "../../page/elements.js";
import { degrees, millimetres, plain } from "../../page/format.js";
import { palette } from "../../page/palette.js";
import { Surface } from "../../page/surface.js";

/** @typedef {import("../../messages").PoseFitsMessage} PoseFitsMessage */
/** @typedef {import("../../messages").PoseFitMessage} PoseFitMessage */

/** Part of the height for the ranges; the rest is for the rays' shares. */
const RANGES = 0.55;
const LEFT = 34;
const GAP = 14;

/** Expected and measured range of each ray, and its share of the log-likelihood. */
export class RayChart {
  /** Number of the ray that stands out. @type {number | null} */
  chosen = null;
  /** @type {PoseFitsMessage | null} */
  #fits = null;
  #canvas = /** @type {HTMLCanvasElement} */ (
    make("canvas", {
      tabindex: "0",
      role: "application",
      "data-own-arrows": "",
      "aria-label": t("Rays: expected and measured range, and share of the log-likelihood. Left and right choose a ray."),
    })
  );
  #readout = make("output", { class: "readout" });
  element = make(
    "div",
    { class: "ray-chart" },
    make(
      "ul",
      { class: "legend" },
      make("li", {}, make("span", { class: "swatch seen" }), t("measured")),
      make("li", {}, make("span", { class: "swatch asked" }), t("expected by it")),
      make("li", {}, make("span", { class: "swatch estimate" }), t("expected by the estimate")),
      make("li", {}, make("span", { class: "swatch ring" }), t("on the map: the larger, the less a ray fits")),
    ),
    make("div", { class: "stage" }, this.#canvas),
    this.#readout,
  );

  /** @param {() => void} changed when another ray is chosen */
  constructor(changed) {
    this.changed = changed;
    this.surface = new Surface(this.#canvas, () => this.#paint());
    this.#canvas.addEventListener("pointermove", (event) => this.#point(event));
    this.#canvas.addEventListener("pointerdown", (event) => this.#point(event));
    this.#canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  /** @param {PoseFitsMessage} fits */
  show(fits) {
    this.#fits = fits;
    this.#tell();
    this.#paint();
  }

  /** Rays from left to right, as the robot sees them. @returns {number[]} */
  get #order() {
    const bearings = this.#fits?.bearings ?? [];
    return bearings.map((_, ray) => ray).sort((a, b) => bearings[b] - bearings[a]);
  }

  /** @param {PointerEvent} event */
  #point(event) {
    const order = this.#order;
    const [u] = this.surface.locate(event);
    const place = Math.floor(((u - LEFT) / Math.max(1, this.surface.width - LEFT)) * order.length);
    this.#choose(order[Math.min(order.length - 1, Math.max(0, place))] ?? null);
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const order = this.#order;
    if (step === undefined || order.length === 0) return;
    const at = this.chosen === null ? -1 : order.indexOf(this.chosen);
    this.#choose(order[Math.min(order.length - 1, Math.max(0, at + step))]);
    event.preventDefault();
  }

  /** @param {number | null} ray */
  #choose(ray) {
    this.chosen = ray;
    this.#tell();
    this.#paint();
    this.changed();
  }

  #tell() {
    if (this.#fits) setText(this.#readout, this.chosen === null ? worst(this.#fits) : told(this.#fits, this.chosen));
  }

  #paint() {
    const fits = this.#fits;
    if (!fits || !this.surface.visible) return;
    const context = this.surface.begin();
    const order = this.#order;
    const { width, height } = this.surface;
    const wide = (width - LEFT) / Math.max(1, order.length);
    const middle = (/** @type {number} */ i) => LEFT + (i + 0.5) * wide;
    if (this.chosen !== null) {
      context.fillStyle = palette.line;
      context.fillRect(middle(order.indexOf(this.chosen)) - Math.max(wide, 3) / 2, 0, Math.max(wide, 3), height);
    }
    paintRanges(context, fits, order, middle, height * RANGES - GAP / 2);
    paintShares(context, fits, order, middle, [height * RANGES + GAP / 2, height - 2], wide);
  }
}

/**
 * @param {CanvasRenderingContext2D} context @param {PoseFitsMessage} fits @param {number[]} order
 * @param {(i: number) => number} middle of a ray's column @param {number} bottom
 */
function paintRanges(context, { ranges, asked, best }, order, middle, bottom) {
  const all = [...ranges, ...asked.expected, ...(best?.expected ?? [])].map((range) => range ?? 0);
  const top = Math.max(0.05, ...all) * 1.08;
  const height = (/** @type {number} */ range) => bottom - (range / top) * (bottom - 10);
  axis(context, [[0, bottom], [top / 1.08, height(top / 1.08)]], (range) => plain(range * 1000));
  /** @param {(number | null)[]} values @param {(u: number, v: number) => void} mark */
  const each = (values, mark) => order.forEach((ray, i) => {
    const range = values[ray];
    if (range !== null && range !== undefined) mark(middle(i), height(range));
  });
  if (best) {
    context.strokeStyle = palette.estimate;
    each(best.expected, (u, v) => dash(context, u, v, 1.5));
  }
  context.strokeStyle = palette.text;
  each(asked.expected, (u, v) => dash(context, u, v, 2.5));
  context.fillStyle = palette.rays;
  each(ranges, (u, v) => {
    context.beginPath();
    context.arc(u, v, 1.8, 0, 2 * Math.PI);
    context.fill();
  });
}

/** @param {CanvasRenderingContext2D} context @param {number} u @param {number} v @param {number} width */
function dash(context, u, v, width) {
  context.lineWidth = width;
  context.beginPath();
  context.moveTo(u - 3, v);
  context.lineTo(u + 3, v);
  context.stroke();
}

/**
 * @param {CanvasRenderingContext2D} context @param {PoseFitsMessage} fits @param {number[]} order
 * @param {(i: number) => number} middle @param {[number, number]} rows top and bottom @param {number} wide
 */
function paintShares(context, { asked, best }, order, middle, [top, bottom], wide) {
  const shares = [...(asked.shares ?? []), ...(best?.shares ?? [])].map((share) => share ?? 0);
  const [low, high] = [Math.min(-0.5, ...shares), Math.max(0, ...shares)];
  const height = (/** @type {number} */ share) => top + ((high - share) / (high - low)) * (bottom - top);
  axis(context, [[0, height(0)], [low, height(low)]], (share) => plain(share, 1));
  const half = Math.max(1, wide * 0.4);
  /** @param {PoseFitMessage | null} fit @param {string} colour @param {number} shift */
  const bars = (fit, colour, shift) => {
    context.fillStyle = colour;
    order.forEach((ray, i) => {
      const share = fit?.shares?.[ray];
      if (share === null || share === undefined) return;
      const [from, to] = [height(0), height(share)];
      context.fillRect(middle(i) + shift, Math.min(from, to), half, Math.max(0.5, Math.abs(to - from)));
    });
  };
  bars(asked, palette.text, -half);
  bars(best, palette.estimate, 0);
}

/**
 * @param {CanvasRenderingContext2D} context @param {[number, number][]} marks values and heights
 * @param {(value: number) => string} words
 */
function axis(context, marks, words) {
  context.font = `${palette.fontSize * 0.85}px system-ui, sans-serif`;
  context.fillStyle = palette.quiet;
  context.textAlign = "right";
  context.textBaseline = "middle";
  for (const [value, v] of marks) context.fillText(words(value), LEFT - 4, Math.min(context.canvas.clientHeight - 6, Math.max(6, v)));
  context.strokeStyle = palette.line;
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(LEFT, marks[0][1]);
  context.lineTo(context.canvas.clientWidth, marks[0][1]);
  context.stroke();
}

/** One ray in words. @param {PoseFitsMessage} fits @param {number} ray */
function told(fits, ray) {
  const { asked, ranges } = fits;
  const share = asked.shares?.[ray] ?? null;
  const values = {
    bearing: degrees(fits.bearings[ray]),
    expected: asked.expected[ray] === null ? t("no tape") : millimetres(asked.expected[ray]),
    measured: ranges[ray] === null ? t("none") : millimetres(ranges[ray]),
  };
  const words = t("Ray at {bearing}: expected {expected}, measured {measured}.", values);
  if (share === null) return `${words} ${t("It does not count.")}`;
  const own = t("Its share is {share}", { share: plain(share, 2) });
  const other = fits.best?.shares?.[ray];
  return `${words} ${own}${other === null || other === undefined ? "" : t(", of the estimate's {share}", { share: plain(other, 2) })}.`;
}

/** The ray that tells most against the pose. @param {PoseFitsMessage} fits */
function worst(fits) {
  const shares = fits.asked.shares ?? [];
  const against = shares.map((share, ray) => (share ?? 0) - (fits.best?.shares?.[ray] ?? 0));
  const least = Math.min(0, ...against);
  return least < -0.05 ? `${t("Most against it:")} ${told(fits, against.indexOf(least))}` : "";
}
