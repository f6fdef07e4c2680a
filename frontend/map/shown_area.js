// @ts-check
/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../messages").MapDrawingMessage} MapDrawingMessage */
/** @typedef {import("../messages").PoseMessage} PoseMessage */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {number[]} Area xmin, ymin, xmax, ymax [m] */

/** Floor that is shown around the free part, and around a robot that has left it [m]. */
const AROUND = 0.12;
const AROUND_ROBOT = 0.25;
/** A robot that is farther beyond the free part has left the field [m]. */
const BEYOND = 0.05;
/** Steps in which the shown area grows [m], so that the view does not creep. */
const STEP = 0.25;

/** The area that the map shows by itself: the free part of the field, what is drawn, and the robot. */
export function shownArea(
  /** @type {FieldMessage} */ { drive_area: free, extent },
  /** @type {MapDrawingMessage | null} */ drawing,
  /** @type {PoseMessage | null} */ robot,
) {
  const [xmin, ymin, xmax, ymax] = around(free, AROUND);
  /** @type {Area} */
  const field = [
    Math.max(xmin, extent[0]),
    Math.max(ymin, extent[1]),
    Math.min(xmax, extent[2]),
    Math.min(ymax, extent[3]),
  ];
  const points = (drawing?.strokes ?? []).flatMap((stroke) => stroke.points);
  if (robot && isBeyond(field, robot, 0)) {
    const [x, y] = [robot.x, robot.y];
    const reach = around([x, y, x, y], AROUND_ROBOT);
    const low = reach.slice(0, 2).map((value) => Math.floor(value / STEP) * STEP);
    const high = reach.slice(2).map((value) => Math.ceil(value / STEP) * STEP);
    points.push(/** @type {[number, number]} */ (low), /** @type {[number, number]} */ (high));
  }
  const [xs, ys] = [points.map(([x]) => x), points.map(([, y]) => y)];
  return [
    Math.min(field[0], ...xs),
    Math.min(field[1], ...ys),
    Math.max(field[2], ...xs),
    Math.max(field[3], ...ys),
  ];
}

/** Where the robot is, as well as it is known. @param {TelemetryMessage | null} telemetry */
export function whereRobotIs(telemetry) {
  if (!telemetry) return null;
  return telemetry.truth ?? (telemetry.particles.alike === 1 ? telemetry.estimate : null);
}

/** @param {FieldMessage} field @param {PoseMessage} robot */
export const hasLeft = ({ drive_area }, robot) => isBeyond(drive_area, robot, BEYOND);

/** @param {Area} area @param {PoseMessage} robot @param {number} distance [m] */
function isBeyond(area, { x, y }, distance) {
  const [xmin, ymin, xmax, ymax] = around(area, distance);
  return x < xmin || x > xmax || y < ymin || y > ymax;
}

/** @param {Area} area @param {number} distance [m] @returns {Area} */
const around = ([xmin, ymin, xmax, ymax], distance) => [
  xmin - distance,
  ymin - distance,
  xmax + distance,
  ymax + distance,
];
