"""A thousand patterns of the whole grammar, each on several random captures at once."""

from dataclasses import replace
from fractions import Fraction
from random import Random

import pytest
from effort import seeds
from fast_search import find_fast, told
from generated_patterns import random_pattern
from plain_matcher import ties
from random_library import DIRECTIONS, PARTS, TOUCHES, WHOLE, random_library

from lanindex.model import Hit
from lanindex.pipeline.search import NEAR
from lanindex.search.language import parse
from lanindex.search.match import finder as find_module
from lanindex.search.match import leading


@pytest.mark.parametrize("seed", seeds(10))
def test_a_hundred_patterns_of_the_whole_grammar(seed: int, monkeypatch) -> None:
    if seed % 2:  # leave out what cannot have a hit, as in a large library
        monkeypatch.setattr(find_module, "MANY", 1)
    if seed % 4 > 1:  # walk from each beginning, as in long captures
        monkeypatch.setattr(leading, "SHORT", 0)
    for case in range(100):
        random = Random(f"{seed} {case}")
        parts = random.sample(WHOLE if case % 8 == 3 else TOUCHES, 3) if case % 4 == 3 else PARTS
        text = random_pattern(random, parts=parts, directions=DIRECTIONS, avoid={"stages"})
        recordings = random_library(random, known=parts)
        query = replace(parse(text), near=random.choice((0, 0, NEAR)))
        options = {"tolerance": Fraction(1, 5), "overlaps": random.choice(("all", "none"))}
        found = find_fast(query, recordings, **options)
        wanted = list(ties(query, recordings, **options))
        assert told(found) == told(hits[0] for hits in wanted), text
        for hit in found:
            assert any(is_as_good(hit, other) for hits in wanted for other in hits), text


def is_as_good(hit: Hit, other: Hit) -> bool:
    return hit.span == other.span and (hit.lines, hit.labels) == (other.lines, other.labels)
