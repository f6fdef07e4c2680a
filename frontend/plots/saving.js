// @ts-check
/** Saves what is plotted as a picture, or as numbers; loaded when somebody saves. */
import { palette } from "../page/palette.js";
import { QUANTITIES } from "./quantities.js";
import { drawStack, lookOf } from "./stack.js";
import { SvgContext } from "./svg_context.js";

/** @typedef {import("./chart.js").Pen} Pen */
/** @typedef {import("./stack.js").Plot} Plot */

/** Size of a saved picture [px], and how much finer a PNG is. */
const WIDTH = 960;
const HEIGHT = 540;
const FINER = 2;
const LEGEND_PX = 28;

/** Offer a plot as a file. @param {string} kind png, svg or csv @param {Plot} shown */
export async function savePlot(kind, shown) {
  const plot = { ...shown, cursor: null };
  if (kind === "csv") return offer(new Blob([csv(plot)], { type: "text/csv" }), "plot.csv");
  if (kind === "svg") {
    const pen = new SvgContext(WIDTH, HEIGHT);
    drawSheet(/** @type {Pen} */ (pen), plot);
    return offer(new Blob([pen.text()], { type: "image/svg+xml" }), "plot.svg");
  }
  const canvas = new OffscreenCanvas(WIDTH * FINER, HEIGHT * FINER);
  const context = canvas.getContext("2d");
  if (!context) return;
  context.scale(FINER, FINER);
  drawSheet(context, plot);
  offer(await canvas.convertToBlob(), "plot.png");
}

/** Draw the plot with a legend, on the page's ground. @param {Pen} pen @param {Plot} plot */
function drawSheet(pen, plot) {
  pen.fillStyle = palette.panel;
  pen.fillRect(0, 0, WIDTH, HEIGHT);
  drawStack(pen, plot, WIDTH, HEIGHT - LEGEND_PX);
  let x = LEGEND_PX;
  const y = HEIGHT - LEGEND_PX / 2;
  pen.font = palette.font;
  pen.textBaseline = "middle";
  pen.textAlign = "left";
  plot.names.forEach((name, place) => {
    const { colour, dash } = lookOf(name, place);
    pen.strokeStyle = colour;
    pen.lineWidth = 2;
    pen.setLineDash(dash);
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(x + 22, y);
    pen.stroke();
    pen.fillStyle = palette.text;
    pen.fillText(QUANTITIES[name].name, x + 28, y);
    x += 48 + pen.measureText(QUANTITIES[name].name).width;
  });
}

/** The shown part of the run as a table, with decimal points in each language. @param {Plot} plot */
function csv({ history, names, span }) {
  const [low, high] = span.ends(history.stamps);
  const [from, until] = [history.after(low), history.after(high + 1e-9)];
  const head = names.map((name) => `${QUANTITIES[name].name} [${QUANTITIES[name].unit}]`);
  const rows = [["stamp [s]", ...head].map(cell).join(",")];
  for (let i = from; i < until; i++) {
    const values = names.map((name) => history.values[name][i]);
    const cells = values.map((value) => (Number.isFinite(value) ? Number(value.toPrecision(7)) : ""));
    rows.push([history.stamps[i].toFixed(3), ...cells].join(","));
  }
  return `${rows.join("\n")}\n`;
}

/** A cell of a table; one with commas is quoted. @param {string} text */
const cell = (text) => (/[",]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

/** @param {Blob} blob @param {string} name */
function offer(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = `brickpose_${name}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
