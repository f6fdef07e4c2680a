// @ts-check
import { t } from "../../page/language.js";
import { bendBeside, bendThrough, middleOf } from "./bends.js";
import { colourOf, pathOf } from "./drawing.js";

/** @typedef {import("./bends.js").Node} Node */
/** @typedef {import("./drawing.js").Drawing} Drawing */
/** @typedef {import("./drawing.js").Stroke} Stroke */
/** @typedef {"select" | "rectangle" | "circle" | "line" | "curve" | "start"} Tool */
/** @typedef {[number, number]} Place x, y [mm], y up */
/**
 * @typedef {object} Board what the canvas draws on, and tells of changes
 * @property {Drawing} drawing @property {number} chosen the stroke, -1 is none @property {number} node
 * @property {number} grid
 * @property {(stroke: number, node?: number) => void} choose
 * @property {() => void} changing while a hand draws @property {() => void} changed when it is done
 * @property {(draws: boolean) => void} drafting
 */

const SVG = "http://www.w3.org/2000/svg";
/** A press that moves less is no drag [px]. */
const STILL = 6;
/** Presses nearer than this to a point mean it [px]. */
const NEAR = 14;
const HANDLE = 6;
const CIRCLE_BEND = Math.tan(Math.PI / 8);

/** @param {string} tag @param {Record<string, string | number>} attributes @param {...Element} children */
function draw(tag, attributes, ...children) {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  element.append(...children);
  return element;
}

/** The floor from above: draws it, and lets hand, mouse and keys change its tape. */
export class Canvas {
  /** @type {Tool} */
  #tool = "select";
  /** Corners of the tape that is being drawn. @type {Node[]} */
  #draft = [];
  /** End of a curve that lacks its middle. @type {Place | null} */
  #end = null;
  /** Where the pointer, or the keys' cross, is. @type {Place} */
  #at = [0, 0];
  #cross = false;
  /** What a press moves. @type {((place: Place, raw: Place) => void) | null} */
  #drag = null;
  /** @type {{x: number, y: number, place: Place, moved: boolean} | null} */
  #down = null;
  #zoom = 1;
  /** Middle of what is shown. @type {Place | null} */
  #middle = null;
  #frame = 0;

