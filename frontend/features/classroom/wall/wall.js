// @ts-check
/** The teacher's wall: a tile for each student, and orders to all of them. */

import { DecimalField } from "../../../page/decimal.js";
import { offerLanguages, t, tn, translated } from "../../../page/language.js";
import { modeWords } from "../../../page/modes.js";

const EVERY_MS = 1000;
const RADIUS = 0.06;
/** What robots claim of where they are. @type {Record<string, string>} */
const STATES = {
  certain: t("certain"), given: t("as given"), approximate: t("about here"), ambiguous: t("several places look alike"),
  searching: t("searching"), lost: t("lost"),
};

/**
 * @typedef {{x: number, y: number, theta: number}} Pose
 * @typedef {{login: string, name: string, awake: boolean, pending: boolean, url?: string,
 *   map?: string, truth?: Pose | null, estimate?: Pose | null, mode?: string,
 *   integrity?: {state: string, radius: number | null} | null, extent?: number[] | null,
 *   frozen?: boolean, message?: string, handed?: number, hand?: boolean, asleep?: boolean,
 *   notebook?: boolean, lesson?: number | null, passed?: number, begun?: number}} Tile
 * @typedef {{driver: string | null, waiting: string[], ended: boolean, seconds_left: number,
 *   url: string}} Queue
 */

/** @param {string} id @returns {any} */
const byId = (id) => document.getElementById(id);
/** @type {Map<string, {article: HTMLElement, floor: HTMLImageElement, map: string}>} */
const tiles = new Map();
/** What has nobody to hear it where all students work in JupyterLab. */
const ORDERS = ["freeze", "say", "place", "lesson", "field", "handing", "recordings"];
let frozen = false;
const place = {
  x: new DecimalField("place-x"), y: new DecimalField("place-y"), theta: new DecimalField("place-theta"),
};
place.x.value = 0.2;
place.y.value = 0;
place.theta.value = 0;

/** @param {string} words */
function tell(words) {
  byId("told").textContent = words;
}

/** @param {string} path @param {unknown} [body] */
async function order(path, body = {}) {
  const headers = { "Content-Type": "application/json" };
  const request = { method: "POST", headers, body: JSON.stringify(body) };
  const answer = await fetch(`api/${path}`, request).catch(() => null);
  if (!answer) tell(t("The wall does not answer."));
  else if (!answer.ok) tell(`${(await answer.json().catch(() => ({}))).detail ?? answer.status}`);
  else tell("");
  return answer?.ok ? answer : null;
}

/** Say how many robots have done something, and why others have not. @param {Response | null} answer why not, of each robot; empty of those that have @param {(done: number, all: number) => string} words */
async function tellOfEach(answer, words) {
  if (!answer?.ok) return;
  /** @type {string[]} */
  const refusals = Object.values(await answer.json());
  const why = [...new Set(refusals.filter(Boolean))].map((each) => translated(each));
  tell([words(refusals.filter((each) => !each).length, refusals.length), ...why].join(" "));
}

/** @param {Tile} tile */
function words({ awake, pending, notebook, integrity, frozen: held, mode, asleep, lesson, passed, begun }) {
  if (!awake) return pending ? t("starting") : t("not here");
  if (notebook) return t("in JupyterLab, whose robot takes no orders from here");
  if (!integrity) return t("waiting");
  const state = STATES[integrity.state] ?? integrity.state;
  const bound = integrity.radius === null ? "" : ` ± ${Math.round(integrity.radius * 1000)} mm`;
  const marks = { lesson: lesson ?? 0, passed: passed ?? 0, begun: begun ?? 0 };
  return [
    state + bound,
    !mode || mode === "idle" ? "" : modeWords(mode),
    asleep ? t("asleep") : "",
    held ? t("frozen") : "",
    lesson && !begun ? t("lesson {lesson}", marks) : "",
    lesson && begun ? t("lesson {lesson}: {passed} of {begun} passed", marks) : "",
  ].filter(Boolean).join(", ");
}

/** @param {Tile} tile */
function made({ login, name }) {
  const article = document.createElement("article");
  article.dataset.login = login;
  article.innerHTML = '<h2><span></span><span class="hand"></span></h2><canvas width="320" height="240"></canvas><p></p><a target="_blank"></a>';
  /** @type {HTMLElement} */ (article.querySelector("a")).textContent = t("watch");
  /** @type {HTMLElement} */ (article.querySelector("h2 span")).textContent = name;
  byId("tiles").append(article);
  const entry = { article, floor: new Image(), map: "" };
  tiles.set(login, entry);
  return entry;
}

