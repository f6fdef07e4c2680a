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
   */
  constructor(connection, order) {
    this.order = order;
    this.#drive = new Drive(
      (command) => connection.post(command),
      () => {},
    );
    this.#eight = new OwnDrive(this.#drive, order, "figure_eight");
    connection.onTelemetry(({ driver: { name, mine, stopped } }) => {
      this.#drive.follow(mine ? null : name);
      if (stopped && performance.now() - this.#begun > SETTLED_MS) this.#drive.disconnect();
    });
    connection.onState((state) => state === "lost" && this.#drive.disconnect());
  }

  /** Carry out a command of a button. @param {Command} command */
  async obey(command) {
    if (command.type === "stop") this.#drive.disconnect();
    if (command.type !== "figure_eight") return this.order(command);
    await this.#eight.begin();
    this.#begun = performance.now();
  }
}
