// @ts-check
import { make } from "../../page/elements.js";
import { minutes, plain } from "../../page/format.js";
import { language, t } from "../../page/language.js";

/** @typedef {import("../../messages").RecordingEntry} RecordingEntry */
/**
 * @typedef {object} Acts
 * @property {(name: string) => void} open
 * @property {(name: string, change: {name?: string, notes?: string}) => void} change
 * @property {(name: string) => void} remove
 */

/** A second press within this time [ms] deletes. */
const SURE_MS = 4000;
const DATE = new Intl.DateTimeFormat(language, { dateStyle: "medium", timeStyle: "short" });

/** One recording of the list: what it is, and what can be done with it. @param {RecordingEntry} entry @param {Acts} acts */
export function recordingRow(entry, acts) {
  const address = `api/recordings/${encodeURIComponent(entry.name)}`;
  const picture = make("img", { src: `${address}/picture?${entry.changed}`, alt: "", loading: "lazy" });
  picture.onerror = () => (picture.style.visibility = "hidden");
  const name = field(entry.name, t("Name"), (text) => acts.change(entry.name, { name: text }));
  const notes = field(entry.notes, t("Notes"), (text) => acts.change(entry.name, { notes: text }));
  notes.placeholder = t("Notes");
  const open = make("button", { type: "button", class: "primary" }, t("open"));
  open.onclick = () => acts.open(entry.name);
  const file = make("a", { class: "button", href: address, download: "" }, t("download"));
  const tools = make("div", { class: "tools" }, open, file, deleteButton(entry, acts));
  const about = make("p", { class: "quiet" }, facts(entry));
  return make("li", {}, picture, make("div", {}, name, about, notes, tools));
}

/** @param {RecordingEntry} entry */
function facts({ changed, duration_s, size_bytes, unfinished }) {
  const length = duration_s === null ? t("length unknown") : minutes(duration_s);
  const size = `${plain(size_bytes / 1e6, 1)} MB`;
  const words = [DATE.format(changed * 1000), length, size];
  if (unfinished) words.push(t("not finished"));
  return words.join(", ");
}

/** @param {string} value @param {string} label @param {(text: string) => void} changed */
function field(value, label, changed) {
  const input = /** @type {HTMLInputElement} */ (
    make("input", { type: "text", "aria-label": label, autocomplete: "off", spellcheck: "false" })
  );
  input.value = value;
  input.onchange = () => changed(input.value.trim());
  return input;
}

/** The first press asks, the second one deletes. @param {RecordingEntry} entry @param {Acts} acts */
function deleteButton({ name }, acts) {
  const button = make("button", { type: "button", "aria-label": t("Delete {name}", { name }) }, t("delete"));
  let sure = false;
  button.onclick = () => {
    if (sure) return acts.remove(name);
    sure = true;
    button.textContent = t("really delete?");
    setTimeout(() => {
      sure = false;
      button.textContent = t("delete");
    }, SURE_MS);
  };
  return button;
}
