// Captures that are added: chosen or dropped, sent, read; what became of each file.

import { follow, get, goingOn, problemOf, send } from "../../api.js";
import { announce, counted, el, readOut, trouble } from "../../dom.js";
import { Sending } from "../../sending.js";

/** @typedef {import("../../sending.js").Given} Given */
/** @typedef {{endings: string[], pictures: string[], unread: Record<string, string>, other: string, profiles: string[]}} About */
/** @typedef {{name: string, status: string, error: string | null, doubts: string[], capture_id: number | null}} Outcome */
/** @typedef {{state: string, done: number, total: number, counts: Record<string, number>, labelled: number, error: import("../../api.js").Problem | null}} Told */

const SHOWN = 100; // lines of a list of files

/** What chooses files, how they are read, and how far they are; it goes on while other screens are shown. */
export class Adding {
  /** @type {() => void} is called when captures have come */
  came = () => {};
  root = el("section", { class: "adding", "aria-label": "Add captures", hidden: true });
  #jobs = el("div", { class: "jobs" });
  #profile = el("select", {});
  #unit = choice("found in the file", ["mm", "cm", "m", "inch"]);
  #up = choice("found in the file", ["y", "z", "x", "-y", "-z", "-x"]);
  #fps = el("input", { inputmode: "decimal", size: 6, placeholder: "the file's" });
  #sending = 0; // what is read goes on without the page, what is sent does not

  #found = false;

