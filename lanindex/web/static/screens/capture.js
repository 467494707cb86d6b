// The screen of a capture: the figure beside its staff, one clock, what is chosen on the staff.

import { address, get, isAbort, problemOf } from "../api.js";
import { CurveView } from "../curves.js";
import { announce, counted, duration, el, readOut, svg, trouble } from "../dom.js";
import { Figure, figureBar, spaceDrawer } from "../figure.js";
import { Motion } from "../motion.js";
import { nameOf } from "../names.js";
import { Player, playerBar, playerKeys } from "../player.js";
import { Speech } from "../speech.js";
import { StaffView } from "../staff.js";
import { Editing } from "./library/editing.js";

/**
 * @typedef {import("../app.js").App} App
 * @typedef {import("./library.js").Capture & {parts: Record<string, number>, usual: string[], moves: boolean}} Shown
 */

const RATE = 60; // frames a second that are played, at most
const TOLD = 200; // ms for which a time is shown before the address tells it: browsers allow few changes a second

/** @param {App} app */
export async function show(app) {
  const { main, url, signal } = app;
  const path = `/api${url.pathname}`, number = url.pathname.split("/").pop() ?? "";
  const given = new URLSearchParams(url.search);
  main.classList.add("watch");
  let early = "&early=1"; // a large file is shown before it is known to be the one that was ingested
  const coming = get(`${path}/figure?early=1`, signal); // asked for before all else, waited for at the end
  coming.catch(() => {});
  const capture = /** @type {Shown} */ (await get(path, signal));
  app.title(capture.capture.split("/").pop() ?? "");
  const canvas = el("canvas", { class: "figure" }), side = el("div", {}), bars = el("div", { class: "bars" });
  const symbol = el("span", { class: "row" }), stretch = el("span", { class: "row" }), speech = new Speech();
  const chosen = el("div", { class: "row chosen-one" }, symbol, stretch);
  const labels = el("datalist", { id: "labels" });
  const editing = app.library.readonly ? null : new Editing(signal, (shown) => shown ? app.refresh() : again());
  const label = el("span", {}, editing ? editing.text(capture, "label", false) : capture.label);
  main.append(
    el("header", { class: "row" },
      el("h1", { class: "path", title: capture.capture }, shortened(capture.capture, app.library.folder)),
      el("span", { class: "label" }, label, labels),
      el("span", { class: "soft num" }, `${duration(capture.seconds)}, ${capture.fps} frames a second, ${capture.format}`),
      el("span", { class: "grow" }),
      el("nav", { class: "row", "aria-label": "This capture" },
        el("a", { href: address("/search", { like: number }) }, "More like this"),
        el("a", { href: address("/edit", { capture: number }) }, "Edit"),
        capture.moves && el("a", { href: address("/convert", { capture: number }) }, "Convert"),
        el("a", { href: address("/compare", { a: number }) }, "Compare with \u2026"))),
    doubts(capture.warnings),
    el("div", { class: "stage" }, canvas, side),
    bars, chosen);
  const places = el("div", {});
  main.append(places);

  const seconds = capture.seconds;
  /** @type {Motion | ReturnType<typeof still>} */
  let motion = still(seconds, false);
  /** @type {Figure | null} */
  let figure = null;
  const player = new Player({ seconds, ready: (at) => motion.ready(at), failure: (at) => motion.failure(at), retry: () => motion.retry() }, Math.min(capture.fps, RATE));
  const lit = new Set((given.get("lit") ?? "").split(",").filter(Boolean));
  let parts = given.get("parts") ?? "", curve = given.get("curve") ?? "", ghosts = false, told = 0, telling = 0;

  const staff = new StaffView(side, {
    seconds,
    load: (from, to, zoom, coming) => get(address(`${path}/staff`, { from, to, zoom, parts }) + early, coming),
    parse: svg,
    seek: (at) => player.seek(at),
    pick: (symbol) => picked(symbol),
    select: (range) => selected(range),
  });

  player.listen((at) => {
    if (figure && motion instanceof Motion) {
      const pose = motion.pose(at), around = ghosts ? motion.around(at) : [];
      if (pose) figure.show([{ strokes: motion.description.strokes, pose, ghosts: around, lit, way: motion.way(at) }]);
    }
    staff.show(at);
    if (curve) curves.show(at);
    if (!player.playing && Math.abs(at - told) > 0.005) {
      told = at;
      clearTimeout(telling);
      telling = setTimeout(tell, TOLD);
    }
  });
  const choice = columns();
  bars.append(playerBar(player), choice, speech.button);
  playerKeys(document.body, player, signal);
  const curves = new CurveView(seconds, (from, to, coming) => get(address(`${path}/curves`, { part: curve, from, to }), coming), (at) => player.seek(at));
  places.append(curvePanel());

  /** Show the figure beside the staff, which does not wait for it: a file may take long to read. */
  async function embody() {
    const drawer = spaceDrawer(); // while the movement is on its way
    /** @type {HTMLElement | undefined} */
    let bar;
    try {
      const description = await coming, space = await drawer;
      if (signal.aborted) return;
      motion = new Motion(path, description, (tile, init) => fetch(`${tile}?v=${app.library.stamp}${early}`, init), 48);
      motion.changed = () => player.refresh();
      figure = new Figure(canvas, { label: "The figure", space });
      figure.floor = description.floor;
      bar = figureBar(figure, (on) => {
        ghosts = on;
        player.refresh();
      });
      choice.before(bar);
      player.refresh();
      await get(`${path}/source`, signal);
    } catch (error) {
      if (isAbort(error)) return;
      canvas.replaceWith(trouble(problemOf(error)));
      bar?.remove();
      figure?.dispose();
      figure = null;
      if (motion instanceof Motion) motion.abort();
      motion = still(seconds);
    }
    early = "";
    player.refresh();
  }

  /** Show the label as the library has it, once it is changed back. */
  async function again() {
    await app.refresh();
    Object.assign(capture, await get(path, signal));
    const focused = label.contains(document.activeElement);
    if (editing) label.replaceChildren(editing.text(capture, "label", false));
    if (focused || document.activeElement === document.body) label.querySelector("button")?.focus();
  }

  /** Offer the labels that other captures have. */
  async function offer() {
    const { facets } = await get("/api/captures?n=0", signal);
    const known = facets.find((/** @type {import("./library.js").Facet} */ it) => it.name === "label");
    labels.replaceChildren(...(known?.values ?? []).filter((/** @type {[string, number]} */ [it]) => it).map((/** @type {[string, number]} */ [value]) => el("option", { value })));
  }
  if (editing) label.addEventListener("focusin", () => void offer().catch((error) => {
    if (!isAbort(error)) announce(problemOf(error).found);
  }), { once: true });

  /** Keep in the address what is shown. */
  function tell() {
    const [from, to] = staff.range ?? [null, null];
    app.replace(address(url.pathname, { t: told ? told.toFixed(3) : "", from: from?.toFixed(3), to: to?.toFixed(3), parts, lit: [...lit].join(","), curve, q: given.get("q") }));
  }

  /** @param {SVGElement} node */
  async function picked(node) {
    const words = el("span", {}, node.querySelector("title")?.textContent ?? "");
    symbol.replaceChildren(words);
    speech.say(words.textContent ?? "");
    const { symbol: name, start: at } = node.dataset;
    if (!name) return;
    try {
      const { pattern } = await get(address(`${path}/symbol`, { name, at, parts }), signal);
      if (pattern && words.isConnected) words.after(el("a", { href: address("/search", { q: pattern }) }, `search for ${pattern}`));
    } catch (error) {
      if (!isAbort(error) && words.isConnected) words.after(trouble(problemOf(error)));
    }
  }

  /** @param {[number, number] | null} range */
  function selected(range) {
    if (!range) {
      stretch.replaceChildren();
      player.range = null;
      player.loop = false;
    } else {
      const [from, to] = range, [first, last] = range.map((it) => Math.round(it * capture.fps));
      player.range = range;
      readOut(`${from.toFixed(2)} to ${to.toFixed(2)} seconds are selected`);
      stretch.replaceChildren(
        el("span", { class: "num" }, `${from.toFixed(2)}\u2013${to.toFixed(2)} s`),
        el("button", { type: "button", onclick: () => {
          player.loop = true;
          player.seek(from);
          player.play();
        } }, "Loop it"),
        el("a", { href: address("/edit", { capture: number, from: from.toFixed(3), to: to.toFixed(3) }) }, "edit it"),
        el("a", { href: address("/search", { like: `${number}:${first}-${last}` }) }, "search for movement like it"),
        el("button", { type: "button", onclick: () => pattern(from, to) }, "search for its symbols"));
    }
    tell();
  }

  /** @param {number} from @param {number} to */
  async function pattern(from, to) {
    try {
      const found = await get(address(`${path}/pattern`, { from, to, parts }), signal);
      app.go(address("/search", { q: found.pattern }));
    } catch (error) {
      if (!isAbort(error)) stretch.append(trouble(problemOf(error)));
    }
  }

  /** The choice of the columns of the staff, also while it plays. */
  function columns() {
    const wanted = new Set(parts ? parts.split(",") : capture.usual);
    const boxes = Object.entries(capture.parts).map(([part, count]) => el("label", { title: counted(count, "symbol") },
      el("input", { type: "checkbox", value: part, checked: wanted.has(part), onchange: (/** @type {Event} */ event) => {
        const { checked } = /** @type {HTMLInputElement} */ (event.target);
        if (checked) wanted.add(part);
        else wanted.delete(part);
        const all = [...wanted].sort().join(","), usual = [...capture.usual].sort().join(",");
        parts = all === usual ? "" : all;
        staff.reload();
        tell();
        readOut(`${nameOf(part)} ${checked ? "is shown" : "is hidden"}`);
      } }), ` ${nameOf(part)}`));
    return el("details", { class: "choose" }, el("summary", {}, "Columns of the staff"), el("div", { class: "row" }, ...boxes));
  }

  /** The curves of a limb, which is chosen above them. */
  function curvePanel() {
    const limbs = Object.keys(capture.parts).filter((it) => /arm|hand|palm|leg|thigh|shank|foot|^head$|^torso$/.test(it) && !/_bend$|_touch$/.test(it));
    const limb = el("select", { onchange: () => {
      curve = limb.value;
      curves.reload();
      tell();
    } }, ...limbs.map((it) => el("option", { value: it, selected: it === curve }, nameOf(it))));
    const panel = el("details", { class: "curve-panel", open: curve !== "", ontoggle: () => {
      if (panel.open === (curve !== "")) return;
      curve = panel.open ? limb.value : "";
      if (panel.open) curves.reload(player.seconds);
      else curves.dispose();
      tell();
    } },
    el("summary", {}, "Curves"),
    el("div", { class: "row" }, el("label", {}, "Limb ", limb),
      el("button", { type: "button", "aria-label": "Fewer seconds", onclick: () => curves.zoom(-1) }, "+"),
      el("button", { type: "button", "aria-label": "More seconds", onclick: () => curves.zoom(1) }, "\u2212"),
      el("span", { class: "soft" }, "shaded: segments; rings: candidates, full ones the first and the last of a hold; click to go there")),
    curves.root);
    if (curve) curves.reload(Number(given.get("t")) || 0);
    return limbs.length ? panel : "";
  }

  const [from, to] = [given.get("from"), given.get("to")].map((it) => (it === null ? NaN : Number(it)));
  if (from < to) {
    staff.range = [from, to];
    selected([from, to]);
    player.loop = true;
  }
  player.seek(Number(given.get("t") ?? (from < to ? from : 0)) || 0);
  if (from < to) player.play();
  void embody();
  return () => {
    clearTimeout(telling);
    player.dispose();
    staff.dispose();
    curves.dispose();
    figure?.dispose();
    if (motion instanceof Motion) motion.abort();
  };
}

/**
 * Return a path without the folder that all captures share.
 * @param {string} path
 * @param {string} folder
 */
function shortened(path, folder) {
  return folder && path.startsWith(folder) && path.length > folder.length ? path.slice(folder.length).replace(/^\//, "") : path;
}

/** @param {string[]} warnings */
function doubts(warnings) {
  if (!warnings.length) return "";
  return el("details", {}, el("summary", {}, counted(warnings.length, "doubt")), ...warnings.map((it) => el("p", {}, it)));
}

/**
 * Return what is played where there is no figure: the staff alone, if it is not to wait.
 * @param {number} seconds
 * @param {boolean} ready
 */
function still(seconds, ready = true) {
  return { seconds, ready: (/** @type {number} */ _) => ready, failure: (/** @type {number} */ _) => null, retry: () => {} };
}
