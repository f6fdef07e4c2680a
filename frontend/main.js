// @ts-check
import { CalibrationPanel } from "./features/calibration/panel.js";
import { CameraPanel } from "./camera/panel.js";
import { endedWords } from "./drive/ended.js";
import { Home } from "./drive/home.js";
import { DrivePanel } from "./drive/panel.js";
import { offerStageBar } from "./drive/stage_bar.js";
import { FieldPanel } from "./field/panel.js";
import { RunAgain } from "./filter/again.js";
import { FilterPanel } from "./filter/panel.js";
import { offerHelp } from "./help/help.js";
import { Layout } from "./layout/layout.js";
import { Journey } from "./features/navigation/journey.js";
import { LayoutMenu } from "./layout/menu.js";
import { Scenes } from "./layout/scenes.js";
import { MapPanel } from "./map/panel.js";
import { MappingPanel } from "./features/mapping/panel.js";
import { dismissByKey, dismissByPress } from "./page/boxes.js";
import { DrawLoop } from "./page/draw_loop.js";
import { welcomeFiles } from "./page/dropped.js";
import { find, findButton, findInput } from "./page/elements.js";
import { FirstStart } from "./page/first_start.js";
import { offerLanguages, t, translated } from "./page/language.js";
import { refreshPalette } from "./page/palette.js";
import { More } from "./page/more.js";
import { keepName, liveAddress, personName } from "./page/person.js";
import { PhoneTabs } from "./page/phone.js";
import { addDelay, exposeProbe } from "./page/probe.js";
import { Problems } from "./page/problems.js";
import { RecordButton } from "./features/recordings/record.js";
import { TapeHealth } from "./page/tape.js";
import { Appearance } from "./page/theme.js";
import { Toasts, sentence } from "./page/toasts.js";
import { TopBar } from "./page/top_bar.js";
import { History } from "./plots/history.js";
import { PlotsPanel } from "./plots/panel.js";
import { View3d } from "./view3d/panel.js";
import { Pointing } from "./view3d/pointing.js";
import { Connection } from "./wire/connection.js";
import { RunsTable } from "./features/run_table/table.js";
import { ReplayBar } from "./features/recordings/replay/bar.js";
import { RecordingsPanel } from "./features/recordings/panel.js";
import { ReplayKeys } from "./features/recordings/replay/keys.js";
import { getJson } from "./wire/http.js";

/** @typedef {import("./messages").AccessMessage} AccessMessage */
/** @typedef {import("./messages").Command} Command */
/** @typedef {import("./messages").FieldMessage} FieldMessage */
/** @typedef {import("./messages").TelemetryMessage} TelemetryMessage */

/** Update rate of numbers and words: nobody can read faster [1/s]. */
const WORDS_HERTZ = 5;
/** Interval between updates of descriptions for screen readers [ms]. */
const DESCRIPTIONS_MS = 2000;
const FIELD_AGAIN_MS = 3000;
/** The delay shown is the median over this many pictures. */
const PICTURES = 15;

