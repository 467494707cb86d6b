"""How fast the page is: its start, its weight, keystrokes, hits, many clients, memory.

    python tests/benchmarks/page.py LIBRARY [ROW ...]

Prints a row a figure, by the wall clock. LIBRARY is of 10,000 captures by `synthetic.py`.
"""
# ruff: noqa: B023 (what a loop defines is called in its own round, threads are joined in it)

import argparse
import gzip
import http.client
import json
import random
import re
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from statistics import median
from typing import Any
from urllib.parse import parse_qs, quote, urlsplit

import psutil
from places import HERE

STATIC = HERE.parents[1] / "lanindex" / "web" / "static"
TYPED = (
    "r_arm high -> low", "arms place high", "l_leg forward low -> place low", "jump",
    "r_arm right mid with l_arm left mid", "r_arm ... high ... low", "torso forward",
)  # fmt: skip
SLOW = {
    "pattern": " with ".join(f"{it} ... any ... any" for it in ("r_arm", "l_arm", "r_leg")),
    "overlaps": "all",
}
"""A search that takes a minute in 10,000 captures."""

CLIENTS, ASKED = 100, 10
CHROMIUM = ("--headless", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader",
            "--enable-precise-memory-info")  # fmt: skip


class Served:
    """A server in a process of its own."""

    def __init__(self, library: str) -> None:
        self.begun = time.perf_counter()
        command = [sys.executable, "-m", "lanindex", "serve", library, "--port", "0", "--no-open"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        self.link = self.process.stdout.readline().strip()
        parts = urlsplit(self.link)
        self.site, self.port = f"http://{parts.netloc}", parts.port
        self.token = parse_qs(parts.query)["token"][0]

    def client(self) -> Callable[..., bytes]:
        """Return what asks over a connection of its own."""
        line = http.client.HTTPConnection("127.0.0.1", self.port, timeout=120)
        headers = {"authorization": f"Bearer {self.token}"}

        def ask(path: str, body: Any = None, method: str = "") -> bytes:
            method = method or ("GET" if body is None else "POST")
            line.request(method, path, None if body is None else json.dumps(body), headers)
            answer = line.getresponse()
            content = answer.read()
            assert answer.status == 200, (path, answer.status, content[:200])
            return content

        return ask

    def memory(self) -> float:
        """Return megabytes."""
        return float(psutil.Process(self.process.pid).memory_info().rss / 1e6)


@contextmanager
def served(library: str) -> Iterator[Served]:
    server = Served(library)
    try:
        yield server
    finally:
        server.process.terminate()
        server.process.wait(30)


@contextmanager
def opened(server: Served, size: tuple[int, int] = (1280, 800), first: str = "/") -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        path = shutil.which("chromium")
        browser = playwright.chromium.launch(executable_path=path, args=list(CHROMIUM))
        page = browser.new_page(viewport={"width": size[0], "height": size[1]})
        page.goto(server.link.replace("/?", f"{first}?"))
        yield page
        browser.close()


def timed(work: Callable[[], Any]) -> float:
    """Return milliseconds."""
    begun = time.perf_counter()
    work()
    return (time.perf_counter() - begun) * 1e3


def row(name: str, found: str) -> None:
    print(f"| {name} | {found} |", flush=True)


def start(names: argparse.Namespace) -> None:
    page, table = [], []
    for _ in range(5):
        with served(names.library) as server:
            ask = server.client()
            ask("/")
            page.append(time.perf_counter() - server.begun)
            ask("/api/library"), ask("/api/captures")
            table.append(time.perf_counter() - server.begun)
    row("start to the first page; to its captures", f"{median(page):.2f} s; {median(table):.2f} s")


def weight(names: argparse.Namespace) -> None:
    def kb(paths: Any) -> float:
        return sum(len(gzip.compress(it.read_bytes(), 9)) for it in paths) / 1e3

    every = [it for it in STATIC.rglob("*") if it.suffix in (".js", ".css", ".html", ".svg")]
    with served(names.library) as server, opened(server) as page:
        page.wait_for_selector("main li, main .card")
        loaded = page.evaluate("performance.getEntriesByType('resource').map((it) => it.name)")
    first = {re.sub(r".*/static/", "", it) for it in loaded if "/static/" in it} | {"index.html"}
    own = kb(STATIC / it for it in first)
    row("page weight, compressed: the first page; everything", f"{own:.0f} kB; {kb(every):.0f} kB")


def keys(names: argparse.Namespace) -> None:
    with served(names.library) as server:
        ask = server.client()
        ask("/api/parse", {"text": "r_arm", "position": 5})
        texts = [text[:stop] for text in TYPED for stop in range(1, len(text) + 1)]
        spent = [
            timed(lambda t=t: ask("/api/parse", {"text": t, "position": len(t)})) for t in texts
        ]
        name = "keystroke → completions and sentence"
        row(name, f"{median(spent):.0f} ms, at most {max(spent):.0f} ms")
        firsts, ends, memories = [], [], [server.memory()]
        parts, ways = ("r_leg", "l_forearm", "r_arm", "torso"), ("high", "left", "place mid")
        for text in (*TYPED, *(f"{part} {way}" for part in parts for way in ways)):

            def first(text: str = text) -> None:
                job = json.loads(ask("/api/searches", {"pattern": text}))["job"]
                ask(f"/api/searches/{job}/hits?n=24")
                job_of.append(job)

            job_of: list[str] = []
            firsts.append(timed(first))
            ends.append(firsts[-1] + timed(lambda j=job_of[0]: ask(f"/api/jobs/{j}/events")))
        memories.append(server.memory())
        row(
            "keystroke → hits: an answer; all of them",
            f"{median(firsts):.0f} ms; {median(ends):.0f} ms",
        )


def many(names: argparse.Namespace) -> None:
    mix: list[tuple[str, Any]] = [
        ("/api/library", None), ("/api/captures?n=60", None), ("/api/captures/5/staff?to=10", None),
        ("/static/app.js", None), ("/api/parse", {"text": "r_arm high -> l", "position": 15}),
        ("/api/captures/7", None), ("/api/captures?q=a&sort=-length", None), ("hits", None),
        ("/search", None), ("/api/words", None),
    ]  # fmt: skip
    with served(names.library) as server:
        busy = server.client()
        for load in ("", ", while a search of a minute runs"):
            if load:
                job = json.loads(busy("/api/searches", SLOW))["job"]
            spent, failures = [], []

            def client(seed: int) -> None:
                ask, dice = server.client(), random.Random(seed)
                for _ in range(ASKED):
                    path, body = dice.choice(mix)

                    def once(path: str = path, body: Any = body) -> None:
                        if path == "hits":
                            begun = ask("/api/searches", {"pattern": dice.choice(TYPED)})
                            ask(f"/api/searches/{json.loads(begun)['job']}/hits")
                        else:
                            ask(path, body)

                    try:
                        spent.append(timed(once))
                    except Exception as error:
                        failures.append(repr(error))
                        ask = server.client()

            threads = [threading.Thread(target=client, args=(it,)) for it in range(CLIENTS)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            p95 = sorted(spent)[int(len(spent) * 0.95)]
            found = f"{median(spent):.0f} ms, p95 {p95 / 1e3:.2f} s, {len(failures)} fail"
            row(f"{CLIENTS} clients at once{load}", found)
            for failure in dict.fromkeys(failures):
                print("   ", failure, file=sys.stderr)
            if load:
                state = json.loads(server.client()(f"/api/jobs/{job}", method="DELETE"))["state"]
                row("the search then", state)
            row(f"memory of the server{load}", f"{server.memory():.0f} MB")


def frames(_: argparse.Namespace) -> None:
    """Play a figure with all that can be shown, beside its staff, and count what is drawn."""
    from figure_page import Walker
    from figure_page import served as figure_served
    from playwright.sync_api import sync_playwright

    walker = Walker(HERE.parents[1] / "corpus" / "marching.bvh")
    with figure_served(STATIC, walker) as address, sync_playwright() as playwright:
        path = shutil.which("chromium")
        browser = playwright.chromium.launch(executable_path=path, args=list(CHROMIUM))
        for kind in ("", "canvas", "space"):
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            page.goto(f"{address}?figure={kind}")
            page.wait_for_selector("body[data-ready]")
            for wanted in ("Ghosts", "Front and side", "Floor plan"):
                page.get_by_role("button", name=wanted).click()
            page.evaluate("log.length = 0; player.play()")
            page.wait_for_timeout(6000)
            log = page.evaluate("(player.pause(), log)")[5:]
            speed = (len(log) - 1) / (log[-1]["at"] - log[0]["at"]) * 1e3
            apart = sum(it["figure"] != it["staff"] for it in log)
            name = f"figure with ghosts, plan and two views, by {page.evaluate('figure.kind')}"
            name += "" if kind else " (chosen by itself)"
            row(name, f"{speed:.0f} frames/s; figure and staff apart in {apart} of {len(log)}")
            page.close()
        browser.close()


LONG = 1800
"""Seconds of a capture from which on it is a long one."""

SHOWN = """() => {
  const line = document.querySelector(".staff-line")?.getBoundingClientRect();
  const here = (it) => it.style.display !== "none" && it.getBoundingClientRect().top <= line.top
    && it.getBoundingClientRect().bottom >= line.top;
  const told = document.querySelector("input.time")?.getAttribute("aria-valuetext");
  const staff = line && [...document.querySelectorAll(".staff-layer svg")].some(here);
  const waits = document.querySelector(".state")?.textContent !== "";
  return { staff: Boolean(staff), figure: Boolean(told) && !waits, told };
}"""
"""Whether a page of a capture shows figure and staff, and of which time."""

UNTIL = f"""(wanted) => new Promise((done) => {{
  const shown = {SHOWN}, begun = wanted === null ? 0 : performance.now(), found = {{}};
  if (wanted !== null) {{
    const time = document.querySelector("input.time");
    time.value = String(wanted);
    time.dispatchEvent(new Event("input"));
  }}
  const look = () => {{
    const now = shown(), slid = document.querySelector("input.time")?.value;
    const there = wanted === null || slid === String(wanted);
    const spent = performance.now() - begun;
    for (const it of ["staff", "figure"]) if (now[it] && there) found[it] ??= spent;
    if (found.staff && found.figure) done(found);
    else requestAnimationFrame(look);
  }};
  requestAnimationFrame(look);
}})"""
"""Goes to a place of the slider; returns after how many milliseconds staff and figure show it."""


def renderer() -> float:
    """Return the megabytes of the largest process that draws a page of ours."""
    ours = psutil.Process().children(recursive=True)
    pages = (it for it in ours if "--type=renderer" in it.cmdline())
    return max(it.memory_info().rss for it in pages) / 1e6


def hour(names: argparse.Namespace) -> None:
    # not from the library, which reads the same files for its pictures
    with served(names.library) as server, opened(server, first="/help") as page:
        page.wait_for_load_state("networkidle")
        page.wait_for_timeout(1500)
        ask, dice = server.client(), random.Random(0)
        every = json.loads(ask("/api/captures?n=60&sort=-length"))["captures"]
        for capture in (it for it in every if it["seconds"] > LONG):
            page.goto(f"{server.site}/captures/{capture['capture_id']}", wait_until="commit")
            begun = page.evaluate(UNTIL, None)
            what = f"{capture['seconds'] / 60:.0f} min of {capture['format']}"
            told = " ms, ".join(f"{begun[it]:.0f}" for it in ("staff", "figure"))
            row(f"{what}: open: staff, figure", f"{told} ms")
            for when in ("at once", "once all is drawn beforehand"):
                jumps = [page.evaluate(UNTIL, dice.randrange(10_000)) for _ in range(30)]
                for it in ("staff", "figure"):
                    spent = sorted(jump[it] for jump in jumps)
                    found = f"{median(spent):.0f} ms, p95 {spent[int(len(spent) * 0.95)]:.0f} ms"
                    row(f"{what}: to 30 random times, {when}: {it}", found)
                page.wait_for_timeout(2000)
                while psutil.Process(server.process.pid).children():
                    page.wait_for_timeout(500)
            heap = page.evaluate("performance.memory.usedJSHeapSize") / 1e6
            row(
                f"{what}: memory of the page",
                f"{heap:.0f} MB of JavaScript, its process {renderer():.0f} MB",
            )
        row("memory of the server then", f"{server.memory():.0f} MB")


MOVES = """(number) => new Promise((done) => {
  const small = new OffscreenCanvas(96, 72), found = {};
  const pen = small.getContext("2d", { willReadFrequently: true });
  const card = document.querySelectorAll(".hit a.show")[number];
  let begun = 0, still = null;
  card.scrollIntoView({ block: "center" });
  card.addEventListener("click", () => { begun = performance.now(); }, { capture: true });
  const look = () => {
    const canvas = begun ? document.querySelector(".watch canvas.figure") : null;
    if (canvas?.width) {
      pen.clearRect(0, 0, 96, 72);
      pen.drawImage(canvas, 0, 0, 96, 72);
      const { data } = pen.getImageData(0, 0, 96, 72), now = data.join();
      if (still === null && data.some(Boolean)) {
        still = now;
        found.shown = performance.now() - begun;
      } else if (still !== null && now !== still) {
        found.moves = performance.now() - begun;
        return done(found);
      }
    }
    requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
  setTimeout(() => card.click(), 300);
})"""
"""Clicks on a hit; returns after how many milliseconds its figure is there, and moves."""


def click(names: argparse.Namespace) -> None:
    with served(names.library) as server, opened(server) as page:
        spent = list[dict[str, float]]()
        for text in TYPED:
            page.goto(f"{server.site}/search?q={quote(text)}")
            page.locator(".hit .poses svg").first.wait_for()
            for number in range(min(page.locator(".hit").count(), 4)):
                spent.append(page.evaluate(MOVES, number))
                page.go_back()
                page.locator(".hit .poses svg").first.wait_for()
        for it, what in (("shown", "its figure is there"), ("moves", "it moves")):
            each = sorted(one[it] for one in spent)
            found = f"{median(each):.0f} ms, p95 {each[int(len(each) * 0.95)]:.0f} ms"
            row(f"click on a hit → {what} ({len(each)} clicks)", found)


EDITED = """
window.log = [];
const asked = window.fetch;
window.fetch = async (path, how) => {
  const answer = await asked(path, how);
  if (String(path).endsWith("scores/motion")) log.push(["figure", performance.now()]);
  return answer;
};
addEventListener("keydown", () => { log = [["key", performance.now()]]; }, { capture: true });
addEventListener("DOMContentLoaded", () => new MutationObserver((all) => {
  if (!all.some((it) => it.target.className === "edit-drawn")) return;
  requestAnimationFrame(() => setTimeout(() => log.push(["staff", performance.now()])));
}).observe(document, { childList: true, subtree: true }));
"""
"""Tells when a key is pressed, the staff that it changes is painted, and the figure has come."""

MINUTES = 5


def edit(names: argparse.Namespace) -> None:
    """Change symbols of a score of five minutes, and wait for staff and figure."""
    import lanindex
    from lanindex.draw.staff import usual_tracks
    from lanindex.notation import edited, lnd

    score = lanindex.encode(lanindex.read(HERE.parents[1] / "corpus" / "marching.bvh"))
    data = edited.of_score(score)
    usual, length = {*usual_tracks(score.tracks)}, data["units"] * data["division"]
    times = round(MINUTES * 60 / (score.frames / float(score.rate)))
    moves = [it for it in data["symbols"] if it[0] in usual and it[2]]
    data["units"] *= times
    data["symbols"] = [
        [part, start + at * length, stop + at * length, *words]
        for at in range(times)
        for part, start, stop, *words in moves
    ]
    with served(names.library) as server, opened(server) as page:
        page.add_init_script(EDITED)
        page.goto(f"{server.site}/edit")
        page.wait_for_selector(".edit-drawn svg")
        text = lnd.write(edited.score_of(data)).encode()
        file = {"name": "long.lnd", "mimeType": "text/plain", "buffer": text}
        page.locator("input[type=file]").set_input_files(file)
        page.wait_for_timeout(5000)
        page.locator("[role=application][aria-label^='The staff']").focus()
        found: dict[str, list[float]] = {"staff": [], "figure": []}
        process, spent = psutil.Process(server.process.pid), []
        for at in range(15):
            for _ in range(12):
                page.keyboard.press("ArrowUp")
            page.wait_for_timeout(1500)
            before = sum(process.cpu_times()[:2])
            page.keyboard.press("46"[at % 2])
            page.wait_for_timeout(1500)
            spent.append((sum(process.cpu_times()[:2]) - before) * 1e3)
            times_of = dict(reversed(page.evaluate("log")))  # the first of each
            for name, all_of in found.items():
                all_of.append(times_of[name] - times_of["key"])
        told = "; ".join(f"{it} {median(own):.0f} ms" for it, own in found.items())
        row(f"an edit of {len(data['symbols']):,} symbols in {MINUTES} min", told)
        row("the server's CPU for it", f"{median(spent):.0f} ms")


ROWS = {
    "start": start,
    "weight": weight,
    "keys": keys,
    "many": many,
    "frames": frames,
    "hour": hour,
    "click": click,
    "edit": edit,
}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("library")
    parser.add_argument("rows", nargs="*")
    named = parser.parse_args()
    for name in named.rows or ROWS:
        ROWS[name](named)
