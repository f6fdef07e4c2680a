// @ts-check
import { wrapAngle } from "../page/format.js";

/** @typedef {import("../messages").EstimateMessage} EstimateMessage */
/** @typedef {import("../messages").PoseMessage} PoseMessage */
/** @typedef {import("../messages").SetPoseCommand} SetPoseCommand */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */

const MOST = 20;
/** Smallest spread that is sent [m, rad]: a cloud without spread could not be corrected. */
const LEAST = 0.001;

/** The filter's beliefs before the user changed them. */
export class Undo {
  /** @type {{estimate: EstimateMessage, odometry: PoseMessage | null}[]} */
  #kept = [];

  get possible() {
    return this.#kept.length > 0;
  }

  /** Keep the present belief. @param {TelemetryMessage | null} telemetry */
  keep(telemetry) {
    if (!telemetry?.estimate) return;
    this.#kept.push({ estimate: telemetry.estimate, odometry: telemetry.odometry });
    if (this.#kept.length > MOST) this.#kept.shift();
  }

  /** Drop all beliefs: after the robot was put elsewhere, they are of no use. */
  clear() {
    this.#kept = [];
  }

  /**
   * Return the command that restores the last belief, carried forward by odometry.
   * @param {TelemetryMessage} telemetry @returns {SetPoseCommand | null}
   */
  take(telemetry) {
    const last = this.#kept.pop();
    if (!last) return null;
    const { estimate, odometry } = last;
    const [xx, , , , yy, , , , tt] = estimate.covariance;
    const pose =
      odometry && telemetry.odometry ? carry(estimate, odometry, telemetry.odometry) : estimate;
    return {
      type: "set_pose",
      x: pose.x,
      y: pose.y,
      theta: pose.theta,
      sd_xy: Math.max(LEAST, Math.sqrt((xx + yy) / 2)),
      sd_theta: Math.min(10, Math.max(LEAST, Math.sqrt(tt))),
    };
  }
}

/**
 * Return a pose after the same motion as odometry's from one pose to another.
 * @param {PoseMessage} pose
 * @param {PoseMessage} from
 * @param {PoseMessage} to
 */
function carry(pose, from, to) {
  const turn = pose.theta - from.theta;
  const [dx, dy] = [to.x - from.x, to.y - from.y];
  return {
    x: pose.x + Math.cos(turn) * dx - Math.sin(turn) * dy,
    y: pose.y + Math.sin(turn) * dx + Math.cos(turn) * dy,
    theta: wrapAngle(pose.theta + to.theta - from.theta),
  };
}
