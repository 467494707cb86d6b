// The screen on which a score is written and changed, and the standard figure carries it out.

import { address, ask, get, isAbort, problemOf, send } from "../api.js";
import { announce, counted, duration, el, trouble } from "../dom.js";
import { Palette } from "../edit/palette.js";
import { Paper } from "../edit/paper.js";
import { Picture, linked } from "../edit/picture.js";
import { blank, changed, end, grain, inMeter, later, mirrored, ofBars, packed, part, placeOf, short, stretched, told, trackOf, unpacked } from "../edit/score.js";
import { Stage } from "../edit/stage.js";
import { Figure, spaceDrawer } from "../figure.js";
import { nameOf } from "../names.js";
import { picker } from "../picker.js";
import { Player, playerBar } from "../player.js";
import { asked } from "./library/editing.js";

/** @typedef {import("../app.js").App} App */
/** @typedef {import("../edit/score.js").Score} Score */
/** @typedef {import("../edit/score.js").Sign} Sign */
/** @typedef {import("../edit/paper.js").Cell} Cell */
/** @typedef {{part: string, difference: string, one: {start: number, direction: string | null, level: string | null} | null, other: {start: number, direction: string | null, level: string | null} | null}} Difference */

const USUAL = ["l_arm", "l_leg", "l_support", "r_support", "r_leg", "r_arm", "torso", "head", "body_turn", "jump"];
const GRIDS = [["1", 1], ["1/2", 1 / 2], ["1/3", 1 / 3], ["1/4", 1 / 4], ["1/6", 1 / 6], ["1/8", 1 / 8]];
const LENGTHS = [["a position", 0], ["1/4 beat", 1 / 4], ["1/2 beat", 1 / 2], ["1 beat", 1], ["2 beats", 2], ["3 beats", 3], ["4 beats", 4]];
const KEPT = 200; // edits that can be undone
const FASTER = 4; // beats a minute of a key
const KEYS = [
  ["arrows", "move the cursor; Page up, Page down a bar; Home, End"], ["1 to 9", "write a direction, as they lie on the number keys"],
  ["H M L", "high, middle, low"], ["[ ]", "degrees"], ["Enter", "write what the palette shows"], ["Shift + up, down", "the end later, earlier"],
  ["Shift + left, right", "the beginning earlier, later"], ["Alt + arrows", "move"], ["Delete", "take away"], ["Shift + M", "mirror"],
  ["Ctrl + C, X, V, A", "copy, cut, paste at the cursor, all"], ["Ctrl + arrows, Ctrl + Enter", "move the cursor alone, choose one more or one less"], ["Ctrl + Z, Ctrl + Shift + Z", "undo, redo"], ["+ -", "tempo"], ["Space", "play from the cursor"], ["Escape", "choose nothing"],
];

