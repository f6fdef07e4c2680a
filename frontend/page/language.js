// @ts-check
/**
 * The page's language. English texts stand in the code; the server has translated the HTML before,
 * and has the other texts in `api/language/CODE.json`.
 */

import { PLACE } from "./place.js";

/** @typedef {import("../messages").LanguageMessage} LanguageMessage */

const COOKIE = "brickpose-language";
/** Where the server's addresses begin: its pages are at several depths below. */
const ROOT = new URL("../../", import.meta.url);
const YEAR_S = 365 * 24 * 3600;

/** Code of the language, as `de`. */
export const language = document.documentElement.lang || "en";

/** @type {LanguageMessage} */
const ENGLISH = { language: "en", plural: "n != 1", point: ".", texts: {} };
const catalogue = language === "en" ? ENGLISH : await load(language);
/** English needs none. */
const templates = language === "en" ? null : new (await import("./templates.js")).Templates(catalogue);
const rule = pluralRule(catalogue.plural);

/** Between a number's whole part and its decimals. */
export const point = catalogue.point;

/**
 * A text in the page's language, with `{names}` replaced by values.
 * @param {string} text in English, written out where it is used, so that it can be found
 * @param {Record<string, string | number>} [values]
 */
export function t(text, values = {}) {
  return filled(catalogue.texts[text]?.[0] ?? text, values);
}

/**
 * The form of a text that fits a count, which is `{count}` in it.
 * @param {string} one @param {string} many in English
 * @param {number} count
 * @param {Record<string, string | number>} [values]
 */
export function tn(one, many, count, values = {}) {
  const forms = catalogue.texts[one];
  const text = forms ? forms[rule(count)] : count === 1 ? one : many;
  return filled(text, { count, ...values });
}

/** What the program tells in English, as a refusal, in the page's language. @param {string} text */
export function translated(text) {
  return templates?.translated(text) ?? text;
}

/** Let the user choose among the languages that there are. @param {HTMLSelectElement} list */
export function offerLanguages(list) {
  for (const code of (document.documentElement.dataset.languages ?? "en").split(" ")) {
    const name = new Intl.DisplayNames([code], { type: "language" }).of(code) ?? code;
    list.add(new Option(name, code, false, code === language));
  }
  list.onchange = () => choose(list.value);
}

/** Keep a language in this browser, and show the page in it. @param {string} code */
function choose(code) {
  document.cookie = `${COOKIE}=${code}; Max-Age=${YEAR_S}; Path=${ROOT.pathname}; SameSite=Strict`;
  location.reload();
}

/** @param {string} text @param {Record<string, string | number>} values */
function filled(text, values) {
  return text.replaceAll(PLACE, (whole, name) => String(values[name] ?? whole));
}

/** @param {string} code @returns {Promise<LanguageMessage>} English if it cannot be had */
async function load(code) {
  const answer = await fetch(new URL(`api/language/${code}.json`, ROOT)).catch(() => null);
  return answer?.ok ? answer.json() : ENGLISH;
}

/** @param {string} expression as gettext has it, in C, which is JavaScript but for its result */
function pluralRule(expression) {
  if (!/^[n\d\s()?:%=!<>&|]+$/.test(expression)) throw new Error(`no plural rule: ${expression}`);
  const value = new Function("n", `return Number(${expression})`);
  return /** @type {(count: number) => number} */ (value);
}
