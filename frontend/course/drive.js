// @ts-check
import { Drive } from "../drive/lease.js";
import { OwnDrive } from "../drive/own_drive.js";

/** @typedef {import("../messages").Command} Command */
/** @typedef {import("../wire/connection.js").Connection} Connection */

/** The figure-eight that a lesson's button starts: renewed until somebody stops or drives otherwise. */
export class LessonDrive {
  #drive;
  #eight;

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
    connection.onTelemetry(({ mode, driver: { name, mine } }) => {
      this.#drive.follow(mine ? null : name);
      this.#eight.follow(mode === "figure_eight");
    });
    connection.onState((state) => state === "lost" && this.#drive.disconnect());
  }

  /** Carry out a command of a button. @param {Command} command */
  obey(command) {
    if (command.type === "figure_eight") return this.#eight.begin();
    if (command.type === "stop") this.#drive.disconnect();
    return this.order(command);
  }
}
