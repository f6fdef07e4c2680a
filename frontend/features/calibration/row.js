// @ts-check
import { t } from "../../page/language.js";
import { make, setText } from "../../page/elements.js";
import { plain } from "../../page/format.js";

/** @typedef {import("../../messages").UnknownMessage} UnknownMessage */

/** @type {Record<string, string>} */
const UNITS = { degree: "°", mm: " mm", ms: " ms", "%": " %" };

/** @type {Record<string, string>} */
const NAMES = {
  camera_roll: t("camera roll"),
  camera_pitch: t("camera pitch"),
  camera_yaw: t("camera yaw"),
  camera_x: t("camera x"),
  camera_y: t("camera y"),
  camera_z: t("camera z"),
  focal_length: t("focal length"),
  picture_delay: t("picture delay"),
  left_radius: t("left radius"),
  right_radius: t("right radius"),
  wheel_separation: t("wheel separation"),
};

/** One number of the robot: its value, and how far it is known, as a bar and in figures. */
export class UnknownRow {
  #bar = make("span", { class: "known" });
  #value = make("span", { class: "value" });
  #interval = make("span", { class: "interval" });

  /** @param {UnknownMessage} unknown */
  constructor({ name }) {
    const bar = make("span", { class: "scale", "aria-hidden": "true" }, this.#bar);
    const words = make("span", {}, NAMES[name] ?? name.replaceAll("_", " "));
    this.element = make("li", {}, words, bar, this.#value, this.#interval);
  }

  /** @param {UnknownMessage} unknown */
  show({ value, interval, prior, unit, learnt }) {
    // Two figures of the interval at most, and as many of the value.
    const digits = [9.5, 0.95, 0.095].filter((size) => interval < size).length;
    this.#bar.style.width = `${Math.min(100, (100 * interval) / prior)}%`;
    setText(this.#value, `${value > 0 ? "+" : ""}${plain(value, digits)}`);
    setText(this.#interval, `± ${plain(interval, digits)}${UNITS[unit] ?? ` ${unit}`}`);
    this.element.dataset.learnt = String(learnt);
    this.element.title = learnt ? "" : t("Not known better than in a robot built by hand");
  }
}
