"""Hold the engine against the plain matcher: ``agreement.py [CASES] [SEED]``.

Random patterns of the whole grammar, each on a few small random captures, with overlaps and
without: capture, frames and fit must be the same, and the symbols of each line and label those of
one of the ways that are as good. Every other one as in a large library, of which most is left out
at once; two of four as in long captures; one of three of the whole body. 20,000 cases take about
ten minutes.
"""

import sys
from fractions import Fraction
from random import Random
from time import perf_counter

import places  # noqa: F401  (finds the tests)
from fast_search import find_fast
from generated_patterns import random_pattern
from plain_matcher import ties
from random_library import DIRECTIONS, PARTS, WHOLE, random_library

from lanindex.errors import LanindexError
from lanindex.model import Hit
from lanindex.search.language import parse
from lanindex.search.match import finder as find_module
from lanindex.search.match import leading


def told(hit: Hit) -> tuple[object, ...]:
    """Return what two matchers must agree in."""
    return (
        *(hit.capture.id, hit.span, round(hit.fit, 3)),
        [[(symbol.part, symbol.ordinal) for symbol in line] for line in hit.lines],
        {label: [(it.part, it.span) for it in found] for label, found in hit.labels.items()},
    )


def differs(text: str, recordings: list, overlaps: str) -> str:
    """Return in what the engine differs; nothing where it does not."""
    query, options = parse(text), {"tolerance": Fraction(1, 5), "overlaps": overlaps}
    wanted = [[told(hit) for hit in hits] for hits in ties(query, recordings, **options)]
    found = [told(hit) for hit in find_fast(query, recordings, **options)]
    if [it[:3] for it in found] != [hits[0][:3] for hits in wanted]:
        return "frames or fit"
    # of those with the same frames and fit, in any order
    left = list(found)
    for hits in wanted:
        here = next((it for it in left if it in hits), None)
        if here is None:
            return "symbols"
        left.remove(here)
    return ""


def set_up(case: int) -> None:
    """Choose the ways that the engine goes."""
    find_module.MANY = 1 if case % 2 else 1000
    leading.SHORT = 0 if case % 4 > 1 else 1000


def main(cases: int = 20_000, seed: int = 1) -> int:
    differing = too_many = 0
    begin = perf_counter()
    for case in range(seed, seed + cases):
        set_up(case)
        random = Random(case)
        parts = random.sample(WHOLE, 3) if case % 3 == 0 else PARTS
        text = random_pattern(random, parts=parts, directions=DIRECTIONS, avoid={"stages"})
        recordings = random_library(random, known=parts)
        overlaps = random.choice(("all", "none"))
        try:
            wrong = differs(text, recordings, overlaps)
        except LanindexError:
            too_many += 1
            continue
        if wrong:
            differing += 1
            print(f"seed {case}, overlaps {overlaps}, {wrong}: {text}")
    seconds = perf_counter() - begin
    print(f"{cases} cases, {differing} differ, {seconds:.0f} s")
    print(f"{too_many} fit in too many ways to try them all")
    return min(differing, 1)


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:3])))
