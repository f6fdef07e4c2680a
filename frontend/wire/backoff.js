// @ts-check
/**
 * Waiting times between attempts: they double up to a second, so that what a page drives goes on
 * after 2 s without a network, and vary at random so that viewers do not all come at the same time.
 */
export class Backoff {
  #attempts = 0;

  /** @param {number} first [ms]  @param {number} longest [ms] */
  constructor(first = 250, longest = 1000) {
    this.first = first;
    this.longest = longest;
  }

  /** @returns {number} how long to wait before the next attempt [ms] */
  next() {
    const wait = Math.min(this.longest, this.first * 2 ** this.#attempts);
    this.#attempts += 1;
    return wait * (0.8 + 0.4 * Math.random());
  }

  reset() {
    this.#attempts = 0;
  }
}
