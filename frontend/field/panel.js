// @ts-check
import { find, findButton, findInput, make, setText } from "../page/elements.js";
import { t } from "../page/language.js";
import { Popover } from "../page/popover.js";
import { getJson } from "../wire/http.js";
import { Faults } from "./faults.js";

/** @typedef {import("../messages").Command} Command */
/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../messages").FieldsMessage} FieldsMessage */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../page/toasts.js").Toasts} Toasts */

/** Which field the robot is on, and what is wrong with a simulated robot. */
export class FieldPanel {
  #name = findInput("field-name");
  #list = find("field-names", HTMLElement);
  #load = findButton("field-load");
  #map = "";

  /** @param {(command: Command) => Promise<boolean>} order @param {Toasts} toasts */
  constructor(order, toasts) {
    this.order = order;
    this.toasts = toasts;
    this.faults = new Faults(order);
    this.popover = new Popover("field", undefined, () => this.#read());
    find("field-form", HTMLFormElement).addEventListener("submit", (event) => {
      event.preventDefault();
      this.#use();
    });
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
    this.#readFaults();
  }

  /** @param {string} map */
  #changed(map) {
    this.#map = map;
    if (document.activeElement !== this.#name) this.#name.value = map;
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
    } catch (error) {
      this.toasts.fail(error);
    }
  }

  async #use() {
    const name = this.#name.value.trim();
    setText(this.#load, t("Loading"));
    this.#load.disabled = true;
    if (await this.order({ type: "use_field", name })) {
      this.toasts.show(t("{name} is loaded: the page connects again.", { name }), "note");
    }
    setText(this.#load, t("Load"));
    this.#load.disabled = false;
  }
}
