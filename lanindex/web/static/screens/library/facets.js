// Facets: how many captures have each value of a column; what is chosen of them.

import { el } from "../../dom.js";

/** @typedef {import("../library.js").Facet} Facet */

const FEW = 8; // values that are shown of a facet, unless more are asked for
const LONG = 18; // letters of a folder: of a longer one the end tells more than the beginning
/** @type {Record<string, string>} */
const EMPTY = { label: "no label", folder: "the folder itself", doubts: "no doubts" };

/** The facets beside the list, the button that shows them in a narrow window, and what is chosen. */
export class Facets {
  root = el("aside", { class: "facets", id: "facets", "aria-label": "Facets" });
  chips = el("div", { class: "row chips" });
  button = el("button", { type: "button", class: "narrow", "aria-expanded": "false", "aria-controls": "facets", onclick: () => this.#open() }, "Facets");
  /** @type {Set<string>} names of the facets that are shown at length */
  #long = new Set();
  /** @type {string[]} */
  #where = [];
  /** @type {Facet[]} */
  #facets = [];
  #choose;

  /** @param {(where: string[]) => void} choose is given what is chosen: `label=walk` */
  constructor(choose) {
    this.#choose = choose;
  }

  /**
   * @param {Facet[]} facets
   * @param {string[]} where what is chosen
   */
  show(facets, where) {
    this.#facets = facets;
    this.#where = where;
    const focus = /** @type {HTMLElement | null} */ (document.activeElement)?.dataset?.key;
    this.root.replaceChildren(...facets.filter((it) => this.#tells(it)).map((it) => this.#facet(it)));
    this.chips.replaceChildren(...where.map((it) => {
      const [column, value] = parted(it);
      return el("button", { type: "button", class: "chip", "data-key": `- ${it}`, "aria-label": `Drop ${column}: ${shown(column, value)}`, onclick: () => this.#turn(it, false) },
        el("span", { class: "soft" }, `${column} `), shown(column, value), " ×");
    }));
    const again = focus && [...this.root.querySelectorAll("[data-key]"), ...this.chips.children].find((it) => /** @type {HTMLElement} */ (it).dataset.key === focus);
    if (again instanceof HTMLElement) again.focus({ preventScroll: true });
  }

  /** @param {Facet} facet @returns {boolean} whether it tells captures apart */
  #tells({ name, values, different }) {
    if (this.#where.some((it) => parted(it)[0] === name)) return true;
    return different > 1 && (different <= FEW || values[0][1] > 1);
  }

  /** @param {Facet} facet */
  #facet({ name, values, different }) {
    const chosen = this.#where.filter((it) => parted(it)[0] === name).map((it) => parted(it)[1]);
    const counts = new Map(values);
    const rest = values.map(([value]) => value).filter((it) => !chosen.includes(it));
    const some = this.#long.has(name) || rest.length <= FEW + 1 ? rest : rest.slice(0, FEW);
    const left = rest.length - some.length, beyond = different - values.length;
    return el("section", {}, el("h2", {}, name), el("ul", { "aria-label": name },
      ...[...chosen, ...some].map((value) => this.#value(name, value, counts.get(value) ?? 0, chosen.includes(value)))),
      left > 0 && el("button", { type: "button", class: "plain", "data-key": `+ ${name}`, onclick: () => {
        this.#long.add(name);
        this.show(this.#facets, this.#where);
        /** @type {HTMLElement | null} */ (this.root.querySelector(`[data-key="${CSS.escape(`${name}=${rest[FEW]}`)}"]`))?.focus();
      } }, `${left} more`),
      this.#long.has(name) && beyond > 0 && el("p", { class: "soft" }, `and ${beyond.toLocaleString("en")} rarer ones: filter for them`));
  }

  /**
   * @param {string} name
   * @param {string} value
   * @param {number} count
   * @param {boolean} checked
   */
  #value(name, value, count, checked) {
    const key = `${name}=${value}`;
    const box = el("input", { type: "checkbox", checked, "data-key": key, onchange: () => this.#turn(key, box.checked) });
    return el("li", {}, el("label", {}, box, el("span", { class: value ? "grow" : "grow soft", title: value }, shown(name, value)), el("span", { class: "soft num" }, count.toLocaleString("en"))));
  }

  /** @param {string} key @param {boolean} on */
  #turn(key, on) {
    this.#choose(on ? [...this.#where, key] : this.#where.filter((it) => it !== key));
  }

  #open() {
    const open = this.root.classList.toggle("open");
    this.button.setAttribute("aria-expanded", String(open));
  }
}

/** @param {string} where @returns {[string, string]} */
function parted(where) {
  const at = where.indexOf("=");
  return [where.slice(0, at), where.slice(at + 1)];
}

/** @param {string} column @param {string} value */
function shown(column, value) {
  if (column === "folder" && value.length > LONG) return `…${value.slice(value.lastIndexOf("/"))}`;
  return value || (EMPTY[column] ?? `no ${column}`);
}
