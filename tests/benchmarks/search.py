"""How long searches take, in CPU time: ``python tests/benchmarks/search.py [RANDOM PATTERNS]``.

The patterns of `evaluate` and the worst ones known on the real captures; then synthetic libraries
of growing size, their columns held in memory, and random patterns of the whole grammar, of which
the largest library gets a part. It needs 3 GB.
"""

import sys
import time
import tomllib
import tracemalloc
from functools import partial
from pathlib import Path
from random import Random
from statistics import median

import numpy as np
import synthetic
from generated_patterns import random_pattern

from lanindex.errors import LanindexError
from lanindex.search.language import parse
from lanindex.search.limits import deadline
from lanindex.search.match import Finder

ROUNDS = 5
MOST_SECONDS = 20.0

WORST = {
    "r_arm any x3+ with l_arm any x3+": "",
    "r_forearm any ... any during l_forearm any ... any": "",
    "r_forearm low ... high ... low with l_forearm low ... high ... low": "",
}
SINGLE = (
    "r_arm right mid -> r_forward high -> place high",
    "r_arm right mid ...[<=3] place high",
    "r_arm right/r_forward mid/high -> any? -> place",
    "r_arm right mid -> high without head",
    "arms low ... high",
    "r_arm high with l_arm high",
    "(r_arm low ... high -> low) <4s",
)
HIT = 64
"""Bytes of a hit in a table of hits."""

MOST_HITS = 3
"""A search may take as much as the columns that it reads, and so many times what its hits do."""

SIZES = {4_000: 0.0, 40_000: 1.0, 400_000: 0.3}
"""Captures, and what share of the random patterns; the largest is some 80 million symbols, of which
the memory of searches is told, too."""


def finder(pattern: str, roster, columns) -> Finder:
    query = parse(pattern)
    own = {part: columns[part] for part in query.parts if part in columns}
    return Finder(query, roster, own, lambda places, parts: [])


def seconds(pattern: str, roster, columns, rounds: int = ROUNDS) -> tuple[float, int]:
    """Return the median of the time that a search takes, and how many hits it has."""
    times = []
    for _ in range(rounds):
        begun = time.process_time()
        found = finder(pattern, roster, columns).find(refused=[])
        times.append(time.process_time() - begun)
    return median(times), len(found)


def told(patterns, roster, columns) -> None:
    for pattern in patterns:
        spent, hits = seconds(pattern, roster, columns)
        print(
            f"  {spent * 1e3:9.1f} ms  {hits:8} hits  {' '.join(pattern.split())[:80]}", flush=True
        )


def peaks(patterns, roster, columns) -> None:
    """Say how much memory searches take, beside the columns that they read and what they find.

    What is kept with the columns is there already: of an earlier search.
    """
    shares = []
    for pattern in patterns:
        finder(pattern, roster, columns).find(refused=[])
        search = finder(pattern, roster, columns)
        tracemalloc.start()
        found = search.find(refused=[])
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        read = sum(
            getattr(columns[part], name).nbytes
            for part in parse(pattern).parts & columns.keys()
            for name in ("bounds", "cell", "runner", "margin", "start", "stop")
        )
        shares.append((peak / (read + MOST_HITS * HIT * len(found)), peak, pattern))
    kept = sum(share <= 1 for share, _, _ in shares)
    print(f"  {kept} of {len(shares)} searches take less than columns + {MOST_HITS} x hits")
    for share, peak, pattern in sorted(shares)[-5:]:
        print(f"  {share:4.0%} of that, {peak / 1e6:6.1f} MB  {' '.join(pattern.split())[:80]}")


def random_text(seed: int) -> str:
    return random_pattern(Random(seed), avoid={"stages", "where", "rhythm"})


def randomly(count: int, roster, columns) -> None:
    """Say how long random patterns take."""
    times, broken = [], 0
    for seed in range(count):
        search = finder(random_text(seed), roster, columns)
        begun = time.process_time()
        try:
            with deadline(lambda *told: None, MOST_SECONDS) as watched:
                search.find(watch=partial(watched, "captures"))
        except LanindexError:
            broken += 1
        times.append(time.process_time() - begun)
    spent = np.percentile(times, (50, 75, 90, 99, 100)) * 1e3
    told = ", ".join(
        f"p{part} {own:.0f}" for part, own in zip((50, 75, 90, 99), spent[:-1], strict=True)
    )
    print(f"  {len(times)} patterns, ms: {told},")
    print(f"  longest {spent[-1]:.0f}; broken off {broken}")


def main(patterns: int = 200) -> None:
    found = synthetic.real()
    page = tomllib.loads((Path(__file__).parent / "bandai2.toml").read_text(encoding="utf-8"))
    evaluated = [entry["pattern"] for entry in page.values()]
    print(f"{len(found.roster)} real captures, the worst patterns known")
    told(WORST, found.roster, found.columns)
    print("  all patterns of bandai2.toml, encoding apart")
    begun = time.process_time()
    told(evaluated, found.roster, found.columns)
    print(f"  {(time.process_time() - begun) / ROUNDS:.2f} s together")
    for captures, share in SIZES.items():
        roster, columns = synthetic.columns(captures)
        symbols = sum(map(len, columns.values()))
        print(f"{captures} captures, {symbols / 1e6:.1f} M symbols")
        told(SINGLE, roster, columns)
        if share:
            print("random patterns of the whole grammar", flush=True)
            randomly(round(share * patterns), roster, columns)
    print("memory of these patterns, and of those random ones", flush=True)
    peaks([*SINGLE, *map(random_text, range(round(share * patterns)))], roster, columns)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
