// @ts-check

/**
 * The rows of a list that is read again and again: what has not changed stays in its place, with its focus, a
 * press that is half done, and a question that is open.
 * @template Entry
 */
export class Rows {
  /** By what they show. @type {Map<string, HTMLElement>} */
  #rows = new Map();

  /** @param {HTMLElement} list @param {(entry: Entry) => HTMLElement} made */
  constructor(list, made) {
    this.list = list;
    this.made = made;
  }

  /** @param {Entry[]} entries */
  show(entries) {
    const keyed = entries.map((entry) => /** @type {const} */ ([JSON.stringify(entry), entry]));
    this.#rows = new Map(keyed.map(([key, entry]) => [key, this.#rows.get(key) ?? this.made(entry)]));
    const rows = [...this.#rows.values()];
    for (const old of [...this.list.children]) {
      if (!rows.some((row) => row === old)) old.remove();
    }
    rows.forEach((row, i) => {
      if (this.list.children[i] !== row) this.list.insertBefore(row, this.list.children[i] ?? null);
    });
  }

  /** Make all anew at the next time, as what stands in them is no longer so. */
  forget() {
    this.#rows.clear();
  }
}
