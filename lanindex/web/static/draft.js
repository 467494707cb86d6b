/** A profile that is being changed: what differs from the one that it began as, and undo. */

import { mirrored } from "./cells.js";

/**
 * @typedef {import("./cells.js").Space} Space
 * @typedef {{cells: string[], deleted: number[]}} Rule
 * @typedef {{name: string, value: string | number, units: string[], low: number, high: number, whole: boolean, says: string}} Parameter
 *
 * A profile as the server tells it; the rules of a part are those of a file.
 * @typedef {object} Profile
 * @property {string} name
 * @property {Parameter[]} parameters
 * @property {string} rhythm
 * @property {Record<string, Space>} spaces
 * @property {Record<string, string>} rules
 * @property {Record<string, Rule[]>} files
 *
 * @typedef {{parameters: Record<string, string | number>, spaces: Record<string, Space>, rules: Record<string, Rule[]>}} Changes
 * @typedef {{profile: Profile, changes: string}} State
 */

const SOON = 1000; // milliseconds within which changes of one number are one step

/** @returns {Changes} */
function none() {
  return { parameters: {}, spaces: {}, rules: {} };
}

/** @param {unknown} one @param {unknown} other */
function same(one, other) {
  return JSON.stringify(one) === JSON.stringify(other);
}

/**
 * Return the part of the other side; the part itself where it has none.
 * @param {string} part
 */
export function fellow(part) {
  return part.replace(/^[rl]_/, (side) => (side === "r_" ? "l_" : "r_"));
}

/** @param {Rule[]} rules */
function mirroredRules(rules) {
  const turned = (/** @type {string} */ cell) => cell.replace(/^(r_|l_)/, (it) => (it === "r_" ? "l_" : "r_")).replace(/^(right|left)\b/, (it) => (it === "right" ? "left" : "right"));
  return rules.map((rule) => ({ ...rule, cells: rule.cells.map(turned) }));
}

export class Draft {
  /** @type {Changes} */
  #changes = none();
  /** @type {State[]} */
  #undo = [];
  /** @type {State[]} */
  #redo = [];
  #token = "";
  #at = 0;

  /** Called after each change. */
  changed = () => {};

  /** @param {Profile} profile */
  constructor(profile) {
    this.profile = profile;
  }

  get changes() {
    return this.#changes;
  }

  /** Whether anything differs. */
  get touched() {
    return Object.values(this.#changes).some((it) => Object.keys(it).length > 0);
  }

  get canUndo() {
    return this.#undo.length > 0;
  }

  get canRedo() {
    return this.#redo.length > 0;
  }

  /** @param {string} part */
  space(part) {
    return this.#changes.spaces[part] ?? this.profile.spaces[part];
  }

  /** @param {string} part */
  rules(part) {
    return this.#changes.rules[part] ?? this.profile.files[this.profile.rules[part]];
  }

  /**
   * Return a parameter as the profile has it.
   * @param {string} name
   */
  given(name) {
    return name === "rhythm" ? this.profile.rhythm : this.profile.parameters.find((it) => it.name === name)?.value ?? "";
  }

  /** @param {string} name */
  parameter(name) {
    return this.#changes.parameters[name] ?? this.given(name);
  }

  /**
   * @param {string} name
   * @param {string | number} value
   */
  setParameter(name, value) {
    this.#step(`parameter ${name}`);
    if (same(value, this.given(name))) delete this.#changes.parameters[name];
    else this.#changes.parameters[name] = value;
    this.changed();
  }

  /**
   * @param {string} part
   * @param {Space} space
   * @param {{alike: boolean, token: string}} how alike: the part of the other side changes with it
   */
  setSpace(part, space, { alike, token }) {
    this.#step(`${part} ${token}`);
    this.#put("spaces", part, space, this.profile.spaces[part]);
    const other = fellow(part);
    if (alike && other !== part) this.#put("spaces", other, mirrored(space), this.profile.spaces[other]);
    this.changed();
  }

  /** @param {string} part @param {Rule[]} rules @param {boolean} alike */
  setRules(part, rules, alike) {
    this.#step("");
    const own = (/** @type {string} */ it) => this.profile.files[this.profile.rules[it]], other = fellow(part);
    this.#put("rules", part, rules, own(part));
    if (alike && other !== part) {
      // rules that are the same for all parts are the same on both sides, in another order
      if (same(rules, own(part))) delete this.#changes.rules[other];
      else this.#put("rules", other, mirroredRules(rules), own(other));
    }
    this.changed();
  }

  /** @param {"spaces" | "rules"} kind @param {string} part @param {any} value @param {any} before */
  #put(kind, part, value, before) {
    if (same(value, before)) delete this.#changes[kind][part];
    else this.#changes[kind][part] = value;
  }

  /**
   * Begin with another profile; what was changed of the one before comes back with undo.
   * @param {Profile} profile
   */
  take(profile) {
    this.#step("");
    this.profile = profile;
    this.#changes = none();
    this.changed();
  }

  /** Undo nothing of what was changed by now: it is saved, and may have replaced what it began as. */
  forget() {
    this.#undo = [];
    this.#redo = [];
    this.changed();
  }

  /** Go back to the profile. */
  reset() {
    this.#step("");
    this.#changes = none();
    this.changed();
  }

  undo() {
    this.#go(this.#undo, this.#redo);
  }

  redo() {
    this.#go(this.#redo, this.#undo);
  }

  /**
   * Take changes that came from elsewhere, such as an address.
   * @param {string} text
   */
  restore(text) {
    try {
      const said = JSON.parse(text);
      for (const name of /** @type {const} */ (["parameters", "spaces", "rules"])) {
        if (said[name] && typeof said[name] === "object") Object.assign(this.#changes[name], said[name]);
      }
    } catch {
      // an address that was cut: the profile as it is
    }
  }

  /** @returns {State} */
  #state() {
    return { profile: this.profile, changes: JSON.stringify(this.#changes) };
  }

  /** @param {State[]} from @param {State[]} to */
  #go(from, to) {
    const state = from.pop();
    if (!state) return;
    to.push(this.#state());
    this.profile = state.profile;
    this.#changes = JSON.parse(state.changes);
    this.#token = "";
    this.changed();
  }

  /** @param {string} token what changes; the same soon after is the same step, and empty never is */
  #step(token) {
    const now = performance.now();
    if (!token || token !== this.#token || now - this.#at > SOON) this.#undo.push(this.#state());
    [this.#token, this.#at] = [token, now];
    this.#redo = [];
  }
}

