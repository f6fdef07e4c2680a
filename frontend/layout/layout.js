// @ts-check
import { find } from "../page/elements.js";
import { Borders } from "./borders.js";
import { COMPACT, READY, read, written } from "./layouts.js";
import { addHandles } from "./handles.js";
import { added, boxesOf, neighbour, panelsOf, swapped, without } from "./tree.js";

/** @typedef {import("./tree.js").Tree} Tree */
/** @typedef {import("./layouts.js").ReadyName} ReadyName */

const KEPT = "brickpose.layout";
const LINK = "#layout=";
/** Below this width of the window fewer panels are shown at first [CSS px]. */
const NARROW = 1000;

/** Where the panels are on a wide screen; on a phone they are tabs (style/phone.css). */
export class Layout {
  #main = find("main", HTMLElement);
  #panels = new Map(
    [...this.#main.querySelectorAll(":scope > .panel")].map((panel) => [
      panel.id,
      /** @type {HTMLElement} */ (panel),
    ]),
  );
  #borders = new Borders(this.#main, (tree) => this.change(tree));
  /** @type {Set<() => void>} */
  #listeners = new Set();
  /** @type {string | null} */
  #enlarged = null;
  /** @type {Tree} */
  #tree = READY.simple;

  /** @param {(text: string) => void} complain */
  constructor(complain) {
    this.complain = complain;
    for (const [name, panel] of this.#panels) addHandles(this, name, panel);
    addEventListener("hashchange", () => this.#follow());
    document.addEventListener("keydown", (event) => this.escape(event));
    this.#tree = this.#kept() ?? this.#usual();
    this.#apply();
    this.#follow();
  }

  get tree() {
    return this.#tree;
  }

  /** Names and titles of all panels. @returns {[string, string][]} */
  get panels() {
    return [...this.#panels].map(([name, panel]) => [name, panel.querySelector("h2")?.textContent ?? name]);
  }

  /** The ready layout that is shown, unless it was changed. @returns {ReadyName | null} */
  get ready() {
    const text = written(this.#tree);
    const names = /** @type {ReadyName[]} */ (Object.keys(READY));
    return names.find((name) => written(this.#readied(name)) === text) ?? null;
  }

  /** A link that shows this layout. */
  get link() {
    return `${location.origin}${location.pathname}${LINK}${encodeURIComponent(written(this.#tree))}`;
  }

  /** @param {() => void} listener called after each change */
  onChange(listener) {
    this.#listeners.add(listener);
  }

  /** @param {Tree} tree */
  change(tree) {
    this.#tree = tree;
    this.#keep();
    this.#apply();
  }

  /** @param {ReadyName} name */
  choose(name) {
    this.#enlarged = null;
    this.change(this.#readied(name));
  }

  /** Show a layout from a file or link; if it is none, say why. @param {string} text */
  open(text) {
    try {
      this.#enlarged = null;
      this.change(read(text, [...this.#panels.keys()]));
    } catch (error) {
      this.complain(error instanceof Error ? error.message : String(error));
    }
  }

  /** @param {string} name */
  shows(name) {
    return panelsOf(this.#tree).includes(name);
  }

  /** Show a panel, or hide it; the last one stays. @param {string} name @param {boolean} shown */
  show(name, shown) {
    if (this.#enlarged !== null) this.#enlarged = null;
    this.change(shown ? added(this.#tree, name) : (without(this.#tree, name) ?? this.#tree));
  }

  /** Show some panels besides those of a ready layout, where they belong, or hide them. @param {string[]} names @param {boolean} shown */
  showAll(names, shown) {
    const wanted = panelsOf(this.#tree).filter((name) => shown || !names.includes(name));
    if (shown) wanted.push(...names);
    const has = (/** @type {Tree} */ tree) => panelsOf(tree).every((name) => wanted.includes(name));
    const drive = panelsOf(READY.drive);
    // What is there may be at any place: then only the newcomers get one.
    const placed = this.ready === "simple" || written(this.#tree) === written(this.#only(panelsOf(this.#tree)));
    this.#enlarged = null;
    if (!placed || !wanted.every((name) => drive.includes(name))) {
      for (const name of names) this.show(name, shown);
    } else if (has(READY.simple) && wanted.length === panelsOf(READY.simple).length) this.choose("simple");
    else this.change(this.#only(wanted));
  }

  /** The layout for driving, with some of its panels. @param {string[]} names @returns {Tree} */
  #only(names) {
    const others = panelsOf(READY.drive).filter((name) => !names.includes(name));
    return others.reduce((/** @type {Tree} */ tree, name) => without(tree, name) ?? tree, READY.drive);
  }

  /** Exchange two panels. @param {string} name @param {string} other */
  swap(name, other) {
    this.change(swapped(this.#tree, name, other));
  }

  /** @param {string} name @param {Parameters<typeof neighbour>[2]} way */
  swapTowards(name, way) {
    const other = neighbour(this.#tree, name, way);
    if (other !== null) this.swap(name, other);
  }

  /** Let a panel have all the room, or give it back. @param {string} name */
  enlarge(name) {
    this.#enlarged = this.#enlarged === name ? null : name;
    this.#apply();
  }

  /** Escape gives the room back, unless it was meant for something else. @param {KeyboardEvent} event */
  escape(event) {
    if (event.key !== "Escape" || event.defaultPrevented || this.#enlarged === null) return;
    const panel = this.#panels.get(this.#enlarged);
    this.enlarge(this.#enlarged);
    /** @type {HTMLElement | null | undefined} */ (panel?.querySelector(".enlarge"))?.focus();
  }

  #usual() {
    return this.#readied(innerWidth < NARROW ? "compact" : "simple");
  }

  /** Without WebGL there is nothing to see in 3D. @param {ReadyName | "compact"} name @returns {Tree} */
  #readied(name) {
    const tree = name === "compact" ? COMPACT : READY[name];
    const seen = document.documentElement.dataset.webgl !== "none";
    return (seen ? null : without(tree, "view")) ?? tree;
  }

  #apply() {
    const boxes = this.#enlarged === null ? boxesOf(this.#tree) : boxesOf(this.#enlarged);
    for (const [name, panel] of this.#panels) {
      const box = boxes.get(name);
      panel.toggleAttribute("data-away", !box);
      panel.dataset.large = String(this.#enlarged === name);
      for (const [side, share] of Object.entries(box ?? {})) {
        panel.style.setProperty(`--${side}`, String(share));
      }
    }
    this.#borders.show(this.#enlarged === null ? this.#tree : this.#enlarged);
    this.#main.dataset.laid = "true";
    document.body.toggleAttribute("data-without-drive", !boxes.has("drive"));
    for (const listener of this.#listeners) listener();
  }

  /** Show the layout of the page's link. */
  #follow() {
    if (!location.hash.startsWith(LINK)) return;
    this.open(unescaped(location.hash.slice(LINK.length)));
    // From now on the layout is this browser's own.
    history.replaceState(null, "", location.pathname + location.search);
  }

  #keep() {
    try {
      localStorage.setItem(KEPT, written(this.#tree));
    } catch {
      // Storage is switched off: the layout lasts until the page is closed.
    }
  }

  /** @returns {Tree | null} */
  #kept() {
    try {
      const text = localStorage.getItem(KEPT);
      return text ? read(text, [...this.#panels.keys()]) : null;
    } catch {
      return null;
    }
  }
}

/** A link's text; as it is, where it is cut off. @param {string} text */
function unescaped(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}
