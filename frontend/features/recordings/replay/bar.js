// @ts-check
import { t } from "../../../page/language.js";
import { find, findButton, findInput, setText } from "../../../page/elements.js";
import { minutes, plain } from "../../../page/format.js";

/** @typedef {import("../../../messages").Command} Command */
/** @typedef {import("../../../messages").ReplayMessage} ReplayMessage */
/** @typedef {Omit<Extract<Command, {type: "replay"}>, "type" | "id">} Wish */

/** Shortest interval between seeks while the slider is dragged [ms]. */
const SCRUB_MS = 80;
/** After the last touch the slider keeps its position this long [ms], until the answer comes. */
const SETTLED_MS = 600;

/** The bar of a replay: pause, steps by picture, time and speed. */
export class ReplayBar {
  /** Whether this is a replay. */
  shown = false;
  #play = findButton("replay-play");
  #slider = findInput("replay-position");
  #time = find("replay-time", HTMLElement);
  #state = find("replay-state", HTMLElement);
  #speed = find("replay-speed", HTMLSelectElement);
  /** @type {ReplayMessage | null} */
  #now = null;
  /** Whether the replay played before the slider was held; null while nobody holds it. */
  /** @type {boolean | null} */
  #played = null;
  #stamp = 0;
  #touched = -Infinity;
  #sent = -Infinity;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #timer;

  /** @param {(command: Command) => Promise<boolean>} order sends; tells whether it was accepted */
  constructor(order) {
    this.order = order;
    this.#play.onclick = () => this.toggle();
    findButton("replay-back").onclick = () => this.step(-1);
    findButton("replay-on").onclick = () => this.step(1);
    this.#speed.onchange = () => this.#ask({ speed: Number(this.#speed.value) });
    this.#slider.addEventListener("input", () => this.#scrub());
    this.#slider.addEventListener("change", () => this.#release());
  }

  /**
   * @param {ReplayMessage | null} replay
   * @param {number} stamp the robot's clock then [s]
   * @returns {boolean} whether a replay has begun or ended
   */
  show(replay, stamp) {
    this.#stamp = stamp;
    const changed = this.shown !== (replay !== null);
    this.shown = replay !== null;
    this.#now = replay;
    if (replay) this.#write(replay);
    return changed;
  }

  /** Play or pause. */
  toggle() {
    if (this.#now) this.#ask({ paused: !this.#now.paused });
  }

  /** Go to a time of the robot's clock. @param {number} stamp [s] */
  seek(stamp) {
    if (this.#now) this.#ask({ position_s: Math.max(0, this.#now.position_s + stamp - this.#stamp) });
  }

  /** @param {number} pictures forward, or back if negative */
  step(pictures) {
    this.#ask({ step: pictures });
  }

  /** @param {ReplayMessage} replay */
  #write({ position_s, duration_s, speed, paused, catching_up, file }) {
    if (Number(this.#slider.max) !== duration_s) this.#slider.max = String(duration_s);
    const held = performance.now() - this.#touched < SETTLED_MS || this.#played !== null;
    if (!held) this.#slider.value = String(position_s);
    const at = held ? this.#slider.valueAsNumber : position_s;
    const text = `${clock(at)} / ${clock(duration_s)}`;
    setText(this.#time, text);
    this.#slider.setAttribute("aria-valuetext", t("{time} of {whole} seconds", { time: plain(at, 1), whole: plain(duration_s, 1) }));
    setText(this.#play, paused && this.#played !== true ? t("Play") : t("Pause"));
    const way = typeof catching_up === "number";
    setText(this.#state, way ? t("the filter follows: {share} %", { share: plain(100 * catching_up) }) : "");
    this.#slider.title = file;
    this.#writeSpeed(speed);
  }

  /** @param {number} speed which may be missing among the options */
  #writeSpeed(speed) {
    const value = String(speed);
    if (document.activeElement === this.#speed || this.#speed.value === value) return;
    if (![...this.#speed.options].some((option) => option.value === value)) {
      this.#speed.add(new Option(`${value} ×`, value));
    }
    this.#speed.value = value;
  }

  /** Pause while the slider moves, and seek its position at a limited rate. */
  #scrub() {
    this.#played ??= this.#now ? !this.#now.paused : false;
    this.#touched = performance.now();
    clearTimeout(this.#timer);
    const wait = this.#sent + SCRUB_MS - performance.now();
    if (wait > 0) this.#timer = setTimeout(() => this.#goThere(), wait);
    else this.#goThere();
    if (this.#now) this.#write(this.#now);
  }

  #goThere() {
    this.#sent = performance.now();
    this.#ask({ position_s: this.#slider.valueAsNumber, paused: true });
  }

  /** Seek the position where the slider was released, and play on if it played before. */
  #release() {
    clearTimeout(this.#timer);
    const paused = this.#played !== true;
    this.#played = null;
    this.#touched = performance.now();
    this.#ask({ position_s: this.#slider.valueAsNumber, paused });
  }

  /** @param {Wish} wish */
  #ask(wish) {
    return this.order({ type: "replay", ...wish });
  }
}

/** @param {number} seconds shown with tenths, as pictures are less than a second apart */
function clock(seconds) {
  const tenths = Math.floor(seconds * 10 + 1e-6) / 10;
  return `${minutes(tenths)}.${Math.floor(tenths * 10 + 1e-6) % 10}`;
}
