// @ts-check
/** @typedef {import("../messages").Command} Command */
/** @typedef {import("./lease.js").Drive} Drive */

/** Telemetry tells of a drive that was accepted within this time [ms]. */
const BEGINS_MS = 1000;

/** A drive that the robot ends by itself: its start is answered, then this page renews it. */
export class OwnDrive {
  /** When this page started it [ms]. */
  #started = -Infinity;
  /** Whether telemetry has told of it. */
  #seen = false;

  /**
   * @param {Drive} drive
   * @param {(command: Command) => Promise<boolean>} order
   * @param {"calibrate" | "explore" | "figure_eight" | "navigate"} programme
   */
  constructor(drive, order, programme) {
    this.drive = drive;
    this.order = order;
    this.programme = programme;
  }

  /** Whether this page lets the robot drive so. */
  get mine() {
    return this.drive.programme === this.programme;
  }

  /** @param {Partial<Command>} start what starts it, besides its name */
  async begin(start = { start: true }) {
    // These two are answered: the renewals that follow are not.
    if (!(await this.order({ type: "take" }))) return;
    // What this page has the robot drive rests: its next renewal would end what begins.
    const { programme, again } = this.drive;
    if (programme !== this.programme) this.drive.letGo();
    if (!(await this.order({ ...this.drive.programmed(this.programme), ...start }))) {
      if (programme !== null && this.drive.programme === null) this.drive.setProgramme(programme);
      this.drive.again = again;
      return;
    }
    this.#started = performance.now();
    this.#seen = false;
    this.drive.setProgramme(this.programme);
    this.drive.again = () => this.begin(start);
  }

  end() {
    if (this.mine) this.drive.setProgramme(null);
  }

  /** Let go of it when somebody stops the robot: it must not go on when that one has driven. @param {boolean} drives whether the robot drives so @param {boolean} stopped whether a stop holds */
  heed(drives, stopped) {
    if (!this.mine) return;
    if (drives) this.#seen = true;
    else if (this.#seen && stopped) this.drive.endBy("stopped");
  }

  /** Let go of the drive when it is over. @param {boolean} drives whether the robot drives so */
  follow(drives) {
    if (!this.mine) return;
    if (drives) this.#seen = true;
    // Whether it is over, or stopped, the drive itself hears after a pause.
    else if (this.drive.away) return;
    else if (this.#seen || performance.now() - this.#started > BEGINS_MS) this.end();
  }
}
