/** What a figure is made of, and its colours: the same in space and drawn flat. */

/**
 * A line of the body with round ends, from a share of the way between two joints to the second; its
 * width is in mm, its part that of its bone; it shows tracks, such as both bones that of an arm.
 * @typedef {{from: number, to: number, share: number, width: number, color: string, part: string, shows: string[]}} Stroke
 *
 * @typedef {{pose: Float32Array, faint: number}} Ghost
 *
 * A body as it is shown; `pose` has x, y and z of each joint, mm, NaN where unknown; `lit` are the
 * tracks that matched; `way` is x and z on the floor, the oldest first.
 * @typedef {object} Body
 * @property {Stroke[]} strokes
 * @property {Float32Array} pose
 * @property {Ghost[]} [ghosts]
 * @property {ReadonlySet<string>} [lit]
 * @property {Float32Array} [way]
 *
 * A part of the canvas, CSS pixels, and what it shows: `span` millimetres from bottom to top around
 * a place, seen from `turn` about the vertical and `tilt` above the horizon, degrees.
 * @typedef {object} View
 * @property {number} left
 * @property {number} top
 * @property {number} width
 * @property {number} height
 * @property {number} turn
 * @property {number} tilt
 * @property {[number, number, number]} target
 * @property {number} span
 * @property {boolean} plan whether it is the floor from above, without perspective
 *
 * @typedef {[number, number, number]} Color red, green and blue, 0 to 1
 * @typedef {Record<string, Color>} Palette
 * @typedef {{bodies: Body[], floor: number | null, palette: Palette}} Picture
 *
 * @typedef {object} Drawer
 * @property {(width: number, height: number, ratio: number) => void} resize
 * @property {(views: View[], picture: Picture) => void} draw
 * @property {() => void} dispose
 */

/** The colours, in variables of the page's style, and what stands for them where it has none. */
export const COLORS = {
  right: "var(--right, #1f77c8)",
  left: "var(--left, #d02f45)",
  head: "var(--head, #9a9a9a)",
  lit: "var(--lit, #f5a300)",
  bone: "var(--ink, CanvasText)",
  floor: "var(--edge, #dedede)",
  way: "var(--way, #aaaaaa)",
  paper: "var(--paper, Canvas)",
};

export const BAND = 60; // mm that what is lit is wider
const SQUARE = 500; // mm from one line of the floor to the next
export const REACH = 4000; // mm to each side in which the floor is drawn

/**
 * Return whether a stroke shows any of the tracks that are lit.
 * @param {Stroke} stroke
 * @param {ReadonlySet<string> | undefined} lit
 */
export function isLit({ shows }, lit) {
  return lit ? shows.some((track) => lit.has(track)) : false;
}

/**
 * Return a colour between two.
 * @param {Color} from
 * @param {Color} to
 * @param {number} share
 * @returns {Color}
 */
export function between(from, to, share) {
  const [red, green, blue] = from.map((part, at) => part + share * (to[at] - part));
  return [red, green, blue];
}

/**
 * Return a place between two joints, a share of the way from the first.
 * @param {Float32Array} pose
 * @param {number} from
 * @param {number} to
 * @param {number} share
 * @returns {[number, number, number]}
 */
export function along(pose, from, to, share) {
  const a = 3 * from, b = 3 * to;
  return [
    pose[a] + share * (pose[b] - pose[a]),
    pose[a + 1] + share * (pose[b + 1] - pose[a + 1]),
    pose[a + 2] + share * (pose[b + 2] - pose[a + 2]),
  ];
}

/**
 * Return how far the lines of the floor are apart, mm, where so much of it is shown.
 * @param {number} span
 */
export function squares(span) {
  return SQUARE * 2 ** Math.max(Math.ceil(Math.log2(span / 10 / SQUARE)), 0);
}
