"""The clearest hits equal the first of all hits sorted."""

from dataclasses import replace
from random import Random

import pytest
from effort import seeds, some
from fast_search import find_fast
from generated_patterns import random_pattern
from query_cases import recordings_of
from random_library import DIRECTIONS, PARTS, random_library

from lanindex.pipeline.search import NEAR
from lanindex.search.language import parse
from lanindex.search.match import finder
from lanindex.search.match import hits as found_module
from lanindex.search.match.finder import Finder


@pytest.mark.parametrize("seed", seeds(4))
def test_the_clearest_are_those_that_sorting_puts_first(seed: int, monkeypatch) -> None:
    monkeypatch.setattr(found_module, "TOGETHER", 2)
    several = 0
    for case in some(100, 40):
        random = Random(f"clearest {seed} {case}")
        text = random_pattern(random, parts=PARTS, directions=DIRECTIONS, avoid={"stages"})
        query = replace(parse(text), near=random.choice((0, NEAR)))
        found = find_fast(query, random_library(random) * 3, overlaps="all")
        every = list(found.by_fit())
        for most in (1, 3):
            best = found.by_fit(most)
            assert list(best[:most]) == every[:most], text
            assert sorted(map(repr, best)) == sorted(map(repr, every)), text
        several += len(every) > 3
    assert several > 4


def test_only_those_are_made_that_might_be_the_clearest(monkeypatch):
    clip = "fps 10 frames 60; {}: place low 0 0, {} mid 5 12, place low 30 36"
    recordings = []
    for number in range(400):
        (one,) = recordings_of(f"{clip.format('r_arm', 'right')}; l_arm: left mid 5 12")
        arm = one.tracks["r_arm"]
        symbols = arm.symbols.copy()
        symbols["margin"][1] = number / 400
        tracks = {**one.tracks, "r_arm": replace(arm, symbols=symbols)}
        recordings.append((replace(one.capture, id=number), tracks))
    found = find_fast(parse("r_arm right mid with l_arm left mid"), recordings)
    made, hits = [], Finder.hits
    monkeypatch.setattr(Finder, "hits", lambda own, some: made.extend(some.low) or hits(own, some))
    assert [it.fit for it in found.by_fit(2)[:2]] == [0.998, 0.995]
    assert len(found) == 400
    assert len(made) <= found_module.TOGETHER + 2


def test_hits_of_many_captures_are_told_by_one_walk(monkeypatch):
    clip = "fps 10 frames 60; r_arm: place low 0 0, right mid 5 12, left high 20 30"
    recordings = []
    for number in range(200):
        (one,) = recordings_of(clip)
        recordings.append((replace(one.capture, id=number), one.tracks))
    walks, traced = [], finder.traced
    monkeypatch.setattr(finder, "traced", lambda *args: walks.append(1) or traced(*args))
    hits = list(find_fast(parse("r_arm right mid -> left high"), recordings))
    assert [hit.capture.id for hit in hits] == list(range(200))
    assert len(walks) == 1
