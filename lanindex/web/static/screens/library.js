// The screen of the library: its captures by filter and facet, each with a pose.

import { get, isAbort, problemOf } from "../api.js";
import { announce, counted, duration, el, readOut, trouble } from "../dom.js";
import { Poses } from "../poses.js";
import { Adding } from "./library/adding.js";
import { Editing } from "./library/editing.js";
import { Facets } from "./library/facets.js";

/** @typedef {import("../app.js").App} App */
/** @typedef {{capture: string, capture_id: number, label: string, format: string, fps: number, frames: number, seconds: number, sha256: string, metadata: Record<string, string>, warnings: string[]}} Capture */
/** @typedef {{name: string, values: [string, number][], different: number}} Facet */
/** @typedef {{captures: Capture[], total: number, all: number, seconds: number, folder: string, facets: Facet[]}} Listing */

const PAGE = 60;
const FIRST = 30; // captures that a filter is answered with: more than a window shows, and few are drawn at once
const SORTS = [["added", "Oldest first"], ["-added", "Newest first"], ["path", "By path"], ["label", "By label"],
  ["-length", "Longest first"], ["length", "Shortest first"], ["-doubts", "Most doubts first"]];

/** @type {Adding | undefined} goes on while another screen is shown */
let only;

/** Return what adds captures, on whatever screen they are dropped. */
export function adding() {
  return only ??= new Adding();
}

