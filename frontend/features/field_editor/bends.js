// @ts-check
/**
 * Lines and arcs between nodes. A node is x, y [mm] and the bend of the way to the next one: the
 * tangent of a quarter of the arc's angle, positive if it turns left (y up); 0 is straight.
 * @typedef {[number, number, number]} Node
 */

const STRAIGHT = 1e-5;
/** Largest bend that a hand can pull: three quarters of a circle. */
export const MOST = Math.tan((270 / 4) * (Math.PI / 180));

/** At most three decimals, and never -0. @param {number} value */
export const rounded = (value) => Number(value.toFixed(3)) + 0;

/** The arc from one node to the next; null if it is straight. @param {Node} node @param {Node} next */
export function arcOf([x, y, bend], [toX, toY]) {
  const chord = Math.hypot(toX - x, toY - y);
  if (Math.abs(bend) < STRAIGHT || chord < 1e-9) return null;
  return { radius: (chord * (1 + bend * bend)) / (4 * Math.abs(bend)), large: Math.abs(bend) > 1, left: bend > 0 };
}

/** The middle of the way from one node to the next. @param {Node} node @param {Node} next @returns {[number, number]} */
export function middleOf([x, y, bend], [toX, toY]) {
  // The middle of an arc is beside the chord's, to the right if it turns left.
  const beside = bend / 2;
  return [(x + toX) / 2 + beside * (toY - y), (y + toY) / 2 - beside * (toX - x)];
}

/** The bend of the arc through a place. @param {Node} node @param {Node} next @param {[number, number]} place */
export function bendThrough([x, y], [toX, toY], [atX, atY]) {
  const [ax, ay, bx, by] = [x - atX, y - atY, toX - atX, toY - atY];
  const cross = ax * by - ay * bx;
  const dot = ax * bx + ay * by;
  // The angle at the place is half of what the arc leaves of the circle.
  const seen = Math.atan2(Math.abs(cross), dot);
  const angle = 2 * (Math.PI - seen);
  const bend = Math.tan(angle / 4) * (cross < 0 ? 1 : -1);
  return Math.abs(bend) < STRAIGHT ? 0 : Math.max(-MOST, Math.min(MOST, bend));
}

/** How far a place beside the chord bends the way if it is its middle. @param {Node} node @param {Node} next @param {[number, number]} place */
export function bendBeside([x, y], [toX, toY], [atX, atY]) {
  const [dx, dy] = [toX - x, toY - y];
  const square = dx * dx + dy * dy;
  if (square < 1e-9) return 0;
  const bend = (2 * ((atX - (x + toX) / 2) * dy - (atY - (y + toY) / 2) * dx)) / square;
  return Math.abs(bend) < 0.02 ? 0 : Math.max(-MOST, Math.min(MOST, bend));
}

/** Degrees of arc. @param {number} bend */
export const degreesOf = (bend) => (4 * Math.atan(bend) * 180) / Math.PI;

/** @param {number} degrees */
export const bendOf = (degrees) => Math.tan((degrees * Math.PI) / 720);

/**
 * Corners between straight lines as arcs; those without room stay as they are.
 * @param {Node[]} nodes @param {boolean} closed @param {number} radius @returns {Node[]}
 */
export function roundedCorners(nodes, closed, radius) {
  /** @type {Node[]} */
  const result = [];
  nodes.forEach((node, i) => {
    const [before, after] = [nodes.at(i - 1), nodes[(i + 1) % nodes.length]];
    const inner = closed || (i > 0 && i < nodes.length - 1);
    if (!inner || !before || node[2] !== 0 || before[2] !== 0) return void result.push(node);
    const [ax, ay] = [node[0] - before[0], node[1] - before[1]];
    const [bx, by] = [after[0] - node[0], after[1] - node[1]];
    const [a, b] = [Math.hypot(ax, ay), Math.hypot(bx, by)];
    const turn = Math.atan2(ax * by - ay * bx, ax * bx + ay * by);
    const cut = radius * Math.abs(Math.tan(turn / 2));
    if (Math.abs(turn) < 0.02 || cut > Math.min(a, b) / 2 + 1e-6) return void result.push(node);
    result.push([node[0] - (ax / a) * cut, node[1] - (ay / a) * cut, Math.tan(turn / 4)]);
    result.push([node[0] + (bx / b) * cut, node[1] + (by / b) * cut, 0]);
  });
  return result;
}
