/** The staff beside the figure: it moves below a line that stands where the figure is. */

/**
 * A stretch of a staff: where it has some seconds, `times` and `ys` tell, the later the higher, in
 * units of the drawing, straight between them; below `names` are the names of its columns.
 * @typedef {{svg: string, times: number[], ys: number[], names: number}} Piece
 *
 * @typedef {object} Options
 * @property {number} seconds how long all of it is
 * @property {number} [span] seconds of a piece
 * @property {(from: number, to: number, zoom: number, signal: AbortSignal) => Promise<Piece>} load
 * @property {(svg: string) => SVGSVGElement} parse returns the node of a drawing, adopted
 * @property {(seconds: number) => void} seek is called when another time is wanted
 * @property {(symbol: SVGElement) => void} pick is called when a symbol is chosen
 * @property {(range: [number, number] | null) => void} select is called when a stretch is chosen
 *
 * @typedef {{node: HTMLElement, piece: Piece, from: number, to: number, wide: number, tall: number}} Held
 */

const LINE = 1 / 4; // of the height above the names is below the line
const NAME = 120, LETTER = 0.6; // units that the name of a column is high, and as a share of that a letter is wide
const LOW = 240; // pixels below which the names of the columns would take too much of the staff
const LARGEST = 0.13, LEAST = 0.08; // pixels of a unit of the drawing: a wider staff is scrolled aside
const KEPT = 24; // pieces, at most
const ZOOMS = [0.25, 0.5, 1, 2, 4];
const STEP = 0.25; // seconds of an arrow key
const JUMP = 1, SETTLED = 150; // seconds that are not played but jumped over; ms for which it stays then
const CLICK = 4; // pixels that a press may move and still be none that drags
const KEYS = "Up and down arrows move in time, with shift they select, left and right choose a symbol, enter takes it, plus and minus change its size, escape selects nothing.";

export class StaffView {
  #options;
  #span;
  /** @type {Map<number, Held | "failed">} pieces by number, the one used last at the end */
  #held = new Map();
  /** @type {AbortController | null} of the piece that is on its way, one after the other */
  #coming = null;
  /** @type {Map<number, Held>} pieces that are shown until those come that are taken anew */
  #stale = new Map();
  #layer = document.createElement("div");
  #names = document.createElement("div");
  #line = document.createElement("div");
  #mark = document.createElement("div");
  #state = document.createElement("p");
  #zoom = 2;
  #time = 0;
  #across = 0; // pixels of its width
  #settling = 0; // a timer, from a jump until it stays there
  #round = 0;
  #named = -1; // of which round the names of the columns are
  /** @type {[number, number] | null} */
  #range = null;
  /** @type {SVGElement | null} */
  #chosen = null;
  #gone = new AbortController();

