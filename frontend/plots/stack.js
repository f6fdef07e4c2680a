// @ts-check
import { t } from "../page/language.js";
import { palette } from "../page/palette.js";
import { drawInto } from "./chart.js";
import { QUANTITIES } from "./quantities.js";
import { roundEnd } from "./scale.js";

/** @typedef {import("./chart.js").Pen} Pen */
/** @typedef {import("./history.js").History} History */
/** @typedef {import("./scale.js").Scale} Scale */
/** @typedef {import("./span.js").Span} Span */
/**
 * @typedef {object} Plot
 * @property {History} history
 * @property {string[]} names of the values
 * @property {Span} span
 * @property {boolean} log whether axes are by powers of ten
 * @property {number | null} cursor stamp that is read out [s]
 */

/** The lowest value of a logarithmic axis. */
const LOG_FLOOR = 0.1;
/** Values without a colour of their own take these in turn. */
const COLOURS = /** @type {const} */ (["estimate", "odometry", "truth", "then", "rays", "text"]);

/** Colour and dashes of a value. @param {string} name @param {number} place among those shown */
export function lookOf(name, place) {
  const { colour, dash } = QUANTITIES[name];
  return { colour: palette[colour ?? COLOURS[place % COLOURS.length]], dash: dash ?? [] };
}

/**
 * Draw values over time, with an axis for each unit, one below the other.
 * @param {Pen} pen @param {Plot} plot @param {number} width @param {number} height
 * @returns {Scale} of stamps
 */
export function drawStack(pen, plot, width, height) {
  const units = [...new Set(plot.names.map((name) => QUANTITIES[name].unit))];
  const share = height / Math.max(1, units.length);
  const scales = units.map((unit, i) =>
    drawInto(pen, chart(plot, unit), { top: i * share, width, height: share }),
  );
  return scales[0] ?? drawInto(pen, chart(plot, ""), { top: 0, width, height });
}

/** @param {Plot} plot @param {string} unit */
function chart({ history, names, span, log, cursor }, unit) {
  const [low, high] = span.ends(history.stamps);
  const [from, until] = [Math.max(0, history.after(low) - 1), history.after(high) + 1];
  const xs = history.stamps.slice(from, until);
  const series = names.flatMap((name, place) => {
    if (QUANTITIES[name].unit !== unit) return [];
    return [{ ...lookOf(name, place), xs, ys: history.values[name].slice(from, until) }];
  });
  const known = series.flatMap(({ ys }) => ys.filter(Number.isFinite));
  const [least, most] = limits(known);
  const isLog = log && most > LOG_FLOOR;
  return {
    x: { low, high, label: t("seconds") },
    y: { low: isLog ? LOG_FLOOR : least, high: most, label: unit, log: isLog },
    series,
    cursor,
  };
}

/** Round ends of an axis that begins at zero, or below. @param {number[]} known @returns {[number, number]} */
function limits(known) {
  let [low, high] = [0, 0];
  for (const value of known) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  if (low === 0 && high === 0) return [0, 1];
  return [low < 0 ? -roundEnd(-low) : 0, high > 0 ? roundEnd(high) : 0];
}
