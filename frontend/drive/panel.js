// @ts-check
import { find, findButton, findInput, setText } from "../page/elements.js";
import { plain } from "../page/format.js";
import { GamepadInput } from "./gamepad.js";
import { Joystick } from "./joystick.js";
import { Keys } from "./keys.js";
import { Drive } from "./lease.js";

/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../wire/connection.js").Connection} Connection */

/** Everything that moves the robot, and what stops it. */
export class DrivePanel {
  #eight = findButton("figure-eight");
  #slider = findInput("speed");
  #hint = find("drive-hint", HTMLElement);
  #pad = find("gamepad", HTMLElement);

  /** @param {Connection} connection */
  constructor(connection) {
    this.drive = new Drive(
      (command) => connection.post(command),
      () => this.#show(),
    );
    const knob = find("knob", HTMLElement);
    this.joystick = new Joystick(find("joystick", HTMLElement), knob, this.drive);
    this.keys = new Keys(this.drive);
    this.gamepad = new GamepadInput(this.drive, (name) => setText(this.#pad, padText(name)));
    for (const stop of ["stop", "stop-thumb"]) this.#wireStop(findButton(stop));
    this.#eight.onclick = () => this.drive.setFigureEight(!this.drive.figureEight);
    this.#slider.addEventListener("input", () => this.#setSpeed());
    connection.onState((state) => state === "lost" && this.#lost());
    this.#setSpeed();
  }

  /** @param {FieldMessage} field */
  setField({ max_v, max_omega, drive_timeout }) {
    this.drive.maxV = max_v;
    this.drive.maxOmega = max_omega;
    this.drive.timeout = drive_timeout * 1000;
    this.#slider.max = String(max_v);
    this.#setSpeed();
  }

  /** @param {TelemetryMessage} telemetry */
  describe({ twist: { v, omega } }) {
    setText(this.#hint, `${plain(v, 2)} m/s, ${plain(omega, 1)} rad/s`);
  }

  /** Stop acts on the press, not on the release. @param {HTMLButtonElement} button */
  #wireStop(button) {
    button.addEventListener("pointerdown", () => this.drive.stop());
    button.addEventListener("click", () => this.drive.stop());
  }

  #lost() {
    this.drive.disconnect();
    setText(this.#hint, "not connected");
  }

  #setSpeed() {
    this.drive.speed = this.#slider.valueAsNumber;
    const text = `${plain(this.drive.speed, 2)} m/s`;
    setText(find("speed-value", HTMLElement), text);
    this.#slider.setAttribute("aria-valuetext", text);
  }

  #show() {
    this.#eight.setAttribute("aria-pressed", String(this.drive.figureEight));
    this.joystick?.show();
  }
}

/** @param {string | null} name */
const padText = (name) => (name ? "gamepad: left stick drives, B stops" : "");
