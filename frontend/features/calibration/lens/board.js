// @ts-check
import { t } from "../../../page/language.js";
import { DecimalField } from "../../../page/decimal.js";
import { find, findButton, findInput, setText } from "../../../page/elements.js";
import { brief } from "../../../page/format.js";

/** @typedef {import("../../../messages").BoardMessage} BoardMessage */
/** @typedef {import("../../../messages").LensStartRequest} LensStartRequest */
/** @typedef {import("../../../messages").LensStatusMessage} LensStatusMessage */

/** The board that is looked for. */
export class BoardForm {
  #form = find("board", HTMLFormElement);
  #kind = find("board-kind", HTMLSelectElement);
  #dictionary = find("board-dictionary", HTMLSelectElement);
  #paper = find("board-paper", HTMLSelectElement);
  #print = find("board-print", HTMLAnchorElement);
  #numbers = {
    columns: findInput("board-columns"),
    rows: findInput("board-rows"),
    square: new DecimalField("board-square"),
    marker: new DecimalField("board-marker"),
  };
  #details = find("board-fields", HTMLDetailsElement);
  #words = find("board-words", HTMLElement);
  #start = findButton("start");
  /** The board that was looked for in the last status, as JSON. */
  #shown = "null";
  /** The board that this page asked for, as JSON, until its first picture. */
  #asked = "";

  /** @param {(request: LensStartRequest) => void} start */
  constructor(start) {
    this.#form.onsubmit = (event) => {
      event.preventDefault();
      start({ type: "start", board: this.board });
      this.#asked = JSON.stringify(this.board);
    };
    this.#form.oninput = () => this.#show();
    this.#show();
  }

  /** @returns {BoardMessage} in metres and shares */
  get board() {
    const { columns, rows, square, marker } = this.#numbers;
    return {
      kind: this.#kind.value,
      columns: Math.round(columns.valueAsNumber),
      rows: Math.round(rows.valueAsNumber),
      square: square.value / 1000,
      marker: marker.value / 100,
      dictionary: this.#dictionary.value,
    };
  }

  /** Show the board that is looked for. @param {LensStatusMessage} status */
  follow({ board, taken }) {
    setText(this.#start, taken ? t("Start anew") : t("Start"));
    const key = JSON.stringify(board);
    // Folded only when it is looked for: a board that is refused has to be mended.
    if (key === this.#asked && taken === 0) this.#details.open = false;
    if (taken > 0) this.#asked = "";
    if (key === this.#shown) return;
    this.#shown = key;
    this.#details.open = board === null;
    setText(this.#words, board === null ? "" : inWords(board));
    if (board === null) return;
    const filled = { ...this.board, ...board };
    this.#kind.value = filled.kind ?? "";
    this.#dictionary.value = filled.dictionary ?? "";
    const { columns, rows, square, marker } = this.#numbers;
    columns.value = String(filled.columns);
    rows.value = String(filled.rows);
    square.value = (filled.square ?? 0) * 1000;
    marker.value = (filled.marker ?? 0) * 100;
    this.#show();
  }

  #show() {
    for (const part of this.#form.querySelectorAll("[data-charuco]")) {
      part.toggleAttribute("hidden", this.#kind.value !== "charuco");
    }
    const query = new URLSearchParams({ paper: this.#paper.value });
    for (const [name, value] of Object.entries(this.board)) query.set(name, String(value));
    this.#print.href = `api/board.pdf?${query}`;
  }
}

/** @param {BoardMessage} board */
function inWords({ kind, columns, rows, square }) {
  return t("{kind}, {columns} × {rows} squares of {side} mm", {
    kind: kind ?? "",
    columns: columns ?? 0,
    rows: rows ?? 0,
    side: brief((square ?? 0) * 1000),
  });
}
