// @ts-check
import { t, translated } from "../page/language.js";
import { make, setText } from "../page/elements.js";
import { readNumber, typed } from "../page/format.js";
import { STEPS, SliderScale } from "./slider.js";
import { readAs } from "./units.js";

/** @typedef {import("../messages").ParameterMessage} ParameterMessage */
/** @typedef {number | string | boolean} Value */

/** One parameter: its name and meaning, a control to change it, and a button for its default. */
export class ParameterRow {
  element = make("div", { class: "parameter" });
  #refusal = make("p", { class: "refusal", role: "alert" });
  #back = /** @type {HTMLButtonElement} */ (make("button", { type: "button", class: "back" }, "↺"));
  /** Whether the user is changing it here, so that values from the server must wait. */
  busy = false;

  /**
   * @param {ParameterMessage} parameter
   * @param {string} words a plain name, or none
   * @param {(name: string, value: Value) => void} changed
   */
  constructor(parameter, words, changed) {
    this.parameter = parameter;
    this.changed = changed;
    /** What is read out; a reference to the title would be empty while that is scrolled out. */
    this.words = `${words} ${parameter.name}`.trim();
    const { name } = parameter;
    const meaning = translated(parameter.meaning);
    const parts = name.split(/(?<=_)/).flatMap((part) => [part, make("wbr")]); // a line may end there
    const code = make("span", { class: words && "quiet" }, ...parts);
    const title = make(
      "span",
      { class: "name", id: `name-${name}`, title: `${name}: ${meaning}` },
      words,
      " ",
      code,
    );
    const about = make("p", { class: "meaning", id: `meaning-${name}` }, meaning);
    this.#back.setAttribute("aria-label", t("Set {name} back to its default, {value}", { name, value: this.#words(parameter.default) }));
    this.#back.title = t("default: {value}", { value: this.#words(parameter.default) });
    this.#back.onclick = () => this.#change(parameter.default);
    this.show = this.#control();
    this.element.prepend(title);
    this.element.append(this.#back, about, this.#refusal);
    this.accept(parameter.value);
  }

  /** Show the value that holds on the robot. @param {Value} value */
  accept(value) {
    this.parameter = { ...this.parameter, value };
    this.busy = false;
    this.refuse("");
    this.show(value);
    const standard = value === this.parameter.default;
    this.element.dataset.changed = String(!standard);
    this.#back.disabled = standard;
  }

  /** Only what the chosen filter and models use can be changed. @param {boolean} used */
  use(used) {
    this.element.dataset.used = String(used);
    this.element.title = used ? "" : t("The chosen filter and models do not use it");
    for (const part of this.element.querySelectorAll("input, select, button")) {
      part.toggleAttribute("disabled", !used);
    }
    if (used) this.#back.disabled = this.parameter.value === this.parameter.default;
  }

  /** Whether another message has the same choices. @param {ParameterMessage} other */
  offers({ choices }) {
    return choices.join() === this.parameter.choices.join();
  }

  /** Show why a change was refused. @param {string} reason */
  refuse(reason) {
    setText(this.#refusal, reason);
    if (!reason) return;
    this.busy = false;
    this.show(this.parameter.value);
  }

  /** @param {Value} value */
  #change(value) {
    this.busy = true;
    this.show(value);
    this.changed(this.parameter.name, value);
  }

  /** Build the control. @returns {(value: Value) => void} writes a value into the control */
  #control() {
    if (this.parameter.choices.length > 0) return this.#choice();
    return typeof this.parameter.default === "boolean" ? this.#switch() : this.#number();
  }

  /** @returns {Record<string, string>} names and descriptions for screen readers */
  get #labels() {
    const { name } = this.parameter;
    return { name, "aria-label": this.words, "aria-describedby": `meaning-${name}` };
  }

  #choice() {
    const own = this.parameter.choices.filter(isOwn).map(option);
    const options = this.parameter.choices.filter((choice) => !isOwn(choice)).map(option);
    if (own.length) options.push(make("optgroup", { label: t("your own") }, ...own));
    const select = /** @type {HTMLSelectElement} */ (make("select", this.#labels, ...options));
    select.onchange = () => this.#change(select.value);
    this.element.append(select);
    return (/** @type {Value} */ value) => void (select.value = String(value));
  }

  #switch() {
    const button = /** @type {HTMLButtonElement} */ (
      make("button", { type: "button", role: "switch", class: "switch", ...this.#labels })
    );
    button.onclick = () => this.#change(button.getAttribute("aria-checked") !== "true");
    this.element.append(button);
    return (/** @type {Value} */ value) => {
      button.setAttribute("aria-checked", String(value));
      setText(button, value ? t("on") : t("off"));
    };
  }

  #number() {
    const scale = new SliderScale(this.parameter);
    const { unit, factor } = readAs(this.parameter.unit);
    const range = { type: "range", min: "0", max: String(STEPS), step: "any" };
    const slider = /** @type {HTMLInputElement} */ (make("input", { ...range, ...this.#labels }));
    const field = /** @type {HTMLInputElement} */ (
      make("input", { type: "text", inputmode: "decimal", autocomplete: "off", ...this.#labels })
    );
    slider.oninput = () => this.#change(scale.fromSlider(slider.valueAsNumber));
    field.onchange = () => this.#typed(readNumber(field.value) / factor);
    this.element.append(slider, field, make("span", { class: "unit" }, unit));
    return (/** @type {Value} */ value) => {
      if (document.activeElement !== slider) slider.value = String(scale.toSlider(Number(value)));
      field.value = typed(Number((Number(value) * factor).toPrecision(6)));
      slider.setAttribute("aria-valuetext", this.#words(value));
    };
  }

  /** @param {number} value */
  #typed(value) {
    if (Number.isFinite(value)) this.#change(Number(value.toPrecision(9)));
    else this.refuse(t("That is not a number."));
  }

  /** @param {Value} value */
  #words(value) {
    if (typeof value !== "number") return String(value);
    const { unit, factor } = readAs(this.parameter.unit);
    return `${typed(Number((value * factor).toPrecision(4)))} ${unit}`.trim();
  }
}

/** Whether it is a user's own model: `my_model.py:MyModel`. @param {string} choice */
const isOwn = (choice) => choice.includes(":");

/** @param {string} choice */
const option = (choice) => make("option", {}, choice);
