// Files that are sent to the server: what was dropped or chosen, three at a time, with progress.

import { isAbort, problemOf, ApiError } from "./api.js";

/** @typedef {import("./api.js").Problem} Problem */
/** @typedef {{name: string, file: File}} Given */
/** @typedef {Given & {state: "waiting" | "going" | "sent" | "failed", bytes: number, kept?: string, problem?: Problem, request?: XMLHttpRequest}} Item */

const AT_ONCE = 3;

/**
 * Return the files that were dropped, those in folders by their path below where they were dropped.
 * @param {DataTransfer} dropped
 * @returns {Promise<Given[]>}
 */
export async function filesOf(dropped) {
  const parts = [...dropped.items].filter((it) => it.kind === "file").map((it) => { // all at once: the list is emptied
    const entry = it.webkitGetAsEntry(), file = it.getAsFile();
    return entry ? filesIn(entry) : file ? [{ name: file.name, file }] : [];
  });
  return (await Promise.all(parts)).flat();
}

/** @param {FileSystemEntry} entry @returns {Promise<Given[]>} */
async function filesIn(entry) {
  if (entry.name.startsWith(".")) return [];
  if (entry.isFile) {
    const file = await new Promise((resolve, reject) => /** @type {FileSystemFileEntry} */ (entry).file(resolve, reject));
    return [{ name: entry.fullPath.replace(/^\//, ""), file }];
  }
  const reader = /** @type {FileSystemDirectoryEntry} */ (entry).createReader();
  const found = [];
  for (;;) { // a hundred at a time
    /** @type {FileSystemEntry[]} */
    const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (!some.length) return found;
    for (const one of some) found.push(...await filesIn(one));
  }
}

/** Sends files, and tells whenever something has changed. */
export class Sending {
  /** @type {Item[]} */
  items;
  paused = false;
  cancelled = false;
  #tell;
  /** @type {(() => void) | undefined} */
  #ended;

  /**
   * @param {Given[]} files
   * @param {() => void} tell
   */
  constructor(files, tell) {
    this.items = files.map((it) => ({ ...it, state: "waiting", bytes: 0 }));
    this.#tell = tell;
  }

  /** Send all; returns when each is sent or failed, or all is cancelled. */
  run() {
    return /** @type {Promise<void>} */ (new Promise((resolve) => {
      this.#ended = resolve;
      this.#next();
    }));
  }

  /** @param {boolean} paused */
  pause(paused) {
    this.paused = paused;
    if (paused) this.#abort();
    this.#next();
  }

  cancel() {
    this.cancelled = true;
    this.#abort();
    this.#next();
  }

  #abort() {
    for (const item of this.items) if (item.state === "going") item.request?.abort();
  }

  #next() {
    const going = this.items.filter((it) => it.state === "going").length;
    const waiting = this.items.filter((it) => it.state === "waiting");
    if (!going && (this.cancelled || !waiting.length)) this.#ended?.();
    if (!this.paused && !this.cancelled) for (const item of waiting.slice(0, AT_ONCE - going)) this.#send(item);
    this.#tell();
  }

  /** @param {Item} item */
  async #send(item) {
    item.state = "going";
    try {
      item.kept = await put(item, this.#tell);
      item.state = "sent";
      item.bytes = item.file.size;
    } catch (error) {
      item.state = isAbort(error) ? "waiting" : "failed";
      item.bytes = 0;
      if (!isAbort(error)) item.problem = problemOf(error);
    }
    this.#next();
  }
}

/**
 * @param {Item} item
 * @param {() => void} tell
 * @returns {Promise<string>} the name that it is kept by
 */
function put(item, tell) {
  return new Promise((resolve, reject) => {
    const request = (item.request = new XMLHttpRequest()); // fetch does not tell how much it has sent
    request.open("PUT", `/api/uploads/${item.name.split("/").map(encodeURIComponent).join("/")}`);
    request.responseType = "json";
    request.upload.onprogress = (event) => {
      item.bytes = event.loaded;
      tell();
    };
    request.onload = () => {
      if (request.status === 200) resolve(request.response.name);
      else reject(new ApiError(request.response?.error ?? { found: `the server says ${request.status}` }, request.status));
    };
    request.onerror = () => reject(new TypeError("no answer"));
    request.onabort = () => reject(new DOMException("broken off", "AbortError"));
    request.send(item.file);
  });
}
