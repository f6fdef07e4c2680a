// @ts-check
import { find, findButton, setText } from "../page/elements.js";
import { Surface } from "../page/surface.js";
import { millimetres } from "../page/format.js";
import { drawOverlay, nearestRay, thin } from "./overlay.js";
import { Pairing } from "./pairing.js";
import { RayProfile } from "./profile.js";
import { CameraStream } from "./stream.js";

/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../messages").ScanMessage} ScanMessage */
/** @typedef {import("../page/draw_loop.js").DrawLoop} DrawLoop */
/** @typedef {import("./overlay.js").Point} Point */
/** @typedef {import("./pairing.js").Pair} Pair */

/** The live picture, what the scanner found in it, and the profile of one ray. */
export class CameraPanel {
  #pairing = new Pairing();
  #hint = find("camera-hint", HTMLElement);
  #text = find("camera-text", HTMLElement);
  #empty = find("camera-empty", HTMLElement);
  #raysButton = findButton("camera-rays");
  #profileButton = findButton("camera-profile");
  /** @type {Point[][]} */
  #rays = [];
  /** @type {Pair | null} */
  #drawn = null;

  /**
   * @param {DrawLoop} loop
   * @param {(stamp: number) => void} drawn called when a new picture is on the screen
   */
  constructor(loop, drawn) {
    this.drawn = drawn;
    const canvas = find("camera-canvas", HTMLCanvasElement);
    this.surface = new Surface(canvas, () => this.#resized());
    this.refresh = loop.add((now) => this.#paint(now), { visible: () => this.surface.visible });
    this.stream = new CameraStream("/api/camera", (picture) => {
      this.#pairing.addPicture(picture);
      this.refresh();
    });
    this.profile = new RayProfile(loop, () => this.#selected());
    this.#raysButton.onclick = () => this.#toggleRays();
    this.#profileButton.onclick = () => this.#toggleProfile();
    canvas.addEventListener("click", (event) => this.#click(event));
    canvas.addEventListener("keydown", (event) => this.#key(event));
    document.addEventListener("visibilitychange", () => this.#resized());
  }

  /** @param {FieldMessage} field */
  setField(field) {
    this.#rays = field.rays_px.map(thin);
    this.profile.count = this.#rays.length;
    this.refresh();
  }

  /** @param {ScanMessage} scan */
  addScan(scan) {
    if (!this.#pairing.addScan(scan)) return;
    const hits = scan.entry_px.filter(Boolean).length;
    const width = scan.tape_width === null ? "" : `, tape ${millimetres(scan.tape_width, 1)} wide`;
    setText(this.#hint, `${scan.bearings.length} rays, ${hits} hits${width}`);
    this.refresh();
  }

  /** Describe the camera's picture in words for screen readers; called now and then. */
  describe() {
    const missing = this.#drawn ? "" : "No picture yet. ";
    setText(this.#text, `${missing}${this.#hint.textContent}. Arrow keys choose a ray.`);
  }

  #resized() {
    this.stream.want(this.surface.visible && !document.hidden);
    this.#drawn = null;
    this.refresh?.();
  }

  /** @param {number} now */
  #paint(now) {
    const { pair, waiting } = this.#pairing.pick(now);
    if (waiting) this.refresh();
    if (!pair || pair === this.#drawn) return;
    const fresh = pair.picture !== this.#drawn?.picture;
    this.#draw(pair);
    this.#drawn = pair;
    this.#empty.hidden = true;
    if (fresh) this.drawn(pair.picture.stamp);
  }

  /** @param {Pair} pair */
  #draw({ picture: { bitmap }, scan }) {
    const context = this.surface.begin();
    const { left, top, scale } = this.#placement(bitmap);
    context.drawImage(bitmap, left, top, bitmap.width * scale, bitmap.height * scale);
    if (scan && this.#showsRays) {
      drawOverlay(context, { left, top, scale }, this.#rays, scan, this.profile.ray);
    }
  }

  /** @param {{width: number, height: number}} picture shown as a whole, in the middle */
  #placement({ width, height }) {
    const scale = Math.min(this.surface.width / width, this.surface.height / height);
    const left = (this.surface.width - width * scale) / 2;
    return { left, top: (this.surface.height - height * scale) / 2, scale };
  }

  get #showsRays() {
    return this.#raysButton.getAttribute("aria-pressed") === "true";
  }

  #toggleRays() {
    this.#raysButton.setAttribute("aria-pressed", String(!this.#showsRays));
    this.#selected();
  }

  #toggleProfile() {
    if (this.profile.ray === null) this.profile.open(Math.floor(this.#rays.length / 2));
    else this.profile.close();
  }

  #selected() {
    this.#profileButton.setAttribute("aria-pressed", String(this.profile.ray !== null));
    this.#drawn = null;
    this.refresh();
  }

  /** @param {MouseEvent} event */
  #click(event) {
    const bitmap = this.#drawn?.picture.bitmap;
    if (!bitmap || this.#rays.length === 0) return;
    const { left, top, scale } = this.#placement(bitmap);
    const [x, y] = this.surface.locate(event);
    this.profile.open(nearestRay(this.#rays, [(x - left) / scale, (y - top) / scale]));
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const step = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
    if (step) this.profile.step(step);
    else if (event.key === "Escape") this.profile.close();
    else return;
    event.preventDefault();
  }
}