  /** @param {SVGSVGElement} stage @param {Board} board */
  constructor(stage, board) {
    this.stage = stage;
    this.board = board;
    stage.addEventListener("pointerdown", (event) => this.#press(event));
    stage.addEventListener("pointermove", (event) => this.#move(event));
    stage.addEventListener("pointerup", (event) => this.#release(event));
    stage.addEventListener("pointercancel", () => this.#abandon());
    stage.addEventListener("keydown", (event) => this.#key(event));
    stage.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    stage.addEventListener("blur", () => {
      this.#cross = false;
      this.show();
    });
    new ResizeObserver(() => this.show()).observe(stage);
  }

  get tool() {
    return this.#tool;
  }

  /** @param {Tool} tool */
  use(tool) {
    this.finish();
    this.#tool = tool;
    this.stage.dataset.tool = tool;
    if (tool !== "select") this.board.choose(-1);
    this.show();
  }

  get drafting() {
    return this.#draft.length > 0;
  }

  /** Take what was drawn so far as tape. @param {boolean} [closed] */
  finish(closed = false) {
    const nodes = this.#draft;
    this.#draft = [];
    this.#end = null;
    this.board.drafting(false);
    if (nodes.length > 1) this.#add(nodes, closed);
    else this.show();
  }

  /** Forget what is being drawn. */
  drop() {
    this.#draft = [];
    this.#end = null;
    this.board.drafting(false);
    this.show();
  }

  /** @param {number} factor more than 1 is nearer; 0 shows the whole floor */
  zoom(factor) {
    this.#zoom = factor === 0 ? 1 : Math.max(1, Math.min(20, this.#zoom * factor));
    if (this.#zoom === 1) this.#middle = null;
    this.show();
  }

  /** Draw it all again, once until the next picture of the screen. */
  show() {
    this.#frame ||= requestAnimationFrame(() => {
      this.#frame = 0;
      this.#show();
    });
  }

  // --- places --------------------------------------------------------------------------------

  /** Millimetres in a pixel of the screen. */
  get #pixel() {
    return 1 / (this.stage.getScreenCTM()?.a ?? 1);
  }

  /** @param {PointerEvent | WheelEvent} event @returns {Place} */
  #place({ clientX, clientY }) {
    const { x, y } = new DOMPoint(clientX, clientY).matrixTransform(this.stage.getScreenCTM()?.inverse());
    return [x, -y];
  }

  /** The place that a press means: a point of tape that is near, or one of the grid. @param {Place} raw @returns {Place} */
  #snapped(raw) {
    const near = NEAR * this.#pixel;
    const points = [...this.#draft, ...this.board.drawing.strokes.flatMap(({ nodes }) => nodes)];
    const found = points.find(([x, y]) => Math.hypot(x - raw[0], y - raw[1]) < Math.min(near, this.board.grid));
    return found ? [found[0], found[1]] : this.#onGrid(raw);
  }

  /** @param {Place} place @returns {Place} */
  #onGrid(place) {
    const { grid } = this.board;
    return /** @type {Place} */ (place.map((value) => Math.round(value / grid) * grid));
  }

  // --- a hand ----------------------------------------------------------------------------------

  /** @param {PointerEvent} event */
  #press(event) {
    if (event.button !== 0) return;
    this.stage.setPointerCapture(event.pointerId);
    this.#cross = false;
    const raw = this.#place(event);
    const place = this.#snapped(raw);
    this.#down = { x: event.clientX, y: event.clientY, place, moved: false };
    this.#at = place;
    const { part } = event.target instanceof SVGElement ? event.target.dataset : { part: undefined };
    const turns = this.#tool === "select" || this.#tool === "start";
    if (turns && (part === "start" || part === "heading")) this.#drag = this.#ofStart(part);
    else if (this.#tool === "select") this.#drag = this.#ofTape(event, raw);
    else if (this.#tool === "start") this.#put(place);
    else this.#point(place);
    this.show();
  }

  /** @param {PointerEvent} event */
  #move(event) {
    const raw = this.#place(event);
    this.#at = this.#snapped(raw);
    const down = this.#down;
    if (down && Math.hypot(event.clientX - down.x, event.clientY - down.y) > STILL) down.moved = true;
    if (down?.moved && this.#drag) {
      this.#drag(this.#onGrid(raw), raw);
      this.board.changing();
    }
    if (down || this.drafting) this.show();
  }

  /** @param {PointerEvent} event */
  #release(event) {
    const down = this.#down;
    this.#down = null;
    if (!down) return;
    if (this.#drag) {
      this.#drag = null;
      if (down.moved) this.board.changed();
    } else if (down.moved && this.drafting) this.#point(this.#snapped(this.#place(event)), true);
    this.show();
  }

