// @ts-check

/** How long a measurement of the clocks counts [ms]: the robot's clock may run slower than ours. */
const KEPT_MS = 12000;
/** The stamp in an answer is known no better [ms]. */
const SLACK_MS = 20;

/** @typedef {{offset: number, trip: number, at: number}} Sample offset [s], trip and at [ms] */

/**
 * The robot's clock seen from here, lined up by the answers to commands.
 *
 * An answer's stamp was written some time between sending and receiving; the answer that came back
 * fastest bounds the error best (as NTP does): offset = stamp - (sent + received) / 2.
 */
export class RobotClock {
  /** @type {Sample[]} */
  #samples = [];

  /**
   * @param {number} sent when the command left, by performance.now() [ms]
   * @param {number} received when the answer came [ms]
   * @param {number} stamp the robot's clock in the answer [s]
   */
  add(sent, received, stamp) {
    const sample = {
      offset: stamp - (sent + received) / 2000,
      trip: received - sent,
      at: received,
    };
    const kept = this.#samples.filter((old) => received - old.at < KEPT_MS && agree(old, sample));
    this.#samples = [...kept, sample].slice(-60);
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

/**
 * Whether two measurements can both be right. When not, the robot's clock has stood still in
 * between, as a simulation does that cannot keep up, and the older one is of no use.
 * @param {Sample} a
 * @param {Sample} b
 */
function agree(a, b) {
  return Math.abs(a.offset - b.offset) * 1000 <= (a.trip + b.trip) / 2 + SLACK_MS;
}
