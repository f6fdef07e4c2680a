// @ts-check
import { t } from "../page/language.js";
import { find, make, setText } from "../page/elements.js";
import { sendJson } from "../wire/http.js";
import { calm, findWebGl } from "./webgl.js";

/** @typedef {import("../messages").Command} Command */
/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../page/theme.js").Appearance} Appearance */
/** @typedef {import("../messages").ShowCommand["layer"]} Layer */
/** @typedef {import("../messages").ViewCameraMessage} ViewCameraMessage */

/** Names this page's viewer, so that its camera can be moved. */
const PAGE = Math.random().toString(36).slice(2, 12);
const LATER_MS = 500;
/** Interval between looks whether the scene is drawn [ms]. */
const LOOK_AGAIN_MS = 300;
/** Hides viser's notices and, in a narrow frame, its controls: they would cover the scene. */
const QUIET =
  ".mantine-Notifications-root, #root .mantine-Paper-root { display: none !important; }";

/** viser's scene in a frame of its own, loaded when it is first seen. */
export class View3d {
  #box = find("view-stage", HTMLElement);
  #message = find("view-message", HTMLElement);
  #say = find("view-say", HTMLElement);
  #buttons = [...document.querySelectorAll("button[data-layer]")].map(
    (button) => /** @type {HTMLButtonElement} */ (button),
  );
  #looks = [...document.querySelectorAll("button[data-look]")].map(
    (button) => /** @type {HTMLButtonElement} */ (button),
  );
  /** @type {HTMLIFrameElement | null} */
  #frame = null;
  /** @type {FieldMessage | null} */
  #field = null;
  #theme = "";

  /**
   * @param {Appearance} appearance @param {(command: Command) => Promise<boolean>} order
   * @param {(target: Window) => void} listen gets the frame's window, whose keys miss the page
   */
  constructor(appearance, order, listen) {
    this.appearance = appearance;
    this.order = order;
    this.listen = listen;
    this.webGl = findWebGl();
    document.documentElement.dataset.webgl = this.webGl;
    this.#explain();
    for (const button of this.#buttons) button.onclick = () => this.#switch(button);
    for (const button of this.#looks) button.onclick = () => this.#look(button);
    appearance.onChange(() => this.#load());
    new ResizeObserver(() => this.#load()).observe(this.#box);
  }

  #explain() {
    if (this.webGl === "none") {
      setText(this.#message, t("This browser has no WebGL: the map shows the same from above."));
      setText(find("view-hint", HTMLElement), t("not in this browser"));
    } else if (this.webGl === "software") {
      setText(find("view-hint", HTMLElement), t("without a graphics card: a few pictures a second"));
    }
  }

  /** @param {FieldMessage} field */
  setField(field) {
    this.#theme = "";
    // viser is slow to start, so the page's own panels come first.
    setTimeout(() => {
      this.#field = field;
      this.#load();
    }, LATER_MS);
  }

  /** Set the switches to the layers that all viewers share. @param {TelemetryMessage} telemetry */
  describe({ hidden_layers: hidden }) {
    if (!hidden) return;
    for (const button of this.#buttons) {
      const layer = /** @type {Layer} */ (button.dataset.layer);
      button.setAttribute("aria-pressed", String(!hidden.includes(layer)));
    }
  }

  /** Tell what a press in the scene does; while it does something, a drag does not turn the scene. @param {string} words */
  say(words) {
    setText(this.#say, words);
    if (this.webGl !== "hardware") return;
    setText(find("view-hint", HTMLElement), words ? t("wheel to zoom") : t("drag to turn, wheel to zoom"));
  }

  /** Keep this page's camera where it is. @returns {Promise<ViewCameraMessage>} */
  hold() {
    return sendJson(`api/view/${PAGE}/free`, "POST", {});
  }

  /** Let the camera go with the robot again, if it did. */
  async letGo() {
    const follow = this.#looks.find((button) => button.dataset.look === "follow");
    if (follow?.getAttribute("aria-pressed") !== "true") return;
    const answer = await fetch(`api/view/${PAGE}/follow`, { method: "POST" }).catch(() => null);
    if (!answer?.ok) follow.setAttribute("aria-pressed", "false");
  }

  /** Let the scene have a turn of the wheel that came elsewhere. @param {WheelEvent} event */
  zoom(event) {
    const { left = 0, top = 0 } = this.#frame?.getBoundingClientRect() ?? {};
    const below = this.#frame?.contentDocument?.elementFromPoint(event.clientX - left, event.clientY - top);
    below?.dispatchEvent(new WheelEvent("wheel", event));
  }

  #load() {
    const seen = this.#box.clientWidth > 0 && this.#box.clientHeight > 0;
    if (this.webGl === "none" || !this.#field || !seen || this.#theme === this.appearance.theme)
      return;
    this.#theme = this.appearance.theme;
    this.#frame?.remove();
    this.#frame = document.createElement("iframe");
    this.#frame.title = t("The scene in 3D");
    this.#frame.src = address(this.#field, this.#theme === "dark");
    // A frame is white until its scene is there, also on a dark page.
    this.#frame.style.opacity = "0";
    this.#frame.onload = () => this.#loaded();
    this.#box.prepend(this.#frame);
  }

  #loaded() {
    this.#awaitPicture();
    const inside = this.#frame?.contentWindow;
    if (!inside) return;
    inside.document.head.append(make("style", {}, QUIET));
    if (this.webGl === "software") calm(inside);
    this.listen(inside);
  }

  /** The frame is loaded long before the scene in it can be seen. */
  #awaitPicture() {
    const inside = this.#frame?.contentDocument;
    const canvases = [...(inside?.querySelectorAll("canvas") ?? [])];
    this.#message.hidden = canvases.some(({ width }) => width > 0);
    if (this.#frame) this.#frame.style.opacity = this.#message.hidden ? "" : "0";
    if (!this.#message.hidden) setTimeout(() => this.#awaitPicture(), LOOK_AGAIN_MS);
  }

  /** Move this page's camera; pressed once more, the one that follows is free. @param {HTMLButtonElement} button */
  async #look(button) {
    const follows = button.getAttribute("aria-pressed") === "true";
    const look = follows ? "free" : button.dataset.look;
    const answer = await fetch(`api/view/${PAGE}/${look}`, { method: "POST" });
    if (!answer.ok) return;
    for (const other of this.#looks) {
      if (other.dataset.look === "follow") other.setAttribute("aria-pressed", String(look === "follow"));
    }
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

/** @param {FieldMessage} field @param {boolean} dark */
function address({ extent: [xmin, ymin, xmax, ymax], view_home }, dark) {
  const words = [
    `initialCameraPosition=${view_home}`,
    `initialCameraLookAt=${(xmin + xmax) / 2},${(ymin + ymax) / 2},0`,
  ];
  return `view/${PAGE}/?${[...words, ...(dark ? ["darkMode"] : [])].join("&")}`;
}
