// @ts-check
import { find, setText } from "../page/elements.js";

/** @typedef {import("../messages").Command} Command */
/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../page/theme.js").Appearance} Appearance */
/** @typedef {import("../messages").ShowCommand["layer"]} Layer */

/** Where the eye stands, in sizes of the field from its middle. */
const EYE = [-0.55, -0.75, 0.7];

/** viser's scene in a frame of its own, loaded when it is first seen. */
export class View3d {
  #box = find("view-stage", HTMLElement);
  #message = find("view-message", HTMLElement);
  #buttons = [...document.querySelectorAll("button[data-layer]")].map(
    (button) => /** @type {HTMLButtonElement} */ (button),
  );
  /** @type {HTMLIFrameElement | null} */
  #frame = null;
  /** @type {FieldMessage | null} */
  #field = null;
  #theme = "";

  /**
   * @param {Appearance} appearance @param {(command: Command) => Promise<boolean>} order
   * @param {(target: Window) => void} listen gets the frame's window, whose keys would else be lost
   */
  constructor(appearance, order, listen) {
    this.appearance = appearance;
    this.order = order;
    this.listen = listen;
    this.possible = hasWebGl();
    document.documentElement.dataset.webgl = String(this.possible);
    if (!this.possible) {
      setText(this.#message, "This browser has no WebGL: the map shows the same from above.");
    }
    for (const button of this.#buttons) button.onclick = () => this.#switch(button);
    appearance.onChange(() => this.#load());
    new ResizeObserver(() => this.#load()).observe(this.#box);
  }

  /** @param {FieldMessage} field */
  setField(field) {
    this.#field = field;
    this.#theme = "";
    this.#load();
  }

  /** The switches follow what all viewers see. @param {TelemetryMessage} telemetry */
  describe({ hidden_layers: hidden }) {
    if (!hidden) return;
    for (const button of this.#buttons) {
      const layer = /** @type {Layer} */ (button.dataset.layer);
      button.setAttribute("aria-pressed", String(!hidden.includes(layer)));
    }
  }

  #load() {
    const seen = this.#box.clientWidth > 0 && this.#box.clientHeight > 0;
    if (!this.possible || !this.#field || !seen || this.#theme === this.appearance.theme) return;
    this.#theme = this.appearance.theme;
    this.#frame?.remove();
    this.#frame = document.createElement("iframe");
    this.#frame.title = "The scene in 3D";
    this.#frame.src = address(this.#field.extent, this.#theme === "dark");
    this.#frame.onload = () => this.#loaded();
    this.#box.prepend(this.#frame);
  }

  #loaded() {
    this.#message.hidden = true;
    const inside = this.#frame?.contentWindow;
    if (inside) this.listen(inside);
  }

  /** @param {HTMLButtonElement} button */
  async #switch(button) {
    const visible = button.getAttribute("aria-pressed") !== "true";
    const layer = /** @type {Layer} */ (button.dataset.layer);
    button.setAttribute("aria-pressed", String(visible));
    if (!(await this.order({ type: "show", layer, visible }))) {
      button.setAttribute("aria-pressed", String(!visible));
    }
  }
}

/** @param {number[]} extent @param {boolean} dark */
function address([xmin, ymin, xmax, ymax], dark) {
  const [x, y] = [(xmin + xmax) / 2, (ymin + ymax) / 2];
  const size = Math.max(xmax - xmin, ymax - ymin);
  const eye = [x + EYE[0] * size, y + EYE[1] * size, EYE[2] * size];
  const words = [`initialCameraPosition=${eye.map((part) => part.toFixed(3))}`, `initialCameraLookAt=${x},${y},0`];
  return `/view/?${[...words, ...(dark ? ["darkMode"] : [])].join("&")}`;
}

function hasWebGl() {
  const context = document.createElement("canvas").getContext("webgl2");
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return context !== null;
}
