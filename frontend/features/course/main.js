// @ts-check
import { find, findButton, setText } from "../../page/elements.js";
import { offerLanguages, t } from "../../page/language.js";
import { endedWords } from "../../drive/ended.js";
import { Appearance } from "../../page/theme.js";
import { liveAddress } from "../../page/person.js";
import { sentence } from "../../page/toasts.js";
import { Connection } from "../../wire/connection.js";
import { getJson } from "../../wire/http.js";
import { Checks } from "./checks.js";
import { LessonDrive } from "./drive.js";
import { Editor } from "./editor.js";
import { LessonList } from "./list.js";
import { Prediction } from "./prediction.js";
import { Sections } from "./sections.js";

/** @typedef {import("../../messages").Command} Command */
/** @typedef {import("../../messages").FieldMessage} FieldMessage */
/** @typedef {{title: string, html: string, choices: string[]}} Section */
/**
 * @typedef {{number: number, title: string, html: string, sections: Section[], stub: string,
 *   picture: boolean, file: string}} Lesson
 */

const number = Number(/\/learn\/(\d+)$/.exec(location.pathname)?.[1] ?? 1);
const banner = find("banner", HTMLElement);
new Appearance(findButton("theme"), findButton("large-text"));
offerLanguages(find("language", HTMLSelectElement));
const connection = new Connection(liveAddress("lesson"));
const list = new LessonList(number);
const editor = new Editor();
const checks = new Checks(number, (passed, lines) => {
  if (passed) list.note(number);
  editor.mark(lines);
});
const sections = new Sections(order);
const drive = new LessonDrive(connection, order, (ended) => setText(banner, endedWords(ended)), (words) => setText(banner, words));

findButton("stop").onclick = () => drive.obey({ type: "stop" });
document.addEventListener("click", (event) => {
  const button = event.target instanceof Element ? event.target.closest("[data-command]") : null;
  if (button instanceof HTMLElement) drive.obey(JSON.parse(button.dataset.command ?? "{}"));
});

/**
 * Send a command to the robot; if it is refused, show why.
 * @param {Command} command
 * @returns {Promise<boolean>} whether it was taken
 */
async function order(command) {
  try {
    await connection.send(command);
    setText(banner, "");
    return true;
  } catch (error) {
    setText(banner, sentence(error));
    return false;
  }
}

/** @param {Lesson} lesson */
function show(lesson) {
  const title = t("{number}. {title}", { number: lesson.number, title: lesson.title });
  document.title = `${title} – BrickPose`;
  setText(find("title", HTMLElement), title);
  find("opening", HTMLElement).innerHTML = lesson.html;
  const picture = find("picture", HTMLImageElement);
  picture.hidden = !lesson.picture;
  if (lesson.picture) picture.src = `api/lessons/${lesson.number}/picture.svg`;
  const [question, ...later] = lesson.sections;
  setText(find("file", HTMLElement), lesson.file);
  setText(find("stub", HTMLElement), lesson.stub);
  editor.follow(lesson.stub);
  new Prediction(lesson.number, question, (prediction) => {
    find("later", HTMLElement).hidden = false;
    sections.show(later, prediction);
    checks.start();
  });
}

/** How wheels err is the first lesson's theme: say there what is missing in them without forces. */
async function showEngine() {
  /** @type {FieldMessage} */
  const field = await getJson("api/field");
  find("engine-missing", HTMLElement).hidden = number !== 1 || !field.engine_missing;
}

let placed = false;

/** Put the robot where the link says, as a finding's does; once, and not for other sites unasked. */
function placeRobot() {
  const asked = new URLSearchParams(location.search);
  if (placed || !(asked.has("x") || asked.has("guess_x"))) return;
  placed = true;
  const own = document.referrer.startsWith(`${location.origin}/`);
  if (!own && !confirm(t("Put the robot where this link says?"))) return;
  /** @param {string} name */
  const value = (name) => Number(asked.get(name) ?? 0);
  if (asked.has("x")) {
    order({ type: "place", x: value("x"), y: value("y"), theta: value("theta") });
  }
  if (asked.has("guess_x")) {
    const [x, y, theta] = [value("guess_x"), value("guess_y"), value("guess_theta")];
    order({ type: "set_pose", x, y, theta, sd_xy: 0.002, sd_theta: 0.01 });
  }
}

connection.onState((state) => {
  document.body.dataset.link = state;
  if (state !== "open") return;
  setText(banner, ""); // what was refused for want of a connection can be pressed again
  placeRobot();
});
connection.start();
try {
  show(await getJson(`api/lessons/${number}`));
  list.show(await getJson("api/lessons"));
  await showEngine();
} catch (error) {
  setText(banner, sentence(error));
}
