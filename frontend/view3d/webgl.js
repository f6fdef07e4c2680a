// @ts-check

/** Renderer names of browsers that draw WebGL on the processor. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;
/** Without a graphics card, the pause is this multiple of the drawing time, within limits [ms]. */
const SHARE = 5;
const SHORTEST_MS = 250;
const LONGEST_MS = 2000;

/** @typedef {"none" | "software" | "hardware"} WebGl */

/** What this browser draws 3D with. @returns {WebGl} */
export function findWebGl() {
  const context = document.createElement("canvas").getContext("webgl2");
  if (!context) return "none";
  const names = context.getExtension("WEBGL_debug_renderer_info");
  const name = context.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : context.RENDERER);
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return SOFTWARE.test(String(name)) ? "software" : "hardware";
}

/**
 * Let a frame draw only now and then. It shares one thread with the page, and a scene that is drawn
 * on the processor would take all of its time: camera pictures came more than a second late.
 * @param {Window} target
 */
export function calm(target) {
  let pause = SHORTEST_MS;
  const request = target.requestAnimationFrame.bind(target);
  const cancel = target.cancelAnimationFrame.bind(target);
  /** @type {Map<number, number>} */
  const asked = new Map();
  target.requestAnimationFrame = (callback) => {
    const draw = (/** @type {number} */ now) => {
      asked.delete(timer);
      callback(now);
      measure((cost) => (pause = Math.min(LONGEST_MS, Math.max(SHORTEST_MS, SHARE * cost))));
    };
    const timer = setTimeout(() => asked.set(timer, request(draw)), pause);
    return timer;
  };
  target.cancelAnimationFrame = (timer) => {
    clearTimeout(timer);
    cancel(asked.get(timer) ?? timer);
    asked.delete(timer);
  };
}

/**
 * Measure how long a drawing that was just requested delays the page's own drawing.
 * @param {(cost: number) => void} told [ms]
 */
function measure(told) {
  const start = performance.now();
  requestAnimationFrame(() => requestAnimationFrame(() => told(performance.now() - start)));
}
