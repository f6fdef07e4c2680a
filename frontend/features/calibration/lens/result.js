// @ts-check
import { t, translated } from "../../../page/language.js";
import { find, findButton, make, setText } from "../../../page/elements.js";
import { plain } from "../../../page/format.js";
import { palette } from "../../../page/palette.js";
import { Surface } from "../../../page/surface.js";
import { sentence } from "./desk.js";
import { drawOutlines } from "./picture.js";

/** @typedef {import("../../../messages").LensMessage} LensMessage */
/** @typedef {import("../../../messages").LensStatusMessage} LensStatusMessage */

/** Errors are drawn this long, by the picture's width. */
const ERROR_LENGTH = 0.03;

/** The lens that was calibrated: its numbers, how sure they are, and how to take it home. */
export class Result {
  #box = find("result", HTMLElement);
  #save = findButton("save");
  #words = find("save-words", HTMLElement);
  /** @type {LensMessage | null} */
  #lens = null;

  /** @param {import("../../../page/draw_loop.js").DrawLoop} loop @param {() => void} save */
  constructor(loop, save) {
    this.errors = new Surface(find("errors", HTMLCanvasElement), () => this.refresh?.());
    this.coverage = new Surface(find("coverage", HTMLCanvasElement), () => this.refresh?.());
    this.refresh = loop.add(() => this.#paint(), { visible: () => this.errors.visible });
    this.#save.onclick = save;
  }

  /** @param {LensStatusMessage} status */
  follow({ profile, saved }) {
    this.#save.hidden = profile === null;
    this.#save.disabled = saved;
    setText(
      this.#words,
      saved
        ? t(
            "Saved in {profile}; it is used from the next start on. Measure the mounting again: it was measured with the old lens.",
            { profile: profile ?? "" },
          )
        : "",
    );
  }

  /** @param {LensMessage | null} lens */
  show(lens) {
    this.#lens = lens;
    this.#box.hidden = lens === null;
    if (!lens) return;
    setText(find("result-model", HTMLElement), lens.model);
    setText(
      find("result-words", HTMLElement),
      t(
        "From {pictures} pictures of {width} × {height} px, of a {board}. The model in bold is the simplest that is as good as the best in pictures that it was not adjusted to.",
        { pictures: lens.pictures, width: lens.width, height: lens.height, board: translated(lens.board) },
      ),
    );
    setText(
      find("errors-words", HTMLElement),
      t(
        "Errors of the corners, {times} times as long. Lines that point the same way are a lens that the model does not describe, or a board that is not flat.",
        { times: lengthening(lens) },
      ),
    );
    this.#fill(lens);
    for (const figure of [this.errors, this.coverage]) {
      figure.canvas.style.aspectRatio = `${lens.width} / ${lens.height}`;
    }
    this.#box.scrollIntoView({ behavior: "smooth", block: "start" });
    this.refresh();
  }

  /** @param {LensMessage} lens */
  #fill(lens) {
    const ratings = lens.ratings.map(({ model, held_out_px, own_px }) => {
      const held_out = held_out_px === null ? t("fails") : `${plain(held_out_px, 3)} px`;
      const chosen = { "data-chosen": String(model === lens.model) };
      return row([model, held_out, `${plain(own_px, 3)} px`], chosen);
    });
    find("ratings", HTMLElement).replaceChildren(...ratings);
    const parameters = lens.parameters.map(({ name, value, interval }, i) => {
      const [digits, unit] = i < 4 ? [2, " px"] : [5, ""];
      return row([name, plain(value, digits), `± ${plain(interval, digits)}${unit}`]);
    });
    find("parameters", HTMLElement).replaceChildren(...parameters);
    const notes = [
      ...lens.missing.map((words) => t("Better with more pictures: {what}.", { what: translated(words) })),
      ...lens.refused.map(({ picture, reason }) => sentence(t("{picture} does not count: {reason}", { picture, reason: translated(reason) }))),
    ];
    find("result-notes", HTMLElement).replaceChildren(...notes.map((note) => make("li", {}, note)));
  }

  #paint() {
    const lens = this.#lens;
    if (!lens) return;
    this.#paintErrors(lens);
    const { context, pixel } = begin(this.coverage, lens);
    drawOutlines(context, lens.outlines, pixel);
    context.fillStyle = palette.estimate;
    for (const [x, y] of lens.corners) context.fillRect(x - pixel, y - pixel, 2 * pixel, 2 * pixel);
  }

  /** @param {LensMessage} lens */
  #paintErrors(lens) {
    const { context, pixel } = begin(this.errors, lens);
    const path = new Path2D();
    const times = lengthening(lens);
    lens.corners.forEach(([x, y], i) => {
      const [dx, dy] = lens.errors[i];
      path.moveTo(x, y);
      path.lineTo(x + times * dx, y + times * dy);
    });
    context.strokeStyle = palette.estimate;
    context.lineWidth = 0.9 * pixel;
    context.stroke(path);
  }
}

/** How many times errors are drawn longer than they are, a round number. @param {LensMessage} lens */
function lengthening({ width, ratings, model }) {
  const error = ratings.find((rating) => rating.model === model)?.own_px ?? 1;
  const wanted = (ERROR_LENGTH * width) / error;
  const power = 10 ** Math.floor(Math.log10(wanted));
  return power * (wanted < 2 * power ? 1 : wanted < 5 * power ? 2 : 5);
}

/**
 * Begin a picture in the camera's pixels.
 * @param {Surface} surface
 * @param {LensMessage} lens
 */
function begin(surface, lens) {
  const context = surface.begin();
  const scale = surface.width / lens.width;
  context.scale(scale, scale);
  return { context, pixel: 1 / scale };
}

/** @param {string[]} cells @param {Record<string, string>} attributes */
function row(cells, attributes = {}) {
  return make("tr", attributes, ...cells.map((cell) => make("td", {}, cell)));
}
