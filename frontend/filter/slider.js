// @ts-check
/** @typedef {import("../messages").ParameterMessage} ParameterMessage */

/** Number of a slider's steps; the number field beside it is exact. */
export const STEPS = 1000;
/** From this ratio of the limits on, a linear slider would be useless at its low end. */
const WIDE = 100;
const SKEWED = 20;

/** Converts between a parameter's value and its slider: linear, logarithmic, or finer near zero. */
export class SliderScale {
  /** @param {ParameterMessage} parameter whose default is a number */
  constructor({ low, high, default: standard, integer }) {
    const usual = Math.abs(Number(standard)) || 1;
    this.low = low ?? Math.min(0, Number(standard) - 4 * usual);
    this.high = high ?? Number(standard) + 4 * usual;
    this.integer = integer ?? false;
    if (this.low > 0 && this.high / this.low >= WIDE) this.bend = "log";
    else if (this.low === 0 && Number(standard) > 0 && this.high / usual >= SKEWED)
      this.bend = "cube";
    else this.bend = "straight";
  }

  /** @param {number} value @returns {number} 0 to STEPS */
  toSlider(value) {
    const inside = Math.min(this.high, Math.max(this.low, value));
    if (this.bend === "log") {
      return (STEPS * Math.log(inside / this.low)) / Math.log(this.high / this.low);
    }
    const share = (inside - this.low) / (this.high - this.low || 1);
    return STEPS * (this.bend === "cube" ? Math.cbrt(share) : share);
  }

  /** @param {number} position 0 to STEPS @returns {number} rounded to the slider's resolution */
  fromSlider(position) {
    const share = position / STEPS;
    if (position >= STEPS) return this.high;
    if (position <= 0) return this.low;
    let value = this.low + (this.high - this.low) * (this.bend === "cube" ? share ** 3 : share);
    if (this.bend === "log") value = this.low * (this.high / this.low) ** share;
    return this.integer ? Math.round(value) : Number(value.toPrecision(3));
  }
}