  /**
   * @param {HTMLElement} root
   * @param {Options} options
   */
  constructor(root, options) {
    this.root = root;
    this.#options = options;
    this.#span = options.span ?? 10;
    root.classList.add("staff");
    root.tabIndex = 0;
    root.setAttribute("role", "application");
    root.setAttribute("aria-label", `The staff. ${KEYS}`);
    this.#layer.className = "staff-layer";
    this.#names.className = "staff-names";
    this.#line.className = "staff-line";
    this.#mark.className = "staff-selected";
    this.#state.className = "staff-state";
    this.#state.setAttribute("role", "status");
    this.#mark.hidden = true;
    root.append(this.#mark, this.#layer, this.#names, this.#line, this.#state);
    this.#listen();
  }

  /** The seconds at the line. */
  get time() {
    return this.#time;
  }

  /** What is selected, from and to, seconds. */
  get range() {
    return this.#range;
  }

  /** @param {[number, number] | null} range */
  set range(range) {
    this.#range = range;
    this.#place();
  }

  /**
   * Move the staff so that some seconds are at the line, at once.
   * @param {number} seconds
   */
  show(seconds) {
    if (Math.abs(seconds - this.#time) > JUMP) {
      clearTimeout(this.#settling);
      this.#settling = setTimeout(() => {
        this.#settling = 0;
        this.#place();
      }, SETTLED);
    }
    this.#time = seconds;
    this.#place();
  }

  /** Take all pieces anew: the score has changed, or other columns are wanted. */
  reload() {
    this.#giveUp();
    for (const [number, held] of this.#held) {
      if (!isHeld(held)) continue;
      this.#stale.get(number)?.node.remove();
      this.#stale.set(number, held);
    }
    this.#held.clear();
    this.#chosen = null;
    this.#place();
  }

  dispose() {
    clearTimeout(this.#settling);
    this.#gone.abort();
    this.#giveUp();
    this.root.replaceChildren();
  }

  #listen() {
    const { root } = this, { signal } = this.#gone;
    const sizes = new ResizeObserver(() => this.#place());
    sizes.observe(root);
    signal.addEventListener("abort", () => sizes.disconnect());
    root.addEventListener("keydown", (event) => this.#key(event), { signal });
    root.addEventListener("wheel", (event) => {
      if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) return; // it is scrolled aside
      event.preventDefault();
      if (event.ctrlKey) this.#larger(-Math.sign(event.deltaY));
      else this.#go(this.#secondsAt(this.#lineAt() + Math.max(-200, Math.min(200, event.deltaY)) / 2));
    }, { signal, passive: false });
    /** @type {{y: number, from: number, target: Element, moved: boolean} | null} */
    let press = null;
    root.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      press = { y: event.clientY, from: this.#secondsAt(this.#inside(event)), target: /** @type {Element} */ (event.target), moved: false };
      root.setPointerCapture(event.pointerId);
    }, { signal });
    root.addEventListener("pointermove", (event) => {
      if (!press || !(press.moved ||= Math.abs(event.clientY - press.y) > CLICK)) return;
      this.#select(press.from, this.#secondsAt(this.#inside(event)));
    }, { signal });
    root.addEventListener("pointerup", () => {
      if (press && !press.moved) {
        const symbol = press.target.closest("g[data-part]");
        if (symbol instanceof SVGElement) this.#choose(symbol, true);
        else this.#go(press.from);
      }
      press = null;
    }, { signal });
    root.addEventListener("pointercancel", () => { press = null; }, { signal });
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const way = { ArrowUp: 1, ArrowDown: -1 }[event.key] ?? 0, aside = { ArrowRight: 1, ArrowLeft: -1 }[event.key] ?? 0;
    if (way && event.shiftKey) {
      const start = this.#range && this.#range.includes(this.#time)
        ? this.#range[this.#range[0] === this.#time ? 1 : 0]
        : this.#time;
      const to = this.#clipped(this.#time + way * STEP);
      this.#go(to);
      this.#select(start, to);
    } else if (way) this.#go(this.#time + way * STEP);
    else if (aside) this.#beside(aside);
    else if (event.key === "Enter" && this.#chosen) this.#options.pick(this.#chosen);
    else if (event.key === "Escape" && this.#range) {
      this.range = null;
      this.#options.select(null);
    } else if (event.key === "+" || event.key === "=") this.#larger(1);
    else if (event.key === "-") this.#larger(-1);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** @param {number} seconds */
  #clipped(seconds) {
    return Math.min(Math.max(seconds, 0), this.#options.seconds);
  }

  /** @param {number} seconds */
  #go(seconds) {
    this.show(this.#clipped(seconds));
    this.#options.seek(this.#time);
  }

  /**
   * @param {number} from
   * @param {number} to
   */
  #select(from, to) {
    const range = /** @type {[number, number]} */ ([from, to].map((it) => this.#clipped(it)).sort((a, b) => a - b));
    this.range = range[0] < range[1] ? range : null;
    this.#options.select(this.#range);
  }

  /** @param {number} by */
  #larger(by) {
    const before = this.#zoom;
    this.#zoom = Math.min(Math.max(this.#zoom + by, 0), ZOOMS.length - 1);
    if (this.#zoom !== before) this.reload();
  }

  /**
   * Choose the next symbol aside of those at the line.
   * @param {number} way
   */
  #beside(way) {
    const last = Math.ceil(this.#options.seconds / this.#span) - 1, line = this.#line.getBoundingClientRect().top + 1;
    const here = this.#piece(Math.min(Math.floor(this.#time / this.#span), last));
    const now = [...here?.node.querySelectorAll("g[data-part]") ?? []].flatMap((node) => {
      const { left, top, bottom } = node.getBoundingClientRect();
      return node instanceof SVGElement && top <= line && line <= bottom ? [{ node, left }] : [];
    }).sort((a, b) => a.left - b.left).map(({ node }) => node);
    const at = this.#chosen ? now.indexOf(this.#chosen) : -1;
    const next = now[at < 0 ? (way > 0 ? 0 : now.length - 1) : Math.min(Math.max(at + way, 0), now.length - 1)];
    if (next) this.#choose(next, false);
  }

  /**
   * @param {SVGElement} symbol
   * @param {boolean} pick
   */
  #choose(symbol, pick) {
    this.#chosen?.classList.remove("chosen");
    this.#chosen = symbol;
    symbol.classList.add("chosen");
    const said = symbol.querySelector("title")?.textContent ?? "";
    this.#state.textContent = said;
    const { root } = this, inside = root.getBoundingClientRect(), { left, right } = symbol.getBoundingClientRect();
    if (left < inside.left || right > inside.left + root.clientWidth) root.scrollLeft += (left + right) / 2 - inside.left - root.clientWidth / 2;
    if (pick) this.#options.pick(symbol);
  }

  #lineAt() {
    return (this.root.clientHeight - this.#names.clientHeight) * (1 - LINE);
  }

  /** @param {PointerEvent} event */
  #inside(event) {
    return event.clientY - this.root.getBoundingClientRect().top;
  }

  /**
   * Return a piece; fetch it if it is not there.
   * @param {number} number
   * @returns {Held | null}
   */
  #piece(number) {
    const held = this.#held.get(number);
    if (held === undefined && !this.#coming) this.#load(number);
    if (!isHeld(held)) return this.#stale.get(number) ?? null;
    this.#held.delete(number);
    this.#held.set(number, held);
    return held;
  }

  /** @param {number} number */
  async #load(number) {
    const from = number * this.#span, to = Math.min(from + this.#span, this.#options.seconds), round = this.#round;
    if (from >= to) return;
    const coming = (this.#coming = new AbortController());
    try {
      const piece = await this.#options.load(from, to, ZOOMS[this.#zoom], coming.signal);
      if (round !== this.#round) return;
      this.#coming = null;
      this.#held.set(number, this.#hold(piece, from, to));
      this.#stale.get(number)?.node.remove();
      this.#stale.delete(number);
      for (const [oldest, held] of this.#held) {
        if (this.#held.size <= KEPT) break;
        if (isHeld(held)) held.node.remove();
        this.#held.delete(oldest);
      }
      this.#state.textContent = "";
    } catch (error) {
      if (coming.signal.aborted || round !== this.#round) return;
      this.#coming = null;
      this.#held.set(number, "failed");
      this.#state.textContent = `The staff could not be read: ${error instanceof Error ? error.message : error}`;
    }
    this.#place();
  }

  /**
   * Cut a piece to its seconds, and take the names of the columns from the first.
   * @param {Piece} piece
   * @param {number} from
   * @param {number} to
   * @returns {Held}
   */
  #hold(piece, from, to) {
    const drawing = this.#options.parse(piece.svg), { x, width } = drawing.viewBox.baseVal;
    if (this.#named !== this.#round) {
      this.#named = this.#round;
      const names = /** @type {SVGSVGElement} */ (drawing.cloneNode(true));
      for (const child of [...names.children]) if (child.tagName !== "text" || Number(child.getAttribute("y")) < piece.names) child.remove();
      cut(names, x, piece.names, width, enlarged(names));
      names.setAttribute("aria-hidden", "true");
      this.#names.replaceChildren(names);
    }
    // the starting position stands below the first second
    const low = from ? along(from, piece.times, piece.ys) : piece.names, high = along(to, piece.times, piece.ys);
    cut(drawing, x, high, width, low - high);
    const node = document.createElement("div"); // to move a drawing itself would lay out its texts anew
    node.append(drawing);
    this.#layer.append(node);
    return { node, piece, from, to, wide: width, tall: low - high };
  }

  /** Stop what is on its way, and take nothing of it. */
  #giveUp() {
    this.#round++;
    this.#coming?.abort();
    this.#coming = null;
  }

  /** Put every piece where it is now. */
  #place() {
    const { clientWidth, clientHeight } = this.root, last = Math.ceil(this.#options.seconds / this.#span) - 1;
    if (!clientHeight) return;
    const number = Math.min(Math.floor(this.#time / this.#span), last), line = this.#lineAt();
    const shown = new Set();
    this.#line.style.transform = `translateY(${line}px)`;
    this.#names.style.display = clientHeight < LOW ? "none" : "";
    const here = this.#piece(number);
    // those beside it come after it, not while it is one that is replaced, nor from jump to jump
    const beside = (/** @type {number} */ at) => {
      if (here === this.#stale.get(number)) return this.#stale.get(at);
      return this.#settling && !isHeld(this.#held.get(at)) ? null : this.#piece(at);
    };
    if (here) {
      const scale = this.#scale(here);
      let foot = line + scale * (along(here.from, here.piece.times, here.piece.ys) - along(this.#time, here.piece.times, here.piece.ys));
      for (let at = number; at > 0 && foot < clientHeight; ) {
        const below = beside(--at);
        if (!below) break;
        foot += scale * below.tall;
        put(below, foot - scale * below.tall, scale, shown);
      }
      let roof = line + scale * (along(here.to, here.piece.times, here.piece.ys) - along(this.#time, here.piece.times, here.piece.ys));
      put(here, roof, scale, shown);
      for (let at = number; at < last && roof > -clientHeight / 2; ) {
        const above = beside(++at);
        if (!above) break;
        roof -= scale * above.tall;
        put(above, roof, scale, shown);
      }
      const names = this.#names.firstElementChild;
      if (names instanceof SVGSVGElement) {
        const { width, height } = names.viewBox.baseVal;
        names.style.width = `${scale * width}px`;
        names.style.height = `${scale * height}px`;
      }
    }
    const across = Math.max(here ? Math.floor(this.#scale(here) * here.wide) : 0, clientWidth);
    for (const it of [this.#layer, this.#names, this.#line, this.#mark]) it.style.width = `${across}px`;
    if (across !== this.#across) this.root.scrollLeft = (across - clientWidth) / 2;
    this.#across = across;
    for (const [at, held] of this.#stale) {
      if (shown.has(held)) continue;
      held.node.remove();
      this.#stale.delete(at);
    }
    for (const held of this.#held.values()) {
      if (isHeld(held)) held.node.style.display = shown.has(held) ? "" : "none";
    }
    const ends = this.#range?.map((seconds) => this.#yOf(seconds));
    this.#mark.hidden = !ends;
    if (ends) {
      this.#mark.style.transform = `translateY(${ends[1]}px)`;
      this.#mark.style.height = `${ends[0] - ends[1]}px`;
    }
  }

  /**
   * Return pixels of a unit of a piece.
   * @param {Held} held
   */
  #scale(held) {
    return Math.min(Math.max(this.root.clientWidth / held.wide, LEAST), LARGEST);
  }

  /** Return pixels of a second, about, where no piece tells. */
  #usual() {
    const held = [...this.#held.values()].find(isHeld);
    return held ? this.#scale(held) * (along(held.from, held.piece.times, held.piece.ys) - along(held.to, held.piece.times, held.piece.ys)) / (held.to - held.from) : 56;
  }

  /**
   * Return where some seconds are, pixels from the top.
   * @param {number} seconds
   */
  #yOf(seconds) {
    const number = Math.floor(Math.min(seconds, this.#options.seconds - 1e-9) / this.#span), held = this.#held.get(number);
    if (isHeld(held) && held.node.style.display !== "none") {
      const roof = Number(held.node.dataset.roof);
      return roof + this.#scale(held) * (along(seconds, held.piece.times, held.piece.ys) - along(held.to, held.piece.times, held.piece.ys));
    }
    return this.#lineAt() - (seconds - this.#time) * this.#usual();
  }

  /**
   * Return the seconds at some pixels from the top.
   * @param {number} y
   */
  #secondsAt(y) {
    for (const held of this.#held.values()) {
      if (!isHeld(held) || held.node.style.display === "none") continue;
      const roof = Number(held.node.dataset.roof), scale = this.#scale(held);
      if (y < roof || y > roof + scale * held.tall) continue;
      const unit = (y - roof) / scale + along(held.to, held.piece.times, held.piece.ys);
      return this.#clipped(along(-unit, held.piece.ys.map((it) => -it), held.piece.times));
    }
    return this.#clipped(this.#time + (this.#lineAt() - y) / this.#usual());
  }
}

/**
 * Return whether a piece is there.
 * @param {Held | "failed" | undefined} held
 * @returns {held is Held}
 */
function isHeld(held) {
  return held !== undefined && held !== "failed";
}

/**
 * @param {Held} held
 * @param {number} roof pixels from the top
 * @param {number} scale
 * @param {Set<unknown>} shown
 */
function put(held, roof, scale, shown) {
  const { node } = held;
  node.style.width = `${scale * held.wide}px`;
  node.style.height = `${scale * held.tall}px`;
  node.style.transform = `translateY(${roof}px)`;
  node.dataset.roof = String(roof);
  shown.add(held);
}

/**
 * Make the names of columns as large as they can be read, and return how much room they take.
 * @param {SVGSVGElement} names
 */
function enlarged(names) {
  let longest = 0;
  for (const name of names.querySelectorAll("text")) {
    const more = NAME - Number(name.getAttribute("font-size"));
    name.setAttribute("font-size", String(NAME));
    name.setAttribute("dy", String(more / 3)); // it stays in the middle of its column
    longest = Math.max(longest, name.textContent?.length ?? 0);
  }
  return NAME * (LETTER * longest + 1);
}

/**
 * Show a part of a drawing.
 * @param {SVGSVGElement} node
 * @param {number} x
 * @param {number} y
 * @param {number} width
 * @param {number} height
 */
function cut(node, x, y, width, height) {
  node.setAttribute("viewBox", `${x} ${y} ${width} ${height}`);
  node.setAttribute("preserveAspectRatio", "none");
  node.removeAttribute("width");
  node.removeAttribute("height");
}

/**
 * Return what stands for a number in a table, straight between its entries.
 * @param {number} value
 * @param {number[]} from rising
 * @param {number[]} to
 */
export function along(value, from, to) {
  let at = 1;
  while (at < from.length - 1 && from[at] < value) at++;
  const wide = from[at] - from[at - 1];
  return wide ? to[at - 1] + (value - from[at - 1]) / wide * (to[at] - to[at - 1]) : to[at];
}
