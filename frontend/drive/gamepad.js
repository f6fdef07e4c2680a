// @ts-check
import { shape } from "./joystick.js";

/** @typedef {import("./lease.js").Drive} Drive */

const POLL_MS = 50;
/** Dead zone of the stick: worn sticks do not come back to zero. */
const DEAD = 0.15;
/** Buttons A and B of the standard layout. */
const FIGURE_EIGHT_BUTTON = 0;
const STOP_BUTTON = 1;

/**
 * The left stick drives, B stops, A drives the figure-eight. Browsers must be polled for it.
 *
 * A stick must first be seen at rest: some gamepads report their axes at the ends until they are
 * moved, and unknown ones have a trigger in the stick's place, which rests at its end.
 */
export class GamepadInput {
  /** @type {ReturnType<typeof setInterval> | undefined} */
  #timer;
  #armed = false;
  /** Buttons of the last look; null before the first. @type {boolean[] | null} */
  #pressed = null;

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
    this.#armed = false;
    this.#pressed = null;
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
    // A page is told of a gamepad when one of its buttons is pressed, which means no more than that.
    const before = this.#pressed ?? pressed;
    const fresh = (/** @type {number} */ i) => pressed[i] && !before[i];
    if (fresh(STOP_BUTTON)) this.drive.stop();
    else if (fresh(FIGURE_EIGHT_BUTTON)) this.drive.setProgramme(this.drive.programme ? null : "figure_eight");
    this.#pressed = pressed;
  }
}
