// @ts-check
/** @typedef {import("../messages").Command} Command */
/** @typedef {{forward: number, turn: number}} Stick each from -1 to 1; turning left is positive */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../wire/connection.js").Connection} Connection */
/** @typedef {"figure_eight" | "calibrate" | "explore" | "navigate"} Programme what the robot drives by itself */
/**
 * @typedef {"hidden" | "away" | "stopped" | "taken"} Why what ended a programme: this page was
 *   hidden; it or its network paused for too long; somebody stopped the robot, or drives it now
 */
/** @typedef {{programme: Programme, why: Why, again: () => void}} Ended a programme that did not end by itself */

/** Interval between renewals of a drive command [ms]: four fit into the shortest time-out. */
const RENEW_MS = 50;
/** Shortest interval between commands [ms]; else a moving stick is sent at once. */
const SOONEST_MS = 25;
/** Telemetry comes five times a second or more: without any for so long, the network has stalled [ms]. */
const SILENT_MS = 400;
/** The robot waits so long for the renewal of a programme: GAP_S of app/engine/driving.py [ms]. */
const WAITS_MS = 5000;
/** The robot hears a page last up to so long before the page sent last [ms]. */
const NOTICED_MS = 2 * SILENT_MS;
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
  /** Starts the programme again, as it was asked for. @type {() => void} */
  again = () => {};
  /** @type {Map<string, Stick>} */
  #sticks = new Map();
  /** @type {ReturnType<typeof setInterval> | undefined} */
  #timer;
  #sent = -Infinity;
  /** @type {Set<() => void>} */
  #stopListeners = new Set();
  /** What the robot drives, as told last. @type {string} */
  #mode = "idle";
  /**
   * After a pause this page first hears how things are, and then goes on: it asks, and the first
   * telemetry after the answer tells. @type {"no" | "lost" | "asked" | "answered"}
   */
  #catchesUp = "no";
  /** When telemetry came last [ms]. */
  #heard = 0;
  /** Whether another page of this browser drives. */
  #elsewhere = false;
  /** @type {(ended: Ended) => void} */
  #tell = () => {};

  /**
   * @param {Connection} connection
   * @param {() => void} changed called when the driving input changes
   */
  constructor(connection, changed) {
    this.connection = connection;
    this.changed = changed;
    addEventListener("pagehide", () => this.#leave());
    document.addEventListener("visibilitychange", () => document.hidden && this.#hide());
    addEventListener("blur", () => this.release());
  }

  /** Call a listener when a programme ends otherwise than by itself or by this page. @param {(ended: Ended) => void} listener */
  onEnded(listener) {
    this.#tell = listener;
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

  /** Note who drives: held inputs of this page end when somebody else does. @param {TelemetryMessage} telemetry */
  follow({ mode, driver: { name, mine, this_page: here, stopped } }) {
    const other = mine ? null : name;
    this.#mode = mode;
    this.#heard = performance.now();
    // Its person went on from another page.
    if (mine && !here && !this.#elsewhere && !this.away) this.#forget();
    this.#elsewhere = mine && !here;
    if (other !== null && this.other === null && this.#timer !== undefined) {
      if (this.programme) this.endBy("taken");
      else this.#forget();
    }
    this.other = other;
    if (this.#catchesUp === "answered") this.#goOn(stopped);
  }

  /** Whether this page drives the robot. */
  get drives() {
    return this.#timer !== undefined;
  }

  /** Whether this page waits to hear how things are, after a pause. */
  get away() {
    return this.#catchesUp !== "no";
  }

  /** Let go of a programme that something has ended, and say what. @param {Why} why */
  endBy(why) {
    const { programme, again } = this;
    if (!programme) return;
    this.#forget();
    this.#tell({ programme, why, again });
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

  /** Let go of held inputs, as the connection is lost; a programme waits for it. */
  disconnect() {
    if (!this.programme) this.#forget();
    else this.#catchesUp = "lost";
  }

  /** Let go of everything, without a word to the robot. */
  letGo() {
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
    this.again = () => this.setProgramme(programme);
    this.#sent = performance.now();
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

  #hide() {
    const { programme, again } = this;
    this.#leave();
    if (programme) this.#tell({ programme, why: "hidden", again });
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
    this.#catchesUp = "no";
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

  /** @param {Command} command */
  send(command) {
    // What waits for a network that is away must not drive when it is back.
    this.connection.post({ ...command, sent: this.connection.clock.now() });
  }

  #renew() {
    const now = performance.now();
    // Half a timer interval early counts as on time.
    if (this.programme && now - this.#sent < this.timeout / RENEWALS - RENEW_MS / 2) return;
    if (this.programme && (this.away || now - this.#sent > this.timeout || now - this.#heard > SILENT_MS)) {
      return void this.#catchUp();
    }
    this.#sent = now;
    this.send(this.programme ? this.programmed(this.programme) : this.#command());
  }

  /** After a pause: somebody may have stopped the robot, which must then not drive on. */
  async #catchUp() {
    const asks = this.#catchesUp === "asked" || this.#catchesUp === "answered";
    if (asks || this.connection.state !== "open") return;
    this.#catchesUp = "asked";
    const answered = await this.connection.send({ type: "ping" }).then(
      () => true,
      () => false,
    );
    if (this.#catchesUp === "asked") this.#catchesUp = answered ? "answered" : "lost";
  }

  /** Renew the programme again if the robot still waits for it. @param {boolean} stopped whether a stop holds */
  #goOn(stopped) {
    this.#catchesUp = "no";
    const now = performance.now();
    if (stopped) return this.endBy("stopped");
    if (this.#mode !== this.programme) {
      // A drive that came to its own end meanwhile needs no words here.
      return now - this.#sent > WAITS_MS - NOTICED_MS ? this.endBy("away") : this.#forget();
    }
    this.#sent = now;
    this.send(this.programmed(this.programme));
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
