// @ts-check
import { point } from "./language.js";
/** Numbers as people read them: millimetres, degrees, minutes. */

const DASH = "–";

/** @param {number | null | undefined} metres @param {number} [digits] */
export function millimetres(metres, digits = 0) {
  return metres === null || metres === undefined ? DASH : `${plain(metres * 1000, digits)} mm`;
}

/** @param {number | null | undefined} radians @param {number} [digits] */
export function degrees(radians, digits = 0) {
  if (radians === null || radians === undefined) return DASH;
  return `${plain((radians * 180) / Math.PI, digits)}°`;
}

/** Minutes and seconds of the robot's clock. @param {number} seconds */
export function minutes(seconds) {
  const whole = Math.max(0, Math.floor(seconds));
  const [h, m, s] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  const rest = `${String(m).padStart(h ? 2 : 1, "0")}:${String(s).padStart(2, "0")}`;
  return h ? `${h}:${rest}` : rest;
}

/**
 * Fixed digits, the language's decimal sign, a true minus sign and never "-0".
 * @param {number} value
 * @param {number} [digits]
 */
export function plain(value, digits = 0) {
  const text = value.toFixed(digits);
  const shown = Number(text) === 0 ? (0).toFixed(digits) : text.replace("-", "−");
  return shown.replace(".", point);
}

/** All digits that a number has, to be read and typed over, with the language's decimal sign. @param {number} value */
export const typed = (value) => String(value).replace(".", point);

/**
 * The number that somebody typed, with a decimal point or comma; NaN if it is none, or may be two.
 * @param {string} text
 */
export function readNumber(text) {
  const plainText = text.trim().replace("−", "-");
  return /^[+-]?(\d+([.,]\d*)?|[.,]\d+)(e[+-]?\d+)?$/i.test(plainText)
    ? Number(plainText.replace(",", "."))
    : NaN;
}

/** About three figures, without an exponent. @param {number} value */
export function brief(value) {
  if (value === 0 || !Number.isFinite(value)) return plain(value);
  const figures = Math.max(0, Math.min(6, 2 - Math.floor(Math.log10(Math.abs(value)))));
  return plain(value, figures)
    .replace(/([.,]\d*?)0+$/, "$1")
    .replace(/[.,]$/, "");
}

/** @param {{x: number, y: number}} a @param {{x: number, y: number}} b [m] */
export const distance = (a, b) => Math.hypot(a.x - b.x, a.y - b.y);
