// @ts-check
import { t } from "../../page/language.js";
import { make, setText } from "../../page/elements.js";
import { brief, degrees, millimetres, plain, readNumber } from "../../page/format.js";
import { sentence } from "../../page/toasts.js";
import { getJson } from "../../wire/http.js";
import { between, moved } from "./poses.js";
import { powerOfTen } from "./powers.js";
import { RayChart } from "./ray_chart.js";

/** @typedef {import("../../messages").PoseFitsMessage} PoseFitsMessage */
/** @typedef {import("../../messages").PoseFitMessage} PoseFitMessage */
/** @typedef {import("../../messages").PoseMessage} PoseMessage */
/** @typedef {import("../../messages").TelemetryMessage} TelemetryMessage */

/** While nothing is dragged, the fit is asked for again this often [ms]. */
const AGAIN_MS = 300;
const HINT = t("Press a particle on the map: it says what it expects to see. Drag it, or turn it by its arrow, and see what it is worth elsewhere.");

/** One pose, asked how the scan fits it, beside the estimate. */
export class FitSection {
  element = make("section", { class: "fit", "aria-label": t("A particle asked") });
  /** The pose that is asked. @type {PoseMessage | null} */
  pose = null;
  /** The newest answer. @type {PoseFitsMessage | null} */
  fits = null;
  /** Whether the particle nearest is asked, or a pose wherever it is. */
  #nearest = false;
  /** Odometry when the pose was chosen. @type {PoseMessage | null} */
  #odometry = null;
  /** @type {TelemetryMessage | null} */
  #telemetry = null;
  #asking = false;
  #changed = false;
  /** Whether what was typed last is no number: its refusal stays until a pose is chosen. */
  #refused = false;
  #answered = 0;
  #words = make("p", { role: "status" }, HINT);
  #table = make("table", {});
  #chart;
  #fields = ["x", "y", "theta"].map(() => /** @type {HTMLInputElement} */ (make("input", { type: "text", inputmode: "decimal", autocomplete: "off" })));

