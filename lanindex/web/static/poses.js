// Poses of captures, which come when they are about to be seen.

import { ask, isAbort } from "./api.js";
import { svg } from "./dom.js";

const AT_ONCE = 3; // of the six requests that a browser makes at once: a list never waits for poses

/** Fills elements with the poses of captures when they come near the window. */
export class Poses {
  #seen = new IntersectionObserver((entries) => this.#sort(entries), { rootMargin: "500px" });
  /** @type {Map<Element, string>} */
  #addresses = new Map();
  /** @type {Set<Element>} */
  #near = new Set();
  #running = 0;
  #signal;

  /** @param {AbortSignal} signal */
  constructor(signal) {
    this.#signal = signal;
    signal.addEventListener("abort", () => this.clear());
  }

  /**
   * @param {Element} node
   * @param {{capture_id: number, sha256: string}} capture
   */
  add(node, capture) {
    this.#addresses.set(node, `/api/captures/${capture.capture_id}/pose?of=${capture.sha256.slice(0, 16)}`);
    this.#seen.observe(node);
  }

  /** Forget all elements. */
  clear() {
    this.#seen.disconnect();
    this.#addresses.clear();
    this.#near.clear();
  }

  /** @param {IntersectionObserverEntry[]} entries */
  #sort(entries) {
    for (const { target, isIntersecting } of entries) {
      if (isIntersecting) this.#near.add(target);
      else this.#near.delete(target);
    }
    this.#next();
  }

  #next() {
    for (const node of this.#near) {
      if (this.#running >= AT_ONCE) return;
      this.#near.delete(node);
      const address = this.#addresses.get(node);
      if (address && this.#addresses.delete(node)) this.#fill(node, address);
      this.#seen.unobserve(node);
    }
  }

  /**
   * @param {Element} node
   * @param {string} address
   */
  async #fill(node, address) {
    this.#running++;
    try {
      const answer = await ask(address, { signal: this.#signal });
      const drawn = svg(await answer.text());
      drawn.setAttribute("aria-hidden", "true"); // the text beside it says whose pose it is
      drawn.querySelector("title")?.remove();
      node.replaceChildren(drawn);
    } catch (error) {
      if (!isAbort(error)) node.classList.add("unknown");
    }
    this.#running--;
    this.#next();
  }
}