refreshPalette();
const appearance = new Appearance(findButton("theme"), findButton("large-text"));
offerLanguages(find("language", HTMLSelectElement));
new More();
offerStageBar();
const loop = new DrawLoop();
const connection = new Connection(liveAddress("dashboard"));
const toasts = new Toasts(find("toasts", HTMLElement));
const problems = new Problems();
const firstStart = new FirstStart((compiling) => {
  showLink();
  if (!compiling) connection.hurry();
});
welcomeFiles(toasts);
const record = new RecordButton(order, toasts);
const recordings = new RecordingsPanel(order, toasts);
const topBar = new TopBar();
const tape = new TapeHealth();
const history = new History();
const drive = new DrivePanel(connection, order);
drive.drive.onEnded((ended) => toasts.offer(endedWords(ended), t("go on"), ended.again));
const home = new Home(drive.drive, order, (words) => toasts.show(words, "note"));
findButton("home").onclick = () => home.go();
const fieldPanel = new FieldPanel(order, toasts);
const calibration = new CalibrationPanel(drive.drive, order, connection);
const camera = new CameraPanel(loop, drawn);
const journey = new Journey(drive.drive, order);
const map = new MapPanel(loop, order, () => home.go(), journey);
const mapping = new MappingPanel(drive.drive, order, connection, (drawing, chosen) => map.setDrawing(drawing, chosen));
const plots = new PlotsPanel(loop, history, (stamp) => replay.seek(stamp));
new RunsTable(toasts, () => plots.seconds);
const filter = new FilterPanel(connection, order, () => map.telling.scatter());
findButton("by-hand").onclick = async () => {
  tabs.show("map");
  if (!layout.shows("map")) layout.show("map", true);
  (await map.particles()).showHand();
};
const again = new RunAgain(order, toasts);
const replay = new ReplayBar(order);
const replayKeys = new ReplayKeys(replay);
const view3d = new View3d(appearance, order, (target) => {
  drive.keys.listen(target);
  replayKeys.listen(target);
  target.addEventListener("keydown", dismissByKey, true);
  target.addEventListener("pointerdown", dismissByPress, true);
  target.addEventListener("keydown", (event) => layout.escape(event));
});
new Pointing(loop, map, view3d);
for (const title of document.querySelectorAll("main > [data-script] h2")) {
  title.textContent = translated(title.textContent ?? "");
}
/** @type {import("./page/added_panels.js").AddedPanels | null} */
let added = null;
if (document.querySelector("main > [data-script]")) {
  import("./page/added_panels.js").then(
    ({ AddedPanels }) => (added = new AddedPanels({ order }, toasts)),
  );
}
const layout = new Layout((text) => toasts.show(text));
new LayoutMenu(layout, toasts);
const scenes = new Scenes(order, layout, toasts);
const nameField = findInput("person-name");
nameField.value = personName();
nameField.onchange = () => {
  keepName(nameField.value.trim());
  connection.again();
};
const tabs = new PhoneTabs();
const probe = exposeProbe((x, y) => map.toPage(x, y));

/** @type {TelemetryMessage | null} */
let telemetry = null;
/** @type {number | null} */
let delay = null;
let fieldName = "";
/** When the robot that the page shows was calibrated [s]. @type {number | null} */
let calibrated = null;
/** The floor from above. @type {ImageBitmap | null} */
let floor = null;
let truthKnown = true;
const writeWords = loop.add(() => telemetry && describe(telemetry), { hertz: WORDS_HERTZ });

/**
 * Send a command; if it is refused, show why.
 * @param {Command} command
 * @returns {Promise<boolean>}
 */
async function order(command) {
  try {
    await connection.send(command);
    return true;
  } catch (error) {
    toasts.fail(error);
    return false;
  }
}

/** @param {TelemetryMessage} news */
function take(news) {
  telemetry = news;
  probe.telemetry = news;
  if (news.map !== fieldName || news.robot.calibrated !== calibrated) loadField(news);
  drive.follow(news);
  if (drive.drive.drives) toasts.withdraw();
  home.follow(news);
  scenes.follow(news);
  fieldPanel.follow(news);
  calibration.follow(news);
  mapping.follow(news);
  journey.follow(news);
  problems.show(news);
  record.show(news.recording ?? null);
  again.follow(news);
  recordings.show(news.replay ?? null, news.mode);
  if (replay.show(news.replay ?? null, news.stamp)) showReplay(replay.shown);
  tape.add(news.scan);
  map.show(news);
  added?.show(news);
  if (history.add(news, delay)) plots.refresh();
  if (truthKnown !== (news.truth !== null)) showTruth(news.truth !== null);
  writeWords();
}

/** Show the parts that need the truth, which only a simulator knows. @param {boolean} known */
function showTruth(known) {
  truthKnown = known;
  for (const part of document.querySelectorAll("[data-needs-truth]")) {
    part.toggleAttribute("hidden", !known);
  }
  plots.setTruth(known);
}

