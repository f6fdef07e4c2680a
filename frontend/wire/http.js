// @ts-check
import { t, translated } from "../page/language.js";

/** The server answered with an error status. */
export class HttpError extends Error {}

/**
 * @template T
 * @param {string} address
 * @returns {Promise<T>}
 */
export async function getJson(address) {
  const answer = await fetch(address, { cache: "no-store" });
  if (!answer.ok) throw new HttpError(await reason(answer));
  return answer.json();
}

/**
 * Ask for a change.
 * @param {string} address @param {string} method @param {BodyInit} [body] a file, or JSON as text
 */
export async function send(address, method, body) {
  const headers = typeof body === "string" ? { "Content-Type": "application/json" } : undefined;
  const answer = await fetch(address, { method, body, headers });
  if (!answer.ok) throw new HttpError(await reason(answer));
}

/**
 * Ask for a change that has an answer.
 * @template T
 * @param {string} address @param {string} method @param {object} content a file, or what is sent as JSON
 * @returns {Promise<T>}
 */
export async function sendJson(address, method, content) {
  const file = content instanceof Blob;
  const headers = file ? undefined : { "Content-Type": "application/json" };
  const answer = await fetch(address, { method, body: file ? content : JSON.stringify(content), headers });
  if (!answer.ok) throw new HttpError(await reason(answer));
  return answer.json();
}

/** @param {Response} answer @returns {Promise<string>} FastAPI's own words, if there are any */
async function reason(answer) {
  const text = await answer.text();
  try {
    const { detail } = JSON.parse(text);
    if (typeof detail === "string") return detail;
  } catch {
    // Not JSON: a line of plain text, as the server's guards write, or the status, says enough.
    if (text === "This token only watches.") return t("This token only watches.");
    if (answer.headers.get("content-type")?.startsWith("text/plain") && text.length < 200) return translated(text);
  }
  return t("the server answered {status}", { status: answer.status });
}
