// @ts-check
import { make } from "../page/elements.js";
import { t } from "../page/language.js";
import { bordersOf, moved, panelsOf } from "./tree.js";

/** @typedef {import("./tree.js").Border} Border */
/** @typedef {import("./tree.js").Tree} Tree */

/** An arrow key moves a border by this share of the two neighbours. */
const STEP = 0.02;

/** The borders between panels: they are dragged, or moved by arrow keys. */
export class Borders {
  /** @type {Tree} */
  #tree = "";
  /** @type {Map<string, HTMLElement>} */
  #shown = new Map();
  /** The borders by their keys. @type {Map<string, Border>} */
  #borders = new Map();

  /** @param {HTMLElement} main @param {(tree: Tree) => void} changed */
  constructor(main, changed) {
    this.main = main;
    this.changed = changed;
  }

  /** @param {Tree} tree */
  show(tree) {
    this.#tree = tree;
    this.#borders = new Map(bordersOf(tree).map((border) => [keyOf(border), border]));
    for (const [key, element] of this.#shown) {
      if (this.#borders.has(key)) continue;
      element.remove();
      this.#shown.delete(key);
    }
    for (const [key, border] of this.#borders) {
      // An element stays as it is dragged: it has the pointer, or the focus.
      const element = this.#shown.get(key) ?? this.#make(key);
      this.#place(element, border);
    }
  }

  /** @param {string} key */
  #make(key) {
    const element = make("div", { class: "border", role: "separator", tabindex: "0", "data-own-arrows": "" });
    element.addEventListener("pointerdown", (event) => {
      element.setPointerCapture(event.pointerId);
      event.preventDefault();
    });
    element.addEventListener("pointermove", (event) => {
      if (element.hasPointerCapture(event.pointerId)) this.#drag(key, event);
    });
    element.addEventListener("keydown", (event) => this.#key(key, event));
    this.main.append(element);
    this.#shown.set(key, element);
    return element;
  }

  /** @param {HTMLElement} element @param {Border} border */
  #place(element, { split, box, share, path, place }) {
    const beside = split === "row";
    const at = beside ? { ...box, x: box.x + share * box.width } : { ...box, y: box.y + share * box.height };
    element.dataset.split = split;
    for (const [side, value] of Object.entries(at)) element.style.setProperty(`--${side}`, String(value));
    const percent = String(Math.round(100 * share));
    const [before, after] = neighbours(this.#tree, path, place);
    element.setAttribute("aria-orientation", beside ? "vertical" : "horizontal");
    element.setAttribute("aria-valuenow", percent);
    element.setAttribute("aria-label", t("Border between {before} and {after}", { before, after }));
  }

  /** @param {string} key @param {PointerEvent} event */
  #drag(key, event) {
    const border = this.#borders.get(key);
    if (!border) return;
    const whole = this.main.getBoundingClientRect();
    const { box, split } = border;
    const share =
      split === "row"
        ? ((event.clientX - whole.left) / whole.width - box.x) / box.width
        : ((event.clientY - whole.top) / whole.height - box.y) / box.height;
    this.changed(moved(this.#tree, border, share));
  }

  /** @param {string} key @param {KeyboardEvent} event */
  #key(key, event) {
    const border = this.#borders.get(key);
    const ways = border?.split === "row" ? ["ArrowLeft", "ArrowRight"] : ["ArrowUp", "ArrowDown"];
    const way = ways.indexOf(event.key);
    if (!border || way < 0) return;
    event.preventDefault();
    this.changed(moved(this.#tree, border, border.share + (way === 0 ? -STEP : STEP)));
  }
}

/** @param {Border} border */
const keyOf = ({ path, place, split }) => `${split} ${path.join(".")} ${place}`;

/** First panels on both sides of a border. @param {Tree} tree @param {number[]} path @param {number} place */
function neighbours(tree, path, place) {
  const at = path.reduce((part, i) => (typeof part === "string" ? part : part.parts[i]), tree);
  const parts = typeof at === "string" ? [at, at] : at.parts.slice(place);
  return [panelsOf(parts[0])[0], panelsOf(parts[1])[0]];
}
