// @ts-check
import { findButton } from "../page/elements.js";

/** @typedef {import("../messages").Command} Command */
/** @typedef {import("../messages").FilterMessage} FilterMessage */
/** @typedef {import("../messages").PoseMessage} PoseMessage */
/** @typedef {import("./numbers.js").NumbersForm} NumbersForm */
/** @typedef {import("./tools.js").Tool} Tool */

/** Sets the filter's pose, puts the robot elsewhere or sends it there; only the first can be undone. */
export class Telling {
  #undo = findButton("undo");

  /**
   * @param {(command: Command) => Promise<boolean>} order
   * @param {(pose: PoseMessage) => void} go sends the robot to a goal
   */
  constructor(order, go) {
    this.order = order;
    this.go = go;
    this.#undo.onclick = () => order({ type: "undo" });
    findButton("scatter").onclick = () => this.scatter();
  }

  /** @param {FilterMessage} filter */
  show({ undoable }) {
    this.#undo.disabled = undoable === 0;
  }

  /** @param {Tool} tool @param {PoseMessage} pose @param {NumbersForm} numbers for the spread */
  tell(tool, pose, { sdXy: sd_xy, sdTheta: sd_theta }) {
    if (tool === "set_pose") this.order({ type: "set_pose", ...pose, sd_xy, sd_theta });
    if (tool === "goal") this.go(pose);
    if (tool === "place") this.order({ type: "place", ...pose });
  }

  /** Scatter the filter: the robot may be anywhere. */
  scatter() {
    this.order({ type: "scatter" });
  }
}
