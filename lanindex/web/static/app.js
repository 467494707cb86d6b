// The frame of the page: which screen an address shows, and how links move between them.

import { get, problemOf, isAbort } from "./api.js";
import { announce, byId, el, trouble } from "./dom.js";
import { takeNames } from "./names.js";
import { filesOf } from "./sending.js";

/**
 * @typedef {Object} Library
 * @property {string} name
 * @property {string} file as a command names it
 * @property {string} version
 * @property {number} stamp
 * @property {boolean} readonly
 * @property {number} captures
 * @property {number} symbols
 * @property {number} seconds
 * @property {string[]} parts
 * @property {Record<string, string>} names of parts and directions, as a person says them
 * @property {string[]} columns
 * @property {string} folder the one in which all captures are
 */

/**
 * What a screen is given. It draws into `main`, keeps what it shows in the address (`go`, `replace`),
 * and returns what is to be done when another screen comes.
 * @typedef {Object} App
 * @property {HTMLElement} main
 * @property {URL} url
 * @property {Library} library
 * @property {AbortSignal} signal - aborted when another screen comes
 * @property {(title: string) => void} title
 * @property {(path: string) => void} go - to another address, which Back returns from
 * @property {(path: string) => void} replace - tells the address of what is shown now
 * @property {(path: string) => void} push - the same, and Back returns to what was shown before
 * @property {() => Promise<void>} refresh - asks for the library anew
 */

/** @typedef {(app: App) => void | (() => void) | Promise<void | (() => void)>} Show */

/** @type {{path: RegExp, name: string, link?: string, load: () => Promise<{show: Show}>}[]} */
const SCREENS = [
  { path: /^\/$/, name: "Library", link: "/", load: () => import("./screens/library.js") },
  { path: /^\/search$/, name: "Search", link: "/search", load: () => import("./screens/search.js") },
  { path: /^\/captures\/\d+$/, name: "Capture", load: () => import("./screens/capture.js") },
  { path: /^\/convert$/, name: "Convert", link: "/convert", load: () => import("./screens/convert.js") },
  { path: /^\/edit$/, name: "Edit", link: "/edit", load: () => import("./screens/edit.js") },
  { path: /^\/compare$/, name: "Compare", link: "/compare", load: () => import("./screens/compare.js") },
  { path: /^\/explore$/, name: "Explore", link: "/explore", load: () => import("./screens/explore.js") },
  { path: /^\/words$/, name: "Words", link: "/words", load: () => import("./screens/words.js") },
  { path: /^\/help(\/[^/]+)?$/, name: "Help", link: "/help", load: () => import("./screens/help.js") },
];

/** @type {Library | undefined} */
let library;
/** @type {AbortController} */
let current = new AbortController();
/** @type {void | (() => void)} */
let leave;

/** @param {URL} url */
async function open(url) {
  current.abort();
  const own = (current = new AbortController());
  if (leave) leave();
  leave = undefined;
  const screen = SCREENS.find((it) => it.path.test(url.pathname));
  mark(screen?.link);
  const main = byId("main");
  main.replaceChildren();
  main.className = "";
  try {
    if (!screen) throw new Error("there is no such page");
    const [about, { show }] = await Promise.all([library ?? get("/api/library", own.signal), screen.load()]);
    library = /** @type {Library} */ (about);
    takeNames(library.names);
    byId("library").textContent = library.name;
    if (own.signal.aborted) return;
    title(screen.name);
    const done = await show({ main, url, library, signal: own.signal, title, go, replace, push, refresh });
    if (own.signal.aborted && done) done();
    else leave = done;
  } catch (error) {
    if (!isAbort(error)) main.replaceChildren(trouble(problemOf(error)));
  }
}

async function refresh() {
  library = await get("/api/library");
}

/** @param {string} name */
function title(name) {
  document.title = `${name} · ${library?.name ?? "LanIndex"}`;
}

/** @param {string} path */
function go(path) {
  history.pushState(null, "", path);
  scrollTo(0, 0);
  return open(new URL(location.href)).then(() => {
    const main = byId("main"); // unless the screen has put the focus where it begins
    if (!main.contains(document.activeElement)) main.focus({ preventScroll: true });
  });
}

/** @param {string} path */
function replace(path) {
  history.replaceState(null, "", path);
}

/** @param {string} path */
function push(path) {
  history.pushState(null, "", path);
}

/** @param {string | undefined} link */
function mark(link) {
  for (const node of byId("screens").querySelectorAll("a")) {
    if (node.getAttribute("href") === link) node.setAttribute("aria-current", "page");
    else node.removeAttribute("aria-current");
  }
}

document.addEventListener("click", (event) => {
  const link = /** @type {Element} */ (event.target).closest?.("a");
  if (!link || event.defaultPrevented || event.button || event.metaKey || event.ctrlKey || event.shiftKey) return;
  if (link.origin !== location.origin || link.target || link.hasAttribute("download") || link.pathname.startsWith("/api/")) return;
  if (link.hash && link.pathname === location.pathname) return;
  event.preventDefault();
  go(link.pathname + link.search + link.hash);
});
const carries = (/** @type {DragEvent} */ event) => event.dataTransfer?.types.includes("Files") ?? false;
addEventListener("dragover", (event) => {
  if (!carries(event)) return;
  event.preventDefault(); // else the browser leaves the page for the file
  document.body.classList.toggle("dropping", library?.readonly === false);
});
addEventListener("dragleave", (event) => {
  if (!event.relatedTarget) document.body.classList.remove("dropping");
});
addEventListener("drop", async (event) => {
  document.body.classList.remove("dropping");
  if (!carries(event) || !event.dataTransfer) return;
  event.preventDefault();
  const dropped = filesOf(event.dataTransfer);
  if (library?.readonly) return announce("This library is only shown: nothing can be added to it.");
  try {
    const files = await dropped, { adding } = await import("./screens/library.js");
    if (location.pathname !== "/") await go("/");
    await adding().add(files);
  } catch (error) {
    announce(problemOf(error).found);
  }
});
addEventListener("popstate", () => open(new URL(location.href)));

byId("screens").append(...SCREENS.filter((it) => it.link).map((it) => el("a", { href: it.link }, it.name)));
open(new URL(location.href));
