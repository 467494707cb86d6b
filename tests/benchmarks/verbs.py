"""What each verb takes in libraries of more and more captures: seconds of CPU and memory.

    python tests/benchmarks/verbs.py FOLDER [CAPTURES ...] [--only WORD ...]

Each verb is a process of its own, from its start to its end. The libraries (1,000, 10,000 and
50,000 captures, or as many as are named; some 200 symbols each, by `synthetic.py`) are kept in the
folder, and made where they are not there yet. `--only` measures the verbs whose name has one of
these words.
"""

import argparse
import os
import sqlite3
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

SIZES = (1_000, 10_000, 50_000)
RUN = "from lanindex.app.cli import main; main()"
ROUNDS, ENOUGH = 5, 5.0
"""Runs of each verb, fewer where they have taken so many seconds together."""

ENVIRONMENT = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
"""Users' modules are compiled once, so they are here."""

PATTERN = "r_arm mid -> high"
VERBS = {
    "show ID": "show 5",
    "show PATH": "show {path}",
    "score ID": "score 5 -o {out}.svg --force",
    "diff ID ID": "diff 5 6",
    "complete a capture": "",
    "list": "list",
    "stats": "stats",
    "show --all --part r_arm -o FILE": "show --all --part r_arm -o {out}.csv --force",
    "search, one hit": "search PATTERN --limit 1",
    "search, all hits": "search PATTERN",
    "search --json, all hits": "search PATTERN --json",
    "search --like ID:FROM-TO": "search --like 5:20-80",
    "similar": "similar",
    "similar --groups 10": "similar --groups 10",
    "motifs": "motifs",
    "db check": "db check",
}
"""Command lines by name; in each, the library is named after them."""

Measured = tuple[float, float, int]
"""Seconds of CPU, the most megabytes, lines printed."""


def measured(words: list[str], more: dict[str, str]) -> Measured:
    """Run a command once."""
    with tempfile.TemporaryFile() as out:
        process = subprocess.Popen(
            [sys.executable, "-c", RUN, *words],
            stdout=out, stderr=subprocess.PIPE, env=ENVIRONMENT | more,
        )  # fmt: skip
        assert process.stderr is not None
        said = process.stderr.read().decode()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode not in (0, 1):
            sys.exit(f"{' '.join(words)}: {said}")
        out.seek(0)
        lines = sum(1 for _ in out)
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, lines


def typical(name: str, db: Path, out: Path) -> Measured:
    """Run a verb some times, and return the middle."""
    link = sqlite3.connect(f"{db.as_uri()}?mode=ro", uri=True)
    (path,) = link.execute("SELECT path FROM capture WHERE id = 5").fetchone()
    link.close()
    given = {"path": path, "out": str(out / "shown")}
    words = [word.format(**given).replace("PATTERN", PATTERN) for word in VERBS[name].split()]
    more = {}
    if words:
        words += ["--db", str(db)]
    else:
        more = {"_LANINDEX_COMPLETE": "complete_bash", "COMP_CWORD": "4"}
        more |= {"COMP_WORDS": f"lanindex show --db {db} {path[:3]}"}
    found: list[Measured] = []
    while len(found) < ROUNDS and sum(one[0] for one in found) < ENOUGH:
        found.append(measured(words, more))
    seconds, megabytes, lines = zip(*found, strict=True)
    return median(seconds), median(megabytes), lines[0]


def made(folder: Path, size: int) -> Path:
    """Return a library of so many captures."""
    path = folder.absolute() / f"{size}.db"
    if not path.exists():
        script = Path(__file__).with_name("synthetic.py")
        subprocess.run([sys.executable, str(script), str(path), str(size)], check=True)
    return path


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("captures", nargs="*", type=int, default=list(SIZES))
    parser.add_argument("--only", nargs="+", default=[""])
    told = parser.parse_args()
    told.folder.mkdir(parents=True, exist_ok=True)
    libraries = [made(told.folder, size) for size in told.captures]
    print(f"{'captures':34}" + "".join(f"{size:>17,}" for size in told.captures))
    results: dict[str, list[Measured]] = {}
    for name in VERBS:
        if any(word in name for word in told.only):
            print(f"{name:34}", end="", flush=True)
            for db in libraries:
                with tempfile.TemporaryDirectory() as out:
                    seconds, megabytes, lines = typical(name, db, Path(out))
                results.setdefault(name, []).append((seconds, megabytes, lines))
                print(f"{seconds:8.2f} s{megabytes:5.0f} MB", end="", flush=True)
            print()
    one = results.get("search, one hit", [])
    for name in ("search, all hits", "search --json, all hits"):
        cells = [
            f"{1e6 * (every[0] - first[0]) / every[2]:14.0f} us"
            for every, first in zip(results.get(name, []), one, strict=False)
        ]
        if cells:
            print(f"{name + ', each more':34}" + "".join(cells))


if __name__ == "__main__":
    main()
