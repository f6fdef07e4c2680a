// @ts-check
import { make } from "../../page/elements.js";
import { t, translated } from "../../page/language.js";
import { Rows } from "../../page/rows.js";
import { getJson, send } from "../../wire/http.js";
import { fieldsOf, freeName, keepField } from "./kept.js";

/** @typedef {import("../../messages").FieldEntry} FieldEntry */
/** @typedef {import("../../page/toasts.js").Toasts} Toasts */

/** A second press within this time [ms] deletes. */
const SURE_MS = 4000;

/** Pictures of all fields: a press puts the robot onto one. Files of one's own are kept among them. */
export class Gallery {
  #now = "";
  /** Pictures that were made, by address: a box that opens again shows them at once. @type {Map<string, string>} */
  #made = new Map();
  #watcher = new IntersectionObserver((seen) => {
    for (const { target, isIntersecting } of seen) if (isIntersecting) this.#draw(target);
  });

  /** @param {HTMLElement} list @param {(name: string) => Promise<void>} use @param {Toasts} toasts */
  constructor(list, use, toasts) {
    this.list = list;
    /** @type {Rows<FieldEntry>} */
    this.rows = new Rows(list, (field) => this.#row(field));
    this.use = use;
    this.toasts = toasts;
  }

  /** Show the fields that there are. @param {string} now the name of the robot's */
  async read(now) {
    const fields = /** @type {FieldEntry[]} */ (await getJson("api/field_list"));
    this.rows.show(fields);
    // Also those that could not be drawn the last time.
    for (const picture of this.list.querySelectorAll("img:not([src])")) this.#watcher.observe(picture);
    this.mark(now);
  }

  /** @param {string} now the name of the robot's field */
  mark(now) {
    this.#now = now;
    for (const button of this.list.querySelectorAll("button.choose"))
      button.setAttribute("aria-pressed", String(button.getAttribute("data-name") === now));
  }

  /** @param {FieldEntry} field */
  #row(field) {
    const { name, own, drawing, changed } = field;
    const address = `api/drawings/${encodeURIComponent(name)}`;
    const picture = make("img", { alt: "", width: "120", height: "120" });
    picture.dataset.address = `${address}${drawing ? "" : "/picture.png"}?${changed}`;
    picture.dataset.drawing = String(drawing);
    const choose = make("button", { type: "button", class: "choose", "data-name": name, title: t("Put the robot onto {name}", { name }) }, picture, make("span", {}, name));
    choose.onclick = () => this.use(name);
    picture.onerror = () => picture.removeAttribute("src");
    const acts = make("span", { class: "acts" });
    if (drawing) {
      const edit = own ? t("edit") : t("edit a copy");
      acts.append(
        make("a", { href: `field_editor?field=${encodeURIComponent(name)}`, "aria-label": `${name}: ${edit}` }, edit),
        make("a", { href: `${address}/sheets.pdf`, target: "_blank", "aria-label": t("{name}: print it to scale", { name }), title: t("At its true size over several sheets of A4, with marks to glue") }, t("print")),
      );
    }
    if (own) acts.append(this.#deleteButton(name, address));
    return make("li", {}, choose, acts);
  }

  /** The first press asks, the second one deletes. @param {string} name @param {string} address */
  #deleteButton(name, address) {
    const button = make("button", { type: "button", "aria-label": t("Delete {name}", { name }) }, t("delete"));
    let sure = false;
    button.onclick = async () => {
      if (!sure) {
        sure = true;
        button.textContent = t("really delete?");
        setTimeout(() => {
          sure = false;
          button.textContent = t("delete");
        }, SURE_MS);
        return;
      }
      try {
        await send(address, "DELETE");
      } catch (error) {
        this.toasts.fail(error);
      }
      await this.read(this.#now);
    };
    return button;
  }

  /** Draw a picture when it comes into sight. @param {Element} picture */
  async #draw(picture) {
    this.#watcher.unobserve(picture);
    if (!(picture instanceof HTMLImageElement)) return;
    const { address = "", drawing } = picture.dataset;
    if (drawing !== "true") {
      picture.src = address;
      return;
    }
    // As a picture from a blob a drawing runs no scripts and fetches nothing, whoever made it.
    let made = this.#made.get(address);
    if (!made) {
      const answer = await fetch(address).catch(() => null);
      if (!answer?.ok) return;
      made = URL.createObjectURL(new Blob([await answer.text()], { type: "image/svg+xml" }));
      this.#made.set(address, made);
    }
    picture.src = made;
  }

  /** Keep dropped files as fields, and go on with the last one. @param {File[]} files */
  async keep(files) {
    let last = "";
    try {
      for (const { name, parts } of fieldsOf(files)) {
        const known = /** @type {FieldEntry[]} */ (await getJson("api/field_list"));
        const free = freeName(name, known.map((field) => field.name));
        const { remarks } = await keepField(free, new Blob(parts), { yaml: parts.length > 1 ? parts[0].size : 0 });
        this.toasts.show(t("{name} is kept among your fields.", { name: free }), "note");
        for (const remark of remarks) this.toasts.show(translated(remark), "note");
        last = free;
      }
    } catch (error) {
      this.toasts.fail(error);
    }
    if (!last) return;
    await this.use(last);
    await this.read(this.#now).catch((error) => this.toasts.fail(error));
  }
}
