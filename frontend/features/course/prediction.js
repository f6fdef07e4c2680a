// @ts-check
import { find, make, setText } from "../../page/elements.js";
import { t } from "../../page/language.js";

/** @typedef {import("./main.js").Section} Section */
/** @typedef {{choice: string, reason: string}} Kept */

/** The question that comes before anything moves; the answer is kept in this browser. */
export class Prediction {
  /**
   * @param {number} number of the lesson
   * @param {Section | undefined} question
   * @param {(prediction: Kept | null) => void} opened called when the rest may be shown
   */
  constructor(number, question, opened) {
    this.key = `brickpose-prediction-${number}`;
    this.opened = opened;
    this.reason = find("reason", HTMLTextAreaElement);
    if (!question) {
      find("predict", HTMLElement).hidden = true;
      opened(null);
      return;
    }
    setText(find("predict-title", HTMLElement), question.title);
    find("question", HTMLElement).innerHTML = question.html;
    const kept = this.#kept();
    const choices = question.choices.map((choice, index) => choiceOf(choice, index, kept));
    find("choices", HTMLElement).replaceChildren(...choices);
    this.reason.value = kept?.reason ?? "";
    const form = find("prediction", HTMLFormElement);
    form.onsubmit = (event) => {
      event.preventDefault();
      this.#keep(form, question.choices);
    };
    if (kept) this.#open({ ...kept, choice: question.choices[Number(kept.choice)] ?? "" });
  }

  /** @param {HTMLFormElement} form @param {string[]} choices */
  #keep(form, choices) {
    const index = String(new FormData(form).get("choice") ?? "");
    const reason = this.reason.value.trim();
    if (index === "" && (choices.length || reason === "")) {
      setText(find("kept", HTMLElement), t("Choose first what you think."));
      return;
    }
    localStorage.setItem(this.key, JSON.stringify({ choice: index, reason }));
    this.#open({ choice: choices[Number(index)] ?? "", reason });
  }

  /** @param {Kept} prediction */
  #open(prediction) {
    setText(find("kept", HTMLElement), t("Kept. Now look what happens."));
    this.opened(prediction);
  }

  /** @returns {Kept | null} the choice by its number: its words depend on the language */
  #kept() {
    try {
      return JSON.parse(localStorage.getItem(this.key) ?? "null");
    } catch {
      return null;
    }
  }
}

/** @param {string} text @param {number} index @param {Kept | null} kept */
function choiceOf(text, index, kept) {
  const input = make("input", { type: "radio", name: "choice", value: String(index) });
  if (kept?.choice === String(index)) input.setAttribute("checked", "");
  return make("label", {}, input, make("span", {}, text));
}
