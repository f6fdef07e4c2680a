// @ts-check
import { Backoff } from "../wire/backoff.js";

/** @typedef {import("../messages").PictureMessage} PictureMessage */
/** @typedef {PictureMessage & {bitmap: ImageBitmap}} Picture */

/** Bytes that hold the length of the head: a little-endian uint32. */
const LENGTH_BYTES = 4;

/**
 * The camera's pictures with their scans; only the newest one is decoded, so a slow machine skips
 * pictures.
 */
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
    this.address = new URL(path, document.baseURI.replace(/^http/, "ws")).href;
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
      this.#next = null;
      try {
        this.listener(await decoded(message));
      } catch (error) {
        console.warn("A camera picture could not be decoded.", error);
      }
    }
    this.#decoding = false;
  }
}

/** @param {ArrayBuffer} message @returns {Promise<Picture>} */
async function decoded(message) {
  const length = new DataView(message).getUint32(0, true);
  const head = new TextDecoder().decode(new Uint8Array(message, LENGTH_BYTES, length));
  const jpeg = new Uint8Array(message, LENGTH_BYTES + length);
  const bitmap = await createImageBitmap(new Blob([jpeg], { type: "image/jpeg" }));
  return { ...JSON.parse(head), bitmap };
}
