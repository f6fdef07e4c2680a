// @ts-check
import { t, translated } from "../page/language.js";
import { drawChart } from "../plots/chart.js";
import { find, findButton, setText } from "../page/elements.js";
import { degrees, millimetres } from "../page/format.js";
import { palette } from "../page/palette.js";
import { Surface } from "../page/surface.js";
import { sentence } from "../page/toasts.js";
import { getJson } from "../wire/http.js";

/** @typedef {import("../messages").ProfileMessage} ProfileMessage */
/** @typedef {import("../page/draw_loop.js").DrawLoop} DrawLoop */

const EVERY_MS = 250;

/** Profile of one ray: brightness, the edge kernel's response, and why the ray counted or not. */
export class RayProfile {
  #box = find("profile", HTMLElement);
  #title = find("profile-title", HTMLElement);
  #words = find("profile-text", HTMLElement);
  /** @type {ProfileMessage | null} */
  #profile = null;
  /** @type {ReturnType<typeof setInterval> | undefined} */
  #timer;
  #asking = false;
  /** @type {number | null} the ray that is shown */
  ray = null;
  /** How many rays there are. */
  count = 0;

  /** @param {DrawLoop} loop @param {() => void} changed called when another ray is chosen */
  constructor(loop, changed) {
    this.changed = changed;
    this.surface = new Surface(find("profile-canvas", HTMLCanvasElement), () => this.refresh?.());
    this.refresh = loop.add(() => this.#paint(), { visible: () => this.surface.visible });
    findButton("profile-close").onclick = () => this.close();
    findButton("profile-left").onclick = () => this.step(-1);
    findButton("profile-right").onclick = () => this.step(1);
  }

  /** @param {number} ray */
  open(ray) {
    this.ray = ray;
    this.#box.hidden = false;
    clearInterval(this.#timer);
    this.#timer = setInterval(() => this.#ask(), EVERY_MS);
    this.#ask();
    this.changed();
  }

  close() {
    this.ray = null;
    this.#profile = null;
    this.#box.hidden = true;
    clearInterval(this.#timer);
    this.changed();
  }

  /** @param {number} step to the neighbouring ray */
  step(step) {
    if (this.count === 0) return;
    this.open(((this.ray ?? -Math.sign(step)) + step + this.count) % this.count);
  }

  async #ask() {
    if (this.#asking || document.hidden || !this.surface.canvas.checkVisibility()) return;
    this.#asking = true;
    try {
      /** @type {ProfileMessage} */
      const profile = await getJson(`api/ray/${this.ray}`);
      if (profile.ray === this.ray) this.#show(profile);
    } catch (error) {
      setText(this.#words, t("No profile: {error}", { error: sentence(error) }));
    } finally {
      this.#asking = false;
    }
  }

  /** @param {ProfileMessage} profile */
  #show(profile) {
    this.#profile = profile;
    setText(this.#title, t("Ray {number} of {count}, {direction}", { number: profile.ray + 1, count: this.count, direction: direction(profile.bearing) }));
    const why = translated(profile.why);
    const verdict = profile.counted ? why : t("Not counted: {why}", { why });
    setText(this.#words, `${edges(profile)} ${verdict}`);
    this.refresh();
  }

  #paint() {
    const profile = this.#profile;
    if (!profile) return;
    const mm = profile.distances.map((distance) => distance * 1000);
    const reach = Math.max(...profile.response.map(Math.abs), profile.threshold) * 1.1;
    const marks = [
      { at: profile.entry, label: t("in") },
      { at: profile.exit, label: t("out") },
    ];
    drawChart(this.surface, {
      x: { low: mm[0] ?? 0, high: mm.at(-1) ?? 1, label: "mm" },
      y: { low: -reach, high: Math.max(255, reach), label: t("grey levels") },
      series: [
        { colour: palette.text, dash: [], xs: mm, ys: profile.grey },
        { colour: palette.rays, dash: [5, 3], xs: mm, ys: profile.response },
      ],
      levels: [profile.threshold, -profile.threshold],
      marks: marks.flatMap(({ at, label }) => (at === null ? [] : [{ at: at * 1000, label }])),
    });
  }
}

/** @param {number} bearing [rad] */
function direction(bearing) {
  const angle = degrees(Math.abs(bearing));
  if (angle === "0°") return t("straight ahead");
  return bearing > 0 ? t("{angle} to the left", { angle }) : t("{angle} to the right", { angle });
}

/** @param {ProfileMessage} profile */
function edges({ entry, exit, width }) {
  if (entry === null) return t("No edge.");
  return t("In at {entry}, out at {exit}, {width} wide at right angles to the edge.", {
    entry: millimetres(entry),
    exit: millimetres(exit),
    width: millimetres(width, 1),
  });
}
