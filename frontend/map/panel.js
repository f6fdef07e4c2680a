// @ts-check
import { find, findButton, setText } from "../page/elements.js";
import { degrees, distance, millimetres } from "../page/format.js";
import { palette } from "../page/palette.js";
import { Surface } from "../page/surface.js";
import { decodeCloud, drawCloud } from "./cloud.js";
import * as drawing from "./drawing.js";
import { Floor } from "./floor.js";
import { Gestures } from "./gestures.js";
import { NumbersForm } from "./numbers.js";
import { Paths } from "./paths.js";
import { PoseTool } from "./tools.js";
import { Undo } from "./undo.js";
import { MapView } from "./view.js";

/** @typedef {import("../messages").Command} Command */
/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../messages").PoseMessage} PoseMessage */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../page/draw_loop.js").DrawLoop} DrawLoop */
/** @typedef {import("./tools.js").Tool} Tool */

const HERTZ = 20;
/** @type {Record<Tool, string>} */
const HINTS = {
  look: "",
  set_pose: "Press where the robot is, drag where it looks.",
  place: "Press where to put the robot, drag where it looks.",
};

/** The field from above: where the robot is, where it is believed to be, and telling it. */
export class MapPanel {
  paths = new Paths();
  view = new MapView();
  #undo = new Undo();
  #undoButton = findButton("undo");
  #hint = find("map-hint", HTMLElement);
  #alike = find("map-alike", HTMLElement);
  #text = find("map-text", HTMLElement);
  #tools = [...document.querySelectorAll("button[data-tool]")].map(
    (button) => /** @type {HTMLButtonElement} */ (button),
  );
  /** @type {FieldMessage | null} */
  #field = null;
  /** @type {Floor | null} */
  #floor = null;
  /** @type {TelemetryMessage | null} */
  #telemetry = null;
  #moved = false;

  /**
   * @param {DrawLoop} loop
   * @param {(command: Command) => Promise<boolean>} order sends a command; tells whether it was taken
   */
  constructor(loop, order) {
    this.order = order;
    this.surface = new Surface(find("map-canvas", HTMLCanvasElement), () => this.#resized());
    const visible = () => this.surface.visible;
    this.refresh = loop.add(() => this.#paint(), { visible, hertz: HERTZ });
    this.numbers = new NumbersForm((act, pose) => this.#tell(act, pose), this.refresh);
    const heading = () => this.#telemetry?.estimate?.theta ?? 0;
    this.tool = new PoseTool(heading, () => this.view.scale, (tool, pose) => this.#tell(tool, pose));
    const changed = () => {
      this.#moved = true;
      this.refresh();
    };
    this.gestures = new Gestures(this.surface, this.view, this.tool, changed, () => this.#fit());
    this.#wire();
  }

  /** @param {FieldMessage} field @param {ImageBitmap} picture */
  setField(field, picture) {
    this.#field = field;
    this.#floor = new Floor(field.extent, picture);
    this.numbers.pose = field.start;
    this.#fit();
  }

  /** @param {TelemetryMessage} telemetry */
  show(telemetry) {
    this.#telemetry = telemetry;
    this.paths.add(telemetry);
    this.refresh();
  }

  /** Words for what the map shows; written a few times a second. @param {TelemetryMessage} telemetry */
  describe({ estimate, truth, particles, filter, robot }) {
    const alike = filter.ambiguous ? `${particles.hypotheses.length} places look alike` : "";
    setText(this.#alike, alike);
    this.#undoButton.disabled = !this.#undo.possible;
    for (const button of this.#tools) {
      if (button.dataset.tool === "place") button.hidden = !robot.can_be_placed;
    }
    this.numbers.allowPlacing(robot.can_be_placed);
    const where = estimate
      ? `The filter believes the robot at x ${millimetres(estimate.x)}, y ${millimetres(estimate.y)}, heading ${degrees(estimate.theta)}.`
      : "The filter has no estimate.";
    const error = truth && estimate ? ` It is off by ${millimetres(distance(truth, estimate))}.` : "";
    setText(this.#text, `${where}${error} ${alike}`);
  }

  /** Where a point of the map is on the page [CSS px]. @param {number} x [m] @param {number} y [m] @returns {[number, number]} */
  toPage(x, y) {
    const box = this.surface.canvas.getBoundingClientRect();
    const [u, v] = this.view.toScreen(x, y);
    return [box.left + u, box.top + v];
  }

  #wire() {
    for (const button of this.#tools) {
      button.onclick = () => this.#choose(/** @type {Tool} */ (button.dataset.tool));
    }
    findButton("map-in").onclick = () => this.gestures.zoom(1);
    findButton("map-out").onclick = () => this.gestures.zoom(-1);
    findButton("map-fit").onclick = () => this.#fit();
    findButton("map-clear").onclick = () => this.#clear();
    findButton("scatter").onclick = () => this.scatter();
    this.#undoButton.onclick = () => this.#takeBack();
    const toggle = findButton("numbers-toggle");
    toggle.onclick = () => {
      const open = toggle.getAttribute("aria-expanded") !== "true";
      toggle.setAttribute("aria-expanded", String(open));
      find("numbers", HTMLElement).hidden = !open;
      if (open && this.#telemetry?.estimate) this.numbers.pose = this.#telemetry.estimate;
    };
  }

  /** @param {Tool} tool */
  #choose(tool) {
    this.tool.tool = tool;
    this.tool.cancel();
    for (const button of this.#tools) {
      button.setAttribute("aria-pressed", String(button.dataset.tool === tool));
    }
    this.surface.canvas.dataset.tool = tool;
    setText(this.#hint, HINTS[tool]);
    this.refresh();
  }

  /** @param {Tool} tool @param {PoseMessage} pose */
  async #tell(tool, pose) {
    this.numbers.pose = pose;
    if (tool === "place") {
      if (await this.order({ type: "place", ...pose })) this.#undo.clear();
    } else if (tool === "set_pose") {
      const { sdXy: sd_xy, sdTheta: sd_theta } = this.numbers;
      await this.#believe({ type: "set_pose", ...pose, sd_xy, sd_theta });
    }
  }

  /** Spread the cloud over the whole field. */
  scatter() {
    return this.#believe({ type: "scatter" });
  }

  /** Change what the filter believes, so that it can be undone. @param {Command} command */
  async #believe(command) {
    const before = this.#telemetry;
    if (await this.order(command)) this.#undo.keep(before);
    this.#undoButton.disabled = !this.#undo.possible;
  }

  async #takeBack() {
    const command = this.#telemetry && this.#undo.take(this.#telemetry);
    if (command) await this.order(command);
    this.#undoButton.disabled = !this.#undo.possible;
  }

  #clear() {
    this.paths.clear();
    this.refresh();
  }

  #fit() {
    this.#moved = false;
    if (this.#field && this.surface.visible) this.view.fit(this.#field.extent);
    this.refresh();
  }

  #resized() {
    this.view.width = this.surface.width;
    this.view.height = this.surface.height;
    if (!this.#moved) this.#fit();
    this.refresh?.();
  }

  #paint() {
    const context = this.surface.begin();
    const pixel = 1 / this.view.scale;
    this.#floor?.draw(context, this.view, this.surface.ratio);
    if (this.#telemetry) this.#paintBelief(context, this.#telemetry, pixel);
    if (this.tool.draft) this.#paintDraft(context, this.tool.draft, pixel);
    drawing.drawScaleBar(context, this.view);
  }

  /** @param {CanvasRenderingContext2D} context @param {TelemetryMessage} telemetry @param {number} pixel */
  #paintBelief(context, { scan, particles, truth, estimate, filter }, pixel) {
    const outline = this.#field?.robot_outline ?? [];
    this.#inMetres(context, () => {
      drawing.drawScan(context, scan, pixel);
      this.paths.draw(context, pixel);
    });
    drawCloud(context, this.view, decodeCloud(particles));
    this.#inMetres(context, () => {
      if (estimate) drawing.drawCertainty(context, estimate, pixel);
      const ghost = { colour: palette["floor-truth"], dash: [4, 4] };
      if (truth) drawing.drawRobot(context, truth, outline, pixel, ghost);
      const believed = { colour: palette["floor-estimate"], fill: 0.15 };
      if (estimate) drawing.drawRobot(context, estimate, outline, pixel, believed);
    });
    if (filter.ambiguous) drawing.drawHypotheses(context, this.view, particles.hypotheses);
  }

  /** @param {CanvasRenderingContext2D} context @param {PoseMessage} draft @param {number} pixel */
  #paintDraft(context, draft, pixel) {
    const colour = palette["floor-draft"];
    const { sdXy } = this.numbers;
    this.#inMetres(context, () => {
      if (this.tool.tool === "set_pose") {
        drawing.drawEllipse(context, draft.x, draft.y, [2 * sdXy, 2 * sdXy], 0, colour, pixel);
      }
      drawing.drawRobot(context, draft, this.#field?.robot_outline ?? [], pixel, { colour, fill: 0.2 });
      drawing.drawAim(context, draft, pixel, colour);
    });
  }

  /** @param {CanvasRenderingContext2D} context @param {() => void} draw */
  #inMetres(context, draw) {
    context.save();
    this.view.apply(context);
    draw();
    context.restore();
  }
}
