// @ts-check
import { find, findButton, findInput, make } from "../../page/elements.js";
import { t } from "../../page/language.js";
import { takeFiles } from "../../page/dropped.js";
import { Rows } from "../../page/rows.js";
import { Popover } from "../../page/popover.js";
import { getJson, send } from "../../wire/http.js";
import { recordingRow } from "./row.js";

/** @typedef {import("../../messages").Command} Command */
/** @typedef {import("../../messages").RecordingEntry} RecordingEntry */
/** @typedef {import("../../messages").ReplayMessage} ReplayMessage */
/** @typedef {import("../../page/toasts.js").Toasts} Toasts */

/** Recordings of one name, told apart by a number; more are refused by the name that is taken. */
const MOST_ALIKE = 20;

/** The recordings of this computer: a list to open, describe and delete; files can be dropped. */
export class RecordingsPanel {
  #popover = new Popover("recordings", undefined, () => this.#load());
  #list = find("recordings-items", HTMLElement);
  /** @type {Rows<RecordingEntry>} */
  #rows = new Rows(this.#list, (entry) => recordingRow(entry, this));
  #file = findInput("recordings-file");
  #back = findButton("replay-end");
  #drives = false;
  #replays = false;

  /** @param {(command: Command) => Promise<boolean>} order @param {Toasts} toasts */
  constructor(order, toasts) {
    this.order = order;
    this.toasts = toasts;
    this.#back.onclick = () => order({ type: "close_recording" });
    this.#file.onchange = () => this.#take([...(this.#file.files ?? [])]);
    takeFiles([".mcap"], () => t("recordings (.mcap)"), (files) => this.#openDropped(files));
  }

  /** @param {ReplayMessage | null} replay @param {string} mode what the robot does */
  show(replay, mode) {
    // What has been opened is not hidden by the list, whoever opened it, and however late.
    if (replay && !this.#replays) this.#popover.show(false);
    this.#replays = replay !== null;
    this.#drives = !replay && mode !== "idle";
    this.#back.hidden = !replay?.robot_waits;
  }

  async #load() {
    try {
      const entries = /** @type {RecordingEntry[]} */ (await getJson("api/recordings"));
      const none = t("There are no recordings yet. Press Record, or drop a file onto this page.");
      this.#rows.show(entries);
      if (entries.length === 0) this.#list.append(make("li", { class: "quiet" }, none));
    } catch (error) {
      this.toasts.fail(error);
    }
  }

  /** Go on with a recording in place of the robot. @param {string} name */
  async open(name) {
    this.toasts.show(t("{name} is being opened; then the page connects again.", { name }), "note");
    if (await this.order({ type: "open_recording", name })) this.#popover.show(false);
  }

  /** Keep what is dropped; one file alone is opened at once, unless a drive is worth more. @param {File[]} files */
  async #openDropped(files) {
    const taken = await this.#take(files);
    const [name] = taken;
    if (taken.length !== 1) return;
    const words = t("Open the recording {name}? The robot stops, and its drive ends.", { name });
    if (!this.#drives || confirm(words)) await this.open(name);
  }

  /** @param {string} name @param {{name?: string, notes?: string}} change */
  change(name, change) {
    return this.#ask(name, "PATCH", JSON.stringify(change), change.name !== undefined);
  }

  /** @param {string} name */
  remove(name) {
    return this.#ask(name, "DELETE");
  }

  /** Take files into the recordings of this computer; return the names of those that were taken. @param {File[]} files */
  async #take(files) {
    /** @type {string[]} */
    const taken = [];
    if (files.length === 0) return taken;
    this.#popover.show(true);
    for (const file of files) {
      const name = await this.#keep(file);
      if (name !== null) taken.push(name);
    }
    this.#file.value = "";
    return taken;
  }

  /** Keep a file by its name, or by one like it if another recording has that; null if it was refused. @param {File} file */
  async #keep(file) {
    const plain = file.name.replace(/(_0)?\.mcap$/i, "").replace(/[^\w.-]+/g, "-");
    const known = /** @type {RecordingEntry[]} */ (await getJson("api/recordings")).map((entry) => entry.name);
    let name = plain;
    for (let count = 2; count <= MOST_ALIKE; count += 1) {
      // What is there already, byte for byte, is taken once more, and not kept twice.
      if (await this.#ask(name, "PUT", file, true, known.includes(name))) return name;
      if (!known.includes(name)) return null;
      name = `${plain}-${count}`;
    }
    return null;
  }

  /**
   * @param {string} name @param {string} method @param {BodyInit} [body]
   * @param {boolean} [again] whether the list is another then; rows that stay can be typed in
   * @param {boolean} [quiet] whether somebody else says what went wrong
   * @returns whether it was done
   */
  async #ask(name, method, body, again = true, quiet = false) {
    let done = true;
    try {
      await send(`api/recordings/${encodeURIComponent(name)}`, method, body);
    } catch (error) {
      if (!quiet) this.toasts.fail(error);
      // What was typed and refused does not stand.
      this.#rows.forget();
      done = false;
    }
    if (again) await this.#load();
    return done;
  }
}
