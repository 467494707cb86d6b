// The field in which a capture is chosen: by its path, a part of it, the name of its file, its label.

import { address, get, isAbort, problemOf } from "./api.js";
import { counted, el } from "./dom.js";

/** @typedef {{capture: string, capture_id: number, label: string}} Capture */

const PAUSE = 120; // milliseconds without a key before captures are offered

let fields = 0;

/**
 * @param {{name: string, chosen?: Capture | null, moving?: boolean, signal: AbortSignal, choose: (capture: Capture) => void}} given
 *   moving: only what has a movement; choose: is given another capture than the one that is chosen
 */
export function picker({ name, chosen = null, moving = false, signal, choose }) {
  const list = el("datalist", { id: `fitting-${++fields}` }), said = el("span", { class: "soft", role: "status" });
  const field = el("input", { type: "search", list: list.id, class: "grow", autocomplete: "off", value: chosen?.capture ?? "", placeholder: "a part of its path, Enter",
    onfocus: () => {
      field.select();
      void offer();
    },
    oninput: () => {
      said.textContent = "";
      clearTimeout(waiting);
      if (!take(offered.get(field.value))) waiting = window.setTimeout(offer, PAUSE);
    },
    onkeydown: (/** @type {KeyboardEvent} */ event) => {
      if (event.key !== "Enter") return;
      event.preventDefault();
      void enter();
    },
    onblur: () => { // nothing stays there that is not chosen
      clearTimeout(waiting);
      said.textContent = "";
      field.value = chosen?.capture ?? "";
    } });
  let waiting = 0;
  /** @type {Map<string, Capture>} */
  const offered = new Map();

  /** @returns {Promise<{captures: Capture[], total: number, one: number | null} | null>} null: no longer wanted, or it cannot be asked */
  async function fitting() {
    try {
      const text = field.value === chosen?.capture ? "" : field.value; // all are offered beside what is chosen
      return await get(address("/api/captures/fitting", { q: text, moving }), signal);
    } catch (error) {
      if (!isAbort(error)) said.textContent = problemOf(error).found;
      return null;
    }
  }

  async function offer() {
    const found = await fitting();
    if (!found) return;
    for (const it of found.captures) offered.set(it.capture, it);
    list.replaceChildren(...found.captures.map((it) => el("option", { value: it.capture }, it.label)));
  }

  async function enter() {
    clearTimeout(waiting);
    const text = field.value.trim();
    if (!text || text === chosen?.capture) return;
    const found = await fitting();
    if (!found || text !== field.value.trim()) return;
    if (take(found.captures.find((it) => it.capture_id === found.one))) return;
    said.textContent = found.total ? `${counted(found.total, "capture")} fit ${text}: type more of its path.` : `No capture ${moving ? "of a movement " : ""}fits ${text}.`;
  }

  /** @param {Capture | undefined} capture */
  function take(capture) {
    if (!capture || capture.capture_id === chosen?.capture_id) return false;
    chosen = capture;
    field.value = capture.capture;
    choose(capture);
    return true;
  }
  return el("span", { class: "grow picker" }, el("label", { class: "row" }, `${name} `, field), list, said);
}
