// What the server says: JSON, bytes, and how far a job is.

/** @typedef {{found: string, place?: string, wanted?: string, remedy?: string, text?: string, start?: number, stop?: number, instead?: string}} Problem */

/** An error that the server told. */
export class ApiError extends Error {
  /** @param {Problem} problem @param {number} status */
  constructor(problem, status) {
    super(problem.found);
    this.problem = problem;
    this.status = status;
  }
}

/**
 * Return what any error is, in the server's words or the browser's.
 * @param {unknown} error
 * @returns {Problem}
 */
export function problemOf(error) {
  if (error instanceof ApiError) return error.problem;
  if (error instanceof TypeError) return { found: "the server does not answer", remedy: "Is lanindex serve still running?" };
  return { found: error instanceof Error ? error.message : String(error) };
}

/** @param {unknown} error */
export function isAbort(error) {
  return error instanceof DOMException && error.name === "AbortError";
}

/**
 * @param {string} path
 * @param {RequestInit} [options]
 * @returns {Promise<Response>}
 */
export async function ask(path, options = {}) {
  const answer = await fetch(path, { credentials: "same-origin", ...options });
  if (answer.ok) return answer;
  /** @type {Problem} */
  let problem = { found: `the server says ${answer.status}` };
  try {
    problem = (await answer.json()).error ?? problem;
  } catch {
    // no JSON: the status has to do
  }
  throw new ApiError(problem, answer.status);
}

/**
 * @param {string} path
 * @param {AbortSignal} [signal]
 * @returns {Promise<any>}
 */
export async function get(path, signal) {
  return (await ask(path, { signal })).json();
}

/**
 * @param {"POST" | "PATCH" | "PUT" | "DELETE"} method
 * @param {string} path
 * @param {unknown} [body]
 * @param {AbortSignal} [signal]
 * @returns {Promise<any>}
 */
export async function send(method, path, body = {}, signal) {
  const headers = { "content-type": "application/json" };
  return (await ask(path, { method, headers, body: JSON.stringify(body), signal })).json();
}

/**
 * Return the numbers of jobs that go on, or whose end nobody was told: those that this page had begun before it was loaded anew.
 * @param {"ingest" | "encode"} kind
 * @returns {Promise<string[]>}
 */
export async function goingOn(kind) {
  const { jobs } = await get("/api/jobs");
  return jobs.filter((/** @type {{kind: string}} */ it) => it.kind === kind).map((/** @type {{job: string}} */ it) => it.job);
}

/**
 * Follow a job until it ends; returns what stops following it.
 * @param {string} path
 * @param {(state: any) => void} tell - is given each state; the last one has `state` other than "running"
 * @param {() => void} [lost] - is called where the server is gone
 * @returns {() => void}
 */
export function follow(path, tell, lost = () => {}) {
  const source = new EventSource(path);
  source.onmessage = (event) => {
    const state = JSON.parse(event.data);
    if (state.state !== "running") source.close();
    tell(state);
  };
  source.onerror = () => {
    if (source.readyState === EventSource.CLOSED) return;
    source.close();
    lost();
  };
  return () => source.close();
}

/**
 * Return a path with the parts of its query that say something.
 * @param {string} path
 * @param {Record<string, string | number | boolean | null | undefined | (string | number)[]>} query
 */
export function address(path, query) {
  const search = new URLSearchParams();
  for (const [name, value] of Object.entries(query)) {
    for (const one of Array.isArray(value) ? value : [value]) {
      if (one !== null && one !== undefined && one !== "" && one !== false) search.append(name, String(one));
    }
  }
  const text = search.toString();
  return text ? `${path}?${text}` : path;
}
