// The picture of a printed score beside its staff: where signs stand on it, and what is still to be checked.

import { counted, el, shape } from "../dom.js";
import { nameOf } from "../names.js";
import { placeOf } from "./score.js";

/**
 * @typedef {import("./score.js").Score} Score
 * @typedef {import("./score.js").Sign} Sign
 * @typedef {[number, number, number, number]} Box left, top, right, bottom
 *
 * @typedef {object} Seen a sign on the picture
 * @property {string} part
 * @property {number} start
 * @property {number} stop
 * @property {string[]} words
 * @property {number} page
 * @property {Box} box
 * @property {Box} around what is shown of it by itself
 * @property {"known" | "doubtful" | "unknown"} kind
 * @property {number} sure 0 to 1
 *
 * @typedef {object} Printed
 * @property {string[]} notes what of its pages is not known but no sign
 * @property {{image: string, width: number, height: number}[]} pages
 * @property {Seen[]} signs
 */

/** Return what a symbol that was read is known by, whatever becomes of it. @param {{part: string, start: number, stop: number}} it */
function key(it) {
  return `${it.part} ${it.start} ${it.stop}`;
}

/** Return a score whose symbols know which sign of a picture they were. @param {Score} score @returns {Score} */
export function linked(score) {
  return { ...score, symbols: score.symbols.map((it) => ({ ...it, seen: key(it) })) };
}

export class Picture {
  /** The pages. */
  root = el("div", { class: "edit-picture", "aria-hidden": "true" });
  /** What is to be checked. */
  list = el("section", { class: "edit-checks", "aria-label": "To be checked" });
  /** @type {ReadonlySet<string>} what a person has checked: the keys of its signs */
  checked;
  #printed;
  #choose;
  /** @type {Map<Seen, SVGRectElement>} */
  #boxes = new Map();
  /** @type {Map<Seen, HTMLElement>} */
  #cards = new Map();
  #count = el("h2", {});
  #all;
  /** @type {Seen | undefined} */
  #shown;

  /**
   * @param {Printed} printed
   * @param {Iterable<string>} checked
   * @param {(seen: Seen) => void} choose
   * @param {() => void} changed something was checked
   */
  constructor(printed, checked, choose, changed) {
    this.#printed = printed;
    this.#choose = choose;
    this.checked = new Set(checked);
    this.root.append(...printed.pages.map((page, at) => this.#page(page, at)));
    const cards = el("div", { class: "edit-cards" }, ...printed.signs.filter((it) => it.kind !== "known").map((it) => this.#card(it, changed)));
    this.#all = el("button", { type: "button", onclick: () => {
      this.checked = new Set(printed.signs.map(key));
      changed();
    } }, "Check off all");
    const notes = el("ul", { hidden: !printed.notes.length }, ...printed.notes.map((it) => el("li", {}, it)));
    this.list.append(this.#count, notes, cards, this.#all);
  }

  /** @param {Printed["pages"][number]} page @param {number} at */
  #page({ image, width, height }, at) {
    const all = shape("g", { id: `edit-page-${at}` }, shape("image", { href: image, width, height }));
    const boxes = this.#printed.signs.filter((it) => it.page === at).map((it) => {
      const [left, top, right, bottom] = it.box;
      const box = shape("rect", { x: left, y: top, width: right - left, height: bottom - top, class: `edit-seen-${it.kind}` });
      box.addEventListener("click", () => this.#choose(it));
      this.#boxes.set(it, box);
      return box;
    });
    return shape("svg", { viewBox: `0 0 ${width} ${height}` }, all, ...boxes);
  }

