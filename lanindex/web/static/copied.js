/** A search as others can use it: a command, a line of Python, or a link. */

import { announce, el } from "./dom.js";

/** @typedef {{q: string, like: string, in: string, where: string[], near: boolean, fuzzy: string}} Asked */

/** @param {string} text as a shell takes it */
function quoted(text) {
  return `'${text.replaceAll("'", "'\\''")}'`;
}

/**
 * @param {Asked} asked
 * @param {string} library the library's file
 */
function command({ q, like, in: path, where, near, fuzzy }, library) {
  return ["lanindex search", ...(like ? ["--like", like] : [quoted(q)]), ...(path ? ["--in", quoted(path)] : []), ...where.flatMap((it) => ["--where", quoted(it)]),
    ...(near && !like ? ["--near"] : []), ...(fuzzy && !like ? ["--fuzzy", fuzzy] : []), "--db", quoted(library)].join(" ");
}

/**
 * @param {Asked} asked
 * @param {string} library the library's file
 */
function python({ q, like, in: path, where, near, fuzzy }, library) {
  const text = JSON.stringify, pairs = where.map((it) => {
    const [name] = it.split("=", 1);
    return `(${text(name)}, ${text(it.slice(name.length + 1))})`;
  });
  const chosen = [...(path ? [text(path)] : []), ...(pairs.length ? [`where=[${pairs.join(", ")}]`] : [])];
  const given = [text(like || q), ...(chosen.length ? [`lanindex.Selection(${chosen.join(", ")})`] : []), ...(near && !like ? ["near=True"] : []), ...(fuzzy && !like ? [`fuzzy=${text(fuzzy)}`] : [])];
  return `import lanindex\n\nwith lanindex.open_library(${text(library)}) as library:\n    hits = library.${like ? "like" : "search"}(${given.join(", ")})${like ? ".hits" : ""}\n`;
}

/**
 * Return buttons that copy a search.
 * @param {() => Asked} asked
 * @param {string} library its file
 */
export function copies(asked, library) {
  /** @type {[string, () => string][]} */
  const forms = [["command", () => command(asked(), library)], ["Python", () => python(asked(), library)], ["link", () => location.href]];
  return el("span", { class: "row", role: "group", "aria-label": "Copy as" }, el("span", { class: "soft" }, "Copy as"), ...forms.map(([name, text]) =>
    el("button", { type: "button", class: "plain", onclick: () => navigator.clipboard.writeText(text()).then(() => announce(`the ${name} is copied`), () => announce("this browser lets nothing be copied")) }, name)));
}
