// The staff on which a score is written: drawn by the server, with the cursor and the selection over it.

import { isAbort, problemOf, send } from "../api.js";
import { el, svg } from "../dom.js";
import { nameOf } from "../names.js";
import { around, end, grain, packed } from "./score.js";

/**
 * @typedef {import("./score.js").Score} Score
 * @typedef {import("./score.js").Sign} Sign
 * @typedef {import("./score.js").Track} Track
 * @typedef {{part: string, tick: number}} Cell a place on the staff; below tick 0 are the positions
 *
 * @typedef {object} Drawing
 * @property {string} svg
 * @property {number} from beat
 * @property {number} to
 * @property {number} foot pixels below the first beat
 * @property {number} beat pixels of one
 * @property {number} beats of all bars
 * @property {number} width
 * @property {Record<string, [number, number]>} columns
 * @property {number[]} seconds at which beats are
 * @property {string[]} warnings
 *
 * @typedef {object} Hands what is done to the score
 * @property {() => {score: Score, selection: Sign[], cell: Cell, step: number}} state
 * @property {(cell: Cell, sign: Sign | null, more: boolean) => void} press
 * @property {(signs: Sign[]) => void} take
 * @property {(by: {ticks: number, part?: string}) => void} move
 * @property {(begins: number, ends: number) => void} stretch
 * @property {(problem: import("../api.js").Problem) => void} fail
 * @property {(drawing: Drawing) => void} drawn
 */

const LANE = 46; // pixels of a lane beside the staff, of what has no column
const EDGE = 6; // pixels at the end of a symbol by which it is stretched
const FINGER = 18; // the same where it is a finger that holds it
const CLICK = 4; // pixels that a press may move and still be none that drags
const START = 64; // pixels of the positions, before the first drawing tells
const REACH = 4; // beats beside a window whose symbols are sent, too: those that are short make room for each other

export class Paper {
  #hands;
  #sheet = el("div", { class: "edit-sheet" });
  #drawn = el("div", { class: "edit-drawn" });
  #over = el("div", { class: "edit-over" });
  #names = el("div", { class: "edit-names", "aria-hidden": "true" });
  #line = el("div", { class: "edit-line", hidden: true });
  #grid = el("div", { class: "edit-grid" });
  /** @type {Drawing | null} */
  #drawing = null;
  /** @type {AbortController} */
  #coming = new AbortController();
  #gone = new AbortController();
  /** @type {Track[]} */
  #tracks = [];
  /** @type {[number, number] | null} beats that are asked for */
  #asked = null;
  #height = 0;
  scale = 1.5;
  /** @type {ReadonlySet<Sign>} what is otherwise in another score */
  marked = new Set();
  /** @type {ReadonlySet<Sign>} what was read from a picture and may be otherwise there */
  doubtful = new Set();
  /** @type {{part: string, start: number, stop: number}[]} where a picture has what was not read */
  unknown = [];

