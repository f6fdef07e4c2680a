// @ts-check

/** Shortest span that can be shown [s]. */
const SHORTEST_S = 1;

/** The part of the run that is shown: the newest seconds, or a part that was chosen. */
export class Span {
  /** How much is shown [s]; infinity is the whole run. */
  seconds = 30;
  /** Stamp at the right end [s]; null follows the newest. @type {number | null} */
  end = null;

  /** @param {number[]} stamps @returns {[number, number]} the stamps at both ends [s] */
  ends(stamps) {
    const [oldest, newest] = [stamps[0] ?? 0, stamps.at(-1) ?? 0];
    const high = this.end ?? newest;
    if (!Number.isFinite(this.seconds)) return [Math.min(oldest, high - SHORTEST_S), high];
    // A run that has just begun fills the plot from the left.
    const right = this.end ?? Math.max(newest, oldest + this.seconds);
    return [right - this.seconds, right];
  }

  /** Show so many of the newest seconds. @param {number} seconds */
  follow(seconds) {
    this.seconds = seconds;
    this.end = null;
  }

  /** Zoom by a factor, about a stamp that stays where it is. @param {number[]} stamps @param {number} factor @param {number} stamp */
  zoom(stamps, factor, stamp) {
    const [low, high] = this.ends(stamps);
    const seconds = Math.max(SHORTEST_S, (high - low) * factor);
    const share = (high - stamp) / (high - low);
    this.seconds = seconds;
    this.#settle(stamps, stamp + share * seconds);
  }

  /** @param {number[]} stamps @param {number} seconds later, or earlier if negative */
  pan(stamps, seconds) {
    const [low, high] = this.ends(stamps);
    this.seconds = high - low;
    this.#settle(stamps, Math.max((stamps[0] ?? 0) + SHORTEST_S, high + seconds));
  }

  /** At its newest end, the plot follows again. @param {number[]} stamps @param {number} end */
  #settle(stamps, end) {
    const newest = stamps.at(-1) ?? 0;
    this.end = end >= newest ? null : end;
  }
}
