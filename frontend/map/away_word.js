// @ts-check
import { find, make } from "../page/elements.js";
import { t } from "../page/language.js";
import { hasLeft, whereRobotIs } from "./shown_area.js";

/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */

/** Says that the robot has left the field, and offers the way back. */
export class AwayWord {
  #line = find("map-away", HTMLElement);
  #shown = false;

  /** @param {() => void} goHome */
  constructor(goHome) {
    this.goHome = goHome;
  }

  /** @param {FieldMessage | null} field @param {TelemetryMessage} telemetry */
  show(field, telemetry) {
    const robot = whereRobotIs(telemetry);
    const left = field !== null && robot !== null && !telemetry.mapping && hasLeft(field, robot);
    if (left === this.#shown) return;
    this.#shown = left;
    this.#line.replaceChildren();
    if (!left) return;
    this.#line.append(t("The robot has left the field."));
    if (telemetry.replay) return;
    const button = make("button", { type: "button" }, t("Back to start"));
    button.onclick = this.goHome;
    this.#line.append(button);
  }
}
