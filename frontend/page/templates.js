// @ts-check
/** Translates finished texts, as `app/languages/templates.py` does: the same steps, the same names. */

import { PLACE } from "./place.js";

/** @typedef {import("../messages").LanguageMessage} LanguageMessage */
/**
 * @typedef {object} Template
 * @property {RegExp} pattern
 * @property {string} longest of its fixed parts: quickly tells most texts apart
 * @property {number} certainty how many characters of it are fixed
 * @property {string} translation
 */

const NUMBER = /^-?\d+\.\d+(?:e[+-]?\d+)?$/;
/** Numbers in a row; maybe more of them are left out. */
const ROW = /^(?:-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?:, |$)){2,}(?:\.\.\.)?$/;
/** What joins texts that are made apart. */
const BETWEEN = ["; ", ": ", ". ", ", "];
/** So many texts in each other are looked for: an error quotes an error. */
const DEEPEST = 6;
/** Letters of a text that begins with a value and could be found in nearly any sentence. */
const LOOSE = 2;
const FEW_WORDS = "(?:\\S+(?: \\S+){0,2})?";
/** Texts with numbers in them, as of alerts, are ever new ones. */
const MOST_KEPT = 500;

/** All texts of a language, ready to be found again in finished ones. */
export class Templates {
  /** @type {Map<string, string>} */
  #known = new Map();
  /** @type {Template[]} the most certain first; made when one is asked for */
  #templates = [];

  /** @param {LanguageMessage} catalogue */
  constructor({ texts, point }) {
    this.texts = texts;
    this.point = point;
  }

  /** @param {string} text */
  translated(text) {
    let result = this.#known.get(text);
    if (result === undefined) {
      result = this.#found(text, 0);
      if (this.#known.size >= MOST_KEPT) this.#known.clear();
      this.#known.set(text, result);
    }
    return result;
  }

  /** @param {string} text @param {number} depth @returns {string} */
  #found(text, depth) {
    if (Object.hasOwn(this.texts, text)) return this.texts[text][0];
    if (NUMBER.test(text)) return text.replace(".", this.point);
    if (ROW.test(text)) return this.#row(text);
    if (depth > DEEPEST || !/\p{L}/u.test(text)) return text;
    if (this.#templates.length === 0) this.#templates = templates(this.texts);
    for (const each of this.#templates) {
      const found = text.includes(each.longest) ? each.pattern.exec(text) : null;
      if (found) return this.#filled(each, found, depth);
    }
    return this.#byParts(text, depth);
  }

  /** @param {Template} template @param {RegExpExecArray} found @param {number} depth */
  #filled({ translation }, found, depth) {
    return translation.replaceAll(PLACE, (_, name) =>
      this.#inside(found.groups?.[name] ?? "", depth + 1),
    );
  }

  /** What stands in a place, with the space around it, which is no part of a text. @param {string} value @param {number} depth */
  #inside(value, depth) {
    const bare = value.trim();
    return bare ? value.replace(bare, () => this.#found(bare, depth)) : value;
  }

  /** Numbers with their decimal signs, and apart where a comma is one. @param {string} text */
  #row(text) {
    if (this.point === ".") return text;
    const dots = text.endsWith("...") ? "..." : "";
    const numbers = text.slice(0, text.length - dots.length);
    return numbers.replaceAll(", ", "; ").replaceAll(".", this.point) + dots;
  }

  /** @param {string} text @param {number} depth */
  #byParts(text, depth) {
    for (const mark of BETWEEN) {
      const at = text.indexOf(mark);
      if (at < 0) continue;
      const rest = text.slice(at + mark.length);
      return `${this.#found(text.slice(0, at), depth + 1)}${mark}${this.#found(rest, depth + 1)}`;
    }
    return text;
  }
}

/** @param {Record<string, string[]>} texts @returns {Template[]} */
function templates(texts) {
  return Object.entries(texts)
    .filter(([text]) => text.search(PLACE) >= 0)
    .map(([text, forms]) => template(text, forms[0]))
    .sort((a, b) => b.certainty - a.certainty);
}

/** @param {string} text @param {string} translation @returns {Template} */
function template(text, translation) {
  const pieces = text.split(PLACE);
  const fixed = pieces.filter((_, i) => i % 2 === 0);
  const names = pieces.filter((_, i) => i % 2 === 1);
  const escaped = fixed.map((part) => part.replace(/[.*+?^${}()|[\]\\]/g, "\\$&"));
  const letters = fixed.join("").match(/\p{L}/gu)?.length ?? 0;
  const loose = fixed[0] === "" && 0 < letters && letters <= LOOSE;
  const value = loose ? FEW_WORDS : ".*?";
  return {
    pattern: new RegExp(`^${alternating(escaped, names, value).join("")}$`, "s"),
    longest: fixed.reduce((a, b) => (b.length > a.length ? b : a)),
    certainty: fixed.reduce((sum, part) => sum + part.trim().length, 0),
    translation,
  };
}

/** @param {string[]} fixed @param {string[]} names @param {string} value */
function alternating(fixed, names, value) {
  return fixed.map((part, i) => {
    if (i >= names.length) return part;
    // The same value stands wherever its name does.
    const known = names.indexOf(names[i]) < i;
    return part + (known ? `\\k<${names[i]}>` : `(?<${names[i]}>${value})`);
  });
}
