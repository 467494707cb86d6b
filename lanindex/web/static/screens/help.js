// The screen of the help: the guide, the reference, the signs of a staff, the keys.

import { get } from "../api.js";
import { el, svg } from "../dom.js";
import { KEYS } from "../keys.js";

/** @typedef {import("../app.js").App} App */
/** @typedef {string | [keyof HTMLElementTagNameMap, Record<string, string>, ...any[]]} Tree a text, or a tag, its attributes and its children */

const OWN = [
  { name: "signs", about: "The signs of a staff" },
  { name: "keys", about: "The keys of all screens" },
];

/** @type {Record<string, string>} */
const SHORT = { lnd: "LND", json: "JSON" };

/** @param {App} app */
export async function show(app) {
  const { main, url, signal } = app, name = url.pathname.split("/")[2] || "page";
  /** @type {{topics: {name: string, about: string}[]}} */
  const { topics } = await get("/api/help", signal);
  const about = [...OWN, ...topics].find((it) => it.name === name)?.about ?? "";
  const page = el("article", { class: "guide" });
  main.append(el("div", { class: "aside" },
    el("nav", { "aria-label": "Help" }, el("ul", {}, ...[...topics.filter((it) => it.name === "page"), ...OWN, ...topics.filter((it) => it.name !== "page")].map((it) =>
      el("li", {}, el("a", { href: `/help/${it.name}`, "aria-current": it.name === name ? "page" : null }, plain(it.name), el("span", { class: "soft" }, it.about)))))),
    page));
  app.title(plain(name));
  if (name === "keys") page.append(...keys());
  else if (name === "signs") page.append(...await signs(signal));
  else page.append(.../** @type {{nodes: Tree[]}} */ (await get(`/api/help/${encodeURIComponent(name)}`, signal)).nodes.map(built));
  if (!page.querySelector("h1")) page.prepend(el("h1", {}, about));
  if (url.hash) document.getElementById(decodeURIComponent(url.hash.slice(1)))?.scrollIntoView();
}

/** @param {string} name */
function plain(name) {
  return SHORT[name] ?? name[0].toUpperCase() + name.slice(1).replaceAll("-", " ");
}

/**
 * Return the nodes of a tree that the server made.
 * @param {Tree} tree
 * @returns {Node | string}
 */
function built(tree) {
  if (typeof tree === "string") return tree;
  const [tag, attributes, ...children] = tree, wide = tag === "table" || tag === "pre";
  const away = attributes.href?.startsWith("http") ? { target: "_blank", rel: "noreferrer" } : {};
  const node = el(tag, { ...attributes, ...away }, ...children.map(built));
  if (tag === "img") return el("a", { href: attributes.src, target: "_blank" }, node); // a phone shows it too small
  return wide ? el("div", { class: "scrolled", tabindex: 0, role: "group", "aria-label": tag === "table" ? "Table" : "Code" }, node) : node;
}

/** @param {AbortSignal} signal */
async function signs(signal) {
  /** @type {{signs: {svg: string, means: string}[]}} */
  const found = await get("/api/help/signs", signal);
  return [
    el("p", {}, "Time goes upwards: what stands higher happens later. The taller a sign, the longer the movement takes. Left of the middle line is the left of the body."),
    el("ul", { class: "signs" }, ...found.signs.map((it) => {
      const drawn = svg(it.svg);
      drawn.setAttribute("aria-hidden", "true");
      return el("li", {}, drawn, el("span", {}, it.means));
    })),
  ];
}

function keys() {
  return KEYS.flatMap(([where, rows]) => [
    el("h2", {}, where),
    el("table", {}, el("tbody", {}, ...rows.map(([pressed, does]) => el("tr", {}, el("th", { scope: "row" }, el("kbd", {}, pressed)), el("td", {}, does))))),
  ]);
}
