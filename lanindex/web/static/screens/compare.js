// The screen of two captures in step: two figures, two staves, one clock, and in what they differ.

import { address, get, isAbort, problemOf } from "../api.js";
import { announce, counted, duration, el, readOut, svg, trouble } from "../dom.js";
import { Figure } from "../figure.js";
import { Motion } from "../motion.js";
import { nameOf } from "../names.js";
import { picker } from "../picker.js";
import { Player, playerBar, playerKeys } from "../player.js";
import { StaffView, along } from "../staff.js";

/**
 * @typedef {import("../app.js").App} App
 * @typedef {{direction: string | null, level: string | null, amount?: number, start: number, end: number}} Timed
 * @typedef {{part: string, difference: string, one: Timed | null, other: Timed | null, change: string}} Difference
 * @typedef {{capture: string, capture_id: number, label: string, seconds: number}} Capture
 * @typedef {{captures: [Capture, Capture], same: number, parts: string[], columns: string[], only: [string[], string[]], all: number, differences: Difference[]}} Comparison
 * @typedef {{capture: Capture, motion: Motion | null, figure: Figure | null, staff: StaffView, strokes: import("../look.js").Stroke[], floor: number | null}} Side
 */

const NAMES = ["A", "B"];
const WAYS = { "": "from the beginning", length: "by length", movement: "by movement" }; // in which B is in step with A

