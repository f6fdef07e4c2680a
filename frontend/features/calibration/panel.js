// @ts-check
import { t, translated } from "../../page/language.js";
import { OwnDrive } from "../../drive/own_drive.js";
import { find, findButton, make, setText } from "../../page/elements.js";
import { millimetres, plain } from "../../page/format.js";
import { Popover } from "../../page/popover.js";
import { sentence } from "../../page/toasts.js";
import { getJson } from "../../wire/http.js";
import { UnknownRow } from "./row.js";

/** @typedef {import("../../messages").CalibrationDriveMessage} CalibrationDriveMessage */
/** @typedef {import("../../messages").CalibrationMessage} CalibrationMessage */
/** @typedef {import("../../messages").Command} Command */
/** @typedef {import("../../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../../drive/lease.js").Drive} Drive */
/** @typedef {import("../../wire/connection.js").Connection} Connection */

const HINT = t(
  "It drives until it knows where its camera is, for one to two minutes, within 0.4 m of where it stands. Tape has to be in sight, and the robot about where the map shows it.",
);

/** Calibration by driving: the button, what is known so far, and the way back. */
export class CalibrationPanel {
  #more = findButton("more");
  /** On a phone, where the drive panel has no header, there is another opener. */
  #popover = new Popover("calibration", ["calibration-open", "calibration-more"], () => this.#shown());
  #state = find("calibration-state", HTMLElement);
  #progress = find("calibration-progress", HTMLProgressElement);
  #list = find("calibration-unknowns", HTMLElement);
  #meaning = find("calibration-meaning", HTMLElement);
  #start = findButton("calibration-drive");
  #finish = findButton("calibration-finish");
  #undo = findButton("calibration-undo");
  #profile = find("calibration-profile", HTMLAnchorElement);
  /** @type {UnknownRow[]} */
  #rows = [];
  /** @type {CalibrationMessage | null} */
  #known = null;
  /** What the numbers on the page were loaded for. */
  #loaded = "";
  /** @type {OwnDrive} */
  #drives;

  /**
   * @param {Drive} drive
   * @param {(command: Command) => Promise<boolean>} order
   * @param {Connection} connection
   */
  constructor(drive, order, connection) {
    this.drive = drive;
    this.#drives = new OwnDrive(drive, order, "calibrate");
    this.#start.onclick = () => this.#drives.begin();
    this.#finish.onclick = () => order({ type: "finish_calibration" });
    this.#undo.onclick = () => order({ type: "undo_calibration" });
    connection.onState((state) => state !== "open" && (this.#loaded = ""));
  }

  /** @param {TelemetryMessage} telemetry */
  follow(telemetry) {
    const drive = telemetry.calibration ?? null;
    this.#drives.follow(drive?.state === "drive");
    if (!this.#popover.shown) return;
    const key = `${drive?.state} ${drive?.adjusted} ${telemetry.robot.calibrated}`;
    if (key !== this.#loaded) this.#load(key);
    const driving = drive?.state === "drive";
    this.#progress.hidden = !driving;
    if (driving) {
      this.#progress.max = drive.whole;
      this.#progress.value = drive.seconds;
    }
    this.#start.hidden = driving;
    this.#start.disabled =
      !this.drive.possible || this.drive.other !== null || drive?.state === "adjust";
    this.#finish.hidden = !driving;
    this.#finish.disabled = !driving || drive.seconds < drive.fewest;
    this.#finish.title = driving ? t("From {seconds} s on", { seconds: plain(drive.fewest) }) : "";
    this.#undo.disabled = !this.#known?.undoable || !this.drive.possible || driving;
    setText(this.#state, this.#words(drive, telemetry.replay !== null));
  }

  /** @param {CalibrationDriveMessage | null} drive @param {boolean} replayed */
  #words(drive, replayed) {
    if (replayed) return t("A recording cannot be driven; its calibration is the recorded one.");
    if (drive?.state === "drive") {
      const seconds = t("Driving: {seconds} s of {whole} s.", {
        seconds: plain(drive.seconds),
        whole: plain(drive.whole),
      });
      if (!drive.message) return seconds;
      return `${seconds} ${t("Not yet: {reason}.", { reason: translated(drive.message) })}`;
    }
    const measured = this.#known?.measured;
    // What was found is told a moment before the robot has it.
    const comes = drive?.state === "done" && !measured;
    if (drive?.state === "adjust" || comes) return t("The robot stands; what it saw is being adjusted.");
    if (drive?.state === "failed")
      return `${sentence(drive.message ?? "")} ${t("Nothing was changed.")} ${HINT}`;
    if (!measured) return `${t("As described: this robot has not been calibrated.")} ${HINT}`;
    const about = [measured, drive?.message ?? ""].filter(Boolean).map(translated).join("; ");
    return sentence(t("Calibrated {measured}", { measured: about }));
  }

  #shown() {
    this.#more.setAttribute("aria-expanded", "false");
    this.#loaded = "";
  }

  /** @param {string} key */
  async #load(key) {
    this.#loaded = key;
    try {
      this.#known = /** @type {CalibrationMessage} */ (await getJson("api/calibration"));
    } catch (error) {
      setText(this.#meaning, t("The calibration could not be read: {error}", { error: sentence(error) }));
      return;
    }
    this.#write(this.#known);
  }

  /** @param {CalibrationMessage} known */
  #write({ unknowns, position, advice, facts, remarks, measured }) {
    if (this.#rows.length !== unknowns.length) {
      this.#rows = unknowns.map((unknown) => new UnknownRow(unknown));
      this.#list.replaceChildren(...this.#rows.map((row) => row.element));
    }
    this.#rows.forEach((row, place) => row.show(unknowns[place]));
    this.#profile.hidden = measured === "";
    const lines = position === null ? [] : [t("Together: the place is known to ± {size}.", { size: millimetres(position, 1) })];
    if (advice.length > 0) lines.push(t("To learn more: {advice}.", { advice: advice.map(translated).join("; ") }));
    lines.push(...[...facts, ...remarks].map((words) => sentence(translated(words))));
    this.#meaning.hidden = lines.length === 0;
    this.#meaning.replaceChildren(...lines.map((line) => make("span", {}, line)));
  }
}
