// @ts-check
import { t } from "../../page/language.js";
import { OwnDrive } from "../../drive/own_drive.js";
import { find, findButton, findInput, make, setText } from "../../page/elements.js";
import { millimetres, plain } from "../../page/format.js";
import { Popover } from "../../page/popover.js";
import { sentence } from "../../page/toasts.js";
import { getJson } from "../../wire/http.js";

/** @typedef {import("../../messages").Command} Command */
/** @typedef {import("../../messages").MapDrawingMessage} MapDrawingMessage */
/** @typedef {import("../../messages").MappingMessage} MappingMessage */
/** @typedef {import("../../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../../drive/lease.js").Drive} Drive */
/** @typedef {import("../../wire/connection.js").Connection} Connection */

const HINT = t(
  "Drive along all of the tape, any way you like, and come back to where you began, or let the robot explore: the map of this floor is drawn meanwhile.",
);

/** The map that is drawn by driving: its buttons, how far it is, and how well it fits. */
export class MappingPanel {
  #more = findButton("more");
  /** On a phone, where the drive panel has no header, there is another opener. */
  #popover = new Popover("mapping", ["mapping-open", "mapping-more"], () => this.#more.setAttribute("aria-expanded", "false"));
  #state = find("mapping-state", HTMLElement);
  #remarks = find("mapping-remarks", HTMLElement);
  #strokes = find("mapping-strokes", HTMLElement);
  #save = find("mapping-save", HTMLFormElement);
  #name = findInput("mapping-name");
  #doubted = find("mapping-doubted", HTMLElement);
  #force = findInput("mapping-force");
  #start = findButton("mapping-start");
  #explore = findButton("mapping-explore");
  #finish = findButton("mapping-finish");
  #undo = findButton("mapping-undo");
  #discard = findButton("mapping-discard");
  #file = find("mapping-file", HTMLAnchorElement);
  /** What the page's drawing was loaded for; empty without one. @type {string | null} */
  #loaded = "";
  /** @type {MapDrawingMessage | null} */
  #drawing = null;
  /** Name of the map that the robot is to go on in; empty without one. */
  #awaited = "";
  /** Name of the map that was saved. */
  #saved = "";
  /** Number of the stroke that another one is to be joined to. @type {number | null} */
  #joined = null;
  /** @type {OwnDrive} */
  #explores;

