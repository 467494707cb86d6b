/** The button that writes a whole library down anew, what it asks before, and how far it is. */

import { address, follow, get, goingOn, problemOf, send } from "./api.js";
import { counted, el, readOut, trouble } from "./dom.js";

/**
 * @typedef {{state: string, done: number, total: number, captures: number, failed: number, reasons: string[], error: import("./api.js").Problem | null}} State
 */

/**
 * @param {{name: () => string, touched: () => boolean, readonly: boolean, encoded: () => void}} given
 *   name of the profile; touched: whether it has changes that are not saved
 */
export function encodeSection({ name, touched, readonly, encoded }) {
  const button = el("button", { type: "button", onclick: () => question() }), hint = el("span", { class: "soft" });
  const bar = el("progress", { "aria-label": "Files that are written down", max: 1, value: 0 }), count = el("span", { class: "num" });
  const stop = el("button", { type: "button", onclick: () => cancel() }, "Cancel");
  const running = el("div", { class: "row", hidden: true }, bar, count, stop), said = el("div", {});
  const text = el("p", {}), yes = el("button", { type: "button", class: "main", onclick: () => begin() }, "Encode the library");
  const dialog = el("dialog", { "aria-labelledby": "encode-title" },
    el("h2", { id: "encode-title" }, "Encode the library"), text,
    el("div", { class: "row" }, yes, el("button", { type: "button", onclick: () => dialog.close() }, "Leave it as it is")));
  const node = el("section", { class: "card wide", "aria-label": "Encode the library" },
    el("h2", {}, "Encode the library"), el("div", { class: "row" }, button, hint), running, said, dialog);
  let job = "", left = false, unfollow = () => {};

  function update() {
    button.textContent = `Encode the library with ${name()}\u2026`;
    button.disabled = readonly || touched() || job !== "";
    hint.textContent = readonly ? "This library is only shown." : touched() ? "Save the changes as a profile first." : "";
  }

  /** Say how many captures it concerns, and ask whether that is meant. */
  async function question() {
    try {
      const { captures, same, scores } = await get(address("/api/library/encode", { profile: name() }));
      if (!captures) {
        said.replaceChildren(el("p", {}, `All captures have the profile ${name()} already.`));
        return;
      }
      const stay = [same ? `${counted(same, "capture")} that ${same === 1 ? "has" : "have"} it already` : "", scores ? counted(scores, "score") : ""].filter(Boolean).join(" and ");
      text.textContent = `${counted(captures, "capture")} ${captures === 1 ? "is" : "are"} read again and written down with the profile ${name()}. Their symbols are replaced; labels and columns stay${stay ? `, and so do ${stay}` : ""}. A capture whose file is gone keeps its symbols.`;
      dialog.showModal();
    } catch (error) {
      said.replaceChildren(trouble(problemOf(error)));
    }
  }

  async function begin() {
    dialog.close();
    said.replaceChildren();
    try {
      watch((await send("POST", "/api/library/encode", { profile: name() })).job);
      stop.focus();
    } catch (error) {
      ended(trouble(problemOf(error)));
    }
  }

  /** @param {string} number */
  function watch(number) {
    unfollow();
    job = number;
    running.hidden = false;
    update();
    unfollow = follow(`/api/jobs/${job}/events`, tell, () => ended(el("p", {}, "The server is gone; what is written down by now stays.")));
  }

  /** Find what was begun before this screen was shown. */
  async function find() {
    try {
      const [number] = await goingOn("encode");
      if (number && !job && !left) watch(number);
    } catch (error) {
      said.replaceChildren(trouble(problemOf(error)));
    }
  }
  void find();

  /** @param {State} state */
  function tell(state) {
    bar.max = Math.max(state.total, 1);
    bar.value = state.done;
    count.textContent = `${state.done.toLocaleString("en")} of ${counted(state.total, "file")}`;
    if (state.state === "running") return;
    const words = { done: "Done", cancelled: "Cancelled", failed: "Broken off" }[state.state] ?? state.state;
    const result = `${words}: ${counted(state.captures, "capture")} written down anew${state.failed ? `, ${counted(state.failed, "file")} could not be read` : ""}.`;
    readOut(result);
    ended(el("div", {}, el("p", {}, result), state.error && trouble(state.error),
      state.reasons.length > 0 && el("details", {}, el("summary", {}, "What could not be read"), el("ul", {}, ...state.reasons.map((it) => el("li", { class: "path" }, it))))));
    encoded();
  }

  /** @param {HTMLElement} result */
  function ended(result) {
    const focused = running.contains(document.activeElement); // what has the focus is about to go
    job = "";
    running.hidden = true;
    said.replaceChildren(result);
    update();
    if (focused) button.focus();
  }

  function cancel() {
    send("DELETE", `/api/jobs/${job}`).catch((error) => said.replaceChildren(trouble(problemOf(error))));
  }

  return { node, update, dispose: () => {
    left = true;
    unfollow();
  } };
}
