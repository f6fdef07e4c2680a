// @ts-check
import { find, findButton, findInput, setText } from "../page/elements.js";

/** @typedef {import("../messages").BoardMessage} BoardMessage */
/** @typedef {import("../messages").LensStartRequest} LensStartRequest */
/** @typedef {import("../messages").LensStatusMessage} LensStatusMessage */

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
    square: findInput("board-square"),
    marker: findInput("board-marker"),
  };
  /** Whether the fields show what the server looks for. */
  #filled = false;

  /** @param {(request: LensStartRequest) => void} start */
  constructor(start) {
    this.#form.onsubmit = (event) => {
      event.preventDefault();
      start({ type: "start", board: this.board });
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
      square: square.valueAsNumber / 1000,
      marker: marker.valueAsNumber / 100,
      dictionary: this.#dictionary.value,
    };
  }

  /** Show the board that is looked for already. @param {LensStatusMessage} status */
  follow({ board, taken }) {
    setText(findButton("start"), board === null ? "Start" : taken ? "Start anew" : "Start");
    if (this.#filled || board === null) return;
    this.#filled = true;
    const filled = { ...this.board, ...board };
    this.#kind.value = filled.kind ?? "";
    this.#dictionary.value = filled.dictionary ?? "";
    const { columns, rows, square, marker } = this.#numbers;
    columns.value = String(filled.columns);
    rows.value = String(filled.rows);
    square.value = String(+((filled.square ?? 0) * 1000).toFixed(3));
    marker.value = String(+((filled.marker ?? 0) * 100).toFixed(3));
    this.#show();
  }

  #show() {
    for (const part of this.#form.querySelectorAll("[data-charuco]")) {
      part.toggleAttribute("hidden", this.#kind.value !== "charuco");
    }
    const query = new URLSearchParams({ paper: this.#paper.value });
    for (const [name, value] of Object.entries(this.board)) query.set(name, String(value));
    this.#print.href = `/api/board.pdf?${query}`;
  }
}
