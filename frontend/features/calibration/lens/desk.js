// @ts-check
import { t, translated } from "../../../page/language.js";
import { Backoff } from "../../../wire/backoff.js";

/** @typedef {import("../../../messages").ErrorMessage} ErrorMessage */
/** @typedef {import("../../../messages").LensStatusMessage} LensStatusMessage */
/**
 * @typedef {import("../../../messages").LensStartRequest | import("../../../messages").LensCalibrateRequest
 *   | import("../../../messages").LensSaveRequest} LensRequest
 */

/** The server closes with this code what the link does not allow. */
const NOT_ALLOWED = 1008;

/** The connection to the calibration: its status in, requests out; it reconnects by itself. */
export class Desk {
  /** @type {WebSocket | null} */
  #socket = null;
  #wanted = false;
  #backoff = new Backoff();
  #lost = false;

  /**
   * @param {string} path
   * @param {(status: LensStatusMessage) => void} listener
   * @param {(words: string) => void} complain called with what is wrong, or with nothing
   */
  constructor(path, listener, complain) {
    this.address = new URL(path, document.baseURI.replace(/^http/, "ws")).href;
    this.listener = listener;
    this.complain = complain;
  }

  /** The robot looks for boards only while somebody looks at this page. @param {boolean} wanted */
  want(wanted) {
    this.#wanted = wanted;
    if (wanted) this.#open();
    else this.#socket?.close();
  }

  /** What is asked before the page is connected is sent once it is. @param {LensRequest} request */
  send(request) {
    this.complain("");
    const socket = this.#socket;
    const send = () => socket?.send(JSON.stringify(request));
    if (socket?.readyState === WebSocket.OPEN) send();
    else if (socket?.readyState === WebSocket.CONNECTING) socket.addEventListener("open", send);
    else this.complain(t("There is no connection to the robot."));
  }

  #open() {
    if (!this.#wanted || this.#socket) return;
    const socket = new WebSocket(this.address);
    socket.onmessage = (event) => this.#take(JSON.parse(event.data));
    socket.onclose = (event) => this.#closed(event.code);
    this.#socket = socket;
  }

  /** @param {LensStatusMessage | ErrorMessage} message */
  #take(message) {
    if (message.type === "error") return this.complain(sentence(message.message));
    this.#backoff.reset();
    if (this.#lost) this.complain("");
    this.#lost = false;
    this.listener(message);
  }

  /** @param {number} code */
  #closed(code) {
    this.#socket = null;
    if (code === NOT_ALLOWED || !this.#wanted) return;
    this.#lost = true;
    this.complain(t("The connection to the robot is lost; trying again."));
    setTimeout(() => this.#open(), this.#backoff.next());
  }
}

/** What the program told, as a sentence in the page's language. @param {string} words */
export function sentence(words) {
  const own = translated(words);
  const start = own.charAt(0).toUpperCase() + own.slice(1);
  return /[.!?]$/.test(start) ? start : `${start}.`;
}
