// @ts-check
import { DecimalField } from "../page/decimal.js";
import { find, findButton, findInput, setText } from "../page/elements.js";
import { degrees, millimetres } from "../page/format.js";

/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../messages").PoseMessage} PoseMessage */
/** @typedef {"set_pose" | "place" | "goal"} Act */

/** What buttons of the form do, besides telling the filter. @type {Record<string, Act>} */
const ACTS = { "numbers-place": "place", "numbers-goal": "goal" };

/** A form for a pose in exact numbers, and for the spread of poses that are sent to the filter. */
export class NumbersForm {
  #x = new DecimalField("pose-x");
  #y = new DecimalField("pose-y");
  #heading = new DecimalField("pose-heading");
  #spread = findInput("spread-xy");
  #turn = findInput("spread-theta");

  /**
   * @param {(act: Act, pose: PoseMessage) => void} act
   * @param {() => void} changed when the spread changes
   */
  constructor(act, changed) {
    const form = find("numbers", HTMLFormElement);
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      act(ACTS[event.submitter?.id ?? ""] ?? "set_pose", this.pose);
    });
    for (const slider of [this.#spread, this.#turn]) {
      slider.addEventListener("input", () => {
        this.#tell();
        changed();
      });
    }
    this.#tell();
  }

  /** Standard deviation of x and y of a pose that is sent [m]; the slider is logarithmic. */
  get sdXy() {
    return 10 ** this.#spread.valueAsNumber;
  }

  /** Standard deviation of its heading [rad]. */
  get sdTheta() {
    return (this.#turn.valueAsNumber * Math.PI) / 180;
  }

  /** @returns {PoseMessage} */
  get pose() {
    return {
      x: this.#x.value / 1000,
      y: this.#y.value / 1000,
      theta: (this.#heading.value * Math.PI) / 180,
    };
  }

  /** Begin with the start pose and the configured spread. @param {FieldMessage} field */
  setField({ start, initial_sd_xy, initial_sd_theta }) {
    this.pose = start;
    this.#spread.value = String(Math.log10(initial_sd_xy));
    this.#turn.value = String((initial_sd_theta * 180) / Math.PI);
    this.#tell();
  }

  /** Write a pose into the form, for small corrections. @param {PoseMessage} pose */
  set pose({ x, y, theta }) {
    this.#x.value = tenths(x * 1000);
    this.#y.value = tenths(y * 1000);
    this.#heading.value = tenths((theta * 180) / Math.PI);
  }

  /** @param {boolean} possible whether this robot can be put elsewhere by a command */
  allowPlacing(possible) {
    findButton("numbers-place").hidden = !possible;
  }

  #tell() {
    const [xy, theta] = [`± ${millimetres(this.sdXy)}`, `± ${degrees(this.sdTheta)}`];
    setText(find("spread-xy-value", HTMLElement), xy);
    setText(find("spread-theta-value", HTMLElement), theta);
    this.#spread.setAttribute("aria-valuetext", xy);
    this.#turn.setAttribute("aria-valuetext", theta);
  }
}

/** @param {number} value */
const tenths = (value) => Math.round(value * 10) / 10;
