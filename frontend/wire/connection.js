// @ts-check
import { t } from "../page/language.js";
import { Backoff } from "./backoff.js";
import { RobotClock } from "./clock.js";

/** @typedef {import("../messages").Command} Command */
/** @typedef {import("../messages").AckMessage} AckMessage */
/** @typedef {import("../messages").ErrorMessage} ErrorMessage */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {"connecting" | "open" | "lost"} LinkState */
/**
 * @typedef {{sent: number, patience?: number, resolve: (ack: AckMessage) => void, reject: (error: Error) => void}}
 *   Waiting
 */

const PING_EVERY_MS = 2000;
/** After this many pings without any message, the connection counts as lost. */
const MOST_SILENT = 3;
const ANSWER_MS = 10000;
/** Loading a field or a recording took 11.5 s on a busy machine; the page connects again anyway then. */
const LOADED_MS = 60000;
const LOADING = ["use_field", "open_recording", "close_recording"];
/** Drive commands are dropped while more bytes wait: an old drive command is worse than none. */
const FULL_BYTES = 4096;

/** A command was refused, or never answered. */
export class CommandError extends Error {}

/** The connection to the robot: telemetry in, commands out; it reconnects by itself. */
export class Connection {
  clock = new RobotClock();
  /** @type {LinkState} */
  state = "connecting";
  /** Whether this page has asked for another field or recording: then the connection breaks, and comes back. */
  loads = false;

  /** @type {WebSocket | null} */
  #socket = null;
  #backoff = new Backoff();
  #heard = 0;
  #nextId = 1;
  /**
   * Pings since the last message; a count, not a time, as this page itself may be busy or asleep.
   */
  #silent = 0;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #retry;
  /** @type {Map<number, Waiting>} */
  #waiting = new Map();
  /** @type {Set<(telemetry: TelemetryMessage) => void>} */
  #telemetryListeners = new Set();
  /** @type {Set<(state: LinkState) => void>} */
  #stateListeners = new Set();

  /** @param {string} path of the socket on this server */
  constructor(path) {
    this.address = new URL(path, document.baseURI.replace(/^http/, "ws")).href;
  }

  /** Connect, and stay connected as long as the page exists. */
  start() {
    setInterval(() => this.#watch(), PING_EVERY_MS);
    addEventListener("online", () => this.hurry());
    document.addEventListener("visibilitychange", () => this.hurry());
    this.#open();
  }

  /** @param {(telemetry: TelemetryMessage) => void} listener */
  onTelemetry(listener) {
    this.#telemetryListeners.add(listener);
  }

  /** @param {(state: LinkState) => void} listener */
  onState(listener) {
    this.#stateListeners.add(listener);
  }

  /**
   * Send a command and wait for its answer.
   * @param {Command} command
   * @returns {Promise<AckMessage>} rejects with a CommandError that says why in plain words
   */
  send(command) {
    return new Promise((resolve, reject) => {
      const loads = LOADING.includes(command.type);
      const refuse = (/** @type {Error} */ error) => {
        // Else the answer was lost with the connection.
        if (loads && this.#socket) this.loads = false;
        reject(error);
      };
      if (loads) this.loads = true;
      const patience = loads ? LOADED_MS : ANSWER_MS;
      if (!this.post(command, { sent: performance.now(), patience, resolve, reject: refuse })) {
        reject(new CommandError(t("There is no connection to the robot.")));
      }
    });
  }

  /**
   * Send a command without waiting for its answer, such as the renewal of a drive command.
   * @param {Command} command
   * @param {Waiting} [waiting]
   * @returns {boolean} whether it was sent
   */
  post(command, waiting) {
    const socket = this.#socket;
    if (socket?.readyState !== WebSocket.OPEN) return false;
    if (command.type === "drive" && socket.bufferedAmount > FULL_BYTES) return false;
    const id = this.#nextId++;
    this.#waiting.set(id, waiting ?? { sent: performance.now(), resolve() {}, reject() {} });
    socket.send(JSON.stringify({ ...command, id }));
    return true;
  }

  #open() {
    const socket = new WebSocket(this.address);
    this.#socket = socket;
    this.#silent = 0;
    socket.onopen = () => this.#opened();
    socket.onmessage = (event) => this.#take(event.data);
    socket.onclose = () => this.#closed(socket);
  }

  #opened() {
    this.clock.reset();
    for (let i = 0; i < 3; i++) this.post({ type: "ping" });
  }

  /** @param {string} text */
  #take(text) {
    this.#heard = performance.now();
    this.#silent = 0;
    /** @type {TelemetryMessage | AckMessage | ErrorMessage} */
    const message = JSON.parse(text);
    if (message.type === "telemetry") this.#telemetry(message);
    else this.#answer(message);
  }

  /** @param {TelemetryMessage} telemetry */
  #telemetry(telemetry) {
    this.#backoff.reset();
    this.#enter("open");
    for (const listener of this.#telemetryListeners) listener(telemetry);
  }

  /** @param {AckMessage | ErrorMessage} message */
  #answer(message) {
    const waiting = this.#waiting.get(Number(message.id));
    this.#waiting.delete(Number(message.id));
    if (!waiting) return;
    if (message.type === "error") return waiting.reject(new CommandError(message.message));
    if (message.stamp !== null) this.clock.add(waiting.sent, this.#heard, message.stamp);
    waiting.resolve(message);
  }

  /** @param {WebSocket} socket */
  #closed(socket) {
    if (socket !== this.#socket) return;
    this.#socket = null;
    for (const waiting of this.#waiting.values()) {
      waiting.reject(new CommandError(t("The connection broke before the robot answered.")));
    }
    this.#waiting.clear();
    this.#enter("lost");
    this.#retry = setTimeout(() => this.#open(), this.#backoff.next());
  }

  #watch() {
    this.#giveUp();
    const socket = this.#socket;
    if (!socket) return;
    this.#silent += 1;
    if (this.#silent <= MOST_SILENT) return void this.post({ type: "ping" });
    this.#closed(socket);
    socket.close();
  }

  /** Reject commands that were not answered in time. */
  #giveUp() {
    for (const [id, waiting] of this.#waiting) {
      if (performance.now() - waiting.sent < (waiting.patience ?? ANSWER_MS)) continue;
      this.#waiting.delete(id);
      waiting.reject(new CommandError(t("The robot did not answer.")));
    }
  }

  /** Connect anew, as the server is to know this page by another name. */
  again() {
    this.#socket?.close();
  }

  /** Connect at once, as the network or the robot is there, or somebody looks at the page. */
  hurry() {
    if (this.#socket || document.hidden) return;
    clearTimeout(this.#retry);
    this.#open();
  }

  /** @param {LinkState} state */
  #enter(state) {
    if (state === this.state) return;
    this.state = state;
    if (state === "open") this.loads = false;
    for (const listener of this.#stateListeners) listener(state);
  }
}
