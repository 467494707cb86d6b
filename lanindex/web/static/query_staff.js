/** The staff on which a query is drawn: its lines as columns, its steps as signs, time upwards. */

import { get, problemOf, send } from "./api.js";
import { announce, el, readOut, svg } from "./dom.js";
import { nameOf } from "./names.js";
import { blank, cell, column, deny, drawingOf, either, gap, insert, LEVELS, MANNERS, move, remove, say, sayAny, settle, sizeOf, swap, textOf, titleOf, told, treeOf, unfold, WAYS } from "./query_tree.js";

/**
 * @typedef {import("./query_tree.js").Drawing} Drawing
 * @typedef {import("./query_tree.js").Column} Column
 * @typedef {import("./query_tree.js").Cell} Cell
 * @typedef {import("./query_tree.js").Chip} Chip
 * @typedef {import("./query_tree.js").Word} Word
 * @typedef {import("./query_line.js").Reading} Reading
 * @typedef {{name: string, parts: string[], form: string, place: number}} Mover `place` on a staff, from left to right, 0 in the middle
 * @typedef {{drawing: Drawing, at: import("./query_tree.js").Place}} Kept
 *
 * @typedef {object} About what `/api/query` returns
 * @property {Mover[]} movers
 * @property {string[]} relations
 * @property {string[]} relative
 * @property {Record<string, string>} signs by size, direction and level
 *
 * @typedef {object} Options
 * @property {About} about
 * @property {(tree: any) => Promise<Reading | null>} changed is given the tree of what is drawn, null where nothing is; returns what its text means
 *
 * @typedef {object} Act
 * @property {string} key as in `aria-keyshortcuts`
 * @property {string} name
 * @property {string} title
 * @property {() => void} run
 */

const KEPT = 200; // changes that can be undone
const ALONE = "the first column stands alone: the others lie beside it";
const USUAL = "r_arm"; // who moves in a step where nothing tells
const LOCKED = "the line is not understood: mend it, or write what is drawn";
const MOST = 4; // signs of a step
const SHORT = { Control: "Ctrl", Shift: "\u21e7", Enter: "\u21b5", Delete: "Del", ArrowUp: "\u2191", ArrowDown: "\u2193", "\u21e7+": "\u21e7" }; // names of keys
const PAD = [7, 8, 9, 4, 5, 6, 1, 2, 3];

export class QueryStaff {
  #options;
  #about;
  #drawing = blank();
  /** @type {import("./query_tree.js").Place} */
  #at = { tab: 0, column: 0, step: 0 };
  #past = /** @type {Kept[]} */ ([]);
  #future = /** @type {Kept[]} */ ([]);
  #writing = false;
  #stale = false;
  #also = false;
  #locked = false; // while the line has a mistake: a change here would take it away
  /** @type {Map<string, SVGSVGElement>} */
  #signs = new Map();
  #tabs = el("div", { class: "q-tabs row", role: "group", "aria-label": "Alternatives" });
  #sheet = el("div", { class: "q-sheet", role: "group", "aria-label": "Staff of the query. Arrow keys move, 1 to 9 say a direction, L, M, H a level, Enter adds a step." });
  #chips = el("div", { class: "q-chips row", role: "group", "aria-label": "Clauses and stages" });
  #prompt = el("form", { class: "q-prompt row", hidden: true });
  #note = el("p", { class: "q-note soft" });
  /** @type {Map<string, Act>} */
  #acts;
  /** @type {Map<string, HTMLButtonElement>} */
  #buttons = new Map();

