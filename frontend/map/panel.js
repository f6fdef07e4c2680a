// @ts-check
import { t } from "../page/language.js";
import { EndTool } from "../features/mapping/end_tool.js";
import { find, findButton, setText } from "../page/elements.js";
import { degrees, distance, millimetres } from "../page/format.js";
import { Surface } from "../page/surface.js";
import { Doubts } from "./doubts.js";
import { Gestures } from "./gestures.js";
import { NumbersForm } from "./numbers.js";
import { MeasureTool } from "./measure.js";
import { NextStep } from "./next_step.js";
import { certainty, claim } from "./places.js";
import { AwayWord } from "./away_word.js";
import { Scene } from "./scene.js";
import { shownArea, whereRobotIs } from "./shown_area.js";
import { Telling } from "./telling.js";
import { PoseTool } from "./tools.js";
import { MapView } from "./view.js";

/** @typedef {import("../messages").Command} Command */
/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../messages").MapDrawingMessage} MapDrawingMessage */
/** @typedef {import("../messages").PoseMessage} PoseMessage */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../page/draw_loop.js").DrawLoop} DrawLoop */
/** @typedef {import("./tools.js").Tool} Tool */

const HERTZ = 20;
/** @type {Record<Tool, string>} */
const HINTS = {
  look: "",
  set_pose: t("Press where the robot is, drag in the direction it faces."),
  place: t("Press where to put the robot, drag in the direction it faces."),
  goal: t("Press where the robot shall go, drag in the direction it shall face there."),
  ask: t("Press a particle: it says how the scan fits it."),
  measure: t("Drag from one point to another, or press at both; by keys: arrows and Enter."),
};

