/** A query as columns of steps, which a staff can show and change, from its tree and back to one. */

import { nameOf } from "./names.js";

/**
 * @typedef {any} Tree as `/api/parse` returns it
 * @typedef {{of: string, values: string[], negated: boolean}} Word
 * @typedef {{later: boolean, limit: string}} Arrow
 *
 * @typedef {object} Cell a step of a column
 * @property {Arrow | null} arrow what leads to it; of the first: from the start of the clip
 * @property {Tree | null} block what stands in its place and cannot be drawn: brackets, names, scores
 * @property {string} part who moves, also where that is not written
 * @property {boolean} named whether it is written
 * @property {string} manner
 * @property {Word[]} words
 * @property {string} label
 * @property {string} length
 * @property {string} repeat
 *
 * @typedef {object} Column a line of the pattern
 * @property {string} relation to the first one, whose own is empty
 * @property {string} limit of the time between
 * @property {string} part
 * @property {Cell[]} cells
 * @property {Arrow | null} end what leads to the end of the clip
 *
 * @typedef {{kind: "let" | "either side" | "rhythm" | "condition" | "stage", text: string}} Chip
 * @typedef {{tabs: Column[][], chips: Chip[]}} Drawing `tabs` are the alternatives
 * @typedef {{tab: number, column: number, step: number}} Place
 */

/** Directions by the number keys, as they lie there. */
export const WAYS = ["l_back", "back", "r_back", "left", "place", "right", "l_forward", "forward", "r_forward"];
export const LEVELS = ["low", "mid", "high"];
export const MANNERS = ["move", "hold", "at", "via"];
const BLOCKS = ["bracket", "mirror", "named", "score"];
const COUNT = /^[<>=]*\d+(\.\.\d+)?$/; // of movements, not of time

/** Return a staff on which nothing is drawn. @returns {Drawing} */
export function blank(part = "r_arm") {
  return { tabs: [[column(part)]], chips: [] };
}

/** @param {string} part @param {string} [relation] @param {Cell[]} [cells] @returns {Column} */
export function column(part, relation = "", cells = []) {
  return { relation, limit: "", part, cells, end: null };
}

/** Return a step of which nothing is said but who moves. @param {string} part @returns {Cell} */
export function cell(part) {
  return { arrow: null, block: null, part, named: false, manner: "move", words: [], label: "", length: "", repeat: "" };
}

// From a tree

/** @param {Tree} tree @returns {Drawing} */
export function drawingOf(tree) {
  /** @type {(kind: Chip["kind"], nodes: Tree[]) => Chip[]} */
  const chips = (kind, nodes) => nodes.map(({ text }) => ({ kind, text }));
  return {
    tabs: tree.pattern.alternatives.map((/** @type {Tree} */ lines) => [columnOf(lines.first), ...lines.others.map((/** @type {Tree} */ it) => ({ ...columnOf(it.line), relation: it.relation, limit: it.limit?.text ?? "" }))]),
    chips: [
      ...chips("let", tree.lets),
      ...tree.clauses.flatMap((/** @type {Tree} */ it) => (it.kind === "where" ? chips("condition", it.conditions) : chips(it.kind, [it]))),
      ...chips("stage", tree.stages),
    ],
  };
}

/** @param {Tree} line @returns {Column} */
function columnOf(line) {
  const arrows = [line.start, ...line.arrows];
  const cells = line.steps.map((/** @type {Tree} */ step, /** @type {number} */ at) => cellOf(step, arrowOf(arrows[at])));
  cells.forEach((/** @type {Cell} */ it, /** @type {number} */ at) => {
    if (!isSaid(it) && at && !cells[at - 1].block && cells[at - 1].part === it.part) it.named = false; // its words may carry it over
  });
  return { ...column(cells.find((/** @type {Cell} */ it) => it.part)?.part ?? ""), cells, end: arrowOf(line.end) };
}

/** @param {Tree | null} node @returns {Arrow | null} */
function arrowOf(node) {
  return node && { later: node.later, limit: node.limit?.text ?? "" };
}

/** @param {Tree} step @param {Arrow | null} arrow @returns {Cell} */
function cellOf(step, arrow) {
  const block = BLOCKS.includes(step.kind) ? step : null;
  return {
    arrow,
    block,
    part: moverOf(step),
    named: step.written ?? false,
    manner: step.manner ?? "move",
    words: (step.words ?? []).map((/** @type {Word} */ { of, values, negated }) => ({ of, values, negated })),
    label: step.label,
    length: step.length?.text ?? "",
    repeat: step.repeat?.text ?? "",
  };
}

/** Return who moves first in a step of any kind; empty where only the server knows. @param {Tree} step @returns {string} */
function moverOf(step) {
  return step.pattern ? moverOf(step.pattern.alternatives[0].first.steps[0]) : step.part ?? "";
}

// To a tree