/** @param {App} app */
export async function show(app) {
  const { main, library, signal } = app;
  const asked = new URLSearchParams(app.url.search);
  const poses = new Poses(signal);
  main.classList.add("library");

  const filter = el("input", { type: "search", value: asked.get("q") ?? "", placeholder: "Filter by path, label or column",
    "aria-label": "Filter captures", class: "grow", oninput: () => change({ q: filter.value ? [filter.value] : [] }) });
  const sort = el("select", { "aria-label": "Order", onchange: () => change({ sort: sort.value === "added" ? [] : [sort.value] }) },
    ...SORTS.map(([value, name]) => el("option", { value, selected: value === (asked.get("sort") ?? "added") }, name)));
  /** @type {Set<number>} */
  const selected = new Set();
  const told = el("span", { class: "num", role: "status" }), every = el("button", { type: "button", onclick: () => selectAll() });
  const chosen = el("div", { class: "row chosen", hidden: true }, told,
    el("button", { type: "button", onclick: () => editing?.label([...selected]) }, "Label \u2026"),
    el("button", { type: "button", onclick: () => editing?.column([...selected]) }, "Column \u2026"),
    el("button", { type: "button", onclick: () => editing?.remove([...selected]) }, "Remove \u2026"),
    every,
    el("button", { type: "button", onclick: () => select([], false) }, "Clear"));
  const facets = new Facets((where) => change({ where }));
  const summary = el("p", { class: "soft num" });
  const earlier = el("button", { type: "button", hidden: true, onclick: () => extend(-1) }, "Show earlier ones");
  const more = el("button", { type: "button", hidden: true, onclick: () => extend(1) }, "Show more");
  const list = el("ol", { class: "shelf" });
  const labels = el("datalist", { id: "labels" }), columns = el("datalist", { id: "columns" });
  const editing = library.readonly ? undefined : new Editing(signal, (shown, gone) => {
    app.refresh();
    if (gone) select(gone, false);
    if (!shown) load(true);
    else page(0, 0).then(tell, (error) => isAbort(error) || announce(problemOf(error).found));
  });
  const added = library.readonly ? undefined : adding();
  await added?.find();
  const add = added && el("button", { type: "button", class: "main", onclick: () => {
    if (added.root.hidden) added.open();
    else added.root.hidden = true;
  } }, "Add captures");
  if (added) {
    added.came = () => {
      app.refresh();
      if (!signal.aborted) load(true);
    };
  }
  main.append(
    el("header", { class: "row" }, el("h1", {}, library.name), el("div", { class: "grow" }, summary), add ?? ""),
    added?.root ?? "",
    el("div", { class: "row bar" }, facets.button, filter, sort, chosen), labels, columns,
    facets.chips,
    el("div", { class: "beside" }, facets.root, el("div", { class: "list" }, earlier, list, more)));

  let latest = -1; // the number of the capture that was selected last
  /**
   * Select captures, or no longer.
   * @param {number[]} numbers none: all
   * @param {boolean} on
   */
  function select(numbers, on) {
    if (!numbers.length && !on) selected.clear();
    for (const it of numbers) on ? selected.add(it) : selected.delete(it);
    for (const box of /** @type {NodeListOf<HTMLInputElement>} */ (list.querySelectorAll(".pick"))) box.checked = selected.has(Number(box.value));
    const some = selected.size, focused = chosen.contains(document.activeElement);
    chosen.hidden = !some;
    if (focused && !some) filter.focus();
    list.classList.toggle("picking", some > 0);
    told.textContent = `${some.toLocaleString("en")} selected`;
    every.hidden = total <= some;
    every.textContent = `Select all ${total.toLocaleString("en")}`;
  }

  async function selectAll() {
    try {
      select((await get(`/api/captures/numbers?${asked}`, signal)).captures, true);
    } catch (error) {
      if (!isAbort(error)) announce(problemOf(error).found);
    }
  }

  /** @param {MouseEvent} event @param {HTMLInputElement} box */
  function pick(event, box) {
    const boxes = /** @type {HTMLInputElement[]} */ ([...list.querySelectorAll(".pick")]).map((it) => Number(it.value));
    const own = Number(box.value), from = event.shiftKey ? boxes.indexOf(latest) : -1, to = boxes.indexOf(own);
    select(from < 0 ? [own] : boxes.slice(Math.min(from, to), Math.max(from, to) + 1), box.checked);
    latest = own;
  }

  let folder = "", first = 0, total = 0;
  let loading = new AbortController();
  signal.addEventListener("abort", () => loading.abort());

  /**
   * Ask for other captures, and tell the address of what is shown then.
   * @param {Record<string, string[]>} values
   */
  function change(values) {
    for (const [name, some] of Object.entries({ ...values, at: [] })) {
      asked.delete(name);
      for (const one of some) asked.append(name, one);
    }
    app.replace(asked.size ? `/?${asked}` : "/");
    load();
  }

  /**
   * Return a part of what is asked for.
   * @param {number} at
   * @param {number} n
   * @returns {Promise<Listing>}
   */
  function page(at, n) {
    const query = new URLSearchParams(asked);
    query.set("at", String(at));
    query.set("n", String(n));
    return get(`/api/captures?${query}`, loading.signal);
  }

  /** Show what the address asks for, from the capture on that it names; `quiet` where all is said. */
  async function load(quiet = false) {
    loading.abort();
    const own = (loading = new AbortController());
    const at = Number(asked.get("at")) || 0;
    const from = Math.max(0, Math.floor(at / PAGE) - 1) * PAGE;
    try {
      let found, calm; // what is being typed in a card is ended before the card is made anew
      do {
        calm = editing?.typed;
        await calm;
        if (own !== loading) return;
        found = await page(from, at ? 3 * PAGE : FIRST);
      } while (editing?.typed !== calm);
      ({ folder, total } = found);
      first = from;
      poses.clear();
      const focus = focused();
      list.replaceChildren(...found.captures.map(card));
      focus();
      const before = summary.textContent;
      tell(found);
      select([], true); // there may be more or fewer to select
      if (before && before !== summary.textContent && !quiet) readOut(summary.textContent ?? "");
      if (at) list.children[at - from]?.scrollIntoView();
      if (!total) list.append(nothing(found));
      main.classList.toggle("empty", !found.all);
      if (!found.all) await added?.open();
      ends();
    } catch (error) {
      if (!isAbort(error)) list.replaceChildren(el("li", { class: "whole" }, trouble(problemOf(error))));
    }
  }

  /** Return what puts the focus back to where it is in the list, once that is made anew. */
  function focused() {
    const parts = "a, input, button, summary", node = document.activeElement, own = node?.closest(".shelf > .shot");
    if (!node || !own || !list.contains(own)) return () => {};
    const link = own.querySelector("a")?.getAttribute("href"), at = [...own.querySelectorAll(parts)].indexOf(node);
    return () => {
      const again = list.querySelector(`a[href="${link}"]`)?.closest(".shot")?.querySelectorAll(parts)[at];
      (again instanceof HTMLElement ? again : filter).focus({ preventScroll: true });
    };
  }

  /** @param {Listing} found */
  function tell(found) {
    const some = found.total < found.all ? `${found.total.toLocaleString("en")} of ` : "";
    const text = `${some}${counted(found.all, "capture")}, ${duration(found.seconds)}`;
    summary.replaceChildren(text);
    if (found.folder && found.folder !== "/") summary.append(", all in ", el("span", { class: "path" }, found.folder));
    facets.show(found.facets, asked.getAll("where"));
    const named = found.facets.find((it) => it.name === "label")?.values ?? [];
    labels.replaceChildren(...named.filter(([it]) => it).map(([value]) => el("option", { value })));
    const own = found.facets.map((it) => it.name).filter((it) => !["label", "folder", "format", "doubts"].includes(it));
    columns.replaceChildren(...own.map((value) => el("option", { value })));
  }

  /** @param {Listing} found */
  function nothing(found) {
    return found.all
      ? el("li", { class: "whole" }, el("p", {}, "No capture fits."), el("button", { type: "button", onclick: () => {
        filter.value = "";
        change({ q: [], where: [] });
        filter.focus();
      } }, "Show all"))
      : el("li", { class: "whole" }, el("p", { class: "soft" }, library.readonly ? "There is no capture in this library yet." : "There is no capture in this library yet. Drop some here, or begin with the examples."));
  }

  /** Say whether there is more before and behind what is shown. */
  function ends() {
    earlier.hidden = first === 0;
    more.hidden = first + list.children.length >= total;
    for (const node of [earlier, more]) { // what is near the window is told anew
      ending.unobserve(node);
      ending.observe(node);
    }
  }

  let extending = false;
  /** @param {1 | -1} way */
  async function extend(way) {
    if (extending) return;
    extending = true;
    const own = loading, at = way > 0 ? first + list.children.length : first - PAGE;
    try {
      const found = await page(at, PAGE);
      if (own !== loading) return;
      const cards = found.captures.map(card), before = document.documentElement.scrollHeight;
      if (way > 0) list.append(...cards);
      else {
        first = at;
        list.prepend(...cards);
        scrollBy({ top: document.documentElement.scrollHeight - before, behavior: "instant" });
      }
    } catch (error) {
      if (!isAbort(error)) announce(problemOf(error).found);
    } finally {
      extending = false;
      if (own === loading) ends();
    }
  }
  const ending = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (isIntersecting && list.children.length && target === more) extend(1);
      if (isIntersecting && target === earlier) extend(-1);
    }
  }, { rootMargin: "800px" });

  let settling = 0;
  /** Keep in the address which capture is the first that is seen: Back comes to the same place. */
  function settle() {
    const top = main.querySelector(".bar")?.getBoundingClientRect().bottom ?? 0;
    const cards = [...list.children];
    const at = scrollY > 200 ? cards.findIndex((it) => it.getBoundingClientRect().top >= top - 8) : -1;
    const before = asked.get("at") ?? "";
    asked.delete("at");
    if (at >= 0 && first + at) asked.set("at", String(first + at));
    if ((asked.get("at") ?? "") !== before) app.replace(asked.size ? `/?${asked}` : "/");
  }
  addEventListener("scroll", () => {
    clearTimeout(settling);
    settling = setTimeout(settle, 150);
  }, { signal, passive: true });
  list.addEventListener("click", settle); // before a link is followed
  signal.addEventListener("abort", () => {
    clearTimeout(settling);
    ending.disconnect();
  });

  /** @param {Capture} capture */
  function card(capture) {
    const path = capture.capture.slice(folder.length), name = path.slice(path.lastIndexOf("/") + 1);
    const pose = el("span", { class: "pose" });
    poses.add(pose, capture);
    const box = editing && el("input", { type: "checkbox", class: "pick", value: capture.capture_id, checked: selected.has(capture.capture_id), "aria-label": `Select ${name}`,
      onclick: (/** @type {MouseEvent} */ event) => pick(event, /** @type {HTMLInputElement} */ (event.target)) });
    return el("li", { class: "shot card" },
      el("a", { href: `/captures/${capture.capture_id}`, title: capture.capture },
        pose, el("span", { class: "folder soft" }, path.slice(0, path.length - name.length)), el("b", {}, ...broken(name))),
      box,
      el("p", { class: "label" }, editing ? editing.text(capture, "label", false) : capture.label || el("i", { class: "soft" }, "no label")),
      el("p", { class: "facts soft num" }, `${duration(capture.seconds)} · ${Number(capture.fps.toFixed(2))} fps · ${capture.format}`),
      ...Object.entries(capture.metadata).map(([column, value]) => el("p", { class: "column" }, el("span", { class: "soft" }, `${column} `), editing ? editing.text(capture, column, true) : value)),
      editing && el("button", { type: "button", class: "plain more", "aria-label": `Add a column to ${name}`, onclick: () => editing.column([capture.capture_id]) }, "+ column"),
      capture.warnings.length > 0 && el("details", { class: "doubts" }, el("summary", {}, counted(capture.warnings.length, "doubt")),
        ...capture.warnings.map((it) => el("p", {}, it))));
  }
  await load();
  if (asked.has("missing")) await missing();

  /** Offer to remove the captures whose files are gone. */
  async function missing() {
    const { captures } = await get("/api/captures/missing", signal);
    change({ missing: [] });
    if (!captures.length) announce("The files of all captures are there.");
    else if (editing) await editing.remove(captures, "Their files are not where they were read.");
    else announce(`The files of ${counted(captures.length, "capture")} are gone, and this library is only shown.`);
  }
}

/** Return a file's name that breaks behind its underscores and dashes. @param {string} name */
function broken(name) {
  return name.split(/(?<=[_-])/).flatMap((it) => [el("wbr"), it]);
}
