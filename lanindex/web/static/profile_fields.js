/** The fields of a profile's numbers for one part, its rules, and the line that saves it. */

import { problemOf } from "./api.js";
import { DIRECTIONS, LEVELS, PLACE } from "./cells.js";
import { el, trouble } from "./dom.js";
import { encodeSection } from "./encode_library.js";
import { nameOf } from "./names.js";
import { numberField, shown } from "./numbers.js";

/**
 * @typedef {import("./cells.js").Space} Space
 * @typedef {import("./draft.js").Draft} Draft
 * @typedef {import("./draft.js").Profile} Profile
 * @typedef {import("./draft.js").Rule} Rule
 * @typedef {import("./sphere.js").Border} Border
 *
 * @typedef {object} Given
 * @property {() => Draft} draft
 * @property {() => string} part
 * @property {() => boolean} alike whether both sides change
 * @property {Record<string, Profile>} others whose numbers are offered
 * @property {(border: Border | null) => void} mark
 * @property {() => Promise<string>} tempo looks for that of the movement
 * @property {boolean} readonly
 * @property {(name: string, replace: boolean) => Promise<{name: string, folder: string}>} save
 * @property {() => void} encoded is called when the library has been written down anew
 */

const DEGREE = "\u00b0";
const LEAST = 0.5; // degrees between two borders
const UNITS = /** @type {Record<string, string>} */ ({
  rate: "frames a second", path_check: "d_t", achieved_within: DEGREE, onset: "of the peak", speed: "beats a minute", division: "ticks",
});
const TITLES = /** @type {Record<string, string>} */ ({
  rate: "Rate", smoothing: "Smoothing", candidate_speed: "v0, slower may be a stop", prominence: "Prominence of a stop", still: "Still",
  distance: "d_t, one stop within", path_check: "Strays at most", achieved_within: "Achieved within", onset: "Onset", speed: "Tempo", division: "Unit: ticks in a bar",
});
const TIME = ["speed", "division"];
const CELLS = DIRECTIONS.flatMap((direction) => LEVELS.map((level) => `${direction} ${level}`));

/**
 * @param {HTMLElement} root
 * @param {Given} given
 */
