// The screen of the dictionary: words, what they mean, how well they find, and one hit that moves.

import { address, get, isAbort, problemOf } from "../api.js";
import { clip } from "../clip.js";
import { counted, el, trouble } from "../dom.js";

/** @typedef {import("../app.js").App} App */
/**
 * @typedef {object} Word
 * @property {string} name
 * @property {string[]} names
 * @property {string} sentence
 * @property {string} pattern
 * @property {string | null} mirror_image
 * @property {string[]} labels
 * @property {number | null} precision
 * @property {number | null} recall
 * @property {number | null} found_rightly
 * @property {number} found_wrongly
 * @property {number} missed
 * @property {number} clips
 * @property {number} collections
 * @property {boolean} own
 * @property {string} [explained]
 */

/** @type {[string, (word: Word) => boolean][]} */
const GROUPS = [
  ["Your own words", (it) => it.own],
  ["Measured on captures", (it) => !it.own && it.precision !== null],
  ["Seen too seldom for figures", (it) => !it.own && it.precision === null],
];

/** @param {App} app */
export async function show(app) {
  const { main, url } = app, query = url.searchParams;
  /** @type {{words: Word[]}} */
  const { words } = await get("/api/words", app.signal);
  const filter = el("input", { type: "search", value: query.get("q") ?? "", placeholder: "Filter", "aria-label": "Filter words" });
  const list = el("nav", { "aria-label": "Words" }), detail = el("div", { class: "halves" });
  let chosen = query.get("word") ?? "", shown = new AbortController();
  app.signal.addEventListener("abort", () => shown.abort());
  filter.addEventListener("input", () => {
    app.replace(here());
    fill();
  });
  main.append(
    el("h1", {}, "Words"),
    el("p", { class: "soft" }, "Each word stands for a pattern and can be searched; ", el("a", { href: "/help/language" }, "what patterns are made of"), "."),
    el("div", { class: "aside" }, list, detail));
  list.append(filter, el("div"));
  fill();
  await choose(chosen || words[0]?.name);

  function here(word = chosen) {
    return address("/words", { word, q: filter.value });
  }

  function fill() {
    const wanted = filter.value.toLowerCase().split(/[\s_]+/);
    const fit = words.filter((it) => wanted.every((word) => [it.name, ...it.names, it.sentence].some((text) => text.toLowerCase().includes(word))));
    list.lastElementChild?.replaceWith(el("div", {},
      ...GROUPS.map(([name, holds]) => /** @type {const} */ ([name, fit.filter(holds)])).filter(([, own]) => own.length).map(([name, own]) =>
        el("section", {}, el("h2", {}, name), el("ul", {}, ...own.map(entry)))),
      !fit.length && el("p", { class: "soft" }, "No word is like this. ", el("button", { type: "button", onclick: () => choose(filter.value) }, "Why?"))));
  }

  /** @param {Word} word */
  function entry({ name }) {
    return el("li", {}, el("a", { href: here(name), "aria-current": name === chosen ? "true" : null, onclick: (/** @type {MouseEvent} */ event) => {
      if (event.ctrlKey || event.metaKey || event.shiftKey) return;
      event.preventDefault();
      choose(name);
    } }, plain(name)));
  }

  /** @param {string} name */
  async function choose(name) {
    shown.abort();
    const own = (shown = new AbortController());
    if (name !== chosen) {
      chosen = name;
      app.replace(here());
    }
    for (const link of list.querySelectorAll("a")) {
      if (link.textContent === plain(name)) link.setAttribute("aria-current", "true");
      else link.removeAttribute("aria-current");
    }
    try {
      /** @type {Word} */
      const word = await get(`/api/words/${encodeURIComponent(name)}`, own.signal);
      app.title(plain(word.name));
      const example = el("section", {}, el("h2", {}, "An example"), el("p", { class: "soft" }, "Looking for one\u2026"));
      detail.replaceChildren(el("section", {}, ...described(word)), example);
      await exemplify(word, example, own.signal);
    } catch (error) {
      if (!isAbort(error)) detail.replaceChildren(trouble(problemOf(error)));
    }
  }

  /** @param {Word} word */
  function described(word) {
    /** @type {[string, Node | string | null][]} */
    const rows = [
      ["also", word.names.map(plain).join(", ")],
      ["mirrored", word.mirror_image === "itself" ? "itself" : word.mirror_image && el("a", { href: `/words?word=${word.mirror_image}` }, plain(word.mirror_image))],
      ["labels", word.labels.join(", ")],
      ["found", figures(word)],
      ["precision", word.precision === null ? null : word.precision.toFixed(2)],
      ["recall", word.recall === null ? null : word.recall.toFixed(2)],
    ];
    return [
      el("div", { "aria-live": "polite" }, el("h2", {}, plain(word.name)), el("p", {}, word.sentence)),
      el("p", {}, el("a", { class: "button", href: address("/search", { q: word.name }) }, "Search for it")),
      el("p", { class: "pattern" }, word.pattern),
      el("details", {}, el("summary", {}, "The pattern in English"), el("p", {}, word.explained ?? "")),
      el("dl", {}, ...rows.filter(([, value]) => value).flatMap(([name, value]) => [el("dt", {}, name), el("dd", {}, value)])),
    ];
  }

  /** @param {Word} word @param {HTMLElement} place @param {AbortSignal} signal */
  async function exemplify(word, place, signal) {
    const { hit, bundled } = await get(`/api/words/${word.name}/example`, signal);
    const said = place.lastElementChild;
    if (!hit) {
      said?.replaceWith(el("p", { class: "soft" }, "No capture of this library has it, and no choreography that comes with LanIndex."));
      return;
    }
    const when = `, ${hit.start.toFixed(2)}\u2013${hit.end.toFixed(2)} s`, link = address(`/captures/${hit.capture_id}`, { from: hit.start, to: hit.end });
    said?.replaceWith(
      bundled
        ? el("p", {}, "No capture of this library has it. This is a choreography that comes with LanIndex, ", el("span", { class: "path" }, hit.capture.split("/").pop()), when)
        : el("p", {}, "The clearest hit of this library: ", el("a", { href: link, class: "path" }, hit.capture), when),
      clip(signal, { ...hit, parts: hit.symbols.map((/** @type {{part: string}} */ it) => it.part) }, bundled ? "/api/choreographies" : undefined),
      el("p", { class: "soft" }, hit.words.join(", ")));
  }
}

/** @param {string} name */
function plain(name) {
  return name.replaceAll("_", " ");
}

/**
 * Return how well a word finds, in words; null where nobody has measured it.
 * @param {Word} word
 */
function figures({ found_rightly: right, found_wrongly: wrong, missed, clips, collections, precision }) {
  if (right === null) return null;
  const wanted = right + missed;
  return `${right} of ${counted(wanted, "capture")}, in ${counted(collections, "collection")}; ${wrong} of ${clips - wanted} others wrongly;`
    + ` all were left out while it was made${precision === null ? "; fewer than ten captures of two collections, too few for figures" : ""}`;
}
