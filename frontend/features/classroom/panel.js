// @ts-check
/** The class on a student's page: the teacher's words, whether the class is frozen, one's hand. */

/** Served below `panels/`, beside which the page's own scripts are `static/`. */
const { t, translated } = await import(new URL("../../../static/page/language.js", import.meta.url).href);
const EVERY_MS = 2000;
const ADDRESS = "classroom";

/**
 * @typedef {{frozen: boolean, message: string, lesson: number, hand: boolean, ended: string}} ClassState
 */

/** @param {HTMLElement} body */
export function panel(body) {
  const button = document.createElement("button");
  button.id = "class-hand";
  button.type = "button";
  const told = document.createElement("p");
  body.append(told, button);
  const banner = document.createElement("p");
  banner.id = "class-banner";
  banner.setAttribute("role", "alert");
  Object.assign(banner.style, {
    position: "sticky", top: "0", flex: "none", zIndex: "60", margin: "0", padding: "0.6rem 1rem",
    background: "#ffd54a", color: "#000", font: "600 1.1rem system-ui", textAlign: "center",
  });
  const page = shownPage();
  // What sticks to the top of the page sticks below it: STOP stays in sight.
  new ResizeObserver(() => page.documentElement.style.setProperty("--taken", `${banner.offsetHeight}px`)).observe(banner);

  /** @param {ClassState} state */
  function show({ frozen, message, lesson, hand, ended }) {
    const because = { reason: translated(ended) };
    const text = [
      frozen ? t("Eyes to the front: the teacher has frozen all robots.") : "",
      message,
      ended ? t("Your robot was ended and begun again: {reason}. Your files are as they were.", because) : "",
      lesson ? t("The teacher hands out:") : "",
    ].filter(Boolean).join(" · ");
    if (banner.dataset.shown !== text + lesson) {
      banner.dataset.shown = text + lesson;
      banner.replaceChildren(text);
      if (lesson) banner.append(" ", linkTo(lesson));
    }
    if (text && !banner.isConnected) page.body.prepend(banner);
    if (!text) banner.remove();
    told.textContent = message;
    button.textContent = hand ? t("Take my hand down") : t("Raise my hand");
    button.setAttribute("aria-pressed", String(hand));
  }

  /** @param {RequestInit} [request] */
  async function ask(request) {
    const answer = await fetch(ADDRESS, { cache: "no-store", ...request }).catch(() => null);
    if (answer?.ok) show(await answer.json());
    // The session at the hub has ended: to load the page anew signs in, without a click.
    if (answer?.status === 401) location.reload();
  }

  button.onclick = () => {
    const hand = button.getAttribute("aria-pressed") !== "true";
    ask({ method: "POST", body: JSON.stringify({ hand }) });
  };
  setInterval(ask, EVERY_MS);
  ask();
  return { show() {} };
}

/** The page that a student sees: this one, or the lesson that has it beside it or below. @returns {Document} */
function shownPage() {
  try {
    if (/\/learn(\/\d+)?$/.test(parent.location.pathname)) return parent.document;
  } catch {} // a page of another site has put this one into itself
  return document;
}

/** @param {number} lesson */
function linkTo(lesson) {
  const link = document.createElement("a");
  link.href = `learn/${lesson}`;
  link.target = "_top";
  link.style.color = "inherit";
  link.textContent = t("lesson {lesson}", { lesson });
  return link;
}