/** @param {App} app */
export async function show(app) {
  const { main, url, library, signal } = app;
  /** @type {import("../edit/score.js").Alphabet} */
  const alphabet = await get("/api/scores/alphabet", signal);
  const capture = url.searchParams.get("capture"), draft = `lanindex-edit ${library.name} ${url.search}`;
  let { score, title, left, checked } = await opened();
  /** @type {Picture | null} what the score was read from */
  let picture = null;
  /** @type {Sign[]} */
  let selection = [];
  /** @type {Cell} */
  let cell = { part: "r_arm", tick: 0 };
  /** @typedef {{score: Score, selection: Sign[]}} State */
  const done = /** @type {State[]} */ ([]), undone = /** @type {State[]} */ ([]);
  /** @type {Sign[]} */
  let copied = [];
  const shown = new Set(USUAL);
  let lasting = 1, each = 1 / 2;
  app.title(title);

  /** @returns {Promise<{score: Score, title: string, left: string[] | null, checked: string[]}>} left: tracks of the capture that are not shown; null: it is a draft */
  async function opened() {
    const kept = stored(draft);
    if (kept) return { checked: [], ...kept, left: null };
    if (!capture) return { score: blank(), title: "new score", left: [], checked: [] };
    const query = Object.fromEntries(["from", "to", "detail"].map((it) => [it, url.searchParams.get(it)]));
    const found = await get(address(`/api/scores/captures/${encodeURIComponent(capture)}`, query), signal);
    const own = unpacked(found.score), name = found.title.split("/").pop();
    return { score: isPicture(name) ? linked(own) : own, title: name.replace(/\.[^.]*$/, ""), left: found.left_out, checked: [] };
  }

  /** @param {string} name of a file */
  function isPicture(name) {
    return alphabet.pictures.some((it) => name.toLowerCase().endsWith(it));
  }

  /** Say what is opened, where it is not all of it. */
  function notice() {
    if (left === null) {
      return el("p", { class: "row soft" }, "This is the draft that this browser keeps. ", tool("Begin again", "", () => {
        forget(draft);
        app.go(url.pathname + url.search);
      }));
    }
    if (!left.length) return null;
    const all = new URL(url);
    all.searchParams.set("detail", "full");
    return el("p", { class: "soft" }, `Without ${left.map(nameOf).join(", ")}: the figure would follow those and not the whole limbs. `, el("a", { href: all.pathname + all.search }, "Open all tracks"));
  }

  const state = el("p", { class: "edit-state", role: "status" }), problems = el("div", { class: "edit-problems" }), cannot = el("div", {});
  const sheet = el("div", { class: "edit-paper", tabindex: 0, role: "application", "aria-label": "The staff. Arrow keys move the cursor, 1 to 9 write a direction, H, M and L its level, Enter writes, Delete takes away; all keys are told below it." });
  const board = el("div", { class: "edit-palette", role: "group", "aria-label": "Signs" }), heading = el("h2", {});
  const palette = new Palette(board, alphabet, (words, at) => {
    const { kind } = trackOf(cell.part, alphabet), own = selection.filter((it) => trackOf(it.part, alphabet).kind === kind);
    if (own.length) commit(own, own.map((it) => ({ ...it, words: it.words.map((word, place) => (place === at ? words[at] : word)) })), own.length > 1);
    else if (keyed && trackOf(cell.part, alphabet).fields[at].field !== "level") write();
    else look();
  });
  let keyed = false;

  const name = el("input", { value: title, "aria-label": "Name", class: "grow", maxlength: 80 });
  const tempo = el("input", { type: "number", min: 1, max: 1000, step: "any", class: "num" });
  const beats = el("input", { type: "number", min: 1, max: 99, class: "num" }), beat = el("select", {}, ...[1, 2, 4, 8, 16].map((it) => el("option", {}, it)));
  const bars = el("input", { type: "number", min: 1, max: 5000, class: "num" });
  const undo = tool("Undo", "Control+z", back), redo = tool("Redo", "Control+Shift+z", forth);
  const notation = el("select", { "aria-label": "Notation" }, ...alphabet.notations.map((it) => el("option", { value: it.name }, `${it.title} (${it.suffix})`)));
  /** @type {import("../picker.js").Capture | null} */
  let against = capture ? await get(`/api/captures/${encodeURIComponent(capture)}`, signal).catch((error) => {
    if (isAbort(error)) throw error;
    announce(problemOf(error).found); // a draft outlives its capture
    return null;
  }) : null;
  const compare = tool("Compare with it", "", diff, !against);
  const found = el("div", { class: "edit-found" });
  const boxes = new Map(alphabet.tracks.map(({ part: own }) => [own, el("input", { type: "checkbox", onchange: () => {
    if (!shown.delete(own)) shown.add(own);
    lanes();
    paper.draw();
  } })]));
  const columns = el("fieldset", { class: "edit-columns" }, el("legend", { class: "hidden" }, "Columns"),
    ...[...boxes].map(([own, box]) => el("label", {}, box, ` ${nameOf(own)}`)));
  const canvas = el("canvas", { class: "figure edit-waits" });
  const file = el("input", { type: "file", hidden: true, accept: [...alphabet.notations.filter((it) => it.text).map((it) => it.suffix), ...alphabet.pictures].join(",") });
  const pair = el("div", { class: "edit-pair" }, sheet), side = el("div", { class: "edit-beside" });
  const pictureSize = el("label", { hidden: true }, "Picture ", select([["100 %", 1], ["150 %", 1.5], ["200 %", 2], ["300 %", 3]], 1, (it) => { if (picture) picture.scale = it; }));

  main.classList.add("edit");
  main.append(
    el("div", { class: "row edit-top" }, el("h1", {}, "Edit"), name,
      tool("New", "", fresh), tool("Open a file", "", () => file.click()), file, undo, redo,
      tool("Copy", "Control+c", copy), tool("Paste", "Control+v", paste), tool("Mirror", "Shift+m", mirror), tool("Delete", "Delete", take)),
    el("div", { class: "row edit-top" },
      el("label", {}, "Tempo ", tempo), el("label", {}, "Metre ", beats), el("label", {}, " / ", beat), el("label", {}, "Bars ", bars),
      el("label", {}, "Grid ", select(GRIDS, each, (it) => { each = it; cell = snapped(cell); look(); })),
      el("label", {}, "Length ", select(LENGTHS, lasting, (it) => { lasting = it; })),
      el("label", {}, "Size ", select([["100 %", 1], ["150 %", 1.5], ["200 %", 2], ["300 %", 3]], 1.5, (it) => { paper.scale = it; paper.draw(); })), pictureSize),
    notice() ?? "", problems,
    el("div", { class: "edit-body" },
      el("section", { class: "edit-side", "aria-label": "Signs" }, heading, board, side,
        el("details", {}, el("summary", {}, "Columns"), columns),
        el("details", {}, el("summary", {}, "Keys"), el("dl", { class: "edit-keys" }, ...KEYS.flatMap(([key, what]) => [el("dt", {}, key), el("dd", {}, what)])))),
      el("section", { class: "edit-middle", "aria-label": "Staff" }, pair, state),
      el("section", { class: "edit-side", "aria-label": "Figure" }, el("div", { class: "edit-figure" }, canvas), cannot, el("div", { class: "edit-player" }),
        el("div", { class: "card edit-acts" },
          el("div", { class: "row" }, notation, tool("Save", "", save)),
          el("div", { class: "row" }, tool("Put into the library", "", store, library.readonly), tool("Search for it", "", search)),
          el("div", { class: "row" }, picker({ name: "Capture", chosen: against, signal, choose: (it) => {
            against = it;
            compare.disabled = false;
            diff();
          } }), compare),
          found))));

  const figure = new Figure(canvas, { label: "The figure that carries out the score", space: await spaceDrawer() });
  const stage = new Stage(), player = new Player(stage, 30);
  main.querySelector(".edit-player")?.append(playerBar(player));
  const paper = new Paper(sheet, {
    state: () => ({ score, selection, cell, step: step() }),
    press(at, sign, more) {
      if (sign && more) choose(selection.includes(sign) ? selection.filter((it) => it !== sign) : [...selection, sign], at);
      else if (sign) choose([sign], at);
      else {
        choose([], at);
        write();
      }
    },
    take: (signs) => choose(signs, cell),
    move,
    stretch,
    fail: (problem) => problems.replaceChildren(trouble(problem)),
    drawn() {
      problems.replaceChildren();
      placed();
    },
  });
  player.listen((seconds, { playing }) => {
    const body = stage.body(seconds);
    figure.floor = stage.floor;
    if (body) figure.show([body]);
    canvas.classList.toggle("edit-waits", !figure.drawn);
    paper.play(playing ? seconds : null);
    if (playing) stage.play();
  });
  stage.changed = () => {
    player.range = null; // all of it, which may be longer now
    const left = stage.warnings.map((it) => el("p", { class: "soft" }, it));
    cannot.replaceChildren(stage.problem ? trouble(problemOf(stage.problem)) : "");
    main.querySelector(".edit-warnings")?.remove();
    if (left.length) main.querySelector(".edit-acts")?.append(el("details", { class: "edit-warnings" }, el("summary", {}, `The figure could not do ${counted(left.length, "thing")}`), ...left));
  };

  /**
   * @param {string} text
   * @param {string} key
   * @param {() => void} press
   * @param {boolean} [off]
   */
  function tool(text, key, press, off = false) {
    return el("button", { type: "button", onclick: press, disabled: off, "aria-keyshortcuts": key || null, title: key && key.replaceAll("Control", "Ctrl") }, text);
  }

  /** @param {(string | number)[][]} values @param {number} now @param {(value: number) => void} take */
  function select(values, now, take) {
    const node = el("select", {}, ...values.map(([text, value]) => el("option", { value, selected: value === now }, text)));
    node.addEventListener("change", () => take(Number(node.value)));
    return node;
  }

  function step() {
    return Math.max(1, Math.round(grain(score) * each));
  }

  /** @param {Cell} at @returns {Cell} */
  function snapped(at) {
    return { ...at, tick: at.tick < 0 ? -1 : Math.floor(at.tick / step() + 1e-6) * step() };
  }

  /** Return the symbol at the cursor: that of its tick, or one that begins before the next step. */
  function here() {
    const { part: own, tick } = cell, signs = score.symbols.filter((it) => it.part === own && (it.stop === 0) === (tick < 0));
    if (tick < 0) return signs[0];
    return signs.find((it) => it.start <= tick && tick < it.stop || it.start === tick) ?? signs.find((it) => tick < it.start && it.start < tick + step());
  }

  /** Show what is chosen, and tell it. @param {boolean} [alone] the cursor has moved alone */
  function look(alone = false) {
    const track = trackOf(cell.part, alphabet), own = selection.find((it) => it.part === cell.part) ?? selection[0];
    heading.textContent = nameOf(cell.part);
    palette.show(track, own && trackOf(own.part, alphabet).kind === track.kind ? own.words : undefined);
    const sign = here(), under = alone ? sign : own ?? sign;
    let said = under ? told(score, under) : `${nameOf(cell.part)}, ${placeOf(score, cell.tick)}, ${picture?.gap(cell) ? "not known" : "empty"}`;
    if (under && !selection.includes(under)) said += ", not chosen";
    if (alone) said += `, ${selection.length} chosen`;
    else if (selection.length > 1) said = `${counted(selection.length, "symbol")} chosen`;
    if (state.textContent !== said) state.textContent = said;
    const open = picture?.open(score);
    paper.doubtful = open?.doubtful ?? new Set();
    paper.unknown = open?.unknown ?? [];
    picture?.refresh(score, selection, cell);
    undo.disabled = !done.length;
    redo.disabled = !undone.length;
    paper.refresh();
    placed();
  }

  /** Let the figure stand as at the cursor. */
  function placed() {
    if (!player.playing) player.seek(paper.seconds(selection.length === 1 ? selection[0].stop : Math.max(cell.tick, 0)));
  }

  /** @param {Sign[]} signs @param {Cell} at */
  function choose(signs, at) {
    selection = signs;
    cell = at;
    look();
  }

  /** @param {Cell} at @param {boolean} [alone] what is chosen stays */
  function go(at, alone = false) {
    cell = { part: at.part, tick: Math.min(at.tick, end(score) - 1) };
    const sign = here();
    if (alone) look(true);
    else choose(sign ? [sign] : [], cell);
    paper.follow();
  }

  /** Choose the symbol at the cursor, too, or no more. */
  function toggled() {
    const sign = here();
    if (sign) selection = selection.includes(sign) ? selection.filter((it) => it !== sign) : [...selection, sign];
    look(true);
  }

  /** Put symbols in the place of others; they are chosen then. @param {Sign[]} gone @param {Sign[]} come @param {boolean} [many] */
  function commit(gone, come, many = false) {
    become(changed(score, gone, come), come);
    if (many) announce(`${counted(come.length, "symbol")} changed`);
  }

  /** @param {Score} next @param {Sign[]} signs */
  function become(next, signs) {
    done.push({ score, selection });
    if (done.length > KEPT) done.shift();
    undone.length = 0;
    follow(next, signs);
  }

  /** @param {Score} next @param {Sign[]} signs */
  function follow(next, signs) {
    paper.marked = new Set();
    score = next;
    selection = signs;
    cell = { ...cell, tick: Math.min(cell.tick, end(score) - 1) };
    lanes();
    paper.draw(); // both are asked for first: the server works on them while the rest is shown
    stage.perform(score, paper.seconds(Math.max(cell.tick, 0)), player.playing);
    numbers();
    look();
    keep();
  }

  function keep() {
    try {
      const text = JSON.stringify({ score, title: name.value, checked });
      for (const it of [sessionStorage, localStorage]) it.setItem(draft, text);
    } catch {
      announce("This browser has no room for a draft: save the score before you leave.");
    }
  }

  function numbers() {
    tempo.value = short(Number(score.speed));
    beats.value = String(score.beats);
    beat.value = String(score.beat);
    bars.value = String(score.units);
  }

  function lanes() {
    const used = new Set(score.symbols.map((it) => it.part));
    const strange = [...used].filter((it) => !alphabet.tracks.some((track) => track.part === it)).map((it) => trackOf(it, alphabet));
    paper.tracks = [...alphabet.tracks, ...strange].filter((it) => used.has(it.part) || shown.has(it.part));
    for (const [own, box] of boxes) {
      box.disabled = used.has(own);
      box.checked = used.has(own) || shown.has(own);
    }
  }

  function write() {
    const track = trackOf(cell.part, alphabet), words = palette.words(track);
    const gap = picture?.gap(cell), start = gap?.start ?? Math.max(cell.tick, 0), stop = gap?.stop ?? (cell.tick < 0 ? 0 : start + Math.round(grain(score) * lasting));
    if (cell.tick < 0 && !track.lasts) return say(`${nameOf(cell.part)} has no starting position`);
    if (cell.tick >= 0 && stop === 0) return say("A position at the first beat stands below it");
    commit([], [{ part: cell.part, start, stop, words }]);
  }

  /** @param {string} text */
  function say(text) {
    state.textContent = text;
  }

  function take() {
    if (!selection.length) return;
    const many = selection.length;
    commit(selection, []);
    announce(`${counted(many, "symbol")} taken away`);
  }

  /** @param {{ticks: number, part?: string}} by */
  function move({ ticks, part: to }) {
    if (!selection.length) return;
    const from = selection[0].part, alone = selection.every((it) => it.part === from);
    const come = later(selection, ticks).map((it) => (to && alone ? { ...it, part: to } : it));
    cell = snapped({ part: to && alone ? to : cell.part, tick: come[0].stop === 0 ? -1 : come[0].start });
    commit(selection, come);
    paper.follow();
  }

  /** @param {number} begins @param {number} ends */
  function stretch(begins, ends) {
    if (selection.length) commit(selection, stretched(selection, begins, ends, step()));
  }

  function mirror() {
    if (selection.length) {
      const come = mirrored(selection, alphabet);
      cell = { ...cell, part: come[0].part };
      commit(selection, come, true);
    }
  }

  function copy() {
    copied = selection;
    if (copied.length) announce(`${counted(copied.length, "symbol")} copied`);
  }

  function paste() {
    if (!copied.length) return;
    const first = Math.min(...copied.map((it) => it.start)), own = copied[0].part;
    const there = trackOf(cell.part, alphabet), same = copied.every((it) => it.part === own) && trackOf(own, alphabet).kind === there.kind;
    const come = later(copied, Math.max(cell.tick, 0) - first).map((it) => (same ? { ...it, part: cell.part } : it));
    commit([], come, true);
  }

  function back() {
    const before = done.pop();
    if (!before) return;
    undone.push({ score, selection });
    follow(before.score, before.selection);
  }

  function forth() {
    const next = undone.pop();
    if (!next) return;
    done.push({ score, selection });
    follow(next.score, next.selection);
  }

  async function fresh() {
    if (score.symbols.length && !await asked("Begin a new score?", "What is written here goes. Saved as a file, or put into the library, it stays.", [], "Begin a new one")) return;
    forget(draft);
    if (capture) return app.go("/edit");
    alone();
    name.value = "new score";
    become(blank(), []);
    forget(draft);
  }

  /** @param {number} by lanes @param {boolean} alike of the same kind only @returns {string} */
  function beside(by, alike) {
    const lanes = paper.lanes.map((it) => it.track), kind = trackOf(cell.part, alphabet).kind;
    let at = lanes.findIndex((it) => it.part === cell.part);
    do at += by; while (alike && lanes[at] && lanes[at].kind !== kind);
    return (lanes[at] ?? lanes.find((it) => it.part === cell.part) ?? lanes[0]).part;
  }

  /** @param {number} ticks */
  function at(ticks) {
    const tick = Math.max(cell.tick, 0) + ticks;
    return cell.tick < 0 ? (ticks > 0 ? Math.max(0, ticks === step() ? 0 : ticks) : -1) : tick < 0 ? -1 : Math.floor(tick / step() + 1e-6) * step();
  }

  /** @param {KeyboardEvent} event @returns {boolean} whether it was a key of the staff */
  function key(event) {
    const { key: own, shiftKey, altKey } = event, ctrl = event.ctrlKey || event.metaKey;
    const up = { ArrowUp: 1, ArrowDown: -1 }[own] ?? 0, right = { ArrowRight: 1, ArrowLeft: -1 }[own] ?? 0;
    if (ctrl && (up || right)) go({ part: right ? beside(right, false) : cell.part, tick: up ? at(up * step()) : cell.tick }, true);
    else if (ctrl) {
      const acts = /** @type {Record<string, () => void>} */ ({
        z: shiftKey ? forth : back, y: forth, c: copy, v: paste,
        x: () => { copy(); take(); }, a: () => choose([...score.symbols], cell), enter: toggled,
      });
      const act = acts[own.toLowerCase()];
      act?.();
      return Boolean(act);
    } else if (altKey) {
      if (up) move({ ticks: up * step() });
      else if (right) move({ ticks: 0, part: beside(right, true) });
      return Boolean(up || right);
    } else if (shiftKey && up) stretch(0, up * step());
    else if (shiftKey && right) stretch(right * step(), 0);
    else if (shiftKey && own.toLowerCase() === "m") mirror();
    else if (up) go({ part: cell.part, tick: at(up * step()) });
    else if (right) go({ part: beside(right, false), tick: cell.tick });
    else if (own === "PageUp") go({ part: cell.part, tick: at(score.division) });
    else if (own === "PageDown") go({ part: cell.part, tick: at(-score.division) });
    else if (own === "Home") go({ part: cell.part, tick: -1 });
    else if (own === "End") go(snapped({ part: cell.part, tick: end(score) - 1 }));
    else if (own === "Enter") write();
    else if (own === "Delete" || own === "Backspace") take();
    else if (own === "Escape") choose([], cell);
    else if (own === " ") play();
    else if (own === "+" || own === "=" || own === "-") faster(own === "-" ? -FASTER : FASTER);
    else {
      keyed = true;
      const known = palette.press(own);
      keyed = false;
      return known;
    }
    return true;
  }

  function play() {
    if (player.playing) return player.pause();
    player.seek(paper.seconds(Math.max(cell.tick, 0)));
    player.play();
  }

  /** @param {number} by */
  function faster(by) {
    const speed = Math.min(Math.max(Math.round(Number(score.speed)) + by, 1), 1000);
    become({ ...score, speed: String(speed) }, selection);
    say(`${speed} beats a minute`);
  }

  addEventListener("storage", (event) => {
    if (event.key === draft && event.newValue) announce("Another tab writes a score here, too: each keeps its own while it is open, and then what was written last is kept.");
  }, { signal });
  sheet.addEventListener("keydown", (event) => {
    if (key(event)) event.preventDefault();
  });
  main.addEventListener("keydown", (event) => {
    const typing = /** @type {Element} */ (event.target).matches("input, textarea, select");
    if (event.defaultPrevented || typing || !(event.ctrlKey || event.metaKey) || !/^[zy]$/i.test(event.key)) return;
    key(event);
    event.preventDefault();
  }, { signal });
  tempo.addEventListener("change", () => become({ ...score, speed: short(Math.min(Math.max(Number(tempo.value) || 60, 1), 1000)) }, selection));
  for (const it of [beats, beat]) it.addEventListener("change", () => become(inMeter(score, Math.min(Math.max(Math.round(Number(beats.value)) || 4, 1), 99), Number(beat.value)), selection));
  bars.addEventListener("change", () => become(ofBars(score, Math.min(Math.round(Number(bars.value)) || 1, 5000)), selection));
  name.addEventListener("change", keep);
  file.addEventListener("change", () => act(async () => {
    const own = file.files?.[0];
    if (!own) return;
    const read = isPicture(own.name) ? await seen(own.name, ask(address("/api/scores/printed", { name: own.name }), { method: "POST", body: own, signal })) : null;
    const answer = read ?? await send("POST", "/api/scores/read", { name: own.name, text: await own.text() }, signal);
    name.value = own.name.replace(/\.[^.]*$/, "");
    checked = [];
    alone();
    if (read) besides(read);
    become(read ? linked(unpacked(answer.score)) : unpacked(answer.score), []);
    announce(`${own.name} is open`);
  }, problems).finally(() => { file.value = ""; }));

  /** Wait until a picture is read; that takes seconds. @param {string} own its name @param {Promise<Response>} coming @returns {Promise<any>} */
  async function seen(own, coming) {
    problems.replaceChildren(el("p", { role: "status" }, `${own} is being read …`));
    try {
      return await (await coming).json();
    } finally {
      problems.replaceChildren();
    }
  }

  /** Show the picture that the score was read from beside it. @param {import("../edit/picture.js").Printed} printed */
  function besides(printed) {
    const own = new Picture(printed, checked, (it) => {
      const sign = own.symbol(score, it) ?? it, there = paper.lanes.some(({ track }) => track.part === it.part);
      const at = { part: sign.part, tick: sign.stop ? sign.start : -1 };
      if (sign !== it) choose([/** @type {Sign} */ (sign)], at);
      else if (there) choose([], at);
      else {
        go({ part: cell.part, tick: at.tick });
        own.point(it);
        say("Its column has no name that is known: go to the one where it belongs, and write it");
      }
      paper.follow();
      sheet.focus({ preventScroll: true });
      pair.scrollIntoView({ block: "nearest" });
    }, () => {
      checked = [...own.checked];
      look();
      keep();
    });
    for (const it of own.parts) if (alphabet.tracks.some((track) => track.part === it)) shown.add(it);
    picture = own;
    pictureSize.hidden = false;
    pair.prepend(own.root);
    side.replaceChildren(own.list);
    main.classList.add("edit-read");
    own.begin();
  }

  /** Let the score stand alone again. */
  function alone() {
    picture?.root.remove();
    side.replaceChildren();
    picture = null;
    pictureSize.hidden = true;
    main.classList.remove("edit-read");
  }

  /** Do what asks the server, and show what it says where it cannot. @param {() => Promise<void>} work @param {HTMLElement} [where] */
  async function act(work, where = found) {
    try {
      where.replaceChildren();
      await work();
    } catch (error) {
      if (!isAbort(error)) where.replaceChildren(trouble(problemOf(error)));
    }
  }

  function save() {
    act(async () => {
      const headers = { "content-type": "application/json" };
      const body = JSON.stringify({ score: packed(score), format: notation.value, name: name.value });
      const answer = await ask("/api/scores/save", { method: "POST", headers, body, signal });
      const { suffix } = /** @type {{suffix: string}} */ (alphabet.notations.find((it) => it.name === notation.value));
      const link = URL.createObjectURL(await answer.blob());
      const own = answer.headers.get("content-disposition")?.match(/''(.*)$/)?.[1];
      const anchor = el("a", { href: link, download: own ? decodeURIComponent(own) : `score${suffix}` });
      anchor.click();
      setTimeout(() => URL.revokeObjectURL(link), 10000);
      const left = answer.headers.get("lanindex-left-out");
      announce(left ? `Saved; this notation has no room for ${left}` : "Saved");
    });
  }

  function store() {
    act(async () => {
      const kept = await send("POST", "/api/scores/store", { score: packed(score), name: name.value }, signal);
      await app.refresh();
      found.replaceChildren(el("p", {}, "It is capture ", el("a", { href: `/captures/${kept.capture_id}` }, kept.capture_id), ` of the library, ${duration(kept.seconds)}.`));
      announce(`It is capture ${kept.capture_id} of the library`);
    });
  }

  function search() {
    act(async () => {
      const own = selection.length > 1 ? selection : score.symbols; // one alone is where the cursor is
      if (!own.length) throw new Error("there is nothing to search for yet");
      const { pattern } = await send("POST", "/api/scores/pattern", { score: packed(part(score, own)) }, signal);
      app.go(address("/search", { q: pattern }));
    });
  }

  function diff() {
    act(async () => {
      const own = String(against?.capture_id) === capture ? Object.fromEntries(["from", "to"].flatMap((it) => url.searchParams.has(it) ? [[it, Number(url.searchParams.get(it))]] : [])) : {};
      const answer = await send("POST", "/api/scores/diff", { score: packed(score), capture: against?.capture_id, ...own }, signal);
      const others = new Set(answer.differences.flatMap((/** @type {Difference} */ it) => (it.other ? [`${it.part} ${Math.round(paper.tick(it.other.start))}`] : [])));
      paper.marked = new Set(score.symbols.filter((it) => others.has(`${it.part} ${it.start}`)));
      paper.refresh();
      const items = answer.differences.map((/** @type {Difference} */ it) => {
        const there = it.other ?? it.one, when = there?.start ?? 0;
        const words = (/** @type {Difference["one"]} */ side) => (side ? [side.direction, side.level].flatMap((word) => word ? [nameOf(word)] : []).join(" ") : "nothing");
        const text = it.difference === "replaced" ? `${words(it.one)}, here ${words(it.other)}` : words(there);
        return el("li", {}, el("button", { type: "button", class: "plain", onclick: () => {
          go(snapped({ part: it.part, tick: Math.round(paper.tick(when)) }));
          sheet.focus();
        } }, `${duration(when)} ${nameOf(it.part)} ${it.difference}: ${text}`));
      });
      found.replaceChildren(
        answer.only[0].length ? el("p", { class: "soft" }, `It alone has ${answer.only[0].map(nameOf).join(", ")}.`) : "",
        el("p", {}, `${counted(answer.same, "symbol")} the same as in `, el("span", { class: "path" }, answer.capture), `, ${counted(answer.count, "difference")}.`),
        el("ol", { class: "edit-differences" }, ...items));
    });
  }

  numbers();
  lanes();
  const strange = paper.lanes.length ? null : cell;
  look();
  await paper.draw();
  cell = strange ?? cell;
  look();
  stage.perform(score, 0, false);
  sheet.focus({ preventScroll: true });
  if (against && isPicture(against.capture) && !url.searchParams.has("from")) {
    const own = against.capture;
    act(async () => {
      besides(await seen(own, ask(`/api/scores/captures/${encodeURIComponent(capture ?? "")}/printed`, { signal })));
      lanes();
      look();
      paper.draw();
    }, problems);
  }
  return () => {
    player.dispose();
    stage.dispose();
    paper.dispose();
    figure.dispose();
  };
}

/** @param {string} key */
function forget(key) {
  for (const it of [sessionStorage, localStorage]) it.removeItem(key);
}

/**
 * Return a draft that this browser keeps.
 * @param {string} key
 * @returns {{score: Score, title: string} | null}
 */
function stored(key) {
  try {
    const kept = JSON.parse(sessionStorage.getItem(key) ?? localStorage.getItem(key) ?? "null"); // that of this tab first
    return kept?.score?.symbols ? kept : null;
  } catch {
    return null; // of another version, or storage is switched off
  }
}
