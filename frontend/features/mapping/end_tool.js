// @ts-check
/** @typedef {import("../../messages").Command} Command */
/** @typedef {import("../../messages").MapDrawingMessage} MapDrawingMessage */
/** @typedef {[number, number]} Point */
/** @typedef {{stroke: number, last: boolean, place: Point}} HeldEnd */

/** An end is taken from this far away [CSS px]. */
const REACH = 12;
/** A drag shorter than this is a click [CSS px]. */
const SHORTEST = 4;

/** Drags the ends of a finished map's strokes. */
export class EndTool {
  /** @type {HeldEnd | null} */
  held = null;
  /** @type {Point} */
  #pressed = [0, 0];

  /**
   * @param {() => MapDrawingMessage | null} finished the map, once its ends may be moved
   * @param {() => number} scale [CSS px/m]
   * @param {(command: Command) => void} send
   */
  constructor(finished, scale, send) {
    this.finished = finished;
    this.scale = scale;
    this.send = send;
  }

  /** @param {number} x @param {number} y */
  wants(x, y) {
    return this.#near(x, y) !== null;
  }

  /** @param {number} x @param {number} y */
  press(x, y) {
    this.held = this.#near(x, y);
    this.#pressed = [x, y];
  }

  /** @param {number} x @param {number} y */
  drag(x, y) {
    if (this.held) this.held = { ...this.held, place: [x, y] };
  }

  release() {
    const { held } = this;
    const version = this.finished()?.version;
    this.held = null;
    if (!held || version === undefined) return;
    const { stroke, last, place } = held;
    const far = Math.hypot(place[0] - this.#pressed[0], place[1] - this.#pressed[1]) * this.scale();
    if (far < SHORTEST) return;
    this.send({ type: "move_end", stroke, last, x: place[0], y: place[1], version });
  }

  cancel() {
    this.held = null;
  }

  /** @param {number} x @param {number} y @returns {HeldEnd | null} the nearest end in reach */
  #near(x, y) {
    /** @type {HeldEnd | null} */
    let nearest = null;
    let reach = REACH / this.scale();
    for (const end of ends(this.finished())) {
      const away = Math.hypot(end.place[0] - x, end.place[1] - y);
      if (away >= reach) continue;
      nearest = end;
      reach = away;
    }
    return nearest;
  }
}

/** The ends of all strokes that are no rings. @param {MapDrawingMessage | null} drawing @returns {HeldEnd[]} */
export function ends(drawing) {
  return (drawing?.strokes ?? []).flatMap(({ points }, stroke) => {
    const [first, last] = [points[0], points[points.length - 1]];
    if (first[0] === last[0] && first[1] === last[1]) return [];
    return [
      { stroke, last: false, place: first },
      { stroke, last: true, place: last },
    ];
  });
}
