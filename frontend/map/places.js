// @ts-check
import { millimetres } from "../page/format.js";

/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../messages").HypothesisMessage} HypothesisMessage */
/** @typedef {"" | "sure" | "likely" | "alike" | "lost"} Certainty */

/** Lighter hypotheses are noise. */
const LIKELY = 0.02;
/** From this weight on nobody need doubt. */
const SURE = 0.95;
/** Hypotheses with less weight than this together are no answer: the robot is rather elsewhere. */
const TOLD = 0.5;
/** A chance of being elsewhere that is worth saying. */
const ELSEWHERE = 0.1;
/** Where the robot is known better than this [m], it is known. */
const NEAR = 0.1;
/** Radii of the ellipse that holds 95 % of a planar normal distribution, in standard deviations. */
export const RADII_95 = 2.4477;
const NUMBERS = ["no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten"];

/**
 * The places where the robot may be, heaviest first; none if there is one only, or none at all.
 * @param {TelemetryMessage} telemetry
 * @returns {HypothesisMessage[]}
 */
export function places({ particles: { hypotheses }, filter: { alike } }) {
  if (alike === 0) return [];
  const likely = hypotheses.filter(({ weight }) => weight >= LIKELY);
  return likely.length > 1 ? likely : [];
}

/**
 * How sure the filter is, in words.
 * @param {TelemetryMessage} telemetry
 * @returns {{certainty: Certainty, words: string}}
 */
export function certainty({ particles: { hypotheses }, filter: { alike, updates }, twist }) {
  const told = hypotheses.reduce((sum, { weight }) => sum + weight, 0);
  if (alike === 0) {
    const moves = twist.v !== 0 || twist.omega !== 0;
    const lost = hypotheses.length > 0 && told < TOLD;
    return { certainty: "lost", words: searching(lost, moves) };
  }
  if (alike > 1) {
    const count = NUMBERS[alike] ?? String(alike);
    const rest = 1 - told >= ELSEWHERE ? `, ${percent(1 - told)} elsewhere` : "";
    return { certainty: "alike", words: `${count} places look alike${rest}` };
  }
  const [{ weight, covariance }] = hypotheses;
  if (weight <= SURE) return { certainty: "likely", words: `probably here: ${percent(weight)}` };
  const reach = RADII_95 * ellipse(covariance).sds[0];
  if (reach > NEAR) return { certainty: "likely", words: `about here, ± ${millimetres(tens(reach))}` };
  // A cloud that was just put somewhere knows only what it was told.
  return updates === 0 ? { certainty: "", words: "" } : { certainty: "sure", words: "sure" };
}

/** @param {boolean} lost whether no place fits that did before @param {boolean} moves */
function searching(lost, moves) {
  if (lost) return moves ? "lost: looking around" : "lost: drive a little";
  return moves ? "looking around" : "looking around: drive a little";
}

/**
 * The ellipse of a covariance in x and y.
 * @param {number[]} covariance 9 numbers by rows
 * @returns {{sds: [number, number], angle: number}} the longer one [m] first, with its direction
 */
export function ellipse([xx, xy, , , yy]) {
  const mean = (xx + yy) / 2;
  const spread = Math.hypot((xx - yy) / 2, xy);
  const sd = (/** @type {number} */ variance) => Math.sqrt(Math.max(0, variance));
  return {
    sds: [sd(mean + spread), sd(mean - spread)],
    angle: Math.atan2(2 * xy, xx - yy) / 2,
  };
}

/** Whole centimetres: more is not known. @param {number} metres */
const tens = (metres) => Math.round(metres * 100) / 100;

/** @param {number} weight 0 to 1 */
export function percent(weight) {
  const whole = Math.round(weight * 100);
  // What is not certain must not be rounded to it.
  return weight < 1 && whole === 100 ? "> 99 %" : `${whole} %`;
}
