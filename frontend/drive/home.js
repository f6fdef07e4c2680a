// @ts-check
import { degrees, millimetres } from "../page/format.js";
import { t } from "../page/language.js";

/** @typedef {import("../messages").Command} Command */
/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("./lease.js").Drive} Drive */

/** Ends what drives, and brings robot and filter back to the field's start; a real robot is carried there. */
export class Home {
  /** @type {FieldMessage | null} */
  #field = null;
  #carried = false;
  #moves = false;

  /** @param {Drive} drive @param {(command: Command) => Promise<boolean>} order @param {(words: string) => void} tell says where to put a real robot */
  constructor(drive, order, tell) {
    this.drive = drive;
    this.order = order;
    this.tell = tell;
  }

  /** @param {FieldMessage} field */
  setField(field) {
    this.#field = field;
  }

  /** @param {TelemetryMessage} telemetry */
  follow({ robot, mode }) {
    this.#carried = !robot.can_be_placed;
    this.#moves = mode !== "idle";
  }

  /** @param {{sd_xy?: number, sd_theta?: number}} known how well the filter is told to know the start [m, rad]; else as at the program's */
  async go(known = {}) {
    if (!this.#field) return;
    const { start, initial_sd_xy, initial_sd_theta } = this.#field;
    const { sd_xy = initial_sd_xy, sd_theta = initial_sd_theta } = known;
    // Whoever drives: what goes on would leave the start at once.
    if (this.#carried || this.#moves || this.drive.drives) {
      this.drive.letGo();
      if (!(await this.order({ type: "stop" }))) return;
    }
    if (!this.#carried && !(await this.order({ type: "place", ...start }))) return;
    if (!(await this.order({ type: "set_pose", ...start, sd_xy, sd_theta }))) return;
    if (this.#carried) this.tell(whereToPut(start));
  }
}

/** @param {import("../messages").PoseMessage} start */
const whereToPut = ({ x, y, theta }) =>
  t("Put the robot at x {x}, y {y}, heading {heading}: there the filter believes it now.", {
    x: millimetres(x),
    y: millimetres(y),
    heading: degrees(theta),
  });
