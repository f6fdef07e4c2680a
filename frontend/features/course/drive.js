// @ts-check
import { Drive } from "../../drive/lease.js";
import { OwnDrive } from "../../drive/own_drive.js";

/** @typedef {import("../../messages").Command} Command */
/** @typedef {import("../../wire/connection.js").Connection} Connection */

/** Telemetry that is older than a start may still tell of the stop before it [ms]. */
const SETTLED_MS = 1000;

/** The figure-eight that a lesson's button starts: renewed until somebody stops or drives otherwise. */
export class LessonDrive {
  #drive;
  #eight;
  #begun = -Infinity;

  /**
   * @param {Connection} connection
   * @param {(command: Command) => Promise<boolean>} order
   * @param {(ended: import("../../drive/lease.js").Ended) => void} tell hears what ended the drive
   */
  constructor(connection, order, tell) {
    this.order = order;
    this.#drive = new Drive(connection, () => {});
    this.#drive.onEnded(tell);
    this.#eight = new OwnDrive(this.#drive, order, "figure_eight");
    connection.onTelemetry((telemetry) => {
      this.#drive.follow(telemetry);
      const settled = performance.now() - this.#begun > SETTLED_MS;
      if (telemetry.driver.stopped && settled) this.#drive.endBy("stopped");
    });
    connection.onState((state) => state === "lost" && this.#drive.disconnect());
  }

  /** Carry out a command of a button. @param {Command} command */
  async obey(command) {
    if (command.type === "stop") this.#drive.letGo();
    if (command.type !== "figure_eight") return this.order(command);
    await this.#eight.begin();
    this.#begun = performance.now();
  }
}
