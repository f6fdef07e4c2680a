// @ts-check
import { t } from "../../page/language.js";
import { sendJson } from "../../wire/http.js";

/** @typedef {import("../../messages").KeptFieldMessage} KeptFieldMessage */

const UMLAUTS = /** @type {Record<string, string>} */ ({ ä: "ae", ö: "oe", ü: "ue", ß: "ss" });

/** A field's name from that of a file or a title. @param {string} title @param {Iterable<string>} taken */
export function freeName(title, taken = []) {
  const plain = title
    .replace(/\.\w+$/, "")
    .replace(/[äöüß]/gi, (letter) => UMLAUTS[letter.toLowerCase()])
    .normalize("NFD")
    .replace(/[\u0300-\u036f]/g, "")
    .replace(/[^A-Za-z0-9_-]+/g, "-")
    .replace(/^[-_]+|-+$/g, "")
    .slice(0, 50);
  const names = new Set(taken);
  const first = plain || "field";
  for (let number = 1; ; number++) {
    const name = number === 1 ? first : `${first}-${number}`;
    if (!names.has(name)) return name;
  }
}

/**
 * Keep a field among the user's: a drawing, or a ROS map's YAML with its picture.
 * @param {string} name @param {Blob} content @param {{yaml?: number, replace?: boolean}} [how] bytes of the YAML
 * @returns {Promise<KeptFieldMessage>}
 */
export async function keepField(name, content, { yaml = 0, replace = false } = {}) {
  const query = `yaml_bytes=${yaml}&replace=${replace}`;
  return sendJson(`api/drawings/${encodeURIComponent(name)}?${query}`, "PUT", content);
}

/** Which of dropped files belong together. @param {File[]} files @returns {{name: string, parts: File[]}[]} */
export function fieldsOf(files) {
  const is = (/** @type {File} */ file, /** @type {RegExp} */ ending) => ending.test(file.name.toLowerCase());
  const drawings = files.filter((file) => is(file, /\.svg$/));
  const maps = files.filter((file) => is(file, /\.ya?ml$/));
  const pictures = files.filter((file) => is(file, /\.(pgm|ppm|png|bmp)$/));
  const stem = (/** @type {File} */ file) => file.name.replace(/\.\w+$/, "");
  const found = drawings.map((file) => ({ name: file.name, parts: [file] }));
  for (const map of maps) {
    const picture = pictures.find((one) => stem(one) === stem(map)) ?? (maps.length === 1 ? pictures[0] : undefined);
    if (!picture) throw new Error(t("{name} is a map without its picture. Choose or drop both files together: the YAML, and the PGM, PNG or BMP that it names.", { name: map.name }));
    pictures.splice(pictures.indexOf(picture), 1);
    found.push({ name: map.name, parts: [map, picture] });
  }
  if (pictures.length > 0) throw new Error(t("{name} is a picture. Valid are a ROS map's YAML together with its picture, or a drawing (.svg).", { name: pictures[0].name }));
  return found;
}
