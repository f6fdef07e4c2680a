// @ts-check
import { t, translated } from "../page/language.js";
import { find, findButton, findInput, setText } from "../page/elements.js";
import { plain } from "../page/format.js";
import { GamepadInput } from "./gamepad.js";
import { Joystick } from "./joystick.js";
import { Keys } from "./keys.js";
import { Drive } from "./lease.js";
import { OwnDrive } from "./own_drive.js";

/** @typedef {import("../messages").AccessMessage} AccessMessage */
/** @typedef {import("../messages").Command} Command */
/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../wire/connection.js").Connection} Connection */

/** Everything that moves the robot, and what stops it. */
export class DrivePanel {
  #eight = findButton("figure-eight");
  #slider = findInput("speed");
  #hint = find("drive-hint", HTMLElement);
  #pad = find("gamepad", HTMLElement);
  #who = find("drive-who", HTMLElement);
  #take = findButton("take");
  /** @type {OwnDrive} */
  #ownEight;
  #replayed = false;
  #watches = false;
  #why = "";

  /**
   * @param {Connection} connection
   * @param {(command: Command) => Promise<boolean>} order
   */
  constructor(connection, order) {
    this.drive = new Drive(connection, () => this.#show());
    const knob = find("knob", HTMLElement);
    this.joystick = new Joystick(find("joystick", HTMLElement), knob, this.drive);
    this.keys = new Keys(this.drive);
    this.gamepad = new GamepadInput(this.drive, (name) => setText(this.#pad, padText(name)));
    for (const stop of ["stop", "stop-thumb"]) this.#wireStop(findButton(stop));
    const eight = new OwnDrive(this.drive, order, "figure_eight");
    this.#ownEight = eight;
    this.#eight.onclick = () => this.#toggleEight(eight, order);
    this.#take.onclick = () => this.drive.take();
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

  /** @param {boolean} replayed whether a recording is shown, which cannot be driven */
  setReplay(replayed) {
    this.#replayed = replayed;
    this.#allow();
  }

  /** @param {AccessMessage} access what this page's link allows, and why not more */
  setAccess({ role, why }) {
    this.#watches = role === "watch";
    this.#why = why ? translated(why) : t("this link only watches");
    this.#allow();
  }

  /** @param {TelemetryMessage} telemetry */
  describe({ mode, twist: { v, omega } }) {
    // It goes on by itself when what holds it up is mended.
    if (this.#ownEight.mine && mode !== "figure_eight") {
      return setText(this.#hint, t("the figure-eight waits"));
    }
    setText(this.#hint, `${plain(v, 2)} m/s, ${plain(omega, 1)} rad/s`);
  }

  /** Show who drives, at once. @param {TelemetryMessage} telemetry */
  follow(telemetry) {
    const { mode, driver } = telemetry;
    const { stopped } = driver;
    this.drive.follow(telemetry);
    this.#ownEight.heed(mode === "figure_eight", stopped);
    const { other, possible } = this.drive;
    const held = stopped ? t("stopped; a new press drives on") : "";
    const words = other ? t("{name} drives", { name: translated(other) }) : held;
    setText(this.#who, this.#watches ? this.#why : words);
    this.#take.hidden = other === null || !possible;
    this.#hint.hidden = this.#who.textContent !== "";
  }

  /** @param {OwnDrive} eight @param {(command: Command) => Promise<boolean>} order */
  #toggleEight(eight, order) {
    if (eight.mine) eight.end();
    else if (this.drive.mayBegin) {
      // What was asked for is seen at once; what is so, when the robot has told.
      this.#eight.setAttribute("aria-pressed", "true");
      eight.begin().then(() => this.#show());
    }
    // The refusal says who drives, and what to do.
    else if (this.drive.possible) order({ ...this.drive.programmed("figure_eight"), start: true });
  }

  /** Stop acts on the press, not on the release. @param {HTMLButtonElement} button */
  #wireStop(button) {
    button.addEventListener("pointerdown", () => this.drive.stop());
    button.addEventListener("click", () => this.drive.stop());
  }

  #allow() {
    this.drive.possible = !this.#replayed && !this.#watches;
  }

  #lost() {
    this.drive.disconnect();
    setText(this.#hint, t("not connected"));
  }

  #setSpeed() {
    this.drive.speed = this.#slider.valueAsNumber;
    const text = `${plain(this.drive.speed, 2)} m/s`;
    setText(find("speed-value", HTMLElement), text);
    this.#slider.setAttribute("aria-valuetext", text);
  }

  #show() {
    this.#eight.setAttribute("aria-pressed", String(this.drive.programme === "figure_eight"));
    this.joystick?.show();
  }
}

/** @param {string | null} name */
const padText = (name) => (name ? t("gamepad: left stick drives, B stops") : "");
