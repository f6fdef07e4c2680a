// @ts-check
import { make } from "../page/elements.js";

/** More would leave the map no room; one wrong thing often raises several doubts. */
const MOST = 2;

/** Reasons for doubt, in plain words; each goes away when its reason does. */
export class Doubts {
  #shown = "";

  /** @param {HTMLElement} list */
  constructor(list) {
    this.list = list;
  }

  /** @param {string[]} alerts the likeliest first */
  show(alerts) {
    const text = alerts.join("\n");
    // The same again would be read out again.
    if (text === this.#shown) return;
    this.#shown = text;
    const lines = alerts.slice(0, MOST);
    if (alerts.length > MOST) lines.push(`and ${alerts.length - MOST} more`);
    this.list.replaceChildren(...lines.map((line) => make("li", {}, line)));
    this.list.title = text;
  }
}
