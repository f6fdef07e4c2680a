// @ts-check
import { find, findButton, setText } from "../../page/elements.js";
import { t } from "../../page/language.js";
import { sentence } from "../../page/toasts.js";
import { getJson, sendJson } from "../../wire/http.js";

/** @typedef {{text: string, version: string}} File */

const ADDRESS = "api/student_file";
const INDENT = "    ";

/** A plain field for the student's file, for who has no editor; only on the robot's own computer. */
export class Editor {
  #box = find("editor", HTMLDetailsElement);
  #field = find("code", HTMLTextAreaElement);
  #gutter = find("gutter", HTMLElement);
  #words = find("editor-words", HTMLElement);
  #save = findButton("editor-save");
  /** Version of the file that the field's text was made from. */
  #version = "";
  #kept = "";
  /** @type {Set<number>} */
  #marked = new Set();
  /** Name of the function that the lesson is about. */
  #function = "";

  constructor() {
    this.#box.ontoggle = () => this.#box.open && this.#version === "" && this.#load();
    findButton("editor-load").onclick = () => this.#load();
    this.#save.onclick = () => this.#keep();
    this.#field.oninput = () => this.#edited();
    this.#field.onscroll = () => (this.#gutter.scrollTop = this.#field.scrollTop);
    this.#field.onkeydown = (event) => this.#key(event);
    addEventListener("beforeunload", (event) => this.#changed && event.preventDefault());
  }

  /** @param {string} stub the lesson's function as it begins, which the field begins with */
  follow(stub) {
    this.#function = /def (\w+)/.exec(stub)?.[1] ?? "";
  }

  /** Mark the lines that findings are about. @param {(number | null)[]} lines from 1 on */
  mark(lines) {
    this.#marked = new Set(lines.filter((line) => line !== null));
    this.#show();
  }

  get #changed() {
    return this.#version !== "" && this.#field.value !== this.#kept;
  }

  async #load() {
    try {
      this.#take(await getJson(ADDRESS));
      setText(this.#words, t("Loaded."));
    } catch (error) {
      setText(this.#words, sentence(error));
    }
  }

  async #keep() {
    const text = this.#field.value;
    try {
      const { version } = /** @type {File} */ (await sendJson(ADDRESS, "PUT", { text, version: this.#version }));
      [this.#version, this.#kept] = [version, text];
      setText(this.#words, t("Saved."));
      this.#show();
    } catch (error) {
      setText(this.#words, sentence(error));
    }
  }

  /** @param {File} file */
  #take({ text, version }) {
    [this.#version, this.#kept] = [version, text];
    this.#field.value = text;
    this.#field.disabled = false;
    this.#show();
    const above = text.slice(0, Math.max(0, text.indexOf(`def ${this.#function}(`))).split("\n").length - 1;
    this.#field.scrollTop = above * parseFloat(getComputedStyle(this.#field).lineHeight);
  }

  #show() {
    const count = this.#field.value.split("\n").length;
    const rows = Array.from({ length: count }, (_, i) => `${this.#marked.has(i + 1) ? "▶ " : ""}${i + 1}`);
    setText(this.#gutter, rows.join("\n"));
    this.#save.disabled = !this.#changed;
  }

  /** Only an edit says so: the check's findings must not hide that a file could not be saved. */
  #edited() {
    this.#show();
    if (this.#changed) setText(this.#words, t("Not saved yet."));
  }

  /** Tab leaves the field, as everywhere: a new line indents itself. @param {KeyboardEvent} event */
  #key(event) {
    if (event.key === "s" && (event.ctrlKey || event.metaKey)) {
      event.preventDefault();
      if (this.#changed) this.#keep();
    } else if (event.key === "Enter" && !event.shiftKey) {
      event.preventDefault();
      this.#insert(`\n${this.#indentation()}`);
    } else if (event.key === "Backspace" && this.#unindents()) {
      event.preventDefault();
      this.#field.setSelectionRange(this.#field.selectionStart - INDENT.length, this.#field.selectionStart);
      this.#insert("");
    }
  }

  /** What a line after the present one begins with. */
  #indentation() {
    const line = this.#lineBefore();
    const own = /^ */.exec(line)?.[0] ?? "";
    return /:\s*(#.*)?$/.test(line) ? own + INDENT : own;
  }

  /** Whether all before the cursor in its line is indentation. */
  #unindents() {
    const { selectionStart: start, selectionEnd: end } = this.#field;
    return start === end && /^( {4})+$/.test(this.#lineBefore());
  }

  #lineBefore() {
    const before = this.#field.value.slice(0, this.#field.selectionStart);
    return before.slice(before.lastIndexOf("\n") + 1);
  }

  /** So that the browser's undo knows of it. @param {string} text */
  #insert(text) {
    document.execCommand(text ? "insertText" : "delete", false, text);
  }
}
