// @ts-check

/**
 * @typedef {object} Painter
 * @property {() => boolean} visible whether anyone could see it
 * @property {(now: number) => void} paint
 * @property {number} every shortest time between two paintings [ms]
 * @property {number} last when it was painted [ms]
 * @property {boolean} dirty whether there is something new to paint
 */

/** The page's only animation loop: paints what changed, at a limited rate, and otherwise rests. */
export class DrawLoop {
  /** @type {Painter[]} */
  #painters = [];
  #asked = false;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #later;

  /**
   * @param {(now: number) => void} paint called with performance.now() [ms]
   * @param {{visible?: () => boolean, hertz?: number}} [options]
   * @returns {() => void} call it when there is something new to paint
   */
  add(paint, { visible = () => true, hertz = 60 } = {}) {
    /** @type {Painter} */
    const painter = { visible, paint, every: 1000 / hertz, last: -Infinity, dirty: true };
    this.#painters.push(painter);
    this.#ask();
    return () => {
      painter.dirty = true;
      this.#ask();
    };
  }

  #ask() {
    if (this.#asked) return;
    this.#asked = true;
    requestAnimationFrame(() => this.#run());
  }

  #run() {
    this.#asked = false;
    const now = performance.now();
    let wait = Infinity;
    for (const painter of this.#painters) {
      if (!painter.dirty || !painter.visible()) continue;
      // Half a frame early counts as on time: the next chance is a whole frame later.
      const early = painter.last + painter.every - 8 - now;
      if (early > 0) wait = Math.min(wait, early);
      else this.#paint(painter, now);
    }
    // A frame in which nothing is painted costs the browser nearly as much as another one.
    clearTimeout(this.#later);
    if (wait < Infinity) this.#later = setTimeout(() => this.#ask(), wait);
  }

  /** @param {Painter} painter @param {number} now */
  #paint(painter, now) {
    painter.dirty = false;
    painter.last = now;
    painter.paint(now);
  }
}
