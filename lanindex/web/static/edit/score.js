// The score that the editor holds: symbols in ticks. Nothing is changed; every edit makes a new one.

import { nameOf } from "../names.js";

/**
 * @typedef {object} Sign a symbol: what a part does between two ticks; a position has no length
 * @property {string} part
 * @property {number} start
 * @property {number} stop
 * @property {string[]} words of its fields, as in LND
 * @property {string} [seen] which sign of a picture it was
 *
 * @typedef {object} Score
 * @property {string} speed beats a minute
 * @property {number} beats of a bar
 * @property {number} beat the note that is one: 4 for a quarter
 * @property {number} division ticks of a bar
 * @property {number} units how many bars, at least
 * @property {string[]} other lines that are kept as they are
 * @property {Sign[]} symbols by part and time
 *
 * @typedef {object} Field
 * @property {string} name
 * @property {"direction" | "level" | "amount"} field
 * @property {string[]} words none where it is a number of degrees
 *
 * @typedef {object} Track
 * @property {string} part
 * @property {string} kind
 * @property {boolean} column whether it has a column of the staff
 * @property {boolean} drawn whether the staff shows it at all
 * @property {boolean} lasts whether it begins with a position
 * @property {Field[]} fields
 *
 * @typedef {object} Alphabet
 * @property {Track[]} tracks
 * @property {Record<string, string>} mirrored
 * @property {Record<string, Record<string, string>>} signs SVG, by kind and words
 * @property {{name: string, title: string, suffix: string, text: boolean}[]} notations
 * @property {string[]} pictures endings of files that may be of printed scores
 */

const GRAIN = 24; // ticks of a beat of a new score

/** @returns {Score} */
export function blank() {
  return { speed: "60", beats: 4, beat: 4, division: 4 * GRAIN, units: 4, other: [], symbols: [] };
}

/**
 * Return a score as the server sends it and takes it.
 * @param {Score} score
 */
export function packed(score) {
  return { ...score, symbols: score.symbols.map((it) => [it.part, it.start, it.stop, ...it.words]) };
}

/**
 * @param {any} data
 * @returns {Score}
 */
export function unpacked(data) {
  const symbols = data.symbols.map((/** @type {[string, number, number, ...string[]]} */ [part, start, stop, ...words]) => ({ part, start, stop, words }));
  return { ...data, symbols: symbols.sort(inOrder) };
}

/** @param {Sign} a @param {Sign} b */
function inOrder(a, b) {
  return a.part < b.part ? -1 : a.part > b.part ? 1 : a.start - b.start || a.stop - b.stop;
}

/** Return the ticks of a beat. @param {Score} score */
export function grain(score) {
  return score.division / score.beats;
}

/** Return the last tick of a score's last bar. @param {Score} score */
export function end(score) {
  return score.units * score.division;
}

/**
 * Return a score without some symbols and with others, for which those in their way make room.
 * @param {Score} score
 * @param {Iterable<Sign>} gone
 * @param {Sign[]} come
 * @returns {Score}
 */
export function changed(score, gone, come) {
  const out = new Set(gone);
  let left = score.symbols.filter((it) => !out.has(it));
  for (const one of come) left = left.flatMap((it) => (it.part === one.part ? beside(it, one) : [it]));
  const symbols = [...left, ...come].sort(inOrder);
  const last = Math.max(0, ...come.map((it) => it.stop));
  return { ...score, symbols, units: Math.max(score.units, Math.ceil(last / score.division)) };
}

/**
 * Return what is left of a symbol beside another of its part.
 * @param {Sign} it
 * @param {Sign} one
 * @returns {Sign[]}
 */
function beside(it, one) {
  const point = one.start === one.stop, still = it.start === it.stop;
  if (still) return it.start === one.start ? (point ? [] : [it]) : it.start > one.start && it.start < one.stop ? [] : [it];
  if (it.stop <= one.start || it.start >= one.stop && it.start >= one.start) return [it];
  if (it.start < one.start) return [{ ...it, stop: one.start }];
  return it.stop > one.stop ? [{ ...it, start: one.stop }] : [];
}

/**
 * Return symbols later by some ticks, as far as the beginning lets them.
 * @param {Sign[]} symbols
 * @param {number} by
 */
export function later(symbols, by) {
  const own = Math.max(by, -Math.min(...symbols.map((it) => it.start)));
  return symbols.map((it) => ({ ...it, start: it.start + own, stop: it.stop + own }));
}

