/** The figure drawn flat, as in films, where WebGL is missing. */

import { BAND, REACH, along, between, isLit, squares } from "./look.js";

/**
 * @typedef {import("./look.js").View} View
 * @typedef {import("./look.js").Picture} Picture
 * @typedef {import("./look.js").Body} Body
 * @typedef {import("./look.js").Color} Color
 * @typedef {[number, number]} Point
 * @typedef {[Point, Point, number, Color]} Line with round ends: its width is in mm
 */

const SPOT = 45; // mm, the radius of the spot below the pelvis
const WAY = 30; // mm, the width of the way

export class CanvasDrawer {
  #pen;
  #ratio = 1;

  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    const pen = canvas.getContext("2d", { alpha: false });
    if (!pen) throw new Error("this browser draws on no canvas");
    this.#pen = pen;
  }

  /**
   * @param {number} width
   * @param {number} height
   * @param {number} ratio
   */
  resize(width, height, ratio) {
    this.#ratio = ratio;
    this.#pen.canvas.width = Math.round(width * ratio);
    this.#pen.canvas.height = Math.round(height * ratio);
  }

  /**
   * @param {View[]} views
   * @param {Picture} picture
   */
  draw(views, picture) {
    const pen = this.#pen;
    pen.setTransform(this.#ratio, 0, 0, this.#ratio, 0, 0);
    pen.lineCap = pen.lineJoin = "round";
    for (const view of views) {
      pen.save();
      pen.beginPath();
      pen.rect(view.left, view.top, view.width, view.height);
      pen.clip();
      pen.fillStyle = css(picture.palette.paper);
      pen.fillRect(view.left, view.top, view.width, view.height);
      this.#scene(view, picture);
      if (view.plan) {
        pen.strokeStyle = css(picture.palette.floor);
        pen.lineWidth = 2;
        pen.strokeRect(view.left, view.top, view.width, view.height);
      }
      pen.restore();
    }
  }

  dispose() {}

  /**
   * @param {View} view
   * @param {Picture} picture
   */
  #scene(view, { bodies, floor, palette }) {
    const seen = projection(view), scale = view.height / view.span;
    if (floor !== null) {
      this.#floor(view, seen, floor, palette.floor);
      for (const body of bodies) this.#way(body, seen, floor, palette.way, scale, view.tilt);
    }
    for (const { strokes, ghosts = [] } of bodies) {
      for (const { pose, faint } of view.plan ? [] : ghosts) {
        const lines = linesOf({ strokes, pose }, seen, palette);
        this.#lines(lines.map(([a, b, width, color]) => [a, b, width, between(color, palette.paper, faint)]), scale);
      }
    }
    for (const body of bodies) this.#lines(linesOf(body, seen, palette), scale);
  }

  /**
   * @param {View} view
   * @param {(x: number, y: number, z: number) => [...Point, number]} seen
   * @param {number} floor
   * @param {Color} color
   */
  #floor(view, seen, floor, color) {
    const pen = this.#pen, wide = squares(view.plan ? view.span : 0);
    const reach = view.plan ? 6 * wide : REACH;
    const [left, near] = [view.target[0], view.target[2]].map((at) => Math.round(at / wide) * wide);
    pen.strokeStyle = css(color);
    pen.lineWidth = 1;
    pen.beginPath();
    for (let at = -reach; at <= reach; at += wide) {
      for (const [a, b] of [[[left + at, near - reach], [left + at, near + reach]], [[left - reach, near + at], [left + reach, near + at]]]) {
        const [x, y] = seen(a[0], floor, a[1]), [toX, toY] = seen(b[0], floor, b[1]);
        pen.moveTo(x, y);
        pen.lineTo(toX, toY);
      }
    }
    pen.stroke();
  }

  /**
   * @param {Body} body
   * @param {(x: number, y: number, z: number) => [...Point, number]} seen
   * @param {number} floor
   * @param {Color} color
   * @param {number} scale
   * @param {number} tilt
   */
  #way({ way, pose }, seen, floor, color, scale, tilt) {
    const pen = this.#pen;
    pen.strokeStyle = pen.fillStyle = css(color);
    pen.lineWidth = Math.max(WAY * scale, 1.5);
    pen.beginPath();
    let drawing = false;
    for (let at = 0; way && at < way.length; at += 2) {
      const [x, y] = seen(way[at], floor, way[at + 1]);
      if (x !== x) drawing = false;
      else if (drawing) pen.lineTo(x, y);
      else {
        pen.moveTo(x, y);
        drawing = true;
      }
    }
    pen.stroke();
    const [x, y] = seen(pose[0], floor, pose[2]), r = SPOT * scale;
    if (x !== x) return;
    pen.beginPath();
    pen.ellipse(x, y, r, r * Math.max(Math.abs(Math.sin(tilt * Math.PI / 180)), 0.3), 0, 0, 2 * Math.PI);
    pen.fill();
  }

  /**
   * @param {Line[]} lines
   * @param {number} scale
   */
  #lines(lines, scale) {
    const pen = this.#pen;
    for (const [a, b, width, color] of lines) {
      pen.strokeStyle = css(color);
      pen.lineWidth = Math.max(width * scale, 1.5);
      pen.beginPath();
      pen.moveTo(...a);
      pen.lineTo(b[0] + 0.01, b[1]); // a line of no length would have no ends
      pen.stroke();
    }
  }
}

/**
 * Return what tells of a place where it is on the canvas, and how near, without perspective.
 * @param {View} view
 * @returns {(x: number, y: number, z: number) => [...Point, number]}
 */
function projection({ left, top, width, height, turn, tilt, target, span }) {
  const [about, over] = [turn, tilt].map((it) => it * Math.PI / 180), scale = height / span;
  const [sin, cos, low, up] = [Math.sin(about), Math.cos(about), Math.sin(over), Math.cos(over)];
  return (x, y, z) => {
    const right = cos * (x - target[0]) - sin * (z - target[2]), toward = sin * (x - target[0]) + cos * (z - target[2]);
    const high = y - target[1];
    return [
      left + width / 2 + scale * right,
      top + height / 2 - scale * (up * high - low * toward),
      up * toward + low * high,
    ];
  };
}

/**
 * Return the strokes of a body, the farthest first, below all of them what is lit.
 * @param {Body} body
 * @param {(x: number, y: number, z: number) => [...Point, number]} seen
 * @param {Picture["palette"]} palette
 * @returns {Line[]}
 */
function linesOf({ strokes, pose, lit }, seen, palette) {
  /** @type {{near: number, line: Line}[]} */
  const found = [];
  for (const stroke of strokes) {
    const { from, to, share, width, color } = stroke;
    const start = seen(...along(pose, from, to, share)), end = seen(...along(pose, from, to, 1));
    const near = start[2] + end[2] + (share === 1 ? width / 2 : 0); // a ball hides its neck
    if (near !== near) continue;
    /** @type {[Point, Point]} */
    const ends = [[start[0], start[1]], [end[0], end[1]]];
    if (isLit(stroke, lit)) found.push({ near: -Infinity, line: [...ends, width + BAND, palette.lit] });
    found.push({ near, line: [...ends, width, palette[color] ?? palette.bone] });
  }
  return found.sort((one, other) => one.near - other.near || 0).map(({ line }) => line);
}

/** @param {Color} color */
function css(color) {
  return `rgb(${color.map((part) => Math.round(255 * part)).join(" ")})`;
}
