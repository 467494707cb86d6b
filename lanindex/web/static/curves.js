/** The curves of a limb: its speed, how far it is from where it rested, and the two angles with the borders of cells. */

import { colorOf, DIRECTIONS, LEVELS } from "./cells.js";
import { el, shape } from "./dom.js";
import { nameOf } from "./names.js";

/**
 * @typedef {{cell: string, start: number, end: number, achieved: number, outcome: string, rule: number}} Run
 * @typedef {object} Curves a window, as the server tells it
 * @property {string} part
 * @property {number} rate frames a second
 * @property {Record<"v0" | "d_t", number>} thresholds mm/s and mm
 * @property {Record<string, number>} azimuth_from degrees at which each direction begins
 * @property {Record<string, number>} elevation_from
 * @property {number[]} times seconds
 * @property {number[]} speed
 * @property {number[]} distance
 * @property {number[]} azimuth
 * @property {number[]} elevation
 * @property {string[]} cells
 * @property {number[]} candidates seconds
 * @property {[number, number][]} holds seconds of the first and the last candidate of each
 * @property {[number, number, number, number][]} moves seconds: from, to, seen from, seen to
 * @property {Run[]} runs
 */

const LEFT = 8, RIGHT = 92; // pixels beside the curves; the names of lines stand at the right
const ROWS = /** @type {const} */ ([["speed", 120], ["distance", 60], ["elevation", 78], ["azimuth", 136], ["cells", 20], ["symbols", 20]]);
const GAP = 20, FOOT = 18;
const TALL = ROWS.reduce((sum, [, tall]) => sum + tall + GAP, 0) + FOOT;
const SPANS = [2, 5, 10, 20, 60]; // seconds that are shown
const MARKS = [0.5, 1, 2, 5, 10]; // seconds from one mark of the time to the next
const LETTER = 6.3; // pixels, at most about
const UNITS = /** @type {Record<string, string>} */ ({
  speed: "mm/s", distance: "mm from where it rested", elevation: "elevation, degrees from below", azimuth: "azimuth, degrees from the right",
  cells: "cells it goes through; struck: left out", symbols: "symbols, each to where its direction is achieved",
});

