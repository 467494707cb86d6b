// The screen of the library: its captures, by filter and facet; labels are changed in place.

import { address, get, isAbort, problemOf } from "../api.js";
import { counted, duration, el, trouble } from "../dom.js";

/** @typedef {import("../app.js").App} App */
/** @typedef {{capture: string, capture_id: number, label: string, format: string, fps: number, frames: number, seconds: number, metadata: Record<string, string>, warnings: string[]}} Capture */
/** @typedef {{captures: Capture[], total: number, all: number, seconds: number, doubtful: number, facets: Record<string, [string, number][]>}} Listing */

const PAGE = 60;
const SORTS = [["added", "in order"], ["path", "by path"], ["label", "by label"], ["-length", "longest first"], ["length", "shortest first"], ["-doubts", "most doubts first"]];

/** @param {App} app */
export async function show(app) {
  const { main, url, library, signal } = app;
  const state = new URLSearchParams(url.search);
  const filter = el("input", { type: "search", value: state.get("q") ?? "", placeholder: "Filter by path, label or column", "aria-label": "Filter captures", class: "grow" });
  const sort = el("select", { "aria-label": "Sort" }, ...SORTS.map(([value, name]) => el("option", { value, selected: value === (state.get("sort") ?? "added") }, name)));
  const summary = el("p", { class: "soft" });
  const facets = el("aside", { class: "facets", "aria-label": "Facets" });
  const list = el("ol", { class: "captures" });
  const more = el("button", { type: "button", hidden: true, onclick: () => load(list.children.length) }, "Show more");
  main.append(
    el("h1", {}, library.name),
    el("div", { class: "row" }, filter, sort),
    summary,
    el("div", { class: "columns" }, facets, el("div", {}, list, more)));

  let waiting = 0;
  filter.addEventListener("input", () => {
    clearTimeout(waiting);
    waiting = window.setTimeout(() => change("q", filter.value ? [filter.value] : []), 120);
  });
  sort.addEventListener("change", () => change("sort", sort.value === "added" ? [] : [sort.value]));

  /** @param {string} name @param {string[]} values */
  function change(name, values) {
    state.delete(name);
    for (const value of values) state.append(name, value);
    app.replace(address("/", Object.fromEntries([...new Set(state.keys())].map((key) => [key, state.getAll(key)]))));
    load(0);
  }

  /** @param {number} at */
  async function load(at) {
    const query = new URLSearchParams(state);
    query.set("at", String(at));
    query.set("n", String(PAGE));
    try {
      /** @type {Listing} */
      const found = await get(`/api/captures?${query}`, signal);
      summary.textContent = `${counted(found.total, "capture")}${found.total < found.all ? ` of ${found.all.toLocaleString("en")}` : ""}, ${duration(found.seconds)}`
        + (found.doubtful ? `, ${found.doubtful} with doubts` : "");
      if (!at) list.replaceChildren();
      list.append(...found.captures.map(card));
      more.hidden = list.children.length >= found.total;
      drawFacets(found);
    } catch (error) {
      if (!isAbort(error)) list.replaceChildren(trouble(problemOf(error)));
    }
  }

  /** @param {Listing} found */
  function drawFacets(found) {
    facets.replaceChildren(...Object.entries(found.facets).filter(([, values]) => values.length > 1 || (values[0] ?? [""])[0]).map(([name, values]) => {
      const chosen = state.getAll(name);
      return el("section", {}, el("h2", {}, name), el("ul", {}, ...values.slice(0, 15).map(([value, count]) =>
        el("li", {}, el("label", {}, el("input", { type: "checkbox", checked: chosen.includes(value), onchange: (/** @type {Event} */ event) => {
          const on = /** @type {HTMLInputElement} */ (event.target).checked;
          change(name, on ? [...chosen, value] : chosen.filter((it) => it !== value));
        } }), " ", value || el("i", {}, "none"), el("span", { class: "soft num" }, ` ${count}`))))));
    }));
  }

  /** @param {Capture} capture */
  function card(capture) {
    const label = el("span", { class: "label" }, capture.label || "no label");
    return el("li", { class: "card" },
      el("a", { href: `/captures/${capture.capture_id}`, class: "path" }, capture.capture),
      el("div", { class: "row" }, label, el("span", { class: "soft num" }, `${duration(capture.seconds)}, ${capture.fps} fps, ${capture.format}`)),
      capture.warnings.length > 0 && el("details", {}, el("summary", {}, counted(capture.warnings.length, "doubt")), ...capture.warnings.map((it) => el("p", {}, it))));
  }
  await load(0);
}
