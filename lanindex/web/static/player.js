/** The clock of what is played, and the buttons and keys that move it. */

import { face, button, toggle, toolbar } from "./widgets.js";

/**
 * What is played: a `Motion` is such.
 * @typedef {object} Source
 * @property {number} seconds how long it lasts
 * @property {(seconds: number) => boolean} ready whether it can be shown at some seconds; fetches it
 * @property {(seconds: number) => Error | null} failure why it cannot
 * @property {() => void} retry
 *
 * @typedef {(seconds: number, player: Player) => void} Listener
 */

const SPEEDS = [0.25, 0.5, 1, 2, 4];
const LONGEST = 0.25; // seconds that a frame may take: of a longer one the rest is not played
const ARROW = 1; // seconds that an arrow key goes
const TICKS = 10000; // of the slider

export class Player {
  #source;
  #rate;
  /** @type {Set<Listener>} */
  #listeners = new Set();
  /** @type {[number, number]} */
  #range;
  #seconds = 0;
  #frame = 0;
  #last = 0;
  #playing = false;
  #speed = 1;
  #loop = false;

  /** Whether it waits for what is not there yet. */
  waiting = false;

  /**
   * @param {Source} source
   * @param {number} rate frames a second
   */
  constructor(source, rate) {
    this.#source = source;
    this.#rate = rate;
    this.#range = [0, source.seconds];
  }

  /** How long it lasts, seconds. */
  get length() {
    return this.#source.seconds;
  }

  get playing() {
    return this.#playing;
  }

  get seconds() {
    return this.#seconds;
  }

  /** How many times as fast as it was it is played. */
  get speed() {
    return this.#speed;
  }

  set speed(times) {
    this.#speed = times;
    this.#later();
  }

  /** Whether the range is played again and again. */
  get loop() {
    return this.#loop;
  }

  set loop(on) {
    this.#loop = on;
    this.#later();
  }

  /** What is played again and again, from and to, seconds; all of it by default. */
  get range() {
    return this.#range;
  }

  /** @param {[number, number] | null} ends */
  set range(ends) {
    this.#range = ends ?? [0, this.length];
    this.#later();
  }

  /** Why it cannot go on; empty where it can. */
  get trouble() {
    return this.#source.failure(this.#seconds)?.message ?? "";
  }

  /**
   * Call a function once a frame while something changes; return what ends that.
   * @param {Listener} listener
   */
  listen(listener) {
    this.#listeners.add(listener);
    this.#later();
    return () => this.#listeners.delete(listener);
  }