/** A recording cannot be driven, but has more parts to show. @param {boolean} replayed */
function showReplay(replayed) {
  drive.setReplay(replayed);
  document.body.toggleAttribute("data-replay", replayed);
  for (const part of document.querySelectorAll("[data-needs-replay]")) {
    part.toggleAttribute("hidden", !replayed);
  }
  plots.setReplay(replayed);
  delay = null;
}

/** @param {TelemetryMessage} news */
function describe(news) {
  if (connection.state !== "open") return;
  topBar.show(news, delay);
  tape.show();
  map.describe(news);
  drive.describe(news);
  filter.describe(news);
  view3d.describe(news);
}

/** Note that a new picture is on the screen. @param {number} stamp of its exposure */
function drawn(stamp) {
  const now = connection.clock.now();
  // The delay of a recorded picture means nothing.
  if (now === null || replay.shown) return;
  addDelay(probe, (now - stamp) * 1000);
  const last = probe.delays.slice(-PICTURES).sort((a, b) => a - b);
  delay = last[Math.floor(last.length / 2)];
}

/** Ask what this page's link allows; if it allows nothing any more, say so. */
async function checkAccess() {
  const answer = await fetch("api/access", { cache: "no-store" }).catch(() => null);
  if (answer?.status === 401) {
    toasts.show(t("This link no longer holds: open the one that the program printed."));
  } else if (answer?.ok) {
    drive.setAccess(/** @type {AccessMessage} */ (await answer.json()));
  }
}

/** Load another field, or the robot after a calibration. @param {TelemetryMessage} news */
async function loadField(news) {
  const known = news.map === fieldName;
  fieldName = news.map;
  calibrated = news.robot.calibrated;
  try {
    /** @type {FieldMessage} */
    const field = await getJson("api/field");
    const parts = [topBar, drive, home, problems, tape, camera, plots, fieldPanel];
    for (const part of parts) part.setField(field);
    findButton("home").disabled = false;
    showFeatures(field.features);
    if (!known) view3d.setField(field);
    if (!known || floor === null) floor = await loadPicture("api/field.png");
    map.setField(field, floor);
  } catch (error) {
    toasts.show(t("The field could not be read: {error}", { error: sentence(error) }));
    // Telemetry makes it try again, but less often than telemetry comes.
    setTimeout(() => (fieldName = ""), FIELD_AGAIN_MS);
  }
}

/** Hide what belongs to features that do not take part. @param {string[]} active */
function showFeatures(active) {
  document.documentElement.dataset.features = active.join(" ");
  for (const element of document.querySelectorAll("[data-feature]")) {
    element.toggleAttribute("data-absent", !active.includes(element.getAttribute("data-feature") ?? ""));
  }
}

/** @param {string} address @returns {Promise<ImageBitmap>} */
async function loadPicture(address) {
  const answer = await fetch(address);
  if (!answer.ok) throw new Error(`the picture of the field: status ${answer.status}`);
  return createImageBitmap(await answer.blob());
}

/** Say in bar and banner whether there is a connection, or why there is none yet. */
function showLink() {
  const state = firstStart.compiling ? "compiling" : connection.state;
  topBar.showLink(state);
  problems.showLink(state, connection.loads);
}

appearance.onChange(() => {
  refreshPalette();
  for (const panel of [camera, map, plots]) panel.refresh();
});
connection.onTelemetry(take);
connection.onState((state) => {
  probe.connected = state === "open";
  firstStart.follow(state);
  showLink();
  record.enable(state === "open");
  if (state !== "connecting") checkAccess();
  if (state === "open") filter.load();
  // Another program may answer next.
  else fieldName = "";
});
setInterval(() => {
  for (const panel of [camera, plots]) panel.describe();
}, DESCRIPTIONS_MS);
tabs.start();
connection.start();
offerHelp();
