// @ts-check
import { findButton } from "../page/elements.js";
import { degrees, millimetres } from "../page/format.js";
import { t } from "../page/language.js";

/** @typedef {import("../messages").Command} Command */
/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../page/toasts.js").Toasts} Toasts */

/** Brings robot and filter back to the field's start; a real robot is carried there. */
export class Home {
  /** @type {FieldMessage | null} */
  #field = null;
  #carried = false;
  #button = findButton("home");

  /** @param {(command: Command) => Promise<boolean>} order @param {Toasts} toasts */
  constructor(order, toasts) {
    this.order = order;
    this.toasts = toasts;
    this.#button.onclick = () => this.go();
  }

  /** @param {FieldMessage} field */
  setField(field) {
    this.#field = field;
    this.#button.disabled = false;
  }

  /** @param {TelemetryMessage} telemetry */
  follow({ robot }) {
    this.#carried = !robot.can_be_placed;
  }

  async go() {
    if (!this.#field) return;
    const { start, initial_sd_xy: sd_xy, initial_sd_theta: sd_theta } = this.#field;
    if (!(await this.order(this.#carried ? { type: "stop" } : { type: "place", ...start }))) return;
    if (!(await this.order({ type: "set_pose", ...start, sd_xy, sd_theta }))) return;
    if (this.#carried) this.toasts.show(whereToPut(start), "note");
  }
}

/** @param {import("../messages").PoseMessage} start */
const whereToPut = ({ x, y, theta }) =>
  t("Put the robot at x {x}, y {y}, heading {heading}: there the filter believes it now.", {
    x: millimetres(x),
    y: millimetres(y),
    heading: degrees(theta),
  });
