/** Plots of how a part moves: where it goes, and when. */

import { el, shape } from "./dom.js";
import { nameOf } from "./names.js";

const LEVELS = ["low", "mid", "high"];
const DIRECTIONS = ["right", "r_forward", "forward", "l_forward", "left", "l_back", "back", "r_back"]; // counterclockwise, seen from above
const APART = 88; // from the middle of a level to that of the next
const RING = 27; // from place to a direction

/**
 * Return the 27 cells laid flat: low, mid and high beside each other, each seen from above, forward up,
 * place in the middle. The larger and darker a cell, the more movements go there.
 * @param {Record<string, number>} cells movements by cell
 * @param {string} name of what they are
 */
export function cellPlot(cells, name) {
  const all = Object.values(cells).reduce((sum, it) => sum + it, 0) || 1, most = Math.max(...Object.values(cells), 1);
  const first = Object.entries(cells).sort((a, b) => b[1] - a[1]).slice(0, 3).map(([cell, count]) => `${nameOf(cell)} ${percent(count / all)}`);
  const plot = shape("svg", { class: "cells", viewBox: `-42 -42 ${2 * APART + 84} 100`, role: "img", "aria-label": `${name}: ${first.join(", ") || "no movement"}` });
  LEVELS.forEach((level, column) => {
    plot.append(shape("circle", { class: "rim", cx: APART * column, cy: 0, r: 40 }), shape("text", { x: APART * column, y: 53 }, level));
    [["place", 0, 0], ...DIRECTIONS.map((it, at) => [it, RING * Math.cos(at * Math.PI / 4), -RING * Math.sin(at * Math.PI / 4)])].forEach(([direction, x, y]) => {
      const cell = `${direction} ${level}`, count = cells[cell] ?? 0, share = count / most;
      plot.append(shape("circle", { class: count ? "cell" : "none", cx: APART * column + Number(x), cy: y, r: count ? 3 + 8 * Math.sqrt(share) : 1.5, opacity: count ? 0.35 + 0.65 * share : 1 },
        shape("title", {}, `${nameOf(cell)}: ${count.toLocaleString("en")}, ${percent(count / all)}`)));
    });
  });
  return plot;
}

/**
 * Return how many movements a second begin in each of equal stretches of the captures.
 * @param {number[]} rates
 * @param {number} most of all that are compared
 */
export function ratePlot(rates, most) {
  const wide = 200 / rates.length, mean = rates.reduce((sum, it) => sum + it, 0) / rates.length;
  return shape("svg", { class: "rates", viewBox: "0 -50 200 61", role: "img", "aria-label": `${mean.toFixed(2)} movements a second, from the captures' beginnings to their ends` },
    ...rates.map((rate, at) => shape("rect", { x: at * wide + 0.5, y: -40 * rate / (most || 1), width: wide - 1, height: 40 * rate / (most || 1) }, shape("title", {}, `${rate.toFixed(2)} a second`))),
    shape("path", { d: "M0 0h200" }),
    shape("path", { class: "most", d: "M0 -40h200" }),
    shape("text", { x: 0, y: -43 }, `${most.toFixed(2)} a second`),
    shape("text", { x: 0, y: 9 }, "beginning"),
    shape("text", { x: 200, y: 9, class: "end" }, "end"));
}

/** @param {number} share */
export function percent(share) {
  return `${(100 * share).toFixed(share < 0.1 ? 1 : 0)} %`;
}

/**
 * Return how far a job is, with a button that breaks it off.
 * @param {() => void} cancel
 */
export function progressBar(cancel) {
  const bar = el("progress", { "aria-label": "Progress" }), text = el("span", { class: "soft num" }, "Begins\u2026");
  const root = el("div", { class: "row" }, bar, text, el("button", { type: "button", onclick: cancel }, "Cancel"));
  /** @param {[string, number, number]} progress */
  const tell = ([noun, done, total]) => {
    if (!total) return;
    bar.max = total;
    bar.value = done;
    text.textContent = `${done.toLocaleString("en")} of ${total.toLocaleString("en")} ${noun}`;
  };
  return { root, tell };
}
