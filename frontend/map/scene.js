// @ts-check
import { palette } from "../page/palette.js";
import { decodeCloud, drawCloud } from "./cloud.js";
import * as drawing from "./drawing.js";
import { Floor } from "./floor.js";
import { drawHypotheses } from "./hypotheses.js";
import { Paths } from "./paths.js";
import { places } from "./places.js";
import { drawJourney } from "../features/navigation/drawing.js";
import { drawMisplaced } from "../features/misplaced_tape/drawing.js";
import { drawEnds, drawMapping } from "../features/mapping/drawing.js";

/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../messages").MapDrawingMessage} MapDrawingMessage */
/** @typedef {import("../messages").PoseMessage} PoseMessage */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../page/surface.js").Surface} Surface */
/** @typedef {import("../features/mapping/end_tool.js").EndTool} EndTool */
/** @typedef {import("./view.js").MapView} MapView */

/** A pose that the user is pointing out, and the `spread` [m] if it will be sent to the filter. */
/** @typedef {{pose: PoseMessage, spread: number | null}} Draft */

/** The known field shows so much while another map is drawn. */
const FAINT = 0.25;

/** Draws everything on the map, from the floor up. */
export class Scene {
  paths = new Paths();
  /** @type {TelemetryMessage | null} */
  telemetry = null;
  /** The map that is drawn by driving. @type {MapDrawingMessage | null} */
  drawing = null;
  /** Number of its stroke that stands out. */
  chosen = -1;
  /** Drags ends of that map. @type {EndTool | null} */
  ends = null;
  /** What is measured. @type {import("./measure.js").MeasureTool | null} */
  measure = null;
  /** Draws what particles say. @type {import("../features/weighing/panel.js").ParticlesPanel | null} */
  particles = null;
  /** The journey to a goal. @type {import("../features/navigation/journey.js").Journey | null} */
  journey = null;
  /** @type {Floor | null} */
  #floor = null;
  /** @type {[number, number][]} */
  #outline = [];

  /** @param {Surface} surface @param {MapView} view */
  constructor(surface, view) {
    this.surface = surface;
    this.view = view;
  }

  /** The map that is drawn by driving, once it can be changed; else null. */
  get finished() {
    return this.telemetry?.mapping?.state === "done" ? this.drawing : null;
  }

  /** @param {FieldMessage} field @param {ImageBitmap} picture */
  setField(field, picture) {
    this.#floor = new Floor(field.extent, picture);
    this.#outline = field.robot_outline;
    this.paths.longestStep = field.longest_step;
  }

  /** @param {Draft | null} draft */
  paint(draft) {
    const context = this.surface.begin();
    const pixel = 1 / this.view.scale;
    context.globalAlpha = (this.drawing ? FAINT : 1) * Number(palette["floor-light"]);
    this.#floor?.draw(context, this.view, this.surface.ratio);
    context.globalAlpha = 1;
    if (this.drawing) this.#paintMapping(context, this.drawing, pixel);
    else if (this.telemetry) this.#paintBelief(context, this.telemetry, pixel);
    if (!this.drawing) this.particles?.paint(context, this.#outline);
    if (draft) this.#paintDraft(context, draft, pixel);
    if (this.measure?.line) drawing.drawMeasure(context, this.view, ...this.measure.line);
    drawing.drawScaleBar(context, this.view);
  }

  /**
   * What the filter believes is of another map, and not drawn.
   * @param {CanvasRenderingContext2D} context
   * @param {MapDrawingMessage} mapped
   * @param {number} pixel [m]
   */
  #paintMapping(context, mapped, pixel) {
    const { truth = null, mapping } = this.telemetry ?? {};
    this.#inMetres(context, () => {
      drawMapping(context, mapped, pixel, this.chosen);
      if (this.finished) drawEnds(context, mapped, pixel, this.ends?.held ?? null);
      const ghost = { colour: palette["floor-truth"], dash: [4, 4] };
      if (truth) drawing.drawRobot(context, truth, this.#outline, pixel, ghost);
      const style = { colour: palette["floor-estimate"], fill: 0.15 };
      if (mapping?.pose) drawing.drawRobot(context, mapping.pose, this.#outline, pixel, style);
    });
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {TelemetryMessage} telemetry
   * @param {number} pixel [m]
   */
  #paintBelief(context, telemetry, pixel) {
    this.journey?.planning?.paintBelow(context);
    this.particles?.paintLandscape(context);
    this.#inMetres(context, () => {
      if (telemetry.misplaced_tape) drawMisplaced(context, telemetry.misplaced_tape, pixel);
      drawing.drawScan(context, telemetry.scan, pixel);
      this.paths.draw(context, pixel);
      this.journey?.planning?.paint(context, pixel);
      const { way = null } = this.journey ?? {};
      if (way && telemetry.navigation) {
        drawJourney(context, way, telemetry.navigation.target, this.#outline, pixel);
      }
    });
    if (!this.particles?.step) drawCloud(context, this.view, decodeCloud(telemetry.particles));
    const found = places(telemetry);
    const count = telemetry.particles.alike;
    this.#inMetres(context, () => {
      found.forEach((place, i) => drawing.drawCertainty(context, place, pixel, i > 0));
      if (found.length === 0) this.#paintEllipse(context, telemetry, pixel, count);
      this.#paintRobots(context, telemetry, pixel, count);
    });
    this.particles?.paintStep(context);
    drawHypotheses(context, this.view, found, count === 1);
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {TelemetryMessage} telemetry
   * @param {number} pixel [m]
   * @param {number} count of places that may be the robot's
   */
  #paintEllipse(context, { estimate }, pixel, count) {
    if (estimate && count > 0) drawing.drawCertainty(context, estimate, pixel, false);
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {TelemetryMessage} telemetry
   * @param {number} pixel [m]
   * @param {number} count of places that may be the robot's
   */
  #paintRobots(context, { truth, estimate, integrity, replay }, pixel, count) {
    const ghost = { colour: palette["floor-truth"], dash: [4, 4] };
    if (truth) drawing.drawRobot(context, truth, this.#outline, pixel, ghost);
    const then = { colour: palette["floor-then"], dash: [9, 3, 2, 3] };
    if (replay?.estimate_then)
      drawing.drawRobot(context, replay.estimate_then, this.#outline, pixel, then);
    // If places look alike, their arrows say more than a robot at one of them.
    if (!estimate || count > 1) return;
    if (count === 1) drawing.drawClaim(context, estimate, integrity, pixel);
    // The mean of a cloud all over the field is not drawn like a robot.
    const vague = { colour: palette["floor-estimate"], dash: [2, 4] };
    const believed = count > 0 ? { colour: vague.colour, fill: 0.15 } : vague;
    drawing.drawRobot(context, estimate, this.#outline, pixel, believed);
  }

  /** @param {CanvasRenderingContext2D} context @param {Draft} draft @param {number} pixel [m] */
  #paintDraft(context, { pose, spread }, pixel) {
    const colour = palette["floor-draft"];
    this.#inMetres(context, () => {
      if (spread !== null) {
        const radii = [2 * spread, 2 * spread];
        drawing.drawEllipse(context, pose.x, pose.y, radii, 0, colour, pixel);
      }
      drawing.drawRobot(context, pose, this.#outline, pixel, { colour, fill: 0.2 });
      drawing.drawAim(context, pose, pixel, colour);
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