/**
 * Return symbols whose beginnings and ends are moved; each keeps a length.
 * @param {Sign[]} symbols
 * @param {number} begins ticks by which they begin later
 * @param {number} ends
 * @param {number} least ticks that are left
 */
export function stretched(symbols, begins, ends, least) {
  return symbols.map((it) => {
    const short = Math.min(least, it.stop - it.start || least);
    const start = Math.min(Math.max(it.start + begins, 0), begins ? it.stop - short : it.start);
    return { ...it, start, stop: ends ? Math.max(it.stop + ends, start + short) : it.stop };
  });
}

/** Return the part on the other side. @param {string} part */
function twin(part) {
  return part.replace(/^[rl]_/, (side) => ({ r_: "l_", l_: "r_" }[side] ?? side));
}

/**
 * Return symbols with left and right changed.
 * @param {Sign[]} symbols
 * @param {Alphabet} alphabet
 * @returns {Sign[]}
 */
export function mirrored(symbols, alphabet) {
  return symbols.map((it) => {
    const fields = trackOf(it.part, alphabet).fields;
    const words = it.words.map((word, at) => (fields[at]?.field === "direction" ? alphabet.mirrored[word] ?? word : word));
    return { ...it, part: twin(it.part), words };
  });
}

/**
 * Return what is known of a part; one that is not known moves like a limb.
 * @param {string} part
 * @param {Alphabet} alphabet
 * @returns {Track}
 */
export function trackOf(part, alphabet) {
  const limb = /** @type {Track} */ (alphabet.tracks.find((it) => it.kind === "gesture"));
  return alphabet.tracks.find((it) => it.part === part) ?? { ...limb, part, column: false, drawn: false };
}

/**
 * Return a score in another metre; symbols keep their beats.
 * @param {Score} score
 * @param {number} beats
 * @param {number} beat
 * @returns {Score}
 */
export function inMeter(score, beats, beat) {
  const division = grain(score) * beats, all = Math.ceil(end(score) / division);
  return { ...score, beats, beat, division, units: all };
}

/**
 * Return a score of so many bars; no symbol is cut.
 * @param {Score} score
 * @param {number} bars
 * @returns {Score}
 */
export function ofBars(score, bars) {
  const last = Math.max(0, ...score.symbols.map((it) => it.stop));
  return { ...score, units: Math.max(1, Math.ceil(last / score.division), bars) };
}

/**
 * Return some symbols as a score of their own, from the first on.
 * @param {Score} score
 * @param {Sign[]} symbols
 * @returns {Score}
 */
export function part(score, symbols) {
  const moves = symbols.filter((it) => it.start < it.stop || !it.start);
  const first = Math.min(...moves.map((it) => it.start));
  const own = moves.map((it) => ({ ...it, start: it.start - first, stop: it.stop - first }));
  const last = Math.max(...own.map((it) => it.stop));
  return { ...score, other: [], units: Math.max(1, Math.ceil(last / score.division)), symbols: own.sort(inOrder) };
}

/**
 * Return a score with the symbols alone that tell of a stretch: those in it, and of each part the last before it.
 * @param {Score} score
 * @param {number} from ticks
 * @param {number} to
 * @returns {Score}
 */
export function around(score, from, to) {
  if (score.other.some((it) => /^\/\/ beats from/.test(it))) return score; // symbols tell when its beats come
  const near = score.symbols.filter((it, at) => it.start <= to && (it.stop >= from || score.symbols[at + 1]?.part !== it.part || score.symbols[at + 1].stop >= from));
  return { ...score, symbols: near };
}

/** Return a number of beats in few digits. @param {number} count */
export function short(count) {
  return String(Math.round(count * 1000) / 1000);
}

/** Return where a tick is: bar 2 beat 1.5. @param {Score} score @param {number} tick */
export function placeOf(score, tick) {
  if (tick < 0) return "the starting position";
  const bar = Math.floor(tick / score.division);
  return `bar ${bar + 1} beat ${short((tick - bar * score.division) / grain(score) + 1)}`;
}

/** Return a symbol in words. @param {Score} score @param {Sign} it */
export function told(score, it) {
  const long = (it.stop - it.start) / grain(score);
  const when = it.stop === 0 ? placeOf(score, -1) : `${placeOf(score, it.start)}, ${long ? `${short(long)} ${long === 1 ? "beat" : "beats"}` : "seen from there on"}`;
  return `${nameOf(it.part)}, ${it.words.map(nameOf).join(" ")}, ${when}`;
}
