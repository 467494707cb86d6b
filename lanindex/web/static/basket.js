/** The basket: hits that were put aside, kept by this browser, and what can be written of them. */

import { ApiError, follow, problemOf, send } from "./api.js";
import { announce, counted, el, trouble } from "./dom.js";
import { watching } from "./hits.js";

/** @typedef {import("./hits.js").Hit & {pattern?: string}} Hit */

const MOST = 2000; // hits that the server takes
const KINDS = [
  ["clips", "Clips", "Each hit in the format it came in, with its score"],
  ["films", "Films", "A figure beside its staff, WebP"],
  ["dataset", "Data set", "Arrays of joints, symbols and words, in splits"],
  ["elan", "ELAN", "A file for each capture, its hits in a tier"],
];

/** @param {Hit} hit */
function key(hit) {
  return `${hit.capture_id}:${hit.start_frame}-${hit.end_frame}`;
}

export class Basket {
  root = el("section", { class: "basket", "aria-label": "Basket" });
  /** @type {Map<string, Hit>} */
  #hits = new Map();
  #place;
  #state = el("div", { class: "row", role: "status" });

  /** @param {string} library the name of the library whose hits these are */
  constructor(library) {
    this.#place = `basket ${library}`;
    try {
      for (const hit of JSON.parse(localStorage.getItem(this.#place) ?? "[]")) this.#hits.set(key(hit), hit);
    } catch {
      localStorage.removeItem(this.#place); // what another version kept is of no use
    }
    this.#draw();
  }

  /** @param {Hit} hit */
  has(hit) {
    return this.#hits.has(key(hit));
  }

  /**
   * Put a hit in, or take it out; return whether it is in.
   * @param {Hit} hit
   * @param {string} pattern
   */
  toggle(hit, pattern) {
    const inside = !this.#hits.delete(key(hit));
    if (inside && this.#hits.size < MOST) this.#hits.set(key(hit), { ...hit, pattern });
    this.#keep(`${counted(this.#hits.size, "hit")} in the basket`);
    return this.has(hit);
  }

  /**
   * @param {Hit[]} hits
   * @param {string} pattern
   */
  add(hits, pattern) {
    for (const hit of hits) if (this.#hits.size < MOST) this.#hits.set(key(hit), { ...hit, pattern });
    this.#keep(`${counted(this.#hits.size, "hit")} in the basket`);
  }

  /** @param {string} said */
  #keep(said) {
    localStorage.setItem(this.#place, JSON.stringify([...this.#hits.values()]));
    this.#draw();
    announce(said);
  }

  #draw() {
    this.root.hidden = !this.#hits.size;
    this.root.replaceChildren(el("div", { class: "row" },
      el("b", {}, `Basket: ${counted(this.#hits.size, "hit")}`),
      ...KINDS.map(([kind, name, title]) => el("button", { type: "button", title, onclick: () => this.#write(kind) }, name)),
      el("span", { class: "grow" }),
      el("button", { type: "button", class: "plain", onclick: () => {
        this.#hits.clear();
        this.#state.replaceChildren();
        this.#keep("the basket is empty");
        for (const node of document.querySelectorAll("[data-basket]")) node.setAttribute("aria-pressed", "false");
      } }, "Empty it")), this.#state, this.#listed());
  }

  /** The hits that are in it, each of which can be watched and taken out. */
  #listed() {
    const open = this.root.querySelector("details")?.open;
    return el("details", { open }, el("summary", {}, "What is in it"), el("ol", {}, ...[...this.#hits.values()].map((hit) => el("li", {},
      el("a", { class: "path", href: watching(hit, hit.pattern ?? "") }, `${hit.capture.split("/").pop()}, ${hit.start.toFixed(2)}\u2013${hit.end.toFixed(2)} s`), " ",
      el("span", { class: "soft" }, hit.pattern ?? ""), " ",
      el("button", { type: "button", class: "plain", "aria-label": `Take out ${hit.capture.split("/").pop()} at ${hit.start.toFixed(2)} s`, onclick: () => {
        this.toggle(hit, "");
        const star = document.querySelector(`[data-basket="${key(hit)}"]`), next = this.root.querySelector("li button") ?? star;
        star?.setAttribute("aria-pressed", "false");
        if (next instanceof HTMLElement) next.focus();
      } }, "take out")))));
  }

  /** @param {string} kind */
  async #write(kind) {
    this.#state.replaceChildren(el("span", {}, "Writing\u2026"));
    try {
      const { job } = await send("POST", "/api/exports", { kind, hits: [...this.#hits.values()], pad: "0.2s" });
      const cancel = el("button", { type: "button", onclick: () => send("DELETE", `/api/jobs/${job}`) }, "Cancel");
      follow(`/api/jobs/${job}/events`, (state) => {
        const [noun, done] = state.progress;
        if (state.state === "running") this.#state.replaceChildren(el("span", {}, `${done} ${noun} written`), cancel);
        else if (state.state === "done") {
          const link = el("a", { href: `/api/exports/${job}/file`, download: `${kind}.zip` }, `${kind}.zip`);
          this.#state.replaceChildren(el("span", {}, `${counted(done, "file")}: `), link, ...state.notes.map((/** @type {string} */ note) => el("p", { class: "soft" }, note)));
          link.click();
        } else this.#state.replaceChildren(state.error ? trouble(state.error) : el("span", {}, "Broken off."));
      });
    } catch (error) {
      this.#state.replaceChildren(trouble(error instanceof ApiError ? error.problem : problemOf(error)));
    }
  }
}
