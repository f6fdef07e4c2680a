// @ts-check
import { find, findButton } from "./elements.js";
import { Tabs } from "./tabs.js";

/** As in style/phone_panels.css: one panel at a time on a screen of small width or height. */
const PHONE = matchMedia("(max-width: 640px), (max-height: 500px)");

/**
 * On a phone the panels are tabs and the bar's numbers open on demand; a wide screen shows them
 * all.
 */
export class PhoneTabs {
  #list = find("tabs", HTMLElement);
  #tabs = new Tabs(this.#list, (name) => this.#open(name));

  start() {
    this.#tabs.select("map");
    PHONE.addEventListener("change", () => this.#name());
    this.#name();
    const more = findButton("more");
    more.onclick = () => {
      more.setAttribute("aria-expanded", String(more.getAttribute("aria-expanded") !== "true"));
    };
  }

  /** Show a panel's tab. @param {string} name */
  show(name) {
    this.#tabs.select(name);
  }

  /**
   * A panel belongs to the tab of its id, or to the one that its `data-tab` names; "all" is each.
   * @param {string} name
   */
  #open(name) {
    document.body.dataset.tab = name;
    for (const panel of document.querySelectorAll("main > .panel")) {
      if (!(panel instanceof HTMLElement)) continue;
      const tab = panel.dataset.tab ?? panel.id;
      panel.toggleAttribute("data-in-tab", tab === name || tab === "all");
    }
  }

  /** Give panels the role of tab panels only while there are tabs. */
  #name() {
    for (const tab of this.#list.querySelectorAll("button")) {
      const panel = document.getElementById(tab.getAttribute("aria-controls") ?? "");
      if (PHONE.matches) panel?.setAttribute("role", "tabpanel");
      else panel?.removeAttribute("role");
    }
  }
}
