// @ts-check
/** @typedef {import("../messages").ScanMessage} ScanMessage */
/** @typedef {import("./stream.js").Picture} Picture */
/** @typedef {{picture: Picture, scan: ScanMessage | null}} Pair */

const KEPT_PICTURES = 15;
/** More than pictures, as a busy page skips pictures but reads every scan. */
const KEPT_SCANS = 60;
/** How long a picture waits for its scan [ms], as long as scans come. */
const PATIENCE_MS = 16;
const SCANS_COME_MS = 500;

/**
 * Pairs each picture with the scan of the same exposure.
 *
 * Pictures and scans come on separate sockets, in either order. A picture whose scan is missing is
 * shown without a scan, not with the scan of another picture.
 */
export class Pairing {
  /** @type {Map<number, ScanMessage>} */
  #scans = new Map();
  /** @type {Picture[]} */
  #pictures = [];
  #paired = -Infinity;
  /** @type {Pair | null} */
  shown = null;

  /** @param {ScanMessage} scan @returns {boolean} whether the scan is new */
  addScan(scan) {
    if (this.#scans.has(scan.stamp)) return false;
    this.#scans.set(scan.stamp, scan);
    if (this.#scans.size > KEPT_SCANS) this.#scans.delete(this.#scans.keys().next().value ?? NaN);
    return true;
  }

  /** @param {Picture} picture */
  addPicture(picture) {
    const newest = this.#pictures.at(-1);
    if (newest && picture.stamp < newest.stamp) this.#drop(this.#pictures.length);
    this.#pictures.push(picture);
    if (this.#pictures.length > KEPT_PICTURES) this.#drop(1);
  }

  /**
   * The pair to show now, and whether to ask again soon because a picture still waits.
   * @param {number} now by performance.now() [ms]
   * @returns {{pair: Pair | null, waiting: boolean}}
   */
  pick(now) {
    const newest = this.#pictures.at(-1);
    if (!newest) return { pair: this.shown, waiting: false };
    const hopeful = now - this.#paired < SCANS_COME_MS && now - newest.arrived < PATIENCE_MS;
    if (this.#scans.has(newest.stamp) || !hopeful)
      return { pair: this.#show(newest, now), waiting: false };
    const older = this.#pictures.findLast((picture) => this.#scans.has(picture.stamp));
    return { pair: older ? this.#show(older, now) : this.shown, waiting: true };
  }

  /** @param {Picture} picture @param {number} now @returns {Pair} */
  #show(picture, now) {
    const scan = this.#scans.get(picture.stamp) ?? null;
    if (scan) this.#paired = now;
    this.#drop(this.#pictures.indexOf(picture));
    if (this.shown?.picture !== picture || this.shown.scan !== scan) this.shown = { picture, scan };
    return this.shown;
  }

  /** Drop the oldest pictures. @param {number} count */
  #drop(count) {
    for (const picture of this.#pictures.splice(0, count)) {
      picture.bitmap.close();
      if (picture === this.shown?.picture) this.shown = null;
    }
  }
}
