// Labels and columns that are changed in place, of one capture or of all that are selected.

import { problemOf, send } from "../../api.js";
import { announce, counted, el } from "../../dom.js";

/** @typedef {{captures: number[], label?: string | null, columns?: Record<string, string>, held?: object}} Change */
/** @typedef {import("../library.js").Capture} Capture */

/** Changes what the user says of captures, and undoes it. */
export class Editing {
  /** @type {Change[][]} what undoes each change, the newest last */
  #undo = [];
  /** @type {Promise<unknown>} changes follow each other: the newest is undone first */
  #last = Promise.resolve();
  /** @type {Promise<unknown>} until nothing is being typed in place, and what was typed is kept */
  typed = Promise.resolve();
  /** @type {HTMLElement | undefined} */
  #offer;
  #changed;

  /**
   * @param {AbortSignal} signal
   * @param {(shown: boolean, gone?: number[]) => void} changed is told of each change, whether the list shows it already, and which captures are gone
   */
  constructor(signal, changed) {
    this.#changed = changed;
    addEventListener("keydown", (event) => {
      const typing = event.target instanceof Element && event.target.closest("input:not([type=checkbox]), textarea, select, dialog");
      if (event.key.toLowerCase() !== "z" || !(event.ctrlKey || event.metaKey) || event.shiftKey || typing) return;
      event.preventDefault();
      this.undo();
    }, { signal });
  }

  /**
   * Have something changed; says what, and offers to undo it. Returns whether it was.
   * @param {Change[]} changes
   * @param {string} said
   * @param {boolean} shown
   */
  change(changes, said, shown) {
    const done = this.#last.then(() => this.#change(changes, said, shown));
    this.#last = done;
    return done;
  }

