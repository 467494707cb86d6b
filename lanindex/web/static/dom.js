// Nodes of the page. Nothing is made from text but staves, which are parsed as XML.

/** @typedef {Node | string | number | null | undefined | false} Child */
/** @typedef {Record<string, string | number | boolean | null | undefined | ((event: any) => void)>} Attributes */

/**
 * Make an element. Functions named `onclick` and so on listen; true is an empty attribute; what is
 * false, null or undefined is left out.
 * @template {keyof HTMLElementTagNameMap} T
 * @param {T} tag
 * @param {Attributes} [attributes]
 * @param {...Child} children
 * @returns {HTMLElementTagNameMap[T]}
 */
export function el(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (typeof value === "function") node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? "" : String(value));
  }
  node.append(...children.filter(given).map((it) => (typeof it === "number" ? String(it) : it)));
  return node;
}

/** @param {Child} child @returns {child is Node | string | number} */
function given(child) {
  return child !== null && child !== undefined && child !== false;
}

const NAMESPACE = "http://www.w3.org/2000/svg";

/**
 * Make an element of SVG.
 * @template {keyof SVGElementTagNameMap} T
 * @param {T} tag
 * @param {Record<string, string | number>} [attributes]
 * @param {...(Node | string)} children
 * @returns {SVGElementTagNameMap[T]}
 */
export function shape(tag, attributes = {}, ...children) {
  const node = document.createElementNS(NAMESPACE, tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, String(value));
  node.append(...children);
  return node;
}

/** @type {{createHTML(text: string): any}} */
const policy = /** @type {any} */ (window).trustedTypes?.createPolicy("svg", { createHTML: (/** @type {string} */ text) => text })
  ?? { createHTML: (text) => text };

/**
 * Return the SVG that the server drew. It is parsed as XML, in which no script runs.
 * @param {string} text
 * @returns {SVGSVGElement}
 */
export function svg(text) {
  const parsed = new DOMParser().parseFromString(policy.createHTML(text), "image/svg+xml");
  return document.adoptNode(/** @type {SVGSVGElement} */ (/** @type {unknown} */ (parsed.documentElement)));
}

/**
 * Return the element with an id, which is there.
 * @param {string} id
 * @returns {HTMLElement}
 */
export function byId(id) {
  const node = document.getElementById(id);
  if (!node) throw new Error(`no element ${id}`);
  return node;
}

/**
 * Tell what happened, also to who cannot see it. What can be done about something stays while other
 * things are told, until the next that something can be done about.
 * @param {string} text
 * @param {...HTMLElement} actions what can be done about it meanwhile
 * @returns {HTMLElement} what is shown, for a while
 */
export function announce(text, ...actions) {
  const kind = actions.length ? "offer" : "told";
  const line = el("p", { class: kind }, text, ...actions);
  for (const it of byId("status").querySelectorAll(`.${kind}`)) it.remove();
  if (text) byId("status").append(line);
  setTimeout(() => line.remove(), actions.length ? 12000 : 6000);
  return line;
}

/**
 * Have a screen reader read out what the page shows now.
 * @param {string} text
 */
export function readOut(text) {
  byId("said").textContent = text;
}

/**
 * Return the sentence of an error: where, what was found, what was wanted, what to do.
 * @param {import("./api.js").Problem} problem
 * @returns {HTMLElement}
 */
export function trouble(problem) {
  const { place, found, wanted, remedy } = problem;
  return el("div", { class: "trouble", role: "alert" },
    el("p", {}, place ? `${place}: ` : "", found, wanted ? `, wanted ${wanted}` : "", "."),
    remedy && el("p", {}, remedy),
    ...HERE.filter(([words]) => remedy?.includes(words)).map(([, href, text]) => el("p", {}, "Or here: ", el("a", { href }, text))));
}

/** What the page does as the terminal would: words of a remedy, an address, what it is called. */
const HERE = [
  ["lanindex list", "/", "all captures"],
  ["lanindex remove --missing", "/?missing=yes", "remove missing captures"],
];

/**
 * Return seconds as people write them: 3.25 s, 2:05 min, 1:02:03 h.
 * @param {number} seconds
 * @param {number} [digits]
 */
export function duration(seconds, digits = 2) {
  if (seconds < 60) return `${seconds.toFixed(digits)} s`;
  const whole = Math.round(seconds), two = (/** @type {number} */ it) => String(it).padStart(2, "0");
  const minutes = Math.floor(whole / 60) % 60, hours = Math.floor(whole / 3600);
  return hours ? `${hours}:${two(minutes)}:${two(whole % 60)} h` : `${minutes}:${two(whole % 60)} min`;
}

/**
 * Return a count with its noun: 1 hit, 2,000 hits.
 * @param {number} number
 * @param {string} noun
 */
export function counted(number, noun) {
  return `${number.toLocaleString("en")} ${noun}${number === 1 ? "" : "s"}`;
}