  /**
   * @param {HTMLElement} root scrolls
   * @param {Hands} hands
   */
  constructor(root, hands) {
    this.root = root;
    this.#hands = hands;
    this.#sheet.append(this.#grid, this.#drawn, this.#over, this.#line);
    root.append(this.#sheet, this.#names);
    const { signal } = this.#gone;
    root.addEventListener("scroll", () => this.#scrolled(), { signal });
    const sizes = new ResizeObserver(() => this.#scrolled());
    sizes.observe(root);
    signal.addEventListener("abort", () => sizes.disconnect());
    this.#listen();
  }

  dispose() {
    this.#gone.abort();
    this.#coming.abort();
  }

  /** The columns, from left to right, and the lanes beside them. */
  get lanes() {
    const columns = this.#drawing?.columns ?? {}, width = this.#drawing?.width ?? 0;
    const inside = this.#tracks.filter((it) => it.column && columns[it.part]).map((it) => ({ track: it, left: columns[it.part][0], right: columns[it.part][1] }));
    const beside = this.#tracks.filter((it) => !it.column).map((track, at) => ({ track, left: width + at * LANE, right: width + (at + 1) * LANE }));
    return [...inside.sort((a, b) => a.left - b.left), ...beside];
  }

  /** @param {Track[]} tracks */
  set tracks(tracks) {
    this.#tracks = tracks;
  }

  /** Return the seconds of a tick. @param {number} tick */
  seconds(tick) {
    const table = this.#drawing?.seconds ?? [0], { score } = this.#hands.state();
    const beat = Math.min(Math.max(tick / grain(score), 0), table.length - 1), at = Math.min(Math.floor(beat), table.length - 2);
    return at < 0 ? 0 : table[at] + (beat - at) * (table[at + 1] - table[at]);
  }

  /** Return the tick of some seconds. @param {number} seconds */
  tick(seconds) {
    const table = this.#drawing?.seconds ?? [0], { score } = this.#hands.state();
    let at = table.findIndex((it) => it > seconds) - 1;
    if (at < 0) at = table.length - 2;
    return at < 0 ? 0 : (at + (seconds - table[at]) / (table[at + 1] - table[at] || 1)) * grain(score);
  }

  /** Draw the score anew. */
  async draw() {
    this.#coming.abort();
    const own = (this.#coming = new AbortController());
    const { score } = this.#hands.state(), [from, to] = this.#window();
    this.#asked = [from, to];
    try {
      const parts = this.#tracks.filter((it) => it.drawn).map((it) => it.part);
      const near = around(score, (from - REACH) * grain(score), (to + REACH) * grain(score));
      /** @type {Promise<Drawing>} */
      const coming = send("POST", "/api/scores/draw", { score: packed(near), parts, from, to, scale: this.scale }, own.signal);
      this.refresh();
      const drawing = await coming;
      if (own.signal.aborted) return;
      const first = this.#drawing === null, node = svg(drawing.svg);
      node.querySelectorAll("title, desc").forEach((it) => it.remove()); // they would show as hints
      node.setAttribute("aria-hidden", "true");
      node.removeAttribute("role");
      const beat = this.#drawing?.beat ?? drawing.beat;
      this.#drawing = drawing;
      this.#drawn.replaceChildren(node);
      this.#lay(beat);
      if (first) this.root.scrollTop = this.root.scrollHeight;
      this.refresh();
      this.#hands.drawn(drawing);
    } catch (error) {
      if (!isAbort(error)) this.#hands.fail(problemOf(error));
    }
  }

  /** Return the beats that shall be drawn: those that are seen, and half as many on either side. */
  #window() {
    const { beat, foot } = this.#shape(), { clientHeight, scrollTop, scrollHeight } = this.root;
    const low = (scrollHeight - scrollTop - clientHeight - foot) / beat, tall = clientHeight / beat;
    return [Math.max(Math.floor(low - tall / 2), 0), Math.max(Math.ceil(low + 1.5 * tall), 4)];
  }

  #scrolled() {
    if (!this.#drawing || !this.#asked) return;
    const { beat, foot } = this.#shape(), { clientHeight, scrollTop, scrollHeight } = this.root;
    const low = (scrollHeight - scrollTop - clientHeight - foot) / beat, high = low + clientHeight / beat;
    const [from, to] = this.#asked;
    if (low < from && from > 0 || high > to && to < this.#drawing.beats) this.draw();
  }

  #shape() {
    const beat = this.#drawing?.beat ?? 56 * this.scale, foot = this.#start();
    return { beat, foot };
  }

  #start() {
    return START * this.scale;
  }

  /**
   * Put the drawing where it belongs; what is seen stays where it is.
   * @param {number} before pixels of a beat until now
   */
  #lay(before) {
    const drawing = /** @type {Drawing} */ (this.#drawing), { beat, foot } = this.#shape();
    const height = foot + drawing.beats * beat + 24 * this.scale;
    const below = this.root.scrollHeight - this.root.scrollTop - this.root.clientHeight;
    this.#sheet.style.height = `${height}px`;
    const beside = this.#tracks.filter((it) => !it.column).length;
    this.#sheet.style.width = `${drawing.width + beside * LANE}px`;
    if (height !== this.#height) this.root.scrollTop = this.root.scrollHeight - this.root.clientHeight - below * beat / before;
    this.#height = height;
    this.#drawn.style.bottom = `${foot - drawing.foot + drawing.from * beat}px`;
    this.#names.style.width = this.#sheet.style.width;
    this.#names.replaceChildren(...this.lanes.map(({ track, left, right }) => {
      const node = el("span", {}, track.column ? nameOf(track.part).replace(/^(right|left) /, "") : nameOf(track.part));
      node.style.left = `${(left + right) / 2}px`;
      return node;
    }));
  }

