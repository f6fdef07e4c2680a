// @ts-check
import { find, findButton, make, setText } from "../page/elements.js";
import { plain } from "../page/format.js";
import { palette } from "../page/palette.js";
import { Surface } from "../page/surface.js";
import { Tabs } from "../page/tabs.js";
import { drawChart } from "./chart.js";
import { SPAN_S } from "./history.js";
import { roundUp } from "./scale.js";

/** @typedef {import("../page/draw_loop.js").DrawLoop} DrawLoop */
/** @typedef {import("../page/palette.js").ColourName} ColourName */
/** @typedef {import("./history.js").History} History */
/** @typedef {import("./history.js").Quantity} Quantity */
/**
 * @typedef {{quantity: Quantity, name: string, unit: string, role: ColourName, dash: number[],
 *   digits: number, replayed?: boolean}} Line replayed: only shown in a replay
 */

/** @type {Record<string, {label: string, floor: number, lines: Line[]}>} */
const PLOTS = {
  error: {
    label: "mm",
    floor: 10,
    lines: [
      {
        quantity: "estimateError",
        name: "estimate",
        unit: "mm",
        role: "estimate",
        dash: [],
        digits: 1,
      },
      {
        quantity: "odometryError",
        name: "odometry",
        unit: "mm",
        role: "odometry",
        dash: [7, 4],
        digits: 1,
      },
      {
        quantity: "thenError",
        name: "estimated then",
        unit: "mm",
        role: "then",
        dash: [9, 3, 2, 3],
        digits: 1,
        replayed: true,
      },
    ],
  },
  particles: {
    label: "particles",
    floor: 100,
    lines: [
      { quantity: "effective", name: "effective", unit: "", role: "estimate", dash: [], digits: 0 },
      { quantity: "count", name: "all", unit: "", role: "quiet", dash: [7, 4], digits: 0 },
    ],
  },
  timing: {
    label: "Hz and ms",
    floor: 20,
    lines: [
      { quantity: "loop", name: "loop", unit: "Hz", role: "truth", dash: [], digits: 0 },
      { quantity: "delay", name: "delay", unit: "ms", role: "odometry", dash: [7, 4], digits: 0 },
    ],
  },
};
/** The lowest value of a logarithmic axis [mm]. */
const LOG_FLOOR = 0.1;

/**
 * Plots of the last half minute, one group of numbers at a time; shows the values under the
 * pointer.
 */
export class PlotsPanel {
  #legend = find("plots-legend", HTMLElement);
  #readout = find("plots-readout", HTMLElement);
  #text = find("plots-text", HTMLElement);
  #log = findButton("plots-log");
  #shown = "error";
  #replayed = false;
  /** @type {number | null} age whose values are shown [s], negative */
  #cursor = null;
  /** @type {import("./scale.js").Scale | null} */
  #x = null;

  /** @param {DrawLoop} loop @param {History} history */
  constructor(loop, history) {
    this.history = history;
    const canvas = find("plots-canvas", HTMLCanvasElement);
    this.surface = new Surface(canvas, () => this.refresh?.());
    const visible = () => this.surface.visible;
    this.refresh = loop.add(() => this.#paint(), { visible, hertz: 10 });
    this.tabs = new Tabs(find("plots-tabs", HTMLElement), (name) => this.#choose(name));
    this.tabs.select(this.#shown);
    this.#log.onclick = () => this.#toggleLog();
    canvas.addEventListener("pointermove", (event) => this.#point(this.surface.locate(event)[0]));
    canvas.addEventListener("pointerleave", () => this.#read(null));
    canvas.addEventListener("blur", () => this.#read(null));
    canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  /** Without the truth there is no error to plot: show particles instead. @param {boolean} known */
  setTruth(known) {
    if (known !== (this.#shown === "error")) this.tabs.select(known ? "error" : "particles");
  }

  /** A replay also has the recorded estimate. @param {boolean} replayed */
  setReplay(replayed) {
    this.#replayed = replayed;
    this.#choose(this.#shown);
  }

  /** Describe the plot in words for screen readers; called now and then. */
  describe() {
    const sentences = this.#lines.map((line) => this.#sentence(line));
    setText(this.#text, `Last ${SPAN_S} seconds. ${sentences.join(" ")}`);
  }

  get #lines() {
    return PLOTS[this.#shown].lines.filter(({ replayed }) => this.#replayed || !replayed);
  }

  get #isLog() {
    return this.#shown === "error" && this.#log.getAttribute("aria-pressed") === "true";
  }

  /** @param {string} name */
  #choose(name) {
    this.#shown = name;
    this.#log.hidden = name !== "error";
    this.#legend.replaceChildren(
      ...this.#lines.map(({ role, name: words }) =>
        make("li", {}, make("span", { class: `swatch ${role}` }), `${words} `, make("b", {})),
      ),
    );
    this.refresh();
  }

  #toggleLog() {
    this.#log.setAttribute("aria-pressed", String(!this.#isLog));
    this.refresh();
  }

  #paint() {
    const xs = this.history.ages();
    const series = this.#lines.map(({ quantity, role, dash }) => {
      return { colour: palette[role], dash, xs, ys: this.history.values[quantity] };
    });
    const high = roundUp(
      Math.max(PLOTS[this.#shown].floor, ...series.flatMap(({ ys }) => ys.filter(Number.isFinite))),
    );
    this.#x = drawChart(this.surface, {
      x: { low: -SPAN_S, high: 0, label: "seconds" },
      y: {
        low: this.#isLog ? LOG_FLOOR : 0,
        high,
        label: PLOTS[this.#shown].label,
        log: this.#isLog,
      },
      series,
      cursor: this.#cursor,
    });
    this.#write();
  }

  /** Write the values beside the names: the newest ones, or those under the pointer. */
  #write() {
    const { stamps, values } = this.history;
    const at = this.#cursor === null ? stamps.length - 1 : this.history.nearest(this.#cursor);
    this.#lines.forEach(({ quantity, unit, digits }, i) => {
      const value = values[quantity][at];
      const text = Number.isFinite(value) ? `${plain(value, digits)} ${unit}` : "–";
      setText(this.#legend.children[i].getElementsByTagName("b")[0], text);
    });
    setText(
      this.#readout,
      this.#cursor === null ? "last 30 s" : `${plain(-this.#cursor, 1)} s ago`,
    );
  }

  /** @param {number} pixel */
  #point(pixel) {
    if (this.#x) this.#read(this.#x.value(pixel));
  }

  /** @param {number | null} age */
  #read(age) {
    this.#cursor = age === null ? null : Math.min(0, Math.max(-SPAN_S, age));
    this.refresh();
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const step = { ArrowLeft: -0.5, ArrowRight: 0.5 }[event.key];
    if (!step) return;
    this.#read((this.#cursor ?? 0) + step);
    event.preventDefault();
  }

  /** @param {Line} line */
  #sentence({ quantity, name, unit, digits }) {
    const known = this.history.values[quantity].filter(Number.isFinite);
    if (known.length === 0) return `${name}: not known.`;
    const [low, high, now] = [Math.min(...known), Math.max(...known), known[known.length - 1]];
    const range = `${plain(low, digits)} to ${plain(high, digits)}`;
    return `${name}: now ${plain(now, digits)} ${unit}, between ${range}.`;
  }
}
