// @ts-check
/** @typedef {import("./lease.js").Drive} Drive */

/** Dead zone in the middle, where the robot stands still. */
const DEAD = 0.1;

/** The on-screen stick, for a finger, a pen or a mouse; it also shows what the keys do. */
export class Joystick {
  #pointer = -1;

  /** @param {HTMLElement} base @param {HTMLElement} knob @param {Drive} drive */
  constructor(base, knob, drive) {
    this.base = base;
    this.knob = knob;
    this.drive = drive;
    drive.onStop(() => this.#letGo());
    base.addEventListener("pointerdown", (event) => this.#down(event));
    base.addEventListener("pointermove", (event) => this.#move(event));
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      base.addEventListener(end, (event) => this.#up(/** @type {PointerEvent} */ (event)));
    }
    base.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /** Move the knob to the sum of all inputs. */
  show() {
    const { forward, turn } = this.drive.stick;
    const long = Math.max(1, Math.hypot(forward, turn));
    const [across, down] = [-turn / long, -forward / long].map((share) => `${share * 58}%`);
    this.knob.style.translate = `calc(-50% + ${across}) calc(-50% + ${down})`;
    this.base.dataset.held = String(forward !== 0 || turn !== 0);
  }

  /** @param {PointerEvent} event */
  #down(event) {
    if (this.#pointer >= 0) return;
    this.#pointer = event.pointerId;
    this.base.setPointerCapture(event.pointerId);
    this.#move(event);
  }

  /** @param {PointerEvent} event */
  #move(event) {
    if (event.pointerId !== this.#pointer) return;
    const box = this.base.getBoundingClientRect();
    const radius = box.width * 0.36;
    const turn = shape((box.left + box.width / 2 - event.clientX) / radius);
    const forward = shape((box.top + box.height / 2 - event.clientY) / radius);
    this.drive.hold("joystick", { forward, turn });
  }

  /** @param {PointerEvent} event */
  #up(event) {
    if (event.pointerId !== this.#pointer) return;
    this.#letGo();
    this.drive.hold("joystick", null);
  }

  #letGo() {
    const pointer = this.#pointer;
    this.#pointer = -1;
    if (pointer >= 0 && this.base.hasPointerCapture(pointer))
      this.base.releasePointerCapture(pointer);
  }
}

/** Zero in the dead zone, full at the rim. @param {number} share @returns {number} -1 to 1 */
export function shape(share) {
  const size = Math.min(1, Math.abs(share));
  return size < DEAD ? 0 : (Math.sign(share) * (size - DEAD)) / (1 - DEAD);
}
