// @ts-check
/** Whose page this is: the server knows a browser by a cookie, or this tab by its own number. */

const NAME = "brickpose-name";
const ROOT = new URL("../../", import.meta.url);
const YEAR_S = 365 * 24 * 3600;
const TAB = "brickpose.tab";

/** The live socket's address, with what this page is. @param {"dashboard" | "lesson"} page */
export const liveAddress = (page) => `api/live?rate=30&page=${page}&tab=${tab()}`;

/** What this page's person is called by others; empty if they never said. */
export function personName() {
  const kept = document.cookie.split("; ").find((pair) => pair.startsWith(`${NAME}=`));
  return kept ? decodeURIComponent(kept.slice(NAME.length + 1)) : "";
}

/** Keep the name in this browser. @param {string} name */
export function keepName(name) {
  const age = name === "" ? 0 : YEAR_S;
  document.cookie = `${NAME}=${encodeURIComponent(name)}; Max-Age=${age}; Path=${ROOT.pathname}; SameSite=Strict`;
}

/** A number of this tab, which a reload keeps. */
function tab() {
  const drawn = [...crypto.getRandomValues(new Uint32Array(4))].map((part) => part.toString(36).padStart(7, "0")).join("");
  try {
    const kept = sessionStorage.getItem(TAB) ?? drawn;
    sessionStorage.setItem(TAB, kept);
    return kept;
  } catch {
    // Storage is switched off: the number lasts as long as the page.
    return drawn;
  }
}
