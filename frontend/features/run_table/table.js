// @ts-check
import { readAs } from "../../filter/units.js";
import { find, findButton, make, setText } from "../../page/elements.js";
import { brief, millimetres, plain } from "../../page/format.js";
import { t, translated } from "../../page/language.js";
import { Popover } from "../../page/popover.js";
import { getJson, send } from "../../wire/http.js";

/** @typedef {import("../../messages").RunMessage} RunMessage */
/** @typedef {import("../../messages").RunsMessage} RunsMessage */
/** @typedef {import("../../page/toasts.js").Toasts} Toasts */

/** The present run's numbers change as it goes on [ms]. */
const AGAIN_MS = 1000;

/** The table of runs beside the plot: what each comes to, and how it differs from another one. */
export class RunsTable {
  #popover = new Popover("runs", undefined, () => this.#load());
  #body = find("runs-body", HTMLElement);
  #note = find("runs-note", HTMLElement);
  #csv = find("runs-csv", HTMLAnchorElement);
  #window = findButton("runs-window");
  /** Number of the run that all are compared with; null is the newest. @type {number | null} */
  #against = null;
  #drawn = "";

  /** @param {Toasts} toasts @param {() => number} span how much of the run the plot shows [s]; 0 is all */
  constructor(toasts, span) {
    this.toasts = toasts;
    this.span = span;
    this.#window.onclick = () => {
      this.#window.setAttribute("aria-pressed", String(!this.#windowed));
      this.#load();
    };
    setInterval(() => this.#load(), AGAIN_MS);
  }

  get #windowed() {
    return this.#window.getAttribute("aria-pressed") === "true";
  }

  get #query() {
    const query = new URLSearchParams();
    const last = this.#windowed ? this.span() : 0;
    if (last > 0) query.set("last", String(last));
    if (this.#against !== null) query.set("against", String(this.#against));
    return String(query);
  }

  async #load() {
    if (!this.#popover.shown || document.hidden) return;
    try {
      const news = /** @type {RunsMessage} */ (await getJson(`api/runs?${this.#query}`));
      this.#csv.href = `api/runs.csv?${this.#query}`;
      const text = JSON.stringify(news);
      if (text !== this.#drawn) this.#write(news);
      this.#drawn = text;
    } catch {
      // The banner says that there is no connection; the next answer comes by itself.
    }
  }

  /** @param {RunsMessage} news */
  #write({ runs, against }) {
    const focused = document.activeElement?.getAttribute("data-run");
    const moved = new Set(runs.map(({ field }) => field)).size > 1;
    this.#body.replaceChildren(...runs.map((run) => this.#row(run, against, moved)));
    const again = focused && this.#body.querySelector(`[data-run="${focused}"]`);
    if (again instanceof HTMLElement) again.focus();
    const empty = t("Drive: a run begins with each change of the filter, and its numbers come here.");
    setText(this.#note, runs.length === 0 ? empty : runs.length > 1 ? difference(runs, against) : "");
  }

  /** @param {RunMessage} run @param {number | null} against @param {boolean} moved whether runs are on several fields */
  #row(run, against, moved) {
    const { number } = run;
    const chosen = number === against;
    const compare = /** @type {HTMLInputElement} */ (make("input", {
      type: "radio",
      name: "runs-against",
      "data-run": `against ${number}`,
      "aria-label": t("Compare all with run {number}", { number }),
    }));
    compare.checked = chosen;
    compare.onchange = () => {
      this.#against = number;
      this.#load();
    };
    const keeper = make("button", { type: "button", "data-run": `keep ${number}`, "aria-pressed": String(run.kept), "aria-label": t("Keep run {number}", { number }) }, t("keep"));
    keeper.onclick = () => this.#ask(`api/runs/${number}/keep?kept=${!run.kept}`, "POST");
    const gone = make("button", { type: "button", "data-run": `forget ${number}`, "aria-label": t("Forget run {number}", { number }) }, "×");
    gone.onclick = () => this.#ask(`api/runs/${number}`, "DELETE");
    const cells = [
      size(run.rmse),
      size(run.median),
      size(run.worst),
      share(run.lost),
      share(run.misleading),
      run.time_to_right === null ? "–" : `${plain(run.time_to_right, 1)} s`,
      apart(run, chosen),
    ];
    const name = make("th", { scope: "row" }, make("label", {}, compare, ` ${words(run, moved)}`));
    name.title = t("{pictures} pictures in {seconds} s on {field}", { pictures: run.pictures, seconds: plain(run.seconds, 0), field: run.field });
    const row = make("tr", {}, name, ...cells.map((cell) => make("td", {}, cell)), make("td", {}, keeper, gone));
    row.dataset.now = String(run.present);
    return row;
  }

  /** @param {string} address @param {"POST" | "DELETE"} method */
  async #ask(address, method) {
    await send(address, method).catch((error) => this.toasts.fail(error));
    this.#load();
  }
}

/** What a run is, where, and with which parameters. @param {RunMessage} run @param {boolean} moved */
function words({ number, field, file, recorded, present, parameters, standard, units }, moved) {
  const changes = Object.entries(parameters).map(([name, value]) => {
    const { unit, factor } = readAs(units[name] ?? "");
    const said = { name, value: told(value, factor), standard: `${told(standard[name], factor)} ${unit}`.trim() };
    return t("{name} {value} instead of {standard}", said);
  });
  const settings = changes.length > 0 ? changes.join(", ") : t("parameters as at the start");
  const values = { number, file };
  if (recorded) return t("{number}: as recorded in {file}", values);
  if (file) return `${t("{number}: {file} again", values)}; ${settings}`;
  const when = present ? t("{number}: now", values) : t("{number}: before", values);
  return `${when}${moved ? t(", on {field}", { field }) : ""}; ${settings}`;
}

/** Say the first difference on the same field in words. @param {RunMessage[]} runs @param {number | null} against */
function difference(runs, against) {
  const chosen = runs.find(({ number }) => number === against);
  const alike = runs.filter(({ field }) => field === chosen?.field);
  if (alike.length === 1) return t("The other runs are on other fields: their errors say little of this one.");
  const run = alike.find(({ difference: found }) => found?.low !== null && found !== null);
  const found = run?.difference;
  if (!run || !found || found.low === null || found.high === null) return t("A difference has an interval once both runs have driven for ten seconds.");
  const values = { run: run.number, other: against ?? 0, size: millimetres(Math.abs(found.rmse), 2) };
  if (found.low <= 0 && found.high >= 0) return t("Between run {run} and run {other} no difference is proven.", values);
  return found.rmse > 0 ? t("Run {run} is farther off than run {other}, by {size}.", values) : t("Run {run} is nearer than run {other}, by {size}.", values);
}

/** @param {RunMessage} run @param {boolean} chosen */
function apart({ difference: found }, chosen) {
  if (chosen) return t("compared with");
  if (!found) return "–";
  const sign = (/** @type {number} */ value) => `${value > 0 ? "+" : ""}${plain(value * 1000, 2)}`;
  if (found.low === null || found.high === null) return `${sign(found.rmse)} mm`;
  return t("{size} mm ({low} to {high})", { size: sign(found.rmse), low: sign(found.low), high: sign(found.high) });
}

/** @param {number | null} value [m] */
const size = (value) => (value === null ? "–" : millimetres(value, 2));
/** @param {number | null} value */
const share = (value) => (value === null ? "–" : `${plain(value * 100, 1)} %`);
/** @param {number | string | boolean} value @param {number} factor to the unit that people read */
const told = (value, factor) => (typeof value === "number" ? brief(value * factor) : translated(String(value)));
