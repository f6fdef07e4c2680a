// @ts-check
import { shape } from "./joystick.js";

/** @typedef {import("./lease.js").Drive} Drive */

const POLL_MS = 50;
/** Dead zone of the stick: worn sticks do not come back to zero. */
const DEAD = 0.15;
/** Buttons A and B of the standard layout. */
const FIGURE_EIGHT_BUTTON = 0;
const STOP_BUTTON = 1;

/** The left stick drives, B stops, A drives the figure-eight. Browsers must be polled for it. */
export class GamepadInput {
  /** @type {ReturnType<typeof setInterval> | undefined} */
  #timer;
  #armed = true;
  /** @type {boolean[]} */
  #pressed = [];

  /** @param {Drive} drive @param {(name: string | null) => void} told gets the gamepad's name */
  constructor(drive, told) {
    this.drive = drive;
    this.told = told;
    drive.onStop(() => (this.#armed = false));
    addEventListener("gamepadconnected", () => this.#look());
    addEventListener("gamepaddisconnected", () => this.#look());
  }

  /** @returns {Gamepad | undefined} */
  get #pad() {
    return navigator.getGamepads().find((pad) => pad?.connected) ?? undefined;
  }

  #look() {
    const pad = this.#pad;
    this.told(pad ? pad.id : null);
    clearInterval(this.#timer);
    this.#timer = pad && setInterval(() => this.#poll(), POLL_MS);
    if (!pad) this.drive.hold("gamepad", null);
  }

  #poll() {
    const pad = this.#pad;
    if (!pad || document.hidden) return;
    this.#buttons(pad);
    const [turn, forward] = [-pad.axes[0], -pad.axes[1]].map((axis) =>
      Math.abs(axis) < DEAD ? 0 : shape(axis),
    );
    const held = forward !== 0 || turn !== 0;
    // After a stop, the stick must return to the centre before it drives again.
    if (!held) this.#armed = true;
    this.drive.hold("gamepad", held && this.#armed ? { forward, turn } : null);
  }

  /** @param {Gamepad} pad */
  #buttons(pad) {
    const pressed = pad.buttons.map((button) => button.pressed);
    const fresh = (/** @type {number} */ i) => pressed[i] && !this.#pressed[i];
    if (fresh(STOP_BUTTON)) this.drive.stop();
    else if (fresh(FIGURE_EIGHT_BUTTON)) this.drive.setProgramme(this.drive.programme ? null : "figure_eight");
    this.#pressed = pressed;
  }
}
