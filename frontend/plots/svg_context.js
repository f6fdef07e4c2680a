// @ts-check

/** As much of a canvas's context as charts need, written as SVG. */
export class SvgContext {
  strokeStyle = "#000";
  fillStyle = "#000";
  lineWidth = 1;
  lineJoin = "round";
  font = "12px sans-serif";
  /** @type {CanvasTextAlign} */
  textAlign = "left";
  /** @type {CanvasTextBaseline} */
  textBaseline = "alphabetic";
  /** @type {string[]} */
  #parts = [];
  #path = "";
  /** @type {number[]} */
  #dash = [];
  #clips = 0;
  #box = "";
  #measure = /** @type {CanvasRenderingContext2D} */ (document.createElement("canvas").getContext("2d"));

  /** @param {number} width @param {number} height */
  constructor(width, height) {
    this.width = width;
    this.height = height;
  }

  beginPath() {
    this.#path = "";
    this.#box = "";
  }

  /** @param {number} x @param {number} y */
  moveTo(x, y) {
    this.#path += `M${short(x)} ${short(y)}`;
  }

  /** @param {number} x @param {number} y */
  lineTo(x, y) {
    this.#path += `L${short(x)} ${short(y)}`;
  }

  /** @param {number} x @param {number} y @param {number} width @param {number} height */
  rect(x, y, width, height) {
    this.#box = `x="${short(x)}" y="${short(y)}" width="${short(width)}" height="${short(height)}"`;
  }

  stroke() {
    const dash = this.#dash.length ? ` stroke-dasharray="${this.#dash.join(" ")}"` : "";
    this.#parts.push(
      `<path d="${this.#path}" fill="none" stroke="${this.strokeStyle}" stroke-width="${this.lineWidth}" stroke-linejoin="round"${dash}/>`,
    );
  }

  /** @param {number} x @param {number} y @param {number} width @param {number} height */
  fillRect(x, y, width, height) {
    this.rect(x, y, width, height);
    this.#parts.push(`<rect ${this.#box} fill="${this.fillStyle}"/>`);
  }

  /** @param {string} text @param {number} x @param {number} y */
  fillText(text, x, y) {
    const anchor = { right: "end", center: "middle" }[/** @type {"right"} */ (this.textAlign)] ?? "start";
    const base = this.textBaseline === "middle" ? ' dominant-baseline="central"' : "";
    const size = parseFloat(this.font);
    this.#parts.push(
      `<text x="${short(x)}" y="${short(y)}" font-family="sans-serif" font-size="${size}" fill="${this.fillStyle}" text-anchor="${anchor}"${base}>${escaped(text)}</text>`,
    );
  }

  /** @param {string} text */
  measureText(text) {
    this.#measure.font = this.font;
    return this.#measure.measureText(text);
  }

  /** @param {number[]} dash */
  setLineDash(dash) {
    this.#dash = dash;
  }

  save() {}

  /** Draw from now on only within the last rectangle. */
  clip() {
    const id = `clip${this.#clips++}`;
    this.#parts.push(`<clipPath id="${id}"><rect ${this.#box}/></clipPath><g clip-path="url(#${id})">`);
  }

  restore() {
    this.#parts.push("</g>");
  }

  /** The picture as a document. */
  text() {
    const { width, height } = this;
    return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}">\n${this.#parts.join("\n")}\n</svg>\n`;
  }
}

/** @param {number} value */
const short = (value) => Number(value.toFixed(2));

/** @param {string} text */
const escaped = (text) => text.replace(/[&<>]/g, (mark) => `&#${mark.charCodeAt(0)};`);
