/** The line in which a query is typed: completions, a mark under what is wrong, the sentence. */

import { isAbort, problemOf, send } from "./api.js";
import { el } from "./dom.js";

/**
 * @typedef {{text: string, kind: string, start: number, stop: number, meaning: string}} Completion
 * @typedef {object} Reading what the server says of a text
 * @property {string} text
 * @property {string | null} english null where it is not understood
 * @property {any} tree null where it is not understood
 * @property {import("./api.js").Problem | null} error
 * @property {Completion[]} completions
 *
 * @typedef {object} Options
 * @property {(reading: Reading) => void} read is called with what each text that is typed means
 * @property {(reading: Reading) => void} run is called when Enter is pressed
 */

const MOST = 12; // completions that are shown

export class QueryLine {
  #options;
  #list = el("ul", { class: "completions", role: "listbox", id: "completions", hidden: true, "aria-label": "Completions" });
  #mirror = el("div", { class: "mirror", "aria-hidden": "true" });
  #said = el("p", { class: "said", id: "meaning", "aria-live": "polite" });
  #area;
  /** @type {AbortController | null} */
  #asking = null;
  /** @type {Completion[]} */
  #offered = [];
  #chosen = -1;
  /** @type {Reading | null} */
  #reading = null;

  /** @param {Options} options */
  constructor(options) {
    this.#options = options;
    this.#area = el("textarea", {
      rows: 1,
      spellcheck: "false",
      autocomplete: "off",
      autocapitalize: "off",
      placeholder: "r_arm right mid -> high, or a word: wave",
      "aria-label": "What is searched for: words or a pattern",
      "aria-controls": "completions",
      "aria-haspopup": "listbox",
      "aria-autocomplete": "list",
      "aria-describedby": "meaning",
      oninput: () => this.#typed(true),
      onkeydown: (/** @type {KeyboardEvent} */ event) => this.#key(event),
      onclick: () => this.#typed(false),
      onblur: () => this.#close(),
      onscroll: () => this.#scroll(),
    });
    this.root = el("div", { class: "query" }, el("div", { class: "typed" }, this.#mirror, this.#area), this.#said, this.#list);
  }

  /** What is typed. */
  get text() {
    return this.#area.value;
  }

  /** What the server said of it last; null: nothing yet. */
  get reading() {
    return this.#reading;
  }

  /**
   * Set what is typed, and have it read.
   * @param {string} text
   */
  async set(text) {
    this.#area.value = text;
    this.#fit();
    return this.#read(false);
  }

  focus() {
    this.#area.focus();
  }

  /** @param {boolean} offer */
  #typed(offer) {
    const some = this.text.trim() !== "";
    if (!some) this.#close(); // anything may begin a pattern: Ctrl-Space offers it
    this.#fit();
    this.#read(offer && some);
  }

  #fit() {
    this.#area.rows = Math.min(this.#area.value.split("\n").length + Math.floor(this.#area.value.length / 110), 8);
    this.#draw();
  }

  /** @param {boolean} offer */
  async #read(offer) {
    this.#asking?.abort();
    const own = (this.#asking = new AbortController());
    const text = this.text, position = this.#area.selectionStart;
    try {
      const reading = /** @type {Reading} */ (await send("POST", "/api/parse", { text, position }, own.signal));
      if (own.signal.aborted) return null;
      const changed = this.#reading?.text !== text;
      this.#reading = { ...reading, text };
      this.#tell();
      if (offer) this.#offer(reading.completions);
      if (changed) this.#options.read(this.#reading);
      return this.#reading;
    } catch (error) {
      if (!isAbort(error)) this.#said.textContent = problemOf(error).found;
      return null;
    }
  }

  #tell() {
    const { error = null, english = "", text = "" } = this.#reading ?? {};
    this.#said.classList.toggle("wrong", error !== null);
    this.#said.textContent = error ? [error.found, error.remedy].filter(Boolean).join(" ") : text.trim() ? english : "";
    const instead = error?.instead;
    if (instead) this.#said.append(" ", el("button", { type: "button", onclick: () => {
      this.set(instead);
      this.focus();
    } }, instead));
    if (this.#said.scrollHeight > this.#said.clientHeight + 1) this.#said.tabIndex = 0; // what a word stands for can be long
    else this.#said.removeAttribute("tabindex");
    this.#area.setAttribute("aria-invalid", String(error !== null));
    this.#draw();
  }

  /** Draw the mark under what is wrong, behind the text. */
  #draw() {
    const error = this.#reading?.text === this.text ? this.#reading.error : null, text = this.text;
    const { start = 0, stop = 0 } = error ?? {};
    this.#mirror.replaceChildren(
      text.slice(0, start),
      error ? el("mark", {}, text.slice(start, Math.max(stop, start + 1)) || "\u00a0") : "",
      text.slice(Math.max(stop, start + (error ? 1 : 0))));
    this.#scroll();
  }

  #scroll() {
    this.#mirror.scrollTop = this.#area.scrollTop;
  }

  /** @param {Completion[]} completions */
  #offer(completions) {
    this.#offered = completions.slice(0, MOST);
    this.#chosen = -1;
    this.#list.replaceChildren(...this.#offered.map((it, at) => el("li", {
      role: "option",
      id: `completion-${at}`,
      "aria-selected": "false",
      onmousedown: (/** @type {Event} */ event) => {
        event.preventDefault(); // the line keeps the focus
        this.#take(it);
      },
    }, el("b", {}, it.text), " ", el("span", { class: "soft" }, it.meaning || it.kind))));
    this.#open(this.#offered.length > 0 && document.activeElement === this.#area);
  }

  /** @param {boolean} on */
  #open(on) {
    this.#list.hidden = !on;
    if (!on) this.#area.removeAttribute("aria-activedescendant");
  }

  #close() {
    this.#open(false);
    this.#chosen = -1;
  }

  /** @param {number} by */
  #choose(by) {
    const count = this.#offered.length;
    this.#chosen = this.#chosen < 0 ? (by > 0 ? 0 : count - 1) : (this.#chosen + by + count) % count;
    [...this.#list.children].forEach((node, at) => node.setAttribute("aria-selected", String(at === this.#chosen)));
    this.#list.children[this.#chosen].scrollIntoView({ block: "nearest" });
    this.#area.setAttribute("aria-activedescendant", `completion-${this.#chosen}`);
  }

  /** @param {Completion} completion */
  #take({ text, start, stop }) {
    const rest = this.text.slice(stop), space = /^[\s)\]]/.test(rest) ? "" : " ";
    this.#area.setSelectionRange(start, stop);
    document.execCommand("insertText", false, text + space); // Ctrl-Z takes it back
    this.#close();
    this.#typed(true);
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const open = !this.#list.hidden, { key } = event;
    if (key === "ArrowDown" && open) this.#choose(1);
    else if (key === "ArrowUp" && open) this.#choose(-1);
    else if (key === "Escape" && open) this.#close();
    else if ((key === "Tab" || key === "Enter") && open && this.#chosen >= 0) this.#take(this.#offered[this.#chosen]);
    else if (key === " " && event.ctrlKey) this.#read(true);
    else if (key === "Enter" && !event.shiftKey) this.#enter();
    else return;
    event.preventDefault();
  }

  async #enter() {
    this.#close();
    const reading = this.#reading?.text === this.text ? this.#reading : await this.#read(false);
    if (reading) this.#options.run(reading);
  }
}