  /** @param {Seen} it @param {() => void} changed */
  #card(it, changed) {
    const [left, top, right, bottom] = it.around;
    const crop = shape("svg", { viewBox: `${left} ${top} ${right - left} ${bottom - top}`, "aria-hidden": "true" }, shape("use", { href: `#edit-page-${it.page}` }),
      shape("rect", { x: it.box[0], y: it.box[1], width: it.box[2] - it.box[0], height: it.box[3] - it.box[1], class: `edit-seen-${it.kind}` }));
    const words = el("span", {});
    const card = el("div", { class: "edit-check" },
      el("button", { type: "button", class: "plain", onclick: () => this.#choose(it) }, crop, words),
      el("button", { type: "button", onclick: () => {
        this.checked = new Set([...this.checked, key(it)]);
        changed();
      } }, it.kind === "unknown" ? "Leave out" : "It is right"));
    this.#cards.set(it, card);
    return card;
  }

  /** Return what became of a sign. @param {Score} score @param {Seen} it */
  symbol(score, it) {
    return it.kind === "unknown" ? undefined : score.symbols.find((other) => other.seen === key(it));
  }

  /** Return the sign that is not known at a place, or undefined. @param {{part: string, tick: number}} cell */
  gap({ part, tick }) {
    return this.#printed.signs.find((it) => it.kind === "unknown" && it.part === part && (tick < 0 ? it.stop === 0 : it.stop > 0 && (it.start === tick || it.start <= tick && tick < it.stop)));
  }

  /** Return the parts of signs that are not known. */
  get parts() {
    return new Set(this.#printed.signs.filter((it) => it.kind === "unknown").map((it) => it.part));
  }

  /**
   * Return what is still to be checked: doubtful symbols as they were read, signs that nothing was written for.
   * @param {Score} score
   * @returns {{doubtful: Set<Sign>, unknown: Seen[]}}
   */
  open(score) {
    const doubtful = new Set(), unknown = [], there = new Map(score.symbols.map((it) => [key(it), it]));
    for (const it of this.#printed.signs) {
      if (it.kind === "known" || this.checked.has(key(it))) continue;
      const own = there.get(key(it));
      if (it.kind === "unknown") {
        if (!own && !score.symbols.some((other) => other.part === it.part && other.start < it.stop && it.start < other.stop)) unknown.push(it);
      } else if (own?.seen === key(it) && own.words.join() === it.words.join()) doubtful.add(own);
    }
    return { doubtful, unknown };
  }

  /**
   * Show what is chosen, and what is left to be checked.
   * @param {Score} score
   * @param {Sign[]} selection
   * @param {{part: string, tick: number}} cell
   */
  refresh(score, selection, cell) {
    const { doubtful, unknown } = this.open(score), left = new Set([...doubtful].map((it) => it.seen));
    const chosen = new Set(selection.map((it) => it.seen)), gap = selection.length ? undefined : this.gap(cell);
    /** @type {Seen | undefined} */
    let shown;
    for (const [it, box] of this.#boxes) {
      const own = it.kind === "unknown" ? it === gap : chosen.has(key(it));
      if (own) shown ??= it;
      box.classList.toggle("edit-seen-chosen", own);
      const still = it.kind === "unknown" ? unknown.includes(it) : left.has(key(it));
      box.classList.toggle("edit-seen-done", it.kind !== "known" && !still);
      const card = this.#cards.get(it);
      if (!card) continue;
      card.hidden = !still;
      card.classList.toggle("edit-seen-chosen", own);
      const what = it.kind === "unknown" ? "not known" : `${it.words.map(nameOf).join(" ")}, ${Math.round(it.sure * 100)} % sure`;
      const words = /** @type {HTMLElement} */ (card.querySelector("span"));
      words.textContent = `${it.part ? nameOf(it.part) : "no column"}, ${placeOf(score, it.stop ? it.start : -1)}: ${what}`;
    }
    const counts = [...(unknown.length ? [`${counted(unknown.length, "sign")} not known`] : []), ...(left.size ? [`${left.size} doubtful`] : [])];
    this.#all.hidden = !counts.length;
    this.#count.textContent = counts.length ? `To be checked: ${counts.join(", ")}` : "All is checked";
    if (shown && shown !== this.#shown) this.#reveal(shown);
    this.#shown = shown;
  }

  /** Point to a sign that has no place on the staff. @param {Seen} it */
  point(it) {
    for (const [other, box] of this.#boxes) box.classList.toggle("edit-seen-chosen", other === it);
    for (const [other, card] of this.#cards) card.classList.toggle("edit-seen-chosen", other === it);
    this.#reveal(it);
  }

  /** Show where the score begins. */
  begin() {
    if (this.#printed.signs.length) this.#reveal(this.#printed.signs[0]);
  }

  /** Bring a sign to where it is seen, on the page and in the list. @param {Seen} it */
  #reveal(it) {
    for (const [node, root] of [[this.#boxes.get(it), this.root], [this.#cards.get(it), this.#cards.get(it)?.parentElement]]) {
      if (!node || !root) continue;
      const own = node.getBoundingClientRect(), seen = root.getBoundingClientRect();
      if (own.top < seen.top || own.bottom > seen.bottom) root.scrollTop += (own.top + own.bottom - seen.top - seen.bottom) / 2;
      if (own.left < seen.left || own.right > seen.right) root.scrollLeft += (own.left + own.right - seen.left - seen.right) / 2;
    }
  }

  /** How large the pages are, of what fits. @param {number} scale */
  set scale(scale) {
    for (const page of this.root.querySelectorAll("svg")) page.style.width = `${100 * scale}%`;
  }
}
