// @ts-check
/** Help and tour, which are loaded when they are asked for. */
import { typesText } from "../drive/keys.js";
import { findButton } from "../page/elements.js";

const SEEN = "brickpose.tour";

/** Wires the button and the key of the help, and what a long press of a finger tells. */
export function offerHelp() {
  findButton("help-open").onclick = openHelp;
  addEventListener("keydown", (event) => {
    if (event.key !== "?" || event.ctrlKey || event.metaKey || typesText(event.target)) return;
    event.preventDefault();
    openHelp();
  });
  addEventListener("pointerdown", watchFinger);
  if (isFirstVisit()) beginTour();
}

async function openHelp() {
  const { toggleHelp } = await import("./sheet.js");
  toggleHelp(beginTour);
}

async function beginTour() {
  const { beginTour } = await import("./tour.js");
  beginTour(() => keep());
}

/** Nobody is shown round on a page that a program drives, or in a frame; `/?tour` asks for it. */
function isFirstVisit() {
  if (new URLSearchParams(location.search).has("tour")) return true;
  if (navigator.webdriver || parent !== window) return false;
  try {
    return localStorage.getItem(SEEN) === null;
  } catch {
    return false; // Storage is switched off: it would come each time.
  }
}

function keep() {
  try {
    localStorage.setItem(SEEN, "seen");
  } catch {
    // Storage is switched off.
  }
}

/** @param {PointerEvent} event */
async function watchFinger(event) {
  if (event.pointerType === "mouse") return;
  const press = { event, begun: performance.now(), over: false };
  for (const end of ["pointerup", "pointercancel"])
    addEventListener(end, () => (press.over = true), { once: true });
  const { tell } = await import("./tips.js");
  tell(press);
}
