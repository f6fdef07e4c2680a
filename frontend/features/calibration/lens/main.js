// @ts-check
import { offerLanguages, t } from "../../../page/language.js";
import { CameraStream } from "../../../camera/stream.js";
import { DrawLoop } from "../../../page/draw_loop.js";
import { find, findButton, setText } from "../../../page/elements.js";
import { refreshPalette } from "../../../page/palette.js";
import { Appearance } from "../../../page/theme.js";
import { getJson } from "../../../wire/http.js";
import { BoardForm } from "./board.js";
import { Desk, sentence } from "./desk.js";
import { Guide } from "./guide.js";
import { LivePicture } from "./picture.js";
import { Result } from "./result.js";

/** @typedef {import("../../../messages").AccessMessage} AccessMessage */
/** @typedef {import("../../../messages").LensMessage} LensMessage */
/** @typedef {import("../../../messages").LensStatusMessage} LensStatusMessage */

refreshPalette();
const appearance = new Appearance(findButton("theme"), findButton("large-text"));
offerLanguages(find("language", HTMLSelectElement));
const loop = new DrawLoop();
const banner = find("banner", HTMLElement);
const desk = new Desk("api/lens", take, (words) => setText(banner, words));
const board = new BoardForm((request) => desk.send(request));
const guide = new Guide(() => desk.send({ type: "calibrate" }));
const result = new Result(loop, () => desk.send({ type: "save" }));
const live = new LivePicture(loop);
const stream = new CameraStream("api/camera", (picture) => live.show(picture));
/** Number of the calibration that is shown. */
let shown = 0;

/** @param {LensStatusMessage} status */
function take(status) {
  board.follow(status);
  guide.follow(status);
  live.follow(status);
  result.follow(status);
  if (status.calibrations !== shown) load(status.calibrations);
}

/** @param {number} number of the calibration, 0 after another program has started */
async function load(number) {
  shown = number;
  try {
    /** @type {LensMessage | null} */
    const lens = number ? await getJson("api/lens") : null;
    result.show(lens);
  } catch (error) {
    setText(banner, t("The lens could not be read: {error}", { error: sentence(error instanceof Error ? error.message : String(error)) }));
  }
}

function look() {
  stream.want(!document.hidden);
  desk.want(!document.hidden);
}

appearance.onChange(() => {
  refreshPalette();
  live.refresh?.();
  result.refresh?.();
});
document.addEventListener("visibilitychange", look);
look();
