"""How long scores of more and more symbols take to be written and read, in every notation; and
how long a tier of more and more hits takes, in an ELAN file that has as many already.

python tests/benchmarks/notations.py [NAME ...]
"""

from __future__ import annotations

import itertools
import resource
import sys
import time

import numpy as np

from lanindex.model import Meter, Score, Span, Track
from lanindex.model.symbol import blank
from lanindex.notation import NOTATIONS, WRITTEN, eaf, left_out, read, write
from lanindex.notation.tiers import TierEntry

PARTS = ("r_upper_arm", "l_upper_arm", "r_forearm", "l_forearm", "r_arm", "l_arm")
"""What every notation has room for."""


def many(count: int, parts: tuple[str, ...]) -> Score:
    """Return a score of so many symbols, at 60 frames a second, each part in its own time."""
    draws, tracks, share = np.random.default_rng(0), {}, count // len(parts)
    for part in parts:
        rows, lengths = blank(share), draws.integers(8, 36, share)
        rows["start"] = rows["tick"] = np.cumsum(lengths) - lengths
        rows["stop"], rows["ticks"] = rows["start"] + lengths - 5, lengths - 5
        rows["direction"] = np.arange(share) % 9
        rows["level"] = np.arange(share) % 3
        tracks[part] = Track(part, rows, (Span(0, int(rows["stop"][-1])),))
    frames = max(int(track.symbols["stop"][-1]) for track in tracks.values())
    return Score(60, frames, Meter(), tracks)


def main(names: list[str]) -> None:
    """Print a row for each notation and size; the peak is that of all rows so far."""
    print("notation        symbols     MB  write s   read s  peak MB")
    for name in names or WRITTEN:
        for count in (1_000, 10_000, 100_000):
            parts = tuple(it for it in PARTS if not left_out(many(12, (it,)), name))[-4:]
            score = many(count, parts)
            times = [time.process_time()]
            content = write(score, name)
            times.append(time.process_time())
            read(f"x{NOTATIONS[name].suffix}", content)
            times.append(time.process_time())
            spent = "  ".join(f"{b - a:7.2f}" for a, b in itertools.pairwise(times))
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
            print(f"{name:15} {count:7}  {len(content) / 1e6:5.1f}  {spent}  {peak:7}")


def hits() -> None:
    """Print a row for each number of hits."""
    print("hits       into a small file s   into one as large s")
    for count in (1_000, 10_000, 100_000):
        entries = [TierEntry("r_arm high 0.90", 10 * at, 10 * at + 5) for at in range(count)]
        times, content = [time.process_time()], eaf.write(many(4, PARTS[:2]))
        for tier in ("hits", "more"):
            content = eaf.mark(content, tier, entries, place="x")
            times.append(time.process_time())
        spent = "  ".join(f"{b - a:20.2f}" for a, b in itertools.pairwise(times))
        print(f"{count:7}  {spent}")


if __name__ == "__main__":
    main(sys.argv[1:])
    hits()
