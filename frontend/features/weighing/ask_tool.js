// @ts-check
/** @typedef {import("../../messages").PoseMessage} PoseMessage */

/** How near a press is to the ghost, or to the tip of its arrow [CSS px]. */
const REACH = 16;
/** Length of the ghost's arrow [CSS px]; see `drawAim`. */
export const ARROW = 48;
/** A shorter drag is a press [CSS px]. */
const SHORTEST = 4;

/** Presses on the map: choose the particle nearest; drag the one that is asked, or turn it by its arrow. */
export class AskTool {
  armed = false;
  /** @type {"none" | "choose" | "move" | "turn"} */
  #doing = "none";
  /** Where it was pressed, from the pose [m]. @type {[number, number]} */
  #held = [0, 0];

  /**
   * @param {() => number} scale [CSS px/m]
   * @param {() => PoseMessage | null} pose that is asked now
   * @param {(x: number, y: number) => void} choose asks the particle nearest to a place
   * @param {(pose: PoseMessage) => void} move asks another pose
   */
  constructor(scale, pose, choose, move) {
    this.scale = scale;
    this.pose = pose;
    this.choose = choose;
    this.move = move;
  }

  /** @param {number} x @param {number} y */
  wants(x, y) {
    return this.armed || this.#part(x, y) !== "choose";
  }

  /** @param {number} x @param {number} y */
  press(x, y) {
    this.#doing = this.#part(x, y);
    const pose = this.pose();
    this.#held = pose ? [x - pose.x, y - pose.y] : [0, 0];
    if (this.#doing === "choose") this.choose(x, y);
  }

  /** @param {number} x @param {number} y */
  drag(x, y) {
    const pose = this.pose();
    if (!pose || this.#doing === "none") return;
    if (this.#doing === "turn") {
      this.move({ ...pose, theta: Math.atan2(y - pose.y, x - pose.x) });
      return;
    }
    const [dx, dy] = [x - this.#held[0] - pose.x, y - this.#held[1] - pose.y];
    // A hand that shakes shall not turn a particle into another pose.
    if (this.#doing === "choose" || Math.hypot(dx, dy) * this.scale() < SHORTEST) return;
    this.move({ ...pose, x: pose.x + dx, y: pose.y + dy });
  }

  release() {
    this.#doing = "none";
  }

  cancel() {
    this.#doing = "none";
  }

  /** @param {number} x @param {number} y @returns {"choose" | "move" | "turn"} */
  #part(x, y) {
    const pose = this.pose();
    if (!pose) return "choose";
    const reach = REACH / this.scale();
    const arrow = ARROW / this.scale();
    const tip = [pose.x + arrow * Math.cos(pose.theta), pose.y + arrow * Math.sin(pose.theta)];
    if (Math.hypot(x - tip[0], y - tip[1]) < reach) return "turn";
    return Math.hypot(x - pose.x, y - pose.y) < reach ? "move" : "choose";
  }
}
