// @ts-check
/** The class on a student's page: the teacher's words, whether the class is frozen, one's hand. */

const EVERY_MS = 2000;
const TEXTS = {
  en: { raise: "Raise my hand", lower: "Take my hand down", frozen: "Eyes to the front: the teacher has frozen all robots." },
  de: { raise: "Melden", lower: "Nicht mehr melden", frozen: "Augen nach vorn: alle Roboter sind angehalten." },
};
const ADDRESS = "classroom";

/** @typedef {{frozen: boolean, message: string, hand: boolean}} ClassState */

/** @param {HTMLElement} body */
export function panel(body) {
  const words = document.documentElement.lang === "de" ? TEXTS.de : TEXTS.en;
  const button = document.createElement("button");
  button.id = "class-hand";
  button.type = "button";
  const told = document.createElement("p");
  body.append(told, button);
  const banner = document.createElement("p");
  banner.id = "class-banner";
  banner.setAttribute("role", "alert");
  Object.assign(banner.style, {
    position: "fixed", inset: "0 0 auto", zIndex: "60", margin: "0", padding: "0.6rem 1rem",
    background: "#ffd54a", color: "#000", font: "600 1.1rem system-ui", textAlign: "center",
  });

  /** @param {ClassState} state */
  function show({ frozen, message, hand }) {
    const text = [frozen ? words.frozen : "", message].filter(Boolean).join(" ");
    if (banner.textContent !== text) banner.textContent = text;
    if (text && !banner.isConnected) document.body.append(banner);
    if (!text) banner.remove();
    told.textContent = message;
    button.textContent = hand ? words.lower : words.raise;
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
