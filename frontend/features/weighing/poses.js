// @ts-check
/** @typedef {import("../../messages").PoseMessage} PoseMessage */

/** A pose seen from another: `pose` moved by `step`. @param {PoseMessage} pose @param {PoseMessage} step @returns {PoseMessage} */
export function moved({ x, y, theta }, step) {
  const [c, s] = [Math.cos(theta), Math.sin(theta)];
  return {
    x: x + c * step.x - s * step.y,
    y: y + s * step.x + c * step.y,
    theta: wrapped(theta + step.theta),
  };
}

/** The step from one pose to another, in the first one's frame. @param {PoseMessage} from @param {PoseMessage} to @returns {PoseMessage} */
export function between(from, to) {
  const [c, s] = [Math.cos(from.theta), Math.sin(from.theta)];
  const [dx, dy] = [to.x - from.x, to.y - from.y];
  return { x: c * dx + s * dy, y: c * dy - s * dx, theta: wrapped(to.theta - from.theta) };
}

/** @param {number} angle [rad] */
const wrapped = (angle) => angle - 2 * Math.PI * Math.floor(angle / (2 * Math.PI) + 0.5);
