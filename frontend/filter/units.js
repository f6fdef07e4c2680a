// @ts-check

/**
 * Units that people read more easily than the wire's.
 * @type {Record<string, {unit: string, factor: number}>}
 */
const READ_AS = {
  m: { unit: "mm", factor: 1000 },
  rad: { unit: "°", factor: 180 / Math.PI },
};

/**
 * @param {string} unit as on the wire
 * @returns {{unit: string, factor: number}} what to show and how to get there
 */
export function readAs(unit) {
  return READ_AS[unit] ?? { unit, factor: 1 };
}
