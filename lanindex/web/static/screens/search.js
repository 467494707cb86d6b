// The screen of the search: the line, what it finds, and what can be done with that.

import { ApiError, address, follow, get, isAbort, problemOf, send } from "../api.js";
import { counted, el, readOut, trouble } from "../dom.js";
import { Basket } from "../basket.js";
import { copies } from "../copied.js";
import { HitList, watching } from "../hits.js";
import { QueryLine } from "../query_line.js";
import { QueryStaff } from "../query_staff.js";

/**
 * @typedef {import("../app.js").App} App
 * @typedef {import("../query_line.js").Reading} Reading
 * @typedef {import("../hits.js").Hit} Hit
 *
 * @typedef {object} State of a search
 * @property {string} job
 * @property {"running" | "done" | "cancelled" | "failed"} state
 * @property {[string, number, number]} progress
 * @property {number} [seconds] of a search by pattern
 * @property {number} found
 * @property {number} captures
 * @property {string[]} notes
 * @property {import("../api.js").Problem} [error]
 * @property {{by: string | null, value: string | number | null, count: number}[]} [counts] of a pattern that ends in `| count`
 */

const GONE = 404; // the status of what the server does not keep any more
const PAGE = 24;
const MOST = 100; // hits in an answer
const LONG = 300; // characters of a pattern that gets a name in addresses
const WIDE = "(min-width: 1100px)"; // where the staff of the query stands beside the hits
const SOON = 150; // milliseconds after the last key, in which nobody wants hits
const ORDERS = [["best", "best first"], ["best capture", "best captures first"], ["capture", "in order"]];
const WAYS = [["near", "near", "A symbol near the border of its cell matches from both sides"]];
const EXAMPLES = ["waving", "bowing", "arms place high -> side mid", "r_arm forward low ... high <2s", "torso forward high"];
const EDITS = [["", "exact"], ["10%", "10 % edits"], ["20%", "20 % edits"], ["35%", "35 % edits"]];