/** @param {Tile} tile */
function show(tile) {
  const entry = tiles.get(tile.login) ?? made(tile);
  const { article } = entry;
  article.dataset.awake = String(tile.awake);
  article.dataset.hand = String(Boolean(tile.hand));
  article.dataset.notebook = String(Boolean(tile.notebook));
  article.dataset.frozen = String(Boolean(tile.frozen));
  /** @type {HTMLElement} */ (article.querySelector(".hand")).textContent = tile.hand ? t("hand up") : "";
  /** @type {HTMLElement} */ (article.querySelector("p")).textContent = words(tile);
  const link = /** @type {HTMLAnchorElement} */ (article.querySelector("a"));
  link.hidden = !tile.url;
  if (tile.url) link.href = tile.url;
  if (tile.map && tile.extent && entry.map !== tile.map) {
    entry.map = tile.map;
    entry.floor.src = `api/floor/${tile.login}.png?${encodeURIComponent(tile.map)}`;
  }
  draw(/** @type {HTMLCanvasElement} */ (article.querySelector("canvas")), tile, entry.floor);
}

/** @param {HTMLCanvasElement} canvas @param {Tile} tile @param {HTMLImageElement} floor */
function draw(canvas, { extent, truth, estimate }, floor) {
  const context = canvas.getContext("2d");
  if (!context) return;
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.clearRect(0, 0, canvas.width, canvas.height);
  if (!extent) return;
  const [xmin, ymin, xmax, ymax] = extent;
  const scale = Math.min(canvas.width / (xmax - xmin), canvas.height / (ymax - ymin));
  if (floor.complete && floor.naturalWidth) {
    context.drawImage(floor, 0, 0, (xmax - xmin) * scale, (ymax - ymin) * scale);
  }
  context.setTransform(scale, 0, 0, -scale, -xmin * scale, ymax * scale);
  for (const [pose, colour] of /** @type {[Pose | null | undefined, string][]} */ ([[truth, "#1a8f3c"], [estimate, "#d0021b"]])) {
    if (!pose) continue;
    context.strokeStyle = colour;
    context.lineWidth = 0.015;
    context.beginPath();
    context.arc(pose.x, pose.y, RADIUS, 0, 2 * Math.PI);
    context.moveTo(pose.x, pose.y);
    context.lineTo(pose.x + 2 * RADIUS * Math.cos(pose.theta), pose.y + 2 * RADIUS * Math.sin(pose.theta));
    context.stroke();
  }
}

async function look() {
  const answer = await fetch("api/tiles", { cache: "no-store" }).catch(() => null);
  if (answer?.status === 401) location.reload();
  if (!answer?.ok) return;
  /** @type {Tile[]} */
  const all = await answer.json();
  for (const tile of all) show(tile);
  for (const [login, { article }] of tiles) {
    if (all.some((tile) => tile.login === login)) continue;
    article.remove();
    tiles.delete(login);
  }
  const awake = all.filter((tile) => tile.awake);
  const led = awake.filter((tile) => !tile.notebook);
  for (const id of ORDERS) byId(id).hidden = led.length === 0 && awake.length > 0;
  frozen = led.length > 0 && led.every((tile) => tile.frozen);
  byId("freeze").setAttribute("aria-pressed", String(frozen));
  byId("freeze").textContent = frozen ? t("Let all go on") : t("Freeze all");
  showStanding(awake);
  byId("summary").textContent = t("{here} of {all} are here", { here: awake.length, all: all.length });
}

/** Show what students' pages show until it is taken away. @param {Tile[]} awake */
function showStanding(awake) {
  const message = awake.find((tile) => tile.message)?.message ?? "";
  const lesson = awake.find((tile) => tile.handed)?.handed ?? 0;
  byId("said").hidden = !message;
  byId("said-words").textContent = t("All read: {message}", { message });
  byId("handed").hidden = !lesson;
  byId("handed-words").textContent = t("Handed out: lesson {lesson}", { lesson });
}

/** @param {string} path @param {unknown} body */
async function orderAndLook(path, body) {
  const answer = await order(path, body);
  await look();
  return answer;
}

