// @ts-check
/** @typedef {import("../messages").Command} Command */
/** @typedef {{forward: number, turn: number}} Stick each from -1 to 1; turning left is positive */
/** @typedef {"figure_eight" | "calibrate" | "explore" | "navigate"} Programme what the robot drives by itself */

/** Interval between renewals of a drive command [ms]: four fit into the shortest time-out. */
const RENEW_MS = 50;
/** Shortest interval between commands [ms]; else a moving stick is sent at once. */
const SOONEST_MS = 25;
/** A programme is renewed so often within the time-out of drive commands. */
const RENEWALS = 5;
/** Turning speed at full stick [rad/s] for each m/s of the chosen speed. */
const TURN_PER_SPEED = 8;

/**
 * The drive command from all inputs together, renewed while an input is held.
 *
 * Without a held input nothing is renewed: if this page dies, the robot stops by itself.
 */
export class Drive {
  speed = 0.15;
  maxV = 0.15;
  maxOmega = 1;
  /** How long a command holds that is not renewed [ms]. */
  timeout = 300;
  /** What this page lets the robot drive by itself. @type {Programme | null} */
  programme = null;
  /** A recording cannot be driven, nor may everybody drive. */
  possible = true;
  /** Another page or program that drives; null if none does. @type {string | null} */
  other = null;
  /** @type {Map<string, Stick>} */
  #sticks = new Map();
  /** @type {ReturnType<typeof setInterval> | undefined} */
  #timer;
  #sent = -Infinity;
  /** @type {Set<() => void>} */
  #stopListeners = new Set();

  /**
   * @param {(command: Command) => void} send
   * @param {() => void} changed called when the driving input changes
   */
  constructor(send, changed) {
    this.send = send;
    this.changed = changed;
    addEventListener("pagehide", () => this.#leave());
    document.addEventListener("visibilitychange", () => document.hidden && this.#leave());
    addEventListener("blur", () => this.release());
  }

  /** Call a listener on each stop, to let go of a held input. @param {() => void} listener */
  onStop(listener) {
    this.#stopListeners.add(listener);
  }

  /** @param {string} source which input @param {Stick | null} stick null when it is let go */
  hold(source, stick) {
    if (!this.possible || (stick ? this.other !== null : !this.#sticks.has(source))) return;
    if (stick) this.#sticks.set(source, stick);
    else this.#sticks.delete(source);
    this.programme = null;
    if (this.#sticks.size > 0) return this.#run();
    this.#rest();
    this.#slowDown();
  }

  /** Note who else drives: held inputs of this page then end. @param {string | null} other */
  follow(other) {
    if (other !== null && this.other === null && this.#timer !== undefined) this.#forget();
    this.other = other;
  }

  /** Take the drive from whoever has it. */
  take() {
    this.send({ type: "take" });
  }

  /** Stop at once, whoever drives; held inputs count again only after a new press. */
  stop() {
    if (!this.possible) return;
    this.#forget();
    this.send({ type: "stop" });
  }

  /** Stop if an input is held, as its release may not be seen; a programme continues. */
  release() {
    if (this.#sticks.size > 0) this.#leave();
  }

  /** Forget all inputs, as the connection is lost: driving must not start again by itself. */
  disconnect() {
    this.#forget();
  }

  /** Whether a programme could begin now: this page may drive, and no other one does. */
  get mayBegin() {
    return this.possible && this.other === null;
  }

  /** Start a programme, or end it. @param {Programme | null} programme */
  setProgramme(programme) {
    if (!this.possible || (programme && this.other !== null)) return;
    if (programme === null) return this.#leave();
    this.#forget();
    this.programme = programme;
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

  /** End this page's own driving; unlike a stop, this holds nobody else up. */
  #leave() {
    if (this.#timer === undefined) return;
    this.#forget();
    this.#slowDown();
  }

  #slowDown() {
    if (this.other === null) this.send({ type: "drive", v: 0, omega: 0 });
  }

  #forget() {
    this.#sticks.clear();
    this.programme = null;
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
    if (this.#timer === undefined) {
      // A new press ends a stop that holds.
      this.take();
      this.#timer = setInterval(() => this.#renew(), RENEW_MS);
    }
    if (performance.now() - this.#sent < SOONEST_MS) return;
    this.#renew();
  }

  #renew() {
    const now = performance.now();
    // Half a timer interval early counts as on time.
    if (this.programme && now - this.#sent < this.timeout / RENEWALS - RENEW_MS / 2) return;
    this.#sent = now;
    this.send(this.programme ? this.programmed(this.programme) : this.#command());
  }

  /** The command that drives a programme. @param {Programme} programme */
  programmed(programme) {
    const speed = Math.min(this.speed, this.maxV);
    return programme === "figure_eight" ? { type: programme, speed } : { type: programme };
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
