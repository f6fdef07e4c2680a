// @ts-check
import { t, translated } from "../../page/language.js";
import { find, findButton, setText } from "../../page/elements.js";
import { minutes, plain } from "../../page/format.js";

/** @typedef {import("../../messages").Command} Command */
/** @typedef {import("../../messages").RecordingMessage} RecordingMessage */
/** @typedef {import("../../page/toasts.js").Toasts} Toasts */

/** Button that records what happens; afterwards there is a link to the file. */
export class RecordButton {
  #button = findButton("record");
  #text = find("record-text", HTMLElement);
  #file = find("record-file", HTMLAnchorElement);
  #toasts;
  #running = false;
  /** The last message about a recording: each message is shown once. @type {string} */
  #said = "";

  /** @param {(command: Command) => Promise<boolean>} order @param {Toasts} toasts */
  constructor(order, toasts) {
    this.#toasts = toasts;
    this.#button.onclick = () => order({ type: "record", on: !this.#running });
  }

  /** @param {boolean} open whether the connection is open */
  enable(open) {
    this.#button.disabled = !open;
  }

  /** @param {RecordingMessage | null} recording the last one */
  show(recording) {
    const running = recording !== null && recording.running;
    if (running !== this.#running) this.#turn(running);
    setText(this.#text, running ? t("Recording {time}", { time: minutes(recording.duration_s) }) : t("Record"));
    this.#button.title = running
      ? t("{size} in {file}. Press to stop.", { size: megabytes(recording), file: recording.file })
      : t("Record everything that happens, to replay it or to look at it with ROS 2's tools");
    const done = recording !== null && !running && recording.size_bytes > 0;
    this.#file.hidden = !done;
    if (done) this.#link(recording);
    if (recording?.message) this.#say(recording);
  }

  /** @param {boolean} running */
  #turn(running) {
    this.#running = running;
    this.#button.setAttribute("aria-pressed", String(running));
  }

  /** @param {RecordingMessage} recording */
  #link(recording) {
    const address = `api/recordings/${encodeURIComponent(recording.file)}`;
    if (this.#file.getAttribute("href") === address) return;
    this.#file.href = address;
    this.#file.title = `${recording.file}, ${minutes(recording.duration_s)}, ${megabytes(recording)}`;
  }

  /** Show why it ended by itself, or what is missing. @param {RecordingMessage} recording */
  #say(recording) {
    // Numbers are left out: the amount that is missing may grow with each tick.
    const what = `${recording.file} ${recording.running} ${recording.message?.replace(/\d+/g, "")}`;
    if (what === this.#said) return;
    this.#said = what;
    this.#toasts.show(translated(recording.message ?? ""));
  }
}

/** @param {RecordingMessage} recording */
const megabytes = (recording) => `${plain(recording.size_bytes / 1e6, 1)} MB`;
