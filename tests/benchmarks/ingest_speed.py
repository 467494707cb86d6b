"""How fast whole captures go into a library, beside a peer that only reads them.

    python tests/benchmarks/ingest_speed.py [COUNT ...]

Makes different captures of a minute each; ingests COUNT of them (32, 384 and 768: about a minute's
work for one process) with one process and with two, each into a new library, and lets pybvh read
the same bytes. The runs take turns; medians of three. Last comes what eight of them take of the
processor's time beside pybvh, once all is imported, and how that is shared; alone with COUNT 0.
"""

import cProfile
import pstats
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import pybvh
from made import captures

ROUNDS = 3


def ingest(paths: list[Path], jobs: int) -> float:
    with tempfile.TemporaryDirectory() as folder:
        words = ["ingest", *map(str, paths), "-q", "--jobs", str(jobs), "--db", f"{folder}/l.db"]
        begun = time.perf_counter()
        code = "from lanindex.app.cli import main; main()"
        subprocess.run([sys.executable, "-c", code, *words], check=True)
        return time.perf_counter() - begun


def read_only(paths: list[Path], placed: bool = False) -> float:
    begun = time.perf_counter()
    for path in paths:
        motion = pybvh.read_bvh_file(str(path))
        if placed:
            motion.node_positions()
    return time.perf_counter() - begun


def cost(work: Callable[[], object]) -> float:
    begun = time.process_time()
    work()
    return time.process_time() - begun


def profile(paths: list[Path]) -> None:
    """Print what one process takes once all is imported, and where it spends that."""
    from lanindex import compiled
    from lanindex.encoding.profile import load
    from lanindex.pipeline.ingest import ingest as run
    from lanindex.pipeline.library import open_library

    stages = {
        "read": ("lanindex/formats/bvh/read.py", "read"),
        "encode": ("lanindex/encoding/__init__.py", "encode"),
        "store": ("lanindex/library/store.py", "add"),
        "columns": ("lanindex/library/cache.py", "compact"),
    }
    chosen, named = load("default"), [str(path) for path in paths]

    def anew() -> None:
        with (
            tempfile.TemporaryDirectory() as folder,
            open_library(f"{folder}/l.db", create=True) as library,
        ):
            list(run(library.store, named, chosen))

    compiled.expect(sum(loops.worth for loops in compiled.LOOPS.values()))
    anew()
    rounds = [
        (cost(anew), cost(lambda: read_only(paths)), cost(lambda: read_only(paths, placed=True)))
        for _ in range(ROUNDS)
    ]
    print(
        f"by the processor's time: {median(b / a for a, b, _ in rounds):.2f} x pybvh's reading of "
        f"numbers, {median(c / a for a, _, c in rounds):.2f} x its reading of joint positions"
    )
    profiler = cProfile.Profile()
    profiler.runcall(anew)
    spent = {
        name: sum(
            cumulative
            for (file, _, called), (*_, cumulative, _) in pstats.Stats(profiler).stats.items()
            if file.endswith(place) and called == function
        )
        for name, (place, function) in stages.items()
    }
    total = sum(spent.values())
    print("where the time goes: " + ", ".join(f"{k} {v / total:.0%}" for k, v in spent.items()))


def measure(paths: list[Path]) -> None:
    size, frames = sum(path.stat().st_size for path in paths) / 1e6, len(paths) * 60 * 60
    print(f"{len(paths)} captures, {size:.0f} MB, {frames} frames")
    rounds = [(ingest(paths, 1), ingest(paths, 2), read_only(paths)) for _ in range(ROUNDS)]
    names = ("ingest, 1 process", "ingest, 2 processes", "pybvh reads only")
    for index, name in enumerate(names):
        seconds = median(one[index] for one in rounds)
        speed = f"{size / seconds:6.1f} MB/s  {frames / seconds:8.0f} frames/s"
        print(f"  {name:20} {seconds:6.2f} s  {speed}")
    print(f"  two processes: {median(one[0] / one[1] for one in rounds):.2f} x one")
    print(f"  ingest: {median(one[2] / one[0] for one in rounds):.2f} x pybvh's mere reading")


def main(counts: list[int]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        paths = captures(Path(folder), max(8, *counts))
        ingest(paths[:2], 1)
        for count in filter(None, counts):
            measure(paths[:count])
        profile(paths[:8])


if __name__ == "__main__":
    main([int(word) for word in sys.argv[1:]] or [32, 384, 768])
