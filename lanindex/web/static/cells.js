/** The 27 cells that space is divided into around a joint, and their colours. */

/**
 * The borders of a part's cells, as a profile has them: `place` is a radius in mm, or in lengths of
 * the part; `starts` are the azimuths at which the directions begin, by code; `mid` and `high` the
 * elevations at which those levels begin. Degrees.
 * @typedef {{place: number, relative: boolean, starts: number[], mid: number, high: number}} Space
 */

export const DIRECTIONS = ["right", "r_forward", "forward", "l_forward", "left", "l_back", "back", "r_back", "place"];
export const LEVELS = ["low", "mid", "high"];
export const PLACE = 8;

/** By code: right and left are those of the palette, the others lie between them. */
const HUES = [207, 172, 128, 50, 352, 318, 276, 238];
const LIGHT = [38, 56, 76]; // per cent, by level: the lower, the darker, as signs are

const DEGREES = 180 / Math.PI;

/**
 * Return the name of a cell.
 * @param {number} cell direction · 3 + level
 */
export function nameOf(cell) {
  return `${DIRECTIONS[Math.floor(cell / 3)]} ${LEVELS[cell % 3]}`;
}

/**
 * Return a direction as angles: azimuth from the right over forward, elevation from straight down.
 * @param {number} right
 * @param {number} up
 * @param {number} forward
 */
export function anglesOf(right, up, forward) {
  const away = Math.hypot(right, forward), azimuth = Math.atan2(forward, right) * DEGREES;
  return { away, azimuth: azimuth < 0 ? azimuth + 360 : azimuth, elevation: away || up ? Math.atan2(away, -up) * DEGREES : 90 };
}

/**
 * Return the radius of place in lengths of a part.
 * @param {Space} space
 * @param {number} length of the part, mm
 */
export function radiusOf(space, length) {
  return space.relative ? space.place : space.place / length;
}

/**
 * Return the cell of a point in lengths of its part.
 * @param {Space} space
 * @param {number} radius of place, in lengths
 * @param {number} right
 * @param {number} up
 * @param {number} forward
 */
export function cellOf(space, radius, right, up, forward) {
  const { away, azimuth, elevation } = anglesOf(right, up, forward);
  const level = elevation < space.mid ? 0 : elevation < space.high ? 1 : 2;
  return 3 * (away <= radius ? PLACE : sectorOf(space.starts, azimuth)) + level;
}

/**
 * Return the direction in whose sector an azimuth lies.
 * @param {number[]} starts
 * @param {number} azimuth
 */
export function sectorOf(starts, azimuth) {
  let nearest = 0, least = 360;
  for (let code = 0; code < PLACE; code++) {
    const behind = (azimuth - starts[code] + 720) % 360;
    if (behind < least) [nearest, least] = [code, behind];
  }
  return nearest;
}

/**
 * Return the colour of a cell: red, green and blue, 0 to 255.
 * @param {number} cell
 * @returns {[number, number, number]}
 */
export function colorOf(cell) {
  const code = Math.floor(cell / 3), light = LIGHT[cell % 3] / 100, full = code === PLACE ? 0 : 0.62;
  const chroma = full * Math.min(light, 1 - light), hue = HUES[code] ?? 0;
  const part = (/** @type {number} */ at) => {
    const k = (at + hue / 30) % 12;
    return Math.round(255 * (light - chroma * Math.max(-1, Math.min(k - 3, 9 - k, 1))));
  };
  return [part(0), part(8), part(4)];
}

/**
 * Return borders with left and right exchanged.
 * @param {Space} space
 * @returns {Space}
 */
export function mirrored(space) {
  const starts = space.starts.map((_, code) => (180 - space.starts[(13 - code) % PLACE] + 720) % 360);
  return { ...space, starts };
}