/** Return the tree of what is drawn; null where nothing is. @param {Drawing} drawing @returns {Tree | null} */
export function treeOf({ tabs, chips }) {
  const drawn = tabs.map((columns) => columns.filter((it) => it.cells.length)).filter((columns) => columns.length);
  if (!drawn.length) return null;
  /** @type {(...kinds: string[]) => Tree[]} */
  const of = (...kinds) => chips.filter((it) => kinds.includes(it.kind)).map(({ kind, text }) => ({ kind, text }));
  const conditions = of("condition");
  return {
    kind: "query",
    lets: of("let"),
    pattern: { kind: "choice", alternatives: drawn.map(([first, ...others]) => ({ kind: "lines", first: lineOf(first), others: others.map(besideOf) })) },
    clauses: [...of("either side", "rhythm"), ...(conditions.length ? [{ kind: "where", conditions }] : [])],
    stages: of("stage"),
  };
}

/** @param {Column} column @returns {Tree} */
function besideOf(column) {
  return { kind: "beside", relation: column.relation || "with", limit: leaf("length", column.limit), line: lineOf(column) };
}

/** @param {Column} column @returns {Tree} */
function lineOf({ cells, end }) {
  const [start, ...arrows] = cells.map((it) => nodeOf(it.arrow));
  return { kind: "line", start, steps: cells.map((it, at) => stepOf(it, at === 0)), arrows, end: nodeOf(end) };
}

/** @param {Arrow | null} arrow @returns {Tree | null} */
function nodeOf(arrow) {
  return arrow && { kind: "arrow", later: arrow.later, limit: leaf("length", arrow.limit) };
}

/** @param {Cell} cell @param {boolean} first @returns {Tree} */
function stepOf(cell, first) {
  const { block, part, manner, words, label } = cell;
  const written = first || cell.named || !isSaid(cell);
  const unit = block ?? { kind: "step", part, written, manner, words: words.map((it) => ({ kind: "word", ...it })) };
  return { ...unit, label, length: leaf("length", cell.length), repeat: leaf("repeat", cell.repeat) };
}

/** Return whether anything is said of a step but who moves. @param {Cell} cell */
function isSaid({ block, manner, words }) {
  return block !== null || words.length > 0 || manner !== "move";
}

/** @param {string} kind @param {string} text */
function leaf(kind, text) {
  return text ? { kind, text } : null;
}

// Words of a step

/**
 * Say a direction or a level of a step, or take it back where it is all that is said of that.
 * @param {Cell} cell
 * @param {"direction" | "level"} of
 * @param {string} value
 * @param {boolean} also beside what is said already: either will do
 */
export function say(cell, of, value, also) {
  const old = cell.words.find((it) => it.of === of && !isAny(it));
  const values = old?.values ?? [];
  const now = also ? (values.includes(value) ? values.filter((it) => it !== value) : [...values, value]) : values.join() === value ? [] : [value];
  const kept = cell.words.filter((it) => it.of !== of && !isAny(it));
  const word = now.length ? [{ of, values: now, negated: old?.negated ?? false }] : [];
  const rest = (/** @type {Word} */ it) => (it.of === "direction" ? 0 : it.of === "level" ? 1 : 2);
  cell.words = [...kept, ...word].sort((one, other) => rest(one) - rest(other));
}

/** @param {Word} word */
function isAny(word) {
  return word.values.join() === "any";
}

/** Let a step be any movement. @param {Cell} cell */
export function sayAny(cell) {
  cell.words = [{ of: "direction", values: ["any"], negated: false }];
}

/** Deny the first word of a step, then the next, both, none. @param {Cell} cell */
export function deny(cell) {
  for (const word of cell.words.filter((it) => !isAny(it))) {
    word.negated = !word.negated;
    if (word.negated) return;
  }
}

// Steps and columns

/** Insert a step into a column, where it carries over who moves. @param {Column} column @param {number} at @param {Cell} cell */
export function insert(column, at, cell) {
  column.cells.splice(at, 0, cell);
  if (at > 0) cell.arrow ??= { later: false, limit: "" };
  else if (column.cells[1]) {
    cell.arrow = column.cells[1].arrow;
    column.cells[1].arrow = { later: false, limit: "" };
    column.cells[1].named = false;
  }
  settle(column, at);
  settle(column, at + 1);
}

/** Remove a step from a column. @param {Column} column @param {number} at */
export function remove(column, at) {
  const [gone] = column.cells.splice(at, 1), next = column.cells[at];
  if (at === 0 && next) next.arrow = gone.arrow;
  settle(column, at);
  if (!column.cells.length) column.end = null;
}

/** Let a step change places with the one after it; what leads to either stays. @param {Column} column @param {number} at */
export function swap(column, at) {
  const { cells } = column, [one, other] = cells.splice(at, 2);
  [one.arrow, other.arrow] = [other.arrow, one.arrow];
  cells.splice(at, 0, other, one);
  if (!one.block) one.named = false;
  for (const it of [at, at + 1, at + 2]) settle(column, it);
}

/**
 * Put what a locked step stands for in its place; return whether a staff can show it there.
 * @param {Drawing} drawing
 * @param {Place} place
 * @param {Tree} query what the step stands for
 */
