// @ts-check
import { find, make } from "../../page/elements.js";
import { t } from "../../page/language.js";

/** @typedef {import("../../messages").Command} Command */
/** @typedef {import("./main.js").Section} Section */

/** What comes after the prediction: watch, what happened beside the prediction, write, break it. */
export class Sections {
  /** @param {(command: Command) => void} order */
  constructor(order) {
    this.order = order;
    this.place = find("sections", HTMLElement);
  }

  /** @param {Section[]} sections @param {{choice: string, reason: string} | null} prediction */
  show(sections, prediction) {
    const made = sections.map(({ title, html }, index) => {
      const words = make("div", { class: "words" });
      words.innerHTML = html;
      const beside = index === 1 && prediction ? [besideIt(prediction)] : [];
      return make("section", {}, make("h2", {}, title), ...beside, words);
    });
    this.place.replaceChildren(...made);
  }
}

/** @param {{choice: string, reason: string}} prediction */
function besideIt({ choice, reason }) {
  const words = [choice, reason].filter(Boolean).join(" – ");
  return make("p", { class: "beside" }, make("strong", {}, t("You predicted:")), ` ${words}`);
}
