// @ts-check
import { find, make, setText } from "../../page/elements.js";
import { t } from "../../page/language.js";
import { Backoff } from "../../wire/backoff.js";

/**
 * @typedef {{cause: string, symptom: string, case: string, seems: string, next: string,
 *   line: number | null, link: string, picture: string}} Finding
 * @typedef {{type: "checking", file: string} | {type: "problem", message: string} |
 *   {type: "result", passed: boolean, begun: boolean, findings: Finding[]}} News
 */

/** How the student's file stands: checked by the program at each save. */
export class Checks {
  #backoff = new Backoff();
  #started = false;

  /** @param {number} number of the lesson @param {(passed: boolean, lines: (number | null)[]) => void} told */
  constructor(number, told) {
    this.told = told;
    this.state = find("state", HTMLElement);
    this.list = find("findings", HTMLElement);
    const path = `api/lessons/${number}/checks`;
    this.address = new URL(path, document.baseURI.replace(/^http/, "ws")).href;
  }

  /** Follow the file from now on. */
  start() {
    if (this.#started) return;
    this.#started = true;
    this.#open();
  }

  #open() {
    const socket = new WebSocket(this.address);
    socket.onmessage = (event) => this.#take(JSON.parse(event.data));
    socket.onclose = () => setTimeout(() => this.#open(), this.#backoff.next());
  }

  /** @param {News} news */
  #take(news) {
    this.#backoff.reset();
    if (news.type === "checking") return setText(this.state, t("Checking {file} …", news));
    if (news.type === "problem") return setText(this.state, news.message);
    this.list.replaceChildren(...news.findings.map(entry));
    setText(this.state, words(news.passed, news.begun));
    this.state.dataset.passed = news.begun ? String(news.passed) : "";
    this.told(news.passed, news.findings.map(({ line }) => line));
  }
}

/** @param {boolean} passed @param {boolean} begun */
function words(passed, begun) {
  if (passed) return t("Passed. Now break it.");
  return begun ? t("Not yet: look below.") : t("Not begun yet.");
}

/** @param {Finding} finding */
function entry(finding) {
  const parts = [
    [t("The smallest case"), finding.case],
    [t("It seems"), finding.seems],
    [t("Look next"), finding.next],
  ].flatMap(([name, text]) => [make("dt", {}, name), make("dd", {}, text)]);
  const picture = make("div", {});
  picture.innerHTML = finding.picture;
  picture.querySelector("svg")?.setAttribute("aria-label", finding.case);
  const link = finding.link.includes("?")
    ? [make("a", { class: "button", href: finding.link.slice(1) }, t("See it in the dashboard"))]
    : [];
  const title = make("h3", {}, finding.symptom, " ", make("code", {}, finding.cause));
  return make("li", {}, title, picture, make("dl", {}, ...parts), ...link);
}