  #abandon() {
    this.#down = null;
    this.#drag = null;
    this.show();
  }

  /** What a press on tape, or beside it, moves. @param {PointerEvent} event @param {Place} raw */
  #ofTape(event, raw) {
    const { board } = this;
    const data = event.target instanceof SVGElement ? event.target.dataset : {};
    const chosen = board.drawing.strokes[board.chosen];
    const index = Number(data.node);
    if (data.part === "node" && chosen) {
      board.choose(board.chosen, index);
      return (/** @type {Place} */ [x, y]) => chosen.nodes.splice(index, 1, [x, y, chosen.nodes[index][2]]);
    }
    if (data.part === "middle" && chosen) {
      const next = chosen.nodes[(index + 1) % chosen.nodes.length];
      return (/** @type {Place} */ _, /** @type {Place} */ free) =>
        (chosen.nodes[index][2] = bendBeside(chosen.nodes[index], next, free));
    }
    if (data.part === "stroke") {
      const number = Number(data.stroke);
      board.choose(number);
      const stroke = board.drawing.strokes[number];
      const before = stroke.nodes.map((node) => /** @type {Node} */ ([...node]));
      const from = this.#onGrid(raw);
      return (/** @type {Place} */ [x, y]) =>
        (stroke.nodes = before.map(([ax, ay, bend]) => [ax + x - from[0], ay + y - from[1], bend]));
    }
    board.choose(-1);
    if (this.#zoom === 1) return null;
    const middle = this.#middle ?? this.#centre;
    const { clientX, clientY } = event;
    const pixel = this.#pixel;
    const pan = (/** @type {PointerEvent} */ move) => {
      this.#middle = [middle[0] - (move.clientX - clientX) * pixel, middle[1] + (move.clientY - clientY) * pixel];
      this.show();
    };
    this.stage.addEventListener("pointermove", pan);
    addEventListener("pointerup", () => this.stage.removeEventListener("pointermove", pan), { once: true });
    return null;
  }

  /** @param {"start" | "heading"} part */
  #ofStart(part) {
    return (/** @type {Place} */ place, /** @type {Place} */ raw) => {
      const { start } = this.board.drawing;
      if (part === "start") [start[0], start[1]] = place;
      else start[2] = heading(start, raw);
    };
  }

  /** Put the robot's start somewhere; a drag turns it. @param {Place} place */
  #put(place) {
    const { start } = this.board.drawing;
    [start[0], start[1]] = place;
    this.#drag = this.#ofStart("heading");
    this.board.changed();
  }

  /** A point of what is being drawn. @param {Place} place @param {boolean} [dragged] whether a drag ends there */
  #point(place, dragged = false) {
    const from = this.#draft.at(-1);
    if (!from) {
      this.#draft = [[...place, 0]];
      this.board.drafting(true);
    } else if (this.#tool === "rectangle" || this.#tool === "circle") this.#shape(from, place);
    else if (this.#tool === "curve") this.#curve(from, place);
    else this.#line(from, place, dragged);
    this.show();
  }

  /** @param {Node} from @param {Place} to @param {boolean} dragged */
  #line(from, to, dragged) {
    if (same(from, to)) return dragged || this.finish();
    if (this.#draft.length > 2 && same(this.#draft[0], to)) return this.finish(true);
    this.#draft.push([...to, 0]);
  }

  /** @param {Node} from @param {Place} place */
  #curve(from, place) {
    if (!this.#end) {
      if (same(from, place)) return this.finish();
      this.#end = place;
      return;
    }
    const end = this.#end;
    this.#end = null;
    from[2] = bendThrough(from, [...end, 0], place);
    if (this.#draft.length > 1 && same(this.#draft[0], end)) return this.finish(true);
    this.#draft.push([...end, 0]);
  }

  /** @param {Node} from @param {Place} to */
  #shape(from, to) {
    const [[ax, ay], [bx, by]] = [from, to];
    const round = this.#tool === "circle";
    const radius = Math.hypot(bx - ax, by - ay);
    if (round ? radius < 1 : ax === bx || ay === by) return;
    this.#draft = [];
    this.board.drafting(false);
    this.#add(round ? circle(from, radius) : rectangle(from, to), true);
  }

  /** @param {Node[]} nodes @param {boolean} closed */
  #add(nodes, closed) {
    const { drawing } = this.board;
    const grey = drawing.floor < 128 ? 235 : 34;
    drawing.strokes.push({ nodes, closed, width: drawing.tape, grey, dashes: [] });
    this.board.choose(drawing.strokes.length - 1);
    this.board.changed();
  }

  // --- keys and wheel --------------------------------------------------------------------------

  /** @param {KeyboardEvent} event */
  #key(event) {
    const step = event.shiftKey ? 1 : this.board.grid;
    /** @type {Record<string, Place>} */
    const ways = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] };
    const way = ways[event.key];
    if (way) this.#shift(way);
    else if (event.key === "Enter") this.#enter();
    else if (event.key === "PageDown" || event.key === "PageUp") this.#next(event.key === "PageDown" ? 1 : -1);
    else return;
    event.preventDefault();
    this.show();
  }

  /** @param {Place} way */
  #shift([dx, dy]) {
    const { board } = this;
    const stroke = board.drawing.strokes[board.chosen];
    if (this.#tool === "select" && stroke) {
      stroke.nodes = stroke.nodes.map(([x, y, bend], i) =>
        board.node < 0 || board.node === i ? [x + dx, y + dy, bend] : [x, y, bend],
      );
      return board.changed();
    }
    this.#cross = true;
    const { left, bottom, width, height } = board.drawing;
    const [x, y] = this.#at;
    this.#at = [Math.max(left, Math.min(left + width, x + dx)), Math.max(bottom, Math.min(bottom + height, y + dy))];
  }

  #enter() {
    if (this.#tool === "select") return;
    if (!this.#cross && this.drafting) return this.finish();
    this.#cross = true;
    if (this.#tool === "start") {
      this.#put(this.#at);
      this.#drag = null;
    } else this.#point(this.#at);
  }

  /** Choose the next tape. @param {number} step */
  #next(step) {
    const count = this.board.drawing.strokes.length;
    if (count) this.board.choose((this.board.chosen + step + count) % count);
  }

  /** @param {WheelEvent} event */
  #wheel(event) {
    event.preventDefault();
    const under = this.#place(event);
    const before = this.#zoom;
    this.zoom(event.deltaY < 0 ? 1.2 : 1 / 1.2);
    if (this.#zoom === 1 || this.#zoom === before) return;
    const centre = this.#middle ?? this.#centre;
    const share = 1 - before / this.#zoom;
    this.#middle = [centre[0] + (under[0] - centre[0]) * share, centre[1] + (under[1] - centre[1]) * share];
  }

  // --- drawing ---------------------------------------------------------------------------------

  /** @returns {Place} */
  get #centre() {
    const { left, bottom, width, height } = this.board.drawing;
    return [left + width / 2, bottom + height / 2];
  }

  #show() {
    const { drawing, chosen } = this.board;
    const { left, bottom, width, height, floor, fills, strokes } = drawing;
    const margin = 0.03 * Math.max(width, height);
    const [x, y] = this.#middle ?? this.#centre;
    const [wide, high] = [(width + 2 * margin) / this.#zoom, (height + 2 * margin) / this.#zoom];
    this.stage.setAttribute("viewBox", `${x - wide / 2} ${-y - high / 2} ${wide} ${high}`);
    const pixel = this.#pixel;
    const up = draw("g", { transform: "scale(1 -1)", fill: "none" });
    up.append(draw("rect", { x: left, y: bottom, width, height, fill: colourOf(floor) }));
    up.append(...this.#gridLines(pixel));
    for (const { rings, grey, opacity } of fills) {
      const d = rings.map((ring) => `M ${ring.map((place) => place.join(" ")).join(" L ")} Z`).join(" ");
      up.append(draw("path", { d, fill: colourOf(grey), "fill-rule": "evenodd", "fill-opacity": opacity }));
    }
    strokes.forEach((stroke, i) => up.append(...this.#tape(stroke, i, i === chosen, pixel)));
    up.append(...this.#drawDraft(pixel), this.#robot(pixel));
    if (strokes[chosen] && this.#tool === "select") up.append(...this.#handles(strokes[chosen], pixel));
    if (this.#cross && this.#tool !== "select") up.append(this.#crossing(pixel));
    this.stage.replaceChildren(up, ...this.#lengths(pixel));
  }

  /** @param {number} pixel */
  *#gridLines(pixel) {
    const { left, bottom, width, height } = this.board.drawing;
    // A grid that is finer than can be seen is none.
    let step = this.board.grid;
    while (step < 12 * pixel) step *= step.toString().startsWith("5") ? 2 : 5;
    let d = "";
    for (let x = Math.ceil(left / step) * step; x <= left + width; x += step) d += `M ${x} ${bottom} v ${height} `;
    for (let y = Math.ceil(bottom / step) * step; y <= bottom + height; y += step) d += `M ${left} ${y} h ${width} `;
    yield draw("path", { d, class: "grid", "stroke-width": 0.5 * pixel });
  }

  /** @param {Stroke} stroke @param {number} number @param {boolean} chosen @param {number} pixel */
  *#tape(stroke, number, chosen, pixel) {
    const d = pathOf(stroke);
    if (chosen) yield draw("path", { d, class: "chosen", "stroke-width": stroke.width + 8 * pixel });
    yield draw("path", { d, stroke: colourOf(stroke.grey), "stroke-width": stroke.width, "stroke-dasharray": stroke.dashes.join(" ") || "none" });
    const data = { "data-part": "stroke", "data-stroke": number };
    yield draw("path", { d, class: "hit", "stroke-width": Math.max(stroke.width, 24 * pixel), ...data });
  }

  /** @param {Stroke} stroke @param {number} pixel */
  *#handles({ nodes, closed }, pixel) {
    const size = matchMedia("(pointer: coarse)").matches ? 1.6 * HANDLE : HANDLE;
    const last = closed ? nodes.length : nodes.length - 1;
    for (let i = 0; i < last; i++) {
      const [cx, cy] = middleOf(nodes[i], nodes[(i + 1) % nodes.length]);
      yield draw("circle", { cx, cy, r: size * 0.8 * pixel, class: "middle", "stroke-width": 2 * pixel, "data-part": "middle", "data-node": i });
    }
    for (const [i, [cx, cy]] of nodes.entries()) {
      const kind = i === this.board.node ? "node now" : "node";
      yield draw("circle", { cx, cy, r: size * pixel, class: kind, "stroke-width": 2 * pixel, "data-part": "node", "data-node": i });
    }
  }

  /** What is being drawn, as far as it is. @param {number} pixel */
  *#drawDraft(pixel) {
    const from = this.#draft.at(-1);
    if (!from) return;
    const { tape } = this.board.drawing;
    const at = this.#at;
    let nodes = [...this.#draft, /** @type {Node} */ ([...at, 0])];
    let closed = false;
    if (this.#tool === "rectangle") [nodes, closed] = [rectangle(from, at), true];
    if (this.#tool === "circle") [nodes, closed] = [circle(from, Math.hypot(at[0] - from[0], at[1] - from[1])), true];
    if (this.#tool === "curve" && this.#end) {
      const bend = bendThrough(from, [...this.#end, 0], at);
      nodes = [...this.#draft.slice(0, -1), [from[0], from[1], bend], [...this.#end, 0]];
    }
    yield draw("path", { d: pathOf({ nodes, closed, width: tape, grey: 0, dashes: [] }), class: "draft", "stroke-width": tape });
    for (const [cx, cy] of this.#draft) yield draw("circle", { cx, cy, r: 4 * pixel, class: "node", "stroke-width": 2 * pixel });
  }

  /** How long what is being drawn is, in words. @param {number} pixel */
  *#lengths(pixel) {
    const from = this.#draft.at(-1);
    if (!from || (this.#tool === "curve" && this.#end)) return;
    const [dx, dy] = [this.#at[0] - from[0], this.#at[1] - from[1]];
    const length = Math.round(Math.hypot(dx, dy));
    const words = this.#tool === "rectangle" ? `${Math.abs(dx)} × ${Math.abs(dy)} mm` : this.#tool === "circle" ? t("radius {length} mm", { length }) : `${length} mm`;
    const text = draw("text", { x: this.#at[0] + 12 * pixel, y: -this.#at[1] - 10 * pixel, "font-size": 15 * pixel, class: "length", "stroke-width": 4 * pixel });
    text.textContent = words;
    yield text;
  }

  /** The robot at its start: an arrow, whose head turns it. @param {number} pixel */
  #robot(pixel) {
    const [x, y, turn] = this.board.drawing.start;
    const reach = Math.max(110, 34 * pixel);
    return draw(
      "g", { transform: `translate(${x} ${y}) rotate(${turn})`, class: "robot" },
      draw("circle", { r: Math.max(28, 12 * pixel), "stroke-width": 2 * pixel, "data-part": "start" }),
      draw("path", { d: `M 0 0 H ${reach}`, "stroke-width": 3 * pixel, class: "arm" }),
      draw("path", { d: `M ${reach + 16 * pixel} 0 l ${-20 * pixel} ${10 * pixel} v ${-20 * pixel} Z`, "data-part": "heading" }),
      draw("circle", { cx: reach, r: 16 * pixel, class: "hit", "data-part": "heading" }),
    );
  }

  /** @param {number} pixel */
  #crossing(pixel) {
    const [x, y] = this.#at;
    const arm = 14 * pixel;
    return draw("path", { d: `M ${x - arm} ${y} h ${2 * arm} M ${x} ${y - arm} v ${2 * arm}`, class: "cross", "stroke-width": 2 * pixel });
  }
}

/** @param {number[]} a @param {number[]} b */
const same = ([ax, ay], [bx, by]) => Math.hypot(ax - bx, ay - by) < 0.5;

/** @param {number[]} from @param {Place} to [degrees], in steps of 5 */
const heading = ([x, y], [toX, toY]) => Math.round((Math.atan2(toY - y, toX - x) * 180) / Math.PI / 5) * 5 + 0;

/** @param {number[]} from @param {number[]} to @returns {Node[]} */
const rectangle = ([ax, ay], [bx, by]) => [[ax, ay, 0], [bx, ay, 0], [bx, by, 0], [ax, by, 0]];

/** @param {number[]} middle @param {number} r @returns {Node[]} */
const circle = ([x, y], r) =>
  [[r, 0], [0, r], [-r, 0], [0, -r]].map(([dx, dy]) => [x + dx, y + dy, CIRCLE_BEND]);
