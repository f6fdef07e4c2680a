// @ts-check
import { find, findButton, make, setText } from "../page/elements.js";
import { plain } from "../page/format.js";
import { t } from "../page/language.js";
import { Surface } from "../page/surface.js";
import { Tabs } from "../page/tabs.js";
import { ValueChooser } from "./chooser.js";
import { PRESETS, QUANTITIES } from "./quantities.js";
import { Span } from "./span.js";
import { drawStack, lookOf } from "./stack.js";

/** @typedef {import("../page/draw_loop.js").DrawLoop} DrawLoop */
/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("./history.js").History} History */

const ZOOM = 1.25;
/** A shorter drag is a click [CSS px]. */
const SHORTEST = 4;

/** Plots of any values over any part of the run; shows the values under the pointer. */
export class PlotsPanel {
  #legend = find("plots-legend", HTMLElement);
  #readout = find("plots-readout", HTMLElement);
  #text = find("plots-text", HTMLElement);
  #log = findButton("plots-log");
  #choice = find("plots-span", HTMLSelectElement);
  #save = find("plots-save", HTMLSelectElement);
  #span = new Span();
  #forces = find("plots-forces", HTMLElement);
  #engineMissing = false;
  #replayed = false;
  /** Names of the values that are shown. @type {string[]} */
  #shown = PRESETS.error;
  /** @type {number | null} stamp whose values are shown [s] */
  #cursor = null;
  /** @type {import("./scale.js").Scale | null} */
  #x = null;
  /** Where the pointer was pressed and last seen [CSS px]. @type {{from: number, last: number} | null} */
  #drag = null;