export function fieldsOf(root, given) {
  /** @type {(() => void)[]} */
  let updates = [];
  let length = 500;
  /** @type {number[]} */
  let counts = [];
  /** @type {HTMLElement[]} */
  let ruleRows = [];

  /** @param {Parameters<typeof numberField>[0]} field */
  function row(field) {
    const { node, update } = numberField(field);
    updates.push(update);
    return node;
  }

  /** @param {(space: Space) => number} read @param {string} unit */
  function offered(read, unit, /** @type {(space: Space) => Space} */ put, /** @type {string} */ token) {
    return Object.entries(given.others).map(([name, profile]) => {
      const space = profile.spaces[given.part()];
      const own = unit || (space.relative ? " L" : " mm");
      return /** @type {[string, string, () => void]} */ ([name, `${shown(read(space))}${own}`, () => set(put(space), token)]);
    });
  }

  /** @param {Space} space @param {string} token */
  function set(space, token) {
    given.draft().setSpace(given.part(), space, { alike: given.alike(), token });
  }

  const now = () => given.draft().space(given.part());
  const before = () => given.draft().profile.spaces[given.part()];

  /** @param {"mid" | "high"} level */
  function levelField(level) {
    const says = level === "mid" ? "0\u00b0 is straight down, 90\u00b0 level; below it is low" : "180\u00b0 is straight up";
    return row({
      label: `${level} begins at`, unit: DEGREE, says, slider: true,
      limits: () => limits(level), get: () => ({ value: now()[level] }),
      set: (value) => set({ ...now(), [level]: value }, level),
      touched: () => now()[level] !== before()[level], back: () => set({ ...now(), [level]: before()[level] }, ""),
      others: offered((it) => it[level], DEGREE, (it) => ({ ...now(), [level]: it[level] }), ""),
      focus: (on) => given.mark(on ? level : null),
    });
  }

  function placeField() {
    const unit = (/** @type {Space} */ it) => (it.relative ? "L" : "mm");
    return row({
      label: "place within", units: ["L", "mm"], says: "of the vertical; L is the part\u2019s length", slider: true,
      limits: () => limits("place"), get: () => ({ value: now().place, unit: unit(now()) }),
      set: (value, chosen) => {
        const { relative, place } = now(), wanted = chosen === "L";
        // another unit says the same radius
        const same = relative !== wanted && value === place;
        set({ ...now(), relative: wanted, place: same ? round(wanted ? place / length : place * length) : value }, "place");
      },
      touched: () => now().place !== before().place || now().relative !== before().relative,
      back: () => set({ ...now(), place: before().place, relative: before().relative }, ""),
      others: offered((it) => it.place, "", (it) => ({ ...now(), place: it.place, relative: it.relative }), ""),
      focus: (on) => given.mark(on ? "place" : null),
    });
  }

  /** @param {number} code */
  function startField(code) {
    const begin = (/** @type {number} */ value) => now().starts.map((it, at) => (at === code ? (value + 360) % 360 : it));
    return row({
      label: `${nameOf(DIRECTIONS[code])} begins at`, unit: DEGREE,
      limits: () => limits(code), get: () => ({ value: wrapped(code, now().starts[code]) }),
      set: (value) => set({ ...now(), starts: begin(value) }, `start ${code}`),
      touched: () => now().starts[code] !== before().starts[code],
      back: () => set({ ...now(), starts: begin(before().starts[code]) }, ""),
      focus: (on) => given.mark(on ? code : null),
    });
  }

  /** Return a start as a number between its neighbours: 337.5 of the right may also be -22.5. */
  function wrapped(/** @type {number} */ code, /** @type {number} */ value) {
    return code === 0 && value > 180 ? value - 360 : value;
  }

  /**
   * Return between which numbers a border may be.
   * @param {Border} border
   * @returns {[number, number]}
   */
  function limits(border) {
    const { mid, high, starts, relative } = now();
    if (border === "mid") return [LEAST, high - LEAST];
    if (border === "high") return [mid + LEAST, 180 - LEAST];
    if (border === "place") return [0, relative ? 1 : 2000];
    const from = starts[(border + 7) % PLACE], to = starts[(border + 1) % PLACE], own = wrapped(border, starts[border]);
    const behind = ((own - from) % 360 + 360) % 360, ahead = ((to - own) % 360 + 360) % 360;
    return [round(own - behind + LEAST), round(own + ahead - LEAST)];
  }

  /** @param {string} name */
  function parameterField(name) {
    const { draft } = given, about = draft().profile.parameters.find((it) => it.name === name);
    if (!about) throw new Error(`no parameter ${name}`);
    const { units, low, high, whole, says } = about;
    const parsed = (/** @type {string | number} */ value) => {
      const [text, unit = ""] = String(value).split(" ");
      return { value: Number(text), unit };
    };
    return row({
      label: TITLES[name] ?? name, says, whole, units: units.length ? units : undefined, unit: UNITS[name],
      limits: () => [low, high], get: () => parsed(draft().parameter(name)),
      set: (value, unit) => draft().setParameter(name, unit ? `${shown(value)} ${unit}` : value),
      touched: () => draft().parameter(name) !== draft().given(name), back: () => draft().setParameter(name, draft().given(name)),
      others: Object.entries(given.others).map(([other, profile]) => {
        const own = profile.parameters.find((it) => it.name === name)?.value ?? "";
        return [other, String(own), () => draft().setParameter(name, own)];
      }),
    });
  }

  function timeFields() {
    const { draft } = given, says = el("span", { class: "soft", role: "status" });
    const beats = el("input", { type: "number", min: 1, max: 99, "aria-label": "Beats in a bar", class: "num", oninput: () => rhythm() });
    const beat = el("select", { "aria-label": "Note of a beat", onchange: () => rhythm() }, ...[1, 2, 4, 8, 16, 32].map((it) => el("option", { value: it }, String(it))));
    const wrong = el("span", { class: "wrong", role: "status" });
    function rhythm() {
      const count = Number(beats.value), good = Number.isInteger(count) && count >= 1 && count <= 99;
      wrong.textContent = good ? "" : `${beats.value || "Nothing"} is not allowed: a whole number from 1 to 99.`;
      if (good) draft().setParameter("rhythm", `${count}/${beat.value}`);
    }
    updates.push(() => {
      const [count, note] = String(draft().parameter("rhythm")).split("/");
      if (document.activeElement !== beats) beats.value = count;
      if (![...beat.options].some((it) => it.value === note)) beat.append(el("option", { value: note }, note));
      beat.value = note;
      wrong.textContent = "";
    });
    const find = el("button", { type: "button", onclick: async () => {
      says.textContent = "Looking\u2026";
      says.textContent = await given.tempo().catch((error) => problemOf(error).found);
    } }, "Find the movement\u2019s tempo");
    return [parameterField("speed"), el("div", {}, find, " ", says),
      el("div", { class: "number" }, el("span", {}, "Rhythm"), el("span", { class: "row" }, beats, " / ", beat), el("span", { class: "soft says" }, "beats in a bar / the note of a beat"), wrong),
      parameterField("division")];
  }

  function rulesSection() {
    const body = el("div", { class: "scroll rules", tabindex: 0, role: "region", "aria-label": "Rules" }), head = el("summary", {});
    const put = (/** @type {Rule[]} */ rules) => given.draft().setRules(given.part(), rules, given.alike());
    updates.push(() => {
      const rules = given.draft().rules(given.part());
      head.textContent = `Passing rules (LDD): ${rules.length}`;
      ruleRows = rules.map((rule, at) => el("div", { class: "row rule" },
        el("button", { type: "button", class: "plain", "aria-label": `Remove the rule ${ruleWords(rule)}`, onclick: () => put(rules.filter((_, other) => other !== at)) }, "\u00d7"),
        el("span", {}, ...rule.cells.flatMap((cell, place) => [place ? " \u2192 " : "", rule.deleted.includes(place) ? el("s", {}, nameOf(cell)) : nameOf(cell)])),
        el("span", { class: "soft num count" })));
      body.replaceChildren(...ruleRows, rules.length ? "" : el("p", { class: "soft" }, "No rule: all symbols stay."));
      used(counts);
    });
    const chosen = [0, 1, 2].map((place) => el("select", { "aria-label": `Symbol ${place + 1} of the new rule` }, ...(place === 2 ? [el("option", { value: "" }, "none")] : []), ...CELLS.map((it) => el("option", { value: it }, nameOf(it)))));
    chosen[0].value = "place low";
    const gone = [0, 1, 2].map((place) => el("input", { type: "checkbox", checked: place === 1, "aria-label": `Symbol ${place + 1} is passed` }));
    const wrong = el("span", { class: "wrong", role: "status" });
    const add = el("button", { type: "button", onclick: () => {
      const cells = chosen.map((it) => it.value).filter(Boolean), deleted = gone.flatMap((it, place) => (it.checked && place < cells.length ? [place] : []));
      wrong.textContent = deleted.length ? "" : "A rule must pass over one of its symbols.";
      if (deleted.length) put([{ cells, deleted }, ...given.draft().rules(given.part())]);
    } }, "Add the rule");
    return el("details", { class: "card wide" }, head,
      el("p", { class: "soft" }, "Of symbols in a row, those struck out are only passed. The number says how often a rule does so in this capture."),
      body,
      el("fieldset", { class: "row plain-set" }, el("legend", {}, "A new rule"), ...chosen.flatMap((it, place) => [el("span", { class: "row" }, it, el("label", {}, gone[place], " passed"))]), add, wrong));
  }

  /** @param {number[]} found how often each rule was applied */
  function used(found) {
    counts = found;
    ruleRows.forEach((node, at) => {
      const count = node.querySelector(".count");
      if (count) count.textContent = found[at] ? `${found[at]}\u00d7` : "";
      node.classList.toggle("used", found[at] > 0);
    });
  }

  function saveSection() {
    const name = el("input", { "aria-label": "Name of the profile", placeholder: "Name of the profile", maxlength: 60, required: true });
    const replace = el("input", { type: "checkbox" }), said = el("div", {});
    const form = el("form", { class: "row", onsubmit: async (/** @type {Event} */ event) => {
      event.preventDefault();
      try {
        const saved = await given.save(name.value, replace.checked);
        said.replaceChildren(el("p", {}, "Saved. Encode the library with it below, or choose it in Add captures, under How they are read. In a terminal: ", el("code", {}, `lanindex ingest --profile "${saved.folder}" \u2026`)));
      } catch (error) {
        said.replaceChildren(trouble(problemOf(error)));
      }
    } }, name, el("button", { class: "main" }, "Save as a profile"), el("label", {}, replace, " replace one of this name"));
    return el("section", { class: "card wide", "aria-label": "Save" }, el("h2", {}, "Save as a profile"),
      given.readonly ? el("p", { class: "soft" }, "This library is only shown: nothing can be saved in it.") : form, said);
  }
  const saving = saveSection();
  const encoding = encodeSection({ name: () => given.draft().profile.name, touched: () => given.draft().touched, readonly: given.readonly, encoded: given.encoded });

  function build() {
    updates = [];
    const { draft } = given, moves = draft().profile.parameters.map((it) => it.name).filter((it) => !TIME.includes(it));
    const set = (/** @type {string} */ title, /** @type {string} */ says, /** @type {Node[]} */ ...nodes) =>
      el("fieldset", { class: "card" }, el("legend", {}, title), el("p", { class: "soft" }, says), ...nodes);
    root.replaceChildren(
      set("Cells (LPD)", "Of this part: where levels and place begin.", levelField("mid"), levelField("high"), placeField()),
      set("Directions (LPD)", "Azimuths: 0\u00b0 is right, 90\u00b0 forward, 180\u00b0 left.", el("div", { class: "starts" }, ...DIRECTIONS.slice(0, PLACE).map((_, code) => startField(code)))),
      set("Time", "How a score counts; symbols stay where they are.", ...timeFields()),
      el("details", { class: "card wide" }, el("summary", {}, "How moves are found (all parts)"), el("div", { class: "parameters" }, ...moves.map(parameterField))),
      rulesSection(),
      saving,
      encoding.node);
    updates.push(encoding.update);
    update();
  }

  function update() {
    for (const each of updates) each();
  }

  return {
    build, update, used,
    /** @param {number} mm */
    set length(mm) { length = mm; },
    dispose: () => {
      updates = [];
      encoding.dispose();
    },
    /**
     * Take a border that is drawn on the sphere: degrees, or lengths of place.
     * @param {Border} border
     * @param {number} value
     * @param {boolean} done
     */
    move(border, value, done) {
      const own = border === "place" && !now().relative ? value * length : typeof border === "number" ? wrapped(border, value) : value;
      const [low, high] = limits(border), digits = border === "place" && now().relative ? 100 : 2;
      let exact = Math.round(own * digits) / digits;
      if (typeof border === "number") while (exact > high && exact - 360 >= low) exact -= 360;
      const kept = Math.min(Math.max(exact, low), high), token = done ? "" : `drawn ${border}`;
      const space = typeof border === "number"
        ? { ...now(), starts: now().starts.map((it, at) => (at === border ? (kept + 360) % 360 : it)) }
        : { ...now(), [border]: kept };
      if (!done) set(space, token);
    },
  };
}

/** @param {Rule} rule */
function ruleWords(rule) {
  return rule.cells.map((it, at) => `${nameOf(it)}${rule.deleted.includes(at) ? ", passed" : ""}`).join(", ");
}

/** @param {number} value */
function round(value) {
  return Math.round(value * 1e4) / 1e4;
}
