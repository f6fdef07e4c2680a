// @ts-check
import { t } from "../page/language.js";
import { panelsOf } from "./tree.js";

/** @typedef {import("./tree.js").Tree} Tree */
/** @typedef {"simple" | "drive" | "understand" | "present"} ReadyName */

/** @type {(shares: number[], ...parts: Tree[]) => Tree} */
const row = (shares, ...parts) => ({ split: "row", shares, parts });
/** @type {(shares: number[], ...parts: Tree[]) => Tree} */
const column = (shares, ...parts) => ({ split: "column", shares, parts });

/** Ready layouts. @type {Record<ReadyName, Tree>} */
export const READY = {
  simple: row([62, 38], "map", column([66, 34], "camera", "drive")),
  drive: row(
    [56, 44],
    column([68, 32], "map", row([42, 58], "drive", "filter")),
    column([57, 43], "camera", row([50, 50], "view", "plots")),
  ),
  understand: row(
    [50, 50],
    column([77, 23], "map", "drive"),
    column([54, 46], row([58, 42], "view", "camera"), row([50, 50], "filter", "plots")),
  ),
  present: row([60, 40], "map", column([46, 54], "camera", "plots")),
};

/** What a window that is not wide begins with. @type {Tree} */
export const COMPACT = column(
  [62, 38],
  row([60, 40], "map", column([50, 50], "camera", "view")),
  row([36, 64], "drive", "filter"),
);

/** A file or link says that it is a layout, and of which kind. */
const KIND = "brickpose-layout-1";
const DEEPEST = 8;
/** Larger shares have no sum. */
const LARGEST = 1e6;

/** @param {Tree} tree @returns {string} */
export const written = (tree) => JSON.stringify({ kind: KIND, tree: rounded(tree) });

/**
 * Read a layout from a file or link.
 * @param {string} text @param {string[]} known names of all panels
 * @returns {Tree} throws an Error that says what is wrong
 */
export function read(text, known) {
  /** @type {unknown} */
  let content;
  try {
    content = JSON.parse(text);
  } catch {
    throw new Error(t("This is no layout: it is not JSON."));
  }
  const { kind, tree } = /** @type {{kind?: unknown, tree?: unknown}} */ (content ?? {});
  if (kind !== KIND) throw new Error(t("This is no layout: its kind is not {kind}.", { kind: KIND }));
  const result = checked(tree, known, 0);
  const names = panelsOf(result);
  const twice = names.find((name, i) => names.indexOf(name) !== i);
  if (twice) throw new Error(t("This layout has the panel {name} twice.", { name: twice }));
  return result;
}

/** @param {unknown} tree @param {string[]} known @param {number} depth @returns {Tree} */
function checked(tree, known, depth) {
  if (typeof tree === "string") {
    if (known.includes(tree)) return tree;
    throw new Error(t("There is no panel {name}; valid are {known}.", { name: tree, known: known.join(", ") }));
  }
  const { split, shares, parts } = /** @type {Record<string, unknown>} */ (tree ?? {});
  const wrong = new Error(t("This layout is damaged: a split needs parts and a share for each."));
  if ((split !== "row" && split !== "column") || depth > DEEPEST) throw wrong;
  if (!Array.isArray(parts) || !Array.isArray(shares) || parts.length < 2) throw wrong;
  const valid = shares.every((share) => Number.isFinite(share) && share > 0 && share <= LARGEST);
  if (!valid || shares.length !== parts.length) throw wrong;
  return { split, shares, parts: parts.map((part) => checked(part, known, depth + 1)) };
}

/** Short numbers, for short links. @param {Tree} tree @returns {Tree} */
function rounded(tree) {
  if (typeof tree === "string") return tree;
  const sum = tree.shares.reduce((a, b) => a + b, 0);
  const shares = tree.shares.map((share) => Math.round((1000 * share) / sum) / 10);
  return { split: tree.split, shares, parts: tree.parts.map(rounded) };
}
