// What is written at the cursor: the words of a symbol, as buttons with their signs.

import { el, svg } from "../dom.js";
import { nameOf } from "../names.js";

/**
 * @typedef {import("./score.js").Alphabet} Alphabet
 * @typedef {import("./score.js").Track} Track
 */

/** Directions as they lie on the number keys. */
const PAD = ["l_forward", "forward", "r_forward", "left", "place", "right", "l_back", "back", "r_back"];
const DIGITS = ["7", "8", "9", "4", "5", "6", "1", "2", "3"];
const TURN = 15; // degrees of a key

/** @type {Record<string, string>} */
const LEVEL_KEYS = { high: "h", mid: "m", low: "l" };

/** @type {Record<string, string[]>} */
const FIRST = { gesture: ["place", "mid"], support: ["place", "mid"], jump: ["place", "spring"], turn: ["right", "90"], travel: ["forward", "0"], twist: ["right", "45"], incline: ["forward", "30"], bend: ["bend3"], stance: ["mid"] };

export class Palette {
  #alphabet;
  #change;
  /** @type {Record<string, string[]>} the words that are written next, by kind of track */
  #words = { ...FIRST };
  /** @type {Track | null} */
  #track = null;

  /**
   * @param {HTMLElement} root
   * @param {Alphabet} alphabet
   * @param {(words: string[], at: number) => void} change is given the words, and which was chosen
   */
  constructor(root, alphabet, change) {
    this.root = root;
    this.#alphabet = alphabet;
    this.#change = change;
  }

  /** Return the words that are written on a track. @param {Track} track */
  words(track) {
    const kept = this.#words[track.kind] ?? [];
    return track.fields.map((field, at) => {
      const word = kept[at] ?? "";
      return field.words.length ? (field.words.includes(word) ? word : field.words[0]) : word || "0";
    });
  }

  /**
   * Show the words of a track.
   * @param {Track} track
   * @param {string[]} [words] of the symbol that is chosen
   */
  show(track, words) {
    if (words) this.#words[track.kind] = words;
    const had = this.root.contains(document.activeElement) ? /** @type {HTMLElement} */ (document.activeElement).dataset.word : undefined;
    this.#track = track;
    this.root.replaceChildren(...track.fields.map((_, at) => this.#field(track, at)));
    if (had) /** @type {HTMLElement | null} */ (this.root.querySelector(`[data-word="${had}"]`))?.focus();
  }

  /** @param {number} at @param {string} word */
  #choose(at, word) {
    const track = this.#track;
    if (!track) return;
    const words = this.words(track);
    words[at] = word;
    this.#words[track.kind] = words;
    this.#change(words, at);
  }

  /** @param {Track} track @param {number} at */
  #field(track, at) {
    const { field, name, words } = track.fields[at], now = this.words(track);
    if (!words.length) {
      const input = el("input", { type: "number", min: 0, max: 3600, step: TURN, value: now[at], class: "num", "data-word": `${name}` });
      input.addEventListener("change", () => this.#choose(at, String(Math.max(0, Math.round(Number(input.value) || 0)))));
      return el("label", { class: "row" }, `${name[0].toUpperCase()}${name.slice(1)} `, input, el("span", { class: "soft" }, "keys [ ]"));
    }
    const listed = field === "direction" ? PAD : field === "level" ? ["high", "mid", "low"] : words;
    const signs = listed.map((word) => this.#sign(track, at, word));
    const buttons = listed.map((word, place) => {
      const there = words.includes(word), key = field === "direction" ? DIGITS[place] : field === "level" ? LEVEL_KEYS[word] : this.#key(track, word);
      const sign = signs[place], said = nameOf(word), alone = sign !== undefined && signs.indexOf(sign) === signs.lastIndexOf(sign);
      const face = sign === undefined ? (there || field !== "direction" ? said : "") : alone ? picture(sign) : el("span", { class: "edit-told" }, picture(sign), said);
      return el("button", {
        type: "button", class: sign || field === "direction" ? "edit-sign" : "edit-word", disabled: !there, "aria-pressed": String(now[at] === word), "data-word": `${name} ${word}`,
        "aria-label": said, "aria-keyshortcuts": key || null, title: key ? `${said} (${key})` : said, onclick: () => this.#choose(at, word),
      }, face);
    });
    return el("div", { role: "group", "aria-label": name, class: `edit-${field}` }, ...buttons);
  }

  /** @param {Track} track @param {string} word */
  #key(track, word) {
    if (track.fields.some((it) => it.field === "direction")) return "";
    const at = track.fields[0].words.indexOf(word);
    return track.kind === "bend" ? (word.startsWith("bend") ? word.slice(4) : "") : at < 9 ? String(at + 1) : "";
  }

  /**
   * Return the sign of a word beside the others that are chosen, as SVG.
   * @param {Track} track
   * @param {number} at
   * @param {string} word
   */
  #sign(track, at, word) {
    const signs = this.#alphabet.signs[track.kind], words = this.words(track);
    words[at] = word;
    return signs[words.join(" ")] ?? (track.fields[at].field === "level" ? undefined : signs[word]);
  }

  /**
   * Choose what a key stands for; return whether it is one.
   * @param {string} key
   */
  press(key) {
    const track = this.#track;
    if (!track) return false;
    for (const [at, { field, words }] of track.fields.entries()) {
      const now = this.words(track)[at];
      let word = "";
      if (field === "direction") word = PAD[DIGITS.indexOf(key)] ?? "";
      else if (field === "level") word = Object.entries(LEVEL_KEYS).find(([, it]) => it === key.toLowerCase())?.[0] ?? "";
      else if (!words.length && (key === "[" || key === "]")) word = String(Math.max(0, Number(now) + (key === "]" ? TURN : -TURN)));
      else if (words.length) word = words.find((it) => this.#key(track, it) === key) ?? "";
      if (word && (!words.length || words.includes(word))) {
        this.#choose(at, word);
        return true;
      }
    }
    return false;
  }
}

/** Return a sign, which its button tells. @param {string} text */
function picture(text) {
  const node = svg(text);
  node.setAttribute("aria-hidden", "true");
  node.removeAttribute("role");
  return node;
}
