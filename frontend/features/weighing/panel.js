// @ts-check
import { t } from "../../page/language.js";
import { make } from "../../page/elements.js";
import { AskTool } from "./ask_tool.js";
import { drawFit, drawGhost, drawWords } from "./drawing.js";
import { FitSection, weightWords } from "./fit.js";
import { HandSection } from "./hand.js";
import { drawStep } from "./hand_drawing.js";
import { LandscapeSection } from "./landscape.js";

/** @typedef {import("../../messages").Command} Command */
/** @typedef {import("../../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../../map/gestures.js").Gestures} Gestures */
/** @typedef {import("../../map/scene.js").Scene} Scene */
/** @typedef {import("../../map/view.js").MapView} MapView */

const STYLE = "static/style/particles.css";

/** Beside the map: a particle asked, the filter by hand, the likelihood all over the field. Loaded when it is first used. */
export class ParticlesPanel {
  #box = make("aside", { id: "particles", class: "aside", "aria-labelledby": "particles-title" });
  /** @type {AskTool} */
  #tool;
  #fit;
  #hand;
  #land;

  /**
   * @param {Scene} scene
   * @param {MapView} view
   * @param {Gestures} gestures
   * @param {(command: Command) => Promise<boolean>} order
   * @param {() => void} refresh paints the map again
   * @param {() => void} closed when it was closed
   */
  constructor(scene, view, gestures, order, refresh, closed) {
    this.scene = scene;
    this.view = view;
    this.closed = closed;
    this.#fit = new FitSection(refresh);
    this.#hand = new HandSection(order, refresh);
    this.#land = new LandscapeSection(() => this.#fit.pose, refresh);
    this.#tool = new AskTool(
      () => view.scale,
      () => (this.shown ? this.#fit.pose : null),
      (x, y) => this.#fit.choose(x, y),
      (pose) => this.#fit.move(pose),
    );
    gestures.tools.push(this.#tool);
    scene.particles = this;
    const close = make("button", { type: "button", "aria-label": t("Close what particles say") }, "×");
    close.onclick = () => this.show(false);
    const title = make("h3", { id: "particles-title" }, t("Particles"));
    this.#box.append(make("div", { class: "aside-bar" }, title, close), this.#fit.element, this.#hand.element, this.#land.element);
    document.head.append(make("link", { rel: "stylesheet", href: STYLE }));
    document.querySelector("#map .map-split")?.append(this.#box);
  }

  get shown() {
    return !this.#box.hidden;
  }

  /** @param {boolean} armed whether a press on the map chooses a particle */
  arm(armed) {
    this.#tool.armed = armed;
    if (armed) this.show(true);
  }

  /** @param {boolean} shown */
  show(shown) {
    this.#box.hidden = !shown;
    if (shown) return;
    this.#fit.clear();
    this.#land.show(false);
    this.closed();
  }

  /** Show the steps by hand. */
  showHand() {
    this.show(true);
    this.#hand.element.scrollIntoView({ block: "nearest" });
  }

  /** @param {TelemetryMessage} telemetry */
  follow(telemetry) {
    this.#fit.follow(telemetry, this.shown);
    this.#hand.follow(telemetry);
    this.#land.follow();
  }

  /** The last step by hand, which is drawn instead of the cloud; null while there is none. */
  get step() {
    return this.#hand.shown;
  }

  /** Shade the field, below all else. @param {CanvasRenderingContext2D} context in CSS pixels */
  paintLandscape(context) {
    this.#land.paint(context, this.view);
  }

  /** Draw the particles as the last step by hand left them. @param {CanvasRenderingContext2D} context in CSS pixels */
  paintStep(context) {
    if (this.step) drawStep(context, this.view, this.step);
  }

  /**
   * Draw over all else on the map.
   * @param {CanvasRenderingContext2D} context in CSS pixels
   * @param {[number, number][]} outline of the robot [m]
   */
  paint(context, outline) {
    const { pose, fits } = this.#fit;
    if (!this.shown || !pose) return;
    const pixel = 1 / this.view.scale;
    context.save();
    this.view.apply(context);
    if (fits) drawFit(context, fits, pose, pixel, this.#fit.chosen);
    drawGhost(context, pose, outline, pixel);
    context.restore();
    this.#land.paintRing(context, this.view);
    if (fits) drawWords(context, this.view, pose, weightWords(fits.asked.weight));
  }
}
