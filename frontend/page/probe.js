// @ts-check
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */

/**
 * `window.brickpose`: values for tests from outside. Nothing on the page reads it.
 * @typedef {object} Probe
 * @property {TelemetryMessage | null} telemetry the newest one
 * @property {number[]} delays of the last pictures, from exposure to drawn [ms]
 * @property {boolean} connected whether telemetry comes
 * @property {(x: number, y: number) => [number, number]} mapPixel where a point of the map [m] is
 *   on the page [CSS px]
 */

const MOST_DELAYS = 300;

/** @param {Probe["mapPixel"]} mapPixel @returns {Probe} */
export function exposeProbe(mapPixel) {
  /** @type {Probe} */
  const probe = { telemetry: null, delays: [], connected: false, mapPixel };
  Object.assign(window, { brickpose: probe });
  return probe;
}

/** @param {Probe} probe @param {number} delay [ms] */
export function addDelay(probe, delay) {
  probe.delays.push(delay);
  if (probe.delays.length > MOST_DELAYS) probe.delays.shift();
}
