// @ts-check
import { findButton } from "../page/elements.js";
import { getJson } from "../wire/http.js";

/** @typedef {import("../messages").FloorGridMessage} FloorGridMessage */
/** @typedef {import("./overlay.js").Placement} Placement */

/** The floor's grid over the camera's picture: by it one sees whether the mounting is right. */
export class FloorGrid {
  #button = findButton("camera-grid");
  /** @type {FloorGridMessage | null} */
  #grid = null;
  /** @type {typeof import("./grid_drawing.js").drawGrid | null} */
  #draw = null;

  /** @param {() => void} changed called when it is to be drawn anew */
  constructor(changed) {
    this.changed = changed;
    this.#button.onclick = () => {
      this.#button.setAttribute("aria-pressed", String(!this.#shown));
      this.load();
    };
  }

  get #shown() {
    return this.#button.getAttribute("aria-pressed") === "true";
  }

  /** Ask where the grid lies; again after a calibration. */
  async load() {
    try {
      if (this.#shown) this.#draw = (await import("./grid_drawing.js")).drawGrid;
      this.#grid = this.#shown ? await getJson("api/floor-grid") : null;
    } catch (error) {
      console.warn("The floor's grid could not be read.", error);
    }
    this.changed();
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {Placement} placement
   * @param {{width: number, height: number}} picture
   */
  draw(context, placement, picture) {
    if (this.#grid) this.#draw?.(context, this.#grid, placement, picture);
  }
}
