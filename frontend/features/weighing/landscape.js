// @ts-check
import { stroke } from "../../map/drawing.js";
import { t } from "../../page/language.js";
import { make, setText } from "../../page/elements.js";
import { degrees, millimetres, plain } from "../../page/format.js";
import { palette } from "../../page/palette.js";
import { sentence } from "../../page/toasts.js";
import { getJson } from "../../wire/http.js";
import { powerOfTen } from "./powers.js";

/** @typedef {import("../../messages").HeadingsMessage} HeadingsMessage */
/** @typedef {import("../../messages").LandscapeMessage} LandscapeMessage */
/** @typedef {import("../../messages").PoseMessage} PoseMessage */
/** @typedef {import("../../map/view.js").MapView} MapView */

/** Shortest time between two landscapes [ms]. */
const AGAIN_MS = 1000;
/** A slow model gets so many times longer a pause [ms/s]: the robot shall have the processor. */
const PAUSE = 5000;
/** Colours from the least to the most likely, ever darker: they differ in every kind of sight. */
const COLOURS = [
  [255, 240, 170, 0],
  [250, 200, 110, 120],
  [225, 130, 100, 190],
  [160, 60, 120, 215],
  [80, 25, 110, 225],
  [25, 10, 50, 235],
];
/** Ring of headings around a pose: from how far, and how far out [CSS px]. */
const RING = 62;
const RING_HIGH = 34;
const TEN = Math.LN10;

