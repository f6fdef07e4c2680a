// @ts-check
import { palette } from "../page/palette.js";
import { brief } from "../page/format.js";
import { axisScale } from "./scale.js";

/** @typedef {import("../page/surface.js").Surface} Surface */
/** @typedef {import("./scale.js").Axis} Axis */
/** @typedef {import("./scale.js").Scale} Scale */
/**
 * @typedef {{colour: string, dash: number[], xs: number[], ys: number[]}} Series NaN leaves a
 *   gap
 */
/**
 * @typedef {Pick<CanvasRenderingContext2D, "strokeStyle" | "fillStyle" | "lineWidth" | "lineJoin" |
 *   "font" | "textAlign" | "textBaseline" | "beginPath" | "moveTo" | "lineTo" | "rect" | "stroke" |
 *   "fillRect" | "fillText" | "measureText" | "setLineDash" | "save" | "restore"> & {clip(): void}} Pen
 */
/** @typedef {{left: number, top: number, right: number, bottom: number}} Box */

/**
 * @typedef {object} Chart
 * @property {Axis} x
 * @property {Axis} y
 * @property {Series[]} series
 * @property {number[]} [levels] dashed horizontal lines at these y
 * @property {{at: number, label: string}[]} [marks] vertical lines at these x
 * @property {number | null} [cursor] the x whose values are read out
 */

/**
 * Draw a line chart with axes, ticks and units.
 * @param {Surface} surface @param {Chart} chart
 * @returns {Scale} of x, to find the value under a pointer
 */
export function drawChart(surface, chart) {
  const { width, height } = surface;
  return drawInto(surface.begin(), chart, { top: 0, width, height });
}

/**
 * Draw a line chart into a part of a picture.
 * @param {Pen} context @param {Chart} chart
 * @param {{top: number, width: number, height: number}} part [px]
 * @returns {Scale} of x
 */
export function drawInto(context, chart, { top, width, height }) {
  context.font = palette.font;
  const line = palette.fontSize;
  const most = (height - line * 3.5) / (line * 2);
  const ticks = axisScale(chart.y, 0, 1, most).ticks;
  const gutter = Math.max(30, ...ticks.map((tick) => context.measureText(brief(tick)).width)) + 14;
  const box = {
    left: gutter,
    top: top + line * 1.5,
    right: width - 10,
    bottom: top + height - line * 2,
  };
  const x = axisScale(chart.x, box.left, box.right, (box.right - box.left) / (line * 6));
  const y = axisScale(chart.y, box.bottom, box.top, most);
  drawAxes(context, box, x, y, chart);
  drawGuides(context, box, x, y, chart);
  clip(context, box, () => chart.series.forEach((one) => drawSeries(context, x, y, one)));
  return x;
}

/**
 * @param {Pen} context
 * @param {Box} box
 * @param {Scale} x
 * @param {Scale} y
 * @param {Chart} chart
 */
function drawAxes(context, box, x, y, chart) {
  const line = palette.fontSize;
  context.strokeStyle = palette.line;
  context.fillStyle = palette.quiet;
  context.lineWidth = 1;
  context.textBaseline = "middle";
  context.textAlign = "right";
  for (const tick of y.ticks) {
    segment(context, box.left, y.at(tick), box.right, y.at(tick));
    context.fillText(brief(tick), box.left - 6, y.at(tick));
  }
  context.textAlign = "left";
  context.fillText(chart.y.label, box.left, box.top - line * 0.9);
  context.textBaseline = "alphabetic";
  const width = context.measureText(chart.x.label).width;
  context.fillText(chart.x.label, box.right - width, box.bottom + line * 1.5);
  context.textAlign = "center";
  for (const tick of x.ticks) {
    segment(context, x.at(tick), box.bottom, x.at(tick), box.bottom + 4);
    if (x.at(tick) > box.right - width - line * 1.5) continue;
    context.fillText(brief(tick), x.at(tick), box.bottom + line * 1.5);
  }
}

/**
 * @param {Pen} context
 * @param {Box} box
 * @param {Scale} x
 * @param {Scale} y
 * @param {Chart} chart
 */
function drawGuides(context, box, x, y, { levels = [], marks = [], cursor = null }) {
  context.strokeStyle = palette.quiet;
  context.setLineDash([2, 4]);
  for (const level of levels) segment(context, box.left, y.at(level), box.right, y.at(level));
  context.setLineDash([]);
  context.strokeStyle = palette.accent;
  context.fillStyle = palette.text;
  for (const [i, { at, label }] of marks.entries()) {
    context.textAlign = i ? "left" : "right";
    segment(context, x.at(at), box.top, x.at(at), box.bottom);
    context.fillText(label, x.at(at) + (i ? 4 : -4), box.bottom - 3);
  }
  context.strokeStyle = palette.text;
  if (cursor !== null) segment(context, x.at(cursor), box.top, x.at(cursor), box.bottom);
}

/**
 * @param {Pen} context
 * @param {Scale} x
 * @param {Scale} y
 * @param {Series} series
 */
function drawSeries(context, x, y, { colour, dash, xs, ys }) {
  context.beginPath();
  let pen = false;
  for (let i = 0; i < xs.length; i++) {
    if (!Number.isFinite(ys[i])) pen = false;
    else if (pen) context.lineTo(x.at(xs[i]), y.at(ys[i]));
    else {
      context.moveTo(x.at(xs[i]), y.at(ys[i]));
      pen = true;
    }
  }
  context.strokeStyle = colour;
  context.setLineDash(dash);
  context.lineWidth = 2;
  context.lineJoin = "round";
  context.stroke();
  context.setLineDash([]);
}

/** @param {Pen} context @param {Box} box @param {() => void} draw */
function clip(context, box, draw) {
  context.save();
  context.beginPath();
  context.rect(box.left, box.top - 2, box.right - box.left, box.bottom - box.top + 4);
  context.clip();
  draw();
  context.restore();
}

/**
 * @param {Pen} context
 * @param {number} x0
 * @param {number} y0
 * @param {number} x1
 * @param {number} y1
 */
function segment(context, x0, y0, x1, y1) {
  context.beginPath();
  context.moveTo(Math.round(x0) + 0.5, Math.round(y0) + 0.5);
  context.lineTo(Math.round(x1) + 0.5, Math.round(y1) + 0.5);
  context.stroke();
}
