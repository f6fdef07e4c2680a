// @ts-check
import { t, translated } from "./language.js";
import { make } from "./elements.js";

const SHOWN_MS = 7000;
const MOST = 3;

/** Short messages about the last action, at the foot of the page; screen readers read them. */
export class Toasts {
  /** @param {HTMLElement} list a live region */
  constructor(list) {
    this.list = list;
  }

  /** @param {string} text in plain words @param {"problem" | "note"} [kind] */
  show(text, kind = "problem") {
    for (const old of [...this.list.children])
      if (old.firstChild?.textContent === text) old.remove();
    const close = make("button", { type: "button", "aria-label": t("Close this message") }, "×");
    const toast = make("div", { class: `toast ${kind}` }, make("span", {}, text), close);
    close.onclick = () => toast.remove();
    setTimeout(() => toast.remove(), SHOWN_MS);
    this.list.append(toast);
    while (this.list.children.length > MOST) this.list.firstElementChild?.remove();
  }

  /** Show why something failed. @param {unknown} error */
  fail(error) {
    this.show(sentence(error));
  }
}

/** @param {unknown} error @returns {string} its message as a sentence, in the page's language */
export function sentence(error) {
  const text = translated(error instanceof Error ? error.message : String(error));
  // Names from the program, such as z_rand, keep their spelling.
  const plain = /^[a-z]+[ ,;:']/.test(text);
  const start = plain ? text.charAt(0).toUpperCase() + text.slice(1) : text;
  return /[.!?]$/.test(start) ? start : `${start}.`;
}