export class CurveView {
  #load;
  #seek;
  #length;
  #plot = shape("svg", { class: "curves", role: "img", height: TALL });
  #line = shape("line", { class: "now", y1: 0, y2: TALL });
  #said = el("p", { class: "num said-now" });
  #state = el("p", { class: "soft", role: "status" });
  #span = 2;
  #time = 0;
  #first = 0;
  /** @type {Curves | null} */
  #shown = null;
  /** @type {AbortController | null} */
  #coming = null;
  /** @type {{node: SVGTextElement, words: string[]}[]} the names of bands, and the cells that lie in them */
  #bands = [];
  #sizes = new ResizeObserver(() => {
    if (this.#shown) this.#draw(this.#shown);
    this.#place();
  });

  /**
   * @param {number} length of the capture, seconds
   * @param {(from: number, to: number, signal: AbortSignal) => Promise<Curves>} load
   * @param {(seconds: number) => void} seek
   */
  constructor(length, load, seek) {
    this.#length = length;
    this.#load = load;
    this.#seek = seek;
    this.root = el("div", {}, this.#plot, this.#said, this.#state);
    this.#sizes.observe(this.root);
    this.#plot.addEventListener("click", (event) => {
      const { left } = this.#plot.getBoundingClientRect();
      const at = (event.clientX - left - LEFT) / (this.#across - LEFT - RIGHT);
      if (at >= 0 && at <= 1) this.#seek(this.#first + at * this.#wide);
    });
  }

  /** Pixels of its width. */
  get #across() {
    return Math.max(this.root.clientWidth, 240);
  }

  /** Seconds that are shown. */
  get #wide() {
    return Math.min(SPANS[this.#span], this.#length);
  }

  /**
   * Show fewer seconds, or more.
   * @param {number} by
   */
  zoom(by) {
    this.#span = Math.min(Math.max(this.#span + by, 0), SPANS.length - 1);
    this.reload();
  }

  /**
   * Fetch what is shown anew: another limb is wanted.
   * @param {number} [seconds] where the line is
   */
  reload(seconds = this.#time) {
    this.#time = seconds;
    this.#shown = null;
    this.#fetch();
  }

  /**
   * Move the line, and the window with it.
   * @param {number} seconds
   */
  show(seconds) {
    this.#time = seconds;
    if (seconds < this.#first || seconds > this.#first + this.#wide) this.#fetch();
    else if (this.#shown) this.#place();
  }

  /** Stop what is on its way. */
  dispose() {
    this.#coming?.abort();
    this.#coming = null;
  }

  /** Fetch the window around the line: that has its middle there where the capture goes on. */
  async #fetch() {
    this.dispose();
    const coming = this.#coming = new AbortController(), wide = this.#wide;
    const first = this.#first = Math.max(Math.min(this.#time - wide / 2, this.#length - wide), 0);
    try {
      const curves = await this.#load(first, first + wide, coming.signal);
      if (coming.signal.aborted) return;
      this.#shown = curves;
      this.#state.textContent = "";
      this.#draw(curves);
      this.#place();
    } catch (error) {
      if (coming.signal.aborted) return;
      this.#shown = null;
      this.#plot.replaceChildren();
      this.#said.textContent = "";
      this.#state.textContent = `There are no curves: ${error instanceof Error ? error.message : error}.`;
    }
  }

  /** @param {number} seconds */
  #x(seconds) {
    const at = (seconds - this.#first) / this.#wide;
    return LEFT + Math.min(Math.max(at, 0), 1) * (this.#across - LEFT - RIGHT);
  }

  /** @param {Curves} it */
  #draw(it) {
    const right = this.#across - RIGHT, first = it.azimuth_from.right ?? 0, azimuths = Object.entries(it.azimuth_from);
    const highest = { speed: Math.max(...it.speed, 1.2 * it.thresholds.v0), distance: Math.max(...it.distance, 3 * it.thresholds.d_t), elevation: 180, azimuth: 360, cells: 1, symbols: 1 };
    const turned = (/** @type {number} */ degrees) => (degrees - first + 360) % 360; // so that no direction is in two pieces
    /** @type {Node[]} */
    const nodes = [];
    let top = GAP;
    this.#bands = [];
    const across = (/** @type {string} */ kind, /** @type {number} */ y) => shape("line", { class: kind, x1: LEFT, x2: right, y1: y, y2: y });
    const label = (/** @type {string} */ text, /** @type {number} */ y) => shape("text", { class: "label", x: right + 6, y: y + 4 }, text);
    for (const [at, [from, to, seen, end]] of it.moves.entries()) {
      nodes.push(shape("rect", { class: at % 2 ? "move odd" : "move", x: this.#x(seen), y: 0, width: Math.max(this.#x(end) - this.#x(seen), 1), height: TALL - FOOT }, shape("title", {}, `segment, ${from.toFixed(2)} to ${to.toFixed(2)} s`)));
    }
    for (const seconds of this.#marks()) {
      nodes.push(shape("line", { class: "mark", x1: this.#x(seconds), x2: this.#x(seconds), y1: 0, y2: TALL - FOOT }), shape("text", { class: "mark", x: this.#x(seconds), y: TALL - 4 }, `${Number(seconds.toFixed(1))} s`));
    }
    for (const [name, tall] of ROWS) {
      const y = (/** @type {number} */ value) => top + tall - tall * value / highest[name];
      nodes.push(shape("text", { class: "unit", x: LEFT, y: top - 5 }, UNITS[name]));
      if (name === "speed" || name === "distance") {
        const [title, value] = name === "speed" ? ["v0", it.thresholds.v0] : ["d_t", it.thresholds.d_t];
        nodes.push(across("base", top + tall), across("threshold", y(value)), label(`${title} ${Math.round(value)}`, y(value)));
        if (y(value) - top > 24) nodes.push(label(`${Math.round(highest[name])}`, top));
      } else if (name === "cells" || name === "symbols") {
        for (const run of name === "cells" ? it.runs : symbolsOf(it)) nodes.push(...this.#cell(run, top, tall));
      } else {
        const starts = name === "azimuth" ? azimuths.map(([word, value]) => /** @type {const} */ ([word, turned(value)])) : Object.entries(it.elevation_from);
        const sorted = [...starts].sort(([, a], [, b]) => a - b);
        for (const [at, [word, value]] of sorted.entries()) {
          const end = sorted[at + 1]?.[1] ?? highest[name], node = label(nameOf(word), y((value + end) / 2));
          const words = it.cells.filter((cell) => cell.split(" ")[name === "azimuth" ? 0 : 1] === word);
          this.#bands.push({ node, words });
          nodes.push(across("border", y(value)), node);
        }
        nodes.push(across("border", top));
      }
      if (name === "azimuth") {
        nodes.push(shape("path", { class: "curve place", d: this.#path(it, it.azimuth.map(turned), y, true) }));
        nodes.push(shape("path", { class: "curve", d: this.#path(it, it.azimuth.map(turned), y, true, (at) => !it.cells[at].startsWith("place")) }));
      } else if (name !== "cells" && name !== "symbols") nodes.push(shape("path", { class: "curve", d: this.#path(it, it[name], y, false) }));
      if (name === "speed") {
        const kept = new Set(it.holds.flat());
        for (const at of it.candidates) {
          const stays = kept.has(at);
          nodes.push(shape("circle", { class: stays ? "candidate kept" : "candidate", cx: this.#x(at), cy: y(it.speed[nearest(it.times, at)]), r: 4 }, shape("title", {}, `candidate, ${at.toFixed(2)} s${stays ? ", the first or the last of a hold" : ", within d_t of others"}`)));
        }
      }
      top += tall + GAP;
    }
    this.#plot.setAttribute("width", String(this.#across));
    this.#line.setAttribute("y2", String(TALL - FOOT));
    this.#plot.replaceChildren(...nodes, this.#line);
    this.#plot.setAttribute("aria-label", `${nameOf(it.part)}, ${this.#first.toFixed(1)} to ${(this.#first + this.#wide).toFixed(1)} s: ${it.candidates.length} candidates, ${it.moves.length} segments; v0 ${Math.round(it.thresholds.v0)} mm/s, d_t ${Math.round(it.thresholds.d_t)} mm`);
  }

  /** Return the seconds that are marked. */
  #marks() {
    const step = MARKS[this.#span], begin = Math.ceil(this.#first / step - 1e-6);
    return Array.from({ length: Math.floor((this.#first + this.#wide) / step + 1e-6) - begin + 1 }, (_, at) => (begin + at) * step);
  }

  /**
   * Return a cell as a piece of a strip: its colour, its name where that has room, struck where it is left out.
   * @param {Run} run
   * @param {number} top
   * @param {number} tall
   */
  #cell({ cell, start, end, achieved, outcome }, top, tall) {
    const [x, to] = [this.#x(start), this.#x(end)], [direction, level] = cell.split(" "), stays = outcome === "symbol";
    if (to - x < 0.5) return [];
    const color = colorOf(3 * DIRECTIONS.indexOf(direction) + LEVELS.indexOf(level)), name = nameOf(cell);
    /** @type {Node[]} */
    const nodes = [shape("rect", { class: "cell", x, y: top, width: to - x, height: tall, fill: `rgb(${color})`, "fill-opacity": stays ? 1 : 0.4 }, shape("title", {}, `${name}, ${stays ? `achieved at ${achieved.toFixed(2)} s` : outcome}`))];
    if (to - x > LETTER * name.length + 6) nodes.push(shape("text", { class: level === "low" && stays ? "cell deep" : "cell", x: (x + to) / 2, y: top + tall / 2 + 4 }, name));
    if (!stays) nodes.push(shape("line", { class: "struck", x1: x + 1, x2: to - 1, y1: top + tall / 2, y2: top + tall / 2 }));
    return nodes;
  }

  /**
   * Return the path of a curve; it breaks where the limb is unknown, and where an angle comes round.
   * @param {Curves} it
   * @param {number[]} values
   * @param {(value: number) => number} y
   * @param {boolean} round
   * @param {(at: number) => boolean} shown
   */
  #path(it, values, y, round, shown = () => true) {
    return values.map((value, at) => {
      if (!shown(at)) return "";
      const breaks = !at || !shown(at - 1) || it.times[at] - it.times[at - 1] > 1.5 / it.rate || round && Math.abs(value - values[at - 1]) > 180;
      return `${breaks ? "M" : "L"}${this.#x(it.times[at]).toFixed(1)} ${y(value).toFixed(1)}`;
    }).join("");
  }

  /** Put the line where the time is, and tell its numbers. */
  #place() {
    const it = this.#shown, x = this.#x(this.#time);
    this.#line.setAttribute("x1", String(x));
    this.#line.setAttribute("x2", String(x));
    if (!it) return;
    const at = nearest(it.times, this.#time), known = at < it.times.length && Math.abs(it.times[at] - this.#time) < 1.5 / it.rate;
    const text = known
      ? `${this.#time.toFixed(2)} s: ${Math.round(it.speed[at])} mm/s, ${Math.round(it.distance[at])} mm from where it rested, azimuth ${Math.round(it.azimuth[at])}\u00b0, elevation ${Math.round(it.elevation[at])}\u00b0: ${nameOf(it.cells[at])}`
      : `${this.#time.toFixed(2)} s: ${nameOf(it.part)} is not known here`;
    if (this.#said.textContent !== text) this.#said.textContent = text;
    for (const { node, words } of this.#bands) node.classList.toggle("here", known && words.includes(it.cells[at]));
  }
}

/**
 * Return the symbols as runs: each goes on from the one before it, or from where its segment is seen to begin.
 * @param {Curves} curves
 * @returns {Run[]}
 */
function symbolsOf({ runs, moves }) {
  const left = runs.filter((it) => it.outcome === "symbol").sort((a, b) => a.achieved - b.achieved);
  return left.map((it, at) => {
    const [first, , seen] = moves.find(([from, to]) => from <= it.start + 1e-6 && it.start < to) ?? [0, 0, it.start], before = left[at - 1];
    return { ...it, start: before && before.start >= first - 1e-6 ? before.achieved : seen, end: it.achieved };
  });
}

/**
 * Return the place of the number that is nearest.
 * @param {number[]} sorted
 * @param {number} value
 */
function nearest(sorted, value) {
  let low = 0, high = sorted.length - 1;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] < value) low = middle + 1;
    else high = middle;
  }
  return low && value - sorted[low - 1] < sorted[low] - value ? low - 1 : low;
}
