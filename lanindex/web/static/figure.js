/** The figure on a canvas: what is looked at, from where, and the keys and pointers that turn it. */

import { CanvasDrawer } from "./figure_canvas.js";
import { COLORS } from "./look.js";
import { button, toggle, toolbar } from "./widgets.js";

/**
 * @typedef {import("./look.js").Stroke} Stroke
 * @typedef {import("./look.js").Body} Body
 * @typedef {import("./look.js").Drawer} Drawer
 * @typedef {import("./look.js").Palette} Palette
 * @typedef {import("./look.js").View} View
 * @typedef {typeof import("./figure_space.js").SpaceDrawer} Space
 */

const TILT = 12; // degrees from which a figure is looked down upon, so that the floor is seen
const ROOM = 1.12; // times the longest way through the body that is shown
const LOW = 0.4; // share of the picture that is below its middle, from the floor
const EASE = 0.25; // seconds in which the eye follows most of the way
const JUMP = 1500; // mm from which on it goes there at once
const DEGREES = 10; // of an arrow key
const LEAST = 3000; // mm that a plan shows, at least
const KEYS = "Arrow keys turn it, plus and minus change its size, 0 sets it back.";

const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i; // what draws WebGL without a graphics card
const CARD = "card"; // under which the tab remembers whether there is one: to ask takes a while

/**
 * Return what draws a figure with WebGL; null where that would be done by software: a canvas is many
 * times as fast. `?figure=space` and `?figure=canvas` choose.
 * @returns {Promise<Space | null>}
 */
export async function spaceDrawer() {
  const asked = new URLSearchParams(location.search).get("figure");
  if (!(asked ? asked === "space" : accelerated())) return null;
  return (await import("./figure_space.js")).SpaceDrawer;
}

/** Whether a graphics card draws WebGL: browsers give it by software, too, and tell that by its name alone. */
function accelerated() {
  const known = sessionStorage.getItem(CARD);
  if (known) return known === "yes";
  const context = document.createElement("canvas").getContext("webgl2");
  const told = context?.getExtension("WEBGL_debug_renderer_info");
  const card = context !== null && !SOFTWARE.test(context.getParameter(told?.UNMASKED_RENDERER_WEBGL ?? context.RENDERER));
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  sessionStorage.setItem(CARD, card ? "yes" : "no");
  return card;
}

export class Figure {
  /** @type {Body[]} */
  #bodies = [];
  /** @type {Drawer} */
  #drawer;
  /** @type {Palette} */
  #palette = {};
  /** @type {[number, number, number] | null} */
  #target = null;
  #front = 0;
  #span = 0;
  #turn = 0;
  #tilt = TILT;
  #zoom = 1;
  #frame = 0;
  #last = 0;
  #width = 0;
  #height = 0;
  #follow = true;
  #plan = false;
  #two = false;
  #gone = new AbortController();

