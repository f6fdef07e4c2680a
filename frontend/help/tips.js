// @ts-check
/** What a mouse learns by hovering, a finger learns by staying: the element's title. */
import { make } from "../page/elements.js";
import { loadStyle } from "./style.js";

/** @typedef {{event: PointerEvent, begun: number, over: boolean}} Press */

const HOLD_MS = 500;
const SHOWN_MS = 6000;
/** A finger that goes further moves something [CSS px]. */
const STILL = 10;

/** Show the title below a finger that stays; its release then presses nothing. @param {Press} press */
export async function tell(press) {
  const target = press.event.target instanceof Element ? press.event.target.closest("[title]") : null;
  // STOP stops, however long it is pressed.
  if (!(target instanceof HTMLElement) || target.matches(".stop")) return;
  const { clientX, clientY } = press.event;
  addEventListener("pointermove", (event) => {
    if (Math.hypot(event.clientX - clientX, event.clientY - clientY) > STILL) press.over = true;
  });
  await loadStyle();
  await new Promise((done) => setTimeout(done, press.begun + HOLD_MS - performance.now()));
  if (!press.over) show(target);
}

/** @param {HTMLElement} target */
function show(target) {
  document.querySelector(".tip")?.remove();
  const tip = make("p", { class: "tip", role: "status" }, target.title);
  document.body.append(tip);
  const { left, bottom, top } = target.getBoundingClientRect();
  const above = bottom + tip.offsetHeight + 8 > innerHeight;
  tip.style.left = `${Math.max(8, Math.min(left, innerWidth - tip.offsetWidth - 8))}px`;
  tip.style.top = `${above ? Math.max(8, top - tip.offsetHeight - 8) : bottom + 8}px`;
  const gone = new AbortController();
  const remove = () => {
    tip.remove();
    gone.abort();
  };
  const { signal } = gone;
  const options = { capture: true, signal };
  addEventListener("click", swallow, { ...options, once: true });
  addEventListener("contextmenu", (event) => event.preventDefault(), options);
  // The next touch is a new one.
  addEventListener("pointerdown", remove, options);
  setTimeout(remove, SHOWN_MS);
}

/** @param {Event} event */
function swallow(event) {
  event.preventDefault();
  event.stopPropagation();
}
