// @ts-check
import { find, findButton, findInput, make } from "../page/elements.js";
import { t } from "../page/language.js";
import { getJson } from "../wire/http.js";
import { written } from "./layouts.js";

/** @typedef {import("../messages").Command} Command */
/** @typedef {import("../messages").ParameterMessage} ParameterMessage */
/** @typedef {import("../messages").TelemetryMessage} TelemetryMessage */
/** @typedef {import("../page/toasts.js").Toasts} Toasts */
/** @typedef {import("./layout.js").Layout} Layout */
/** @typedef {{x: number, y: number, theta: number}} Place */
/**
 * @typedef {object} Scene
 * @property {string} kind
 * @property {string} title
 * @property {string} field
 * @property {{file: string, position: number} | null} replay
 * @property {Place | null} truth where a simulated robot is put
 * @property {(Place & {covariance?: number[]}) | "anywhere"} belief what the filter is told
 * @property {Record<string, number | string | boolean>} parameters that differ from those at the start
 * @property {boolean} hand whether the filter waits for steps by hand
 * @property {string} layout
 */

const KIND = "brickpose-scene-1";
const LINK = "#scene=";
const KEY = "brickpose.scenes";
/** A lecture has no more. */
const MOST = 40;

/** Scenes of a lecture: field, poses, filter and layout by one press, or by a link. */
export class Scenes {
  #row = find("scenes", HTMLElement);
  #title = findInput("scene-title");
  /** @type {TelemetryMessage | null} */
  #now = null;
  /** A scene whose field or recording is loaded. @type {Scene | null} */
  #awaited = null;
  /** @type {Scene[]} */
  #kept = readKept();

  /**
   * @param {(command: Command) => Promise<boolean>} order
   * @param {Layout} layout @param {Toasts} toasts
   */
  constructor(order, layout, toasts) {
    this.order = order;
    this.layout = layout;
    this.toasts = toasts;
    findButton("scene-keep").onclick = () => this.#keep();
    this.#title.onkeydown = ({ key }) => key === "Enter" && this.#keep();
    addEventListener("hashchange", () => this.#followLink());
    this.#followLink();
    this.#write();
  }

  /** @param {TelemetryMessage} telemetry */
  follow(telemetry) {
    this.#now = telemetry;
    const scene = this.#awaited;
    if (!scene || telemetry.map !== scene.field || (telemetry.replay?.file ?? "") !== (scene.replay?.file ?? "")) return;
    this.#awaited = null;
    this.#set(scene);
  }

  /** Show a scene; another field or recording is loaded first. @param {Scene} scene */
  async show(scene) {
    this.layout.open(scene.layout);
    this.#awaited = scene;
    const now = this.#now;
    const file = scene.replay?.file ?? "";
    if (!now || (now.map === scene.field && (now.replay?.file ?? "") === file)) return;
    /** @type {Command} */
    let command = { type: "use_field", name: scene.field };
    if (file) command = { type: "open_recording", name: file };
    else if (now.replay) command = { type: "close_recording" };
    if (!(await this.order(command))) this.#awaited = null;
  }

  /** @param {Scene} scene */
  async #set({ replay, truth, belief, parameters, hand }) {
    /** @type {Command[]} */
    const commands = this.#now?.filter.hand ? [{ type: "filter_by_hand", on: false }, { type: "reset" }] : [{ type: "reset" }];
    if (Object.keys(parameters).length > 0) commands.push({ type: "set_parameters", values: parameters });
    if (replay) commands.push({ type: "replay", position_s: replay.position });
    else {
      if (truth && this.#now?.robot.can_be_placed) commands.push({ type: "place", ...truth });
      commands.push(belief === "anywhere" ? { type: "scatter" } : { type: "set_pose", ...belief });
    }
    for (const command of commands) if (!(await this.order(command))) return;
    if (hand) await this.order({ type: "filter_by_hand", on: true });
  }

  async #keep() {
    const title = this.#title.value.trim() || t("Scene {number}", { number: this.#kept.length + 1 });
    this.#title.value = "";
    const scene = await this.#present(title);
    if (!scene) return;
    this.#kept = [...this.#kept.filter((other) => other.title !== title), scene].slice(-MOST);
    this.#write();
  }

