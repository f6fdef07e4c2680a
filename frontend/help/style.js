// @ts-check
import { make } from "../page/elements.js";

/** @type {Promise<void> | undefined} */
let loaded;

/** Load the style of help and tour, once. */
export function loadStyle() {
  loaded ??= new Promise((done) => {
    const link = make("link", { rel: "stylesheet", href: "static/help/help.css" });
    link.onload = link.onerror = () => done();
    document.head.append(link);
  });
  return loaded;
}
