// @ts-check

/**
 * @typedef {object} Axis
 * @property {number} low
 * @property {number} high
 * @property {string} label with its unit
 * @property {boolean} [log] logarithmic; low and high must then be above zero
 */

/**
 * @typedef {object} Scale
 * @property {(value: number) => number} at pixel of a value [CSS px]
 * @property {(pixel: number) => number} value value at a pixel
 * @property {number[]} ticks round values between low and high
 */

/**
 * @param {Axis} axis
 * @param {number} from pixel of the low end
 * @param {number} to pixel of the high end
 * @param {number} most about this many ticks
 * @returns {Scale}
 */
export function axisScale(axis, from, to, most) {
  const bend = axis.log ? Math.log : (/** @type {number} */ value) => value;
  const unbend = axis.log ? Math.exp : (/** @type {number} */ value) => value;
  const [low, high] = [bend(axis.low), bend(axis.high)];
  const slope = (to - from) / (high - low || 1);
  const ticks = axis.log ? decades(axis.low, axis.high) : roundTicks(axis.low, axis.high, most);
  return {
    at: (value) => from + (bend(axis.log ? Math.max(value, axis.low) : value) - low) * slope,
    value: (pixel) => unbend(low + (pixel - from) / slope),
    ticks,
  };
}

/** Of a step; an end may lie between: with 10 after 5, half of a plot would be empty. */
const STEPS = [1, 2, 5];
const ENDS = [1, 1.5, 2, 2.5, 3, 4, 5, 6, 8];

/** Round up to 1, 2 or 5 times a power of ten. @param {number} value above zero @param {number[]} to other numbers than these */
export function roundUp(value, to = STEPS) {
  const decade = 10 ** Math.floor(Math.log10(value));
  return (to.find((one) => one * decade >= value * 0.999999) ?? 10) * decade;
}

/** Round up to the end of an axis. @param {number} value above zero */
export const roundEnd = (value) => roundUp(value, ENDS);

/**
 * Ticks at round steps; the last tick is at the high end if a step allows it.
 * @param {number} low
 * @param {number} high
 * @param {number} most
 * @returns {number[]}
 */
function roundTicks(low, high, most) {
  const wanted = roundUp((high - low || 1) / Math.max(1, most));
  const steps = [wanted, 1.25 * wanted, 2.5 * wanted, 2 * wanted];
  const step = steps.find((one) => Math.abs(high / one - Math.round(high / one)) < 1e-9) ?? wanted;
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: last - first + 1 }, (_, i) => (first + i) * step);
}

/** @param {number} low @param {number} high @returns {number[]} */
function decades(low, high) {
  const ticks = [];
  for (let power = Math.ceil(Math.log10(low) - 1e-9); 10 ** power <= high * 1.000001; power++) {
    ticks.push(10 ** power);
  }
  return ticks;
}
