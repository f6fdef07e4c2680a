// @ts-check
import { t, translated } from "./language.js";
import { HttpError, getJson } from "../wire/http.js";
import { find, findButton, make, setText } from "./elements.js";
import { minutes } from "./format.js";
import { Popover } from "./popover.js";
import { sentence } from "./toasts.js";

/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../messages").HealthMessage} HealthMessage */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../messages").ProblemsMessage} ProblemsMessage */
/** @typedef {import("../wire/connection.js").LinkState} LinkState */

/** A first connection may take this time [ms] before the page shows a message. */
const PATIENCE_MS = 3000;

/** Present problems in a line under the bar, and the record of past ones. */
export class Problems {
  #banner = find("banner", HTMLElement);
  #button = findButton("problems");
  #count = find("problems-count", HTMLElement);
  #popover = new Popover("problems-list", ["problems"], () => this.#load());
  #list = find("problems-items", HTMLElement);
  #known = -1;
  #heard = 0;
  /** Telemetry older than this [ms] does not show the present. */
  #staleAfter = Infinity;
  /**
   * Why there is no news, in the program's own words; null before the page asked for it.
   * @type {string | null}
   */
  #reason = null;
  /** @type {LinkState | "compiling"} */
  #link = "connecting";
  #loads = false;
  /** @type {string[]} */
  #present = [];

  constructor() {
    setInterval(() => this.#say(), 500);
  }

  /** @param {FieldMessage} field */
  setField({ stale_after }) {
    this.#staleAfter = stale_after * 1000;
  }

  /** @param {TelemetryMessage} telemetry */
  show(telemetry) {
    this.#heard = performance.now();
    this.#reason = null;
    this.#present = telemetry.robot.connected
      ? telemetry.problems.map(translated)
      : [t("The robot stands still."), ...telemetry.problems.map(translated)];
    if (telemetry.error_count === this.#known) return;
    this.#known = telemetry.error_count;
    setText(this.#count, String(this.#known));
    this.#button.setAttribute("aria-label", t("Problems: {count}", { count: this.#known }));
    this.#button.dataset.some = String(this.#known > 0);
    if (this.#popover.shown) this.#load();
  }

  /** @param {LinkState | "compiling"} link @param {boolean} loads whether it is lost for what this page wanted */
  showLink(link, loads) {
    this.#link = link;
    this.#loads = loads;
    this.#say();
  }

  /** Whether the page shows an old state, not the present one. */
  get stale() {
    return this.#link !== "open" || performance.now() - this.#heard > this.#staleAfter;
  }

  #say() {
    const lines = this.#sentences();
    setText(this.#banner, lines.join(" ").trim());
    document.body.dataset.stale = String(this.stale);
  }

  /** @returns {string[]} */
  #sentences() {
    if (this.#link === "lost" && this.#loads) return [t("Loading: the page connects again in a few seconds.")];
    if (this.#link === "lost") {
      return [t("The connection is lost; trying again. The robot stops by itself.")];
    }
    if (this.#link === "compiling") return [];
    if (!this.stale) return this.#present;
    if (this.#link === "connecting" && performance.now() < PATIENCE_MS) return [];
    if (this.#reason === null) this.#askWhy();
    return [t("No news from the robot."), translated(this.#reason ?? "")];
  }

  async #askWhy() {
    this.#reason = "";
    try {
      /** @type {HealthMessage} */
      const { status, detail } = await getJson("api/health");
      if (status !== "ok") this.#reason = detail;
    } catch (error) {
      // A failed program answers with the reason.
      this.#reason = error instanceof HttpError ? error.message : "";
    }
  }

  async #load() {
    /** @type {Node[]} */
    let items;
    let fault = "";
    try {
      /** @type {ProblemsMessage} */
      const { problems, trace } = await getJson("api/problems");
      items = together(problems.reverse()).map(({ stamp, message, times }) => {
        const often = times > 1 ? [" ", make("span", { class: "count" }, t("{count} times", { count: times }))] : [];
        return make("li", {}, make("time", {}, minutes(stamp)), ` ${translated(message)}`, ...often);
      });
      fault = trace ?? "";
    } catch (error) {
      items = [make("li", {}, t("The log could not be read: {error}", { error: sentence(error) }))];
    }
    if (fault) items.unshift(traced(fault));
    if (items.length === 0) items = [make("li", { class: "quiet" }, t("Nothing has gone wrong."))];
    this.#list.replaceChildren(...items);
  }
}

/**
 * Problems that repeat are one, with the newest's words and how often: only their numbers differ.
 * @param {{stamp: number, message: string}[]} problems the newest first
 */
function together(problems) {
  /** @type {Map<string, {stamp: number, message: string, times: number}>} */
  const kinds = new Map();
  for (const problem of problems) {
    const kind = problem.message.replace(/\d+([.,]\d+)*/g, "#");
    const known = kinds.get(kind);
    if (known) known.times += 1;
    else kinds.set(kind, { ...problem, times: 1 });
  }
  return [...kinds.values()];
}

/** Where a model of one's own failed: the calls, on demand. @param {string} trace */
function traced(trace) {
  const calls = make("pre", { tabindex: "0" }, trace);
  return make("li", {}, make("details", { class: "trace" }, make("summary", {}, t("Where your model failed")), calls));
}
