/** Hits as cards: their poses and staff, which come when they are seen, and move when pointed at. */

import { address, get, isAbort, problemOf } from "./api.js";
import { duration, el, svg, trouble } from "./dom.js";
import { Figure } from "./figure.js";
import { Motion } from "./motion.js";
import { nameOf } from "./names.js";
import { Player } from "./player.js";

/**
 * @typedef {{part: string, direction: string, level: string, start_frame: number, end_frame: number}} Matched
 * @typedef {object} Hit
 * @property {string} capture
 * @property {number} capture_id
 * @property {string} label
 * @property {number} fps
 * @property {number} start_frame
 * @property {number} end_frame
 * @property {number} start
 * @property {number} end
 * @property {number} fit
 * @property {Matched[]} symbols
 *
 * @typedef {{poses: string, staff: string, trouble: string, words: string, parts: string[], tall: number}} Card
 */

const BESIDE = 0.4; // seconds around a hit that are played, too

/** Shows hits in a list; those of one capture that follow each other stand below its name. */
export class HitList {
  root = el("ol", { class: "hits" });
  #seen = new IntersectionObserver((entries) => this.#show(entries), { rootMargin: "300px" });
  /** @type {Map<Element, () => void>} */
  #waiting = new Map();
  #signal;
  #before = -1;

  /**
   * @param {AbortSignal} signal
   * @param {string} folder the one in which all captures are
   * @param {(hit: Hit) => HTMLElement[]} actions what can be done with a hit
   */
  constructor(signal, folder, actions) {
    this.#signal = signal;
    this.folder = folder;
    this.actions = actions;
    signal.addEventListener("abort", () => this.#seen.disconnect());
  }

  clear() {
    this.root.replaceChildren();
    this.#waiting.clear();
    this.#before = -1;
  }

  /** How many hits are shown. */
  get length() {
    return this.root.querySelectorAll(".hit").length;
  }

  /**
   * @param {Hit[]} hits
   * @param {(index: number) => string} card the address of the pictures of a hit
   * @param {(hit: Hit) => string} link
   * @param {boolean} grouped whether a capture's name stands above its hits, not on each
   */
  add(hits, card, link, grouped) {
    const first = this.length;
    hits.forEach((hit, at) => {
      if (grouped && hit.capture_id !== this.#before) this.root.append(el("li", { class: "capture" }, this.#name(hit)));
      this.#before = hit.capture_id;
      this.root.append(this.#card(hit, card(first + at), link(hit), grouped));
    });
  }

  /** @param {Hit} hit */
  #name(hit) {
    const path = hit.capture.slice(this.folder.length), name = path.slice(path.lastIndexOf("/") + 1);
    return el("div", { class: "named" }, el("a", { class: "path", href: `/captures/${hit.capture_id}`, title: hit.capture }, name), el("span", { class: "soft" }, hit.label), el("span", { class: "soft folder" }, path.slice(0, -name.length)));
  }

  /** @param {IntersectionObserverEntry[]} entries */
  #show(entries) {
    for (const { target, isIntersecting } of entries) {
      if (!isIntersecting) continue;
      this.#seen.unobserve(target);
      this.#waiting.get(target)?.();
      this.#waiting.delete(target);
    }
  }

  /**
   * @param {Hit} hit
   * @param {string} pictures
   * @param {string} link
   * @param {boolean} grouped
   */
  #card(hit, pictures, link, grouped) {
    const poses = el("div", { class: "poses" }), staff = el("div", { class: "strip" });
    const words = el("p", { class: "soft words" }, hit.symbols.map(({ part, direction, level }) => [part, direction, level].filter(Boolean).map(nameOf).join(" ")).join(", "));
    const item = el("li", { class: "card hit" },
      !grouped && this.#name(hit),
      el("a", { class: "show", href: link }, el("span", { class: "hidden" }, `Watch ${hit.capture}, ${hit.start.toFixed(2)} to ${hit.end.toFixed(2)} s`), el("div", { class: "seen", "aria-hidden": "true" }, poses, staff)),
      el("div", { class: "row num" },
        el("span", {}, `${hit.start.toFixed(2)}\u2013${hit.end.toFixed(2)} s`),
        el("span", { class: "soft length" }, duration(hit.end - hit.start)),
        el("span", { class: "soft", title: "How clearly its symbols lie in their cells, from 0 to 1; below 0.5 it differs from the pattern" }, `fit ${hit.fit.toFixed(2)}`),
        el("span", { class: "grow" }), ...this.actions(hit)),
      words);
    this.#waiting.set(item, async () => {
      try {
        const card = /** @type {Card} */ (await get(pictures, this.#signal));
        if (card.poses) poses.append(svg(card.poses));
        if (card.staff) staff.append(svg(card.staff));
        if (card.trouble) poses.append(el("p", { class: "soft" }, card.trouble));
        words.textContent = card.words || words.textContent;
        if (card.poses) moves(item, poses, hit, card);
      } catch (error) {
        if (!isAbort(error)) poses.append(trouble(problemOf(error)));
      }
    });
    this.#seen.observe(item);
    return item;
  }
}

/**
 * Let a card move while it is pointed at or has the focus.
 * @param {HTMLElement} card
 * @param {HTMLElement} place
 * @param {Hit} hit
 * @param {Card} pictures
 */
function moves(card, place, hit, { parts, tall }) {
  /** @type {(() => void) | null} */
  let stop = null;
  const start = async () => {
    if (stop) return;
    let gone = false;
    stop = () => { gone = true; };
    const path = `/api/captures/${hit.capture_id}`;
    const description = await get(`${path}/figure`).catch(() => null);
    if (gone || !description) return;
    const canvas = el("canvas", { class: "moving" });
    place.append(canvas);
    const figure = new Figure(canvas), motion = new Motion(path, description), player = new Player(motion, description.rate);
    canvas.tabIndex = -1;
    figure.floor = description.floor;
    figure.span = tall * place.clientHeight / drawnHeight(place.querySelector("svg"));
    const lit = new Set(parts), { strokes } = description;
    motion.changed = () => player.refresh();
    player.listen((seconds) => {
      const pose = motion.pose(seconds);
      if (pose) figure.show([{ strokes, pose, lit }]);
    });
    player.range = [Math.max(hit.start - BESIDE, 0), Math.min(hit.end + BESIDE, motion.seconds)];
    player.loop = true;
    player.seek(player.range[0]);
    player.play();
    stop = () => {
      player.dispose();
      motion.abort();
      figure.dispose();
      canvas.remove();
    };
  };
  const end = () => {
    stop?.();
    stop = null;
  };
  card.addEventListener("pointerenter", start);
  card.addEventListener("pointerleave", end);
  card.addEventListener("focusin", start);
  card.addEventListener("focusout", end);
}

/**
 * Return how high a picture is drawn, which keeps its proportions: its place may be higher.
 * @param {SVGSVGElement | null} picture
 */
function drawnHeight(picture) {
  const { width = 1, height = 1 } = picture?.viewBox.baseVal ?? {};
  return Math.min(picture?.clientHeight ?? 1, (picture?.clientWidth ?? 1) * height / width);
}

/**
 * Return the address at which a hit is watched.
 * @param {Hit} hit
 * @param {string} query
 */
export function watching(hit, query) {
  const lit = [...new Set(hit.symbols.map((it) => it.part))].join(",");
  return address(`/captures/${hit.capture_id}`, { from: hit.start, to: hit.end, lit, q: query });
}
