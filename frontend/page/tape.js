// @ts-check
import { t } from "./language.js";
import { find, setText } from "./elements.js";
import { millimetres, plain } from "./format.js";

/** @typedef {import("../messages").FieldMessage} FieldMessage */
/** @typedef {import("../messages").ScanMessage} ScanMessage */

/** The median over this many pictures is shown: the width in a single picture is noisy. */
const PICTURES = 15;
/** With a larger difference from the drawn width [m], the camera is not mounted as described. */
const MOST_OFF = 0.001;

/**
 * The measured width of the tape. If the camera's pitch differs by half a degree from the
 * description, this width is wrong by two millimetres, and the ranges by six times as much.
 */
export class TapeHealth {
  #row = find("tape", HTMLElement);
  #measured = find("stat-tape", HTMLElement);
  #drawn = find("stat-tape-drawn", HTMLElement);
  /** @type {number[]} */
  #widths = [];
  #stamp = NaN;
  #wanted = NaN;

  /** @param {FieldMessage} field */
  setField({ tape_width }) {
    this.#wanted = tape_width;
  }

  /** @param {ScanMessage} scan */
  add({ stamp, tape_width }) {
    if (stamp === this.#stamp) return;
    this.#stamp = stamp;
    if (tape_width === null) return;
    this.#widths.push(tape_width);
    if (this.#widths.length > PICTURES) this.#widths.shift();
  }

  /** Write the width; a few times a second is enough. */
  show() {
    if (this.#widths.length === 0 || !Number.isFinite(this.#wanted)) return;
    const sorted = [...this.#widths].sort((a, b) => a - b);
    const width = sorted[Math.floor(sorted.length / 2)];
    const off = Math.abs(width - this.#wanted) > MOST_OFF;
    setText(this.#measured, millimetres(width, 1));
    setText(this.#drawn, off ? t("camera pitch?") : t("(nominal {width})", { width: plain(this.#wanted * 1000) }));
    this.#row.dataset.off = String(off);
    this.#row.title = off ? this.#hint(width) : TITLE;
  }

  /** @param {number} width [m] */
  #hint(width) {
    const wanted = millimetres(this.#wanted);
    return width > this.#wanted
      ? t(
          "The tape is drawn {wanted} wide and measured wider. Is the camera tilted otherwise than described? Half a degree makes two millimetres.",
          { wanted },
        )
      : t(
          "The tape is drawn {wanted} wide and measured narrower. Is the camera tilted otherwise than described? Half a degree makes two millimetres.",
          { wanted },
        );
  }
}

const TITLE = t("Width of the tape as the camera measures it: a health figure");
