// @ts-check
/**
 * Where panels are, as a tree: a panel's name, or parts beside each other (a row) or below each
 * other (a column), with the share of each. Trees are never changed; changes make new ones.
 *
 * @typedef {{split: "row" | "column", shares: number[], parts: Tree[]}} Split
 * @typedef {string | Split} Tree
 * @typedef {{x: number, y: number, width: number, height: number}} Box in shares of the whole
 */
/**
 * @typedef {object} Border between two neighbours, which can be moved
 * @property {number[]} path of the split, as places from the root on
 * @property {number} place of the neighbour before the border
 * @property {"row" | "column"} split
 * @property {Box} box of both neighbours together
 * @property {number} share of the neighbour before, in that box
 */

/** @type {Box} */
const WHOLE = { x: 0, y: 0, width: 1, height: 1 };
/** No panel becomes smaller than this share of the two that a border parts. */
const LEAST = 0.12;
/** A new panel gets this share of the whole. */
const NEWCOMER = 0.28;

/** @param {Tree} tree @returns {string[]} names in reading order */
export const panelsOf = (tree) =>
  typeof tree === "string" ? [tree] : tree.parts.flatMap(panelsOf);

/** @param {Tree} tree @returns {Map<string, Box>} */
export function boxesOf(tree, box = WHOLE) {
  if (typeof tree === "string") return new Map([[tree, box]]);
  return new Map(tree.parts.flatMap((part, i) => [...boxesOf(part, partOf(tree, box, i, i + 1))]));
}

/** @param {Tree} tree @param {Box} [box] @param {number[]} [path] @returns {Border[]} */
export function bordersOf(tree, box = WHOLE, path = []) {
  if (typeof tree === "string") return [];
  const own = tree.parts.slice(1).map((_, place) => ({
    path,
    place,
    split: tree.split,
    box: partOf(tree, box, place, place + 2),
    share: tree.shares[place] / (tree.shares[place] + tree.shares[place + 1]),
  }));
  const inner = tree.parts.flatMap((part, i) =>
    bordersOf(part, partOf(tree, box, i, i + 1), [...path, i]),
  );
  return [...own, ...inner];
}

/** The box of some neighbouring parts. @param {Split} tree @param {Box} box @returns {Box} */
function partOf({ split, shares }, box, /** @type {number} */ first, /** @type {number} */ end) {
  const sum = shares.reduce((a, b) => a + b, 0);
  const before = shares.slice(0, first).reduce((a, b) => a + b, 0) / sum;
  const share = shares.slice(first, end).reduce((a, b) => a + b, 0) / sum;
  return split === "row"
    ? { ...box, x: box.x + before * box.width, width: share * box.width }
    : { ...box, y: box.y + before * box.height, height: share * box.height };
}

/**
 * Move a border.
 * @param {Tree} tree
 * @param {Pick<Border, "path" | "place">} border
 * @param {number} share that the neighbour before gets of both
 * @returns {Tree}
 */
export function moved(tree, { path, place }, share) {
  if (typeof tree === "string") return tree;
  if (path.length > 0) {
    const [first, ...rest] = path;
    const parts = tree.parts.map((part, i) =>
      i === first ? moved(part, { path: rest, place }, share) : part,
    );
    return { ...tree, parts };
  }
  const both = tree.shares[place] + tree.shares[place + 1];
  const before = both * Math.min(1 - LEAST, Math.max(LEAST, share));
  const shares = [...tree.shares];
  [shares[place], shares[place + 1]] = [before, both - before];
  return { ...tree, shares };
}

/** Exchange two panels. @param {Tree} tree @param {string} a @param {string} b @returns {Tree} */
export function swapped(tree, a, b) {
  if (typeof tree === "string") return tree === a ? b : tree === b ? a : tree;
  return { ...tree, parts: tree.parts.map((part) => swapped(part, a, b)) };
}

/** Leave a panel out. @param {Tree} tree @param {string} name @returns {Tree | null} null if nothing is left */
export function without(tree, name) {
  if (typeof tree === "string") return tree === name ? null : tree;
  const kept = tree.parts.map((part) => without(part, name));
  const parts = kept.filter((part) => part !== null);
  if (parts.length < 2) return parts[0] ?? null;
  return { split: tree.split, shares: tree.shares.filter((_, i) => kept[i] !== null), parts };
}

/** Put a panel at the right of all others. @param {Tree} tree @param {string} name @returns {Tree} */
export function added(tree, name) {
  if (panelsOf(tree).includes(name)) return tree;
  return { split: "row", shares: [1 - NEWCOMER, NEWCOMER], parts: [tree, name] };
}

/**
 * The panel whose box lies next to another's in a direction.
 * @param {Tree} tree @param {string} name
 * @param {"ArrowLeft" | "ArrowRight" | "ArrowUp" | "ArrowDown"} way
 * @returns {string | null}
 */
export function neighbour(tree, name, way) {
  const boxes = boxesOf(tree);
  const own = boxes.get(name);
  if (!own) return null;
  const [dx, dy] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[way];
  const gap = (/** @type {Box} */ { x, y, width, height }) => {
    const across = x + width / 2 - own.x - own.width / 2;
    const down = y + height / 2 - own.y - own.height / 2;
    const along = across * dx + down * dy;
    return along > 1e-6 ? along + 2 * Math.abs(across * dy) + 2 * Math.abs(down * dx) : Infinity;
  };
  const others = [...boxes].filter(([other]) => other !== name);
  const [nearest] = others.sort(([, a], [, b]) => gap(a) - gap(b));
  return nearest && gap(nearest[1]) < Infinity ? nearest[0] : null;
}
