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
 * Return a name as a person says it: right arm bend, travel, left back.
 * @param {string} name
 */
export function nameOf(name) {
  return spoken.get(name) ?? name.replaceAll("_", " ");
}
