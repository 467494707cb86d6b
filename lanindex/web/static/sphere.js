/** The sphere of a part's cells: its borders, which are drawn aside, and the way of the limb. */

import { anglesOf, cellOf, colorOf, nameOf as wordsOf, PLACE, radiusOf, sectorOf } from "./cells.js";
import { nameOf } from "./names.js";

/**
 * @typedef {import("./cells.js").Space} Space
 * @typedef {{length: number, times: number[], points: number[][]}} Way points in lengths: right, up, forward
 *
 * A border that can be moved: that of a level, of place, or the start of a direction.
 * @typedef {"mid" | "high" | "place" | number} Border
 *
 * @typedef {object} Handlers
 * @property {(border: Border, value: number, done: boolean) => void} move degrees, or lengths of place
 */

const DEGREES = Math.PI / 180;
const MARGIN = 26; // pixels around the sphere, for its names
const FINE = 110; // points of the coloured half, from its middle to its edge
const SHADES = 12; // of the way, from its oldest piece to its latest
const NEAR = 4; // degrees from a border at which it is taken
const STEP = 4; // degrees from one point of a border to the next
const TURN = 10; // degrees of an arrow key
const KEYS = "Arrow keys turn it, 0 sets it back, a border is drawn aside with the mouse; its number stands in a field beside it.";
const AXES = /** @type {const} */ ([["right", 1, 0, 0], ["left", -1, 0, 0], ["high", 0, 1, 0], ["low", 0, -1, 0], ["forward", 0, 0, 1], ["back", 0, 0, -1]]);

export class SphereView {
  /** @type {Space} */
  #space = { place: 0.38, relative: true, starts: [337.5, 22.5, 67.5, 112.5, 157.5, 202.5, 247.5, 292.5], mid: 67.5, high: 112.5 };
  /** @type {Way} */
  #way = { length: 500, times: [], points: [] };
  #time = 0;
  #turn = 25;
  #tilt = 18;
  #frame = 0;
  /** @type {Border | null} */
  #marked = null;
  /** From where it is seen, and how large: worked out once a picture. */
  #view = { aside: [1, 0, 0], above: [0, 1, 0], near: [0, 0, 1], radius: 10, x: 0, y: 0 };
  /** @type {{ink: string, paper: string, lit: string} | null} */
  #colors = null;
  #fill = document.createElement("canvas");
  #filled = "";
  #gone = new AbortController();

