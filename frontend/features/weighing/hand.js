// @ts-check
import { decodeCloud } from "../../map/cloud.js";
import { t, tn } from "../../page/language.js";
import { make, setText } from "../../page/elements.js";
import { degrees, millimetres, plain } from "../../page/format.js";
import { sentence } from "../../page/toasts.js";
import { getJson } from "../../wire/http.js";

/** @typedef {import("../../messages").Command} Command */
/** @typedef {import("../../messages").HandStepMessage} HandStepMessage */
/** @typedef {import("../../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../../map/cloud.js").Cloud} Cloud */
/** @typedef {"predict" | "weigh" | "resample"} Step */
/** @typedef {{message: HandStepMessage, before: Cloud, after: Cloud, noiseless: Cloud}} Shown the last step, unpacked */

/** The step that follows on another in one update. */
const NEXT = /** @type {const} */ ({ predict: "weigh", weigh: "resample", resample: "predict" });
/** @type {[Step, string, string][]} */
const STEPS = [
  ["predict", t("predict"), t("Move each particle as the wheels say, and by chance")],
  ["weigh", t("weigh"), t("Weigh each particle by the newest picture")],
  ["resample", t("resample"), t("Draw the particles that go on, by weight")],
];

/** The filter by hand: its three steps, back, and what the last one did. */
export class HandSection {
  /** The last step, as it is drawn; null while the filter works by itself. @type {Shown | null} */
  shown = null;
  #words = make("p", { role: "status" });
  #ahead = make("p", { class: "quiet" });
  #switch = button(t("by hand"), t("Let the filter wait for your steps, or work by itself again"));
  #undo = button(t("back"), t("Take the last step back; the same step then draws the same numbers"));
  #steps = STEPS.map(([step, text, title]) => {
    const made = button(text, title);
    made.onclick = () => this.order({ type: "filter_step", step });
    return made;
  });
  #row = make("div", { class: "tools", role: "group", "aria-label": t("Steps by hand") }, ...this.#steps, this.#undo);
  element = make(
    "section",
    { class: "hand", "aria-labelledby": "hand-title" },
    make("div", { class: "aside-bar" }, make("h4", { id: "hand-title" }, t("The filter by hand")), this.#switch),
    this.#row,
    this.#words,
    this.#ahead,
  );
  /** Number of the step that was asked for last. */
  #number = -1;
  #enabled = false;

  /** @param {(command: Command) => Promise<boolean>} order @param {() => void} changed when there is something new to draw */
  constructor(order, changed) {
    this.order = order;
    this.changed = changed;
    this.#switch.onclick = () => order({ type: "filter_by_hand", on: !this.#enabled });
    this.#undo.onclick = () => order({ type: "filter_undo" });
  }

  /** @param {TelemetryMessage} telemetry */
  follow({ filter: { kind, hand } }) {
    const possible = kind === "particles";
    this.#enabled = Boolean(hand);
    this.#switch.setAttribute("aria-pressed", String(this.#enabled));
    this.#row.hidden = !hand;
    if (!hand) {
      if (this.shown) this.#forget();
      this.#number = -1;
      setText(this.#words, possible ? t("Predict, weigh and resample one at a time, and back.") : t("Takes the particle filter in place of {kind}, with its heaviest place.", { kind }));
      setText(this.#ahead, "");
      return;
    }
    const next = hand.last === null ? "predict" : NEXT[hand.last];
    STEPS.forEach(([step], i) => {
      this.#steps[i].classList.toggle("primary", step === next);
      this.#steps[i].disabled = step !== "predict" && step !== next;
    });
    this.#undo.disabled = hand.undoable === 0;
    setText(this.#ahead, gathered(hand.ahead));
    if (hand.number !== this.#number) this.#load(hand.number);
  }

  #forget() {
    this.shown = null;
    this.changed();
  }

  /** @param {number} number */
  async #load(number) {
    this.#number = number;
    try {
      /** @type {HandStepMessage} */
      const message = await getJson("api/filter_by_hand");
      if (this.#number !== number) return;
      // Another step was taken meanwhile: telemetry will say so, too.
      if (message.number !== number) this.#number = message.number;
      const [before, after, noiseless] = [message.before, message.after, message.noiseless].map((cloud) =>
        decodeCloud({ cloud, extent: message.extent }),
      );
      this.shown = { message, before, after, noiseless };
      setText(this.#words, words(message));
      this.changed();
    } catch (error) {
      if (this.#enabled) setText(this.#words, sentence(error));
    }
  }
}

/** @param {string} text @param {string} title */
function button(text, title) {
  return /** @type {HTMLButtonElement} */ (make("button", { type: "button", title }, text));
}

/** @param {{x: number, y: number, theta: number}} ahead */
function gathered({ x, y, theta }) {
  const way = Math.hypot(x, y);
  if (way < 5e-4 && Math.abs(theta) < 0.002) return t("The robot stands where the last prediction ended: drive a little before the next one.");
  return t("Since the last prediction the wheels have driven {way} and turned {turn}.", { way: millimetres(way), turn: degrees(theta, 1) });
}

/** What a step did. @param {HandStepMessage} step */
function words({ last, moved, noise, parents, effective, effective_before, after, before }) {
  if (last === "predict" && moved && noise) {
    return t("All moved {way} and turned {turn}. The noise drawn: ± {ahead} ahead, ± {aside} aside, ± {spread} of heading; it is drawn as lines.", {
      way: millimetres(Math.hypot(moved.x, moved.y)),
      turn: degrees(moved.theta, 1),
      ahead: millimetres(noise.x, 1),
      aside: millimetres(noise.y, 1),
      spread: degrees(noise.theta, 2),
    });
  }
  const counts = { before: plain(effective_before ?? 0), now: plain(effective), count: count(after) };
  if (last === "weigh") return t("Heavier particles are larger and darker. Of {count} particles, {now} are effective; it was {before}.", counts);
  if (last === "resample") {
    const copies = new Map();
    for (const parent of parents) copies.set(parent, (copies.get(parent) ?? 0) + 1);
    const fresh = copies.get(-1) ?? 0;
    copies.delete(-1);
    const dead = count(before) - copies.size;
    const anywhere = fresh ? ` ${tn("{count} is drawn from anywhere.", "{count} are drawn from anywhere.", fresh)}` : "";
    return `${t("{dead} of {all} died (crosses); {left} live on in {count} copies, the most in {most}.", {
      dead,
      all: count(before),
      left: copies.size,
      count: parents.length - fresh,
      most: Math.max(0, ...copies.values()),
    })}${anywhere} ${t("All weigh the same again.")}`;
  }
  return t("The filter waits. Begin with predict.");
}

/** Particles in a packed cloud of 8 bytes each. @param {string} packed base64 */
const count = (packed) => Math.floor((packed.length * 3) / 4 / 8);
