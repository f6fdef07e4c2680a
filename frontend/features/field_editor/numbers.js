// @ts-check
import { find, findInput, make } from "../../page/elements.js";
import { plain, readNumber } from "../../page/format.js";
import { t } from "../../page/language.js";
import { bendOf, degreesOf, roundedCorners } from "./bends.js";
import { FLOOR, LOOKS, TAPE } from "./drawing.js";

/** @typedef {import("./canvas.js").Board} Board */
/** @typedef {{low: number, high: number, unit: string}} Limits */

const MM = { low: -20_000, high: 20_000, unit: "mm" };

/**
 * A field for a number, with a decimal point or comma; what is none is said, and the old one comes back.
 * @param {string} label @param {Limits} limits @param {() => number} read @param {(value: number) => void} write
 */
function numberField(label, { low, high, unit }, read, write) {
  const input = /** @type {HTMLInputElement} */ (
    make("input", { type: "text", inputmode: "decimal", autocomplete: "off", "aria-label": `${label} [${unit}]` })
  );
  const show = () => {
    if (document.activeElement !== input) input.value = written(read());
  };
  input.onchange = () => {
    const value = readNumber(input.value);
    if (value >= low && value <= high) {
      input.setCustomValidity("");
      write(value);
    } else {
      input.setCustomValidity(t("Valid is {low} to {high}.", { low, high }));
      input.reportValidity();
      input.setCustomValidity("");
    }
    input.value = written(read());
  };
  show();
  return { input, show };
}

/** @param {number} value */
const written = (value) => plain(value, String(Number(Math.abs(value).toFixed(2))).split(".")[1]?.length ?? 0);

/** The drawing in numbers: floor, tape, start, and the chosen tape's nodes. */
export class Numbers {
  #floor = find("floor-fields", HTMLElement);
  #start = find("start-fields", HTMLElement);
  #strip = find("strip", HTMLElement);
  #stripFields = find("strip-fields", HTMLElement);
  #nodes = find("nodes", HTMLElement);
  #closed = findInput("closed");
  #look = find("tape-look", HTMLSelectElement);
  /** @type {(() => void)[]} */
  #shows = [];
  /** Which nodes stand in the table. */
  #listed = "";
  /** @type {(() => void)[]} */
  #nodeShows = [];

  /** @param {Board} board */
  constructor(board) {
    this.board = board;
    this.#row(this.#floor, t("width"), { low: FLOOR[0], high: FLOOR[1], unit: "mm" }, () => board.drawing.width, (value) => {
      board.drawing.left -= (value - board.drawing.width) / 2;
      board.drawing.width = value;
    });
    this.#row(this.#floor, t("height"), { low: FLOOR[0], high: FLOOR[1], unit: "mm" }, () => board.drawing.height, (value) => {
      board.drawing.bottom -= (value - board.drawing.height) / 2;
      board.drawing.height = value;
    });
    this.#row(this.#floor, t("tape width"), { low: TAPE[0], high: TAPE[1], unit: "mm" }, () => board.drawing.tape, (value) => {
      // As in a class: there is one roll of tape.
      for (const stroke of board.drawing.strokes) if (stroke.width === board.drawing.tape) stroke.width = value;
      board.drawing.tape = value;
    });
    ["x", "y"].forEach((name, i) =>
      this.#row(this.#start, name, MM, () => board.drawing.start[i], (value) => (board.drawing.start[i] = value)),
    );
    this.#row(this.#start, t("heading"), { low: -360, high: 360, unit: "°" }, () => board.drawing.start[2], (value) => (board.drawing.start[2] = value));
    this.#row(this.#stripFields, t("width of this tape"), { low: TAPE[0], high: TAPE[1], unit: "mm" }, () => this.#chosen?.width ?? 50, (value) => {
      if (this.#chosen) this.#chosen.width = value;
    });
    this.#row(this.#stripFields, t("round its corners"), { low: 0, high: 10_000, unit: "mm" }, () => 0, (value) => {
      if (this.#chosen && value) this.#chosen.nodes = roundedCorners(this.#chosen.nodes, this.#chosen.closed, value);
    });
    this.#closed.onchange = () => {
      if (this.#chosen) this.#chosen.closed = this.#closed.checked;
      board.changed();
    };
    this.#look.onchange = () => {
      const look = LOOKS[this.#look.value === "light" ? "light" : "dark"];
      board.drawing.floor = look.floor;
      for (const stroke of board.drawing.strokes) stroke.grey = look.tape;
      board.changed();
    };
  }

  get #chosen() {
    return this.board.drawing.strokes[this.board.chosen];
  }

  /** Show the numbers as they are now. */
  show() {
    for (const show of this.#shows) show();
    this.#look.value = this.board.drawing.floor < 128 ? "light" : "dark";
    const stroke = this.#chosen;
    this.#strip.hidden = !stroke;
    if (!stroke) return;
    this.#closed.checked = stroke.closed;
    const listed = `${this.board.chosen} ${stroke.nodes.length}`;
    if (listed !== this.#listed) this.#list(listed);
    for (const show of this.#nodeShows) show();
    [...this.#nodes.children].forEach((row, i) => row.toggleAttribute("data-now", i === this.board.node));
  }

  /** @param {string} listed */
  #list(listed) {
    this.#listed = listed;
    this.#nodeShows = [];
    const rows = (this.#chosen?.nodes ?? []).map((_, i) => this.#nodeRow(i));
    this.#nodes.replaceChildren(...rows);
  }

  /** @param {number} i */
  #nodeRow(i) {
    const { board } = this;
    const node = () => this.#chosen?.nodes[i] ?? [0, 0, 0];
    const number = i + 1;
    const columns = [
      numberField(t("x of point {number}", { number }), MM, () => node()[0], (value) => this.#write(() => (node()[0] = value))),
      numberField(t("y of point {number}", { number }), MM, () => node()[1], (value) => this.#write(() => (node()[1] = value))),
      numberField(t("bend after point {number}", { number }), { low: -270, high: 270, unit: "°" }, () => degreesOf(node()[2]), (value) => this.#write(() => (node()[2] = bendOf(value)))),
    ];
    for (const { input, show } of columns) {
      this.#nodeShows.push(show);
      input.onfocus = () => board.choose(board.chosen, i);
    }
    const remove = make("button", { type: "button", "aria-label": t("Remove point {number}", { number }) }, "×");
    remove.onclick = () =>
      this.#write(() => {
        const { nodes = [] } = this.#chosen ?? {};
        if (nodes.length > 2) nodes.splice(i, 1);
      });
    return make("tr", {}, ...columns.map(({ input }) => make("td", {}, input)), make("td", {}, remove));
  }

  /** @param {() => void} change */
  #write(change) {
    change();
    this.board.changed();
  }

  /** @param {HTMLElement} list @param {string} label @param {Limits} limits @param {() => number} read @param {(value: number) => void} write */
  #row(list, label, limits, read, write) {
    const { input, show } = numberField(label, limits, read, (value) => this.#write(() => write(value)));
    const words = make("span", { "aria-hidden": "true" }, label, " ", make("span", { class: "unit" }, limits.unit));
    list.append(words, input);
    this.#shows.push(show);
  }
}
