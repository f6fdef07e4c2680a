// @ts-check
import { make } from "./elements.js";
import { t } from "./language.js";

/** @typedef {import("./toasts.js").Toasts} Toasts */
/**
 * @typedef {object} Taker
 * @property {string[]} endings as `.svg`
 * @property {() => string} words what it takes, for people
 * @property {(files: File[]) => unknown} take
 */

/** @type {Taker[]} */
const takers = [];

/**
 * Have files of some endings taken that are dropped on the page.
 * @param {string[]} endings @param {() => string} words what they are, for people
 * @param {(files: File[]) => unknown} take gets those of one drop together
 */
export function takeFiles(endings, words, take) {
  takers.push({ endings, words, take });
}

/** Give files to who takes them; say of others what would be valid. @param {File[]} files @param {Toasts} toasts */
export async function offer(files, toasts) {
  const known = (/** @type {File} */ { name }) =>
    takers.find(({ endings }) => endings.some((ending) => name.toLowerCase().endsWith(ending)));
  for (const file of files) {
    if (known(file)) continue;
    const valid = takers.map(({ words }) => words()).join(", ");
    toasts.show(t("{name} is no file that this page can open. Valid are {valid}.", { name: file.name, valid }));
  }
  for (const taker of takers) {
    const own = files.filter((file) => known(file) === taker);
    if (own.length) await taker.take(own);
  }
}

/** Let files be dropped anywhere on the page, and show that they can be. @param {Toasts} toasts */
export function welcomeFiles(toasts) {
  const sign = make("p", { class: "drop-sign", hidden: "" });
  document.body.append(sign);
  const shows = (/** @type {DragEvent} */ event) => event.dataTransfer?.types.includes("Files");
  addEventListener("dragover", (event) => {
    event.preventDefault();
    if (!shows(event) || !sign.hidden) return;
    sign.textContent = t("Drop it here: {valid}", { valid: takers.map(({ words }) => words()).join(", ") });
    sign.hidden = false;
  });
  addEventListener("dragleave", (event) => (sign.hidden = event.relatedTarget === null || sign.hidden));
  addEventListener("drop", (event) => {
    event.preventDefault();
    sign.hidden = true;
    offer([...(event.dataTransfer?.files ?? [])], toasts);
  });
}
