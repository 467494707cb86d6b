/** Fields of numbers: with a unit, what is allowed, what other profiles have, and back to before. */

import { el } from "./dom.js";

/**
 * @typedef {object} Field
 * @property {string} label
 * @property {string} [says] what it is
 * @property {string} [unit] of a bare number
 * @property {string[]} [units] of which one is chosen
 * @property {() => [number, number]} limits
 * @property {() => {value: number, unit?: string}} get
 * @property {(value: number, unit: string) => void} set
 * @property {() => boolean} [touched] whether it differs from the profile
 * @property {() => void} [back] takes what the profile has
 * @property {[string, string, () => void][]} [others] name, text and what takes it, of other profiles
 * @property {boolean} [whole]
 * @property {boolean} [slider]
 * @property {(on: boolean) => void} [focus]
 */

let count = 0;

/**
 * Return the row of a field, and what shows its number anew.
 * @param {Field} field
 * @returns {{node: HTMLElement, update: () => void}}
 */
export function numberField(field) {
  const id = `number-${++count}`, step = field.whole ? 1 : "any";
  const number = el("input", { type: "number", id, step, class: "num", "aria-describedby": `${id}-says ${id}-wrong`, oninput: () => take(number.value) });
  const slider = field.slider ? el("input", { type: "range", step: "any", "aria-label": `${field.label}, slider`, oninput: () => take(slider?.value ?? "") }) : null;
  const unit = field.units
    ? el("select", { "aria-label": `Unit of ${field.label}`, onchange: () => take(number.value) }, ...field.units.map((it) => el("option", { value: it }, it)))
    : null;
  const wrong = el("span", { id: `${id}-wrong`, class: "wrong", role: "status" });
  const back = field.back ? el("button", { type: "button", class: "plain", title: "As in the profile", "aria-label": `${field.label}: as in the profile`, onclick: field.back }, "\u21ba") : null;
  const node = el("div", { class: "number" },
    el("label", { for: id }, field.label),
    el("span", { class: "row" }, number, unit ?? (field.unit ? el("span", { class: "soft" }, field.unit) : null), back),
    slider,
    el("span", { id: `${id}-says`, class: "soft says" }, field.says ?? ""),
    el("span", { class: "others" }, ...(field.others ?? []).map(([name, text, act]) =>
      el("button", { type: "button", class: "plain soft", "aria-label": `${field.label}: ${name} ${text}`, onclick: act }, `${name} ${text}`))),
    wrong);
  if (field.focus) {
    node.addEventListener("focusin", () => field.focus?.(true));
    node.addEventListener("focusout", () => field.focus?.(false));
  }

  /** @param {string} text */
  function take(text) {
    const value = Number(text), [low, high] = field.limits();
    const bad = text.trim() === "" || !(value >= low && value <= high) || field.whole && !Number.isInteger(value);
    const allowed = `${shown(low)} to ${shown(high)}${unit ? ` ${unit.value}` : field.unit === "\u00b0" ? "\u00b0" : ""}`;
    wrong.textContent = bad ? `${text.trim() || "Nothing"} is not allowed: a ${field.whole ? "whole " : ""}number from ${allowed}.` : "";
    number.setAttribute("aria-invalid", String(bad));
    if (!bad) field.set(value, unit?.value ?? "");
  }

  function update() {
    const { value, unit: own } = field.get(), [low, high] = field.limits();
    if (document.activeElement !== number || Number(number.value) !== value) number.value = shown(value);
    if (unit && own) unit.value = own;
    if (slider) {
      [slider.min, slider.max] = [String(low), String(high)];
      slider.value = String(value);
    }
    if (back) back.hidden = !field.touched?.();
    wrong.textContent = "";
    number.removeAttribute("aria-invalid");
  }

  update();
  return { node, update };
}

/**
 * Return a number with as many digits as it needs, five behind the point at most.
 * @param {number} value
 */
export function shown(value) {
  return String(Math.round(value * 1e5) / 1e5);
}
