"""Compare scores of ten thousand and a hundred thousand symbols: one with itself, edited, others.

Run it as ``python tests/benchmarks/comparing.py``. It prints the processor's time and the most
memory that Python took.
"""

import sys
import time
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

import lanindex
from lanindex.compare import compare
from lanindex.model import Score
from lanindex.model.symbol import blank

STEP = 16
"""Frames of a symbol: a second."""


def score(count: int, seed: int, kinds: int) -> Score:
    """Return a score of one arm: a symbol a second, of so many kinds at random."""
    draw = np.random.default_rng(seed)
    rows = blank(count)
    codes = draw.integers(0, kinds, count)
    rows["direction"], rows["level"] = codes % 9, codes // 9
    rows["start"] = rows["tick"] = np.arange(count) * STEP
    rows["stop"], rows["ticks"] = rows["start"] + STEP, STEP
    held = lanindex.read_lnd(Path(__file__).parents[2] / "corpus" / "jumping_jacks.lnd")
    track = replace(held.tracks["r_arm"], symbols=rows)
    return replace(held, frames=count * STEP, tracks={"r_arm": track})


def without(one: Score, share: float, seed: int = 1) -> Score:
    """Return a score in which some symbols are left out, the others where they were."""
    track = one.tracks["r_arm"]
    kept = np.random.default_rng(seed).random(len(track)) >= share
    return replace(one, tracks={"r_arm": replace(track, symbols=track.symbols[kept])})


def main() -> None:
    """Print a table."""
    print(f"{'symbols':>8} {'beside':<28} {'differ':>7} {'s':>6} {'MB':>6}")
    for count in (1_000, 10_000, 100_000):
        varied, repeated = score(count, 0, 27), score(count, 0, 1)
        for name, one, other in (
            ("itself", varied, varied),
            ("a hundredth left out", varied, without(varied, 0.01)),
            ("one kind, half left out", repeated, without(repeated, 0.5)),
            ("other symbols", varied, score(count, 1, 27)),
        ):
            begin = time.process_time()
            found = compare(one, other)
            taken = time.process_time() - begin
            tracemalloc.start()
            compare(one, other)
            most = tracemalloc.get_traced_memory()[1] / 1e6
            tracemalloc.stop()
            print(f"{count:8} {name:<28} {len(found.differences):7} {taken:6.2f} {most:6.0f}")


if __name__ == "__main__":
    main()
