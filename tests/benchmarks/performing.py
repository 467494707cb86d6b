"""Random scores of the whole body, performed and encoded again.

    python tests/benchmarks/performing.py [SCORES]

Steps, jumps and turns; the same between other supports (*); twists and inclines; bends. Prints,
without noise and with 2 mm on every coordinate: how many symbols there were, how many came back
exactly (angles within 5 degrees), how many came that were not there, and how many frames of 60
their borders are off.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

import random_bends
import random_palms
import random_supports
import random_twists
from random_steps import RATE, Tally, compared, drawn

from lanindex import encode
from lanindex.alphabet import BENDS, FACING
from lanindex.perform import perform
from lanindex.perform.travel import WEIGHT


def main() -> int:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    for noise in (0.0, 2.0):
        tally, between = dict[str, Tally](), dict[str, Tally]()
        for seed in range(count):
            for score, parts, into in (
                (drawn(seed), WEIGHT, tally),
                (random_supports.drawn(seed), random_supports.TRACKS, between),
                (random_twists.drawn(seed), random_twists.TURNED, tally),
                (random_bends.drawn(seed), BENDS.values(), tally),
                (random_palms.drawn(seed), FACING, tally),
            ):
                motion = perform(score, rate=RATE, noise=noise, seed=seed)
                compared(score, encode(motion), into, parts)
        print(f"{count} scores, noise {noise:g} mm; borders in frames, p50 p95")
        for part, it in (*tally.items(), *((f"* {part}", it) for part, it in between.items())):
            if not it.wanted:
                print(f"{part:15} {it.added} added")
                continue
            starts, stops = (np.percentile(off, [50, 95]) for off in (it.starts, it.stops))
            print(
                f"{part:15} {it.exact:5} of {it.wanted:5} ({it.exact / it.wanted:.4f}), "
                f"{it.added} added; starts {starts[0]:.0f} {starts[1]:.0f}, "
                f"stops {stops[0]:.0f} {stops[1]:.0f}"
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