  /** @param {() => void} changed when there is something new to draw on the map */
  constructor(changed) {
    this.changed = changed;
    this.#chart = new RayChart(() => changed());
    const heaviest = make("button", { type: "button", title: t("Ask the particle nearest to the estimate") }, t("nearest to estimate"));
    heaviest.onclick = () => this.#askEstimate();
    const names = [t("x in mm"), t("y in mm"), t("heading in degrees")];
    const labels = ["x", "y", "°"];
    const inputs = this.#fields.map((field, i) => {
      field.setAttribute("aria-label", names[i]);
      field.onchange = () => this.#typed();
      return make("label", {}, labels[i], " ", field);
    });
    this.#chart.element.hidden = true;
    this.element.append(this.#words, make("div", { class: "tools" }, heaviest), make("div", { class: "tools" }, ...inputs), this.#table, this.#chart.element);
  }

  /** Ray that stands out; null is none. */
  get chosen() {
    return this.fits ? this.#chart.chosen : null;
  }

  /** Ask the particle nearest to a place. @param {number} x @param {number} y */
  choose(x, y) {
    this.#nearest = true;
    this.#take({ x, y, theta: 0 });
  }

  /** Ask a pose. @param {PoseMessage} pose */
  move(pose) {
    this.#nearest = false;
    this.#take(pose);
  }

  clear() {
    this.#refused = false;
    this.pose = this.fits = null;
    setText(this.#words, HINT);
    this.#table.replaceChildren();
    this.#chart.element.hidden = true;
    this.changed();
  }

  /** @param {TelemetryMessage} telemetry @param {boolean} shown */
  follow(telemetry, shown) {
    this.#telemetry = telemetry;
    if (shown && this.pose && performance.now() - this.#answered > AGAIN_MS) this.#ask();
  }

  #askEstimate() {
    const estimate = this.#telemetry?.estimate;
    if (estimate) this.choose(estimate.x, estimate.y);
  }

  #typed() {
    const [x, y, angle] = this.#fields.map((field) => readNumber(field.value));
    this.#refused = ![x, y, angle].every(Number.isFinite);
    if (this.#refused) return void setText(this.#words, t("That is not a number."));
    this.move({ x: x / 1000, y: y / 1000, theta: (angle * Math.PI) / 180 });
  }

  /** @param {PoseMessage} pose */
  #take(pose) {
    this.#refused = false;
    this.pose = pose;
    this.#odometry = this.#telemetry?.odometry ?? null;
    this.#changed = true;
    this.#ask();
    this.changed();
  }

  /** Where the pose is now: odometry carries it along, but by hand particles stand. */
  get #carried() {
    const odometry = this.#telemetry?.odometry;
    if (!this.pose || !this.#odometry || !odometry || this.#telemetry?.filter.hand) return this.pose;
    return moved(this.pose, between(this.#odometry, odometry));
  }

  async #ask() {
    if (this.#asking || !this.pose) return;
    this.#asking = true;
    this.#changed = false;
    const pose = /** @type {PoseMessage} */ (this.#carried);
    const odometry = this.#telemetry?.odometry ?? null;
    const place = `x=${pose.x}&y=${pose.y}`;
    try {
      /** @type {PoseFitsMessage} */
      const fits = await getJson(`api/pose_fit?${this.#nearest ? place : `${place}&theta=${pose.theta}`}`);
      // Somebody may have dragged it on meanwhile.
      if (!this.#changed && this.pose) this.#show(fits, odometry);
    } catch (error) {
      setText(this.#words, sentence(error));
    } finally {
      this.#asking = false;
      this.#answered = performance.now();
    }
    if (this.#changed) this.#ask();
  }

  /** @param {PoseFitsMessage} fits @param {PoseMessage | null} odometry when it was asked for */
  #show(fits, odometry) {
    this.fits = fits;
    const { x, y, theta } = fits.asked;
    this.pose = { x, y, theta };
    this.#odometry = odometry;
    [x * 1000, y * 1000, (theta * 180) / Math.PI].forEach((value, i) => {
      if (document.activeElement !== this.#fields[i]) this.#fields[i].value = plain(value, i === 2 ? 1 : 0);
    });
    if (!this.#refused) setText(this.#words, words(fits));
    this.#table.replaceChildren(...rows(fits));
    this.#chart.element.hidden = false;
    this.#chart.show(fits);
    this.changed();
  }
}

/** A weight as a multiple of the estimate's. @param {number} weight */
export function weightWords(weight) {
  if (weight >= 0.001 && weight < 1000) return `× ${brief(weight)}`;
  return `× ${powerOfTen(Math.log10(Math.max(weight, 1e-300)))}`;
}

/** @param {PoseFitsMessage} fits */
function words({ particle, asked, model, extra_sd, bearings, ranges }) {
  const who =
    particle === null
      ? t("A place of your own choice, no particle.")
      : t("A particle: it weighs {times} times the mean.", { times: brief(particle) });
  const hits = ranges.filter((range) => range !== null).length;
  if (hits === 0) return `${who} ${t("No ray meets tape now.")}`;
  const soft = extra_sd < 5e-4 ? "" : ` ${t("As the particles lie apart, ranges are believed to {spread} only.", { spread: millimetres(extra_sd, 1) })}`;
  const slow = asked.shares ? "" : ` ${t("The model is too slow to ask for each ray.")}`;
  return `${who} ${t("{hits} of {count} rays meet tape; the model is {model}.", { hits, count: bearings.length, model })}${soft}${slow}`;
}

/** @param {PoseFitsMessage} fits */
function rows({ asked, best }) {
  const head = make("tr", {}, make("td", {}), ...[t("asked"), t("estimate")].map((text) => make("th", { scope: "col" }, text)));
  /** @param {string} name @param {(fit: PoseFitMessage) => string} value */
  const row = (name, value) =>
    make("tr", {}, make("th", { scope: "row" }, name), ...[asked, best].map((fit) => make("td", {}, fit ? value(fit) : "–")));
  const lines = [
    head,
    row(t("log-likelihood"), ({ log_likelihood }) => plain(log_likelihood, 1)),
    row(t("weight"), ({ weight }) => weightWords(weight)),
    row(t("where"), ({ x, y, theta }) => `${plain(x * 1000)}, ${plain(y * 1000)}, ${degrees(theta)}`),
  ];
  if (Math.abs(asked.rest) > 0.05 && asked.shares) lines.push(row(t("besides the rays"), ({ rest }) => plain(rest, 1)));
  return lines;
}