/** @param {App} app */
export async function show(app) {
  const { main, url, signal } = app, given = url.searchParams;
  const numbers = ["a", "b"].map((name) => given.get(name) ?? "");
  /** @type {import("../api.js").Problem[]} */
  const problems = [];
  const chosen = /** @type {(Capture | null)[]} */ (await Promise.all(numbers.map((it) => it ? get(`/api/captures/${encodeURIComponent(it)}`, signal).catch((error) => {
    if (isAbort(error)) throw error;
    problems.push(problemOf(error));
    return null;
  }) : null)));
  const way = el("select", {}, ...Object.entries(WAYS).map(([value, text]) => el("option", { value, selected: value === given.get("step") }, text)));
  /** @type {[number[], number[]] | null} seconds of A, and those of B that belong to them; null: the same */
  let times = null;
  const out = el("div", {});
  /** @type {Player | null} */
  let player = null;
  let first = Number(given.get("t")) || 0; // where it begins
  main.append(
    el("h1", {}, "Compare"),
    el("div", { class: "row" }, ...numbers.map((_, at) => picker({ name: NAMES[at], chosen: chosen[at], signal, choose: (it) => choose(at, it.capture_id) })),
      el("label", {}, "In step ", way)),
    out);
  for (const problem of problems) out.append(trouble(problem));
  if (!chosen.every(Boolean)) {
    const [one, other] = chosen.map(Boolean);
    if (!problems.length) out.append(el("p", { class: "soft" }, one || other ? `Choose ${one ? "B" : "A"}, too: they play in step, and what differs is listed.` : "Choose two captures or scores: they play in step, and what differs is listed."));
    /** @type {HTMLElement | null} */ (main.querySelectorAll(".picker input")[one ? 1 : 0])?.focus();
    return;
  }
  try {
    /** @type {Comparison} */
    const found = await get(address("/api/compare", { a: numbers[0], b: numbers[1] }), signal);
    await play(found);
  } catch (error) {
    if (!isAbort(error)) out.replaceChildren(trouble(problemOf(error)));
  }

  /** @param {number} at @param {number} number */
  function choose(at, number) {
    numbers[at] = String(number);
    app.go(address("/compare", { a: numbers[0], b: numbers[1], step: way.value }));
  }

  /** @param {Comparison} found */
  async function play(found) {
    const stage = el("div", { class: "pair" }), bars = el("div", {});
    const root = el("div", {}, stage, bars);
    out.replaceChildren(root, listed(found));
    await step(found, bars);
    const sides = await Promise.all(found.captures.map((capture, at) => side(found, capture, at, stage)));
    const [one, two] = sides;
    const seconds = () => times ? one.capture.seconds : Math.max(one.capture.seconds, two.capture.seconds);
    /** @type {(at: number, of: number) => number} */
    const own = (at, of) => Math.min(of && times ? along(at, ...times) : at, sides[of].capture.seconds);
    const moving = sides.map((it) => it.motion);
    const clock = player = new Player({
      get seconds() { return seconds(); },
      ready: (at) => moving.map((motion, of) => !motion || motion.ready(own(at, of))).every(Boolean),
      failure: (at) => moving.map((motion, of) => motion?.failure(own(at, of)) ?? null).find(Boolean) ?? null,
      retry: () => moving.forEach((motion) => motion?.retry()),
    }, 60);
    let told = Number(given.get("t")) || 0;
    for (const motion of moving) if (motion) motion.changed = () => clock.refresh();
    clock.listen((at) => {
      sides.forEach(({ motion, figure, staff, strokes }, of) => {
        const mine = own(at, of), pose = motion?.pose(mine);
        if (figure && pose) figure.show([{ strokes, pose }]);
        staff.show(mine);
      });
      if (!clock.playing && Math.abs(at - told) > 0.005) {
        told = at;
        tell();
      }
    });
    sides.forEach((it, of) => { it.staff.seek = (at) => clock.seek(of ? there(at) : at); });
    way.addEventListener("change", () => step(found, bars).then(() => {
      clock.range = null;
      clock.seek(Math.min(clock.seconds, seconds()));
      tell();
    }).catch((error) => {
      if (!isAbort(error)) throw error;
    }));
    bars.append(playerBar(clock));
    playerKeys(root, clock);
    clock.seek(first);
    readOut(summary(found));
    signal.addEventListener("abort", () => {
      clock.dispose();
      for (const { motion, figure, staff } of sides) {
        motion?.abort();
        figure?.dispose();
        staff.dispose();
      }
    });

    function tell() {
      app.replace(address("/compare", { a: numbers[0], b: numbers[1], step: way.value, t: told ? told.toFixed(3) : "" }));
    }
  }

  /** Find which seconds belong together, or say in `bars` why that is not known. @param {Comparison} found @param {HTMLElement} bars */
  async function step({ captures: [one, two] }, bars) {
    bars.querySelector(".trouble")?.remove();
    times = way.value === "length" ? [[0, one.seconds], [0, two.seconds]] : null;
    if (way.value !== "movement") return;
    try {
      times = (await get(address("/api/compare/step", { a: numbers[0], b: numbers[1] }), signal)).times;
    } catch (error) {
      if (isAbort(error)) throw error;
      bars.append(trouble(problemOf(error)));
    }
  }

  /** Return where in A something of B is. @param {number} at seconds of B */
  function there(at) {
    return times ? along(at, times[1], times[0]) : at;
  }

  /**
   * @param {Comparison} found
   * @param {Capture} capture
   * @param {number} at
   * @param {HTMLElement} stage
   * @returns {Promise<Side & {staff: StaffView & {seek: (at: number) => void}}>}
   */
  async function side(found, capture, at, stage) {
    const path = `/api/captures/${capture.capture_id}`, canvas = el("canvas", { class: "figure" }), strip = el("div", {});
    stage.append(el("section", { class: "card", "aria-label": NAMES[at] },
      el("h2", {}, `${NAMES[at]}: `, el("a", { href: `/captures/${capture.capture_id}`, class: "path" }, capture.capture.split("/").pop())),
      el("p", { class: "soft num" }, [capture.label, duration(capture.seconds)].filter(Boolean).join(", ")),
      el("div", { class: "two" }, canvas, strip)));
    const differ = new Set(found.differences.flatMap((it) => {
      const timed = at ? it.other : it.one;
      return timed ? [`${it.part} ${timed.start.toFixed(2)}`] : [];
    }));
    const staff = /** @type {any} */ (new StaffView(strip, {
      seconds: capture.seconds,
      load: (from, to, zoom) => get(address(`${path}/staff`, { from, to, zoom, parts: found.columns.join(",") }), signal),
      parse: (text) => {
        const drawn = svg(text);
        for (const node of drawn.querySelectorAll("g[data-part]")) {
          const { part, start } = /** @type {SVGElement} */ (node).dataset;
          node.classList.toggle("differs", differ.has(`${part} ${Number(start).toFixed(2)}`));
        }
        return drawn;
      },
      seek: (seconds) => staff.seek(seconds),
      pick: (symbol) => announce(symbol.querySelector("title")?.textContent ?? ""),
      select: () => {},
    }));
    staff.seek = () => {};
    try {
      const description = await get(`${path}/figure`, signal), figure = new Figure(canvas, { label: `The figure of ${NAMES[at]}` });
      figure.floor = description.floor;
      return { capture, motion: new Motion(path, description), figure, staff, strokes: description.strokes, floor: description.floor };
    } catch (error) {
      if (isAbort(error)) throw error;
      canvas.replaceWith(trouble(problemOf(error)));
      return { capture, motion: null, figure: null, staff, strokes: [], floor: null };
    }
  }

  /** @param {Comparison} found */
  function listed(found) {
    const more = found.all - found.differences.length;
    return el("section", { class: "guide differences" },
      el("h2", {}, "Differences"),
      el("p", {}, summary(found)),
      ...found.only.map((parts, at) => parts.length > 0 && el("p", { class: "soft" }, `Only ${NAMES[at]} tells of ${parts.map(nameOf).join(", ")}.`)),
      found.differences.length > 0 && el("div", { class: "scrolled", tabindex: 0, role: "group", "aria-label": "Differences" }, el("table", {},
        el("thead", {}, el("tr", {}, ...["part", "A", "seconds", "B", "seconds", "B is"].map((it) => el("th", { scope: "col" }, it)))),
        el("tbody", {}, ...found.differences.map((it) => el("tr", {},
          el("td", {}, nameOf(it.part)), ...cells(it.one, (at) => at), ...cells(it.other, there), el("td", {}, it.change)))))),
      more > 0 && el("p", { class: "soft" }, `and ${more.toLocaleString("en")} more`));
  }

  /** @param {Timed | null} timed @param {(at: number) => number} place where it is in A */
  function cells(timed, place) {
    if (!timed) return [el("td", {}), el("td", {})];
    const words = nameOf([timed.direction, timed.level, timed.amount].filter((it) => it !== null && it !== undefined).join(" ")) || "\u2014";
    return [el("td", {}, words), el("td", { class: "num" }, el("button", { type: "button", class: "plain", title: "Go there", onclick: () => {
      first = place(timed.start);
      player?.pause();
      player?.seek(first);
    } }, `${timed.start.toFixed(2)}\u2013${timed.end.toFixed(2)}`))];
  }

  /** @param {Comparison} found */
  function summary({ all, same, parts }) {
    return `${counted(all, "difference")} in ${counted(parts.length, "track")}, ${counted(same, "symbol")} the same.`;
  }
}
