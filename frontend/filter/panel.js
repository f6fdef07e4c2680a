// @ts-check
import { t, tn } from "../page/language.js";
import { find, findButton, make, setText } from "../page/elements.js";
import { plain } from "../page/format.js";
import { sentence } from "../page/toasts.js";
import { getJson } from "../wire/http.js";
import { ParameterRow } from "./row.js";

/** @typedef {import("../messages").Command} Command */
/** @typedef {import("../messages").ParameterMessage} ParameterMessage */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../wire/connection.js").Connection} Connection */
/** @typedef {import("./row.js").Value} Value */

/**
 * Parameters that students change first, with plain names; the rest follows in groups.
 * @type {Record<string, string>}
 */
const FIRST = {
  filter: t("Filter"),
  sigma_hit: t("Hit spread"),
  z_rand: t("False share"),
  alpha3: t("Motion noise"),
  max_particles: t("Particles"),
  laser_model_type: t("Sensor model"),
  robot_model_type: t("Motion model"),
};
/** @type {Record<string, string>} */
const GROUPS = {
  motion: t("how odometry errs"),
  sensor: t("how the scan errs"),
  filter: t("how the belief is kept"),
  hypotheses: t("how places are found, weighed and given up"),
};
/** @type {Record<string, string>} */
const NAMES = {
  motion: t("Motion"),
  sensor: t("Sensor"),
  filter: t("Filter"),
  hypotheses: t("Hypotheses"),
};
/** Shortest interval between changes that are sent while a slider moves [ms]. */
const SETTLE_MS = 120;
/** Interval between reads of all parameters, as somebody else may change them, too [ms]. */
const LOOK_AGAIN_MS = 5000;

/** The filter's state and its parameters, live. */
export class FilterPanel {
  #list = find("parameters", HTMLElement);
  #hint = find("filter-hint", HTMLElement);
  #pause = findButton("pause");
  #step = findButton("step");
  #paused = false;
  /** @type {Map<string, ParameterRow>} */
  #rows = new Map();
  /** @type {Map<string, Value>} */
  #wanted = new Map();
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #timer;

  /**
   * @param {Connection} connection
   * @param {(command: Command) => Promise<boolean>} order
   * @param {() => void} scatter
   */
  constructor(connection, order, scatter) {
    this.connection = connection;
    this.#pause.onclick = () => order({ type: this.#paused ? "resume" : "pause" });
    this.#step.onclick = () => order({ type: "update" });
    findButton("filter-scatter").onclick = scatter;
    findButton("reset").onclick = async () => {
      if (await order({ type: "reset" })) this.load();
    };
    const explain = findButton("explain");
    explain.onclick = () => {
      const shown = this.#list.dataset.explain !== "true";
      this.#list.dataset.explain = String(shown);
      explain.setAttribute("aria-pressed", String(shown));
    };
    setInterval(() => this.#lookAgain(), LOOK_AGAIN_MS);
  }

  /** @param {TelemetryMessage} telemetry */
  describe({ particles, filter }) {
    const words = contents(filter.kind, particles);
    const state = filter.hand ? t("by hand, {words}", { words }) : filter.paused ? t("paused, {words}", { words }) : words;
    setText(this.#hint, state);
    this.#pause.disabled = this.#step.disabled = Boolean(filter.hand);
    this.#paused = filter.paused;
    setText(this.#pause, filter.paused ? t("resume") : t("pause"));
  }

  /** Read the parameters as they are on the robot. */
  async load() {
    /** @type {ParameterMessage[]} */
    let parameters;
    try {
      parameters = await getJson("api/parameters");
    } catch (error) {
      if (this.#rows.size === 0) setText(this.#list, t("No parameters: {error}", { error: sentence(error) }));
      return;
    }
    const same =
      parameters.length === this.#rows.size &&
      parameters.every((one) => this.#rows.get(one.name)?.offers(one));
    if (!same) this.#build(parameters);
    for (const { name, value, used } of parameters) {
      const row = this.#rows.get(name);
      if (row && !row.busy && row.parameter.value !== value) row.accept(value);
      row?.use(used ?? true);
    }
  }

  #lookAgain() {
    const seen = !document.hidden && this.#list.checkVisibility();
    if (seen && this.connection.state === "open") this.load();
  }

  /** @param {ParameterMessage[]} parameters */
  #build(parameters) {
    this.#rows.clear();
    const first = Object.keys(FIRST).flatMap((name) =>
      parameters.filter((one) => one.name === name),
    );
    const rest = parameters.filter((one) => !first.includes(one));
    const open = new Set(
      [...this.#list.querySelectorAll("details[open]")].map((details) => details.id),
    );
    const most = make("section", {}, make("h3", {}, t("Most used")), ...this.#rowsOf(first));
    const groups = [...new Set(rest.map(({ group }) => group))].map((group) => {
      const id = `group-${group}`;
      const mine = rest.filter((one) => one.group === group);
      const details = make("details", { id }, heading(group, mine), ...this.#rowsOf(mine));
      details.toggleAttribute("open", open.has(id));
      return details;
    });
    this.#list.replaceChildren(most, ...groups);
  }

  /** @param {ParameterMessage[]} parameters */
  #rowsOf(parameters) {
    return parameters.map((parameter) => {
      const change = (/** @type {string} */ name, /** @type {Value} */ value) =>
        this.#want(name, value);
      const row = new ParameterRow(parameter, FIRST[parameter.name] ?? "", change);
      this.#rows.set(parameter.name, row);
      return row.element;
    });
  }

  /**
   * Collect changes, and send them together after a short time.
   * @param {string} name
   * @param {Value} value
   */
  #want(name, value) {
    this.#wanted.set(name, value);
    this.#timer ??= setTimeout(() => this.#send(), SETTLE_MS);
  }

  async #send() {
    this.#timer = undefined;
    const values = Object.fromEntries(this.#wanted);
    this.#wanted.clear();
    try {
      await this.connection.send({ type: "set_parameters", values });
    } catch (error) {
      for (const name of Object.keys(values)) this.#rows.get(name)?.refuse(sentence(error));
      return;
    }
    for (const [name, value] of Object.entries(values)) {
      if (!this.#wanted.has(name)) this.#rows.get(name)?.accept(value);
    }
    // A choice decides which of the others are used.
    if (Object.values(values).some((value) => typeof value !== "number")) this.load();
  }
}

/**
 * What a filter's belief consists of: not all have particles.
 * @param {string} kind
 * @param {TelemetryMessage["particles"]} particles
 */
function contents(kind, { count, effective }) {
  if (kind === "kalman") return t("one normal distribution, no particles");
  if (kind === "grid") return t("{count} cells of the pose grid", { count });
  return tn("{count} particle, {effective} effective", "{count} particles, {effective} effective", count, {
    effective: plain(effective),
  });
}

/**
 * Make the heading of a group: its name, what it is about, and the number of its parameters.
 * @param {string} group
 * @param {ParameterMessage[]} parameters
 */
function heading(group, parameters) {
  const name = NAMES[group] ?? group;
  const about = make("span", { class: "quiet" }, GROUPS[group] ?? "");
  return make(
    "summary",
    {},
    make("h3", {}, name),
    " ",
    about,
    make("span", { class: "count" }, String(parameters.length)),
  );
}
