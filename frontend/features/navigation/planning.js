// @ts-check
import { findButton, make, setText } from "../../page/elements.js";
import { plain } from "../../page/format.js";
import { t, tn } from "../../page/language.js";
import { sentence } from "../../page/toasts.js";
import { getJson } from "../../wire/http.js";
import { costPicture, drawWaypoints, drawZone } from "./drawing.js";
import { ZoneTool } from "./zone_tool.js";

/** @typedef {import("../../messages").Command} Command */
/** @typedef {import("../../messages").CostsMessage} CostsMessage */
/** @typedef {import("../../messages").GoalMessage} GoalMessage */
/** @typedef {import("../../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../../messages").WallsMessage} WallsMessage */
/** @typedef {import("../../map/gestures.js").Gestures} Gestures */
/** @typedef {import("../../map/view.js").MapView} MapView */
/** @typedef {import("./journey.js").Journey} Journey */

/** What belongs to goals: waypoints, keep-out zones, tape, and the costs that a way has. Loaded when it is first used. */
export class Planning {
  /** Waypoints that wait to be driven to. @type {GoalMessage[]} */
  #points = [];
  /** @type {WallsMessage} */
  #walls = { tape: "wall", zones: [] };
  /** When those walls were said [s]. */
  #said = -1;
  /** @type {{costs: CostsMessage, picture: HTMLCanvasElement} | null} */
  #layer = null;
  /** @type {ZoneTool} */
  #zone;
  #several = toggle(t("several"), t("Press several goals, then drive to one after the other"));
  #once = make("button", { type: "button", title: t("Drive to all of them, one after the other") });
  #patrol = make("button", { type: "button", title: t("Drive to all of them, again and again") }, t("patrol"));
  #back = make("button", { type: "button", title: t("Take back the last of them") }, t("take back"));
  #draw = toggle(t("keep out"), t("Draw a zone that the robot does not enter: drag from corner to corner"));
  #remove = make("button", { type: "button", title: t("Remove the zone that was drawn last") });
  #tape = toggle(t("cross tape"), t("Whether the robot may cross tape on its way to goals"));
  #eight = make("button", { type: "button", title: t("Drive the figure-eight closed: the robot stays on the curve by its estimate, at the speed of the slider") }, t("closed figure-eight"));
  #follow = make("button", { type: "button", title: t("Follow the tape ahead by the camera, without a map, at the speed of the slider") }, t("follow tape"));
  #costs = toggle(t("costs"), t("Shade the floor by what a way there costs: that is why the robot goes around"));
  #words = make("p", { role: "status" });
  #row = make("div", { id: "planning", class: "tools", role: "group", "aria-label": t("Goals") });

