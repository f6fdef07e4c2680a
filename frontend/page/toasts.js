// @ts-check
import { t, translated } from "./language.js";
import { make } from "./elements.js";

const SHOWN_MS = 7000;
const MOST = 3;

/** Short messages about the last action, at the foot of the page; screen readers read them. */
export class Toasts {
  /** The last offer. @type {HTMLElement | undefined} */
  #offered;

  /** @param {HTMLElement} list a live region */
  constructor(list) {
    this.list = list;
  }

  /** @param {string} text in plain words @param {"problem" | "note"} [kind] */
  show(text, kind = "problem") {
    const toast = this.#add(text, kind);
    setTimeout(() => toast.remove(), SHOWN_MS);
  }

  /** Show a message that stays, with what can be done about it. @param {string} text @param {string} action its button's words @param {() => void} act */
  offer(text, action, act) {
    this.withdraw();
    const button = make("button", { type: "button" }, action);
    const toast = (this.#offered = this.#add(text, "note", button));
    button.onclick = () => {
      toast.remove();
      act();
    };
  }

  /** Take an offer back, as it is out of date. */
  withdraw() {
    this.#offered?.remove();
  }

  /** @param {string} text @param {"problem" | "note"} kind @param {HTMLElement[]} actions */
  #add(text, kind, ...actions) {
    for (const old of [...this.list.children])
      if (old.firstChild?.textContent === text) old.remove();
    const close = make("button", { type: "button", "aria-label": t("Close this message") }, "×");
    const toast = make("div", { class: `toast ${kind}` }, make("span", {}, text), ...actions, close);
    close.onclick = () => toast.remove();
    this.list.dataset.side = awayFromDrive();
    this.list.append(toast);
    while (this.list.children.length > MOST) this.list.firstElementChild?.remove();
    return toast;
  }

  /** Show why something failed. @param {unknown} error */
  fail(error) {
    this.show(sentence(error));
  }
}

/** At the foot of the page, where no button that drives lies below. @returns {"left" | "right"} */
function awayFromDrive() {
  const drive = document.getElementById("drive")?.getBoundingClientRect();
  return drive && drive.left + drive.right > innerWidth ? "left" : "right";
}

/** @param {unknown} error @returns {string} its message as a sentence, in the page's language */
export function sentence(error) {
  const text = translated(error instanceof Error ? error.message : String(error));
  // Names from the program, such as z_rand, keep their spelling.
  const plain = /^[a-z]+[ ,;:']/.test(text);
  const start = plain ? text.charAt(0).toUpperCase() + text.slice(1) : text;
  return /[.!?]$/.test(start) ? start : `${start}.`;
}
