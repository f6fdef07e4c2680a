// @ts-check
/** @typedef {import("../messages").PoseMessage} PoseMessage */
/** @typedef {"look" | "set_pose" | "place" | "measure" | "ask" | "goal"} Tool */

/** A drag shorter than this [CSS px] sets no heading. */
const SHORTEST = 8;

/** Handles presses on the map: ignore, set the filter's pose, or put the robot; as RViz does. */
export class PoseTool {
  /** @type {Tool} */
  tool = "look";
  /** The pose that the user is pointing out. @type {PoseMessage | null} */
  draft = null;
  /** Whether the drag was long enough to set a heading. */
  aimed = false;

  /**
   * @param {() => number} heading used if the drag sets none [rad]
   * @param {() => number} scale [CSS px/m]
   * @param {(tool: Tool, pose: PoseMessage) => void} finished
   */
  constructor(heading, scale, finished) {
    this.heading = heading;
    this.scale = scale;
    this.finished = finished;
  }

  wants() {
    return this.tool === "set_pose" || this.tool === "place" || this.tool === "goal";
  }

  /** @param {number} x @param {number} y */
  press(x, y) {
    this.aimed = false;
    this.draft = { x, y, theta: this.heading() };
  }

  /**
   * @param {number} x @param {number} y
   * @param {number} [way] of the pointer [CSS px], where that is not the map's
   */
  drag(x, y, way) {
    if (!this.draft) return;
    const [dx, dy] = [x - this.draft.x, y - this.draft.y];
    const far = (way ?? Math.hypot(dx, dy) * this.scale()) >= SHORTEST;
    this.aimed = far;
    this.draft = { ...this.draft, theta: far ? Math.atan2(dy, dx) : this.draft.theta };
  }

  release() {
    const draft = this.draft;
    this.draft = null;
    if (draft) this.finished(this.tool, draft);
  }

  cancel() {
    this.draft = null;
  }
}
