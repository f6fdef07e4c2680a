// @ts-check

/** A canvas that follows its box's size and the screen's density; its unit is the CSS pixel. */
export class Surface {
  width = 0;
  height = 0;
  ratio = 1;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {() => void} [resized] called after each change of size, also when shown or hidden
   */
  constructor(canvas, resized = () => {}) {
    this.canvas = canvas;
    this.resized = resized;
    const context = canvas.getContext("2d");
    if (!context) throw new Error("This browser cannot draw on a canvas.");
    this.context = context;
    new ResizeObserver(() => this.#follow()).observe(canvas);
  }

  /** Whether the canvas takes any room on the page. */
  get visible() {
    return this.width > 0 && this.height > 0;
  }

  /** Start a picture: empty, in CSS pixels. @returns {CanvasRenderingContext2D} */
  begin() {
    this.context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    this.context.clearRect(0, 0, this.width, this.height);
    return this.context;
  }

  /** @param {MouseEvent} event @returns {[number, number]} its position on the canvas [CSS px] */
  locate(event) {
    const box = this.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  #follow() {
    this.width = this.canvas.clientWidth;
    this.height = this.canvas.clientHeight;
    this.ratio = Math.min(2, devicePixelRatio || 1);
    this.canvas.width = Math.round(this.width * this.ratio);
    this.canvas.height = Math.round(this.height * this.ratio);
    this.resized();
  }
}
