// @ts-check
import { find, make, setText } from "../../page/elements.js";
import { t } from "../../page/language.js";

const KEY = "brickpose-passed";

/** The lessons at the top of the page; those that have passed, here or elsewhere, have a tick. */
export class LessonList {
  /** @param {number} current */
  constructor(current) {
    this.current = current;
    this.list = find("lessons", HTMLElement);
    /** @type {{number: number, title: string, passed: boolean}[]} */
    this.lessons = [];
  }

  /** @param {{number: number, title: string, passed: boolean}[]} lessons */
  show(lessons) {
    this.lessons = lessons;
    this.list.replaceChildren(...lessons.map((lesson) => this.#entry(lesson)));
    this.#showNext();
  }

  /** Note that a lesson has passed. @param {number} number */
  note(number) {
    const passed = this.#passed();
    if (passed.has(number)) return;
    localStorage.setItem(KEY, JSON.stringify([...passed, number]));
    this.show(this.lessons);
  }

  /** A way on to the next lesson, as soon as this one has passed. */
  #showNext() {
    const next = this.lessons[this.lessons.findIndex(({ number }) => number === this.current) + 1];
    find("next", HTMLElement).hidden = !next || !this.#passed().has(this.current);
    if (!next) return;
    const link = find("next-link", HTMLAnchorElement);
    link.href = `learn/${next.number}`;
    setText(link, t("Next: {number}. {title}", next));
  }

  /** @param {{number: number, title: string}} lesson */
  #entry({ number, title }) {
    const passed = this.#passed().has(number);
    const name = passed ? t("{title} (passed)", { title }) : title;
    const attributes = { href: `learn/${number}`, title: name, "aria-label": `${number}. ${name}` };
    const link = make("a", attributes, passed ? `${number} ✓` : String(number));
    if (number === this.current) link.setAttribute("aria-current", "page");
    return make("li", {}, link);
  }

  /** @returns {Set<number>} */
  #passed() {
    const kept = this.lessons.filter(({ passed }) => passed).map(({ number }) => number);
    try {
      return new Set([...kept, ...JSON.parse(localStorage.getItem(KEY) ?? "[]")]);
    } catch {
      return new Set(kept);
    }
  }
}
