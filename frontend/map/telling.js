// @ts-check
import { findButton } from "../page/elements.js";
import { Undo } from "./undo.js";

/** @typedef {import("../messages").Command} Command */
/** @typedef {import("../messages").PoseMessage} PoseMessage */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("./numbers.js").NumbersForm} NumbersForm */
/** @typedef {import("./tools.js").Tool} Tool */

/** Sets the filter's pose, or puts the robot elsewhere; only the first can be undone. */
export class Telling {
  #undo = new Undo();
  #button = findButton("undo");

  /**
   * @param {(command: Command) => Promise<boolean>} order sends; tells whether it was accepted
   * @param {() => TelemetryMessage | null} newest
   */
  constructor(order, newest) {
    this.order = order;
    this.newest = newest;
    this.#button.onclick = () => this.#takeBack();
    findButton("scatter").onclick = () => this.scatter();
  }

  /** @param {Tool} tool @param {PoseMessage} pose @param {NumbersForm} numbers for the spread */
  async tell(tool, pose, { sdXy: sd_xy, sdTheta: sd_theta }) {
    if (tool === "set_pose") return this.#believe({ type: "set_pose", ...pose, sd_xy, sd_theta });
    if (tool === "place" && (await this.order({ type: "place", ...pose }))) {
      this.#undo.clear();
      this.#show();
    }
  }

  /** Scatter the filter: the robot may be anywhere. */
  scatter() {
    return this.#believe({ type: "scatter" });
  }

  /** @param {Command} command changes the filter's belief */
  async #believe(command) {
    const before = this.newest();
    if (await this.order(command)) this.#undo.keep(before);
    this.#show();
  }

  async #takeBack() {
    const telemetry = this.newest();
    const command = telemetry && this.#undo.take(telemetry);
    if (command) await this.order(command);
    this.#show();
  }

  #show() {
    this.#button.disabled = !this.#undo.possible;
  }
}