/** @param {App} app */
export function show(app) {
  const { main, signal, url } = app;
  const given = new URLSearchParams(url.search);
  let like = given.get("like") ?? ""; // the clip whose like is searched for, until something is typed
  const list = new HitList(signal, app.library.folder, actions);
  const basket = new Basket(app.library.name);
  const summary = el("p", { class: "summary" });
  const bar = el("progress", { hidden: true, "aria-label": "How far the search is" });
  const cancel = el("button", { type: "button", hidden: true, onclick: () => job && send("DELETE", `/api/jobs/${job}`) }, "Cancel");
  const more = el("button", { type: "button", hidden: true, onclick: () => {
    least = list.length + PAGE; // also where all come anew, in their order, because the search has ended
    page();
  } }, "Show more");
  const facets = el("details", { class: "facets", hidden: true, open: matchMedia("(min-width: 801px)").matches });
  const problem = el("div"), example = el("p", { hidden: true });
  const order = choice("Order", ORDERS, given.get("order") ?? "best");
  const edits = choice("Edits a match may cost", EDITS, given.get("fuzzy") ?? "");
  const within = el("input", { type: "search", value: given.get("in") ?? "", placeholder: "all captures, or *walk*", title: "Only captures whose path is like this; * stands for any letters", "aria-label": "Only captures whose path matches" });
  edits.title = "How far a hit may differ from the pattern: a missing step costs one edit; so much of an edit is allowed for each step after the second";
  const near = el("input", { type: "checkbox", checked: given.has("near") });
  const line = new QueryLine({ read: (reading) => soon(reading), run: (reading) => run(reading, true) });
  const chosen = given.getAll("where"), chips = el("div", { class: "row", hidden: !chosen.length }, ...chosen.map((it) =>
    el("button", { type: "button", title: "Take it away", onclick: () => app.go(address("/search", { ...asked(line.text), where: chosen.filter((other) => other !== it) })) }, `${it} \u00d7`)));
  /** @type {QueryStaff | null} */
  let staff = null;
  const wide = matchMedia(WIDE).matches, drawn = el("details", { class: "q-toggle", open: given.has("draw") ? given.get("draw") !== "0" : wide, ontoggle: () => draw() }, el("summary", {}, "Draw it"));

  const copying = copies(() => asked(line.text), app.library.file);
  main.append(
    el("h1", { class: "hidden" }, "Search"),
    el("div", { class: "asked" },
      line.root,
      drawn,
      el("div", { class: "found" },
        el("div", { class: "row" }, order, edits, el("label", { title: WAYS[0][2] }, near, " near"), within, el("span", { class: "grow" }), bar, cancel),
        chips, example, el("div", { class: "row" }, summary, el("span", { class: "grow" }), copying), problem,
        el("div", { class: "columns" }, facets, el("div", {}, list.root, more)))),
    basket.root);

  /** @type {string | null} */
  let job = null;
  let stop = () => {};
  let waiting = 0, ran = "", all = 0;
  let wanted = Number(given.get("hit")) || 0; // the hit, from 1, that the address comes back to
  let settled = false; // whether the address is one to come back to, not of something half typed
  let running = false, least = 0;
  let round = 0, loading = -1; // hits of an earlier round are not shown any more
  for (const node of [order, edits, near, within]) node.addEventListener("change", () => again());
  list.root.addEventListener("click", (event) => {
    const link = /** @type {Element} */ (event.target).closest("a"), card = link?.closest(".hit");
    if (card && ran) app.replace(address("/search", { ...asked(line.text), hit: [...list.root.querySelectorAll(".hit")].indexOf(card) + 1 })); // where Back comes to
  });

  /** @param {Reading} reading */
  function soon(reading) {
    staff?.show(reading);
    clearTimeout(waiting);
    list.root.classList.toggle("old", reading.error !== null);
    if (!reading.text.trim() && !like) nothing();
    else if (!reading.error && reading.text.trim()) waiting = window.setTimeout(() => run(reading, false), SOON);
  }

  function again() {
    ran = "";
    if (like) alike();
    else if (line.reading) run(line.reading, true);
  }

  /** Return what searches for a pattern. @param {string} pattern */
  function way(pattern) {
    return el("button", { type: "button", class: "way", onclick: () => line.set(pattern).then((reading) => reading && run(reading, true)) }, pattern);
  }

  /** Show no hits: what is asked is not understood, or there is nothing. */
  function nothing() {
    stop();
    job = null;
    ran = summary.textContent = "";
    round++;
    list.clear();
    list.root.classList.remove("old");
    problem.replaceChildren(...(line.text.trim() ? [] : [el("div", { class: "row ways" }, el("span", { class: "soft" }, "For example"), ...EXAMPLES.map(way))]));
    facets.hidden = more.hidden = bar.hidden = cancel.hidden = true;
    copying.hidden = !line.text.trim();
    told(address("/search", asked(line.text)));
    settled = false;
  }

  /**
   * Tell the address of what is asked; Back returns to what somebody meant.
   * @param {string} path
   */
  function told(path) {
    if (path === location.pathname + location.search) return;
    if (settled) app.push(path);
    else app.replace(path);
  }

  /**
   * What is asked, as the address has it.
   * @param {string} q
   */
  function asked(q) {
    return { q, like, in: within.value, where: chosen, near: near.checked, fuzzy: edits.value, order: order.value === "best" ? "" : order.value, draw: drawn.open === wide ? "" : Number(drawn.open) };
  }

  /**
   * Ask for hits.
   * @param {string} text what is asked, which may be less than is typed by now
   * @param {object} body
   * @param {boolean} meant whether it was asked for, not only typed
   */
  async function search(text, body, meant) {
    const path = address("/search", asked(text));
    if (path === ran) {
      settled ||= meant;
      return;
    }
    ran = path;
    copying.hidden = false;
    if (job) wanted = 0; // it was a hit of the search that the screen began with
    app.title(text || `like ${like}`);
    if (!wanted) told(path);
    settled = meant;
    stop();
    try {
      const { job: number } = await send("POST", "/api/searches", { path: within.value || null, where: chosen, ...body }, signal);
      if (path !== ran) return;
      job = number;
      begin();
    } catch (error) {
      if (isAbort(error) || path !== ran) return;
      nothing();
      problem.replaceChildren(trouble(problemOf(error)));
    }
  }

  /** Open the staff of the query, or close it. */
  async function draw() {
    const url = new URL(location.href);
    if (drawn.open === wide) url.searchParams.delete("draw");
    else url.searchParams.set("draw", String(Number(drawn.open)));
    app.replace(url.pathname + url.search);
    if (!drawn.open || staff) return;
    try {
      const about = await get("/api/query", signal);
      if (staff) return;
      staff = new QueryStaff({ about, changed: write });
      drawn.append(staff.root);
      if (line.reading) staff.show(line.reading);
    } catch (error) {
      if (!isAbort(error)) problem.replaceChildren(trouble(problemOf(error)));
    }
  }

  /**
   * Write what is drawn into the line.
   * @param {any} tree
   */
  async function write(tree) {
    try {
      return await line.set(tree ? (await send("POST", "/api/text", { tree }, signal)).text : "");
    } catch (error) {
      if (!isAbort(error)) problem.replaceChildren(trouble(problemOf(error)));
      return null;
    }
  }

  /**
   * @param {Reading} reading
   * @param {boolean} meant whether it was asked for, not only typed
   */
  async function run(reading, meant) {
    clearTimeout(waiting);
    if (!reading.text.trim()) return;
    if (reading.error) return meant && nothing(); // the line says what is wrong
    like = "";
    shown();
    const query = asked(reading.text), path = address("/search", query);
    if (query.q.length > LONG && !app.library.readonly) shorten(query, path);
    await search(query.q, { pattern: query.q, near: query.near, fuzzy: query.fuzzy || null }, meant);
  }

  /** Search for what is like a clip. */
  function alike() {
    shown();
    return search(line.text, { like }, true);
  }

  /** Say what the hits are like; such a search has no order and no edits. */
  function shown() {
    example.hidden = !like;
    if (like) example.replaceChildren("Movement like that of ", el("a", { href: `/captures/${like.split(":")[0]}` }, `capture ${like}`));
    order.disabled = edits.disabled = near.disabled = like !== "";
  }

  /**
   * Let a name stand for a long pattern in the address.
   * @param {ReturnType<typeof asked>} query
   * @param {string} path
   */
  async function shorten(query, path) {
    const { name } = await send("POST", "/api/names", { text: query.q }, signal).catch(() => ({ name: "" }));
    if (name && path === ran) app.replace(address("/search", { ...query, q: "", p: name }));
  }

  /** Follow the search that has begun: the first hits are shown as soon as there are any. */
  function begin() {
    round++;
    list.clear();
    list.root.classList.remove("old");
    problem.replaceChildren();
    facets.hidden = true;
    least = wanted;
    const own = job;
    stop = follow(`/api/jobs/${own}/events`, (state) => own === job && tell(state), () => own === job && problem.replaceChildren(trouble({ found: "the server does not answer", remedy: "Is lanindex serve still running?" })));
  }

  /** @param {State} state */
  async function tell(state) {
    const [noun, done, total] = state.progress, own = job;
    running = state.state === "running";
    all = state.found;
    bar.hidden = cancel.hidden = !running;
    bar.max = total || 1;
    bar.value = done;
    const found = `${counted(state.found, "hit")} in ${counted(state.captures, "capture")}`;
    const far = total ? `; ${done.toLocaleString("en")} of ${total.toLocaleString("en")} ${noun}` : "", spent = Math.floor(state.seconds ?? 0);
    summary.textContent = running ? `${found} so far${far}${spent ? `; ${spent} s` : ""}` : found + (state.state === "cancelled" ? ", broken off" : "");
    if (state.error) problem.replaceChildren(trouble(state.error));
    if (!running) {
      round++;
      list.clear();
      for (const note of state.notes) problem.append(el("p", { class: "soft" }, note));
      if (state.counts) problem.append(el("ul", { class: "counts" }, ...state.counts.map(({ by, value, count }) => el("li", {}, `${value ?? (by ? "none" : "all")}: ${count.toLocaleString("en")}`))));
      await page();
      if (own !== job) return; // something else is asked by now
      readOut(summary.textContent);
      if (!state.found && state.state === "done") instead();
      else showFacets();
    } else if (state.found && !list.length) await page();
    more.hidden = list.length >= state.found;
  }

  async function page() {
    const now = round;
    if (loading === now || !job) return;
    loading = now;
    try {
      const own = job, at = list.length, by = order.value, n = Math.min(Math.max(PAGE, least - at), MOST);
      const { hits } = await get(address(`/api/searches/${own}/hits`, { at, n, order: by }), signal);
      if (now !== round) return;
      list.add(hits, (index) => `/api/searches/${own}/hits/${index}/card?order=${encodeURIComponent(by)}`, (hit) => watching(hit, line.text), by !== "best");
      more.hidden = list.length >= all;
      if (wanted && !running) reach();
    } catch (error) {
      if (now !== round) return;
      if (error instanceof ApiError && error.status === GONE) again();
      else if (!isAbort(error)) problem.replaceChildren(trouble(problemOf(error)));
    } finally {
      if (loading === now) loading = -1;
    }
  }

  /** Go to the hit that the address names, once it is there. */
  function reach() {
    const link = list.root.querySelectorAll(".hit")[wanted - 1]?.querySelector("a.show");
    if (!link && list.length < all && wanted <= all) return void setTimeout(page);
    wanted = 0;
    if (!(link instanceof HTMLElement)) return;
    link.focus({ preventScroll: true });
    link.scrollIntoView({ block: "center" });
  }

  /** @param {Hit} hit */
  function actions(hit) {
    const clip = `${hit.capture_id}:${hit.start_frame}-${hit.end_frame}`;
    const keep = el("button", { type: "button", class: "plain", "data-basket": clip, "aria-pressed": String(basket.has(hit)), "aria-label": "In the basket", title: "Put it into the basket", onclick: () => {
      keep.setAttribute("aria-pressed", String(basket.toggle(hit, line.text)));
    } });
    return [el("a", { href: address("/search", { like: clip }) }, "more like this"), keep];
  }

  async function showFacets() {
    const own = job;
    const found = await get(`/api/searches/${own}/facets`, signal).catch(() => null);
    if (!found || own !== job) return;
    const several = Object.entries(found).filter(([, values]) => values.length > 1);
    facets.hidden = !several.length;
    facets.replaceChildren(el("summary", {}, "Narrow down"), ...several.map(([name, values]) => el("section", {}, el("h2", {}, name),
      el("ul", {}, .../** @type {[string, number][]} */ (values).map(([value, count]) => el("li", {}, el("a", { href: address("/search", { ...asked(line.text), where: [...chosen, `${name}=${value}`] }) }, value || "none"), el("span", { class: "soft num" }, ` ${count}`)))))));
  }

  /** Offer what would be found, where nothing is. */
  async function instead() {
    if (!app.library.captures) {
      problem.append(el("p", {}, "There is no capture in this library yet. ", el("a", { href: "/" }, "Add some")));
      return;
    }
    if (like) return;
    const own = job;
    try {
      const advice = await get(`/api/searches/${own}/advice`, signal);
      if (own !== job) return;
      problem.append(
        advice.remark && el("p", {}, advice.remark),
        ...advice.never.map((/** @type {string} */ it) => el("p", {}, `"${it}" is nowhere to be found.`)),
        ...advice.left_out.map((/** @type {{said: string, pattern: string}} */ it) => el("p", {}, it.said, " ", way(it.pattern))),
        ...(advice.instead.length ? [el("h2", {}, "What would be found")] : []),
        ...advice.instead.map((/** @type {{pattern: string, hits: number, captures: number}} */ it) =>
          el("p", {}, way(it.pattern), " ", el("span", { class: "soft" }, `${counted(it.hits, "hit")} in ${counted(it.captures, "capture")}`))));
    } catch (error) {
      if (!isAbort(error)) problem.append(trouble(problemOf(error)));
    }
  }

  if (like) {
    alike();
    line.focus();
  } else fill();

  async function fill() {
    const name = given.get("p");
    try {
      const text = name ? (await get(`/api/names/${name}`, signal)).text : given.get("q") ?? "";
      if (!text) line.focus();
      const reading = await line.set(text);
      if (reading?.text.trim()) run(reading, true);
    } catch (error) {
      if (!isAbort(error)) problem.replaceChildren(trouble(problemOf(error)));
    }
  }
  return () => stop();
}

/**
 * @param {string} label
 * @param {string[][]} options
 * @param {string} chosen
 */
function choice(label, options, chosen) {
  return el("select", { "aria-label": label }, ...options.map(([value, name]) => el("option", { value, selected: value === chosen }, name)));
}
