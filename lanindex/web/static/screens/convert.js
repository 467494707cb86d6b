// The screen Convert: a capture's limbs written down with other numbers, before and after.

import { address, get, isAbort, problemOf, send } from "../api.js";
import { announce, counted, el, svg, trouble } from "../dom.js";
import { Draft, fellow } from "../draft.js";
import { Figure, spaceDrawer } from "../figure.js";
import { Motion } from "../motion.js";
import { nameOf } from "../names.js";
import { picker } from "../picker.js";
import { fieldsOf } from "../profile_fields.js";
import { Player, playerBar, playerKeys } from "../player.js";
import { SphereView } from "../sphere.js";
import { StaffView } from "../staff.js";

/**
 * @typedef {import("../app.js").App} App
 * @typedef {import("./library.js").Capture & {parts: Record<string, number>, moves: boolean}} Capture
 * @typedef {import("../draft.js").Profile} Profile
 * @typedef {import("../staff.js").Piece} Piece
 * @typedef {{part: string, kind: string, before: [string, number, number] | null, after: [string, number, number] | null}} Difference
 * @typedef {{before: Piece, after: Piece, same: number, changed: number, kinds: Record<string, number>, differences: Difference[], rules: Record<string, number[]>, speed: number, rhythm: string, division: number}} Converted
 */

const WAY = 60; // seconds of the limb's way that are held
const TRAILS = [1, 3, 10, 30];

