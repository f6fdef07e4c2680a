// @ts-check
/** @typedef {import("../messages").Command} Command */
/** @typedef {{forward: number, turn: number}} Stick each from -1 to 1; turning left is positive */

/** A drive command holds for 0.5 s on the robot; so often it is renewed [ms]. */
const RENEW_MS = 50;
/** A stick that moves is told at once, but not oftener than this [ms]. */
const SOONEST_MS = 25;
const FIGURE_EIGHT_MS = 100;
/** Turning at full stick [rad/s] for each m/s of the chosen speed. */
const TURN_PER_SPEED = 8;

/**
 * What people want of the wheels, from all inputs together, renewed while they want it.
 *
 * Nothing is sent without an input that is held: when this page dies, the robot stops by itself.
 */
export class Drive {
  speed = 0.15;
  maxV = 0.15;
  maxOmega = 1;
  figureEight = false;
  /** A recording cannot be driven. */
  possible = true;
  /** @type {Map<string, Stick>} */
  #sticks = new Map();
  /** @type {ReturnType<typeof setInterval> | undefined} */
  #timer;
  #sent = -Infinity;
  /** @type {Set<() => void>} */
  #stopListeners = new Set();

  /**
   * @param {(command: Command) => void} send
   * @param {() => void} changed called when what drives changes
   */
  constructor(send, changed) {
    this.send = send;
    this.changed = changed;
    addEventListener("pagehide", () => this.stop());
    document.addEventListener("visibilitychange", () => document.hidden && this.#leave());
    addEventListener("blur", () => this.release());
  }

  /** Inputs that are held forget it when this is called. @param {() => void} listener */
  onStop(listener) {
    this.#stopListeners.add(listener);
  }

  /** @param {string} source which input @param {Stick | null} stick null when it is let go */
  hold(source, stick) {
    if (!this.possible || (!stick && !this.#sticks.has(source))) return;
    if (stick) this.#sticks.set(source, stick);
    else this.#sticks.delete(source);
    this.figureEight = false;
    if (this.#sticks.size > 0) return this.#run();
    this.#rest();
    this.send({ type: "stop" });
  }

  /** Stand still at once, whatever drives; held inputs count again only when pressed anew. */
  stop() {
    if (!this.possible) return;
    this.#forget();
    this.send({ type: "stop" });
  }

  /** Nobody holds anything any more, as far as we can know; the figure-eight goes on. */
  release() {
    if (this.#sticks.size > 0) this.stop();
  }

  /** The line is gone: send nothing, start nothing by itself when it is back. */
  disconnect() {
    this.#forget();
  }

  /** @param {boolean} active */
  setFigureEight(active) {
    if (!this.possible) return;
    if (!active) return this.stop();
    this.#forget();
    this.figureEight = true;
    this.#run();
  }

  /** @returns {Stick} all inputs added up */
  get stick() {
    const sum = { forward: 0, turn: 0 };
    for (const { forward, turn } of this.#sticks.values()) {
      sum.forward += forward;
      sum.turn += turn;
    }
    return { forward: clamp(sum.forward), turn: clamp(sum.turn) };
  }

  #leave() {
    if (this.#timer !== undefined) this.stop();
  }

  #forget() {
    this.#sticks.clear();
    this.figureEight = false;
    this.#rest();
    for (const listener of this.#stopListeners) listener();
  }

  #rest() {
    clearInterval(this.#timer);
    this.#timer = undefined;
    this.changed();
  }

  #run() {
    this.changed();
    if (this.#timer === undefined) this.#timer = setInterval(() => this.#renew(), RENEW_MS);
    if (performance.now() - this.#sent < SOONEST_MS) return;
    this.#renew();
  }

  #renew() {
    const now = performance.now();
    // Half a turn of the timer early is on time.
    if (this.figureEight && now - this.#sent < FIGURE_EIGHT_MS - RENEW_MS / 2) return;
    this.#sent = now;
    this.send(this.figureEight ? { type: "figure_eight" } : this.#command());
  }

  /** @returns {Command} */
  #command() {
    const { forward, turn } = this.stick;
    const omega = Math.min(this.maxOmega, TURN_PER_SPEED * this.speed);
    return { type: "drive", v: forward * Math.min(this.speed, this.maxV), omega: turn * omega };
  }
}

/** @param {number} value */
const clamp = (value) => Math.min(1, Math.max(-1, value));
