"""Speed of file → joint positions beside pybvh, family by family: ``python tests/benchmarks/...``.

Runs are interleaved (ours, pybvh, and again), the same files in each; printed
are the medians in MB/s and the median of the ratios. Files that pybvh refuses are left out of its
figure and of the ratio. The captures are those of LANINDEX_CAPTURES.
"""

import statistics
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import pybvh
from places import CAPTURES

from lanindex import formats

ROUNDS = 7


def ours(path: Path) -> None:
    formats.read(path)


def theirs(path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        motion = pybvh.read_bvh_file(path)
        motion.node_positions()


def taken(reader: Callable[[Path], None], files: list[Path]) -> float:
    start = time.process_time()
    for path in files:
        reader(path)
    return time.process_time() - start


def accepts(reader: Callable[[Path], None], path: Path) -> bool:
    try:
        reader(path)
    except Exception as error:
        print(f"  {path.name}: {str(error)[:100]}", file=sys.stderr)
        return False
    return True


def family(name: str, files: list[Path]) -> None:
    accepted = [path for path in files if accepts(theirs, path)]
    times: dict[str, list[float]] = {"ours": [], "shared": [], "pybvh": []}
    for _ in range(ROUNDS + 1):
        times["ours"].append(taken(ours, files))
        times["shared"].append(taken(ours, accepted))
        times["pybvh"].append(taken(theirs, accepted))
    size = {True: 0.0, False: 0.0}
    for path in files:
        size[path in accepted] += path.stat().st_size / 1e6
    middle = {kind: statistics.median(runs[1:]) for kind, runs in times.items()}
    pairs = zip(times["shared"][1:], times["pybvh"][1:], strict=True)
    ratio = statistics.median(b / a for a, b in pairs) if accepted else float("nan")
    total = sum(size.values())
    print(
        f"{name:16} {len(files):5} {total:7.1f} {total / middle['ours']:7.1f} "
        f"{size[True] / middle['pybvh'] if accepted else float('nan'):7.1f} {ratio:7.1f}"
    )


def main() -> None:
    print(f"{'family':16} {'files':>5} {'MB':>7} {'ours':>7} {'pybvh':>7} ratio")
    wanted = sys.argv[1:]
    for place in sorted(path for path in (CAPTURES / "bvh").iterdir() if path.is_dir()):
        if not wanted or place.name in wanted:
            family(place.name, sorted(place.rglob("*.bvh")))


if __name__ == "__main__":
    main()