  /** @param {string} title @returns {Promise<Scene | null>} */
  async #present(title) {
    const now = this.#now;
    if (!now) return null;
    /** @type {ParameterMessage[]} */
    const all = await getJson("api/parameters");
    const changed = all.filter(({ value, default: standard }) => value !== standard);
    const known = ["certain", "given", "approximate"].includes(now.integrity.state);
    return {
      kind: KIND,
      title,
      field: now.map,
      replay: now.replay ? { file: now.replay.file, position: now.replay.position_s } : null,
      truth: placeOf(now.truth),
      belief: known && now.estimate ? { ...now.estimate } : "anywhere",
      parameters: Object.fromEntries(changed.map(({ name, value }) => [name, value])),
      hand: Boolean(now.filter.hand),
      layout: written(this.layout.tree),
    };
  }

  /** Show the scene of the page's link; one from elsewhere asks before it moves the robot. */
  #followLink() {
    if (!location.hash.startsWith(LINK)) return;
    const scene = read(location.hash.slice(LINK.length));
    history.replaceState(null, "", location.pathname + location.search);
    if (!scene) return this.toasts.show(t("This link has no scene."));
    if (!confirm(t("Show the scene {title}? It sets robot, filter and layout.", { title: scene.title }))) return;
    this.show(scene);
  }

  #write() {
    try {
      localStorage.setItem(KEY, JSON.stringify(this.#kept));
    } catch {
      // Storage is switched off: the scenes last until the page is closed.
    }
    this.#row.hidden = this.#kept.length === 0;
    this.#row.replaceChildren(...this.#kept.map((scene, place) => this.#button(scene, place)));
  }

  /** @param {Scene} scene @param {number} place */
  #button(scene, place) {
    const show = make("button", { type: "button", title: t("Show this scene") }, scene.title);
    show.onclick = () => this.show(scene);
    const link = make("a", { class: "button", href: `${LINK}${encodeURIComponent(JSON.stringify(scene))}`, "aria-label": t("Link to {title}", { title: scene.title }), title: t("Copy this link") }, t("link"));
    link.onclick = (event) => {
      event.preventDefault();
      const address = /** @type {HTMLAnchorElement} */ (link).href;
      navigator.clipboard?.writeText(address).then(
        () => this.toasts.show(t("The link to this scene is copied."), "note"),
        () => prompt(t("The link to this scene:"), address),
      ) ?? prompt(t("The link to this scene:"), address);
    };
    const gone = make("button", { type: "button", "aria-label": t("Forget {title}", { title: scene.title }) }, "×");
    gone.onclick = () => {
      this.#kept.splice(place, 1);
      this.#write();
    };
    return make("li", {}, show, link, gone);
  }
}

/** @param {Place | null | undefined} pose @returns {Place | null} */
const placeOf = (pose) => (pose ? { x: pose.x, y: pose.y, theta: pose.theta } : null);

/** @param {string} text @returns {Scene | null} */
function read(text) {
  try {
    const scene = JSON.parse(decodeURIComponent(text));
    return isScene(scene) ? scene : null;
  } catch {
    return null;
  }
}

/** @param {any} scene @returns {scene is Scene} what the robot is told of it, the program checks */
const isScene = (scene) =>
  scene?.kind === KIND && typeof scene.title === "string" && typeof scene.field === "string" && typeof scene.layout === "string" && scene.belief && typeof scene.parameters === "object";

/** @returns {Scene[]} */
function readKept() {
  try {
    const kept = JSON.parse(localStorage.getItem(KEY) ?? "[]");
    return Array.isArray(kept) ? kept.filter(isScene) : [];
  } catch {
    return [];
  }
}
