// @ts-check
import { ParameterRow } from "../filter/row.js";
import { find, findButton, make, setText } from "../page/elements.js";
import { typed } from "../page/format.js";
import { t, tn } from "../page/language.js";
import { getJson } from "../wire/http.js";

/** @typedef {import("../messages").Command} Command */
/** @typedef {import("../messages").FaultsMessage} FaultsMessage */
/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../messages").RobotMessage} RobotMessage */
/** @typedef {import("../filter/row.js").Value} Value */

/** Shortest interval between changes that are sent while a slider moves [ms]. */
const SETTLE_MS = 200;

/** Plain names of the faults. */
const names = () =>
  /** @type {Record<string, string>} */ ({
    slip_sd: t("Wheels slip"),
    wheel_radius_sd: t("Wheels differ"),
    track_sd: t("Track differs"),
    camera_angle_sd: t("Camera askew"),
    camera_position_sd: t("Camera displaced"),
    focal_length_sd: t("Lens differs"),
    noise: t("Noise"),
    light: t("Light"),
    uneven_light: t("Uneven light"),
    glare: t("Glare"),
    clutter: t("Clutter"),
    floor_scale: t("Floor's size"),
    exposure: t("Exposure time"),
    blur: t("Blur"),
    stamp_error: t("Pictures late"),
    frame_rate: t("Pictures a second"),
    lost_share: t("Pictures lost"),
    lost_burst: t("Bursts of loss"),
    gap: t("Camera pauses"),
  });

/** Sliders for what is wrong with a simulated robot and its camera. */
export class Faults {
  #box = find("faults", HTMLElement);
  #list = find("faults-list", HTMLElement);
  #count = find("stat-faults", HTMLElement);
  #condition = find("faults-condition", HTMLSelectElement);
  #forces = find("faults-forces", HTMLElement);
  #engine = find("faults-engine", HTMLElement);
  #names = names();
  /** @type {Map<string, ParameterRow>} */
  #rows = new Map();
  /** @type {FaultsMessage["conditions"]} */
  #conditions = {};
  /** @type {Record<string, Value>} */
  #wanted = {};
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #timer;
  #shown = "";
  #offered = false;

  /** @param {(command: Command) => Promise<boolean>} order */
  constructor(order) {
    this.order = order;
    findButton("faults-clear").onclick = () => this.#set({});
    this.#condition.onchange = () => this.#set(this.#conditions[this.#condition.value] ?? {});
  }

  /** Read what can be wrong. */
  async read() {
    if (!this.#offered) return;
    /** @type {FaultsMessage} */
    const { faults, conditions } = await getJson("api/faults");
    this.#box.hidden = faults.length === 0;
    this.#conditions = conditions;
    this.#rows.clear();
    for (const fault of faults) {
      const want = (/** @type {string} */ name, /** @type {Value} */ value) => this.#want(name, value);
      this.#rows.set(fault.name, new ParameterRow(fault, this.#names[fault.name] ?? "", want));
    }
    this.#list.replaceChildren(...[...this.#rows.values()].map((row) => row.element));
    const options = Object.keys(conditions).map((name) => make("option", { value: name }, name));
    this.#condition.replaceChildren(make("option", { value: "" }, t("condition")), ...options);
  }

  /** Offer an engine to a robot without forces, if none is installed. @param {FieldMessage} field */
  setField({ engine_missing, features }) {
    this.#engine.hidden = !engine_missing;
    this.#offered = features.includes("faults");
  }

  /** Show what is wrong now; another page may have changed it. @param {RobotMessage} robot */
  follow({ faults: wrong, engine }) {
    this.#forces.hidden = engine !== null;
    const count = Object.keys(wrong).length;
    const words = Object.entries(wrong).map(([name, value]) => `${this.#names[name] ?? name} ${typeof value === "number" ? typed(value) : value}`);
    const text = words.join(", ");
    if (text === this.#shown) return;
    this.#shown = text;
    this.#count.hidden = count === 0;
    this.#count.title = text;
    setText(this.#count, tn("{count} fault", "{count} faults", count));
    for (const [name, row] of this.#rows) {
      if (!row.busy) row.accept(wrong[name] ?? row.parameter.default);
    }
  }

  /** @param {string} name @param {Value} value */
  #want(name, value) {
    this.#wanted[name] = value;
    this.#timer ??= setTimeout(() => this.#send(), SETTLE_MS);
  }

  /** Set the faults of a condition; all others are mended. @param {Record<string, Value>} values */
  #set(values) {
    for (const [name, { parameter }] of this.#rows) {
      const value = values[name] ?? parameter.default;
      if (value !== parameter.value) this.#want(name, value);
    }
  }

  async #send() {
    this.#timer = undefined;
    const values = /** @type {Record<string, number | string>} */ (this.#wanted);
    this.#wanted = {};
    const taken = await this.order({ type: "set_faults", values });
    for (const [name, value] of Object.entries(values)) {
      const row = this.#rows.get(name);
      row?.accept(taken ? value : row.parameter.value);
    }
  }
}
