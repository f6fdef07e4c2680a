// @ts-check
/** @typedef {import("./lease.js").Drive} Drive */

/**
 * Physical keys, so that W A S D lie under the fingers on every layout.
 * @type {Record<string, [number, number]>}
 */
const KEYS = {
  KeyW: [1, 0],
  ArrowUp: [1, 0],
  KeyS: [-1, 0],
  ArrowDown: [-1, 0],
  KeyA: [0, 1],
  ArrowLeft: [0, 1],
  KeyD: [0, -1],
  ArrowRight: [0, -1],
};
/**
 * Keys of the system: macOS tells of no key that is let go while Cmd is held, and menus open by Alt,
 * F10 or the menu key, which get the keyups.
 */
const SYSTEM_KEYS = ["Meta", "OS", "Alt", "ContextMenu", "F10"];
/** Events after which something else may have the keyboard: menus, dragging, input of characters. */
const TAKERS = ["contextmenu", "dragstart", "compositionstart", "beforeprint"];
const TEXT_TYPES = ["text", "number", "search", "email", "url", "tel", "password"];

/**
 * Driving by keyboard: several keys combine, space stops, and typing text does not drive.
 *
 * A key counts as held from its keydown to its keyup, and no longer than its keyup would come: all
 * are let go when something else may take the keyboard. What remains are keyups that get lost
 * without any event, as on the way through a remote desktop or with a keyboard that is unplugged.
 * Repeats say nothing: they end when another key is pressed, and some people switch them off.
 */
export class Keys {
  /** @type {Set<string>} */
  #held = new Set();

  /** @param {Drive} drive */
  constructor(drive) {
    this.drive = drive;
    drive.onStop(() => this.#held.clear());
    this.listen(window);
  }

  /** Take keys from another window, too, such as the 3D view's frame. @param {Window} target */
  listen(target) {
    target.addEventListener("keydown", (event) => this.#down(event), { capture: true });
    target.addEventListener("keyup", (event) => this.#up(event), { capture: true });
    for (const taker of TAKERS)
      target.addEventListener(taker, () => this.#letGo(), { capture: true });
    target.addEventListener("focusin", (event) => this.#focused(event), { capture: true });
    if (target !== window) target.addEventListener("blur", () => this.drive.release());
  }

  /** @param {KeyboardEvent} event */
  #down(event) {
    if (!this.drive.possible) return;
    if (SYSTEM_KEYS.includes(event.key) || event.metaKey) this.#letGo();
    if (typesText(event.target)) return;
    if (event.code === "Space") {
      if (!event.repeat) this.drive.stop();
      return take(event);
    }
    if (!(event.code in KEYS) || event.ctrlKey || event.metaKey || event.altKey || event.shiftKey)
      return;
    if (ownsKey(event.target, event.code)) return;
    take(event);
    // A key that still repeats after a stop must be pressed again.
    if (event.repeat) return;
    this.#held.add(event.code);
    this.#apply();
  }

  /** @param {KeyboardEvent} event */
  #up(event) {
    if (!this.drive.possible) return;
    if (event.code === "Space" && !typesText(event.target)) return take(event);
    if (SYSTEM_KEYS.includes(event.key) || event.metaKey) return this.#letGo();
    if (this.#held.delete(event.code)) this.#apply();
  }

  /** Let go where keys do something else: text, and lists that open. @param {FocusEvent} event */
  #focused({ target }) {
    const element = /** @type {Element | null} */ (target);
    if (typesText(target) || element?.tagName === "SELECT") this.#letGo();
  }

  #letGo() {
    if (this.#held.size === 0) return;
    this.#held.clear();
    this.#apply();
  }

  #apply() {
    if (this.#held.size === 0) return this.drive.hold("keys", null);
    let [forward, turn] = [0, 0];
    for (const code of this.#held) {
      forward += KEYS[code][0];
      turn += KEYS[code][1];
    }
    this.drive.hold("keys", { forward: Math.sign(forward), turn: Math.sign(turn) });
  }
}

/** Keep an event from the page and the 3D view's camera keys. @param {Event} event */
export function take(event) {
  event.preventDefault();
  event.stopPropagation();
}

/** @param {EventTarget | null} target may be of another window, so instanceof would fail */
export function typesText(target) {
  const element = /** @type {HTMLInputElement | null} */ (target);
  if (element?.isContentEditable || element?.tagName === "TEXTAREA") return true;
  return element?.tagName === "INPUT" && TEXT_TYPES.includes(element.type);
}

/**
 * Whether the focused element uses the key itself.
 * @param {EventTarget | null} target
 * @param {string} code
 */
export function ownsKey(target, code) {
  const element = /** @type {Element | null} */ (target);
  if (element?.tagName === "SELECT") return true;
  const owner = element?.closest?.("input[type=range], [role=tab], [data-own-arrows]");
  return code.startsWith("Arrow") && Boolean(owner);
}