  /** Draw the cursor, the selection and what has no column. */
  refresh() {
    const { score, selection, cell, step } = this.#hands.state(), lanes = this.lanes, { beat, foot } = this.#shape();
    const chosen = new Set(selection), { marked, doubtful } = this;
    this.#grid.style.bottom = `${foot}px`;
    this.#grid.style.setProperty("--beat", `${beat}px`);
    this.#grid.style.setProperty("--step", `${step / grain(score) * beat}px`);
    /** @type {HTMLElement[]} */
    const boxes = [];
    for (const { track, left, right } of lanes) {
      for (const gap of this.unknown) {
        if (gap.part === track.part) boxes.push(this.#box("edit-gap", left, right, ...this.#ends(gap), "?"));
      }
      if (track.column && !selection.length && !marked.size && !doubtful.size) continue;
      for (const sign of score.symbols) {
        if (sign.part !== track.part || track.column && !chosen.has(sign) && !marked.has(sign) && !doubtful.has(sign)) continue;
        const kind = `${chosen.has(sign) ? "edit-chosen" : ""} ${track.column ? "" : `edit-block edit-${track.kind}`} ${marked.has(sign) ? "edit-differs" : ""} ${doubtful.has(sign) ? "edit-doubtful" : ""}`;
        boxes.push(this.#box(kind, left, right, ...this.#ends(sign), track.column ? "" : sign.words.map(nameOf).join(" ")));
      }
    }
    const lane = lanes.find((it) => it.track.part === cell.part);
    if (lane) {
      const [low, high] = cell.tick < 0 ? [6, this.#start() - 6] : [this.#y(cell.tick), this.#y(cell.tick + step)];
      boxes.push(this.#box("edit-cursor", lane.left, lane.right, low, high));
    }
    this.#over.replaceChildren(...boxes);
  }

  /** @param {{start: number, stop: number}} sign @returns {[number, number]} pixels from below */
  #ends(sign) {
    if (sign.stop === 0) return [6, this.#start() - 6];
    return [this.#y(sign.start), Math.max(this.#y(sign.stop), this.#y(sign.start) + 5)];
  }

  /** @param {number} tick */
  #y(tick) {
    const { beat, foot } = this.#shape();
    return foot + tick / grain(this.#hands.state().score) * beat;
  }

  /**
   * @param {string} kind
   * @param {number} left
   * @param {number} right
   * @param {number} low
   * @param {number} high
   * @param {string} [text]
   */
  #box(kind, left, right, low, high, text = "") {
    const node = el("div", { class: kind }, text);
    Object.assign(node.style, { left: `${left}px`, width: `${right - left}px`, bottom: `${low}px`, height: `${high - low}px` });
    return node;
  }

  /** Show where the figure is; null: nowhere. @param {number | null} seconds */
  play(seconds) {
    this.#line.hidden = seconds === null;
    if (seconds === null) return;
    const y = this.#y(this.tick(seconds));
    this.#line.style.bottom = `${y}px`;
    this.#reveal(y, y + 40);
  }

  /** Bring the cursor to where it is seen. */
  follow() {
    const { cell, step } = this.#hands.state(), lane = this.lanes.find((it) => it.track.part === cell.part);
    if (cell.tick < 0) this.#reveal(0, this.#start());
    else this.#reveal(this.#y(cell.tick), this.#y(cell.tick + step));
    if (!lane) return;
    const { scrollLeft, clientWidth } = this.root;
    if (lane.left < scrollLeft) this.root.scrollLeft = lane.left - 30;
    else if (lane.right > scrollLeft + clientWidth) this.root.scrollLeft = lane.right + 30 - clientWidth;
  }

  /** @param {number} low pixels from below @param {number} high */
  #reveal(low, high) {
    const { root } = this, names = this.#names.offsetHeight;
    const below = root.scrollHeight - names - root.scrollTop - root.clientHeight + names; // of the sheet, not seen
    if (low < below + 4) root.scrollTop += below + 4 - low;
    else if (high > below + root.clientHeight - names - 4) root.scrollTop -= high - (below + root.clientHeight - names - 4);
  }

  /** @param {{clientX: number, clientY: number}} event */
  #at(event) {
    const box = this.#sheet.getBoundingClientRect();
    return { x: event.clientX - box.left, y: box.bottom - event.clientY };
  }

  /** @param {number} y pixels from below */
  #tickAt(y) {
    const { beat, foot } = this.#shape();
    return (y - foot) / beat * grain(this.#hands.state().score);
  }

  /** @param {{x: number, y: number}} at @returns {{cell: Cell, sign: Sign | null} | null} */
  #what({ x, y }) {
    const lane = this.lanes.find((it) => it.left <= x && x < it.right);
    if (!lane) return null;
    const { score, step } = this.#hands.state(), { part } = lane.track, tick = this.#tickAt(y);
    const own = score.symbols.filter((it) => it.part === part);
    const sign = own.find((it) => { const [low, high] = this.#ends(it); return low - 1 <= y && y <= high + 1; }) ?? null;
    const cell = { part, tick: tick < 0 ? -1 : Math.min(Math.floor(tick / step + 1e-6) * step, end(score) - 1) };
    return { cell: sign ? { part, tick: sign.stop === 0 ? -1 : sign.start } : cell, sign };
  }

  #listen() {
    const { signal } = this.#gone;
    /** @typedef {{x: number, y: number}} Point */
    /** @type {{at: Point, what: {cell: Cell, sign: Sign | null} | null, kind: "move" | "start" | "stop" | "frame", moved: boolean, more: boolean} | null} */
    let press = null;
    const ghost = el("div", { class: "edit-ghost", hidden: true });
    this.#sheet.append(ghost);
    this.#sheet.addEventListener("touchstart", (event) => { // a finger on a symbol drags it; elsewhere it scrolls
      if (event.touches.length === 1 && this.#what(this.#at(event.touches[0]))?.sign) event.preventDefault();
    }, { signal, passive: false });
    this.#sheet.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      const at = this.#at(event), what = this.#what(at), sign = what?.sign;
      /** @type {"move" | "start" | "stop" | "frame"} */
      let kind = sign ? "move" : "frame";
      if (sign && sign.stop > sign.start) {
        const [low, high] = this.#ends(sign), reach = Math.min(event.pointerType === "touch" ? FINGER : EDGE, (high - low) / 3);
        kind = high - at.y < reach ? "stop" : at.y - low < reach ? "start" : "move";
      }
      press = { at, what, kind, moved: false, more: event.shiftKey || event.ctrlKey || event.metaKey };
      this.#sheet.setPointerCapture(event.pointerId);
      this.root.focus({ preventScroll: true });
      if (what && sign && !this.#hands.state().selection.includes(sign)) {
        this.#hands.press(what.cell, sign, press.more);
        press.more = false;
      }
    }, { signal });
    this.#sheet.addEventListener("pointermove", (event) => {
      const at = this.#at(event);
      if (!press) return this.#point(at);
      if (!(press.moved ||= Math.hypot(at.x - press.at.x, at.y - press.at.y) > CLICK)) return;
      const { kind, what } = press, { step } = this.#hands.state();
      /** @type {[number, number, number, number]} left, right, low, high */
      let box = [Math.min(at.x, press.at.x), Math.max(at.x, press.at.x), Math.min(at.y, press.at.y), Math.max(at.y, press.at.y)];
      if (kind !== "frame" && what?.sign) {
        const lane = this.#drop(at, what.sign.part), [low, high] = this.#ends(what.sign);
        const by = this.#y(this.#snapped(at, press.at)) - this.#y(0), least = this.#y(step) - this.#y(0);
        box = kind === "move" ? [lane.left, lane.right, low + by, high + by]
          : kind === "stop" ? [lane.left, lane.right, low, Math.max(high + by, low + least / 2)]
          : [lane.left, lane.right, Math.min(low + by, high - least / 2), high];
      }
      ghost.hidden = false;
      Object.assign(ghost.style, { left: `${box[0]}px`, width: `${box[1] - box[0]}px`, bottom: `${box[2]}px`, height: `${box[3] - box[2]}px` });
    }, { signal });
    const done = (/** @type {PointerEvent} */ event, /** @type {boolean} */ kept) => {
      const own = press;
      press = null;
      ghost.hidden = true;
      if (!own || !kept) return;
      const at = this.#at(event), by = this.#snapped(at, own.at), sign = own.what?.sign;
      if (!own.moved) {
        if (own.what) this.#hands.press(own.what.cell, own.what.sign, own.more);
      } else if (own.kind === "frame") this.#hands.take(this.#inside(own.at, at));
      else if (own.kind === "stop") this.#hands.stretch(0, by);
      else if (own.kind === "start") this.#hands.stretch(by, 0);
      else if (sign) {
        const part = this.#drop(at, sign.part).track.part;
        this.#hands.move({ ticks: by, part: part === sign.part ? undefined : part });
      }
    };
    this.#sheet.addEventListener("pointerup", (event) => done(event, true), { signal });
    this.#sheet.addEventListener("pointercancel", (event) => done(event, false), { signal });
  }

  /** Show what a press would do. @param {{x: number, y: number}} at */
  #point(at) {
    const sign = this.#what(at)?.sign;
    let shape = "crosshair";
    if (sign) {
      const [low, high] = this.#ends(sign), reach = Math.min(EDGE, (high - low) / 3);
      shape = sign.stop > sign.start && (high - at.y < reach || at.y - low < reach) ? "ns-resize" : "move";
    }
    this.#sheet.style.cursor = shape;
  }

  /** Return ticks of a drag, on the grid. @param {{y: number}} at @param {{y: number}} from */
  #snapped(at, from) {
    const { step } = this.#hands.state();
    return Math.round((this.#tickAt(at.y) - this.#tickAt(from.y)) / step) * step;
  }

  /** Return the lane to which a symbol of a part is dragged. @param {{x: number}} at @param {string} part */
  #drop(at, part) {
    const lanes = this.lanes, own = lanes.find((it) => it.track.part === part) ?? lanes[0];
    const there = lanes.find((it) => it.left <= at.x && at.x < it.right);
    return there && there.track.kind === own.track.kind ? there : own;
  }

  /** @param {{x: number, y: number}} a @param {{x: number, y: number}} b */
  #inside(a, b) {
    const left = Math.min(a.x, b.x), right = Math.max(a.x, b.x), low = Math.min(a.y, b.y), high = Math.max(a.y, b.y);
    const parts = new Set(this.lanes.filter((it) => it.left < right && it.right > left).map((it) => it.track.part));
    return this.#hands.state().score.symbols.filter((it) => {
      const [from, to] = this.#ends(it);
      return parts.has(it.part) && from < high && to > low;
    });
  }
}
