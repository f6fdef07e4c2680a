// @ts-check
import { t, translated } from "./language.js";
import { find, make, setText } from "./elements.js";
import { distance, millimetres, minutes, plain } from "./format.js";
import { modeWords } from "./modes.js";

/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../wire/connection.js").LinkState} LinkState */

const LINKS = { connecting: t("connecting"), lost: t("disconnected"), compiling: t("compiling") };

/** The slim bar: the robot's name and state, and the few numbers that show whether all is well. */
export class TopBar {
  #name = find("robot-name", HTMLElement);
  #state = find("robot-state", HTMLElement);
  #measured = find("robot-measured", HTMLElement);
  #dot = find("robot-dot", HTMLElement);
  #time = find("stat-time", HTMLElement);
  #field = find("stat-field", HTMLElement);
  #battery = find("stat-battery", HTMLElement);
  #error = find("stat-error", HTMLElement);
  #loop = find("stat-loop", HTMLElement);
  #delay = find("stat-delay", HTMLElement);
  #stats = find("stats", HTMLElement);
  /** @type {Map<string, HTMLElement>} */
  #values = new Map();

  constructor() {
    const bar = /** @type {HTMLElement} */ (document.querySelector(".bar"));
    const root = document.documentElement.style;
    // What opens below the bar stands below all of its rows.
    new ResizeObserver(() => root.setProperty("--bar", `${bar.offsetHeight}px`)).observe(bar);
  }

  /** @param {TelemetryMessage} telemetry @param {number | null} delay exposure to pixel [ms] */
  show(telemetry, delay) {
    const { robot, truth, particles } = telemetry;
    // Among places that look alike, the heaviest one is so by chance: no single error is right.
    const estimate = particles.alike < 2 ? telemetry.estimate : null;
    setText(this.#name, translated(robot.name));
    this.#name.title = robot.engine === null ? "" : t("Physics by {engine}", { engine: robot.engine });
    const mode = telemetry.replay ? t("replay") : modeWords(telemetry.mode);
    this.#enter(robot.connected ? mode : t("not ready"), robot.connected);
    setText(this.#field, telemetry.map);
    setText(this.#time, minutes(telemetry.stamp));
    find("battery", HTMLElement).hidden = robot.battery_v === null;
    setText(this.#battery, robot.battery_v === null ? "–" : `${plain(robot.battery_v, 1)} V`);
    setText(this.#error, millimetres(truth && estimate && distance(truth, estimate), 1));
    setText(this.#loop, `${plain(telemetry.loop.step_hz)} Hz`);
    setText(this.#delay, delay === null ? "–" : `${plain(delay)} ms`);
    for (const [name, value] of Object.entries(telemetry.values ?? {})) {
      // What was never known, as of a part that is not in use, takes no place.
      if (value === null && !this.#values.has(name)) continue;
      const digits = Math.min(String(value).split(".")[1]?.length ?? 0, 2);
      const text = typeof value === "number" ? plain(value, digits) : value;
      setText(this.#values.get(name) ?? this.#add(name), text === null ? "–" : String(text));
    }
  }

  /** @param {string} name of a further value; it gets a place of its own */
  #add(name) {
    const value = make("dd");
    const label = translated(name.replaceAll("_", " "));
    const words = make("dt", {}, label.charAt(0).toUpperCase() + label.slice(1));
    this.#stats.append(make("div", {}, words, value));
    this.#values.set(name, value);
    return value;
  }

  /** @param {FieldMessage} field */
  setField(field) {
    this.#measured.hidden = !field.robot_measured;
    const [date] = field.robot_measured.split(",");
    setText(this.#measured, t("calibrated {date}", { date }));
    this.#measured.title = t("Calibrated {measured}", { measured: translated(field.robot_measured) });
  }

  /** @param {LinkState | "compiling"} link is shown while no telemetry comes */
  showLink(link) {
    if (link !== "open") this.#enter(LINKS[link], false);
  }

  /** @param {string} state @param {boolean} well */
  #enter(state, well) {
    setText(this.#state, state);
    this.#dot.dataset.well = String(well);
  }
}
