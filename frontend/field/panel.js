// @ts-check
import { find, findButton, findInput, make, setText } from "../page/elements.js";
import { t } from "../page/language.js";
import { offer, takeFiles } from "../page/dropped.js";
import { Popover } from "../page/popover.js";
import { getJson } from "../wire/http.js";
import { Faults } from "./faults.js";

/** @typedef {import("../messages").Command} Command */
/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../messages").FieldsMessage} FieldsMessage */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../page/toasts.js").Toasts} Toasts */

/** Endings of files that the feature keeps as fields. */
const MAPS = [".svg", ".yaml", ".yml", ".pgm", ".ppm", ".png", ".bmp"];

/** Which field the robot is on, and what is wrong with a simulated robot. */
export class FieldPanel {
  #name = findInput("field-name");
  #list = find("field-names", HTMLElement);
  #load = findButton("field-load");
  #file = findInput("field-file");
  #pictures = find("field-pictures", HTMLElement);
  /** @type {Promise<import("../features/field_editor/gallery.js").Gallery> | undefined} */
  #made;
  #map = "";

  /** @param {(command: Command) => Promise<boolean>} order @param {Toasts} toasts */
  constructor(order, toasts) {
    this.order = order;
    this.toasts = toasts;
    this.faults = new Faults(order);
    this.popover = new Popover("field", undefined, () => this.#read());
    find("field-form", HTMLFormElement).addEventListener("submit", (event) => {
      event.preventDefault();
      this.use(this.#name.value.trim());
    });
    const words = () => t("drawings (.svg), ROS maps (.yaml with its picture)");
    takeFiles(MAPS, words, async (files) => (await this.#gallery())?.keep(files));
    this.#file.onchange = () => {
      offer([...(this.#file.files ?? [])], toasts);
      this.#file.value = "";
    };
  }

  /** @param {TelemetryMessage} telemetry */
  follow({ map, robot, replay }) {
    if (map !== this.#map) this.#changed(map);
    this.faults.follow(robot);
    this.#load.disabled = replay !== null && replay !== undefined;
  }

  /** @param {FieldMessage} field */
  setField(field) {
    this.faults.setField(field);
    // The server has begun anew, with what it knows of fields.
    if (this.popover.shown) this.#read();
  }

  /** @param {string} map */
  #changed(map) {
    this.#map = map;
    if (document.activeElement !== this.#name) this.#name.value = map;
    this.#made?.then((gallery) => gallery.mark(map));
  }

  /** Pictures to choose by, and files of one's own, made when they are first asked for. */
  async #gallery() {
    if (this.#pictures.hasAttribute("data-absent")) return null;
    this.#made ??= import("../features/field_editor/gallery.js").then(
      ({ Gallery }) => new Gallery(this.#pictures, (name) => this.use(name), this.toasts),
    );
    return this.#made;
  }

  async #readFaults() {
    try {
      await this.faults.read();
    } catch (error) {
      this.toasts.fail(error);
    }
  }

  async #read() {
    this.#readFaults();
    try {
      /** @type {FieldsMessage} */
      const { names } = await getJson("api/fields");
      const options = names.map((value) => make("option", { value }));
      this.#list.replaceChildren(...options);
      await (await this.#gallery())?.read(this.#map);
    } catch (error) {
      this.toasts.fail(error);
    }
  }

  /** Put the robot onto a field. @param {string} name @returns {Promise<void>} */
  async use(name) {
    setText(this.#load, t("Loading"));
    this.#load.disabled = true;
    if (await this.order({ type: "use_field", name })) {
      this.toasts.show(t("{name} is loaded: the page connects again.", { name }), "note");
    }
    setText(this.#load, t("Load"));
    this.#load.disabled = false;
  }
}
