// @ts-check

/** How long a measurement of the clocks counts [ms]: the robot's clock may run slower than ours. */
const KEPT_MS = 12000;

/**
 * The robot's clock seen from here, lined up by the answers to commands.
 *
 * An answer's stamp was written some time between sending and receiving; the answer that came back
 * fastest bounds the error best (as NTP does): offset = stamp - (sent + received) / 2.
 */
export class RobotClock {
  /** @type {{offset: number, trip: number, at: number}[]} */
  #samples = [];

  /**
   * @param {number} sent when the command left, by performance.now() [ms]
   * @param {number} received when the answer came [ms]
   * @param {number} stamp the robot's clock in the answer [s]
   */
  add(sent, received, stamp) {
    const offset = stamp - (sent + received) / 2000;
    this.#samples.push({ offset, trip: received - sent, at: received });
    this.#samples = this.#samples.filter((sample) => received - sample.at < KEPT_MS).slice(-60);
  }

  /** Forget all: another robot, or the same one started anew. */
  reset() {
    this.#samples = [];
  }

  /**
   * @param {number} at by performance.now() [ms]
   * @returns {number | null} the robot's clock [s]; null before the first answer
   */
  now(at = performance.now()) {
    if (this.#samples.length === 0) return null;
    const best = this.#samples.reduce((a, b) => (b.trip < a.trip ? b : a));
    return at / 1000 + best.offset;
  }
}