  /** How often it has been drawn. */
  drawn = 0;
  /** @type {number | null} how high the floor is, mm */
  floor = null;
  /** @type {number | null} how many mm are shown from bottom to top; null: as many as the bodies need */
  span = null;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {{label?: string, space?: Space | null}} options space: what draws it with WebGL
   */
  constructor(canvas, { label = "The figure", space = null } = {}) {
    this.canvas = canvas;
    const drawer = space?.on(canvas, () => this.later()) ?? null;
    this.#drawer = drawer ?? new CanvasDrawer(canvas);
    this.kind = drawer ? "space" : "canvas";
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "application");
    canvas.setAttribute("aria-label", `${label}. ${KEYS}`);
    this.#listen();
    this.recolor();
  }

  #listen() {
    const { canvas } = this, { signal } = this.#gone;
    const sizes = new ResizeObserver(() => this.#resize());
    sizes.observe(canvas);
    signal.addEventListener("abort", () => sizes.disconnect());
    window.addEventListener("resize", () => this.#resize(), { signal });
    const dark = matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", () => this.recolor(), { signal });
    canvas.addEventListener("keydown", (event) => this.#key(event), { signal });
    canvas.addEventListener("wheel", (event) => this.#wheel(event), { signal, passive: false });
    /** @type {Map<number, PointerEvent>} */
    const held = new Map();
    canvas.addEventListener("pointerdown", (event) => {
      held.set(event.pointerId, event);
      canvas.setPointerCapture(event.pointerId);
    }, { signal });
    for (const name of /** @type {const} */ (["pointerup", "pointercancel"])) {
      canvas.addEventListener(name, (event) => held.delete(event.pointerId), { signal });
    }
    canvas.addEventListener("pointermove", (event) => {
      const before = held.get(event.pointerId);
      if (!before) return;
      const other = [...held.values()].find((it) => it.pointerId !== event.pointerId);
      held.set(event.pointerId, event);
      if (other) {
        const [was, is] = [before, event].map((it) => Math.hypot(it.clientX - other.clientX, it.clientY - other.clientY));
        if (was && is) this.zoom(is / was);
      } else {
        this.turn((before.clientX - event.clientX) / 2.5, (event.clientY - before.clientY) / 4);
      }
    }, { signal });
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || event.shiftKey && event.key !== "+") return;
    /** @type {Record<string, () => void>} */
    const keys = {
      ArrowLeft: () => this.turn(DEGREES, 0),
      ArrowRight: () => this.turn(-DEGREES, 0),
      ArrowUp: () => this.turn(0, DEGREES),
      ArrowDown: () => this.turn(0, -DEGREES),
      "+": () => this.zoom(1.15),
      "=": () => this.zoom(1.15),
      "-": () => this.zoom(1 / 1.15),
      0: () => this.reset(),
    };
    const act = keys[event.key];
    if (!act) return;
    act();
    event.preventDefault();
    event.stopPropagation(); // the player has arrow keys of its own
  }

  /** @param {WheelEvent} event */
  #wheel(event) {
    if (!event.ctrlKey && document.activeElement !== this.canvas) return; // the page scrolls
    this.zoom(Math.exp(-Math.sign(event.deltaY) * Math.min(Math.abs(event.deltaY), 100) / 500));
    event.preventDefault();
  }

  /**
   * Look from elsewhere.
   * @param {number} right degrees
   * @param {number} up degrees
   */
  turn(right, up) {
    this.#turn += right;
    this.#tilt = Math.min(Math.max(this.#tilt + up, -5), 89);
    this.later();
  }

  /**
   * Make it larger, by a factor.
   * @param {number} by
   */
  zoom(by) {
    this.#zoom = Math.min(Math.max(this.#zoom * by, 0.2), 8);
    this.later();
  }

  /** Look at it from the front again, all of it. */
  reset() {
    this.#measure();
    this.#turn = 0;
    this.#tilt = TILT;
    this.#zoom = 1;
    this.#target = null;
    this.later();
  }

  /** Whether the eye follows the body. */
  get follow() {
    return this.#follow;
  }

  set follow(on) {
    this.#follow = on;
    this.later();
  }

  /** Whether the floor is shown from above in a corner. */
  get plan() {
    return this.#plan;
  }

  set plan(on) {
    this.#plan = on;
    this.later();
  }

  /** Whether it is shown from the front and from the side. */
  get two() {
    return this.#two;
  }

  set two(on) {
    this.#two = on;
    this.later();
  }

  /** Where the eye looks from: degrees about the vertical and above the horizon, and the size. */
  get eye() {
    return { turn: this.#front + this.#turn, tilt: this.#tilt, zoom: this.#zoom };
  }

  /** Take the colours of the page's style again. */
  recolor() {
    const { style } = this.canvas, before = style.color;
    for (const [name, color] of Object.entries(COLORS)) {
      style.color = color;
      const numbers = getComputedStyle(this.canvas).color;
      const parts = (numbers.match(/[\d.]+/g) ?? []).slice(0, 3).map(Number);
      const whole = numbers.startsWith("rgb") ? 255 : 1;
      this.#palette[name] = [parts[0] / whole, parts[1] / whole, parts[2] / whole];
    }
    style.color = before;
    this.later();
  }

  /**
   * Draw bodies, at once: what moves with them can be drawn in the same frame.
   * @param {Body[]} bodies
   */
  show(bodies) {
    this.#bodies = bodies;
    if (!this.#span) this.#measure();
    this.#draw();
  }

  /** Draw in the next frame, once. */
  later() {
    this.#frame ||= requestAnimationFrame(() => this.#draw());
  }

  /** Draw in the frame after the next, unless something else draws before. */
  #on() {
    this.#frame ||= requestAnimationFrame(() => {
      this.#frame = 0;
      this.later();
    });
  }

  /** Stop listening, and give back what the graphics card holds. */
  dispose() {
    this.#gone.abort();
    cancelAnimationFrame(this.#frame);
    this.#drawer.dispose();
  }

  /** Find how large the bodies are, and where they look, if enough of them is known. */
  #measure() {
    const size = Math.max(0, ...this.#bodies.map(({ strokes, pose }) => longest(strokes, pose)));
    if (!size) return;
    this.#span = this.span ?? ROOM * size;
    this.#front = front(this.#bodies[0]);
  }

  #resize() {
    const { clientWidth, clientHeight } = this.canvas;
    this.#width = clientWidth;
    this.#height = clientHeight;
    if (clientWidth && clientHeight) {
      this.#drawer.resize(clientWidth, clientHeight, Math.min(window.devicePixelRatio || 1, 2));
      this.#draw();
    }
  }

  #draw() {
    cancelAnimationFrame(this.#frame);
    this.#frame = 0;
    if (!this.#width || !this.#height || !this.#span) return;
    const target = this.#aim();
    const views = this.#views(target);
    this.#drawer.draw(views, { bodies: this.#bodies, floor: this.floor, palette: this.#palette });
    this.drawn++;
  }

  /**
   * Return where the eye looks, a little nearer to where the bodies are.
   * @returns {[number, number, number]}
   */
  #aim() {
    const now = performance.now(), passed = Math.min((now - this.#last) / 1000, 0.1);
    this.#last = now;
    const middle = midst(this.#bodies);
    if (!middle) return this.#target ?? [0, 0, 0];
    const at = this.#target ?? middle;
    const far = Math.hypot(middle[0] - at[0], middle[2] - at[2]);
    if (this.#follow && far > 0) {
      const share = far > JUMP || far < 1 ? 1 : 1 - Math.exp(-passed / EASE);
      for (const axis of [0, 2]) at[axis] += share * (middle[axis] - at[axis]);
      if (share < 1) this.#on();
    }
    this.#target = at;
    return [at[0], this.floor === null ? at[1] : this.floor + LOW * this.#span, at[2]];
  }

  /**
   * Return the parts of the canvas.
   * @param {[number, number, number]} target
   * @returns {View[]}
   */
  #views(target) {
    const width = this.#width, height = this.#height, beside = width > 0.9 * height;
    const boxes = !this.#two
      ? [[0, 0, width, height, 0]]
      : beside
        ? [[0, 0, width / 2, height, 0], [width / 2, 0, width / 2, height, 90]]
        : [[0, 0, width, height / 2, 0], [0, height / 2, width, height / 2, 90]];
    const views = boxes.map(([left, top, wide, high, more]) => ({
      left,
      top,
      width: wide,
      height: high,
      turn: this.#front + this.#turn + more,
      tilt: this.#tilt,
      target,
      span: this.#span / this.#zoom * Math.max(1, 0.75 * high / wide),
      plan: false,
    }));
    if (this.#plan) {
      const side = Math.round(Math.min(200, 0.32 * Math.min(views[0].width, views[0].height))), { middle, span } = this.#ground();
      const left = width - side - 10;
      views.push({ left, top: 10, width: side, height: side, turn: this.#front, tilt: 90, target: middle, span, plan: true });
    }
    return views;
  }

  /**
   * Return the middle of what has been walked, and how far it reaches.
   * @returns {{middle: [number, number, number], span: number}}
   */
  #ground() {
    let [left, right, back, near] = [Infinity, -Infinity, Infinity, -Infinity];
    for (const { way, pose } of this.#bodies) {
      for (const [points, step, z] of /** @type {const} */ ([[way ?? [], 2, 1], [pose, 3, 2]])) {
        for (let at = 0; at < points.length; at += step) {
          if (!(points[at] === points[at])) continue;
          left = Math.min(left, points[at]);
          right = Math.max(right, points[at]);
          back = Math.min(back, points[at + z]);
          near = Math.max(near, points[at + z]);
        }
      }
    }
    if (left > right) return { middle: [0, 0, 0], span: LEAST };
    const span = Math.max(LEAST, 1.2 * Math.max(right - left, near - back));
    return { middle: [(left + right) / 2, this.floor ?? 0, (back + near) / 2], span };
  }
}

/**
 * Return the middle of bodies, mm; null: nothing of them is known.
 * @param {Body[]} bodies
 * @returns {[number, number, number] | null}
 */
function midst(bodies) {
  const sums = [0, 0, 0];
  let count = 0;
  for (const { pose } of bodies) {
    const own = pose[0] === pose[0] ? 3 : pose.length; // the pelvis, or all that is known
    const known = [];
    for (let at = 0; at < own; at += 3) if (pose[at] === pose[at]) known.push(at);
    if (!known.length) continue;
    for (let axis = 0; axis < 3; axis++) {
      sums[axis] += known.reduce((sum, at) => sum + pose[at + axis], 0) / known.length;
    }
    count++;
  }
  return count ? [sums[0] / count, sums[1] / count, sums[2] / count] : null;
}

/**
 * Return the longest way along the bones of a body, mm: it is the same in every pose.
 * @param {Stroke[]} strokes
 * @param {Float32Array} pose
 */
function longest(strokes, pose) {
  /** @type {Map<number, number>} by joint, how far it is to the farthest end below it */
  const below = new Map();
  let most = 0;
  for (let round = 0; round < 10; round++) {
    most = 0;
    /** @type {Map<number, number[]>} */
    const ways = new Map();
    for (const { from, to, share } of strokes) {
      const length = Math.hypot(...[0, 1, 2].map((axis) => pose[3 * from + axis] - pose[3 * to + axis]));
      if (share === 1 || !(length >= 0)) continue;
      ways.set(from, [...(ways.get(from) ?? []), length + (below.get(to) ?? 0)]);
    }
    for (const [joint, own] of ways) {
      own.sort((a, b) => b - a);
      below.set(joint, own[0]);
      most = Math.max(most, own[0] + (own[1] ?? 0));
    }
  }
  return most;
}

/**
 * Return from where a body is seen from the front, degrees: it has its left at +x where it is 0.
 * @param {Body} body
 */
function front({ strokes, pose }) {
  const sides = ["left", "right"].map((side) =>
    strokes.find((it) => it.color === side && it.part.endsWith("thigh")) ?? strokes.find((it) => it.color === side));
  if (!sides[0] || !sides[1]) return 0;
  const [left, right] = [3 * sides[0].from, 3 * sides[1].from];
  const angle = Math.atan2(-(pose[left + 2] - pose[right + 2]), pose[left] - pose[right]);
  return angle === angle ? angle * 180 / Math.PI : 0;
}

/**
 * Return the switches of a figure; `ghosts` is called when poses around are wanted, or not.
 * @param {Figure} figure
 * @param {(on: boolean) => void} ghosts
 */
export function figureBar(figure, ghosts) {
  return toolbar("View", [
    toggle((on) => { figure.follow = on; }, figure.follow, "Follow"),
    toggle((on) => { figure.plan = on; }, figure.plan, "Floor plan"),
    toggle((on) => { figure.two = on; }, figure.two, "Front and side"),
    toggle(ghosts, false, "Ghosts"),
    button(() => figure.reset(), "Reset"),
  ]);
}
