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
    let waiting = false;
    for (const painter of this.#painters) {
      if (!painter.dirty || !painter.visible()) continue;
      // Half a frame early counts as on time: the next chance is a whole frame later.
      if (now - painter.last < painter.every - 8) waiting = true;
      else this.#paint(painter, now);
    }
    if (waiting) this.#ask();
  }

  /** @param {Painter} painter @param {number} now */
  #paint(painter, now) {
    painter.dirty = false;
    painter.last = now;
    painter.paint(now);
  }
}