  /** @param {Change[]} changes @param {string} said @param {boolean} shown */
  async #change(changes, said, shown) {
    try {
      const { changed, undo } = await send("PATCH", "/api/captures", { changes });
      if (changed) {
        this.#undo.push(undo);
        this.#offer = announce(said, el("button", { type: "button", onclick: () => this.undo() }, "Undo"));
        this.#changed(shown);
      }
      return true;
    } catch (error) {
      announce(sentence(error));
      return false;
    }
  }

  async undo() {
    await this.#last;
    const changes = this.#undo.pop();
    if (!changes) return;
    this.#offer?.remove();
    try {
      await send("PATCH", "/api/captures", { changes });
      announce("Undone");
    } catch (error) {
      announce(sentence(error));
    }
    this.#changed(false); // somebody else may have changed it, too
  }

  /**
   * Return a text that Enter or a double click lets change: Enter keeps, Escape leaves, Tab goes on to the next one.
   * @param {Capture} capture
   * @param {string} column `label`, or one of the user's
   * @param {boolean} own whether it is one of the user's
   */
  text(capture, column, own) {
    const value = () => (own ? capture.metadata[column] ?? "" : capture.label);
    const name = capture.capture.slice(capture.capture.lastIndexOf("/") + 1);
    const button = el("button", { type: "button", class: "editable", title: "Enter or double click to change", onclick: (/** @type {PointerEvent} */ event) => {
      if (event.pointerType !== "mouse") begin();
    }, ondblclick: () => begin() });
    /** @param {string} text */
    function shown(text) {
      button.textContent = text || `no ${column}`;
      button.classList.toggle("soft", !text);
      button.setAttribute("aria-label", `${column} of ${name}: ${text || "none"}, change`);
    }
    const begin = () => {
      let open = true, release = () => {};
      this.typed = Promise.all([this.typed, new Promise((resolve) => (release = () => resolve(null)))]);
      /** @param {boolean} keep */
      const end = async (keep) => {
        if (!open) return;
        open = false;
        const before = value(), after = input.value.trim();
        input.replaceWith(button);
        if (!keep || after === before) return release();
        shown(after);
        if (own) capture.metadata[column] = after;
        else capture.label = after;
        const change = own ? { columns: { [column]: after } } : { label: after };
        const done = await this.change([{ captures: [capture.capture_id], ...change }], `${column} changed`, true);
        release();
        if (done) return;
        if (own) capture.metadata[column] = before;
        else capture.label = before;
        shown(before);
      };
      const input = el("input", { value: value(), list: own ? null : "labels", "aria-label": `${column} of ${name}`, onblur: () => end(true), onkeydown: (/** @type {KeyboardEvent} */ event) => {
        if (event.key !== "Enter" && event.key !== "Escape" && event.key !== "Tab") return;
        const all = [...document.querySelectorAll(".editable, .shelf .editing")], at = all.indexOf(input);
        const next = all[at + (event.shiftKey ? -1 : 1)];
        if (event.key !== "Tab" || next) event.preventDefault();
        end(event.key !== "Escape");
        if (event.key !== "Tab") button.focus();
        else next?.dispatchEvent(new MouseEvent("dblclick"));
      }, class: "editing" });
      button.replaceWith(input);
      input.focus();
      input.select();
    };
    shown(value());
    return button;
  }

  /**
   * Ask for a label of several captures.
   * @param {number[]} captures
   */
  async label(captures) {
    const said = await asked(`Label ${counted(captures.length, "capture")}`, "", [["Label", "labels"]], "Set the label");
    if (said) await this.change([{ captures, label: said[0] }], `${counted(captures.length, "capture")} labelled ${said[0] || "no longer"}`, false);
  }

  /**
   * Ask for a column of several captures.
   * @param {number[]} captures
   */
  async column(captures) {
    const said = await asked(`Set a column of ${counted(captures.length, "capture")}`, "Without a value the column goes.", [["Column", "columns"], ["Value", ""]], "Set the column");
    if (said) await this.change([{ captures, columns: { [said[0]]: said[1] } }], `${said[0]} of ${counted(captures.length, "capture")} changed`, false);
  }

  /**
   * Take captures out of the library, once that is confirmed.
   * @param {number[]} captures
   * @param {string} [files] what is said of their files
   */
  async remove(captures, files = "Their files stay where they are.") {
    const some = counted(captures.length, "capture");
    const text = `${files} What was written down of them goes, their labels and columns too; this cannot be undone.`;
    if (!await asked(`Remove ${some} from the library?`, text, [], `Remove ${some}`)) return;
    try {
      await send("POST", "/api/captures/remove", { captures });
      this.#undo = [];
      announce(`${some} removed`);
      this.#changed(false, captures);
    } catch (error) {
      announce(problemOf(error).found);
    }
  }
}

/** @param {unknown} error */
function sentence(error) {
  const { found, wanted, remedy } = problemOf(error);
  return `${found}${wanted ? `, wanted ${wanted}` : ""}.${remedy ? ` ${remedy}` : ""}`;
}

/**
 * Ask in a dialog; returns what was typed, or nothing where it is left.
 * @param {string} title
 * @param {string} text
 * @param {[string, string][]} fields names, and the list that each is offered
 * @param {string} action
 * @returns {Promise<string[] | null>}
 */
export function asked(title, text, fields, action) {
  return new Promise((resolve) => {
    const inputs = fields.map(([, list]) => el("input", { list: list || null, required: list === "columns" }));
    const dialog = el("dialog", { "aria-label": title, onclose: () => {
      dialog.remove();
      resolve(dialog.returnValue === "do" ? inputs.map((it) => it.value.trim()) : null);
    } }, el("form", { onsubmit: (/** @type {Event} */ event) => {
      event.preventDefault();
      dialog.close("do");
    } }, el("h2", {}, title), text && el("p", {}, text),
      ...fields.map(([name], at) => el("label", {}, name, inputs[at])),
      el("p", { class: "row" }, el("button", { class: "main" }, action), el("button", { type: "button", onclick: () => dialog.close("") }, "Cancel"))));
    document.body.append(dialog);
    dialog.showModal();
  });
}
