// @ts-check
/**
 * The queue of a robot that the class shares: who drives, who waits, and one's own place. On that
 * robot's page, and on each student's own.
 */

/** Served below `panels/`, beside which the page's own scripts are `static/`. */
const { t, tn } = await import(new URL("../../../static/page/language.js", import.meta.url).href);
const EVERY_MS = 1000;
/** Of a student's own page: where the robot is that all share. */
const SHARED = location.pathname.includes("/user/")
  ? `${location.pathname.split("/user/")[0]}/services/robot/`
  : "";
const ADDRESS = `${SHARED}queue`;

/**
 * @typedef {{driver: string | null, waiting: string[], ended: boolean, seconds_left: number,
 *   me: string, teaches: boolean}} Queue
 */

/** @param {HTMLElement} body */
export function panel(body) {
  const told = document.createElement("p");
  told.id = "queue-told";
  told.setAttribute("role", "status");
  const waiting = document.createElement("p");
  const button = document.createElement("button");
  button.id = "queue-wish";
  button.type = "button";
  body.append(told, waiting, button);
  if (SHARED) body.append(" ", linkToRobot());
  let asked = false;
  let wish = "join";

  /** @param {Queue} queue */
  function show(queue) {
    const queued = queue.driver === queue.me || queue.waiting.includes(queue.me);
    wish = queued ? "leave" : "join";
    button.hidden = queue.ended || queue.teaches;
    button.textContent = queued ? t("Leave the queue") : t("Queue up to drive");
    told.textContent = words(queue);
    waiting.textContent = queue.waiting.length
      ? tn("{count} waits: {names}", "{count} wait: {names}", queue.waiting.length, {
        names: queue.waiting.join(", "),
      })
      : "";
  }

  /** @param {RequestInit} [request] */
  async function ask(request) {
    const answer = await fetch(ADDRESS, { cache: "no-store", ...request }).catch(() => null);
    if (answer?.ok) show(await answer.json());
    if (answer?.status !== 401) return;
    if (!SHARED) location.reload();
    // The hub knows who this is: the first page of that robot signs in there, without a click.
    else if (!asked) {
      asked = true;
      await fetch(SHARED, { headers: { Accept: "text/html" } }).catch(() => null);
      await ask();
      asked = false;
    }
  }

  button.onclick = () => ask({ method: "POST", body: JSON.stringify({ action: wish }) });
  setInterval(ask, EVERY_MS);
  ask();
  return { show() {} };
}

function linkToRobot() {
  const link = document.createElement("a");
  link.id = "queue-robot";
  link.href = SHARED;
  link.target = "_blank";
  link.textContent = t("Watch the shared robot");
  return link;
}

/** @param {Queue} queue */
function words({ driver, waiting, ended, seconds_left, me }) {
  if (ended) return t("The teacher has ended the queue.");
  if (driver === null) return t("Nobody drives: queue up.");
  const values = { name: driver, seconds: seconds_left };
  if (driver === me) {
    return waiting.length ? t("You drive, {seconds} s more.", values) : t("You drive; nobody waits.");
  }
  if (!waiting.length) return t("{name} drives.", values);
  return t("{name} drives, {seconds} s more.", values);
}
