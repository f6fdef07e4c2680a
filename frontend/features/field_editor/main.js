// @ts-check
import { find, findButton, findInput, setText } from "../../page/elements.js";
import { offerLanguages, t, translated } from "../../page/language.js";
import { liveAddress } from "../../page/person.js";
import { Appearance } from "../../page/theme.js";
import { sentence } from "../../page/toasts.js";
import { Connection } from "../../wire/connection.js";
import { getJson } from "../../wire/http.js";
import { Canvas } from "./canvas.js";
import { emptyDrawing, openedDrawing, svgOf } from "./drawing.js";
import { History } from "./history.js";
import { freeName, keepField } from "./kept.js";
import { Numbers } from "./numbers.js";

/** @typedef {import("../../messages").EditableDrawingMessage} EditableDrawingMessage */
/** @typedef {import("../../messages").FieldEntry} FieldEntry */
/** @typedef {import("./canvas.js").Board} Board */
/** @typedef {import("./canvas.js").Tool} Tool */
/** @typedef {import("./drawing.js").Drawing} Drawing */

const KEY = "brickpose.field_editor";
const KEYS = /** @type {Record<string, Tool>} */ ({ v: "select", r: "rectangle", o: "circle", l: "line", c: "curve", s: "start" });
/** How long the robot may take to answer [ms]. */
const PATIENCE_MS = 120_000;

new Appearance(findButton("theme"), findButton("large-text"));
offerLanguages(find("language", HTMLSelectElement));
const stage = find("stage", SVGSVGElement);
const nameField = findInput("name");
const banner = find("banner", HTMLElement);
const opener = find("open", HTMLSelectElement);
const done = findButton("done");

let history = new History(emptyDrawing());
/** Name under which the drawing is kept; only then may it be written over. */
let keptName = "";
/** The file as it was kept last. */
let keptText = "";
/** @type {FieldEntry[]} */
let fields = [];

/** @type {Board} */
const board = {
  drawing: emptyDrawing(),
  chosen: -1,
  node: -1,
  grid: 50,
  choose(stroke, node = -1) {
    board.chosen = stroke;
    board.node = node;
    show();
  },
  changing: () => numbers.show(),
  changed() {
    history.add(board.drawing);
    keepDraft();
    setText(banner, "");
    show();
  },
  drafting(draws) {
    done.hidden = !draws;
    tellHint();
  },
};
const canvas = new Canvas(stage, board);
const numbers = new Numbers(board);

function show() {
  canvas.show();
  numbers.show();
  findButton("undo").disabled = !history.canUndo;
  findButton("redo").disabled = !history.canRedo;
  findButton("delete").disabled = board.chosen < 0;
  tellHint();
}

function tellHint() {
  setText(find("hint", HTMLElement), hint());
}

/** What can be done next, in a line. */
function hint() {
  if (canvas.drafting) {
    if (canvas.tool === "curve") return t("Press where the curve ends, then where its middle is; Enter or done ends the tape.");
    if (canvas.tool === "line") return t("Press at each corner; at the first one the tape is closed; Enter or done ends it.");
    return t("Press again, or drag, to the other side.");
  }
  if (board.drawing.strokes.length === 0) return t("Draw tape: drag a rectangle over the floor. Then press Save and drive.");
  if (startsOnTape()) return t("The robot starts on tape: drag its arrow to free floor.");
  if (board.chosen >= 0) return t("Drag the tape, its points, or the middle dots to bend it; Delete removes it.");
  if (canvas.tool === "start") return t("Press where the robot begins, and drag to where it looks.");
  return t("Choose tape to change it, or a tool to draw more.");
}

function startsOnTape() {
  const [x, y] = board.drawing.start;
  const place = new DOMPoint(x, y);
  return [...stage.querySelectorAll("path.hit[data-stroke]")].some((path, i) => {
    const stroke = board.drawing.strokes[i];
    if (!(path instanceof SVGGeometryElement) || !stroke) return false;
    const wide = path.getAttribute("stroke-width") ?? "";
    path.setAttribute("stroke-width", String(stroke.width));
    const on = path.isPointInStroke(place);
    path.setAttribute("stroke-width", wide);
    return on;
  });
}

