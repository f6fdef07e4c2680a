// @ts-check

/** How long a measurement of the clocks counts [ms]: the robot's clock may run slower than ours. */
const KEPT_MS = 12000;
/** Accuracy of the stamp in an answer [ms]. */
const SLACK_MS = 20;

/** @typedef {{offset: number, trip: number, at: number}} Sample offset [s], trip and at [ms] */

/**
 * The robot's clock as estimated here, from the answers to commands.
 *
 * An answer's stamp was written some time between sending and receiving. As in NTP, the answer that
 * came back fastest bounds the error best: offset = stamp - (sent + received) / 2.
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

  /** Forget all measurements: it may be another robot, or the same one after a restart. */
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
 * Whether two measurements can both be right. If not, the robot's clock stood still in between, as
 * in a simulation that is slower than real time, and the older measurement is of no use.
 * @param {Sample} a
 * @param {Sample} b
 */
function agree(a, b) {
  return Math.abs(a.offset - b.offset) * 1000 <= (a.trip + b.trip) / 2 + SLACK_MS;
}
