"""What the columns of a library cost: bytes a symbol, building, opening, loading, making anew.

    python tests/benchmarks/columns.py [CAPTURES] [CAPTURES WITH ROWS]

On a synthetic library: 400,000 captures, columns alone, in the library and in files; 2,000 with
rows. What an ingest takes, its columns included, tells `ingest_speed.py`.
"""

import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from statistics import median

import synthetic
from sqlalchemy import update

from lanindex.library import cache, migrate, read, schema, segments
from lanindex.pipeline.library import open_library

ROUNDS = 5


def seconds(work) -> float:
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun


def build(path: Path, captures: int) -> None:
    """Write a library of columns alone, and say how fast and how large."""
    begun = time.perf_counter()
    roster, columns = synthetic.columns(captures)
    symbols, parts = sum(map(len, columns.values())), len(columns)
    print(f"{captures} captures, {symbols / 1e6:.1f} M symbols, {parts} parts", end="")
    print(f" (made in {time.perf_counter() - begun:.1f} s)")
    with open_library(path, create=True) as library:
        before = path.stat().st_size
        with library.store.session.writing() as connection:
            names = [f"{number:06}.bvh" for number in roster.number.tolist()]
            texts = {name: names for name in segments.TEXTS} | {"metadata": [{}] * len(names)}
            texts["still"] = [[]] * len(names)
            put = partial(segments.put, connection, roster, texts)
            spent = seconds(lambda: put(columns.values()))
            numbers = {"captures": captures, "numbers": int(roster.number.sum())}
            connection.execute(update(schema.state).values(numbers))
    size = path.stat().st_size - before
    print(f"  build from arrays: {symbols / spent / 1e6:.1f} M symbols/s")
    print(f"  bytes a symbol: {size / symbols:.2f}")


def opened(path: Path) -> None:
    """Say how long it takes to open columns, and to load a part of them."""

    def load() -> None:
        found.append(library.store.columns(["r_arm"])[1]["r_arm"])

    whole, spines, firsts, found = [], [], [], []
    for _ in range(ROUNDS):
        begun = time.perf_counter()
        library = open_library(path, readonly=True)
        whole.append(time.perf_counter() - begun)
        with library:
            begun = time.perf_counter()
            with library.store.session.reading() as connection:
                segments.read_spine(connection)
            spines.append(time.perf_counter() - begun)
            firsts.append(seconds(load))
            again = seconds(load)
    number = len(found[0])
    print(f"  open the library: {1000 * median(whole):.1f} ms; know its columns:", end="")
    print(f" {1000 * median(spines):.1f} ms")
    print(
        f"  load one part of {number / 1e6:.1f} M symbols: {1000 * median(firsts):.0f} ms", end=""
    )
    print(f"; again {1000 * again:.2f} ms")


def memory(path: Path) -> None:
    """Say how much memory a part takes, in a process of its own."""
    code = (
        "import re, sys, lanindex\n"
        "def most():\n"  # that of this program alone, whatever has started it
        "    told = open('/proc/self/status').read()\n"
        "    return int(re.search(r'VmHWM:\\s+(\\d+)', told)[1]) / 1024\n"
        "with lanindex.open_library(sys.argv[1], readonly=True) as library:\n"
        "    library.store.columns([])\n"
        "    before = most()\n"
        "    one = library.store.columns(['r_arm'])[1]['r_arm']\n"
        "    names = ('bounds', 'cell', 'runner', 'margin', 'start', 'stop')\n"
        "    held = sum(getattr(one, name).nbytes for name in names) / 1024**2\n"
        "print(f'  memory for it: {most() - before:.0f} MB, its arrays are {held:.0f} MB')\n"
    )
    subprocess.run([sys.executable, "-c", code, str(path)], check=True)


def anew(path: Path, captures: int) -> None:
    """Say how fast segments are made of rows, and how fast they are joined."""
    synthetic.library(path, captures)
    with open_library(path) as library:
        with library.store.session.reading() as connection:
            numbers = read.capture_numbers(connection)
            found = []
            spent = seconds(lambda: found.extend(segments.batches(connection, numbers)))
        symbols = sum(len(one) for piece in found for one in piece.columns.values())
        print(f"{captures} captures with rows: {path.stat().st_size / symbols:.1f} bytes a symbol")
        print(f"  rows to arrays: {symbols / spent / 1e6:.2f} M rows/s")
        with library.store.session.writing() as connection:
            segments.begin_anew(connection)
        print(f"  rebuild: {symbols / seconds(library.store.cache.compact) / 1e6:.2f} M rows/s")
        with library.store.session.reading() as connection:
            spent = seconds(lambda: cache.verify(connection))
        print(f"  hold all against their checksums: {symbols / spent / 1e6:.1f} M symbols/s")


def main(captures: int, with_rows: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "columns.db"
        build(path, captures)
        opened(path)
        memory(path)
        print("the same in files:")
        spent = seconds(lambda: migrate.keep_columns(path, "files"))
        print(f"  move them into files: {spent:.1f} s")
        opened(path)
        memory(path)
        anew(Path(folder) / "rows.db", with_rows)


if __name__ == "__main__":
    told = [int(word) for word in sys.argv[1:]]
    main(*told, *(400_000, 2_000)[len(told) :])
