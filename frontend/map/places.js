// @ts-check
import { t } from "../page/language.js";
import { plain } from "../page/format.js";

/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../messages").HypothesisMessage} HypothesisMessage */

/** Smallest probability of being elsewhere that is shown. */
const ELSEWHERE = 0.1;
/** Radii of the ellipse that holds 95 % of a planar normal distribution, in standard deviations. */
export const RADII_95 = 2.4477;
/** Tenths of a degree in a radian. */
const TENTHS = 1800 / Math.PI;
/** How far rounding errors alone may lift a number above a whole one. */
const FUZZ = 1e-6;
/** Number words from two on. */
const NUMBERS = [
  t("two"), t("three"), t("four"), t("five"), t("six"), t("seven"), t("eight"), t("nine"), t("ten"),
];

/**
 * Places where the robot may be, heaviest first; empty if there is only one, or none.
 * @param {TelemetryMessage} telemetry
 * @returns {HypothesisMessage[]}
 */
export function places({ particles: { hypotheses, alike, likely } }) {
  return alike > 0 && likely > 1 ? hypotheses.slice(0, likely) : [];
}

/**
 * Say in words how far the estimate can be relied on.
 * @param {Pick<TelemetryMessage, "filter" | "integrity" | "particles" | "twist">} telemetry
 * @returns {string}
 */
export function certainty(telemetry) {
  const { state, radius } = telemetry.integrity;
  const within = radius === null ? "" : bound(radius);
  if (state === "certain") return within ? t("certain, ± {bound}", { bound: within }) : t("certain");
  if (state === "given")
    return within ? t("as given, ± {bound}", { bound: within }) : t("as given");
  if (state === "approximate")
    return within ? t("about here, ± {bound}", { bound: within }) : t("about here, no bound");
  if (state === "ambiguous") return undecided(telemetry.particles);
  // Then it compares nothing, however far it is driven.
  if (telemetry.filter.paused || telemetry.filter.hand) return t("the filter waits");
  // A robot that stands still sees nothing new: it has to move to find its place.
  const { v, omega } = telemetry.twist;
  if (v === 0 && omega === 0)
    return state === "lost" ? t("lost: drive a little") : t("searching: drive a little");
  return state === "lost" ? t("lost: searching") : t("searching");
}

/** @param {TelemetryMessage["particles"]} particles */
function undecided({ hypotheses, alike }) {
  if (alike === 0) return t("several places look alike");
  if (alike === 1) return t("probably here: {share}", { share: percent(hypotheses[0].weight) });
  const elsewhere = 1 - hypotheses.reduce((sum, { weight }) => sum + weight, 0);
  const number = NUMBERS[alike - 2] ?? String(alike);
  if (elsewhere < ELSEWHERE) return t("{number} places look alike", { number });
  return t("{number} places look alike, {share} elsewhere", { number, share: percent(elsewhere) });
}

/** The claimed bounds in a sentence. @param {TelemetryMessage["integrity"]} integrity */
export function claim({ radius, heading_bound: heading }) {
  const limits = [];
  if (radius !== null) limits.push(bound(radius));
  if (heading !== null) limits.push(`${plain(Math.ceil(heading * TENTHS - FUZZ) / 10, 1)}°`);
  if (limits.length === 0) return t("How sure the filter is of the place; at arrows, how likely each is");
  return t("In 99.9 % of pictures the robot is within {limits} of the estimate.", {
    limits: limits.join(` ${t("and")} `),
  });
}

/** A bound in words, which is never rounded down. @param {number} metres */
function bound(metres) {
  const step = metres < 0.1 ? 1 : 10;
  return `${plain(Math.ceil((metres * 1000) / step - FUZZ) * step)} mm`;
}

/**
 * The ellipse of a covariance in x and y.
 * @param {number[]} covariance 9 numbers by rows
 * @returns {{sds: [number, number], angle: number}} longer axis first [m], and its direction
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

/** @param {number} weight 0 to 1 */
export function percent(weight) {
  const whole = Math.round(weight * 100);
  // A weight below one must not be rounded to 100 %.
  return weight < 1 && whole === 100 ? "> 99 %" : `${whole} %`;
}
