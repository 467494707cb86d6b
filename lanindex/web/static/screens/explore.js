// The screen of a library as a whole: how movement is spread, what recurs, which captures are alike.

import { address, follow, get, isAbort, problemOf, send } from "../api.js";
import { counted, el, readOut, svg, trouble } from "../dom.js";
import { nameOf } from "../names.js";
import { cellPlot, percent, progressBar, ratePlot } from "../plots.js";
import { Poses } from "../poses.js";

/** @typedef {import("../app.js").App} App */
/** @typedef {{group: string, part: string, captures: number, movements: number, coverage: number, rate: number, cells: Record<string, number>, transitions: [string, string, number][], over_time: number[]}} Moves */
/** @typedef {{part: string, what: string, values: [number, number], difference: number, least: number, most: number, p: number}} Difference */

/** @type {[string, string, string][]} */
const WAYS = [
  ["statistics", "Statistics", "Where each part goes, how often and when; for two groups, in what they differ."],
  ["motifs", "Motifs", "Sequences of symbols that recur. Each is a pattern, with as many hits."],
  ["similar", "Similar", "Captures that are alike, in groups."],
];

/** @param {App} app */
export async function show(app) {
  const { main, url, library, signal } = app, query = url.searchParams;
  const what = WAYS.some(([name]) => name === query.get("what")) ? String(query.get("what")) : "statistics";
  const path = el("input", { type: "search", value: query.get("in") ?? "", placeholder: "All paths", "aria-label": "Path contains" });
  const where = el("input", { type: "search", value: query.getAll("where").join(", "), placeholder: "label=walk*", title: "A column of the captures and what stands in it; * stands for any letters. Several, with commas, must all hold.", "aria-label": "Where a column is", list: "columns" });
  const part = choice("Part", "all parts", library.parts, query.get("part"), nameOf);
  const by = choice("By", "all together", library.columns, query.get("by"));
  const one = choice("First group", "all groups", [], null), two = choice("Second group", "all groups", [], null);
  const comparing = el("span", { class: "row", hidden: !by.value }, el("label", {}, "Compare ", one), el("label", {}, "with ", two));
  const out = el("section", { "aria-label": "What was found" }), poses = new Poses(signal);
  const pair = query.getAll("compare");
  let stop = () => {};
  let round = 0; // what an earlier round finds is not shown any more
  signal.addEventListener("abort", () => stop());

  main.append(
    el("h1", {}, "Explore"),
    el("nav", { class: "tabs", "aria-label": "What is explored" }, ...WAYS.map(([name, title]) =>
      el("a", { href: address("/explore", { ...asked(), what: name }), "aria-current": name === what ? "page" : null }, title))),
    el("p", { class: "soft" }, WAYS.find(([name]) => name === what)?.[2] ?? ""),
    el("form", { class: "row", onsubmit: (/** @type {Event} */ event) => {
      event.preventDefault();
      run();
    } },
      el("label", {}, "Path ", path), el("label", {}, "Where ", where),
      el("datalist", { id: "columns" }, ...library.columns.map((it) => el("option", { value: `${it}=` }))),
      what !== "similar" && el("label", {}, "Part ", part),
      ...(what === "statistics" ? [el("label", {}, "By ", by), comparing] : []),
      el("button", { type: "submit", class: "main" }, "Explore")),
    out);
  for (const node of [part, by]) node.addEventListener("change", run);
  by.addEventListener("change", () => pair.splice(0));
  for (const node of [one, two]) node.addEventListener("change", () => {
    pair.splice(0, 2, ...(one.value && two.value && one.value !== two.value ? [one.value, two.value] : []));
    if (pair.length || !one.value && !two.value) run();
  });
  if (by.value && what === "statistics") await groups();
  by.addEventListener("change", groups);
  if (what === "statistics" || query.has("run")) run();

  function asked() {
    return { in: path.value, where: where.value.split(",").map((it) => it.trim()).filter(Boolean), part: part.value, by: by.value, compare: pair };
  }

  /** Offer the groups of a column. */
  async function groups() {
    comparing.hidden = !by.value;
    /** @type {{facets: {name: string, values: [string, number][]}[]}} */
    const { facets } = await get("/api/captures?n=1", signal);
    const values = (facets.find((it) => it.name === by.value)?.values ?? []).map(([value]) => value).filter(Boolean);
    for (const [at, node] of [one, two].entries()) {
      node.replaceChildren(el("option", { value: "" }, "all groups"), ...values.map((it) => el("option", { value: it, selected: it === pair[at] }, it)));
    }
  }

  async function run() {
    stop();
    const own = ++round;
    const { in: within, where: globs, part: only, by: column, compare } = asked();
    app.replace(address("/explore", { what, in: within, where: globs, part: only, by: column, compare, run: what !== "statistics" }));
    const body = { what, path: within, where: globs, parts: only ? [only] : [], ...(what === "statistics" ? { by: column, compared: compare } : {}) };
    try {
      /** @type {{job: string}} */
      const { job } = await send("POST", "/api/explore", body, signal);
      if (own !== round) return;
      const { root, tell } = progressBar(() => send("DELETE", `/api/jobs/${job}`, {}, signal));
      out.replaceChildren(root);
      stop = follow(`/api/jobs/${job}/events`, (state) => {
        tell(state.progress);
        if (state.state === "running") return;
        poses.clear();
        if (state.state === "cancelled") out.replaceChildren(el("p", { class: "soft" }, "Cancelled."));
        else if (state.error) out.replaceChildren(trouble(state.error));
        else out.replaceChildren(...DRAWN[what](state.found));
        readOut(out.querySelector("p")?.textContent ?? "");
      }, () => out.replaceChildren(trouble({ found: "the server does not answer", remedy: "Is lanindex serve still running?" })));
    } catch (error) {
      if (!isAbort(error) && own === round) out.replaceChildren(trouble(problemOf(error)));
    }
  }

  /** @type {Record<string, (found: any) => HTMLElement[]>} */
  const DRAWN = { statistics, motifs, similar };

  /** @param {{captures: number, of: number}} found */
  function sample({ captures, of }) {
    return captures < of ? `${captures.toLocaleString("en")} of ${counted(of, "capture")}, taken at random` : counted(captures, "capture");
  }

  /** @param {{motifs: any[], captures: number, of: number, all: number, notes: string[]}} found */
  function motifs(found) {
    const shown = found.motifs.length < found.all ? `; the first ${found.motifs.length} are shown` : "";
    return [
      el("p", {}, `${counted(found.all, "motif")} in ${sample(found)}${shown}. What accounts for most symbols comes first.`),
      ...found.notes.map((it) => el("p", { class: "soft" }, it)),
      el("ol", { class: "motifs" }, ...found.motifs.map(({ pattern, hits, captures, first, svg: drawn }) => el("li", { class: "card" },
        drawn && el("div", { class: "strip" }, hidden(svg(drawn))),
        el("div", {},
          el("a", { href: address("/search", { q: pattern }) }, el("code", {}, pattern)),
          el("p", { class: "soft" }, `${counted(hits, "hit")} in ${counted(captures, "capture")}; first `,
            el("a", { href: address(`/captures/${first.capture_id}`, { from: first.start, to: first.end }), class: "path" }, tail(first.capture))))))),
    ];
  }

  /** @param {{groups: any[], captures: number, of: number, all: number, alone: number}} found */
  function similar(found) {
    return [
      el("p", {}, `${counted(found.all, "group")} in ${sample(found)}; ${found.alone} are like no other.`),
      ...found.groups.map((group) => el("section", { class: "card alike" },
        el("h2", {}, `${counted(group.count, "capture")}, likeness ${group.likeness.toFixed(2)}`),
        el("ul", {}, ...group.captures.map((/** @type {any} */ capture, /** @type {number} */ at) => {
          const pose = el("span", { class: "pose" });
          poses.add(pose, capture);
          return el("li", {}, el("a", { href: `/captures/${capture.capture_id}`, title: capture.capture }, pose, el("span", { class: "path" }, tail(capture.capture)), capture.label && el("span", { class: "soft" }, capture.label)),
            at > 0 && el("a", { class: "soft", href: address("/compare", { a: group.captures[0].capture_id, b: capture.capture_id }) }, "compare"));
        })),
        group.count > group.captures.length && el("p", { class: "soft" }, `and ${group.count - group.captures.length} more`))),
    ];
  }

  /** @param {{groups: Record<string, number>, moves: Moves[], differences: Difference[], compared: number}} found */
  function statistics(found) {
    const names = Object.keys(found.groups), parts = [...new Set(found.moves.map((it) => it.part))];
    const most = Math.max(...found.moves.flatMap((it) => it.over_time), 0);
    return [
      el("p", {}, names.length > 1 ? `${counted(names.length, "group")}: ${names.map((it) => `${it || "none"} (${found.groups[it]})`).join(", ")}` : counted(found.groups[names[0]] ?? 0, "capture")),
      ...(names.length === 2 ? [differences(found, names)] : []),
      ...(names.length > 1
        ? parts.map((name) => el("section", {}, el("h2", {}, nameOf(name)), el("div", { class: "moves" }, ...found.moves.filter((it) => it.part === name).map((it) => figure(it, it.group || "none", most)))))
        : [el("div", { class: "moves" }, ...found.moves.map((it) => figure(it, nameOf(it.part), most)))]),
    ];
  }

  /** @param {Moves} moves @param {string} name @param {number} most */
  function figure(moves, name, most) {
    return el("figure", { class: "card" },
      el("figcaption", {}, name),
      cellPlot(moves.cells, `${nameOf(moves.part)}, ${moves.group || "none"}`),
      ratePlot(moves.over_time, most),
      el("p", { class: "soft num" }, `${counted(moves.movements, "movement")} in ${counted(moves.captures, "capture")}, ${moves.rate.toFixed(2)} a second; known ${percent(moves.coverage)} of the time`),
      el("details", {}, el("summary", {}, "The most frequent ways"), el("ol", {}, ...moves.transitions.map(([from, to, count]) =>
        el("li", {}, el("a", { href: address("/search", { q: `${moves.part} ${from} -> ${to}` }) }, `${nameOf(from)} \u2192 ${nameOf(to)}`), ` ${count}`)))));
  }

  /** @param {{differences: Difference[], compared: number}} found @param {string[]} names */
  function differences({ differences: rows, compared }, names) {
    const told = (/** @type {string} */ name, /** @type {number} */ it) => name === "rate" ? `${it.toFixed(2)} /s` : percent(it);
    return el("div", { class: "guide" },
      el("p", { class: "soft" }, `${rows.length} of ${compared} differences matter: means over captures; intervals and p hold for all of them together.`),
      rows.length > 0 && el("table", {},
        el("thead", {}, el("tr", {}, ...["part", "where", ...names.map((it) => it || "none"), "difference", "95 % interval", "p"].map((it) => el("th", { scope: "col" }, it)))),
        el("tbody", {}, ...rows.map((it) => el("tr", {}, ...[nameOf(it.part), nameOf(it.what), ...it.values.map((value) => told(it.what, value)), told(it.what, it.difference), `${told(it.what, it.least)} to ${told(it.what, it.most)}`, it.p.toFixed(3)].map((cell) => el("td", { class: "num" }, cell)))))));
  }
}

/** @param {string} label @param {string} none @param {string[]} values @param {string | null} chosen @param {(value: string) => string} said */
function choice(label, none, values, chosen, said = (it) => it) {
  return el("select", { "aria-label": label }, el("option", { value: "" }, none), ...values.map((it) => el("option", { value: it, selected: it === chosen }, said(it))));
}

/** @param {string} path */
function tail(path) {
  return path.split("/").slice(-1)[0];
}

/** @param {SVGSVGElement} node */
function hidden(node) {
  node.setAttribute("aria-hidden", "true");
  return node;
}