/** Begin with a drawing. @param {Drawing} drawing @param {string} name @param {boolean} kept whether it is kept so */
function begin(drawing, name, kept) {
  canvas.drop();
  board.drawing = drawing;
  history = new History(drawing);
  keptName = kept ? name : "";
  keptText = kept ? svgOf(drawing, name) : "";
  nameField.value = name;
  board.choose(-1);
  canvas.zoom(0);
}

/** Keep what is drawn in this browser, so that a reload loses nothing. */
function keepDraft() {
  try {
    localStorage.setItem(KEY, JSON.stringify({ drawing: board.drawing, name: nameField.value, kept: keptName }));
  } catch {
    // Storage is switched off, or full: the drawing lasts until the page is closed.
  }
}

/** @param {-1 | 1} step */
function go(step) {
  if (canvas.drafting) return canvas.drop();
  board.drawing = history.go(step);
  keepDraft();
  board.choose(board.drawing.strokes[board.chosen] ? board.chosen : -1);
}

function remove() {
  const stroke = board.drawing.strokes[board.chosen];
  if (!stroke) return;
  if (board.node >= 0 && stroke.nodes.length > 2) stroke.nodes.splice(board.node, 1);
  else board.drawing.strokes.splice(board.chosen, 1);
  board.choose(-1);
  board.changed();
}

/** Keep the drawing among the user's fields. @returns {Promise<string>} its name; empty if it was refused */
async function save() {
  canvas.finish();
  const name = freeName(nameField.value || t("my-field"));
  nameField.value = name;
  const text = svgOf(board.drawing, name);
  if (name === keptName && text === keptText) return name;
  setText(banner, t("Keeping …"));
  try {
    const { remarks } = await keepField(name, new Blob([text]), { replace: name === keptName });
    [keptName, keptText] = [name, text];
    keepDraft();
    setText(banner, [t("{name} is kept among your fields.", { name }), ...remarks.map(translated)].join(" "));
    await list();
    return name;
  } catch (error) {
    setText(banner, sentence(error));
    return "";
  }
}

/** Keep the drawing, put the robot onto it, and go to the dashboard. */
async function saveAndDrive() {
  const button = findButton("drive");
  button.disabled = true;
  try {
    const name = await save();
    if (!name) return;
    setText(banner, t("The robot is put onto {name} …", { name }));
    await ordered(name);
    location.href = new URL(".", document.baseURI).href;
  } catch (error) {
    setText(banner, sentence(error));
  } finally {
    button.disabled = false;
  }
}

/** Order the field, as a page that drives, and wait until the robot is on it. @param {string} name */
async function ordered(name) {
  const connection = new Connection(liveAddress("dashboard"));
  const late = () => new Error(t("There is no connection to the robot."));
  let gone = false;
  await new Promise((resolve, reject) => {
    setTimeout(() => reject(late()), PATIENCE_MS);
    connection.onState((state) => (state === "open" ? resolve(null) : (gone = true)));
    connection.start();
  });
  gone = false;
  // The server ends and begins anew: a page that is opened meanwhile would be broken.
  const there = new Promise((resolve, reject) => {
    setTimeout(() => reject(late()), PATIENCE_MS);
    connection.onTelemetry(({ map }) => gone && map === name && resolve(null));
  });
  await Promise.all([connection.send({ type: "use_field", name }), there]);
}

async function list() {
  fields = await getJson("api/field_list");
  const drawings = fields.filter(({ drawing }) => drawing);
  opener.replaceChildren(opener.options[0], new Option(t("an empty floor"), "\n"), ...drawings.map(({ name }) => new Option(name, name)));
}

