// @ts-check

/**
 * A row of tabs after the ARIA pattern: one tab is selected, arrow keys select another one, and
 * only the selected tab is in the tab order.
 */
export class Tabs {
  /** @type {HTMLButtonElement[]} */
  #tabs;

  /** @param {HTMLElement} list @param {(name: string) => void} chosen gets the tab's data-name */
  constructor(list, chosen) {
    this.#tabs = [...list.querySelectorAll("button")];
    this.chosen = chosen;
    for (const tab of this.#tabs) tab.onclick = () => this.select(tab.dataset.name ?? "");
    list.addEventListener("keydown", (event) => this.#key(event));
  }

  /** @param {string} name */
  select(name) {
    for (const tab of this.#tabs) {
      const selected = tab.dataset.name === name;
      tab.setAttribute("aria-selected", String(selected));
      tab.tabIndex = selected ? 0 : -1;
    }
    this.chosen(name);
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    const tabs = this.#tabs.filter((tab) => !tab.hidden);
    const at = tabs.findIndex((tab) => tab.getAttribute("aria-selected") === "true");
    const next = tabs[(at + step + tabs.length) % tabs.length];
    this.select(next.dataset.name ?? "");
    next.focus();
    event.preventDefault();
  }
}
