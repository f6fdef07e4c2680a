// @ts-check
/** The tour of a minute: a few words beside each part of the real page. */
import { make } from "../page/elements.js";
import { t } from "../page/language.js";
import { loadStyle } from "./style.js";

/** @typedef {{at: string, tab?: string, title: string, text: string}} Step */

/** @type {Step[]} */
const STEPS = [
  {
    at: "#map",
    tab: "map",
    title: t("Where the robot is"),
    text: t("The field from above. Blue is what the filter believes: particles, and the robot where they say it is. Green is the truth, which only a simulator knows. The words above say how sure the filter is."),
  },
  {
    at: "#drive",
    title: t("Drive"),
    text: t("W A S D, the arrow keys or the joystick. The figure-eight drives by itself. The space bar and STOP stop at once; when you let go, the robot stops."),
  },
  {
    at: "#camera",
    tab: "camera",
    title: t("What it sees"),
    text: t("The scanner looks along rays for tape. Click a ray to see why it counted, or why not."),
  },
  {
    at: "#map .beside",
    tab: "map",
    title: t("Let it get lost"),
    text: t("Scatter makes the filter forget where it is; move robot, above the map, carries the robot off. Then drive, and watch it find itself. Back to start mends all."),
  },
  {
    at: "#filter",
    tab: "filter",
    title: t("Change how it thinks"),
    text: t("A changed parameter takes effect at once. A dot marks one that differs from its default, and the arrow resets it. The question mark explains them all."),
  },
  {
    at: "#help-open",
    title: t("When in doubt"),
    text: t("Keys, what is drawn, the documents, and this tour again: press the question mark."),
  },
];

/** Gap between the words and what they are about [CSS px]. */
const GAP = 12;

/** @type {Tour | null} */
let running = null;

/** Show the page round, from the beginning. @param {() => void} ended */
export async function beginTour(ended) {
  running?.end();
  await loadStyle();
  running = new Tour(ended);
  running.go(0, 1);
}

class Tour {
  #at = 0;
  #title = make("h2", { id: "tour-title", tabindex: "-1" });
  #text = make("p", { id: "tour-text" });
  #count = make("span", { class: "quiet" });
  #back = this.#button(t("Back"), () => this.go(this.#at - 1, -1));
  #next = this.#button(t("Next"), () => this.go(this.#at + 1, 1));
  #before = document.activeElement;
  #box = /** @type {HTMLDialogElement} */ (
    make(
      "dialog",
      { id: "tour", class: "tour", "aria-labelledby": "tour-title", "aria-describedby": "tour-text" },
      this.#title,
      this.#text,
      make("div", { class: "tools" }, this.#count, this.#button(t("End the tour"), () => this.end()), this.#back, this.#next),
    )
  );
  #place = () => this.#beside();

  /** @param {() => void} ended */
  constructor(ended) {
    this.ended = ended;
    this.#next.classList.add("primary");
    this.#box.addEventListener("keydown", (event) => this.#key(event));
    addEventListener("resize", this.#place);
    document.body.append(this.#box);
    // Not modal: what it shows can be used, STOP above all.
    this.#box.show();
  }

  /** Go to a step; those of panels that are not shown are passed over. @param {number} at @param {1 | -1} way */
  go(at, way) {
    if (at >= STEPS.length || at < 0) return this.end();
    const { tab, title, text } = STEPS[at];
    if (tab) this.#turnTo(tab);
    this.#at = at;
    if (!this.#target?.checkVisibility()) return this.go(at + way, way);
    this.#title.textContent = title;
    this.#text.textContent = text;
    this.#count.textContent = t("{step} of {steps}", { step: at + 1, steps: STEPS.length });
    this.#back.toggleAttribute("disabled", at === 0);
    this.#next.textContent = at === STEPS.length - 1 ? t("Done") : t("Next");
    this.#mark(this.#target);
    this.#beside();
    this.#title.focus();
  }

  /** End it, as the user wishes; it does not come again by itself. */
  end() {
    this.#mark(null);
    removeEventListener("resize", this.#place);
    this.#box.remove();
    running = null;
    this.ended();
    if (this.#before instanceof HTMLElement) this.#before.focus();
  }

  get #target() {
    const { at } = STEPS[this.#at];
    const target = document.querySelector(at);
    if (target?.checkVisibility()) return target;
    // On a phone the button of the help is behind another one; on a wide page a button shows the filter.
    const instead = { "#help-open": "#more", "#filter": '[data-panels~="filter"]' }[at];
    return instead ? document.querySelector(instead) : target;
  }

  /** On a phone one panel is shown at a time. @param {string} name */
  #turnTo(name) {
    const tab = document.querySelector(`#tabs [data-name=${name}]`);
    if (tab instanceof HTMLElement && tab.checkVisibility()) tab.click();
  }

  /** @param {Element | null} target */
  #mark(target) {
    for (const one of document.querySelectorAll("[data-toured]")) one.removeAttribute("data-toured");
    target?.setAttribute("data-toured", "");
  }

  /** Stand at the right of what is shown, else at its left, below or above it, or on its foot. */
  #beside() {
    const about = this.#target?.getBoundingClientRect();
    if (!about) return;
    const { offsetWidth: width, offsetHeight: height } = this.#box;
    const [right, left] = [about.right + GAP, about.left - width - GAP];
    const [below, above] = [about.bottom + GAP, about.top - height - GAP];
    const across = Math.max(GAP, Math.min(about.left, innerWidth - width - GAP));
    const level = Math.max(GAP, Math.min(about.top, innerHeight - height - GAP));
    /** @type {[number, number]} */
    let [x, y] = [across, Math.max(GAP, about.bottom - height - GAP)];
    if (right + width < innerWidth) [x, y] = [right, level];
    else if (left > 0) [x, y] = [left, level];
    else if (below + height < innerHeight) [x, y] = [across, below];
    else if (above > 0) [x, y] = [across, above];
    this.#box.style.left = `${x}px`;
    this.#box.style.top = `${y}px`;
  }

  /** @param {string} words @param {() => void} pressed */
  #button(words, pressed) {
    const button = make("button", { type: "button" }, words);
    button.onclick = pressed;
    return button;
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.key !== "Escape") return;
    event.preventDefault();
    this.end();
  }
}
