"""A library in PostgreSQL beside the same one in SQLite, and many who use it at once.

    python tests/benchmarks/postgres.py [ingest] [large] [crowd]

All is wall clock, of processes that take turns; the server runs on this machine, in a temporary
folder, with PostgreSQL's own settings. `ingest`: 300 real captures into new libraries. `large`:
libraries of 10,000 captures by `synthetic.py`: the first search of one that is open, and verbs,
each from the start of its process to its end. `crowd`: two processes write, fifty read.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

import synthetic
from crowd import crowd
from places import CAPTURES
from postgres_server import Server, serving
from verbs import PATTERN, RUN

from lanindex.library.store import Store

ROUNDS, SEARCHES = 5, 25
CAPTURES_READ, LARGE = 300, 10_000
READERS, WRITERS, EACH = 50, 2, 100

VERBS = {
    "list": "list",
    "list --json": "list --json",
    "stats": "stats",
    "show ID": "show 5",
    "search, one hit": "search PATTERN --limit 1",
    "search, all hits": "search PATTERN",
    "search of a word": "search waving",
    "complete a capture": "",
}

FIRST = """
import sys, time
from lanindex.pipeline.library import open_library
with open_library(sys.argv[1], readonly=True) as library:
    begun = time.perf_counter()
    library.search(sys.argv[2])
    first = time.perf_counter()
    library.search(sys.argv[2])
    print(first - begun, time.perf_counter() - first)
"""


def run(*words: str, **more: str) -> tuple[float, str]:
    """Run Python, and return the seconds and what it printed."""
    begun = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", *words], env=os.environ | more, capture_output=True, text=True
    )
    if done.returncode not in (0, 1):
        sys.exit(done.stderr)
    return time.perf_counter() - begun, done.stdout


def schema(server: Server, name: str) -> str:
    """Return the URL of a schema that is empty."""
    with server.connect(autocommit=True) as link:
        link.execute(f"DROP SCHEMA IF EXISTS {name} CASCADE")
        link.execute(f"CREATE SCHEMA {name}")
    return server.url(name)


def ingest(server: Server) -> None:
    files = sorted(map(str, (CAPTURES / "bvh").rglob("*.bvh")))[:CAPTURES_READ]
    print(f"ingest of {len(files)} captures: s in SQLite, in PostgreSQL, speed")
    for jobs in ("1", "2"):
        pairs = []
        for _ in range(ROUNDS):
            with tempfile.TemporaryDirectory() as folder:
                url = schema(server, "ingested")
                words = [RUN, "ingest", *files, "-q", "--jobs", jobs, "--db"]
                pairs.append([run(*words, name)[0] for name in (f"{folder}/new.db", url)])
        here, there = zip(*pairs, strict=True)
        speed = median(one / other for one, other in pairs)
        print(f"--jobs {jobs:10}{median(here):8.1f}{median(there):8.1f}{speed:8.2f}", flush=True)


def large(names: tuple[str, str]) -> None:
    """Compare two libraries of the same captures."""
    print(f"{LARGE:,} captures: ms in SQLite, in PostgreSQL")
    rounds = [
        [[float(it) for it in run(FIRST, name, PATTERN)[1].split()] for name in names]
        for _ in range(SEARCHES)
    ]
    for at, what in enumerate(("first search", "second search")):
        row = [1000 * median(one[side][at] for one in rounds) for side in (0, 1)]
        print(f"{what:24}{row[0]:8.0f}{row[1]:8.0f}", flush=True)
    with Store.open(names[0], readonly=True) as store:
        begun = store.capture(5).path[:3]
    for what, verb in VERBS.items():
        seconds = [[timed(verb, name, begun) for name in names] for _ in range(ROUNDS)]
        row = [1000 * median(one[side] for one in seconds) for side in (0, 1)]
        print(f"{what:24}{row[0]:8.0f}{row[1]:8.0f}", flush=True)


def timed(verb: str, name: str, begun: str) -> float:
    """Return what a verb takes; without one, the completion of a capture's path."""
    if verb:
        words = [word.replace("PATTERN", PATTERN) for word in verb.split()]
        return run(RUN, *words, "--db", name)[0]
    words = {"COMP_WORDS": f"lanindex show --db '{name}' {begun}", "COMP_CWORD": "4"}
    return run(RUN, **words, _LANINDEX_COMPLETE="complete_bash")[0]


def many(server: Server) -> None:
    url = schema(server, "shared")
    Store.open(url, create=True).close()
    wrote, asked, waiting = crowd(
        server, url, url.replace("owner@", "reader@"), writers=WRITERS, readers=READERS, each=EACH
    )
    print(f"{WRITERS} write {EACH} captures each, {READERS} read: ms p50, p95, longest")
    told = {
        "a writer waits": [it for one in wrote for it in one["waited"]],
        "a batch": [it for one in wrote for it in one["took"]],
        "a search": [it for one in asked for it in one["took"]],
    }
    for what, values in told.items():
        values.sort()
        row = (values[int(share * (len(values) - 1))] for share in (0.5, 0.95, 1))
        print(f"{what:24}" + "".join(f"{1000 * it:8.0f}" for it in row) + f"  of {len(values):,}")
    print(f"seen to wait for a lock: {', '.join(waiting)}")


def main() -> None:
    wanted = sys.argv[1:] or ["ingest", "large", "crowd"]
    with serving("") as server, tempfile.TemporaryDirectory() as folder:
        with server.connect(autocommit=True) as link:
            link.execute("CREATE ROLE reader SUPERUSER LOGIN")
        if "ingest" in wanted:
            ingest(server)
        if "crowd" in wanted:
            many(server)
        if "large" in wanted:
            names = str(Path(folder) / "large.db"), schema(server, "large")
            for name in names:
                synthetic.library(name, LARGE)
            large(names)


if __name__ == "__main__":
    main()
