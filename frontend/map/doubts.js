// @ts-check
import { t, translated } from "../page/language.js";
import { make } from "../page/elements.js";

/** Most doubts shown: more would hide the map, and a single error often raises several doubts. */
const MOST = 2;

/** Reasons for doubt in plain words; each disappears with its cause. */
export class Doubts {
  #shown = "";

  /** @param {HTMLElement} list */
  constructor(list) {
    this.list = list;
  }

  /** @param {string[]} alerts the newest first */
  show(alerts) {
    const words = alerts.map(translated);
    const text = words.join("\n");
    // Screen readers would read the same text out again.
    if (text === this.#shown) return;
    this.#shown = text;
    const lines = words.slice(0, MOST);
    if (alerts.length > MOST) lines.push(t("and {count} more", { count: alerts.length - MOST }));
    this.list.replaceChildren(...lines.map((line) => make("li", {}, line)));
    this.list.title = text;
  }
}
