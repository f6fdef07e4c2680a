// @ts-check
import { Backoff } from "../wire/backoff.js";

/** Bytes before the JPEG: the exposure's stamp, little-endian float64. */
const HEADER_BYTES = 8;

/**
 * @typedef {object} Picture
 * @property {number} stamp exposure on the robot's clock [s]
 * @property {ImageBitmap} bitmap
 * @property {number} arrived by performance.now() [ms]
 */

/** The camera's pictures; only the newest one is decoded, so a slow machine skips pictures. */
export class CameraStream {
  /** @type {WebSocket | null} */
  #socket = null;
  #wanted = false;
  #backoff = new Backoff();
  #decoding = false;
  /** @type {ArrayBuffer | null} */
  #next = null;

  /** @param {string} path @param {(picture: Picture) => void} listener then owns the bitmap */
  constructor(path, listener) {
    this.address = new URL(path, location.href.replace(/^http/, "ws")).href;
    this.listener = listener;
  }

  /** Stream only while somebody looks. @param {boolean} wanted */
  want(wanted) {
    if (wanted === this.#wanted) return;
    this.#wanted = wanted;
    if (wanted) this.#open();
    else this.#socket?.close();
  }

  #open() {
    if (!this.#wanted || this.#socket) return;
    const socket = new WebSocket(this.address);
    socket.binaryType = "arraybuffer";
    socket.onmessage = (event) => this.#take(event.data);
    socket.onclose = () => {
      this.#socket = null;
      setTimeout(() => this.#open(), this.#backoff.next());
    };
    this.#socket = socket;
  }

  /** @param {ArrayBuffer} message */
  #take(message) {
    this.#backoff.reset();
    this.#next = message;
    if (!this.#decoding) this.#decode();
  }

  async #decode() {
    this.#decoding = true;
    while (this.#next) {
      const message = this.#next;
      const arrived = performance.now();
      this.#next = null;
      const stamp = new DataView(message).getFloat64(0, true);
      const jpeg = new Blob([new Uint8Array(message, HEADER_BYTES)], { type: "image/jpeg" });
      try {
        this.listener({ stamp, bitmap: await createImageBitmap(jpeg), arrived });
      } catch (error) {
        console.warn("A camera picture could not be decoded.", error);
      }
    }
    this.#decoding = false;
  }
}
