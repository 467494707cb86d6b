/** Buttons, switches and choices of the player and the figure. */

const SVG = "http://www.w3.org/2000/svg";

/** Outlines of icons, 24 × 24. */
const ICONS = {
  play: "M7 4.5v15l13-7.5z",
  pause: "M6 4.5h4.5v15H6zM13.5 4.5H18v15h-4.5z",
  back: "M17 5v14L7.5 12zM5 5h2v14H5z",
  next: "M7 5v14l9.5-7zM17 5h2v14h-2z",
  loop: "M17 2l4 4-4 4V7H7a2 2 0 0 0-2 2v2H3V9a4 4 0 0 1 4-4h10zM7 22l-4-4 4-4v3h10a2 2 0 0 0 2-2v-2h2v2a4 4 0 0 1-4 4H7z",
};

/** @typedef {keyof typeof ICONS} Icon */

/**
 * Return an icon, which a screen reader leaves out.
 * @param {Icon} name
 */
function icon(name) {
  const svg = document.createElementNS(SVG, "svg"), path = document.createElementNS(SVG, "path");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("class", "icon");
  svg.setAttribute("aria-hidden", "true");
  path.setAttribute("d", ICONS[name]);
  svg.append(path);
  return svg;
}

/**
 * Give a button its icon, its name and its key.
 * @param {HTMLButtonElement} node
 * @param {Icon} name
 * @param {string} label
 * @param {string} key as in `aria-keyshortcuts`
 */
export function face(node, name, label, key) {
  node.replaceChildren(icon(name));
  node.setAttribute("aria-label", label);
  node.setAttribute("aria-keyshortcuts", key);
  node.title = `${label} (${key})`;
}

/**
 * Return a button.
 * @param {() => void} press
 * @param {string} text
 */
export function button(press, text = "") {
  const node = document.createElement("button");
  node.type = "button";
  node.textContent = text;
  node.addEventListener("click", press);
  return node;
}

/**
 * Return a button that is on or off.
 * @param {(on: boolean) => void} turn
 * @param {boolean} on
 * @param {string} text
 */
export function toggle(turn, on, text = "") {
  const node = button(() => {
    const now = node.getAttribute("aria-pressed") !== "true";
    node.setAttribute("aria-pressed", String(now));
    turn(now);
  }, text);
  node.setAttribute("aria-pressed", String(on));
  return node;
}

/**
 * Return a toolbar.
 * @param {string} label
 * @param {Node[]} children
 */
export function toolbar(label, children) {
  const node = document.createElement("div");
  node.className = "toolbar";
  node.setAttribute("role", "toolbar");
  node.setAttribute("aria-label", label);
  node.append(...children);
  return node;
}
