// @ts-check
import { make } from "../page/elements.js";
import { t } from "../page/language.js";

/** @typedef {import("./layout.js").Layout} Layout */

const NEAREST = 12;
const LARGE = "M2 6V2h4M10 2h4v4M14 10v4h-4M6 14H2v-4";
const DOTS = "M5 3v.01M11 3v.01M5 8v.01M11 8v.01M5 13v.01M11 13v.01";

/** Add a panel's own buttons: one that moves it, and one that enlarges it. */
export function addHandles(
  /** @type {Layout} */ layout,
  /** @type {string} */ name,
  /** @type {HTMLElement} */ panel,
) {
  const title = panel.querySelector("h2")?.textContent ?? name;
  const move = button("move", DOTS, t("Move {title}: drag it onto another panel; arrow keys swap", { title }));
  const large = button("enlarge", LARGE, t("Enlarge {title}; Escape goes back", { title }));
  move.toggleAttribute("data-own-arrows", true);
  panel.querySelector("header")?.append(make("div", { class: "handles" }, move, large));
  large.onclick = () => layout.enlarge(name);
  layout.onChange(() => large.setAttribute("aria-pressed", String(panel.dataset.large === "true")));
  panel.querySelector("header")?.addEventListener("dblclick", (event) => {
    const on = /** @type {Element} */ (event.target);
    if (!on.closest("button, a, input")) layout.enlarge(name);
  });
  listenForKeys(layout, name, move);
  listenForDrag(layout, name, move);
}

/** @param {string} kind @param {string} path @param {string} label */
function button(kind, path, label) {
  const icon = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  icon.setAttribute("viewBox", "0 0 16 16");
  icon.setAttribute("aria-hidden", "true");
  const line = document.createElementNS("http://www.w3.org/2000/svg", "path");
  line.setAttribute("d", path);
  icon.append(line);
  return /** @type {HTMLButtonElement} */ (
    make("button", { type: "button", class: `handle ${kind}`, "aria-label": label, title: label }, icon)
  );
}

/** @param {Layout} layout @param {string} name @param {HTMLButtonElement} move */
function listenForKeys(layout, name, move) {
  move.addEventListener("keydown", (event) => {
    const { key } = event;
    if (key !== "ArrowLeft" && key !== "ArrowRight" && key !== "ArrowUp" && key !== "ArrowDown") return;
    event.preventDefault();
    layout.swapTowards(name, key);
  });
}

/** @param {Layout} layout @param {string} name @param {HTMLButtonElement} move */
function listenForDrag(layout, name, move) {
  /** @type {[number, number] | null} */
  let from = null;
  const over = (/** @type {PointerEvent} */ { clientX, clientY }) =>
    document.elementsFromPoint(clientX, clientY).find((one) => one.matches("main > .panel"));
  const mark = (/** @type {Element | undefined} */ target) => {
    for (const panel of document.querySelectorAll("main > .panel"))
      panel.toggleAttribute("data-target", panel === target && panel.id !== name);
  };
  const end = () => {
    from = null;
    mark(undefined);
    document.body.toggleAttribute("data-moving", false);
  };
  move.addEventListener("pointerdown", (event) => {
    move.setPointerCapture(event.pointerId);
    from = [event.clientX, event.clientY];
  });
  move.addEventListener("pointermove", (event) => {
    if (!from || Math.hypot(event.clientX - from[0], event.clientY - from[1]) < NEAREST) return;
    document.body.toggleAttribute("data-moving", true);
    mark(over(event));
  });
  move.addEventListener("pointerup", (event) => {
    const target = document.body.hasAttribute("data-moving") ? over(event) : undefined;
    end();
    if (target && target.id !== name) layout.swap(name, target.id);
  });
  move.addEventListener("pointercancel", end);
}
