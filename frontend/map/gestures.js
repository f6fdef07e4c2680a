// @ts-check
/** @typedef {import("./view.js").MapView} MapView */
/** @typedef {import("../page/surface.js").Surface} Surface */

/**
 * @typedef {object} Press how a tool handles one pointer; positions are in the map [m]
 * @property {(x: number, y: number) => boolean} wants whether the tool takes a press there; otherwise it moves the view
 * @property {(x: number, y: number) => void} press
 * @property {(x: number, y: number, way?: number) => void} drag `way`: of the pointer since the press, if that is not on the map [CSS px]
 * @property {() => void} release
 * @property {() => void} cancel
 * @property {[number, number][] | null} [corners] of what it draws; a tool that has them can be used in the 3D view, too
 */

const WHEEL_STEP = 0.0015;
const BUTTON_STEP = 1.3;
const PAN_STEP = 40;

/** Pointers, wheel and keys on the map: two fingers or the wheel zoom, the tool gets the rest. */
export class Gestures {
  /** @type {Map<number, [number, number]>} */
  #pointers = new Map();
  /** @type {"none" | "pan" | "tool"} */
  #doing = "none";
  /** What the press was for. @type {Press | undefined} */
  #tool;

  /**
   * @param {Surface} surface
   * @param {MapView} view
   * @param {Press[]} tools the first that wants a press takes it
   * @param {() => void} changed when the view was moved by hand
   * @param {() => void} drawn when a tool draws something else
   * @param {() => void} fit
   */
  constructor(surface, view, tools, changed, drawn, fit) {
    this.surface = surface;
    this.view = view;
    this.tools = tools;
    this.changed = changed;
    this.drawn = drawn;
    this.fit = fit;
    const { canvas } = surface;
    canvas.addEventListener("pointerdown", (event) => this.#down(event));
    canvas.addEventListener("pointermove", (event) => this.#move(event));
    canvas.addEventListener("pointerup", (event) => this.#up(event, true));
    canvas.addEventListener("pointercancel", (event) => this.#up(event, false));
    canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    canvas.addEventListener("keydown", (event) => this.#key(event));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /** @param {number} steps zooms in, or out if negative */
  zoom(steps) {
    this.view.zoom(BUTTON_STEP ** steps);
    this.changed();
  }

  /** @param {PointerEvent} event */
  #down(event) {
    this.surface.canvas.setPointerCapture(event.pointerId);
    this.#pointers.set(event.pointerId, this.surface.locate(event));
    const second = this.#pointers.size > 1;
    if (second && this.#doing === "tool") this.#tool?.cancel();
    const place = this.view.toMap(...this.surface.locate(event));
    this.#tool = this.tools.find((tool) => tool.wants(...place));
    if (second || event.button !== 0 || event.shiftKey || !this.#tool) {
      this.#doing = "pan";
      return;
    }
    this.#doing = "tool";
    this.#tool.press(...place);
  }

  /** @param {PointerEvent} event */
  #move(event) {
    const before = this.#pointers.get(event.pointerId);
    if (!before) return;
    const now = this.surface.locate(event);
    this.#pointers.set(event.pointerId, now);
    if (this.#doing === "tool") {
      this.#tool?.drag(...this.view.toMap(...now));
      return this.drawn();
    }
    this.#pinch(event.pointerId, before, now);
    this.changed();
  }

  /**
   * One pointer pans. Of two pointers, each moves the middle by half, and their distance zooms.
   * @param {number} id
   * @param {[number, number]} before
   * @param {[number, number]} now
   */
  #pinch(id, before, now) {
    const other = [...this.#pointers].find(([key]) => key !== id)?.[1];
    const share = other ? 2 : 1;
    this.view.pan((now[0] - before[0]) / share, (now[1] - before[1]) / share);
    if (!other) return;
    const apart = (/** @type {[number, number]} */ at) =>
      Math.hypot(at[0] - other[0], at[1] - other[1]);
    const middle = /** @type {const} */ ([(now[0] + other[0]) / 2, (now[1] + other[1]) / 2]);
    this.view.zoom(apart(now) / Math.max(1, apart(before)), ...middle);
  }

  /** @param {PointerEvent} event @param {boolean} finished */
  #up(event, finished) {
    if (!this.#pointers.delete(event.pointerId)) return;
    if (this.#doing === "tool") finished ? this.#tool?.release() : this.#tool?.cancel();
    if (this.#pointers.size === 0 || this.#doing === "tool") this.#doing = "none";
    this.drawn();
  }

  /** @param {WheelEvent} event */
  #wheel(event) {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 30 : 1;
    this.view.zoom(Math.exp(-event.deltaY * lines * WHEEL_STEP), ...this.surface.locate(event));
    this.changed();
  }

  /**
   * Plus, minus and 0 zoom, shift with arrows pans; arrows alone drive.
   * @param {KeyboardEvent} event
   */
  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "+" || event.key === "=") this.zoom(1);
    else if (event.key === "-") this.zoom(-1);
    else if (event.key === "0") this.fit();
    else if (event.key === "Escape") return void this.#cancel();
    else if (event.shiftKey && event.key.startsWith("Arrow")) this.#panBy(event.key);
    else return;
    event.preventDefault();
    this.changed();
  }

  /** Another part of the page may use Escape, too. */
  #cancel() {
    for (const tool of this.tools) tool.cancel();
    this.drawn();
  }

  /** @param {string} key */
  #panBy(key) {
    const across = { ArrowLeft: PAN_STEP, ArrowRight: -PAN_STEP }[key] ?? 0;
    const down = { ArrowUp: PAN_STEP, ArrowDown: -PAN_STEP }[key] ?? 0;
    this.view.pan(across, down);
  }
}