/** @param {App} app */
export async function show(app) {
  const { main, url, signal, library } = app;
  main.classList.add("convert");
  const given = new URLSearchParams(url.search);
  const number = given.get("capture") ?? await first(signal);
  if (!number) {
    main.append(el("h1", {}, "Convert"), el("p", {}, "There is no capture of a movement in this library yet."));
    return;
  }
  const path = `/api/captures/${number}`;
  const [capture, names] = /** @type {[Capture, string[]]} */ (await Promise.all([get(path, signal), get("/api/profiles", signal).then((it) => it.profiles)]));
  const other = picker({ name: "Capture", chosen: capture, moving: true, signal, choose: (it) => {
    const now = new URLSearchParams(location.search);
    app.go(address("/convert", { capture: it.capture_id, ...Object.fromEntries(["part", "profile", "alike", "changes"].map((kept) => [kept, now.get(kept)])) }));
  } });
  if (!capture.moves) {
    main.append(el("h1", {}, "Convert"), other, el("p", {}, `${capture.capture} is a score, which has no movement: choose a capture of a movement.`));
    return;
  }
  const others = Object.fromEntries(await Promise.all(["default", "paper"].map(async (it) => [it, await get(`/api/profiles/${it}`, signal)])));
  const wanted = given.get("profile") ?? "default", chosen = names.includes(wanted) ? wanted : "default";
  const draft = new Draft(others[chosen] ?? await get(address(`/api/profiles/${encodeURIComponent(chosen)}`, {}), signal));
  draft.restore(given.get("changes") ?? "{}");
  const parts = Object.keys(draft.profile.spaces).filter((it) => capture.parts[it]);
  let part = parts.includes(given.get("part") ?? "") ? given.get("part") ?? "" : parts[0], alike = given.get("alike") !== "no";
  app.title(`Convert ${capture.capture.split("/").pop() ?? ""}`);

  const sphereCanvas = el("canvas", { class: "sphere" }), figureCanvas = el("canvas", { class: "figure" });
  const [beforeRoot, afterRoot] = [el("div", {}), el("div", {})];
  const words = el("p", { class: "num now" }), summary = el("p", { class: "summary", role: "status" }), problems = el("div", {});
  const fields = el("div", { class: "fields" }), list = el("details", { class: "differences" }), bars = el("div", { class: "bars" });
  const partSelect = el("select", { onchange: () => choose(partSelect.value) }, ...parts.map((it) => el("option", { value: it, selected: it === part }, nameOf(it))));
  const both = el("input", { type: "checkbox", checked: alike, onchange: () => { alike = both.checked; tell(); } });
  const profileSelect = el("select", { onchange: () => take(profileSelect.value) }, ...names.map((it) => el("option", { value: it, selected: it === chosen }, it)));
  const undo = el("button", { type: "button", "aria-keyshortcuts": "Control+Z", title: "Ctrl-Z", onclick: () => draft.undo() }, "Undo");
  const redo = el("button", { type: "button", "aria-keyshortcuts": "Control+Shift+Z", title: "Ctrl-Shift-Z", onclick: () => draft.redo() }, "Redo");
  const reset = el("button", { type: "button", onclick: () => draft.reset() }, "Reset all");
  const trail = el("select", { onchange: () => { sphere.trail = Number(trail.value); sphere.later(); } }, ...TRAILS.map((it) => el("option", { value: it, selected: it === 3 }, `\u00b1 ${it} s`)));
  const reach = el("input", { type: "checkbox", checked: true, onchange: () => { sphere.reaching = reach.checked; sphere.later(); } });
  main.append(
    el("h1", {}, "Convert"),
    el("div", { class: "row top-row" },
      other,
      el("label", {}, "Part ", partSelect),
      el("label", {}, both, " both sides alike"),
      el("label", {}, "Profile ", profileSelect),
      undo, redo, reset),
    problems,
    el("div", { class: "views" },
      el("section", { class: "cells", "aria-label": "Cells" }, sphereCanvas, words,
        el("div", { class: "row soft" }, el("label", {}, "Way shown ", trail), el("label", { title: "The nearer the limb, the wider is place on it" }, reach, " sphere at the limb\u2019s reach"))),
      el("section", { class: "side" }, el("h2", {}, "Movement"), figureCanvas),
      el("section", { class: "side" }, el("h2", {}, "Before", el("span", { class: "soft" }, " as the library has it")), beforeRoot),
      el("section", { class: "side" }, el("h2", {}, "After", el("span", { class: "soft" }, " with the numbers below")), afterRoot)),
    bars, summary, list, fields);

  // what moves: one clock for the figure, the sphere and both staves
  const description = await get(`${path}/figure`, signal).catch((error) => {
    if (!isAbort(error)) figureCanvas.replaceWith(trouble(problemOf(error)));
    return null;
  });
  const motion = description ? new Motion(path, description, undefined, 24) : null;
  const player = new Player(motion ?? { seconds: capture.seconds, ready: () => true, failure: () => null, retry: () => {} }, description?.rate ?? capture.fps);
  const figure = description ? new Figure(figureCanvas, { label: "The figure", space: await spaceDrawer() }) : null;
  if (figure) figure.floor = description.floor;
  if (motion) motion.changed = () => player.refresh();
  const sphere = new SphereView(sphereCanvas, { move: (border, value, done) => form.move(border, value, done) });

  let round = new AbortController(), told = 0, wayFrom = -1, saying = 0;
  /** @type {Map<string, Promise<Converted>>} */
  let answers = new Map();

  /** What the server is asked with. */
  const body = () => ({ profile: draft.profile.name, changes: draft.changes });

  /** @param {number} from @param {number} to @param {number} zoom @returns {Promise<Converted>} */
  function converted(from, to, zoom) {
    const key = `${from} ${to} ${zoom}`, known = answers.get(key);
    if (known) return known;
    const pair = fellow(part), shown = pair !== part && parts.includes(pair) ? [part, pair].sort() : [part];
    const answer = /** @type {Promise<Converted>} */ (send("POST", `${path}/encode`, { ...body(), parts: shown, from, to, zoom, own_tempo: !("speed" in draft.changes.parameters || "rhythm" in draft.changes.parameters) }, round.signal));
    answers.set(key, answer);
    answer.then(result, failed);
    return answer;
  }

  /** @param {"before" | "after"} side @param {HTMLElement} root */
  function staffOf(side, root) {
    const view = new StaffView(root, {
      seconds: capture.seconds,
      load: async (from, to, zoom) => (await converted(from, to, zoom))[side],
      parse: svg,
      seek: (at) => player.seek(at),
      pick: (symbol) => announce(symbol.querySelector("title")?.textContent ?? ""),
      select: () => {},
    });
    root.setAttribute("aria-label", `${side === "before" ? "Before" : "After"}. ${root.getAttribute("aria-label")}`);
    return view;
  }
  const staves = [staffOf("before", beforeRoot), staffOf("after", afterRoot)];

  /** @param {Converted} found */
  function result(found) {
    problems.replaceChildren();
    const all = found.changed + found.same, kinds = Object.entries(found.kinds).map(([kind, count]) => `${count} ${kind}`).join(", ");
    summary.replaceChildren(
      el("strong", {}, found.changed ? `${counted(found.changed, "symbol")} changed` : "No symbol changed"),
      found.changed ? ` of ${all}: ${kinds}` : ` of ${all}`,
      el("span", { class: "soft" }, `; counted at ${found.speed} beats a minute, ${found.rhythm}, ${counted(found.division, "tick")} a bar`));
    clearTimeout(saying);
    form.used(found.rules[part] ?? []);
    const rows = found.differences.map((it) => {
      const at = it.after ?? it.before, time = at ? at[1] : 0;
      return el("tr", {},
        el("td", {}, el("button", { type: "button", class: "plain num", "aria-label": `Go to ${time.toFixed(2)} s`, onclick: () => player.seek(time) }, `${time.toFixed(2)} s`)),
        el("td", {}, nameOf(it.part)), el("td", {}, said(it.before)), el("td", {}, said(it.after)), el("td", {}, it.kind));
    });
    const open = list.open;
    list.hidden = !rows.length;
    list.replaceChildren(el("summary", {}, rows.length < found.changed ? `The first ${rows.length} differences` : counted(rows.length, "difference")),
      el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Differences" },
        el("table", {}, el("thead", {}, el("tr", {}, ...["Time", "Part", "Before", "After", "What"].map((it) => el("th", { scope: "col" }, it)))), el("tbody", {}, ...rows))));
    list.open = open;
  }

  /** @param {unknown} error */
  function failed(error) {
    if (!isAbort(error)) problems.replaceChildren(trouble(problemOf(error)));
  }

  /** Write down anew: both staves show what comes, and until then what they have. */
  function convert() {
    round.abort();
    round = new AbortController();
    signal.addEventListener("abort", () => round.abort(), { once: true });
    answers = new Map();
    for (const staff of staves) staff.reload();
  }

  let shownWay = "";
  /** Fetch the limb's way around the present, unless it is there. */
  async function walk() {
    const from = Math.max(Math.floor(player.seconds / WAY) * WAY - 5, 0), calm = [draft.parameter("rate"), draft.parameter("smoothing")];
    const key = JSON.stringify([part, from, ...calm]);
    if (key === shownWay) return;
    shownWay = key;
    try {
      const way = await send("POST", `${path}/way`, { ...body(), part, from, to: from + WAY + 10 }, signal);
      if (key !== shownWay) return;
      wayFrom = from;
      form.length = way.length;
      sphere.way = way;
      player.refresh();
    } catch (error) {
      failed(error);
    }
  }

  const form = fieldsOf(fields, {
    draft: () => draft,
    part: () => part,
    alike: () => alike,
    others,
    mark: (border) => { sphere.marked = border; },
    tempo: async () => {
      const found = await send("POST", `${path}/tempo`, body(), signal);
      announce(found.speed ? found.says : `No tempo: ${found.says}`);
      if (found.speed) draft.setParameter("speed", found.speed);
      return found.says;
    },
    readonly: library.readonly,
    save: (name, replace) => save(name, replace),
    encoded: () => {
      app.refresh();
      convert();
    },
  });

  /** @type {import("../draft.js").Profile | null} whose fields are shown */
  let shown = null;
  function changed() {
    if (shown === draft.profile) form.update();
    else form.build();
    shown = draft.profile;
    profileSelect.value = shown.name;
    sphere.space = draft.space(part);
    undo.disabled = !draft.canUndo;
    redo.disabled = !draft.canRedo;
    reset.disabled = !draft.touched;
    convert();
    walk();
    tell();
  }
  draft.changed = changed;

  /** @param {string} name */
  function choose(name) {
    part = name;
    both.disabled = fellow(part) === part;
    shown = null;
    changed();
  }

  /** @param {string} name */
  async function take(name) {
    try {
      draft.take(others[name] ?? await get(`/api/profiles/${encodeURIComponent(name)}`, signal));
    } catch (error) {
      failed(error);
    }
  }

  /** @param {string} name @param {boolean} replace */
  async function save(name, replace) {
    const saved = await send("POST", "/api/profiles", { name, ...body(), replace }, signal);
    announce(`The profile ${saved.name} is saved.`);
    if (![...profileSelect.options].some((it) => it.value === saved.name)) profileSelect.append(el("option", { value: saved.name }, saved.name));
    profileSelect.value = saved.name;
    delete others[saved.name];
    await take(saved.name);
    draft.forget();
    return saved;
  }

  /** Keep in the address what is shown. */
  function tell() {
    const changes = draft.touched ? JSON.stringify(draft.changes) : "";
    app.replace(address("/convert", { capture: number, part, profile: draft.profile.name === "default" ? "" : draft.profile.name, alike: alike ? "" : "no", t: told ? told.toFixed(2) : "", changes }));
  }

  player.listen((at) => {
    const pose = motion?.pose(at);
    if (figure && pose) figure.show([{ strokes: description.strokes, pose, lit: new Set([part]) }]);
    for (const staff of staves) staff.show(at);
    sphere.show(at);
    if (words.textContent !== sphere.words) words.textContent = sphere.words;
    if (wayFrom >= 0 && (at < wayFrom || at > wayFrom + WAY + 5)) walk();
    if (!player.playing && Math.abs(at - told) > 0.005) {
      told = at;
      tell();
    }
  });
  bars.append(playerBar(player));
  playerKeys(main, player);
  main.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey || event.key.toLowerCase() !== "z") return;
    if (event.shiftKey) draft.redo();
    else draft.undo();
    event.preventDefault();
  }, { signal });

  choose(part);
  player.seek(Number(given.get("t") ?? 0) || 0);
  return () => {
    round.abort();
    player.dispose();
    for (const staff of staves) staff.dispose();
    sphere.dispose();
    figure?.dispose();
    motion?.abort();
    form.dispose();
  };
}

/** @param {[string, number, number] | null} symbol */
function said(symbol) {
  return symbol ? `${nameOf(symbol[0])} ${symbol[1].toFixed(2)}\u2013${symbol[2].toFixed(2)} s` : "\u2013";
}

/**
 * Return the number of the first capture of a movement.
 * @param {AbortSignal} signal
 */
async function first(signal) {
  const found = await get("/api/captures/fitting?moving=true", signal);
  return found.captures[0]?.capture_id;
}
