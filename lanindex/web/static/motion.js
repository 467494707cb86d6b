/** The movement of a capture, fetched in tiles as it is looked at. */

/**
 * What is known of a capture's body before any of its tiles.
 * @typedef {object} Description
 * @property {number} rate frames a second
 * @property {number} frames
 * @property {number} tile frames of a tile
 * @property {string[]} joints
 * @property {import("./look.js").Stroke[]} strokes
 * @property {number | null} floor its height, mm
 */

/**
 * @typedef {{origin: Float32Array, places: Int16Array}} Tile
 * @typedef {(path: string, init: {signal: AbortSignal}) => Promise<Response>} Fetch
 */

const UNKNOWN = -32768;
const HEADER = 12; // bytes: the origin, three float32

const SOON = 5; // seconds: what is played later is not fetched yet
const STEP = 0.1; // seconds from one point of the way to the next
const OFFSETS = [-0.75, -0.5, -0.25, 0.75, 0.5, 0.25]; // seconds at which ghosts are, the farthest first

/** Whether numbers in memory have the order of those in tiles. */
const LITTLE = new Uint8Array(new Uint16Array([1]).buffer)[0] === 1;

/**
 * Return the tile that some bytes hold.
 * @param {ArrayBuffer} bytes
 * @returns {Tile}
 */
export function unpacked(bytes) {
  if (!LITTLE) {
    const view = new DataView(bytes);
    for (let at = 0; at < HEADER; at += 4) view.setUint32(at, view.getUint32(at, true));
    for (let at = HEADER; at < bytes.byteLength; at += 2) view.setUint16(at, view.getUint16(at, true));
  }
  return { origin: new Float32Array(bytes, 0, 3), places: new Int16Array(bytes, HEADER) };
}

export class Motion {
  /** @type {Map<number, Tile>} tiles by number, the one used last at the end */
  #tiles = new Map();
  /** @type {AbortController | null} of the tile that is on its way: one after the other, so that no server works on what nobody looks at any more */
  #coming = null;
  /** @type {Map<number, Error>} */
  #failed = new Map();
  #fetch;
  #most;

  /** Called when a tile has come, or cannot come. */
  changed = () => {};

  /**
   * @param {string} path of the capture: `/api/captures/12`
   * @param {Description} description
   * @param {Fetch} fetch
   * @param {number} most tiles that are kept
   */
  constructor(path, description, fetch = globalThis.fetch.bind(globalThis), most = 64) {
    this.path = path;
    this.description = description;
    this.#fetch = fetch;
    this.#most = most;
  }

  /** How long it is, seconds. */
  get seconds() {
    return this.description.frames / this.description.rate;
  }

  /** How many tiles are held. */
  get held() {
    return this.#tiles.size;
  }

  /**
   * Return the number of the tile at some seconds.
   * @param {number} seconds
   */
  #at(seconds) {
    return Math.floor(this.#frame(seconds) / this.description.tile);
  }

  /**
   * Return the frame at some seconds, and what is left to the next.
   * @param {number} seconds
   */
  #frame(seconds) {
    return Math.min(Math.max(seconds * this.description.rate, 0), this.description.frames - 1);
  }

  /**
   * Whether the pose at some seconds can be shown; fetches its tile, and those that come soon, and no others.
   * @param {number} seconds
   */
  ready(seconds) {
    const at = this.#at(seconds);
    if (!this.#coming) {
      const lacking = [at, this.#at(seconds + SOON)].find((it) => !this.#tiles.has(it) && !this.#failed.has(it));
      if (lacking !== undefined) this.#load(lacking);
    }
    return this.#tiles.has(at);
  }

  /**
   * Return why the pose at some seconds cannot come; null: it is there or on its way.
   * @param {number} seconds
   */
  failure(seconds) {
    return this.#failed.get(this.#at(seconds)) ?? null;
  }

  /** Try again what could not come. */
  retry() {
    this.#failed.clear();
  }

  /** Stop what is on its way. */
  abort() {
    this.#coming?.abort();
  }

  /** @param {number} number */
  async #load(number) {
    const coming = (this.#coming = new AbortController());
    try {
      const answer = await this.#fetch(`${this.path}/motion/${number}`, { signal: coming.signal });
      if (!answer.ok) throw new Error(`the movement could not be read (${answer.status})`);
      this.#tiles.set(number, unpacked(await answer.arrayBuffer()));
      for (const oldest of this.#tiles.keys()) {
        if (this.#tiles.size <= this.#most) break;
        this.#tiles.delete(oldest);
      }
    } catch (error) {
      if (coming.signal.aborted) return;
      this.#failed.set(number, error instanceof Error ? error : new Error(String(error)));
    } finally {
      this.#coming = null;
    }
    this.changed();
  }

  /**
   * Return where the joints are at some seconds, mm, NaN where unknown; null: the tile is not there.
   * @param {number} seconds
   * @param {Float32Array} into three numbers a joint
   */
  pose(seconds, into = new Float32Array(3 * this.description.joints.length)) {
    const frame = this.#frame(seconds), first = Math.floor(frame), rest = frame - first;
    const size = 3 * this.description.joints.length, { tile } = this.description;
    const number = Math.floor(first / tile), here = this.#tiles.get(number);
    if (!here) return null;
    this.#tiles.delete(number);
    this.#tiles.set(number, here);
    const later = Math.min(first + 1, this.description.frames - 1);
    const after = this.#tiles.get(Math.floor(later / tile)) ?? here;
    const a = (first % tile) * size, b = after === here && later % tile === 0 ? a : (later % tile) * size;
    for (let at = 0; at < size; at++) {
      const start = here.places[a + at], stop = after.places[b + at], axis = at % 3;
      const from = start === UNKNOWN ? NaN : start + here.origin[axis];
      into[at] = stop === UNKNOWN ? from : from + rest * (stop + after.origin[axis] - from);
    }
    return into;
  }

  /**
   * Return poses before and after some seconds, and how faint each is.
   * @param {number} seconds
   * @returns {import("./look.js").Ghost[]}
   */
  around(seconds) {
    const most = Math.abs(OFFSETS[0]);
    return OFFSETS.flatMap((offset) => {
      const time = seconds + offset, pose = time < 0 || time > this.seconds ? null : this.pose(time);
      return pose ? [{ pose, faint: 0.55 + 0.35 * Math.abs(offset) / most }] : [];
    });
  }

  /**
   * Return where the pelvis was until some seconds: x and z by turns, NaN where unknown.
   * @param {number} seconds
   * @param {number} back over how long
   */
  way(seconds, back = 60) {
    const joint = 3 * this.description.joints.indexOf("Pelvis"), into = new Float32Array(3 * this.description.joints.length);
    const first = Math.ceil(Math.max(seconds - back, 0) / STEP), last = Math.floor(seconds / STEP);
    const way = new Float32Array(2 * (Math.max(last - first, -1) + 2)).fill(NaN);
    for (let step = first; step <= last + 1; step++) {
      const pose = this.pose(Math.min(step * STEP, seconds), into);
      if (pose) way.set([pose[joint], pose[joint + 2]], 2 * (step - first));
    }
    return way;
  }
}