  constructor() {
    const files = el("input", { type: "file", multiple: true, hidden: true, onchange: () => this.#chosen(files) });
    const folder = el("input", { type: "file", webkitdirectory: true, hidden: true, onchange: () => this.#chosen(folder) });
    this.root.append(
      el("div", { class: "drop" },
        el("p", {}, el("b", {}, "Drop files or folders anywhere on this page")),
        el("p", { class: "row" },
          el("button", { type: "button", class: "main", onclick: () => files.click() }, "Choose files"),
          el("button", { type: "button", onclick: () => folder.click() }, "Choose a folder"),
          el("button", { type: "button", onclick: () => this.#example() }, "Add ten example choreographies"), files, folder),
        el("p", { class: "soft" }, "BVH, C3D, AMC with its ASF, FBX, glTF, TRC, MVNX, CSV, NumPy arrays, LND and Laban scores, or archives of them; printed scores as pictures or PDF, chosen or dropped by themselves. A table (CSV) with columns file, label and any others gives them labels."),
        el("details", {}, el("summary", {}, "How they are read"), el("div", { class: "row" },
          el("label", {}, "Profile ", this.#profile), el("label", {}, "Unit ", this.#unit),
          el("label", {}, "Upward axis ", this.#up), el("label", {}, "Frames a second ", this.#fps)))),
      this.#jobs);
    addEventListener("beforeunload", (event) => {
      if (this.#sending) event.preventDefault();
    });
  }

  async open() {
    this.root.hidden = false;
    const { profiles } = /** @type {About} */ (await get("/api/ingests"));
    const before = this.#profile.value;
    this.#profile.replaceChildren(...profiles.map((it) => el("option", { selected: it === before }, it)));
  }

  /** Find, once, what was begun before this page was loaded. */
  async find() {
    if (this.#found) return;
    this.#found = true;
    for (const job of await goingOn("ingest")) {
      await this.open();
      this.#part("Adding captures").watch(job);
    }
  }

  /** @param {string} title */
  #part(title) {
    const part = new Part(title, () => this.came());
    this.#jobs.prepend(part.root);
    return part;
  }

  /** @param {HTMLInputElement} input */
  #chosen(input) {
    this.add([...input.files ?? []].map((file) => ({ name: file.webkitRelativePath || file.name, file })));
    input.value = "";
  }

  #how() {
    const how = { unit: this.#unit.value, up: this.#up.value, fps: this.#fps.value.trim() };
    return { profile: this.#profile.value || "default", reading: Object.fromEntries(Object.entries(how).filter(([, it]) => it)) };
  }

  #example() {
    return this.#part("Adding the choreographies").read({ choreographies: true }, []);
  }

  /** @param {Given[]} files */
  add(files) {
    this.open().catch((error) => announce(problemOf(error).found));
    if (!files.length) return announce("There is no file in that.");
    return this.#part("Adding captures").send(files, this.#how(), (on) => { this.#sending += on ? 1 : -1; });
  }
}

/** Files that came together: their progress, then what became of them. */
class Part {
  #head = el("h2", {});
  #bar = el("progress", { "aria-label": "Progress" });
  #going = el("ul", { class: "going" });
  #buttons = el("p", { class: "row" });
  root = el("section", { class: "card part" }, this.#head, this.#bar, this.#going, this.#buttons);
  #came;

  /** @param {string} title @param {() => void} came */
  constructor(title, came) {
    this.#head.textContent = title;
    this.#came = came;
  }

  /**
   * Send files, then have them read.
   * @param {Given[]} files
   * @param {Record<string, unknown>} how
   * @param {(on: boolean) => void} sends is told when it begins to send, and when it has
   */
  async send(files, how, sends) {
    try {
      /** @type {About} */
      const about = await get("/api/ingests");
      /** @type {{name: string, reason: string}[]} */
      const left = [];
      const worth = files.filter(({ name }) => {
        const lower = name.toLowerCase(), printed = !name.includes("/") && about.pictures.some((it) => lower.endsWith(it)); // in folders, most are of something else
        const fits = printed || about.endings.some((it) => lower.endsWith(it));
        const ending = Object.keys(about.unread).find((it) => lower.endsWith(it));
        if (!fits) left.push({ name, reason: ending ? about.unread[ending] : about.other });
        return fits;
      });
      const sending = new Sending(worth, () => this.#sends(sending));
      const pause = el("button", { type: "button", onclick: () => {
        sending.pause(!sending.paused);
        pause.textContent = sending.paused ? "Resume" : "Pause";
      } }, "Pause");
      this.#buttons.replaceChildren(pause, el("button", { type: "button", onclick: () => sending.cancel() }, "Cancel"));
      sends(true);
      await sending.run().finally(() => sends(false));
      this.#going.replaceChildren();
      const sent = sending.items.filter((it) => it.state === "sent");
      const failed = sending.items.filter((it) => it.state === "failed").map((it) => ({ name: it.name, reason: it.problem?.found ?? "" }));
      if (sending.cancelled) this.#end("Cancelled: nothing was read", [], failed, left);
      else if (!sent.length) this.#end("Nothing to read", [], failed, left);
      else await this.read({ files: Object.fromEntries(sent.map((it) => [it.name, it.kept])), ...how }, left, failed);
    } catch (error) {
      this.#fail(error);
    }
  }

  /**
   * @param {Record<string, unknown>} what
   * @param {{name: string, reason: string}[]} left
   * @param {{name: string, reason: string}[]} [unsent]
   */
  async read(what, left, unsent = []) {
    try {
      const { job } = await send("POST", "/api/ingests", what);
      await this.watch(job, left, unsent);
    } catch (error) {
      this.#fail(error);
    }
  }

  /**
   * Show how far a job is, then what became of its files.
   * @param {string} job
   * @param {{name: string, reason: string}[]} [left]
   * @param {{name: string, reason: string}[]} [unsent]
   */
  async watch(job, left = [], unsent = []) {
    try {
      this.#buttons.replaceChildren(el("button", { type: "button", onclick: () => send("DELETE", `/api/jobs/${job}`).catch((error) => announce(problemOf(error).found)) }, "Cancel"));
      /** @type {Told} */
      const told = await new Promise((resolve, reject) => follow(`/api/jobs/${job}/events`, (/** @type {Told} */ it) => {
        this.#reads(it);
        if (it.state !== "running") resolve(it);
      }, () => reject(new TypeError("no answer"))));
      /** @type {Outcome[]} */
      const outcomes = [];
      for (;;) {
        const page = await get(`/api/ingests/${job}?at=${outcomes.length}`);
        if (!outcomes.length) left.push(...page.left);
        if (!page.outcomes.length) break;
        outcomes.push(...page.outcomes);
      }
      if (told.error) this.root.append(trouble(told.error));
      this.#end(told.state === "cancelled" ? `Cancelled: ${summed(told)}` : summed(told), outcomes, unsent, left);
      this.#came();
    } catch (error) {
      this.#fail(error);
    }
  }

  /** @param {Sending} sending */
  #sends({ items, paused }) {
    const sent = items.filter((it) => it.state === "sent").length;
    this.#head.textContent = `${paused ? "Paused" : "Sending"}: ${sent.toLocaleString("en")} of ${counted(items.length, "file")}`;
    this.#bar.max = items.reduce((sum, it) => sum + it.file.size, 1);
    this.#bar.value = items.reduce((sum, it) => sum + it.bytes, 0);
    this.#going.replaceChildren(...items.filter((it) => it.state === "going").map((it) =>
      el("li", {}, el("span", { class: "grow path" }, it.name), el("progress", { max: it.file.size || 1, value: it.bytes, "aria-label": `Sent of ${it.name}` }))));
  }

  /** @param {Told} told */
  #reads({ done, total, counts }) {
    const failed = counts.failed ? `, ${counts.failed} failed` : "";
    this.#head.textContent = `Reading: ${done.toLocaleString("en")} of ${counted(total, "capture")}${failed}`;
    this.#bar.max = total || 1;
    this.#bar.value = done;
  }

  /**
   * @param {string} title
   * @param {Outcome[]} outcomes
   * @param {{name: string, reason: string}[]} unsent
   * @param {{name: string, reason: string}[]} left
   */
  #end(title, outcomes, unsent, left) {
    const failed = [...unsent, ...outcomes.filter((it) => it.status === "failed").map((it) => ({ name: "", reason: it.error ?? it.name }))];
    const said = [title, unsent.length && `${unsent.length} not sent`, left.length && `${left.length} left out`].filter(Boolean).join(", ");
    this.#head.textContent = said;
    readOut(said);
    this.#bar.remove();
    this.#going.remove();
    this.#buttons.replaceChildren(
      outcomes.some((it) => it.status === "added") && el("a", { href: "/?sort=-added" }, "Show the newest") || "",
      el("button", { type: "button", onclick: () => this.root.remove() }, "Close"));
    const added = outcomes.filter((it) => it.status === "added");
    this.root.append(
      ...listed("Failed", failed.map((it) => [it.name && el("b", {}, `${it.name} `), it.reason]), true),
      ...listed("With doubts", added.filter((it) => it.doubts.length).map((it) => [link(it), `: ${it.doubts.join("; ")}`]), false),
      ...listed("Added", added.map((it) => [link(it)]), false),
      ...listed("Unchanged", outcomes.filter((it) => it.status === "unchanged").map((it) => [link(it)]), false),
      ...listed("Left out", left.map((it) => [`${it.name}: ${it.reason}`]), false));
  }

  /** @param {unknown} error */
  #fail(error) {
    this.#head.textContent = "Nothing was added";
    this.#bar.remove();
    this.#going.remove();
    this.#buttons.replaceChildren(el("button", { type: "button", onclick: () => this.root.remove() }, "Close"));
    this.root.append(trouble(problemOf(error)));
  }
}

/** @param {Told} told */
function summed({ counts, labelled }) {
  const some = ["added", "unchanged", "failed"].filter((it) => counts[it] || it === "added").map((it) => `${(counts[it] ?? 0).toLocaleString("en")} ${it}`);
  return [...some, labelled && `${labelled} labelled anew`].filter(Boolean).join(", ");
}

/** @param {Outcome} outcome */
function link(outcome) {
  return outcome.capture_id === null ? outcome.name : el("a", { href: `/captures/${outcome.capture_id}` }, outcome.name);
}

/**
 * Return a list that opens, of as many lines as can be read.
 * @param {string} title
 * @param {import("../../dom.js").Child[][]} lines
 * @param {boolean} open
 */
function listed(title, lines, open) {
  if (!lines.length) return [];
  const more = lines.length - SHOWN;
  return [el("details", { open }, el("summary", {}, `${title}: ${lines.length.toLocaleString("en")}`),
    el("ul", {}, ...lines.slice(0, SHOWN).map((it) => el("li", { class: "path" }, ...it)), more > 0 && el("li", { class: "soft" }, `and ${more.toLocaleString("en")} more`)))];
}

/** @param {string} none @param {string[]} values */
function choice(none, values) {
  return el("select", {}, el("option", { value: "" }, none), ...values.map((it) => el("option", {}, it)));
}
