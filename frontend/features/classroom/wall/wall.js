// @ts-check
/** The teacher's wall: a tile for each student, and orders to all of them. */

const EVERY_MS = 1000;
const RADIUS = 0.06;

/**
 * @typedef {{x: number, y: number, theta: number}} Pose
 * @typedef {{login: string, name: string, awake: boolean, pending: boolean, url?: string,
 *   map?: string, truth?: Pose | null, estimate?: Pose | null, mode?: string,
 *   integrity?: {state: string, radius: number | null} | null, extent?: number[] | null,
 *   frozen?: boolean, message?: string, hand?: boolean, asleep?: boolean}} Tile
 */

/** @param {string} id @returns {any} */
const byId = (id) => document.getElementById(id);
/** @type {Map<string, {article: HTMLElement, floor: HTMLImageElement, map: string}>} */
const tiles = new Map();
let frozen = false;

/** @param {string} words */
function tell(words) {
  byId("told").textContent = words;
}

/** @param {string} path @param {unknown} [body] */
async function order(path, body = {}) {
  const headers = { "Content-Type": "application/json" };
  const request = { method: "POST", headers, body: JSON.stringify(body) };
  const answer = await fetch(`api/${path}`, request).catch(() => null);
  if (!answer) tell("The wall does not answer.");
  else if (!answer.ok) tell(`${(await answer.json().catch(() => ({}))).detail ?? answer.status}`);
  else tell("");
  return answer?.ok ? answer : null;
}

/** @param {Tile} tile */
function words({ awake, pending, integrity, frozen: held, mode, asleep }) {
  if (!awake) return pending ? "starting" : "not here";
  if (!integrity) return "waiting";
  const radius = integrity.radius === null ? "" : ` ± ${Math.round(integrity.radius * 1000)} mm`;
  return [`${integrity.state}${radius}`, mode === "idle" ? "" : mode, asleep ? "asleep" : "", held ? "frozen" : ""]
    .filter(Boolean).join(", ");
}

/** @param {Tile} tile */
function made({ login, name }) {
  const article = document.createElement("article");
  article.dataset.login = login;
  article.innerHTML = '<h2><span></span><span class="hand"></span></h2><canvas width="320" height="240"></canvas><p></p><a target="_blank">watch</a>';
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
  article.dataset.frozen = String(Boolean(tile.frozen));
  /** @type {HTMLElement} */ (article.querySelector(".hand")).textContent = tile.hand ? "hand up" : "";
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
  frozen = awake.length > 0 && awake.every((tile) => tile.frozen);
  byId("freeze").setAttribute("aria-pressed", String(frozen));
  byId("freeze").textContent = frozen ? "Let all go on" : "Freeze all";
  byId("summary").textContent = `${awake.length} of ${all.length} are here`;
}

byId("freeze").onclick = async () => {
  await order("freeze", { frozen: !frozen });
  await look();
};
byId("start").onclick = () => order("start");
byId("say").onsubmit = (/** @type {SubmitEvent} */ event) => {
  event.preventDefault();
  order("message", { text: byId("say").elements.text.value });
};
byId("place").onsubmit = (/** @type {SubmitEvent} */ event) => {
  event.preventDefault();
  const { x, y, theta } = byId("place").elements;
  order("place", { x: Number(x.value), y: Number(y.value), theta: (Number(theta.value) * Math.PI) / 180 });
};
byId("field").onsubmit = (/** @type {SubmitEvent} */ event) => {
  event.preventDefault();
  order("field", { name: byId("field").elements.name.value });
};
byId("collect").onclick = async () => {
  byId("collect").disabled = true;
  tell("Grading …");
  let answer = await order("collect");
  while (answer?.status === 202) {
    tell("Grading …");
    await new Promise((resolve) => setTimeout(resolve, EVERY_MS));
    answer = await fetch("api/results.csv", { cache: "no-store" }).catch(() => null);
  }
  byId("collect").disabled = false;
  if (!answer?.ok) {
    if (answer) tell((await answer.json().catch(() => ({}))).detail ?? "Grading failed.");
    return;
  }
  tell("");
  const link = document.createElement("a");
  link.href = URL.createObjectURL(await answer.blob());
  link.download = "results.csv";
  link.click();
};
setInterval(look, EVERY_MS);
look();
