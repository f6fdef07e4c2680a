// @ts-check
import { ownsKey, take, typesText } from "../../../drive/keys.js";

/** @typedef {import("./bar.js").ReplayBar} ReplayBar */

/** Steps in pictures by key: a replay is not driven, so these keys are free. */
/** @type {Record<string, number>} */
const STEPS = { Comma: -1, ArrowLeft: -1, Period: 1, ArrowRight: 1 };

/** Space pauses or plays; comma and full stop, or the arrows, go from picture to picture. */
export class ReplayKeys {
  /** @param {ReplayBar} bar */
  constructor(bar) {
    this.bar = bar;
    this.listen(window);
  }

  /** Take keys from another window, too, such as the 3D view's frame. @param {Window} target */
  listen(target) {
    target.addEventListener("keydown", (event) => this.#down(event), { capture: true });
    target.addEventListener("keyup", (event) => this.#up(event), { capture: true });
  }

  /** @param {KeyboardEvent} event */
  #down(event) {
    if (!this.#minds(event)) return;
    take(event);
    if (event.code !== "Space") this.bar.step(STEPS[event.code]);
    else if (!event.repeat) this.bar.toggle();
  }

  /** Keep space from also pressing the button with the focus. @param {KeyboardEvent} event */
  #up(event) {
    if (event.code === "Space" && this.#minds(event)) take(event);
  }

  /** @param {KeyboardEvent} event */
  #minds(event) {
    if (!this.bar.shown || event.ctrlKey || event.metaKey || event.altKey || event.shiftKey)
      return false;
    if (event.code !== "Space" && !(event.code in STEPS)) return false;
    return !typesText(event.target) && !ownsKey(event.target, event.code);
  }
}