  /**
   * @param {Journey} journey
   * @param {MapView} view
   * @param {Gestures} gestures
   * @param {() => void} refresh paints the map again
   */
  constructor(journey, view, gestures, refresh) {
    this.journey = journey;
    this.view = view;
    this.refresh = refresh;
    this.#zone = new ZoneTool(() => view.scale, (corners) => {
      this.#say({ zones: [...this.#walls.zones, corners] });
      this.#press(this.#draw, () => (this.#zone.armed = false));
    });
    gestures.tools.unshift(this.#zone);
    this.#several.onclick = () => this.#press(this.#several, (on) => !on && this.#clear());
    this.#once.onclick = () => this.#go(false);
    this.#patrol.onclick = () => this.#go(true);
    this.#back.onclick = () => {
      this.#points.pop();
      this.#show();
    };
    this.#draw.onclick = () => this.#press(this.#draw, (on) => (this.#zone.armed = on));
    this.#remove.onclick = () => this.#say({ zones: this.#walls.zones.slice(0, -1) });
    this.#tape.onclick = () => this.#say({ tape: this.#walls.tape === "wall" ? "ignored" : "wall" });
    this.#costs.onclick = () => this.#press(this.#costs, (on) => (on ? this.#ask() : (this.#layer = null)));
    this.#eight.onclick = () => journey.loop();
    this.#follow.onclick = () => journey.followTape();
    this.#row.append(this.#several, this.#once, this.#patrol, this.#back, this.#draw, this.#remove, this.#tape, this.#costs, this.#eight, this.#follow);
    this.#row.hidden = true;
    findButton("journey-cancel").closest("p")?.before(this.#row, this.#words);
    this.#show();
  }

  /** Show the row while the tool for goals is chosen. @param {boolean} armed */
  arm(armed) {
    this.#row.hidden = !armed;
    if (!armed) {
      this.#zone.armed = false;
      this.#draw.setAttribute("aria-pressed", "false");
      this.#clear();
    }
    this.#show();
  }

  /**
   * Take a goal that was pressed.
   * @param {GoalMessage} goal
   * @returns {boolean} whether more may follow: it waits to be driven to
   */
  take(goal) {
    if (!isOn(this.#several)) return false;
    this.#points.push(goal);
    this.#show();
    return true;
  }

  /** @param {TelemetryMessage} telemetry */
  follow({ walls }) {
    if (walls === undefined || walls === null || walls === this.#said) return;
    this.#said = walls;
    this.#load();
  }

  /** Shade the floor, below all else. @param {CanvasRenderingContext2D} context in CSS pixels */
  paintBelow(context) {
    if (!this.#layer) return;
    const { costs, picture } = this.#layer;
    const [left, top] = this.view.toScreen(costs.x, costs.y + costs.rows * costs.step);
    const scale = costs.step * this.view.scale;
    context.imageSmoothingEnabled = false;
    context.drawImage(picture, left, top, costs.columns * scale, costs.rows * scale);
    context.imageSmoothingEnabled = true;
  }

  /** @param {CanvasRenderingContext2D} context in metres @param {number} pixel [m] */
  paint(context, pixel) {
    for (const zone of this.#walls.zones) drawZone(context, zone, pixel);
    if (this.#zone.corners) drawZone(context, this.#zone.corners, pixel, true);
    drawWaypoints(context, this.#points, pixel);
  }

  /** @param {boolean} repeat */
  #go(repeat) {
    this.journey.goAll(this.#points, repeat);
    this.#clear();
  }

  #clear() {
    this.#points = [];
    this.#several.setAttribute("aria-pressed", "false");
    this.#show();
  }

  /** @param {Omit<Extract<Command, {type: "set_walls"}>, "type">} said */
  #say(said) {
    this.journey.order({ type: "set_walls", ...said });
  }

  async #load() {
    try {
      this.#walls = await getJson("api/navigation/walls");
      if (isOn(this.#costs)) await this.#ask();
    } catch (error) {
      this.#said = -1;
    }
    this.#show();
  }

  async #ask() {
    try {
      /** @type {CostsMessage} */
      const costs = await getJson("api/navigation/costs");
      this.#layer = isOn(this.#costs) ? { costs, picture: costPicture(costs) } : null;
    } catch (error) {
      setText(this.#words, sentence(error));
    }
    this.#show();
  }

  /** @param {HTMLElement} button @param {(on: boolean) => void} then */
  #press(button, then) {
    const on = !isOn(button);
    button.setAttribute("aria-pressed", String(on));
    then(on);
    this.#show();
  }

  #show() {
    const [points, zones] = [this.#points.length, this.#walls.zones.length];
    for (const button of [this.#once, this.#patrol, this.#back]) button.hidden = points === 0;
    setText(this.#once, tn("drive to {count} goal", "drive to {count} goals", points));
    this.#remove.hidden = zones === 0;
    setText(this.#remove, tn("remove the zone", "remove the last of {count} zones", zones));
    this.#tape.setAttribute("aria-pressed", String(this.#walls.tape === "ignored"));
    setText(this.#words, this.#layer ? costWords(this.#layer.costs) : "");
    this.refresh();
  }
}

/** @param {CostsMessage} costs */
function costWords({ inflation_radius, cost_scaling_factor }) {
  return t(
    "Dark: the robot cannot turn there. Orange: a way there costs more. The cost falls as exp(−{factor} d) with the distance d [m] (cost_scaling_factor), and ends {radius} m from walls (inflation_radius).",
    { radius: plain(inflation_radius, 2), factor: plain(cost_scaling_factor) },
  );
}

/** @param {HTMLElement} button */
const isOn = (button) => button.getAttribute("aria-pressed") === "true";

/** @param {string} words @param {string} title */
const toggle = (words, title) => make("button", { type: "button", "aria-pressed": "false", title }, words);