/** The field from above: the robot's true and estimated poses, and tools to set them. */
export class MapPanel {
  #view = new MapView();
  #hint = find("map-hint", HTMLElement);
  #certainty = find("map-certainty", HTMLElement);
  /** @type {AwayWord} */
  #away;
  #nextStep = new NextStep();
  #doubts = new Doubts(find("map-doubts", HTMLElement));
  #text = find("map-text", HTMLElement);
  #measured = find("map-measured", HTMLElement);
  #tools = [...document.querySelectorAll("button[data-tool], button[data-scene-tool]")].map(
    (button) => /** @type {HTMLButtonElement} */ (button),
  );
  /** @type {FieldMessage | null} */
  #field = null;
  /** Whether the view was moved by hand; until then it shows the whole field. */
  #moved = false;
  /** Whether the filter waits for steps by hand. */
  #waits = false;
  /** The area that is shown until then. */
  #area = "";
  /** Told of each choice of a tool. @type {(words: string) => void} */
  #chosen = () => {};

  /**
   * @param {DrawLoop} loop
   * @param {(command: Command) => Promise<boolean>} order sends; tells whether it was accepted
   * @param {() => void} goHome
   * @param {import("../features/navigation/journey.js").Journey} journey
   */
  constructor(loop, order, goHome, journey) {
    this.surface = new Surface(find("map-canvas", HTMLCanvasElement), () => this.#resized());
    this.scene = new Scene(this.surface, this.#view);
    this.journey = this.scene.journey = journey;
    const visible = () => this.surface.visible;
    this.refresh = loop.add(() => this.#paint(), { visible, hertz: HERTZ });
    this.telling = new Telling(order, (pose) => journey.go(pose));
    this.numbers = new NumbersForm((act, pose) => this.#tell(act, pose), this.refresh);
    this.tool = new PoseTool(
      () => this.scene.telemetry?.estimate?.theta ?? 0,
      () => this.#view.scale,
      (tool, pose) => {
        const theta = this.tool.aimed ? pose.theta : null;
        if (tool === "goal" && journey.planning?.take({ ...pose, theta })) return;
        this.#tell(tool, pose);
        // The next drag shall not move the robot again.
        this.#choose("look");
      },
    );
    this.measure = new MeasureTool(
      () => this.#view.scale,
      () => this.#choose("look"),
    );
    this.scene.measure = this.measure;
    const changed = () => {
      this.#moved = true;
      this.refresh();
    };
    const ends = new EndTool(() => this.scene.finished, () => this.#view.scale, order);
    this.scene.ends = ends;
    const tools = [ends, this.measure, this.tool];
    this.gestures = new Gestures(this.surface, this.#view, tools, changed, this.refresh, () => this.#fit());
    this.#wire();
    this.#away = new AwayWord(goHome);
  }

  /** @param {FieldMessage} field @param {ImageBitmap} picture */
  setField(field, picture) {
    const known = this.#field?.extent.join() === field.extent.join();
    this.#field = field;
    this.scene.setField(field, picture);
    if (known) return this.refresh();
    this.measure.clear();
    // In an open form, the user may have typed something already.
    if (find("numbers", HTMLElement).hidden) this.numbers.setField(field);
    this.#fit();
  }

  /**
   * Show a map that is drawn by driving; null is the field.
   * @param {MapDrawingMessage | null} drawing
   * @param {number} chosen number of a stroke that stands out
   */
  setDrawing(drawing, chosen = -1) {
    this.scene.drawing = drawing;
    this.scene.chosen = chosen;
    if (!this.#moved) this.#fit();
    this.refresh();
  }

  /** @param {TelemetryMessage} telemetry */
  show(telemetry) {
    this.scene.telemetry = telemetry;
    this.scene.paths.add(telemetry);
    this.scene.particles?.follow(telemetry);
    // Zones are shown to all, whoever drew them.
    if (telemetry.walls && !this.journey.planning) this.planning();
    this.journey.planning?.follow(telemetry);
    // Whoever let the filter wait, here it shows: a lesson's button, or another page.
    if (telemetry.filter.hand && !this.#waits) this.particles().then((panel) => panel.showHand());
    this.#waits = Boolean(telemetry.filter.hand);
    if (!this.#moved && this.#wanted.join() !== this.#area) this.#fit();
    this.refresh();
  }

  /**
   * Describe in words what the map shows; called a few times a second.
   * @param {TelemetryMessage} telemetry
   */
  describe(telemetry) {
    const { integrity } = telemetry;
    const words = certainty(telemetry);
    this.#certainty.dataset.state = integrity.state;
    this.#certainty.title = claim(integrity);
    setText(this.#certainty, words);
    this.#doubts.show(integrity.alerts);
    this.#away.show(this.#field, telemetry);
    setText(this.#hint, HINTS[this.tool.tool] || this.#nextStep.words(telemetry));
    this.telling.show(telemetry.filter);
    setText(this.#text, `${whereabouts(telemetry)} ${words}`);
    const { can_be_placed } = telemetry.robot;
    for (const button of this.#tools) {
      if (toolOf(button) === "place") button.hidden = !can_be_placed;
    }
    this.numbers.allowPlacing(can_be_placed);
  }

  /**
   * Position of a point of the map on the page [CSS px].
   * @param {number} x [m]
   * @param {number} y [m]
   * @returns {[number, number]}
   */
  toPage(x, y) {
    const box = this.surface.canvas.getBoundingClientRect();
    const [u, v] = this.#view.toScreen(x, y);
    return [box.left + u, box.top + v];
  }

  /**
   * Tell of each choice of a tool for poses, which can be used elsewhere, too.
   * @param {(words: string) => void} told gets what to do with it; "" for a tool of the map only
   */
  onChosen(told) {
    this.#chosen = told;
  }

  /** The tool for a press on the floor that is not on the map. @param {number} x [m] @param {number} y [m] */
  toolFor(x, y) {
    const tools = this.gestures.tools.filter((tool) => tool === this.tool || "corners" in tool);
    return tools.find((tool) => tool.wants(x, y)) ?? null;
  }

  /** Lay the tool down. */
  layDown() {
    this.#choose("look");
  }

  /** The pose that is pointed out, with its spread [m] if it will be sent to the filter. */
  get draft() {
    const pose = this.tool.draft;
    return pose && { pose, spread: this.tool.tool === "set_pose" ? this.numbers.sdXy : null };
  }

  /** The robot's outline on the floor [m], in the robot frame. */
  get outline() {
    return this.#field?.robot_outline ?? [];
  }

  #wire() {
    for (const button of this.#tools) {
      button.onclick = ({ detail }) => {
        const tool = toolOf(button);
        // Pressed once more, a tool is laid down.
        this.#choose(tool === this.tool.tool ? "look" : tool);
        // Who chose it by keys goes on by keys.
        if (detail === 0 && this.measure.armed) this.surface.canvas.focus();
      };
    }
    this.surface.canvas.addEventListener("keydown", (event) => this.#disarm(event), { capture: true });
    this.surface.canvas.addEventListener("keydown", (event) => {
      if (this.measure.key(event, [this.#view.x, this.#view.y])) this.refresh();
    });
    findButton("map-in").onclick = () => this.gestures.zoom(1);
    findButton("map-out").onclick = () => this.gestures.zoom(-1);
    findButton("map-fit").onclick = () => this.#fit();
    findButton("map-clear").onclick = () => {
      this.scene.paths.clear();
      this.measure.clear();
      this.refresh();
    };
    const toggle = findButton("numbers-toggle");
    toggle.onclick = () => this.#openNumbers(toggle.getAttribute("aria-expanded") !== "true");
  }

  /** Escape lays a tool down. @param {KeyboardEvent} event */
  #disarm(event) {
    if (event.key !== "Escape" || (this.tool.tool !== "ask" && !this.measure.line && !this.measure.armed && !this.tool.wants())) return;
    this.measure.clear();
    this.#choose("look");
    event.preventDefault();
  }

  /** @param {boolean} open */
  #openNumbers(open) {
    findButton("numbers-toggle").setAttribute("aria-expanded", String(open));
    find("numbers", HTMLElement).hidden = !open;
    const estimate = this.scene.telemetry?.estimate;
    if (open && estimate) this.numbers.pose = estimate;
  }

  /** @param {Tool} tool */
  #choose(tool) {
    this.tool.tool = tool;
    this.tool.cancel();
    this.measure.arm(tool === "measure");
    if (tool === "ask") this.particles().then((panel) => panel.arm(this.tool.tool === tool));
    else this.scene.particles?.arm(false);
    if (tool === "goal") this.planning().then((planning) => planning.arm(this.tool.tool === tool));
    else this.journey.planning?.arm(false);
    for (const button of this.#tools) {
      button.setAttribute("aria-pressed", String(toolOf(button) === tool));
    }
    this.surface.canvas.dataset.tool = tool;
    // Else the arrows drive.
    this.surface.canvas.toggleAttribute("data-own-arrows", tool === "measure");
    setText(this.#hint, HINTS[tool]);
    this.#chosen(this.tool.wants() ? HINTS[tool] : "");
    this.refresh();
  }

  /** What belongs to goals; it is loaded when it is first used. */
  async planning() {
    const { Planning } = await import("../features/navigation/planning.js");
    this.journey.planning ??= new Planning(this.journey, this.#view, this.gestures, this.refresh);
    return this.journey.planning;
  }

  /** What particles say, beside the map; it is loaded when it is first used. */
  async particles() {
    const { ParticlesPanel } = await import("../features/weighing/panel.js");
    const closed = () => this.tool.tool === "ask" && this.#choose("look");
    return this.scene.particles ?? new ParticlesPanel(this.scene, this.#view, this.gestures, this.telling.order, this.refresh, closed);
  }

  /** @param {Tool} tool @param {PoseMessage} pose */
  #tell(tool, pose) {
    this.numbers.pose = pose;
    this.telling.tell(tool, pose, this.numbers);
    if (tool === "place") this.#nextStep.robotMoved();
  }

  /** The area that is shown until the view is moved by hand. */
  get #wanted() {
    if (!this.#field) return [];
    return shownArea(this.#field, this.scene.drawing, whereRobotIs(this.scene.telemetry));
  }

  #fit() {
    this.#moved = false;
    const area = this.#wanted;
    if (area.length > 0 && this.surface.visible) {
      this.#view.fit(area);
      this.#area = area.join();
    }
    this.refresh();
  }

  #resized() {
    this.#view.width = this.surface.width;
    this.#view.height = this.surface.height;
    if (!this.#moved) this.#fit();
    this.refresh();
  }

  #paint() {
    setText(this.#measured, this.measure.words);
    this.scene.paint(this.draft);
  }
}

/** @param {HTMLElement} button of the map, or of the scene in 3D */
const toolOf = ({ dataset: { tool, sceneTool } }) => /** @type {Tool} */ (tool ?? sceneTool);

/** @param {TelemetryMessage} telemetry */
function whereabouts({ truth, estimate }) {
  if (!estimate) return t("The filter has no estimate.");
  const words = t("The filter believes the robot at x {x}, y {y}, heading {heading}.", {
    x: millimetres(estimate.x),
    y: millimetres(estimate.y),
    heading: degrees(estimate.theta),
  });
  if (!truth) return words;
  return `${words} ${t("It is off by {error}.", { error: millimetres(distance(truth, estimate)) })}`;
}
