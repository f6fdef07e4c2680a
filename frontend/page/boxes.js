// @ts-check
/** Boxes over the page: Escape closes the one that opened last, wherever the focus is; a press beside closes all. */

/**
 * @typedef {object} Box
 * @property {HTMLElement} element
 * @property {HTMLElement[]} openers a press on one of them is left to it
 * @property {(focus: boolean) => void} close `focus`: whether its opener gets the focus back
 */

/** @type {Box[]} the one that opened last is the last */
const boxes = [];

/** Have Escape and a press beside close a box. @param {Box} box */
export function dismissable(box) {
  boxes.push(box);
}

/** Note that a box opens, above all others. @param {HTMLElement} element */
export function raise(element) {
  boxes.sort((a, b) => Number(a.element === element) - Number(b.element === element));
}

/** @param {KeyboardEvent} event also one of a frame in the page */
export function dismissByKey(event) {
  // A dialogue lies above all boxes, and closes by itself.
  if (event.key !== "Escape" || document.querySelector("dialog[open]")) return;
  const box = boxes.findLast(({ element }) => !element.hidden);
  if (!box) return;
  event.preventDefault();
  event.stopImmediatePropagation();
  box.close(true);
}

/** @param {Event} event a press anywhere, also in a frame of the page */
export function dismissByPress({ target }) {
  for (const { element, openers, close } of boxes) {
    if (element.hidden) continue;
    const parts = [element, ...openers];
    // What is used together with a box leaves it open: a map that is drawn needs the joystick.
    if (target instanceof Element && (parts.some((part) => part.contains(target)) || target.closest(besides(element)))) continue;
    close(false);
  }
}

/** @param {HTMLElement} element */
const besides = ({ dataset: { beside } }) => [".stop", ".toasts", "dialog", ".tour", ...(beside ? [beside] : [])].join();

addEventListener("keydown", dismissByKey, true);
addEventListener("pointerdown", dismissByPress, true);