  /**
   * @param {Drive} drive
   * @param {(command: Command) => Promise<boolean>} order sends; tells whether it was accepted
   * @param {Connection} connection
   * @param {(drawing: MapDrawingMessage | null, chosen?: number) => void} draw shows the map, and one of its
   *   strokes; null is none
   */
  constructor(drive, order, connection, draw) {
    this.drive = drive;
    this.order = order;
    this.draw = draw;
    this.#explores = new OwnDrive(drive, order, "explore");
    this.#start.onclick = () => order({ type: "start_map" });
    this.#explore.onclick = () => (this.#explores.mine ? this.#explores.end() : this.#explores.begin());
    this.#finish.onclick = () => {
      this.#explores.end();
      order({ type: "finish_map" });
    };
    this.#undo.onclick = () => this.#drawing && order({ type: "undo_edit", version: this.#drawing.version });
    this.#discard.onclick = () => order({ type: "discard_map" });
    this.#save.onsubmit = (event) => this.#keep(event);
    connection.onState((state) => state !== "open" && (this.#loaded = null));
  }

  /** @param {TelemetryMessage} telemetry */
  follow({ mapping, mode, replay, map: field }) {
    const map = mapping ?? null;
    this.#explores.follow(mode === "explore");
    // The answer to the command may be lost where the program changes its map.
    if (this.#awaited !== "" && field === this.#awaited) this.#arrive();
    const key = map && map.version > 0 ? `${map.state} ${map.version}` : "";
    if (key !== this.#loaded) this.#load(key);
    if (!this.#popover.shown) return;
    const state = map?.state ?? "";
    this.#start.hidden = state === "draw" || state === "finish" || state === "done";
    this.#start.disabled = !this.drive.possible || replay !== null;
    this.#explore.hidden = state === "finish" || state === "done";
    this.#explore.disabled = !this.drive.possible || this.drive.other !== null || replay !== null;
    setText(this.#explore, this.#explores.mine ? t("Stop exploring") : t("Explore"));
    this.#finish.hidden = state !== "draw";
    this.#finish.disabled = (map?.version ?? 0) === 0;
    this.#undo.hidden = state !== "done" || !this.#drawing?.changes;
    this.#discard.hidden = map === null;
    this.#save.hidden = this.#file.hidden = state !== "done";
    this.#remarks.hidden = this.#strokes.hidden = state !== "done";
    this.#doubted.hidden = state !== "done" || !this.#drawing?.contradictory;
    setText(this.#state, this.#words(map, replay !== null, mode === "explore"));
  }

  /** @param {MappingMessage | null} map @param {boolean} replayed @param {boolean} explores */
  #words(map, replayed, explores) {
    if (replayed) return t("This is a recording; the command brickpose map draws its floor.");
    if (map?.state === "draw") {
      const seconds = t("Drawn from {seconds} s of driving.", { seconds: plain(map.seconds) });
      if (map.message) return `${seconds} ${sentence(map.message)}`;
      return `${seconds} ${explores ? t("The robot drives to what the map lacks, and says when nothing is left.") : HINT}`;
    }
    if (map?.state === "finish") return t("All of the drive is being adjusted.");
    if (map?.state === "failed") return `${t("There is no map: {reason}", { reason: sentence(map.message ?? "") })} ${HINT}`;
    if (map?.state === "done" && this.#saved) return t("The map is saved as {name}.", { name: this.#saved });
    if (map?.state === "done") return t("The map is done. Give it a name to save it.");
    return HINT;
  }

  /** @param {SubmitEvent} event */
  async #keep(event) {
    event.preventDefault();
    const use = event.submitter?.id !== "mapping-keep";
    const name = hyphenated(this.#name.value);
    this.#awaited = use ? name : "";
    const force = !this.#doubted.hidden && this.#force.checked;
    if (await this.order({ type: "save_map", name, use, force })) this.#saved = name;
  }

  /** The robot goes on in the map that was saved. */
  #arrive() {
    this.#awaited = "";
    this.#popover.show(false);
  }

  /** @param {string} key */
  async #load(key) {
    this.#loaded = key;
    if (key === "") {
      this.#saved = "";
      this.#drawing = null;
      this.draw(null);
      return;
    }
    try {
      const drawing = /** @type {MapDrawingMessage} */ (await getJson("api/mapping"));
      // Meanwhile it may have been discarded, or there is a newer one.
      if (this.#loaded !== key || drawing.version === 0) return;
      this.#drawing = drawing;
      this.#joined = null;
      this.#force.checked = false;
      this.draw(drawing);
      const lines = [
        ...drawing.remarks.map((line) => make("li", { class: "remark" }, sentence(line))),
        ...drawing.facts.map((line) => make("li", {}, sentence(line))),
      ];
      this.#remarks.replaceChildren(...lines);
      this.#list(drawing);
    } catch (error) {
      setText(this.#state, t("The map could not be read: {error}", { error: sentence(error) }));
    }
  }

  /** List the strokes of a finished map, which can be changed. @param {MapDrawingMessage} drawing */
  #list({ strokes, version }) {
    const rows = strokes.map(({ points, interval }, stroke) => {
      const length = points.slice(1).reduce((sum, [x, y], i) => sum + Math.hypot(x - points[i][0], y - points[i][1]), 0);
      const words = t("Tape {number}: {length}, ± {interval}", {
        number: stroke + 1,
        length: millimetres(length),
        interval: millimetres(interval, 1),
      });
      const row = make("li", {}, make("span", {}, words), this.#join(stroke, version), this.#remove(stroke, version));
      row.onpointerenter = row.onfocusin = () => this.draw(this.#drawing, stroke);
      row.onpointerleave = row.onfocusout = () => this.draw(this.#drawing);
      return row;
    });
    this.#strokes.replaceChildren(...rows);
  }

  /** @param {number} stroke @param {number} version */
  #remove(stroke, version) {
    const name = t("Delete tape {number}", { number: stroke + 1 });
    const button = make("button", { type: "button", "aria-label": name }, t("delete"));
    button.onclick = () => this.order({ type: "delete_stroke", stroke, version });
    return button;
  }

  /** The first press chooses a stroke, the second one joins another to it. @param {number} stroke @param {number} version */
  #join(stroke, version) {
    const chosen = this.#joined;
    const [words, name] = joining(chosen, stroke);
    const button = make("button", { type: "button", "aria-label": name }, words);
    button.onclick = async () => {
      const first = this.#joined;
      this.#joined = first === null ? stroke : null;
      if (this.#drawing) this.#list(this.#drawing);
      if (first !== null && first !== stroke) await this.order({ type: "join_strokes", stroke: first, other: stroke, version });
    };
    return button;
  }
}

/**
 * Words and name of the button that joins a stroke to another.
 * @param {number | null} chosen the other one, if there is one already
 * @param {number} stroke
 * @returns {[string, string]}
 */
function joining(chosen, stroke) {
  const number = stroke + 1;
  if (chosen === null) return [t("join"), t("Join tape {number}", { number })];
  if (chosen === stroke) return [t("cancel"), t("Do not join tape {number}", { number })];
  const other = chosen + 1;
  return [t("to {other}", { other }), t("Join tape {other} to tape {number}", { other, number })];
}

/** A name without spaces, which a map's file has not. @param {string} name */
const hyphenated = (name) => name.trim().replace(/\s+/g, "-");