  play() {
    const [from, to] = this.#loop ? this.#range : [0, this.length];
    if (this.#seconds >= to || this.#loop && this.#seconds < from) this.#seconds = from;
    this.#source.retry();
    this.#playing = true;
    this.#last = performance.now();
    this.#later();
  }

  pause() {
    this.#playing = false;
    this.#later();
  }

  toggle() {
    if (this.#playing) this.pause();
    else this.play();
  }

  /**
   * Go to some seconds.
   * @param {number} seconds
   */
  seek(seconds) {
    this.#seconds = Math.min(Math.max(seconds, 0), this.length);
    this.#source.retry();
    this.#later();
  }

  /**
   * Stop, and go some frames on or back.
   * @param {number} frames
   */
  step(frames) {
    this.pause();
    this.seek((Math.round(this.#seconds * this.#rate) + frames) / this.#rate);
  }

  /** Show the same again, after something came or changed. */
  refresh() {
    this.#later();
  }

  /** Stop for good. */
  dispose() {
    cancelAnimationFrame(this.#frame);
    this.#listeners.clear();
    this.#playing = false;
  }

  #later() {
    this.#frame ||= requestAnimationFrame((now) => this.#tick(now));
  }

  /** @param {number} now milliseconds */
  #tick(now) {
    this.#frame = 0;
    const passed = Math.min(Math.max((now - this.#last) / 1000, 0), LONGEST);
    this.#last = now;
    const next = this.#playing ? this.#after(this.#seconds + passed * this.#speed) : this.#seconds;
    this.waiting = !this.#source.ready(next);
    if (!this.waiting) this.#seconds = next;
    if (this.trouble) this.#playing = false;
    for (const listener of this.#listeners) listener(this.#seconds, this);
    if (this.#playing) this.#later();
  }

  /**
   * Return where the clock stands that has come to some seconds.
   * @param {number} seconds
   */
  #after(seconds) {
    const [from, to] = this.#loop ? this.#range : [0, this.length];
    if (seconds < to) return seconds;
    if (this.#loop && to > from) return from;
    this.#playing = false;
    return to;
  }
}

/**
 * Return some seconds as a clock shows them.
 * @param {number} seconds
 */
function clock(seconds) {
  const minutes = Math.floor(seconds / 60), rest = (seconds - 60 * minutes).toFixed(2);
  return `${minutes}:${rest.padStart(5, "0")}`;
}

/**
 * Return the toolbar of a player.
 * @param {Player} player
 */
export function playerBar(player) {
  const play = button(() => player.toggle()), back = button(() => player.step(-1)), next = button(() => player.step(1));
  face(back, "back", "A frame back", ",");
  face(next, "next", "A frame on", ".");
  const loop = toggle((on) => { player.loop = on; }, player.loop);
  face(loop, "loop", "Loop", "l");

  const time = document.createElement("input");
  Object.assign(time, { type: "range", min: "0", max: String(TICKS), step: "1", value: "0", className: "time" });
  time.setAttribute("aria-label", "Time");
  time.addEventListener("input", () => player.seek(Number(time.value) / TICKS * player.length));

  const speed = document.createElement("select");
  speed.setAttribute("aria-label", "Speed");
  for (const times of SPEEDS) {
    speed.add(new Option(`${{ 0.25: "\u00bc", 0.5: "\u00bd" }[times] ?? times}\u00a0\u00d7`, String(times)));
  }
  speed.addEventListener("change", () => { player.speed = Number(speed.value); });

  const shown = document.createElement("span"), state = document.createElement("span");
  shown.className = "clock";
  state.className = "state";
  state.setAttribute("role", "status");

  /** @type {boolean | null} */
  let playing = null;
  player.listen((seconds) => {
    const text = `${clock(seconds)} / ${clock(player.length)}`;
    if (shown.textContent !== text) shown.textContent = text;
    time.value = String(Math.round(TICKS * seconds / player.length));
    time.setAttribute("aria-valuetext", clock(seconds));
    if (playing !== player.playing) {
      playing = player.playing;
      face(play, playing ? "pause" : "play", playing ? "Pause" : "Play", "Space");
    }
    loop.setAttribute("aria-pressed", String(player.loop));
    speed.value = String(player.speed);
    const said = player.trouble || (player.waiting ? "Waiting for the movement\u2026" : "");
    if (state.textContent !== said) state.textContent = said;
  });
  return toolbar("Playback", [back, play, next, time, shown, speed, loop, state]);
}

/**
 * Let keys move a player wherever in an element they are pressed, but for where text is typed.
 * @param {HTMLElement} root
 * @param {Player} player
 * @param {AbortSignal} [signal] ends it
 */
export function playerKeys(root, player, signal) {
  root.addEventListener("keydown", (event) => {
    if (event.defaultPrevented || event.ctrlKey || event.altKey || event.metaKey || event.shiftKey) return;
    const target = /** @type {Element} */ (event.target);
    if (target.matches("input:not([type=range]), select, textarea, [contenteditable]")) return;
    if (event.key === " " && target.matches("button, a, summary")) return;
    /** @type {Record<string, () => void>} */
    const keys = {
      " ": () => player.toggle(),
      ArrowLeft: () => player.seek(player.seconds - ARROW),
      ArrowRight: () => player.seek(player.seconds + ARROW),
      ",": () => player.step(-1),
      ".": () => player.step(1),
      l: () => { player.loop = !player.loop; },
    };
    const act = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!act) return;
    act();
    event.preventDefault();
  }, { signal });
}