byId("said-away").onclick = () => orderAndLook("message", { text: "" });
byId("handed-away").onclick = () => orderAndLook("lesson", { number: 0 });
byId("freeze").onclick = async () => {
  await order("freeze", { frozen: !frozen });
  await look();
};
byId("start").onclick = () => order("start");
byId("say").onsubmit = async (/** @type {SubmitEvent} */ event) => {
  event.preventDefault();
  const { text } = byId("say").elements;
  if (await orderAndLook("message", { text: text.value })) text.value = "";
};
byId("place").onsubmit = async (/** @type {SubmitEvent} */ event) => {
  event.preventDefault();
  const pose = { x: place.x.value, y: place.y.value, theta: (place.theta.value * Math.PI) / 180 };
  tellOfEach(await order("place", pose), (done, all) =>
    tn("{count} robot stands there, of {all}.", "{count} robots stand there, of {all}.", done, { all }),
  );
};
byId("lesson").onsubmit = (/** @type {SubmitEvent} */ event) => {
  event.preventDefault();
  orderAndLook("lesson", { number: Number(byId("lesson").elements.number.value) });
};
byId("recording").onchange = async () => {
  const [file] = byId("recording").files;
  if (!file) return;
  tell(t("Handing out {name} …", { name: file.name }));
  const address = `api/recordings/${encodeURIComponent(file.name)}`;
  const answer = await fetch(address, { method: "PUT", body: file }).catch(() => null);
  byId("recording").value = "";
  if (!answer?.ok) tell(t("The wall does not answer."));
  tellOfEach(answer, (done, all) =>
    tn("{count} robot has it now, of {all}.", "{count} robots have it now, of {all}.", done, { all }),
  );
};
byId("field").onsubmit = async (/** @type {SubmitEvent} */ event) => {
  event.preventDefault();
  const name = byId("field").elements.name.value;
  tell(t("Handing out {name} …", { name }));
  tellOfEach(await order("field", { name }), (done, all) =>
    tn("{count} robot is on {name} now, of {all}.", "{count} robots are on {name} now, of {all}.", done, { all, name }),
  );
};
byId("collect").onclick = async () => {
  byId("collect").disabled = true;
  tell(t("Grading …"));
  let answer = await order("collect");
  while (answer?.status === 202) {
    tell(t("Grading …"));
    await new Promise((resolve) => setTimeout(resolve, EVERY_MS));
    answer = await fetch("api/results.csv", { cache: "no-store" }).catch(() => null);
  }
  byId("collect").disabled = false;
  if (!answer?.ok) {
    if (answer) tell((await answer.json().catch(() => ({}))).detail ?? t("Grading failed."));
    return;
  }
  tell("");
  byId("junit").hidden = false;
  const link = document.createElement("a");
  link.href = URL.createObjectURL(await answer.blob());
  link.download = "results.csv";
  link.click();
};

/** @param {Queue | null} queue */
function showQueue(queue) {
  byId("queue").hidden = !queue;
  if (!queue) return;
  byId("queue-watch").href = queue.url;
  const values = { name: queue.driver ?? "", seconds: queue.seconds_left };
  const driver = queue.driver === null ? t("Nobody drives.") : t("{name} drives, {seconds} s more.", values);
  const { waiting } = queue;
  const names = { names: waiting.join(", ") };
  const others = waiting.length ? tn("{count} waits: {names}", "{count} wait: {names}", waiting.length, names) : "";
  byId("queue-told").textContent = queue.ended ? t("The queue is closed.") : `${driver} ${others}`;
  byId("queue-end").textContent = queue.ended ? t("Open the queue") : t("End the queue");
  byId("queue-end").dataset.action = queue.ended ? "open" : "end";
  const list = byId("queue-login");
  if (list.length === tiles.size) return;
  list.replaceChildren(...[...tiles.keys()].map((name) => new Option(name, name)));
}

async function lookAtQueue() {
  const answer = await fetch("api/queue", { cache: "no-store" }).catch(() => null);
  if (answer?.ok) showQueue(await answer.json());
}

/** @param {string} action @param {string} [login] */
async function wish(action, login = "") {
  const answer = await order("queue", { action, login });
  if (answer) showQueue(await answer.json());
}

byId("queue-skip").onclick = () => wish("skip");
byId("queue-hand").onclick = () => wish("hand", byId("queue-login").value);
byId("queue-end").onclick = () => wish(byId("queue-end").dataset.action);
offerLanguages(byId("language"));
setInterval(look, EVERY_MS);
setInterval(lookAtQueue, EVERY_MS);
look();
lookAtQueue();
