// @ts-check
import { t, translated } from "../../../page/language.js";
import { find, findButton, make, setText } from "../../../page/elements.js";
import { sentence } from "./desk.js";

/** @typedef {import("../../../messages").LensLookMessage} LensLookMessage */
/** @typedef {import("../../../messages").LensStatusMessage} LensStatusMessage */

const BARS = /** @type {const} */ (["x", "y", "size", "tilt"]);
/** How long it is said that a picture was taken [ms]. */
const TAKEN_MS = 1200;

/** What the present picture is worth, what is missing, and the button to calibrate. */
export class Guide {
  #box = find("guide", HTMLElement);
  #verdict = find("verdict", HTMLElement);
  #steps = find("steps", HTMLElement);
  #taken = find("taken", HTMLElement);
  #calibrate = findButton("calibrate");
  #words = find("calibrate-words", HTMLElement);
  #bars = BARS.map((name) => find(`bar-${name}`, HTMLProgressElement));
  #said = 0;

  /** @param {() => void} calibrate */
  constructor(calibrate) {
    this.#calibrate.onclick = calibrate;
  }

  /** @param {LensStatusMessage} status */
  follow(status) {
    this.#box.hidden = status.board === null;
    this.#judge(status);
    setText(this.#taken, String(status.taken));
    BARS.forEach((name, i) => {
      if (this.#bars[i].value !== status.bars[name]) this.#bars[i].value = status.bars[name];
    });
    this.#showSteps(status.next_steps);
    const enough = status.board !== null && status.next_steps.length === 0;
    this.#calibrate.disabled = status.busy;
    this.#calibrate.classList.toggle("primary", enough);
    setText(this.#calibrate, status.busy ? t("Calibrating …") : t("Calibrate"));
    setText(this.#words, this.#advice(status, enough));
    this.#words.dataset.problem = String(status.problem !== "");
  }

  /** @param {LensStatusMessage} status */
  #judge({ board, look, taken, next_steps, busy }) {
    const now = performance.now();
    if (board === null) return this.#say("idle", t("Choose the board, then start."));
    if (busy) return this.#say("idle", t("Calibrating …"));
    if (look === null) return this.#say("idle", t("Waiting for the camera."));
    if (look.verdict === "taken") {
      this.#said = now;
      return this.#say("taken", t("Picture {number} taken.", { number: taken }));
    }
    // Time to read it: what the next picture lacks is told a moment later.
    if (now - this.#said < TAKEN_MS) return;
    const words = look.verdict === "known" ? (next_steps[0] ?? look.words) : look.words;
    this.#say(look.verdict, sentence(words));
  }

  /** @param {LensLookMessage["verdict"] | "idle"} kind @param {string} words */
  #say(kind, words) {
    this.#verdict.dataset.kind = kind;
    setText(this.#verdict, words);
  }

  /** @param {string[]} steps */
  #showSteps(steps) {
    const words = steps.length ? steps.map(translated) : [t("that is enough: calibrate")];
    if (words.join() === [...this.#steps.children].map((step) => step.textContent).join()) return;
    this.#steps.replaceChildren(...words.map((step) => make("li", {}, step)));
  }

  /** @param {LensStatusMessage} status @param {boolean} enough */
  #advice({ problem, taken, least }, enough) {
    if (problem) return sentence(problem);
    if (taken < least) return t("{least} pictures are needed at least.", { least });
    return enough ? "" : t("It works already; what is missing makes it better.");
  }
}