  /**
   * @param {DrawLoop} loop @param {History} history
   * @param {(stamp: number) => void} seek goes to a time of a replay
   */
  constructor(loop, history, seek) {
    this.history = history;
    this.seek = seek;
    const canvas = find("plots-canvas", HTMLCanvasElement);
    this.surface = new Surface(canvas, () => this.refresh?.());
    const visible = () => this.surface.visible;
    this.refresh = loop.add(() => this.#paint(), { visible, hertz: 10 });
    this.chooser = new ValueChooser((names) => this.#show(names));
    this.tabs = new Tabs(find("plots-tabs", HTMLElement), (name) => this.#preset(name));
    this.tabs.select("error");
    this.#log.onclick = () => this.#toggleLog();
    this.#choice.onchange = () => this.#follow(Number(this.#choice.value));
    this.#save.onchange = async () => {
      const kind = this.#save.value;
      this.#save.value = "";
      const { savePlot } = await import("./saving.js");
      savePlot(kind, this.plot);
    };
    this.#wire(canvas);
  }

  /** How much of the run is shown [s]; 0 is all of it. */
  get seconds() {
    return Number.isFinite(this.#span.seconds) ? this.#span.seconds : 0;
  }

  /** What is drawn now, for any size. @returns {import("./stack.js").Plot} */
  get plot() {
    const names = this.#shown.filter((name) => this.#replayed || name !== "thenError");
    return { history: this.history, names, span: this.#span, log: this.#isLog, cursor: this.#cursor };
  }

  /** Without the truth there is no error to plot: show how sure the estimate is. @param {boolean} known */
  setTruth(known) {
    if (known !== this.#shown.includes("estimateError")) this.tabs.select(known ? "error" : "bound");
  }

  /** Odometry says less of a robot that moves without forces. @param {FieldMessage} field */
  setField({ engine_missing }) {
    this.#engineMissing = engine_missing;
    this.#show(this.#shown);
  }

  /** A replay also has the recorded estimate. @param {boolean} replayed */
  setReplay(replayed) {
    this.#replayed = replayed;
    if (this.#shown === PRESETS.error || this.#shown === PRESETS.replay) this.#preset("error");
    else this.#show(this.#shown);
  }

  /** Describe the plot in words for screen readers; called now and then. */
  describe() {
    setText(this.#text, this.plot.names.map((name) => this.#sentence(name)).join(" "));
  }

  get #isLog() {
    return this.#log.getAttribute("aria-pressed") === "true";
  }

  /** @param {HTMLCanvasElement} canvas */
  #wire(canvas) {
    canvas.addEventListener("pointerdown", (event) => this.#press(event));
    canvas.addEventListener("pointermove", (event) => this.#move(event));
    canvas.addEventListener("pointerup", () => this.#release());
    canvas.addEventListener("pointerleave", () => this.#read(null));
    canvas.addEventListener("blur", () => this.#read(null));
    canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    canvas.addEventListener("dblclick", () => this.#follow(Number(this.#choice.value)));
    canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  /** @param {string} name */
  #preset(name) {
    const names = PRESETS[this.#replayed && name === "error" ? "replay" : name];
    this.chooser?.choose(names);
    this.#show(names);
  }

  /** @param {string[]} names */
  #show(names) {
    this.#shown = names;
    this.#forces.hidden = !this.#engineMissing || !names.some((name) => name.startsWith("odometry"));
    const lines = this.plot.names.map((name, i) => {
      const { colour, dash } = lookOf(name, i);
      const swatch = make("span", { class: "swatch line", style: `color: ${colour}` });
      swatch.dataset.dashed = String(dash.length > 0);
      const label = `${QUANTITIES[name].name} `;
      const off = make("button", { type: "button", title: t("Plot it no more; values lists all") }, swatch, label, make("b", {}));
      off.onclick = () => this.#leaveOut(name);
      return make("li", {}, off);
    });
    this.#legend.replaceChildren(...lines);
    this.refresh();
  }

  /** The scale is that of what is left. @param {string} name */
  #leaveOut(name) {
    const left = this.#shown.filter((each) => each !== name);
    if (left.length === 0) return;
    this.chooser.choose(left);
    this.#show(left);
  }

  #toggleLog() {
    this.#log.setAttribute("aria-pressed", String(!this.#isLog));
    this.refresh();
  }

  /** Show the newest part of the run. @param {number} seconds 0 is all of it */
  #follow(seconds) {
    this.#span.follow(seconds || Infinity);
    this.refresh();
  }

  #paint() {
    const context = this.surface.begin();
    this.#x = drawStack(context, this.plot, this.surface.width, this.surface.height);
    this.#write();
  }

  /** Write the values beside the names: the newest ones, or those under the pointer. */
  #write() {
    const { stamps, values } = this.history;
    const newest = stamps.at(-1) ?? 0;
    const stamp = this.#cursor ?? this.#span.end ?? newest;
    const at = this.history.nearest(stamp);
    this.plot.names.forEach((name, i) => {
      const { unit, digits } = QUANTITIES[name];
      const value = values[name][at];
      const text = Number.isFinite(value) ? `${plain(value, digits)} ${unit}` : "–";
      setText(this.#legend.children[i].getElementsByTagName("b")[0], text);
    });
    const ago = newest - stamp;
    setText(this.#readout, ago < 0.05 ? "" : t("{seconds} s ago", { seconds: plain(ago, 1) }));
  }

  /** @param {PointerEvent} event */
  #press(event) {
    const [x] = this.surface.locate(event);
    this.#drag = { from: x, last: x };
    this.surface.canvas.setPointerCapture(event.pointerId);
  }

  /** @param {PointerEvent} event */
  #move(event) {
    const [x] = this.surface.locate(event);
    if (this.#x === null) return;
    if (this.#drag && Math.abs(x - this.#drag.from) > SHORTEST) {
      this.#span.pan(this.history.stamps, this.#x.value(this.#drag.last) - this.#x.value(x));
    }
    if (this.#drag) this.#drag.last = x;
    this.#read(this.#x.value(x));
  }

  /** A click goes to that time of a replay. */
  #release() {
    const drag = this.#drag;
    this.#drag = null;
    if (drag && this.#x && this.#replayed && Math.abs(drag.last - drag.from) <= SHORTEST) {
      this.seek(this.#x.value(drag.last));
    }
  }

  /** @param {WheelEvent} event */
  #wheel(event) {
    event.preventDefault();
    if (this.#x) this.#zoom(event.deltaY > 0 ? ZOOM : 1 / ZOOM, this.#x.value(this.surface.locate(event)[0]));
  }

  /** @param {number} factor @param {number} [stamp] */
  #zoom(factor, stamp) {
    const [, high] = this.#span.ends(this.history.stamps);
    this.#span.zoom(this.history.stamps, factor, stamp ?? high);
    this.refresh();
  }

  /** @param {number | null} stamp */
  #read(stamp) {
    this.#cursor = stamp;
    this.refresh();
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const [low, high] = this.#span.ends(this.history.stamps);
    const last = Math.min(high, this.history.stamps.at(-1) ?? 0);
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (step && event.shiftKey) this.#span.pan(this.history.stamps, (step * (high - low)) / 10);
    else if (step) this.#read(Math.min(last, Math.max(low, (this.#cursor ?? last) + (step * (high - low)) / 60)));
    else if (event.key === "+") this.#zoom(1 / ZOOM);
    else if (event.key === "-") this.#zoom(ZOOM);
    else if (event.key === "0") this.#follow(Number(this.#choice.value));
    else return;
    event.preventDefault();
    this.refresh();
  }

  /** @param {string} quantity */
  #sentence(quantity) {
    const { name, unit, digits } = QUANTITIES[quantity];
    const [low, high] = this.#span.ends(this.history.stamps);
    const part = this.history.values[quantity].slice(this.history.after(low), this.history.after(high) + 1);
    const known = part.filter(Number.isFinite);
    if (known.length === 0) return t("{name}: not known.", { name });
    return t("{name}: now {now} {unit}, between {low} and {high}.", {
      name,
      unit,
      now: plain(known[known.length - 1], digits),
      low: plain(Math.min(...known), digits),
      high: plain(Math.max(...known), digits),
    });
  }
}