/** How likely the scan is all over the field at a heading, and in all directions at the pose asked. */
export class LandscapeSection {
  /** @type {LandscapeMessage | null} */
  #land = null;
  /** @type {HeadingsMessage | null} */
  #ring = null;
  /** @type {HTMLCanvasElement | null} */
  #picture = null;
  #asked = 0;
  #asking = false;
  #words = make("p", { role: "status" });
  #switch = make("button", { type: "button", "aria-pressed": "false", title: t("Shade the field by how likely the newest scan is there") }, t("show"));
  #scale = make("ul", { class: "scale", "aria-label": t("Weight, against the best place") });
  element = make(
    "section",
    { class: "landscape", "aria-labelledby": "landscape-title" },
    make("div", { class: "aside-bar" }, make("h4", { id: "landscape-title" }, t("Likelihood of the scan")), this.#switch),
    this.#scale,
    this.#words,
  );

  /** @param {() => PoseMessage | null} pose that is asked @param {() => void} changed */
  constructor(pose, changed) {
    this.pose = pose;
    this.changed = changed;
    this.#switch.onclick = () => this.show(!this.shown);
    this.show(false);
  }

  get shown() {
    return this.#switch.getAttribute("aria-pressed") === "true";
  }

  /** @param {boolean} shown */
  show(shown) {
    this.#switch.setAttribute("aria-pressed", String(shown));
    this.#scale.hidden = true;
    this.#land = this.#ring = this.#picture = null;
    setText(this.#words, shown ? "" : t("How well the newest scan fits all over the field, at the heading of the particle asked, or of the estimate."));
    if (shown) this.#ask();
    this.changed();
  }

  follow() {
    if (this.shown && performance.now() - this.#asked > AGAIN_MS + PAUSE * (this.#land?.seconds ?? 0)) this.#ask();
  }

  async #ask() {
    if (this.#asking) return;
    this.#asking = true;
    const pose = this.pose();
    try {
      /** @type {LandscapeMessage} */
      const land = await getJson(pose ? `api/likelihood?theta=${pose.theta}` : "api/likelihood");
      /** @type {HeadingsMessage | null} */
      const ring = pose ? await getJson(`api/likelihood/headings?x=${pose.x}&y=${pose.y}`) : null;
      if (this.shown) this.#take(land, ring);
    } catch (error) {
      if (this.shown) setText(this.#words, sentence(error));
    } finally {
      this.#asking = false;
      this.#asked = performance.now();
    }
  }

  /** @param {LandscapeMessage} land @param {HeadingsMessage | null} ring */
  #take(land, ring) {
    this.#land = land;
    this.#ring = ring;
    this.#picture = picture(land);
    this.#legend(land.lowest);
    const best = ring && ring.thetas[ring.logs.indexOf(Math.max(...ring.logs))];
    const around = best === null ? "" : ` ${t("At the pose asked, the heading {heading} fits best.", { heading: degrees(best) })}`;
    setText(
      this.#words,
      `${t("At heading {heading}, {x}, {y} fits best. {model}, cells of {step}, in {seconds} ms.", {
        heading: degrees(land.theta),
        x: millimetres(land.best.x),
        y: millimetres(land.best.y),
        model: land.model,
        step: millimetres(land.step),
        seconds: plain(land.seconds * 1000),
      })}${around}`,
    );
    this.changed();
  }

  /** @param {number} lowest log of the weight */
  #legend(lowest) {
    this.#scale.hidden = false;
    const marks = [0, 1, 2, 3].map((step) => {
      const share = 1 - step / 3;
      const name = step === 0 ? "1" : powerOfTen(((step / 3) * lowest) / TEN);
      const swatch = make("span", { class: "patch" });
      const ink = `rgba(${colour(share).map((part, i) => (i === 3 ? part / 255 : part)).join()})`;
      // On the floor it looks so, in both themes.
      swatch.style.background = `linear-gradient(${ink}, ${ink}), var(--floor)`;
      return make("li", {}, swatch, name);
    });
    this.#scale.replaceChildren(...marks);
  }

  /** Shade the field. @param {CanvasRenderingContext2D} context in CSS pixels @param {MapView} view */
  paint(context, view) {
    if (!this.#land || !this.#picture) return;
    const { x, y, step, columns, rows } = this.#land;
    const [left, top] = view.toScreen(x - step / 2, y + (rows - 0.5) * step);
    context.drawImage(this.#picture, left, top, columns * step * view.scale, rows * step * view.scale);
  }

  /** Draw how likely each heading is, around the pose asked. @param {CanvasRenderingContext2D} context @param {MapView} view */
  paintRing(context, view) {
    const pose = this.pose();
    if (!pose || !this.#ring || !this.#land) return;
    const { thetas, logs } = this.#ring;
    const [u, v] = view.toScreen(pose.x, pose.y);
    const lowest = this.#land.lowest;
    const path = new Path2D();
    thetas.forEach((theta, i) => {
      const radius = RING + RING_HIGH * (1 - Math.min(1, logs[i] / lowest));
      path.lineTo(u + radius * Math.cos(theta), v - radius * Math.sin(theta));
    });
    path.closePath();
    const base = new Path2D();
    base.arc(u, v, RING, 0, 2 * Math.PI);
    stroke(context, base, palette["floor-halo"], 3, 0.7);
    stroke(context, base, palette["floor-draft"], 0.8, 0.8);
    stroke(context, path, palette["floor-halo"], 4, 0.8);
    stroke(context, path, palette["floor-draft"], 1.8, 1);
  }
}

/** @param {number} share 0 to 1, of the way from the least to the most likely @returns {number[]} red, green, blue, alpha */
function colour(share) {
  const place = share * (COLOURS.length - 1);
  const low = Math.min(COLOURS.length - 2, Math.floor(place));
  return COLOURS[low].map((part, i) => Math.round(part + (COLOURS[low + 1][i] - part) * (place - low)));
}

/** One pixel a cell, north up. @param {LandscapeMessage} land */
function picture({ cells, columns, rows }) {
  const canvas = document.createElement("canvas");
  canvas.width = columns;
  canvas.height = rows;
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const image = context.createImageData(columns, rows);
  const table = Array.from({ length: 256 }, (_, value) => colour(value / 255));
  const text = atob(cells);
  for (let i = 0; i < text.length; i++) {
    const row = rows - 1 - Math.floor(i / columns);
    image.data.set(table[text.charCodeAt(i)], 4 * (row * columns + (i % columns)));
  }
  context.putImageData(image, 0, 0);
  return canvas;
}
