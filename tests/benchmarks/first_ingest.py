"""What the extra ``fast`` costs at first and gains later: ``python tests/benchmarks/...``.

The whole command over the BVH files of LANINDEX_CAPTURES, in one process and in two: without
numba, with nothing compiled yet (as after an install), and with what an earlier command compiled.
Processor's seconds and seconds by the clock, medians of three that take turns. Then
`lanindex.read` in a loop over the files that pybvh reads, too, beside pybvh's joint positions.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path
from statistics import median

import pybvh
from places import CAPTURES

import lanindex

ROUNDS = 3
COMPILE = (
    "import sys; from lanindex import compiled; compiled.expect(10**9)\n"
    "from lanindex.app.cli import main; main()"
)
INGEST = "from lanindex.app.cli import main; main()"


def ingest(folder: Path, jobs: int, code: str, **told: str) -> tuple[float, float]:
    with tempfile.TemporaryDirectory() as place:
        words = ["ingest", str(folder), "-q", "--jobs", str(jobs), "--db", f"{place}/l.db"]
        before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        subprocess.run([sys.executable, "-c", code, *words], check=True, env=os.environ | told)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return spent, time.perf_counter() - begun


def loop(paths: list[Path]) -> None:
    warnings.simplefilter("ignore")
    for number in range(ROUNDS):
        begun = time.process_time()
        for path in paths:
            lanindex.read(path)
        ours = time.process_time() - begun
        for path in paths:
            pybvh.read_bvh_file(path).node_positions()
        theirs = time.process_time() - begun - ours
        print(f"read in a loop, {len(paths)} files, time {number + 1}: {theirs / ours:.2f} x pybvh")


def accepts(path: Path) -> bool:
    try:
        pybvh.read_bvh_file(path)
    except Exception:
        return False
    return True


def main() -> None:
    folder = CAPTURES / "bvh"
    with tempfile.TemporaryDirectory() as place:
        absent = Path(place, "absent", "numba")
        absent.mkdir(parents=True)
        absent.joinpath("__init__.py").write_text("raise ImportError\n")
        kept = f"{place}/kept"
        ingest(folder, 1, COMPILE, NUMBA_CACHE_DIR=kept)
        for jobs in (1, 2):
            runs: dict[str, list[tuple[float, float]]] = {}
            for number in range(ROUNDS):
                empty = f"{place}/empty{jobs}{number}"
                for name, told in (
                    ("without numba", {"PYTHONPATH": str(absent.parent)}),
                    ("nothing compiled yet", {"NUMBA_CACHE_DIR": empty}),
                    ("compiled before", {"NUMBA_CACHE_DIR": kept}),
                ):
                    runs.setdefault(name, []).append(ingest(folder, jobs, INGEST, **told))
            for name, found in runs.items():
                spent, taken = (median(one) for one in zip(*found, strict=True))
                print(f"{jobs} processes, {name:20} {spent:6.2f} s CPU {taken:6.2f} s by the clock")
    loop([path for path in sorted(folder.rglob("*.bvh")) if accepts(path)])


if __name__ == "__main__":
    main()
