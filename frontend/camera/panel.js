// @ts-check
import { t, tn } from "../page/language.js";
import { find, findButton, setText } from "../page/elements.js";
import { Surface } from "../page/surface.js";
import { millimetres } from "../page/format.js";
import { FloorGrid } from "./floor_grid.js";
import { drawOverlay, nearestRay, thin } from "./overlay.js";
import { CameraStream } from "./stream.js";

/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../page/draw_loop.js").DrawLoop} DrawLoop */
/** @typedef {import("./overlay.js").Point} Point */
/** @typedef {import("./profile.js").RayProfile} RayProfile */
/** @typedef {import("./stream.js").Picture} Picture */

/** The live picture, what the scanner found in it, and the profile of one ray. */
export class CameraPanel {
  #hint = find("camera-hint", HTMLElement);
  #text = find("camera-text", HTMLElement);
  #empty = find("camera-empty", HTMLElement);
  #raysButton = findButton("camera-rays");
  #profileButton = findButton("camera-profile");
  /** The profile of one ray; loaded when it is first opened. @type {RayProfile | null} */
  profile = null;
  /** @type {Point[][]} */
  #rays = [];
  /** @type {Picture | null} */
  #picture = null;
  /** Whether the picture was never drawn. */
  #fresh = false;

  /**
   * @param {DrawLoop} loop
   * @param {(stamp: number) => void} drawn called when a new picture is on the screen
   */
  constructor(loop, drawn) {
    this.loop = loop;
    this.drawn = drawn;
    const canvas = find("camera-canvas", HTMLCanvasElement);
    this.surface = new Surface(canvas, () => this.#resized());
    this.refresh = loop.add(() => this.#paint(), { visible: () => this.surface.visible });
    this.stream = new CameraStream("api/camera", (picture) => this.#show(picture));
    this.grid = new FloorGrid(() => this.refresh());
    this.#raysButton.onclick = () => this.#toggleRays();
    this.#profileButton.onclick = () => this.#toggleProfile();
    canvas.addEventListener("click", (event) => this.#click(event));
    canvas.addEventListener("keydown", (event) => this.#key(event));
    document.addEventListener("visibilitychange", () => this.#resized());
  }

  /** @param {FieldMessage} field */
  setField(field) {
    this.#rays = field.rays_px.map(thin);
    if (this.profile) this.profile.count = this.#rays.length;
    this.grid.load();
  }

  /** @param {Picture} picture */
  #show(picture) {
    this.#picture?.bitmap.close();
    this.#picture = picture;
    this.#fresh = true;
    this.#empty.hidden = true;
    this.refresh();
    if (!picture.edges) return;
    const { entry_px, tape_width } = picture.edges;
    const hits = entry_px.filter(Boolean).length;
    const rays = tn("{count} ray", "{count} rays", entry_px.length);
    const found = tn("{count} hit", "{count} hits", hits);
    const width = millimetres(tape_width, 1);
    setText(
      this.#hint,
      tape_width === null ? `${rays}, ${found}` : t("{rays}, {found}, tape {width} wide", { rays, found, width }),
    );
  }

  /** Describe the camera's picture in words for screen readers; called now and then. */
  describe() {
    const seen = this.#picture ? `${this.#hint.textContent}.` : t("No picture yet.");
    setText(this.#text, `${seen} ${t("Arrow keys choose a ray.")}`);
  }

  #resized() {
    this.stream.want(this.surface.visible && !document.hidden);
    this.refresh?.();
  }

  #paint() {
    if (!this.#picture) return;
    const { stamp, bitmap, edges } = this.#picture;
    const context = this.surface.begin();
    const placement = this.#placement(bitmap);
    const { left, top, scale } = placement;
    context.drawImage(bitmap, left, top, bitmap.width * scale, bitmap.height * scale);
    this.grid.draw(context, placement, bitmap);
    if (edges && this.#showsRays) {
      drawOverlay(context, placement, this.#rays, edges, this.#ray);
    }
    if (this.#fresh) this.drawn(stamp);
    this.#fresh = false;
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
    if (this.#ray === null) this.#withProfile((profile) => profile.open(Math.floor(this.#rays.length / 2)));
    else this.profile?.close();
  }

  /** The ray that is looked at closely. */
  get #ray() {
    return this.profile?.ray ?? null;
  }

  /** @param {(profile: RayProfile) => void} act */
  async #withProfile(act) {
    if (this.#profileButton.hasAttribute("data-absent")) return;
    const { RayProfile } = await import("./profile.js");
    this.profile ??= new RayProfile(this.loop, () => this.#selected());
    this.profile.count = this.#rays.length;
    act(this.profile);
  }

  #selected() {
    this.#profileButton.setAttribute("aria-pressed", String(this.#ray !== null));
    this.refresh();
  }

  /** @param {MouseEvent} event */
  #click(event) {
    const bitmap = this.#picture?.bitmap;
    if (!bitmap || this.#rays.length === 0) return;
    const { left, top, scale } = this.#placement(bitmap);
    const [x, y] = this.surface.locate(event);
    const ray = nearestRay(this.#rays, [(x - left) / scale, (y - top) / scale]);
    this.#withProfile((profile) => profile.open(ray));
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const step = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
    if (step) this.#withProfile((profile) => profile.step(step));
    else if (event.key === "Escape") this.profile?.close();
    else return;
    event.preventDefault();
  }
}