export function unfold(drawing, { tab, column: at, step }, query) {
  const columns = drawing.tabs[tab], column = columns[at], [own] = column.cells.slice(step);
  const { tabs, chips } = drawingOf(query), [[line, ...beside], ...others] = tabs;
  if (own.label || own.length || own.repeat || (chips.length && drawing.chips.length)) return false;
  const whole = columns.length === 1 && column.cells.length === 1 && !own.arrow && !column.end;
  if (whole && (!chips.length || drawing.tabs.length === 1)) {
    drawing.tabs.splice(tab, 1, ...tabs);
    drawing.chips.push(...chips);
    return true;
  }
  const absent = [line.cells[0], line.cells[line.cells.length - 1]].some((it) => /^(\?|x0)/.test(it.repeat)); // then what lies between is another time
  if (beside.length || others.length || chips.length || line.end || line.cells[0].arrow || absent) return false;
  line.cells[0].arrow = own.arrow;
  column.cells.splice(step, 1, ...line.cells);
  settle(column, step);
  settle(column, step + line.cells.length);
  return true;
}

/** Write who moves in a step, where the one before it does not tell. @param {Column} column @param {number} at */
export function settle({ cells }, at) {
  const cell = cells[at], before = cells[at - 1];
  if (!cell || (before && !before.block && before.part === cell.part)) return;
  cell.named = true;
  if (cell.block) own(cell.block);
}

/** Write who moves in the first step of each line that stands in brackets. @param {Tree} step */
function own(step) {
  if (step.kind === "step") step.written = true;
  for (const { first } of step.pattern?.alternatives ?? []) own(first.steps[0]);
}

/** Let a step follow at once, or after a gap; the first one at the start of a clip. @param {Cell} cell @param {boolean} first */
export function gap(cell, first) {
  const { arrow } = cell;
  if (arrow && arrow.later && first) cell.arrow = null;
  else if (!arrow) cell.arrow = { later: false, limit: "" };
  else cell.arrow = { later: !arrow.later, limit: arrow.later && COUNT.test(arrow.limit) ? "" : arrow.limit };
}

/** Let another part move in a column. @param {Column} column @param {string} part */
export function move(column, part) {
  const old = column.part;
  column.part = part;
  for (const cell of column.cells) if (!cell.block && cell.part === old) cell.part = part;
}

/** Let the mirror image do as well, or not. @param {Drawing} drawing */
export function either(drawing) {
  const rest = drawing.chips.filter((it) => it.kind !== "either side");
  drawing.chips = rest.length < drawing.chips.length ? rest : [...rest, { kind: "either side", text: "either side" }];
}

// What is read out

/** Return what a step is in the words of the language, without its length. @param {Cell} cell */
export function textOf({ block, part, named, manner, words }) {
  if (block) return blockText(block);
  const said = words.map((it) => `${it.negated ? "not " : ""}${it.values.join("/")}`);
  return [...(named || !words.length ? [part] : []), ...(manner === "move" ? [] : [manner]), ...said].join(" ");
}

/** @param {Tree} block */
function blockText(block) {
  if (block.pattern) return `${block.kind === "mirror" ? "mirror " : ""}(${block.pattern.text})`;
  return block.named ? `@${block.named}` : block.score ?? block.text;
}

/** Return a name as it is read: right arm. @param {string} name @param {{name: string, form: string}[]} movers */
export function titleOf(name, movers) {
  const form = movers.find((it) => it.name === name)?.form;
  const said = nameOf(name);
  return form === "either" || form === "both" ? `${form} ${said}` : said;
}

/** Return what a step is, to be read out. @param {Cell} cell @param {boolean} first */
export function told(cell, first) {
  const { arrow, block, manner, words, label, length, repeat } = cell;
  const said = words.map((it) => `${it.negated ? "not " : ""}${it.values.map(nameOf).join(" or ")}`);
  const before = arrow && (first ? `${arrow.later ? "some time after" : "at"} the start of the clip` : arrow.later ? "after a gap" : "");
  return [
    block ? `locked: ${textOf(cell)}` : said.join(", ") || (manner === "move" ? "any movement" : ""),
    manner === "move" ? "" : manner,
    before,
    arrow?.limit && `time before ${arrow.limit}`,
    length && `length ${length}`,
    repeat && `repeat ${repeat}`,
    label && `named ${label}`,
  ].filter(Boolean).join(", ");
}

/** Return how high a sign is drawn for a length: by its digits, or as usual. @param {string} length */
export function sizeOf(length) {
  const found = /([\d.]+)(ms|s|b|f)(\+?)/.exec(length);
  if (!found) return "usual";
  const seconds = Number(found[1]) * { ms: 0.001, s: 1, b: 0.5, f: 1 / 30 }[/** @type {"ms" | "s" | "b" | "f"} */ (found[2])];
  return seconds < 0.5 ? "short" : seconds >= 1 ? "long" : "usual";
}
