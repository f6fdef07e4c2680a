// @ts-check
import { translated } from "./language.js";
import { find, setText } from "./elements.js";
import { getJson } from "../wire/http.js";

/** @typedef {import("../messages").HealthMessage} HealthMessage */
/** @typedef {import("../wire/connection.js").LinkState} LinkState */

const LOOK_MS = 500;

/**
 * At the first start functions are compiled, and there is no robot to connect to: this shows how far
 * that is, where the camera's picture will be.
 */
export class FirstStart {
  #box = find("compiling", HTMLElement);
  #text = find("compiling-text", HTMLElement);
  #bar = find("compiling-bar", HTMLProgressElement);
  #empty = find("camera-empty", HTMLElement);
  /** @type {LinkState} */
  #link = "connecting";
  #looking = false;

  /** @param {(compiling: boolean) => void} changed */
  constructor(changed) {
    this.changed = changed;
  }

  /** Whether functions are compiled just now. */
  get compiling() {
    return !this.#box.hidden;
  }

  /** Without a connection, ask why. @param {LinkState} link */
  follow(link) {
    this.#link = link;
    if (link === "open") this.#show(null);
    else if (link === "lost" && !this.#looking) this.#look();
  }

  async #look() {
    this.#looking = true;
    /** @type {HealthMessage | null} */
    const health = await getJson("api/health").catch(() => null);
    // Between compiling and the robot nobody answers for a moment.
    const between = health === null && this.compiling;
    this.#looking = this.#link !== "open" && (between || Boolean(health?.compiling));
    if (!this.#looking) return this.#show(null);
    if (health) this.#show(health);
    setTimeout(() => this.#look(), LOOK_MS);
  }

  /** @param {HealthMessage | null} health null if nothing is compiled any more */
  #show(health) {
    if (health?.compiling) {
      this.#bar.max = health.compiling.total;
      this.#bar.value = health.compiling.done;
      setText(this.#text, translated(health.detail));
    }
    if (this.compiling === (health !== null)) return;
    this.#box.hidden = health === null;
    this.#empty.hidden = health !== null;
    this.changed(this.compiling);
  }
}
