// The standard figure carries out a score while it is edited: first what is near, then all of it.

import { isAbort, send } from "../api.js";
import { Motion } from "../motion.js";

/** @typedef {{motion: Motion, start: number, stop: number}} Clip seconds of the score, from and to */
/** @typedef {{start: number, stop: number, seconds: number, warnings: string[], figure: import("../motion.js").Description, places: string}} Answer */

const NEAR = [1, 4]; // seconds before and behind where the figure is that are carried out first
const FEW = 60; // symbols that are carried out at once
const IDLE = 1200; // milliseconds without an edit before all is carried out

/** What a `Player` plays. */
export class Stage {
  /** @type {Clip[]} the newest first */
  #clips = [];
  /** @type {unknown} */
  #score = null;
  #many = 0;
  #whole = false;
  /** @type {AbortController} */
  #near = new AbortController();
  /** @type {AbortController} */
  #all = new AbortController();
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #idle;
  /** @type {Error | null} */
  #failure = null;

  seconds = 1;
  /** @type {string[]} what the figure could not do */
  warnings = [];
  /** Called when a movement has come, or cannot come. */
  changed = () => {};

  /**
   * Carry out another score, from about some seconds on.
   * @param {{symbols: unknown[]}} score as the server takes it
   * @param {number} at
   */
  async perform(score, at) {
    clearTimeout(this.#idle);
    this.#near.abort();
    this.#all.abort();
    this.#near = new AbortController();
    this.#score = score;
    this.#many = score.symbols.length;
    this.#whole = false;
    this.#failure = null;
    if (this.#many <= FEW) return this.#everything();
    this.#idle = setTimeout(() => this.#everything(), IDLE);
    await this.#ask({ from: Math.max(at - NEAR[0], 0), to: at + NEAR[1] }, this.#near.signal);
  }

  #everything() {
    clearTimeout(this.#idle);
    this.#whole = true;
    this.#all = new AbortController();
    return this.#ask({}, this.#all.signal);
  }

  /**
   * @param {{from?: number, to?: number}} window
   * @param {AbortSignal} signal
   */
  async #ask(window, signal) {
    try {
      /** @type {Answer} */
      const answer = await send("POST", "/api/scores/motion", { score: this.#score, ...window }, signal);
      const bytes = Uint8Array.from(atob(answer.places), (it) => it.charCodeAt(0));
      const motion = new Motion("", answer.figure, async () => new Response(bytes));
      await new Promise((done) => {
        motion.changed = () => done(null);
        motion.ready(0);
      });
      if (signal.aborted) return;
      const clip = { motion, start: answer.start, stop: answer.stop };
      const all = window.from === undefined;
      this.#clips = all ? [clip] : [clip, ...this.#clips.slice(0, 1)];
      this.seconds = answer.seconds;
      if (all) this.warnings = answer.warnings;
    } catch (error) {
      if (isAbort(error)) return;
      this.#failure = error instanceof Error ? error : new Error(String(error));
    }
    this.changed();
  }

  /** @param {number} seconds */
  #clip(seconds) {
    const here = (/** @type {Clip} */ it) => it.start <= seconds + 1e-6 && seconds <= it.stop + 0.05;
    return this.#clips.find(here);
  }

  /** @param {number} seconds */
  ready(seconds) {
    if (this.#clip(seconds)) return true;
    if (!this.#whole && this.#score) this.#everything();
    return false;
  }

  /** @param {number} seconds */
  failure(seconds) {
    return this.#clip(seconds) ? null : this.#failure;
  }

  retry() {}

  /** Why it is not carried out, or not all of it. */
  get problem() {
    return this.#failure;
  }

  /**
   * Return the body at some seconds; null: it is not carried out yet.
   * @param {number} seconds
   * @returns {import("../look.js").Body | null}
   */
  body(seconds) {
    const clip = this.#clip(seconds), pose = clip?.motion.pose(Math.max(seconds - clip.start, 0));
    return clip && pose ? { strokes: clip.motion.description.strokes, pose } : null;
  }

  /** How high the floor is, mm. */
  get floor() {
    return this.#clips[0]?.motion.description.floor ?? null;
  }

  dispose() {
    clearTimeout(this.#idle);
    this.#near.abort();
    this.#all.abort();
  }
}
