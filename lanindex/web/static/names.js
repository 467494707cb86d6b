/** The names of parts and directions as a person says them, which the server knows. */

/** @type {Map<string, string>} */
let spoken = new Map();

/**
 * Take the names that the server knows.
 * @param {Record<string, string>} names
 */
export function takeNames(names) {
  spoken = new Map(Object.entries(names));
}

/**
 * Return names as a person says them: right arm bend, travel, left back high.
 * @param {string} names
 */
export function nameOf(names) {
  return names.split(" ").map((it) => spoken.get(it) ?? it.replaceAll("_", " ")).join(" ");
}
