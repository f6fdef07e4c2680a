// @ts-check
import { distance } from "../page/format.js";
import { t } from "../page/language.js";

/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../page/palette.js").ColourName} ColourName */
/**
 * @typedef {object} Quantity
 * @property {string} name for people
 * @property {string} unit also tells which axis it has
 * @property {number} digits
 * @property {ColourName} [colour] where one belongs to it on the whole page
 * @property {number[]} [dash]
 * @property {(news: TelemetryMessage, delay: number | null) => number | null | undefined} of
 */

const DEGREE = 180 / Math.PI;
/** Half axis of an ellipse that holds 95 % of a planar normal distribution [standard deviations]. */
const RADIUS_95 = 2.4477;
/** The same of a single number. */
const SIDE_95 = 1.96;

/** While places look alike, the likeliest one keeps changing: no single error is right. @param {TelemetryMessage} news */
const single = (news) => (news.particles.alike < 2 ? news.estimate : null);

/** @typedef {{x: number, y: number, theta: number} | null | undefined} Pose */

/** @param {Pose} a @param {Pose} b [mm] */
const apart = (a, b) => (a && b ? distance(a, b) * 1000 : null);

/** @param {Pose} a @param {Pose} b [degrees] */
function turned(a, b) {
  if (!a || !b) return null;
  const angle = a.theta - b.theta;
  return Math.abs(Math.atan2(Math.sin(angle), Math.cos(angle))) * DEGREE;
}

/** Longest half axis of the ellipse of 95 % [mm]. @param {TelemetryMessage} news */
function spread({ estimate }) {
  if (!estimate) return null;
  const [xx, xy, , , yy] = estimate.covariance;
  const longest = (xx + yy) / 2 + Math.hypot((xx - yy) / 2, xy);
  return RADIUS_95 * Math.sqrt(Math.max(0, longest)) * 1000;
}

/** Ranges that returned [mm]. @param {TelemetryMessage} news */
const returns = ({ scan }) => scan.ranges.flatMap((range) => (range === null ? [] : [range * 1000]));

/** @param {number[]} values */
const median = (values) => values.sort((a, b) => a - b)[Math.floor(values.length / 2)];

/**
 * Every value that can be plotted, by name.
 * @type {Record<string, Quantity>}
 */
export const QUANTITIES = {
  estimateError: {
    name: t("error of the estimate"), unit: "mm", digits: 1, colour: "estimate",
    of: (news) => apart(news.truth, single(news)),
  },
  odometryError: {
    name: t("error of odometry"), unit: "mm", digits: 1, colour: "odometry", dash: [7, 4],
    of: (news) => apart(news.truth, news.odometry),
  },
  thenError: {
    name: t("error as recorded"), unit: "mm", digits: 1, colour: "then", dash: [9, 3, 2, 3],
    of: (news) => apart(news.truth, news.replay?.estimate_then),
  },
  bound: {
    name: t("bound (99.9 %)"), unit: "mm", digits: 1, colour: "warning", dash: [3, 3],
    of: ({ integrity: { radius } }) => (radius === null ? null : radius * 1000),
  },
  spread: {
    name: t("± of the estimate (95 %)"), unit: "mm", digits: 1, colour: "quiet", dash: [8, 3], of: spread,
  },
  headingError: {
    name: t("heading error of the estimate"), unit: "°", digits: 2, colour: "estimate",
    of: (news) => turned(news.truth, single(news)),
  },
  odometryHeadingError: {
    name: t("heading error of odometry"), unit: "°", digits: 2, colour: "odometry", dash: [7, 4],
    of: (news) => turned(news.truth, news.odometry),
  },
  headingBound: {
    name: t("bound of the heading (99.9 %)"), unit: "°", digits: 2, colour: "warning", dash: [3, 3],
    of: ({ integrity: { heading_bound: bound } }) => (bound === null ? null : bound * DEGREE),
  },
  headingSpread: {
    name: t("± of the heading (95 %)"), unit: "°", digits: 2, colour: "quiet", dash: [8, 3],
    of: ({ estimate }) => estimate && SIDE_95 * Math.sqrt(Math.max(0, estimate.covariance[8])) * DEGREE,
  },
  x: { name: "x", unit: "m", digits: 3, of: ({ estimate }) => estimate?.x },
  y: { name: "y", unit: "m", digits: 3, dash: [7, 4], of: ({ estimate }) => estimate?.y },
  trueX: { name: t("true x"), unit: "m", digits: 3, dash: [2, 3], of: ({ truth }) => truth?.x },
  trueY: { name: t("true y"), unit: "m", digits: 3, dash: [9, 3, 2, 3], of: ({ truth }) => truth?.y },
  nearest: {
    name: t("nearest range"), unit: "mm", digits: 0, colour: "rays",
    of: (news) => Math.min(...returns(news)),
  },
  medianRange: {
    name: t("median range"), unit: "mm", digits: 0, dash: [7, 4], of: (news) => median(returns(news)),
  },
  hits: { name: t("rays that hit"), unit: t("rays"), digits: 0, colour: "rays", of: (news) => returns(news).length },
  tape: {
    name: t("width of the tape"), unit: "mm", digits: 1,
    of: ({ scan: { tape_width: width } }) => (width === null ? null : width * 1000),
  },
  v: { name: t("speed"), unit: "m/s", digits: 3, of: ({ twist }) => twist.v },
  omega: { name: t("turning speed"), unit: "rad/s", digits: 2, of: ({ twist }) => twist.omega },
  left: { name: t("left wheel"), unit: "rad/s", digits: 2, of: ({ wheels }) => wheels?.[0] },
  right: { name: t("right wheel"), unit: "rad/s", digits: 2, dash: [7, 4], of: ({ wheels }) => wheels?.[1] },
  effective: {
    name: t("effective particles"), unit: t("particles"), digits: 0, colour: "estimate",
    of: ({ particles }) => particles.effective,
  },
  count: {
    name: t("all particles"), unit: t("particles"), digits: 0, colour: "quiet", dash: [7, 4],
    of: ({ particles }) => particles.count,
  },
  loop: { name: t("loop"), unit: "Hz", digits: 0, colour: "truth", of: ({ loop }) => loop.step_hz },
  step: { name: t("work of a step"), unit: "ms", digits: 1, of: ({ loop }) => loop.step_ms },
  delay: { name: t("delay"), unit: "ms", digits: 0, colour: "odometry", dash: [7, 4], of: (_, delay) => delay },
  battery: { name: t("battery"), unit: "V", digits: 2, of: ({ robot }) => robot.battery_v },
};

/** Choices that come with the page. @type {Record<string, string[]>} */
export const PRESETS = {
  error: ["estimateError", "odometryError"],
  /** Odometry, which is farther off, would set the scale of two estimates that are compared. */
  replay: ["estimateError", "thenError"],
  bound: ["estimateError", "bound", "spread"],
  heading: ["headingError", "headingBound", "headingSpread"],
  particles: ["effective", "count"],
  timing: ["loop", "delay"],
};
