// The standard figure carries out a score while it is edited: first what is near, then all of it.

import { isAbort, send } from "../api.js";
import { Motion } from "../motion.js";
import { around, grain, packed } from "./score.js";

/** @typedef {import("./score.js").Score} Score */
/** @typedef {{score: Score, motion: Motion, start: number, stop: number, whole: boolean}} Clip seconds of a score, from and to */
/** @typedef {{start: number, stop: number, seconds: number, warnings: string[], figure: import("../motion.js").Description, places: string}} Answer */

const NEAR = [1, 3]; // seconds before and behind where the figure is that are carried out first
const FEW = 60; // symbols that are carried out at once
const MANY = 1000; // symbols that are carried out without being played: more would slow down the next edit
const IDLE = 1200; // milliseconds without an edit before all is carried out
const AHEAD = 1.5; // seconds before its end that what comes behind a clip is asked for
const KEPT = 8; // clips

/** What a `Player` plays. */
export class Stage {
  /** @type {Clip[]} the newest first; those of earlier scores are shown until that of this one has come */
  #clips = [];
  /** @type {Score | null} */
  #score = null;
  #near = new AbortController();
  #all = new AbortController();
  /** @type {number | null} seconds around which it is being carried out */
  #asked = null;
  #whole = false; // whether all is asked for
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #idle;
  #soon = false; // whether all is carried out soon
  /** @type {Error | null} */
  #failure = null;

  seconds = 1;
  /** @type {string[]} what the figure could not do */
  warnings = [];
  /** Called when a movement has come, or cannot come. */
  changed = () => {};

  /**
   * Carry out another score, from about some seconds on.
   * @param {Score} score
   * @param {number} at
   * @param {boolean} playing whether all of it is wanted
   */
  async perform(score, at, playing) {
    this.dispose();
    this.#score = score;
    this.#failure = null;
    this.#asked = null;
    this.#whole = false;
    if (score.symbols.length <= FEW) return this.#everything();
    this.#soon = playing || score.symbols.length <= MANY;
    if (this.#soon) this.#idle = setTimeout(() => this.#everything(), IDLE);
    await this.#about(at);
  }

  /** Carry out all of it, unless that is done or comes soon: it is played. */
  play() {
    if (!this.#whole && !this.#soon && this.#score) this.#everything();
  }

  #everything() {
    clearTimeout(this.#idle);
    this.#whole = true;
    this.#all = new AbortController();
    return this.#ask(null, this.#all.signal);
  }

  /** @param {number} seconds */
  #about(seconds) {
    this.#near.abort();
    this.#near = new AbortController();
    this.#asked = seconds;
    return this.#ask([Math.max(seconds - NEAR[0], 0), seconds + NEAR[1]], this.#near.signal);
  }

  /**
   * @param {[number, number] | null} window null: all
   * @param {AbortSignal} signal
   */
  async #ask(window, signal) {
    const whole = /** @type {Score} */ (this.#score), ticks = Number(whole.speed) / 60 * grain(whole);
    const [from, to] = window ?? [0, undefined], score = packed(to === undefined ? whole : around(whole, from * ticks, to * ticks));
    try {
      /** @type {Answer} */
      const answer = await send("POST", "/api/scores/motion", { score, from, to }, signal);
      const bytes = Uint8Array.from(atob(answer.places), (it) => it.charCodeAt(0));
      const motion = new Motion("", answer.figure, async () => new Response(bytes));
      await new Promise((done) => {
        motion.changed = () => done(null);
        motion.ready(0);
      });
      if (signal.aborted) return;
      const clip = { score: whole, motion, start: answer.start, stop: answer.stop, whole: !window };
      this.#clips = [clip, ...this.#clips.filter((it) => it.score === whole ? !clip.whole : it.whole && !clip.whole)].slice(0, KEPT);
      this.seconds = answer.seconds;
      if (clip.whole) this.warnings = answer.warnings;
    } catch (error) {
      if (isAbort(error)) return;
      this.#failure = error instanceof Error ? error : new Error(String(error));
    }
    if (window) this.#asked = null;
    this.changed();
  }

  /** @param {number} seconds */
  #clip(seconds) {
    const here = this.#clips.filter((it) => it.start <= seconds + 1e-6 && seconds <= it.stop + 0.05);
    return here.find((it) => it.whole && it.score === this.#score) ?? here.find((it) => it.score === this.#score) ?? here[0];
  }

  /** @param {number} seconds */
  ready(seconds) {
    const clip = this.#clip(seconds);
    if (clip?.score !== this.#score) this.#want(seconds);
    else if (clip && seconds > clip.stop - AHEAD && clip.stop < this.seconds && this.#clip(clip.stop + AHEAD)?.score !== this.#score) this.#want(clip.stop);
    return Boolean(clip);
  }

  /** Carry out what is around some seconds, unless that is under way or has failed. @param {number} seconds */
  #want(seconds) {
    const asked = this.#asked !== null && this.#asked - NEAR[0] <= seconds && seconds <= this.#asked + NEAR[1];
    if (this.#score && !asked && !this.#failure) this.#about(seconds);
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
