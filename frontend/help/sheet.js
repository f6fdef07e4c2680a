// @ts-check
/** The help: keys, what is drawn, and the documents. It lies beside STOP, never on it. */
import { make } from "../page/elements.js";
import { t } from "../page/language.js";
import { loadStyle } from "./style.js";

/** Where, and what each key does there. @type {[string, [string[], string][]][]} */
const KEYS = [
  [
    t("Anywhere"),
    [
      [["W", "A", "S", "D"], t("drive; the arrow keys do, too")],
      [[t("space")], t("stop; in a replay, pause")],
      [["Esc"], t("close, lay a tool down, make a panel small again")],
      [["?"], t("this help")],
    ],
  ],
  [
    t("On the map"),
    [
      [["+", "−", "0"], t("nearer, farther, show all")],
      [["⇧", "←→↑↓"], t("move the view")],
      [["←→↑↓", "⏎"], t("with the tool measure: move an end, lay it down")],
    ],
  ],
  [t("On the camera's picture"), [[["←", "→"], t("choose a ray, and see why it counted")]]],
  [
    t("On the plots"),
    [
      [["←", "→"], t("read the values of a moment")],
      [["⇧", "←→"], t("go back and forth in time")],
      [["+", "−", "0"], t("shorter, longer, follow the newest")],
    ],
  ],
  [t("On a border or on the dots of a panel"), [[["←→↑↓"], t("resize; swap with the next panel")]]],
  [t("In a replay"), [[[",", "."], t("a picture back, a picture on; the arrow keys do, too")]]],
];

/** What the map draws besides, for its tool *ask* and for steps by hand: a sign, a name, and what it means. @type {[string, string, string][]} */
const BESIDES = [
  ["rings", t("ask: rings"), t("Where a ray of the particle asked ends; the larger the ring, the less the ray fits")],
  ["bar", t("ask: bar"), t("Where that particle expects the tape, on the ray that is chosen")],
  ["weighed", t("by hand: dots"), t("Particles; the heavier, the larger and darker")],
  ["died", t("by hand: cross"), t("A particle that resampling has not drawn")],
  ["noise", t("by hand: line"), t("The noise that a particle drew, or the way from a parent to its copy")],
];

/** Documents that are asked for most. @type {[string, string][]} */
const DOCUMENTS = [
  ["page.md", t("This page: layouts, plots, field and faults")],
  ["localization.md", t("The filters, and how the robot finds itself")],
  ["models.md", t("Motion and sensor models")],
  ["own_models.md", t("A model of your own")],
  ["recordings.md", t("Recordings")],
  ["calibration.md", t("Calibration")],
  ["mapping.md", t("Maps, drawn by driving")],
  ["robot.md", t("The robot in bricks")],
  ["glossary.md", t("Words, each for one thing")],
  ["", t("All documents")],
];

/** @type {HTMLDialogElement | null} */
let sheet = null;
/** What had the focus before. @type {Element | null} */
let before = null;

/** Open the help, or close it. @param {() => void} beginTour */
export async function toggleHelp(beginTour) {
  if (sheet !== null) return close();
  before = document.activeElement;
  await loadStyle();
  sheet = made(beginTour);
  document.body.append(sheet);
  // Not modal: STOP has to be in reach.
  sheet.show();
  sheet.querySelector("h2")?.focus();
}

function close() {
  sheet?.remove();
  sheet = null;
  if (before instanceof HTMLElement) before.focus();
}

/** @param {() => void} beginTour */
function made(beginTour) {
  const heading = make("h2", { id: "help-title", tabindex: "-1" }, t("Help"));
  const tour = make("button", { type: "button", class: "primary" }, t("Show me round"));
  const shut = make("button", { type: "button", "aria-label": t("Close the help") }, "×");
  const dialog = make(
    "dialog",
    { id: "help", class: "help", "aria-labelledby": "help-title", "data-own-arrows": "" },
    make("div", { class: "head" }, heading, tour, shut),
    part(t("Keys"), make("div", { class: "keys-of-all" }, ...KEYS.map(keysOf))),
    part(t("What is drawn"), make("ul", { class: "meanings on-floor" }, ...meanings())),
    ...documents(),
    make("p", { class: "quiet" }, t("Rest the pointer or a finger on a button to read what it does.")),
  );
  shut.onclick = close;
  tour.onclick = () => {
    close();
    beginTour();
  };
  dialog.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    event.preventDefault();
    close();
  });
  return /** @type {HTMLDialogElement} */ (dialog);
}

/** @param {string} title @param {HTMLElement} content */
const part = (title, content) => make("section", {}, make("h3", {}, title), content);

/** @param {[string, [string[], string][]]} place */
function keysOf([where, rows]) {
  const lines = rows.flatMap(([keys, does]) => [
    make("dt", {}, ...keys.map((key) => make("kbd", {}, key))),
    make("dd", {}, does),
  ]);
  return make("div", {}, make("h4", {}, where), make("dl", {}, ...lines));
}

/** The map's legend with its tips written out, and what is drawn besides. */
function meanings() {
  const shown = document.querySelectorAll("#map .legend li:not([hidden])");
  const legend = [...shown].map((item) => {
    const swatch = item.querySelector(".swatch")?.cloneNode(true) ?? "";
    return meaning(swatch, item.textContent ?? "", item.getAttribute("title") ?? "");
  });
  const besides = BESIDES.map(([sign, name, means]) => meaning(make("span", { class: `swatch ${sign}` }), name, means));
  return [...legend, ...besides];
}

/** @param {Node | string} swatch @param {string} name @param {string} means */
function meaning(swatch, name, means) {
  return make("li", {}, swatch, make("span", {}, make("b", {}, name), ` ${means}`));
}

/** Documents are shown by a feature, which may be left out. */
function documents() {
  const active = document.documentElement.dataset.features?.split(" ") ?? [];
  return active.includes("help") ? [part(t("Documents"), make("ul", {}, ...DOCUMENTS.map(link)))] : [];
}

/** @param {[string, string]} document */
function link([name, title]) {
  return make("li", {}, make("a", { href: `help/${name}`, target: "_blank" }, title));
}