  /** Seconds of the way that are shown, around the present. */
  trail = 3;
  /** Whether the sphere is as large as the limb reaches now; else as it is long. */
  reaching = true;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Handlers} handlers
   */
  constructor(canvas, handlers) {
    this.canvas = canvas;
    this.handlers = handlers;
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "application");
    canvas.setAttribute("aria-label", `The sphere of cells. ${KEYS}`);
    this.#fill.width = this.#fill.height = 2 * FINE;
    this.#listen();
  }

  /** @param {Space} space */
  set space(space) {
    this.#space = space;
    this.later();
  }

  /** @param {Way} way */
  set way(way) {
    this.#way = way;
    this.later();
  }

  /** The border that is marked. @param {Border | null} border */
  set marked(border) {
    this.#marked = border;
    this.later();
  }

  /** Where the eye is: degrees from the front to the body's right, and above the horizon. */
  get eye() {
    return { turn: this.#turn, tilt: this.#tilt };
  }

  /**
   * Show where the limb is at some seconds, at once.
   * @param {number} seconds
   */
  show(seconds) {
    this.#time = seconds;
    this.#draw();
  }

  later() {
    this.#frame ||= requestAnimationFrame(() => this.#draw());
  }

  dispose() {
    this.#gone.abort();
    cancelAnimationFrame(this.#frame);
  }

  /** Where the limb is now, in its lengths; null where it is not known. */
  get point() {
    const { times, points } = this.#way, at = this.#index(this.#time);
    return at < times.length && Math.abs(times[at] - this.#time) < 0.1 ? points[at] : null;
  }

  /** What is said of where the limb is now. */
  get words() {
    const point = this.point;
    if (!point) return "The part is not known here.";
    const { azimuth, elevation } = anglesOf(point[0], point[1], point[2]);
    return `${nameOf(wordsOf(this.#cell(point)))}: azimuth ${azimuth.toFixed(0)}\u00b0, elevation ${elevation.toFixed(0)}\u00b0, reach ${Math.hypot(...point).toFixed(2)} L`;
  }

  /** @param {number} right @param {number} up */
  turn(right, up) {
    this.#turn = (this.#turn + right + 540) % 360 - 180;
    this.#tilt = Math.min(Math.max(this.#tilt + up, -90), 90);
    this.later();
  }

  /** @param {number[]} point */
  #cell(point) {
    return cellOf(this.#space, radiusOf(this.#space, this.#way.length), point[0], point[1], point[2]);
  }

  /** @param {number} seconds */
  #index(seconds) {
    const { times } = this.#way;
    let low = 0, high = times.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (times[middle] <= seconds + 1e-6) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  #listen() {
    const { canvas } = this, { signal } = this.#gone;
    const sizes = new ResizeObserver(() => this.later());
    sizes.observe(canvas);
    signal.addEventListener("abort", () => sizes.disconnect());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.#colors = null;
      this.later();
    }, { signal });
    canvas.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey) return;
      const aside = { ArrowLeft: -TURN, ArrowRight: TURN }[event.key] ?? 0, up = { ArrowUp: -TURN, ArrowDown: TURN }[event.key] ?? 0;
      if (event.key === "0") [this.#turn, this.#tilt] = [25, 18];
      else if (!aside && !up) return;
      this.turn(aside, up);
      event.preventDefault();
      event.stopPropagation();
    }, { signal });
    /** @type {{x: number, y: number, border: Border | null} | null} */
    let held = null;
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      held = { x: event.clientX, y: event.clientY, border: this.#borderAt(event) };
      canvas.setPointerCapture(event.pointerId);
    }, { signal });
    canvas.addEventListener("pointermove", (event) => {
      if (!held) {
        const border = this.#borderAt(event), point = this.#pointAt(event);
        canvas.style.cursor = border === null ? "grab" : "move";
        canvas.title = point ? nameOf(wordsOf(this.#cell(point))) : "";
        this.marked = border;
      } else if (held.border !== null) {
        this.#moved(held.border, event, false);
      } else {
        this.turn((event.clientX - held.x) / 2, (event.clientY - held.y) / 2);
        [held.x, held.y] = [event.clientX, event.clientY];
      }
    }, { signal });
    for (const name of /** @type {const} */ (["pointerup", "pointercancel"])) {
      canvas.addEventListener(name, (event) => {
        if (held && held.border !== null) this.#moved(held.border, event, true);
        held = null;
      }, { signal });
    }
    canvas.addEventListener("pointerleave", () => { this.marked = null; }, { signal });
  }

  /** @param {Border} border @param {PointerEvent} event @param {boolean} done */
  #moved(border, event, done) {
    const point = this.#pointAt(event);
    if (!point) return;
    const { azimuth, elevation, away } = anglesOf(point[0], point[1], point[2]);
    this.handlers.move(border, border === "place" ? away : typeof border === "number" ? azimuth : elevation, done);
  }

  /** How far the sphere reaches, in lengths. */
  get #reach() {
    const point = this.point;
    return this.reaching && point ? Math.max(Math.hypot(...point), 0.02) : 1;
  }

  /** Work out the directions of the screen, each right, up, forward; its middle, and the radius. */
  #look() {
    const turn = this.#turn * DEGREES, tilt = this.#tilt * DEGREES, { clientWidth, clientHeight } = this.canvas;
    const [sine, cosine, rise, flat] = [Math.sin(turn), Math.cos(turn), Math.sin(tilt), Math.cos(tilt)];
    this.#view = {
      aside: [-cosine, 0, sine],
      above: [-sine * rise, flat, -cosine * rise],
      near: [sine * flat, rise, cosine * flat],
      radius: Math.max(Math.min(clientWidth, clientHeight) / 2 - MARGIN, 10),
      x: clientWidth / 2,
      y: clientHeight / 2,
    };
  }

  /**
   * Return the point of the sphere below the pointer, in lengths; null beside it.
   * @param {PointerEvent} event
   */
  #pointAt(event) {
    const box = this.canvas.getBoundingClientRect(), { radius, x, y, aside, above, near } = this.#view;
    const a = (event.clientX - box.left - x) / radius, b = (y - event.clientY + box.top) / radius, flat = a * a + b * b;
    if (flat > 1) return null;
    const depth = Math.sqrt(1 - flat), reach = this.#reach;
    return aside.map((it, axis) => reach * (a * it + b * above[axis] + depth * near[axis]));
  }

  /**
   * Return the border below the pointer.
   * @param {PointerEvent} event
   * @returns {Border | null}
   */
  #borderAt(event) {
    const point = this.#pointAt(event);
    if (!point) return null;
    const { azimuth, elevation, away } = anglesOf(point[0], point[1], point[2]);
    const { mid, high, starts } = this.#space, cap = this.#cap(), slope = away / this.#reach;
    /** @type {[Border, number][]} */
    const borders = [["mid", Math.abs(elevation - mid)], ["high", Math.abs(elevation - high)]];
    borders.push(["place", Math.min(Math.abs(elevation - cap), Math.abs(180 - elevation - cap))]);
    if (elevation > cap && elevation < 180 - cap) {
      starts.forEach((start, code) => borders.push([code, Math.abs((azimuth - start + 540) % 360 - 180) * slope]));
    }
    const [border, off] = borders.reduce((a, b) => (b[1] < a[1] ? b : a));
    return off <= NEAR ? border : null;
  }

  /** Degrees from a pole at which place ends; 90 where all of the sphere is within it. */
  #cap() {
    const share = radiusOf(this.#space, this.#way.length) / this.#reach;
    return share < 1 ? Math.asin(share) / DEGREES : 90;
  }

  #draw() {
    cancelAnimationFrame(this.#frame);
    this.#frame = 0;
    const { canvas } = this, { clientWidth, clientHeight } = canvas, ratio = Math.min(window.devicePixelRatio || 1, 2);
    const context = canvas.getContext("2d");
    if (!context || !clientWidth || !clientHeight) return;
    if (canvas.width !== Math.round(clientWidth * ratio) || canvas.height !== Math.round(clientHeight * ratio)) {
      [canvas.width, canvas.height] = [Math.round(clientWidth * ratio), Math.round(clientHeight * ratio)];
    }
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, clientWidth, clientHeight);
    this.#look();
    const { ink, paper, lit } = (this.#colors ??= this.#palette());
    this.#drawNames(context, ink, false);
    this.#drawWay(context, ink, paper, false);
    this.#drawFill();
    const { radius, x, y } = this.#view;
    context.globalAlpha = 0.8;
    context.drawImage(this.#fill, x - radius, y - radius, 2 * radius, 2 * radius);
    context.globalAlpha = 1;
    this.#drawBorders(context, ink, lit);
    this.#drawWay(context, ink, paper, true);
    this.#drawPoint(context, ink, lit);
    this.#drawNames(context, ink, true);
  }

  /** The colours of the page. */
  #palette() {
    const style = getComputedStyle(this.canvas), own = (/** @type {string} */ name, /** @type {string} */ other) => style.getPropertyValue(name).trim() || other;
    return { ink: style.color, paper: own("--paper", "#fff"), lit: own("--lit", "#f5a300") };
  }

  /** Colour the near half of the sphere, unless it is as it was. */
  #drawFill() {
    const reach = this.#reach, key = JSON.stringify([this.#space, this.#way.length, this.#turn, this.#tilt, reach.toFixed(2)]);
    if (key === this.#filled) return;
    this.#filled = key;
    const context = this.#fill.getContext("2d");
    if (!context) return;
    const image = context.createImageData(2 * FINE, 2 * FINE), { aside, above, near } = this.#view, { mid, high, starts } = this.#space;
    const share = radiusOf(this.#space, this.#way.length) / reach, within = share * share;
    const [belowMid, belowHigh] = [-Math.cos(mid * DEGREES), -Math.cos(high * DEGREES)];
    const colors = Array.from({ length: 27 }, (_, cell) => colorOf(cell));
    const sectors = Array.from({ length: 720 }, (_, half) => sectorOf(starts, half / 2 + 0.25));
    for (let row = 0, at = 0; row < 2 * FINE; row++) {
      const b = (FINE - row - 0.5) / FINE;
      for (let column = 0; column < 2 * FINE; column++, at += 4) {
        const a = (column + 0.5 - FINE) / FINE, flat = a * a + b * b;
        if (flat > 1) continue;
        const depth = Math.sqrt(1 - flat), up = b * above[1] + depth * near[1];
        const right = a * aside[0] + b * above[0] + depth * near[0];
        const forward = a * aside[2] + b * above[2] + depth * near[2];
        const level = up < belowMid ? 0 : up < belowHigh ? 1 : 2;
        const half = Math.floor(Math.atan2(forward, right) / DEGREES * 2 + 720) % 720;
        const color = colors[3 * (right * right + forward * forward <= within ? PLACE : sectors[half]) + level], shade = 0.82 + 0.18 * depth;
        image.data[at] = color[0] * shade;
        image.data[at + 1] = color[1] * shade;
        image.data[at + 2] = color[2] * shade;
        image.data[at + 3] = 255;
      }
    }
    context.putImageData(image, 0, 0);
  }

  /** @param {CanvasRenderingContext2D} context @param {string} ink @param {string} lit */
  #drawBorders(context, ink, lit) {
    const { mid, high, starts } = this.#space, cap = this.#cap();
    /** @type {[Border, number[][]][]} */
    const borders = [["mid", parallel(mid)], ["high", parallel(high)]];
    if (cap < 90) {
      borders.push(["place", parallel(cap)], ["place", parallel(180 - cap)]);
      starts.forEach((start, code) => borders.push([code, meridian(start, cap)]));
    }
    for (const [border, points] of borders) {
      const marked = border === this.#marked;
      context.lineWidth = marked ? 3.5 : 1.4;
      context.strokeStyle = marked ? lit : ink;
      for (const front of [false, true]) {
        context.globalAlpha = front ? 1 : 0.16;
        this.#line(context, points, front);
      }
    }
    const { radius, x, y } = this.#view;
    context.globalAlpha = 1;
    context.lineWidth = 1.4;
    context.strokeStyle = ink;
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.stroke();
  }

  /**
   * Draw those pieces of a line on the unit sphere that are on the near half, or on the far one.
   * @param {CanvasRenderingContext2D} context
   * @param {number[][]} points
   * @param {boolean} front
   */
  #line(context, points, front) {
    context.beginPath();
    let before = null;
    for (const point of points) {
      const { x, y, depth } = this.#seen(point);
      if (depth >= 0 === front) {
        if (before) context.lineTo(x, y);
        else context.moveTo(x, y);
        before = point;
      } else before = null;
    }
    context.stroke();
  }

  /**
   * Return where a point is seen, in pixels; it is given in radii of the sphere.
   * @param {number[]} point
   */
  #seen(point) {
    const { aside, above, near, radius, x, y } = this.#view;
    return { x: x + radius * dot(point, aside), y: y - radius * dot(point, above), depth: dot(point, near) };
  }

  /**
   * Return where the way is on the sphere, in its radii: as far as it is where the sphere is that of
   * the whole length, else drawn onto it.
   * @param {number[]} point
   */
  #onto(point) {
    const size = this.reaching ? Math.hypot(...point) : 1;
    return size ? point.map((it) => it / size) : point;
  }

  /** @param {CanvasRenderingContext2D} context @param {string} ink @param {string} paper @param {boolean} front */
  #drawWay(context, ink, paper, front) {
    const { times, points } = this.#way, first = this.#index(this.#time - this.trail), last = this.#index(this.#time + this.trail);
    const seen = points.slice(first, last + 1).map((it) => this.#seen(this.#onto(it)));
    context.lineCap = "round";
    for (let shade = 0; shade < SHADES; shade++) {
      const end = first + Math.floor((shade + 1) * (last - first) / SHADES);
      context.globalAlpha = (0.12 + 0.88 * shade / (SHADES - 1)) * (front ? 1 : 0.4);
      context.beginPath();
      for (let at = first + Math.floor(shade * (last - first) / SHADES); at < end; at++) {
        const from = seen[at - first], to = seen[at + 1 - first];
        if (times[at + 1] - times[at] > 0.2 || from.depth >= 0 !== front) continue;
        context.moveTo(from.x, from.y);
        context.lineTo(to.x, to.y);
      }
      for (const [wide, color] of /** @type {[number, string][]} */ ([[5.5, paper], [2.6, ink]])) {
        context.lineWidth = wide;
        context.strokeStyle = color;
        context.stroke();
      }
    }
    context.globalAlpha = 1;
  }

  /** @param {CanvasRenderingContext2D} context @param {string} ink @param {string} lit */
  #drawPoint(context, ink, lit) {
    const point = this.point;
    if (!point) return;
    const { x, y, depth } = this.#seen(this.#onto(point));
    context.beginPath();
    context.arc(x, y, 7, 0, 2 * Math.PI);
    context.globalAlpha = depth >= 0 ? 1 : 0.45;
    context.fillStyle = lit;
    context.fill();
    context.lineWidth = 2;
    context.strokeStyle = ink;
    context.stroke();
    context.globalAlpha = 1;
  }

  /** @param {CanvasRenderingContext2D} context @param {string} ink @param {boolean} front */
  #drawNames(context, ink, front) {
    context.font = "12px system-ui, sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillStyle = ink;
    for (const [name, ...point] of AXES) {
      const { x, y, depth } = this.#seen(point.map((it) => 1.12 * it));
      if (depth >= 0 !== front) continue;
      const { radius, x: across, y: down } = this.#view, away = Math.hypot(x - across, y - down), rim = radius + 12;
      if (!front && away < radius / 3) continue; // behind the middle
      const out = front ? 1 : Math.max(rim / away, 1); // one that is behind stands beside the sphere
      context.globalAlpha = front ? 1 : 0.55;
      context.fillText(name, across + out * (x - across), down + out * (y - down));
    }
    context.globalAlpha = 1;
  }
}

/** @param {number[]} one @param {number[]} other */
function dot(one, other) {
  return one[0] * other[0] + one[1] * other[1] + one[2] * other[2];
}

/** @param {number} elevation */
function parallel(elevation) {
  return Array.from({ length: 360 / STEP + 1 }, (_, at) => pointOf(at * STEP, elevation));
}

/** @param {number} azimuth @param {number} cap */
function meridian(azimuth, cap) {
  const count = Math.ceil((180 - 2 * cap) / STEP);
  return Array.from({ length: count + 1 }, (_, at) => pointOf(azimuth, cap + (180 - 2 * cap) * at / count));
}

/** @param {number} azimuth @param {number} elevation */
function pointOf(azimuth, elevation) {
  const away = Math.sin(elevation * DEGREES);
  return [away * Math.cos(azimuth * DEGREES), -Math.cos(elevation * DEGREES), away * Math.sin(azimuth * DEGREES)];
}
