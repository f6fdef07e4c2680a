// @ts-check
import { OwnDrive } from "../../drive/own_drive.js";
import { find, findButton, setText } from "../../page/elements.js";
import { plain } from "../../page/format.js";
import { t, translated } from "../../page/language.js";
import { getJson } from "../../wire/http.js";

/** @typedef {import("../../messages").Command} Command */
/** @typedef {import("../../messages").GoalMessage} GoalMessage */
/** @typedef {import("../../messages").NavigationMessage} NavigationMessage */
/** @typedef {import("../../messages").NavigationPathMessage} NavigationPathMessage */
/** @typedef {import("../../messages").PoseMessage} PoseMessage */
/** @typedef {import("../../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../../drive/lease.js").Drive} Drive */

/** Sends the robot to a goal, and shows how far it is; this page renews the journey. */
export class Journey {
  /** The way on the map; null without one. @type {NavigationPathMessage | null} */
  way = null;
  /** Waypoints, zones and costs, once they are used. @type {import("./planning.js").Planning | null} */
  planning = null;
  #line = find("journey", HTMLElement);
  #text = find("journey-text", HTMLElement);
  #cancel = findButton("journey-cancel");
  /** @type {OwnDrive} */
  #own;
  /** When the way that was asked for was planned [s]. */
  #asked = 0;
  /** Whether this page has the robot drive along a closed curve. */
  #onCurve = false;
  /** Whether this page has the robot follow tape. */
  #onTape = false;

  /**
   * @param {Drive} drive
   * @param {(command: Command) => Promise<boolean>} order
   */
  constructor(drive, order) {
    this.drive = drive;
    this.order = order;
    this.#own = new OwnDrive(drive, order, "navigate");
    this.#cancel.onclick = () => order({ type: "cancel" });
  }

  /** Drive to a pose. @param {PoseMessage} pose */
  go({ x, y, theta }) {
    this.goAll([{ x, y, theta }], false);
  }

  /**
   * Drive to goals, one after the other.
   * @param {GoalMessage[]} poses
   * @param {boolean} repeat whether to begin again after the last one
   */
  goAll(poses, repeat) {
    this.#begin({ type: "navigate", poses, repeat, renewed: true });
  }

  /** Drive the figure-eight by the estimate; or end it, if this page drives a curve. */
  loop() {
    if (this.#onCurve) return void this.order({ type: "cancel" });
    const speed = Math.min(this.drive.speed, this.drive.maxV);
    this.#begin({ type: "navigate", curve: { shape: "figure_eight", speed }, renewed: true });
  }

  /** Follow the tape ahead by the camera, without a map; or end it, if this page does. */
  followTape() {
    if (this.#onTape) return void this.order({ type: "cancel" });
    this.#begin({ type: "navigate", line: { speed: Math.min(this.drive.speed, this.drive.maxV) }, renewed: true });
  }

  /** @param {Command} command */
  #begin(command) {
    if (this.drive.mayBegin) this.#own.begin(command);
    // The refusal says who drives, and what to do.
    else this.order(command);
  }

  /** @param {TelemetryMessage} telemetry */
  follow({ mode, navigation, driver }) {
    this.#onCurve = mode === "navigate" && this.#own.mine && !!navigation?.on_curve;
    this.#onTape = mode === "navigate" && this.#own.mine && !navigation?.on_curve && this.way?.goals.length === 0;
    this.#own.heed(mode === "navigate", driver.stopped);
    this.#own.follow(mode === "navigate");
    this.#line.hidden = !navigation;
    if (!navigation) return void (this.way = null);
    setText(this.#text, words(navigation, this.way?.goals.length ?? 1));
    this.#cancel.hidden = !isActive(navigation);
    if (navigation.planned !== this.#asked) this.#load(navigation.planned);
  }

  /** @param {number} planned [s] */
  async #load(planned) {
    this.#asked = planned;
    this.way = await getJson("api/navigation").catch(() => null);
  }
}

/** @param {NavigationMessage} navigation */
const isActive = ({ state }) => state === "planning" || state === "driving" || state === "waiting";

/** @param {NavigationMessage} navigation @param {number} count of goals */
function words({ state, remaining_m, remaining_s, reason, number, on_curve }, count) {
  const why = reason ? translated(reason) : "";
  const left = { way: plain(remaining_m, 2), time: plain(remaining_s, 0) };
  switch (state) {
    case "planning":
      return t("goal: planning the way");
    case "driving":
      if (on_curve) return t("curve: {way} m of this lap left", left);
      if (count === 0) return t("tape: following it");
      if (count > 1) return t("goal {number} of {count}: {way} m, {time} s left", { number: number + 1, count, ...left });
      if (why) return t("goal: {way} m, {time} s left; {why}", { why, ...left });
      return t("goal: {way} m, {time} s left", left);
    case "waiting":
      return t("goal: waiting; {why}", { why });
    case "arrived":
      return why ? t("goal: arrived; {why}", { why }) : t("goal: arrived");
    case "canceled":
      return t("goal: canceled; {why}", { why });
    default:
      return t("goal: failed; {why}", { why });
  }
}
