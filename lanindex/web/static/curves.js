/** The curves of a limb: its speed, how far it is from where it rested, and the two angles with the borders of cells. */

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
 * @property {[number, number, number, number][]} moves seconds: from, to, seen from, seen to
 * @property {Run[]} runs
 */

const WIDE = 1000, LEFT = 8, RIGHT = 92; // the names of lines stand at the right
const ROWS = /** @type {const} */ ([["speed", 130], ["distance", 70], ["azimuth", 150], ["elevation", 90]]);
const GAP = 18;
const TALL = ROWS.reduce((sum, [, tall]) => sum + tall + GAP, 0);
const SPANS = [2, 5, 10, 20, 60]; // seconds that are shown

export class CurveView {
  #load;
  #seek;
  #length;
  #plot = shape("svg", { class: "curves", viewBox: `0 0 ${WIDE} ${TALL}`, role: "img" });
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

  /**
   * @param {number} length of the capture, seconds
   * @param {(from: number, to: number, signal: AbortSignal) => Promise<Curves>} load
   * @param {(seconds: number) => void} seek
   */
  constructor(length, load, seek) {
    this.#length = length;
    this.#load = load;
    this.#seek = seek;
    this.root = el("div", {}, el("div", { class: "scrolled", tabindex: "0", role: "group", "aria-label": "Curves" }, this.#plot), this.#said, this.#state);
    this.#plot.addEventListener("click", (event) => {
      const { left, width } = this.#plot.getBoundingClientRect();
      const at = ((event.clientX - left) / width * WIDE - LEFT) / (WIDE - LEFT - RIGHT);
      if (at >= 0 && at <= 1) this.#seek(this.#first + at * this.#wide);
    });
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
    return LEFT + Math.min(Math.max(at, 0), 1) * (WIDE - LEFT - RIGHT);
  }

  /** @param {Curves} it */
  #draw(it) {
    /** @type {Record<string, [string, number][]>} */
    const lines = {
      speed: [[`v0 ${Math.round(it.thresholds.v0)}`, it.thresholds.v0]],
      distance: [[`d_t ${Math.round(it.thresholds.d_t)}`, it.thresholds.d_t]],
      azimuth: Object.entries(it.azimuth_from),
      elevation: Object.entries(it.elevation_from),
    };
    const highest = { speed: Math.max(...it.speed, 1.2 * it.thresholds.v0), distance: Math.max(...it.distance, 3 * it.thresholds.d_t), azimuth: 360, elevation: 180 };
    const units = { speed: "mm/s", distance: "mm from where it rested", azimuth: "azimuth, degrees", elevation: "elevation, degrees from below" };
    /** @type {Record<string, number>} */
    const down = { low: -2 };
    /** @type {Node[]} */
    const nodes = [];
    let top = GAP;
    for (const [at, [from, to, seen, end]] of it.moves.entries()) {
      nodes.push(shape("rect", { class: at % 2 ? "move odd" : "move", x: this.#x(seen), y: 0, width: Math.max(this.#x(end) - this.#x(seen), 1), height: TALL }, shape("title", {}, `segment, ${from.toFixed(2)} to ${to.toFixed(2)} s`)));
    }
    for (const [name, tall] of ROWS) {
      const y = (/** @type {number} */ value) => top + tall - tall * value / highest[name];
      nodes.push(shape("line", { class: "base", x1: LEFT, x2: WIDE - RIGHT, y1: top + tall, y2: top + tall }), shape("text", { class: "unit", x: LEFT, y: top - 4 }, units[name]));
      for (const [label, value] of lines[name]) {
        nodes.push(shape("line", { class: name === "azimuth" || name === "elevation" ? "border" : "threshold", x1: LEFT, x2: WIDE - RIGHT, y1: y(value), y2: y(value) }), shape("text", { class: "label", x: WIDE - RIGHT + 5, y: y(value) + (down[label] ?? 4) }, nameOf(label)));
      }
      nodes.push(shape("path", { class: `curve ${name}`, d: this.#path(it, it[name], y, name === "azimuth") }));
      if (name === "speed") for (const at of it.candidates) nodes.push(shape("circle", { class: "candidate", cx: this.#x(at), cy: y(it.speed[nearest(it.times, at)]), r: 4 }, shape("title", {}, `candidate, ${at.toFixed(2)} s`)));
      top += tall + GAP;
    }
    for (const run of it.runs) {
      if (run.outcome === "symbol" && run.achieved >= it.times[0]) nodes.push(shape("circle", { class: "achieved", cx: this.#x(run.achieved), cy: top - GAP - 4, r: 4 }, shape("title", {}, `${nameOf(run.cell)}, ${run.achieved.toFixed(2)} s`)));
    }
    this.#plot.replaceChildren(...nodes, this.#line);
    this.#plot.setAttribute("aria-label", `${nameOf(it.part)}, ${this.#first.toFixed(1)} to ${(this.#first + this.#wide).toFixed(1)} s: ${it.candidates.length} candidates, ${it.moves.length} segments; v0 ${Math.round(it.thresholds.v0)} mm/s, d_t ${Math.round(it.thresholds.d_t)} mm`);
  }

  /**
   * Return the path of a curve; it breaks where the limb is unknown, and where an angle comes round.
   * @param {Curves} it
   * @param {number[]} values
   * @param {(value: number) => number} y
   * @param {boolean} round
   */
  #path(it, values, y, round) {
    return values.map((value, at) => {
      const breaks = !at || it.times[at] - it.times[at - 1] > 1.5 / it.rate || round && Math.abs(value - values[at - 1]) > 180;
      return `${breaks ? "M" : "L"}${this.#x(it.times[at]).toFixed(1)} ${y(value).toFixed(1)}`;
    }).join("");
  }

  /** Put the line where the time is, and tell its numbers. */
  #place() {
    const it = this.#shown, x = this.#x(this.#time);
    this.#line.setAttribute("x1", String(x));
    this.#line.setAttribute("x2", String(x));
    this.#reveal(x);
    if (!it) return;
    const at = nearest(it.times, this.#time), known = at < it.times.length && Math.abs(it.times[at] - this.#time) < 1.5 / it.rate;
    const text = known
      ? `${this.#time.toFixed(2)} s: ${Math.round(it.speed[at])} mm/s, ${Math.round(it.distance[at])} mm from where it rested, azimuth ${Math.round(it.azimuth[at])}\u00b0, elevation ${Math.round(it.elevation[at])}\u00b0: ${nameOf(it.cells[at])}`
      : `${this.#time.toFixed(2)} s: ${nameOf(it.part)} is not known here`;
    if (this.#said.textContent !== text) this.#said.textContent = text;
  }

  /** Scroll to where the line is, on a page that is narrower than the plot. @param {number} x */
  #reveal(x) {
    const box = /** @type {HTMLElement} */ (this.#plot.parentElement), { scrollLeft, clientWidth } = box;
    const at = x / WIDE * this.#plot.clientWidth;
    if (at < scrollLeft || at > scrollLeft + clientWidth) box.scrollLeft = at - clientWidth / 4; // it goes to the right
  }
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
