// @ts-check
import { find } from "../page/elements.js";
import { t } from "../page/language.js";
import { Surface } from "../page/surface.js";
import { sentence } from "../page/toasts.js";
import { drawDraft, drawShape } from "./floor_drawing.js";
import { FloorView } from "./floor_view.js";

/** @typedef {import("../map/gestures.js").Press} Tool */
/** @typedef {import("../map/panel.js").MapPanel} MapPanel */
/** @typedef {import("../page/draw_loop.js").DrawLoop} DrawLoop */
/** @typedef {import("./floor_view.js").Point} Point */
/** @typedef {import("./panel.js").View3d} View3d */

/**
 * @typedef {object} Held a pointer that is down; points are of the picture [CSS px]
 * @property {number} id
 * @property {Point} start where it was pressed
 * @property {Point} last where it is
 * @property {boolean} released
 * @property {Pressed | null} pressed null until the camera is known
 */
/** @typedef {{tool: Tool, floor: FloorView, place: Point}} Pressed what the press was for, and where on the floor [m] */

/** Lets the map's tools for poses be used in the 3D view: a layer over the scene takes the pointer while one is chosen. */
export class Pointing {
  #surface = new Surface(find("view-floor", HTMLCanvasElement), () => this.#refresh());
  /** @type {Held | null} */
  #held = null;
  /** What to do with the tool that is chosen. */
  #words = "";
  /** Paints the layer again. */
  #refresh = () => {};

  /** @param {DrawLoop} loop @param {MapPanel} map @param {View3d} view */
  constructor(loop, map, view) {
    this.map = map;
    this.view = view;
    this.#refresh = loop.add(() => this.#paint(), { visible: () => this.#surface.visible });
    map.onChosen((words) => this.#arm(words));
    const { canvas } = this.#surface;
    canvas.addEventListener("pointerdown", (event) => this.#down(event));
    canvas.addEventListener("pointermove", (event) => this.#move(event));
    canvas.addEventListener("pointerup", (event) => this.#up(event));
    canvas.addEventListener("pointercancel", () => this.#abandon());
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  /** @param {string} words */
  #arm(words) {
    this.#abandon();
    this.#words = words;
    this.#surface.canvas.hidden = words === "";
    this.view.say(words);
  }

  /** @param {PointerEvent} event */
  #down(event) {
    const { canvas } = this.#surface;
    canvas.focus({ preventScroll: true });
    // A second finger is no part of a pose.
    if (this.#held) return this.#abandon();
    if (event.button !== 0) return;
    canvas.setPointerCapture(event.pointerId);
    const start = this.#surface.locate(event);
    this.#held = { id: event.pointerId, start, last: start, released: false, pressed: null };
    this.#press(this.#held);
  }

  /** Press a tool, as soon as it is known what the viewer sees. @param {Held} held */
  async #press(held) {
    const camera = await this.view.hold().catch(sentence);
    // Somebody may have taken the press back meanwhile.
    if (this.#held !== held) return void this.view.letGo();
    const { width, height } = this.#surface;
    const floor = typeof camera === "string" ? null : new FloorView(camera, width, height);
    const place = floor?.toFloor(held.start);
    const tool = place && this.map.toolFor(...place);
    if (!floor || !place || !tool) {
      this.#abandon();
      const words = t("There is no floor: press below the horizon.");
      return void this.view.say(typeof camera === "string" ? camera : words);
    }
    held.pressed = { tool, floor, place };
    this.view.say(this.#words);
    tool.press(...place);
    this.#drag(held);
    if (held.released) this.#release(held);
  }

  /** @param {PointerEvent} event */
  #move(event) {
    if (this.#held?.id !== event.pointerId || this.#held.released) return;
    this.#held.last = this.#surface.locate(event);
    this.#drag(this.#held);
  }

  /** @param {Held} held */
  #drag({ start, last, pressed }) {
    if (!pressed) return;
    const { tool, floor, place } = pressed;
    const way = Math.hypot(last[0] - start[0], last[1] - start[1]);
    tool.drag(...(floor.toFloor(last) ?? ahead(place, floor.heading(place, last))), way);
    this.#show();
  }

  /** @param {PointerEvent} event */
  #up(event) {
    const held = this.#held;
    if (held?.id !== event.pointerId || held.released) return;
    held.last = this.#surface.locate(event);
    held.released = true;
    this.#drag(held);
    if (held.pressed) this.#release(held);
  }

  /** @param {Held} held */
  #release({ pressed }) {
    this.#held = null;
    this.view.letGo();
    pressed?.tool.release();
    this.#show();
  }

  #abandon() {
    const held = this.#held;
    if (!held) return;
    this.#held = null;
    this.view.letGo();
    held.pressed?.tool.cancel();
    this.#show();
  }

  /** @param {WheelEvent} event */
  #wheel(event) {
    event.preventDefault();
    // While a pose is pointed out, the view stands still.
    if (!this.#held) this.view.zoom(event);
  }

  /** Escape lays a tool down, as on the map. @param {KeyboardEvent} event */
  #key(event) {
    if (event.key !== "Escape") return;
    this.map.layDown();
    event.preventDefault();
  }

  /** What is pointed out shows on the map, too. */
  #show() {
    this.#refresh();
    this.map.refresh();
  }

  #paint() {
    const context = this.#surface.begin();
    const { pressed = null } = this.#held ?? {};
    if (!pressed) return;
    const { floor, tool } = pressed;
    const { draft, outline } = this.map;
    if (tool.corners) drawShape(context, floor, tool.corners, 0.2);
    else if (draft) drawDraft(context, floor, draft, outline);
  }
}

/** A place a metre on. @param {Point} place [m] @param {number} heading [rad] @returns {Point} */
const ahead = ([x, y], heading) => [x + Math.cos(heading), y + Math.sin(heading)];
