// @ts-check
import { Home } from "../../drive/home.js";
import { Drive } from "../../drive/lease.js";
import { OwnDrive } from "../../drive/own_drive.js";
import { getJson } from "../../wire/http.js";

/** @typedef {import("../../messages").Command} Command */
/** @typedef {import("../../wire/connection.js").Connection} Connection */

/** Telemetry that is older than a start may still tell of the stop before it [ms]. */
const SETTLED_MS = 1000;

/** @typedef {Command | {type: "back_to_start", sd_xy?: number, sd_theta?: number}} Wish what a button of a lesson asks for */

/** What a lesson's buttons drive: a figure-eight is renewed until somebody stops or drives otherwise. */
export class LessonDrive {
  #drive;
  #eight;
  #home;
  #begun = -Infinity;

  /**
   * @param {Connection} connection
   * @param {(command: Command) => Promise<boolean>} order
   * @param {(ended: import("../../drive/lease.js").Ended) => void} tell hears what ended the drive
   * @param {(words: string) => void} say shows a sentence
   */
  constructor(connection, order, tell, say) {
    this.order = order;
    this.#drive = new Drive(connection, () => {});
    this.#drive.onEnded(tell);
    this.#eight = new OwnDrive(this.#drive, order, "figure_eight");
    this.#home = new Home(this.#drive, order, say);
    connection.onTelemetry((telemetry) => {
      this.#drive.follow(telemetry);
      this.#home.follow(telemetry);
      const settled = performance.now() - this.#begun > SETTLED_MS;
      if (telemetry.driver.stopped && settled) this.#drive.endBy("stopped");
    });
    connection.onState((state) => state === "lost" && this.#drive.disconnect());
  }

  /** Carry out what a button asks for. @param {Wish} wish */
  async obey(wish) {
    if (wish.type === "back_to_start") {
      this.#home.setField(await getJson("api/field")); // another one may have been loaded
      return this.#home.go(wish);
    }
    // The next renewal of a figure-eight would end a journey, and be ended by it.
    if (wish.type === "stop" || wish.type === "navigate") this.#drive.letGo();
    // A press ends a stop that holds, from before another field, too.
    if (wish.type === "navigate" && !(await this.order({ type: "take" }))) return;
    if (wish.type !== "figure_eight") return this.order(wish);
    await this.#eight.begin();
    this.#begun = performance.now();
  }
}
