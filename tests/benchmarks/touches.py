"""Touches drawn at random, carried out, and written down again.

    python tests/benchmarks/touches.py [SCORES]

Prints, without noise and with 2 mm on every coordinate: how many there were, how many came back
exactly, how many came that were not there, and how many frames of 60 their borders are off.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from random_touches import RATE, Tally, compared, drawn

from lanindex import encode
from lanindex.perform import perform


def main() -> int:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    for noise in (0.0, 2.0):
        tally = Tally()
        for seed in range(count):
            score = drawn(seed)
            compared(score, encode(perform(score, rate=RATE, noise=noise, seed=seed)), tally)
        starts, stops = (np.percentile(off, [50, 95]) for off in (tally.starts, tally.stops))
        print(
            f"{count} scores, noise {noise:g} mm: {tally.exact} of {tally.wanted} "
            f"({tally.exact / tally.wanted:.4f}), {tally.added} added; borders in frames, p50 p95: "
            f"starts {starts[0]:.0f} {starts[1]:.0f}, stops {stops[0]:.0f} {stops[1]:.0f}"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