  /** @param {Options} options */
  constructor(options) {
    this.#options = options;
    this.#about = options.about;
    this.#acts = new Map(this.#all().map((it) => [it.key, it]));
    this.root = el("section", { class: "q-staff", "aria-label": "The query as a staff" },
      el("div", { class: "q-drawn" }, this.#tabs, this.#sheet, this.#prompt, this.#note, this.#chips), this.#palette());
    new ResizeObserver(() => this.#see()).observe(this.#sheet);
    this.root.addEventListener("keydown", (event) => this.#undoes(event));
    this.root.addEventListener("keydown", (event) => this.#key(event));
    this.#draw();
  }

  /** What is drawn, as a tree; null: nothing. */
  get tree() {
    return treeOf(this.#drawing);
  }

  focus() {
    /** @type {HTMLElement | null} */ (this.#sheet.querySelector("[tabindex='0']"))?.focus();
  }

  /**
   * Show what a text means.
   * @param {Reading} reading
   * @param {boolean} [own] whether it is the text of what is drawn
   */
  show(reading, own = false) {
    if (this.#writing) return;
    const { text, tree, error } = reading, empty = !text.trim();
    this.#locked = error !== null && !own;
    this.#note.replaceChildren(...(this.#locked ? ["The line is not understood: what is drawn was before it. ", el("button", { type: "button", onclick: () => this.#write() }, "Write what is drawn")] : [error?.found ?? ""]));
    this.root.classList.toggle("q-old", this.#locked);
    if ((own && empty) || (!tree && !empty)) return;
    const drawing = empty ? blank(this.#mover) : drawingOf(tree);
    if (!own && this.tree && JSON.stringify(drawing) !== JSON.stringify(this.#drawing)) this.#keep();
    if (own) this.#withEmpty(drawing);
    this.#drawing = drawing;
    this.#draw();
  }

  // What is chosen

  get #columns() {
    return this.#drawing.tabs[this.#at.tab];
  }

  get #column() {
    return this.#columns[this.#at.column];
  }

  /** Who moves in a new step of the column. */
  get #mover() {
    return this.#column.part || USUAL;
  }

  /** @returns {Cell | undefined} */
  get #cell() {
    return this.#column.cells[this.#at.step];
  }

  /** The numbers of the columns as they stand on a staff from left to right; those of the pattern follow its text. */
  get #order() {
    return this.#columns.map((_, at) => at).sort((one, other) => this.#placeOf(one) - this.#placeOf(other));
  }

  /** @param {number} at */
  #placeOf(at) {
    const { part } = this.#columns[at];
    return this.#about.movers.find((it) => it.name === part)?.place ?? 0;
  }

  /** Let the place be one that there is. */
  #clamp() {
    const at = this.#at, within = (/** @type {number} */ it, /** @type {unknown[]} */ list) => Math.max(Math.min(it, list.length - 1), 0);
    at.tab = within(at.tab, this.#drawing.tabs);
    at.column = within(at.column, this.#columns);
    at.step = within(at.step, this.#column.cells);
  }

  /** Keep columns to which no step has been added yet. @param {Drawing} drawing */
  #withEmpty(drawing) {
    this.#drawing.tabs.forEach((columns, at) => {
      if (columns.every((it) => !it.cells.length)) drawing.tabs.splice(at, 0, columns);
    });
  }

  // Changes

  #keep() {
    this.#past = [...this.#past, structuredClone({ drawing: this.#drawing, at: this.#at })].slice(-KEPT);
    this.#future = [];
  }

  /** @param {() => void} change @param {string} [said] */
  #edit(change, said) {
    if (this.#locked) return announce(LOCKED);
    this.#keep();
    change();
    this.#draw();
    readOut(said ?? this.#told());
    this.#write();
  }

  /** Have it written; what is changed meanwhile is written next. */
  async #write() {
    this.#stale = true;
    if (this.#writing) return;
    this.#writing = true;
    let reading = null;
    while (this.#stale) {
      this.#stale = false;
      reading = await this.#options.changed(this.tree);
    }
    this.#writing = false;
    if (reading) this.show(reading, true);
  }

  /** @param {Kept[]} from @param {Kept[]} to @param {string} what */
  #step(from, to, what) {
    if (this.#locked) return announce(LOCKED);
    const kept = from.pop();
    if (!kept) return announce(`nothing to ${what}`);
    to.push({ drawing: this.#drawing, at: this.#at });
    this.#drawing = kept.drawing;
    this.#at = kept.at;
    this.#draw();
    readOut(`${what}: ${this.#told()}`);
    this.#write();
  }

  /** Change the step that is chosen, which is made where there is none. @param {(cell: Cell) => void} change @param {boolean} [words] whether it changes words, which a locked step has not */
  #change(change, words = false) {
    if (words && this.#cell?.block) return announce(`locked: ${textOf(this.#cell)} is changed in the line`);
    this.#edit(() => {
      if (!this.#cell) insert(this.#column, 0, cell(this.#mover));
      change(/** @type {Cell} */ (this.#cell));
    });
  }

  /** @param {"direction" | "level"} of @param {string} value */
  #say(of, value) {
    const also = this.#also;
    this.#alsoIs(false);
    this.#change((it) => say(it, of, value, also), true);
  }

  /** @param {boolean} on */
  #alsoIs(on) {
    this.#also = on;
    this.#buttons.get("/")?.setAttribute("aria-pressed", String(on));
  }

  /** @param {number} [by] 1: after the step that is chosen, 0: before it */
  #add(by = 1) {
    const { cells } = this.#column, last = this.#cell;
    this.#edit(() => {
      const at = cells.length ? this.#at.step + by : 0;
      insert(this.#column, at, cell((last && !last.block && last.part) || this.#mover));
      this.#at.step = at;
    });
  }

  #take() {
    if (!this.#cell) return this.#takeColumn();
    this.#edit(() => {
      remove(this.#column, this.#at.step);
      if (this.#at.step) this.#at.step -= 1;
      if (!this.#column.cells.length) this.#dropColumn();
    });
  }

  /** @param {number} by 1: later, -1: sooner */
  #shift(by) {
    const { cells } = this.#column, to = this.#at.step + by;
    if (!cells[to]) return announce(by > 0 ? "no step is later" : "no step is sooner");
    this.#edit(() => {
      swap(this.#column, Math.min(to, this.#at.step));
      this.#at.step = to;
    });
  }

  /** Draw what a locked step stands for. */
  async #unfold() {
    const block = this.#cell?.block;
    if (!block?.named && block?.kind !== "bracket") return announce("only a word or brackets can be unfolded");
    try {
      const tree = block.named ? await this.#defined(block.named) : { pattern: block.pattern, lets: [], clauses: [], stages: [] };
      const drawing = structuredClone(this.#drawing);
      if (this.#cell?.block !== block) return null; // it is another step by now
      if (!unfold(drawing, this.#at, tree)) return announce(`${textOf(/** @type {Cell} */ (this.#cell))} cannot be drawn here`);
      return this.#edit(() => (this.#drawing = drawing));
    } catch (error) {
      return announce(problemOf(error).found);
    }
  }

  /** Return the tree of a word's pattern. @param {string} name */
  async #defined(name) {
    const { pattern } = await get(`/api/words/${name}`);
    return (await send("POST", "/api/parse", { text: pattern })).tree;
  }

  #takeColumn() {
    if (this.#columns.length > 1 || this.#drawing.tabs.length > 1) this.#edit(() => this.#dropColumn());
  }

  #dropColumn() {
    const { tabs } = this.#drawing, columns = this.#columns;
    if (columns.length > 1) {
      columns.splice(this.#at.column, 1);
      Object.assign(columns[0], { relation: "", limit: "" });
      this.#at.column = Math.max(this.#at.column - 1, 0);
    } else if (tabs.length > 1) tabs.splice(this.#at.tab, 1);
    this.#clamp();
  }

  /** @param {string} part */
  #addColumn(part) {
    this.#edit(() => {
      const { cells } = this.#columns[0];
      if (!cells.length) move(this.#columns[0], part);
      else this.#columns.push(column(part, "with", [cell(part)]));
      this.#at = { ...this.#at, column: this.#columns.length - 1, step: 0 };
    });
  }

  #relate() {
    if (!this.#at.column) return announce(ALONE);
    const { relations } = this.#about, own = this.#column;
    this.#edit(() => {
      own.relation = relations[(relations.indexOf(own.relation) + 1) % relations.length];
      own.limit = "";
    }, `${relations[(relations.indexOf(own.relation) + 1) % relations.length]} ${this.#title(own.part)}`);
  }

  #alternative() {
    this.#edit(() => {
      const part = this.#columns[0].part || USUAL;
      this.#drawing.tabs.push([column(part, "", [cell(part)])]);
      this.#at = { tab: this.#drawing.tabs.length - 1, column: 0, step: 0 };
    }, `alternative ${this.#drawing.tabs.length + 1}`);
  }

  /** @param {"length" | "repeat" | "label"} name @param {string} label @param {string} example */
  #ask(name, label, example) {
    if (!this.#cell) return announce("no step is chosen");
    this.#promptFor(label, example, this.#cell[name], (text) => this.#change((it) => (it[name] = text)));
  }

  #askGap() {
    const own = this.#cell?.arrow;
    if (!own) return announce("nothing leads to this step: G makes a gap");
    this.#promptFor("Time before the step", "<1s", own.limit, (limit) => this.#change((it) => (it.arrow = { later: own.later, limit })));
  }

  #askLimit() {
    const own = this.#column;
    if (!this.#at.column) return announce(ALONE);
    this.#promptFor("Time between", "0.5s", own.limit, (limit) => this.#edit(() => (this.#column.limit = limit)));
  }

  /** Ask for a clause as the language has it: without a word before it, it is a condition. */
  #addClause() {
    this.#promptFor("Clause", "b.end - a.start > 1s, rhythm 1:2, | count", "", (typed) => {
      const [, word = "", rest] = /** @type {RegExpExecArray} */ (/^(let\b|rhythm\b|where\b|\|)?\s*(.*)$/s.exec(typed));
      const kind = /** @type {Chip["kind"]} */ ({ let: "let", rhythm: "rhythm", "|": "stage" }[word] ?? "condition");
      if (rest) this.#edit(() => this.#drawing.chips.push({ kind, text: kind === "stage" || kind === "condition" ? rest : `${word} ${rest}` }), `${word || "where"} ${rest}`);
    });
  }

  #askText() {
    const own = this.#cell;
    if (!own) return announce("no step is chosen");
    const whole = [own.label && `${own.label}:`, textOf(own), own.length, own.repeat].filter(Boolean).join(" ");
    this.#promptFor("Text of the step", "r_arm bent 3+", whole, (text) => text && this.#change((it) => {
      Object.assign(it, { block: { kind: "text", text }, label: "", length: "", repeat: "" });
      settle(this.#column, this.#at.step + 1);
    }));
  }

  /**
   * Ask for a short text, or a choice, below the staff.
   * @param {string} label
   * @param {string} example
   * @param {string} value
   * @param {(text: string) => void} take
   * @param {string[]} [choices]
   */
  #promptFor(label, example, value, take, choices) {
    const back = /** @type {HTMLElement | null} */ (document.activeElement), from = back && this.#sheet.contains(back);
    const field = choices
      ? el("select", {}, ...choices.map((it) => el("option", { value: it, selected: it === value }, this.#title(it))))
      : el("input", { value, placeholder: example, size: 14, spellcheck: "false", autocomplete: "off" });
    const done = (/** @type {boolean} */ taken) => {
      const text = field.value.trim();
      this.#prompt.hidden = true;
      if (taken) take(text);
      if (from) this.focus();
      else back?.focus();
    };
    this.#prompt.replaceChildren(el("label", {}, `${label} `, field), el("button", { type: "submit", class: "main" }, "Take"), el("button", { type: "button", onclick: () => done(false) }, "Leave"));
    this.#prompt.onsubmit = (event) => {
      event.preventDefault();
      done(true);
    };
    this.#prompt.onkeydown = (event) => {
      event.stopPropagation();
      if (event.key === "Escape") done(false);
      else if (event.key === "Enter" && field instanceof HTMLSelectElement && event.target === field) done(true);
      else return;
      event.preventDefault();
    };
    this.#prompt.hidden = false;
    field.focus();
    if (field instanceof HTMLInputElement) field.select();
  }

  /** @param {string} label @param {string} part @param {(part: string) => void} take */
  #askPart(label, part, take) {
    this.#promptFor(label, "", part, take, this.#about.movers.map((it) => it.name));
  }

  /** Return a part that no column shows, the other side of the first one if that is free. */
  #free() {
    const used = this.#columns.map((it) => it.part), [first] = used;
    const other = first.replace(/^[rl]_/, (it) => (it === "r_" ? "l_" : "r_"));
    return used.includes(other) ? this.#about.movers.find((it) => !used.includes(it.name))?.name ?? first : other;
  }

  // Keys and buttons

  /** @returns {Act[]} */
  #all() {
    return [
      { key: "a", name: "any", title: "Any movement", run: () => this.#change(sayAny, true) },
      { key: "n", name: "not", title: "Not the direction, the level, both", run: () => this.#change(deny, true) },
      { key: "/", name: "or \u2026", title: "The next direction or level is another that will do", run: () => {
        this.#alsoIs(!this.#also);
        announce(this.#also ? "the next direction or level will do as well" : "");
      } },
      { key: "Enter", name: "+ step", title: "Add a step after this one", run: () => this.#add() },
      { key: "Shift+Enter", name: "+ before", title: "Add a step before this one", run: () => this.#add(0) },
      { key: "Delete", name: "\u2212 step", title: "Remove the step", run: () => this.#take() },
      { key: "Alt+ArrowUp", name: "later", title: "Move the step up its column", run: () => this.#shift(1) },
      { key: "Alt+ArrowDown", name: "sooner", title: "Move the step down its column", run: () => this.#shift(-1) },
      { key: "u", name: "unfold", title: "Draw what a locked step stands for", run: () => this.#unfold() },
      { key: "g", name: "gap", title: "At once, or after a gap", run: () => this.#cell && this.#change((it) => gap(it, this.#at.step === 0)) },
      { key: "Shift+g", name: "gap time", title: "Time before the step", run: () => this.#askGap() },
      { key: "o", name: "hold", title: "Moves there, holds it, is at it, passes through it", run: () => this.#change((it) => (it.manner = MANNERS[(MANNERS.indexOf(it.manner) + 1) % MANNERS.length]), true) },
      { key: "t", name: "length", title: "Length of the step", run: () => this.#ask("length", "Length", "1s, <0.5s, 1s..2s") },
      { key: "x", name: "repeat", title: "How often in a row", run: () => this.#ask("repeat", "Repeat", "x2, x2+, x1..3, ?") },
      { key: "b", name: "label", title: "A name of the step, for conditions", run: () => this.#ask("label", "Label", "a") },
      { key: "F2", name: "text", title: "The step as text", run: () => this.#askText() },
      { key: "p", name: "part", title: "Who moves in the column", run: () => this.#askPart("Part", this.#column.part, (part) => this.#edit(() => move(this.#column, part), this.#title(part))) },
      { key: "c", name: "+ column", title: "Add a column", run: () => this.#askPart("Part of the new column", this.#free(), (part) => this.#addColumn(part)) },
      { key: "r", name: "relation", title: "How the column lies to the first: with, during, without, never \u2026", run: () => this.#relate() },
      { key: "Shift+r", name: "time beside", title: "Time between the column and the first: with, without, after, before", run: () => this.#askLimit() },
      { key: "v", name: "+ alternative", title: "Another staff that will do as well", run: () => this.#alternative() },
      { key: "e", name: "either side", title: "The mirror image will do as well", run: () => this.#edit(() => either(this.#drawing), this.#sided ? "this side only" : "either side") },
      { key: "w", name: "+ clause", title: "A condition, a rhythm, a name of a pattern, a stage", run: () => this.#addClause() },
      { key: "Control+z", name: "undo", title: "Undo", run: () => this.#step(this.#past, this.#future, "undo") },
      { key: "Control+Shift+z", name: "redo", title: "Redo", run: () => this.#step(this.#future, this.#past, "redo") },
    ];
  }

  get #sided() {
    return this.#drawing.chips.some((it) => it.kind === "either side");
  }

  #palette() {
    const ways = PAD.map((digit) => this.#button(String(digit), "", nameOf(WAYS[digit - 1]), () => this.#say("direction", WAYS[digit - 1]), this.#sign(`usual ${WAYS[digit - 1]} ?`)));
    const levels = [...LEVELS].reverse().map((it) => this.#button(it[0], "", it, () => this.#say("level", it), this.#sign(`usual ? ${it}`)));
    const relative = el("select", { "aria-label": "Direction relative to the side", onchange: () => {
      if (relative.value) this.#say("direction", relative.value);
      relative.value = "";
    } }, el("option", { value: "" }, "by side \u2026"), ...this.#about.relative.map((it) => el("option", { value: it }, it.replaceAll("_", " "))));
    const acts = (/** @type {string[]} */ ...keys) => keys.map((key) => {
      const { name, title, run } = /** @type {Act} */ (this.#acts.get(key));
      return this.#button(key, name, title, run);
    });
    const group = (/** @type {string} */ name, /** @type {string[]} */ ...keys) => el("div", { class: "q-acts", role: "group", "aria-label": name }, el("span", { class: "soft", "aria-hidden": "true" }, name), el("div", { class: "row" }, ...acts(...keys)));
    return el("div", { class: "q-palette", role: "group", "aria-label": "Signs and changes" },
      el("div", { class: "q-signs" }, el("div", { class: "q-pad" }, ...ways), el("div", { class: "q-levels" }, ...levels), el("div", { class: "q-other" }, relative, ...acts("a", "n", "/", "o"))),
      group("Step", "Enter", "Shift+Enter", "Delete", "Alt+ArrowUp", "Alt+ArrowDown", "b", "F2", "u"),
      group("Time", "t", "x", "g", "Shift+g"),
      group("Column", "c", "p", "r", "Shift+r"),
      group("Query", "v", "e", "w", "Control+z", "Control+Shift+z"));
  }

  /** @param {string} key @param {string} text @param {string} title @param {() => void} run @param {Node} [sign] */
  #button(key, text, title, run, sign) {
    const shown = Object.entries(SHORT).reduce((text, [name, short]) => text.replace(name, short), key).replace(/\b[a-z]$/, (it) => it.toUpperCase());
    const node = el("button", { type: "button", title: `${title} (${shown})`, "aria-keyshortcuts": key, onclick: run }, sign ?? null, text || el("span", { class: "hidden" }, title), el("kbd", { "aria-hidden": "true" }, shown));
    this.#buttons.set(key, node);
    return node;
  }

  /** @param {KeyboardEvent} event */
  #undoes(event) {
    if (!(event.ctrlKey || event.metaKey) || event.altKey || event.target instanceof HTMLInputElement) return;
    const key = event.key.toLowerCase();
    if (key !== "z" && key !== "y") return;
    event.preventDefault();
    this.#acts.get(key === "y" || event.shiftKey ? "Control+Shift+z" : "Control+z")?.run();
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const within = event.target instanceof Element && event.target.closest(".q-sheet, .q-palette");
    if (!within || event.target instanceof HTMLSelectElement) return;
    if (event.ctrlKey || event.metaKey || (event.altKey && !event.key.startsWith("Arrow"))) return;
    const { key } = event, at = this.#at, step = !(event.target instanceof HTMLButtonElement);
    const digit = /^(?:Digit|Numpad)([1-9])$/.exec(event.code)?.[1], number = /^[1-9]$/.test(key) || event.code.startsWith("Numpad") ? Number(/^[1-9]$/.test(key) ? key : digit) : 0;
    const level = LEVELS.find((it) => it[0] === key.toLowerCase());
    const name = event.shiftKey && /^([GR]|Enter)$/.test(key) ? `Shift+${key === "Enter" ? key : key.toLowerCase()}` : { Insert: "Enter", "+": "Enter", Backspace: "Delete" }[key] ?? (key.length === 1 ? key.toLowerCase() : key);
    if (event.altKey && !this.#acts.has(`Alt+${key}`)) return;
    if (event.altKey) this.#acts.get(`Alt+${key}`)?.run();
    else if (number) this.#say("direction", WAYS[number - 1]);
    else if (level) this.#say("level", level);
    else if (key === "ArrowUp") this.#go({ step: at.step + 1 });
    else if (key === "ArrowDown") this.#go({ step: at.step - 1 });
    else if (key === "ArrowRight") this.#beside(1);
    else if (key === "ArrowLeft") this.#beside(-1);
    else if (key === "Home") this.#go({ step: 0 });
    else if (key === "End") this.#go({ step: this.#column.cells.length - 1 });
    else if (key === "PageUp" || key === "PageDown") this.#go({ tab: at.tab + (key === "PageUp" ? -1 : 1), column: 0, step: 0 });
    else if (this.#acts.has(name) && (step || key !== "Enter")) this.#acts.get(name)?.run();
    else return;
    event.preventDefault();
  }

  /** @param {Partial<import("./query_tree.js").Place>} there */
  #go(there) {
    this.#at = { ...this.#at, ...there };
    this.#at.tab = Math.max(this.#at.tab, 0);
    this.#at.column = Math.max(this.#at.column, 0);
    this.#clamp();
    this.#draw(true);
    readOut(this.#told());
  }

  /** @param {number} by 1: to the column on the right, -1: to that on the left */
  #beside(by) {
    const order = this.#order, there = order[order.indexOf(this.#at.column) + by];
    this.#go({ column: there ?? this.#at.column });
  }

  // What is seen

  /** @param {string} part */
  #title(part) {
    return titleOf(part, this.#about.movers) || "a word";
  }

  /** Return what is chosen, to be read out. */
  #told() {
    this.#clamp();
    const own = this.#cell, { column: at, step } = this.#at, { relation, limit, part, cells } = this.#column;
    const head = [relation, limit && `within ${limit}`, this.#title(part)].filter(Boolean).join(" ");
    return own ? `step ${step + 1} of ${cells.length}, ${at ? head : this.#title(part)}: ${told(own, step === 0)}` : `${head}: nothing drawn yet`;
  }

  /** @param {boolean} [focus] whether the chosen step gets the focus, also where it has not been in the staff */
  #draw(focus = false) {
    this.#clamp();
    const had = focus || this.#sheet.contains(document.activeElement);
    this.#tabs.hidden = this.#drawing.tabs.length < 2;
    this.#tabs.replaceChildren(...this.#drawing.tabs.map((_, tab) => el("button", { type: "button", "aria-pressed": String(tab === this.#at.tab), onclick: () => this.#go({ tab, column: 0, step: 0 }) }, tab ? `or ${tab + 1}` : "1")));
    const order = this.#order, right = order.find((at) => this.#placeOf(at) > 0);
    this.#sheet.replaceChildren(...order.map((at) => this.#columnNode(this.#columns[at], at, at === right && at !== order[0])));
    this.#chips.hidden = !this.#drawing.chips.length;
    this.#chips.replaceChildren(...this.#drawing.chips.map((it) => this.#chip(it)));
    this.#buttons.get("e")?.setAttribute("aria-pressed", String(this.#sided));
    if (had) this.focus();
    this.#see();
  }

  /** Scroll to the step that is chosen within the sheet, which alone is scrolled. */
  #see() {
    const own = this.#sheet.querySelector("[aria-selected=true]")?.getBoundingClientRect(), sheet = this.#sheet.getBoundingClientRect();
    if (!own) return;
    const head = this.#sheet.querySelector(".q-head")?.clientHeight ?? 0; // lies above what is scrolled
    const past = (/** @type {number} */ low, /** @type {number} */ high, /** @type {number} */ least, /** @type {number} */ most) => (low < least ? low - least : Math.max(Math.min(high - most, low - least), 0));
    this.#sheet.scrollBy(past(own.left, own.right, sheet.left, sheet.right), past(own.top, own.bottom, sheet.top, sheet.bottom - head));
  }

  /** @param {Column} own @param {number} at @param {boolean} middle whether the middle of the body is on its left */
  #columnNode(own, at, middle) {
    const { relation, limit, part, cells, end } = own, title = this.#title(part), here = at === this.#at.column;
    const side = part.startsWith("r_") ? "q-right" : part.startsWith("l_") ? "q-left" : "";
    const struck = relation === "without" || relation === "never" ? "q-struck" : "";
    const options = cells.length ? cells.map((it, step) => this.#stepNode(it, own, at, step)) : [el("div", { class: "q-step q-none", role: "option", tabindex: here ? 0 : -1, "aria-selected": String(here), onclick: () => this.#go({ column: at, step: 0 }) }, "draw here: 1\u20139, L M H")];
    return el("div", { class: `q-column ${side} ${struck} ${middle ? "q-middle" : ""}` },
      el("div", { class: "q-head" }, el("span", { class: "q-relation" }, relation, limit && ` [${limit}]`, at || !this.#columns[1] ? "" : "\u00a0"), el("b", {}, title)),
      el("div", { class: "q-lane", role: "listbox", "aria-orientation": "vertical", "aria-label": [relation, limit, title].filter(Boolean).join(" ") }, ...options),
      end && el("div", { class: "q-end soft" }, `${end.later ? "\u22ee" : ""} ${end.limit} to the end`),
      el("button", { type: "button", class: "plain q-more", tabindex: -1, title: `Add a step to ${title}`, onclick: () => {
        this.#at = { ...this.#at, column: at, step: Math.max(cells.length - 1, 0) };
        this.#add();
        this.focus();
      } }, "+", el("span", { class: "hidden" }, ` step of ${title}`)));
  }

  /** @param {Cell} own @param {Column} column @param {number} at @param {number} step */
  #stepNode(own, column, at, step) {
    const here = at === this.#at.column && step === this.#at.step, { arrow, block, label, length, repeat } = own;
    const before = arrow && el("span", { class: arrow.later ? "q-gap" : "q-joined", "aria-hidden": "true" }, step ? "" : "start ", arrow.limit);
    const other = !block && own.part !== column.part && this.#title(own.part);
    const marks = [label && `${label}:`, other, length, repeat].filter(Boolean);
    const body = block ? el("span", { class: "q-block", "aria-hidden": "true" }, textOf(own)) : el("span", { class: `q-sign ${own.words.some((it) => it.negated) ? "q-not" : ""}`, "aria-hidden": "true" }, ...this.#signsOf(own));
    const words = block ? "" : own.words.map((it) => `${it.negated ? "not " : ""}${it.values.map(nameOf).join("/")}`).join(", ") || (own.manner === "move" ? "any" : "");
    const manner = block || own.manner === "move" ? "" : own.manner;
    return el("div", {
      class: "q-step",
      role: "option",
      tabindex: here ? 0 : -1,
      "aria-selected": String(here),
      onclick: () => this.#go({ column: at, step }),
    }, el("span", { class: "hidden" }, `step ${step + 1} of ${column.cells.length}: ${told(own, step === 0)}`), before, body, el("span", { class: "q-words", "aria-hidden": "true" }, manner && el("i", {}, `${manner} `), words, ...marks.map((it) => el("span", { class: "q-mark" }, it))));
  }

  /** Return the signs of a step: each direction with each level that will do. @param {Cell} own */
  #signsOf(own) {
    const values = (/** @type {string} */ of) => {
      const said = own.words.filter((it) => it.of === of).flatMap((it) => it.values).map((it) => (WAYS.includes(it) || LEVELS.includes(it) ? it : "?"));
      return [...new Set(said.length ? said : ["?"])];
    };
    const ways = values("direction"), levels = values("level"), size = sizeOf(own.length);
    return ways.flatMap((way) => levels.map((level) => this.#sign(`${size} ${way} ${level}`))).slice(0, MOST);
  }

  /** @param {string} name */
  #sign(name) {
    if (!this.#signs.has(name)) {
      const drawn = svg(this.#about.signs[name]);
      for (const it of ["width", "height", "role"]) drawn.removeAttribute(it);
      drawn.setAttribute("aria-hidden", "true");
      drawn.setAttribute("class", / \? /.test(name) ? "q-open" : "");
      this.#signs.set(name, drawn);
    }
    return /** @type {SVGSVGElement} */ (this.#signs.get(name)?.cloneNode(true));
  }

  /** @param {Chip} chip */
  #chip(chip) {
    const { kind, text } = chip, at = this.#drawing.chips.indexOf(chip);
    const set = (/** @type {string} */ to) => this.#edit(() => {
      const { chips } = this.#drawing; // it may have been read again meanwhile
      if (to) chips[at].text = to;
      else chips.splice(at, 1);
    }, to || `removed: ${text}`);
    const said = { let: "", "either side": "", rhythm: "", condition: "where ", stage: "| " }[kind];
    return el("span", { class: "q-chip" }, el("span", { class: "soft" }, said),
      el("button", { type: "button", class: "plain", title: "Change it", onclick: () => this.#promptFor(kind, text, text, set) }, text),
      el("button", { type: "button", class: "plain", title: "Remove it", onclick: () => {
        set("");
        this.focus();
      } }, "\u00d7", el("span", { class: "hidden" }, ` remove ${text}`)));
  }
}
