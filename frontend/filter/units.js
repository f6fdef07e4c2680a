// @ts-check

/**
 * Units that people read more easily than those of the messages.
 * @type {Record<string, {unit: string, factor: number}>}
 */
const READ_AS = {
  m: { unit: "mm", factor: 1000 },
  rad: { unit: "°", factor: 180 / Math.PI },
  degree: { unit: "°", factor: 1 },
};

/**
 * @param {string} unit of the message
 * @returns {{unit: string, factor: number}} the unit to show, and the factor to convert to it
 */
export function readAs(unit) {
  return READ_AS[unit] ?? { unit, factor: 1 };
}