/** Open a field: one's own to change it, another as a copy. @param {string} name */
async function open(name) {
  if (name === "\n") return begin(emptyDrawing(), freeName(t("my-field"), fields.map((field) => field.name)), false);
  setText(banner, t("Opening {name} …", { name }));
  try {
    /** @type {EditableDrawingMessage} */
    const message = await getJson(`api/drawings/${encodeURIComponent(name)}/strokes`);
    const own = fields.some((field) => field.name === name && field.own);
    const copy = own ? name : freeName(t("{name}-copy", { name }), fields.map((field) => field.name));
    begin(openedDrawing(message), copy, own);
    keepDraft();
    setText(banner, message.remarks.map(translated).join(" "));
  } catch (error) {
    setText(banner, sentence(error));
  }
}

function download() {
  const name = freeName(nameField.value || t("my-field"));
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([svgOf(board.drawing, name)], { type: "image/svg+xml" }));
  link.download = `${name}.svg`;
  link.click();
}

async function print() {
  // Opened by the press itself: later a browser would take it for an advertisement.
  const page = window.open("", "_blank");
  const name = await save();
  const address = `api/drawings/${encodeURIComponent(name)}/sheets.pdf?paper=${find("paper", HTMLSelectElement).value}`;
  if (name && page) page.location.href = new URL(address, document.baseURI).href;
  else page?.close();
}

/** @param {Tool} tool */
function use(tool) {
  canvas.use(tool);
  for (const button of document.querySelectorAll("[data-tool]"))
    if (button instanceof HTMLButtonElement) button.setAttribute("aria-pressed", String(button.dataset.tool === tool));
  tellHint();
}

/** @param {KeyboardEvent} event */
function key(event) {
  const writes = event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement;
  const letter = event.key.toLowerCase();
  if (event.ctrlKey || event.metaKey) {
    if (letter === "s") save();
    else if (event.target === nameField) return;
    else if (letter === "z") go(event.shiftKey ? 1 : -1);
    else if (letter === "y") go(1);
    else return;
  } else if (event.key === "Escape") {
    if (canvas.drafting) canvas.finish();
    else use("select");
  } else if (writes || event.altKey) return;
  else if (event.key === "Delete" || event.key === "Backspace") remove();
  else if (event.key === "+") canvas.zoom(1.4);
  else if (event.key === "-" || event.key === "−") canvas.zoom(1 / 1.4);
  else if (event.key === "0") canvas.zoom(0);
  else if (KEYS[letter]) use(KEYS[letter]);
  else return;
  event.preventDefault();
}

for (const button of document.querySelectorAll("[data-tool]"))
  if (button instanceof HTMLButtonElement) button.onclick = () => use(/** @type {Tool} */ (button.dataset.tool));
findButton("undo").onclick = () => go(-1);
findButton("redo").onclick = () => go(1);
findButton("delete").onclick = remove;
findButton("nearer").onclick = () => canvas.zoom(1.4);
findButton("farther").onclick = () => canvas.zoom(1 / 1.4);
findButton("fit").onclick = () => canvas.zoom(0);
findButton("save").onclick = save;
findButton("drive").onclick = saveAndDrive;
findButton("download").onclick = download;
findButton("print").onclick = print;
done.onclick = () => canvas.finish();
nameField.onchange = keepDraft;
const grid = find("grid", HTMLSelectElement);
grid.onchange = () => {
  board.grid = Number(grid.value);
  show();
};
opener.onchange = () => {
  open(opener.value);
  opener.value = "";
};
addEventListener("keydown", key);

/** Show what the address asks for, or what was drawn here last, or an empty floor. */
async function start() {
  await list().catch((error) => setText(banner, sentence(error)));
  const wanted = new URLSearchParams(location.search).get("field");
  if (wanted) {
    // A reload then shows what was changed.
    window.history.replaceState(null, "", location.pathname);
    return open(wanted);
  }
  try {
    const { drawing, name, kept } = JSON.parse(localStorage.getItem(KEY) ?? "");
    begin(drawing, name, false);
    // Who kept it, and has it still, goes on writing over it.
    if (fields.some((field) => field.own && field.name === kept)) keptName = kept;
  } catch {
    begin(emptyDrawing(), freeName(t("my-field"), fields.map((field) => field.name)), false);
  }
}


use("rectangle");
start().then(() => board.drawing.strokes.length > 0 && use("select"));
