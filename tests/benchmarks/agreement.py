"""Hold the engine against the plain matcher: ``agreement.py [CASES] [SEED]``.

Random patterns of the whole grammar, each on a few small random captures, with overlaps and
without; capture, frames and fit must be the same; where ways tie in all these either may tell the
symbols of another one, which is counted. Every other one as in a large library, of which most is
left out at once; two of four with what is compiled. Says how many captures the engine left to the
plain matcher, and which patterns did it. 20,000 cases take about five minutes.
"""

import sys
from collections.abc import Iterable
from fractions import Fraction
from random import Random
from time import perf_counter

import places  # noqa: F401  (finds the tests)
from both_ways import fast, plain
from fast_search import find_fast
from grammar_patterns import random_pattern
from random_library import DIRECTIONS, PARTS, random_library

from lanindex.errors import LanindexError
from lanindex.model import Hit
from lanindex.search import compiled
from lanindex.search.fast import find as find_module
from lanindex.search.fast import order
from lanindex.search.language import parse
from lanindex.search.plain import find


def told(hits: Iterable[Hit]) -> list[tuple[object, ...]]:
    """Return what two matchers must agree in."""
    return [
        (
            *(hit.capture.id, hit.span, round(hit.fit, 3)),
            sorted((symbol.part, symbol.ordinal) for symbol in hit.symbols),
            {label: [(it.part, it.span) for it in found] for label, found in hit.labels.items()},
        )
        for hit in hits
    ]


def agrees(text: str, recordings: list, overlaps: str) -> tuple[bool, bool, int]:
    """Return whether both find and tell the same, and how many captures the engine left alone."""
    query, tolerance = parse(text), Fraction(1, 5)
    try:
        wanted = told(find(query, recordings, tolerance=tolerance, overlaps=overlaps))
    except LanindexError:
        return True, True, 0
    found = find_fast(query, recordings, tolerance=tolerance, overlaps=overlaps)
    here = told(found)
    return [it[:3] for it in here] == [it[:3] for it in wanted], here == wanted, found.left


def set_up(case: int) -> None:
    """Choose the ways that the engine goes."""
    find_module.MANY = 1 if case % 2 else 1000
    compiled.chosen = fast if case % 4 < 2 else plain


def main(cases: int = 20_000, seed: int = 1) -> int:
    left = captures = differing = otherwise = 0
    begin = perf_counter()
    order.FEW = 0
    for case in range(seed, seed + cases):
        set_up(case)
        random = Random(case)
        text = random_pattern(random, parts=PARTS, directions=DIRECTIONS, avoid={"stages"})
        recordings = random_library(random)
        overlaps = random.choice(("all", "none"))
        same, alike, alone = agrees(text, recordings, overlaps)
        otherwise += same and not alike
        left, captures = left + alone, captures + len(recordings)
        if alone:
            print(f"seed {case}, {alone} captures left: {text}")
        if not same:
            differing += 1
            print(f"seed {case}, overlaps {overlaps}: {text}")
    seconds = perf_counter() - begin
    print(f"{cases} cases, {differing} differ, {seconds:.0f} s")
    print(f"{otherwise} tell the symbols of another way that ties")
    print(f"the engine left {left} of {captures} captures to the plain matcher")
    return min(differing, 1)


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:3])))
