"""State that partial matches keep: clauses, companions of brackets, repeats."""

from dataclasses import replace
from fractions import Fraction
from random import Random

import numpy as np
import pytest
from effort import slow, some
from fast_search import find_fast, told
from plain_matcher import find
from query_cases import recordings_of
from random_library import random_library

from lanindex.pipeline.search import NEAR
from lanindex.search import limits
from lanindex.search.language import parse
from lanindex.search.limits import OverBudget
from lanindex.search.match import leading, matches, walk
from lanindex.search.match.arrays import FAR, together
from lanindex.search.match.context import Context
from lanindex.search.match.matches import Claims, Nodes, single_claims

PATTERNS = [
    # conditions on one step, on several, on what is missing
    "a: r_arm high where a.length < 0.3s",
    "a: r_arm any -> b: any where a.level < b.level and b.length >= a.length",
    "a: r_arm any ... b: any where b.start - a.end <= 3f and a.direction = b.direction",
    "a: arm any where a.part = r_arm and a.margin + 0.2 >= 0.5",
    "r_arm low -> a: mid? -> b: high where a.length < 1s",
    "r_arm low -> a: mid? -> b: high where b.length < 1s and b.level != low",
    "a: (r_arm any x1..2) -> b: any where a.length > b.length",
    "a: arms any where a.length > 3f",
    "a: r_arm at high where a.length < 2b and a.swings < 1",
    # conditions on all that matched, and on the capture
    "r_arm any ... high where match.length > 1s",
    "r_arm any ... high with l_arm any where match.length > 1s and match.level = high",
    'r_arm any -> high where clip.label = "made" and clip.frames > 15',
    'r_arm any where clip.path = "made2.lnd"',
    "a: r_arm any where a.margin + 9.5 < clip.fps - 0.2",
    "a: r_arm any where a.start > 0s and a.margin != clip.nothing",
    # conditions on lines beside each other
    "a: r_arm any with b: l_arm any where b.start - a.start < 0.2s and a mirrors b",
    "a: r_arm any x2 with b: l_arm any x1+ where a mirrors b",
    "a: (r_arm any x1+) with b: (l_arm any x1+) where b mirrors a",
    "a: (l_arm any x2+) with b: (r_arm any x1+) where a mirrors b",
    "a: (r_arm rising x1+) with b: (l_arm any <0.4s x1+) where a mirrors b",
    "a: (r_arm not low x1+) with b: (l_arm any x1+) either side where a mirrors b",
    "a: (r_arm any x1+) with b: (l_arm any x1+) or r_arm high where a mirrors b",
    "a: (r_arm any x1+) with b: (l_arm any x1+ -> end) where a mirrors b",
    "a: (r_arm any x1+) with b: (l_arm any x1+) where a mirrors b and a.length > 0.2s",
    "a: r_arm any with b: l_arm any x1+ where a.level = b.level",
    "(r_arm any with a: l_arm any or r_arm high) -> b: r_arm any where a.length = b.length",
    "l1: head right/place -> any starting with l2: r_arm any where l1.level = l2.level",
    # rhythm
    "r_arm any -> any rhythm 1:1",
    "r_arm any x1+ rhythm 1:1.5:2",
    "arm any ... any? -> any rhythm 2:1 where match.length < 3s",
    "r_arm any -> (any with head) rhythm 1:2",
    # lines beside brackets of a longer line
    "r_arm any -> (any with l_arm any) -> any",
    "r_arm any -> (high without l_arm any)",
    "(r_arm any with arm any) -> any",
    "((r_arm any -> any) without arm any) -> any with arm any",
    "r_arm any ... (any after head) ... (any before l_arm)",
    "(r_arm any with r_arm at any) x1+",
    "(r_arm any never l_arm high)? -> any with l_arm any",
    "r_arm any during (l_arm any with head) -> any",
    # open repeats: of a length, with lines beside them, that take what others could want
    "(r_arm any x1+) <1s",
    "(r_arm any x1+) <1s x1+",
    "r_arm any x1+ with arm any x1+",
    "r_arm any x1+ ending with l_arm any x1+",
    "r_arm any x2+ without arm any",
    "r_arm any x1+ after[<1s] l_arm any x1+",
    "head via any -> any with r_arm any",
    # claims that nothing can want any more
    "(r_arm any x1+ with l_arm any) x2+",
    "(r_arm any x1..2 with l_arm any -> any) x2+",
    "(r_arm any with arm any) x2+ with l_arm any",
    "(r_arm any during l_arm any) x2+ with arm any",
    "(r_arm any x1+ ending with l_arm any) x1+ during head any",
    "(r_arm any with l_arm at any) x2+ with l_arm hold",
    "(r_arm any before l_arm any) x2 with l_arm any",
    "(r_arm any after l_arm any) x2+",
    "(r_arm any with[0.2s] l_arm any) x2+",
    "(r_arm any with l_arm any) x2 without l_arm high",
    "(r_arm any with (l_arm any with head any)) x2+ with head any",
    "(arms any with l_arm at any) x1+ with arm at any",
]


@pytest.mark.parametrize("pattern", PATTERNS)
def test_what_ways_remember_is_found_as_plainly(pattern: str, monkeypatch) -> None:
    query, hits = parse(pattern), 0
    for seed in some(6, 1):
        recordings = random_library(Random(seed))
        for overlaps in ("all", "none"):
            options = {"tolerance": Fraction(1, 5), "overlaps": overlaps}
            plain = told(find(query, recordings, **options))
            for short in (0, leading.SHORT):
                monkeypatch.setattr(leading, "SHORT", short)
                assert told(find_fast(query, recordings, **options)) == plain, short
            hits += len(plain)
    assert hits or "clip.nothing" in pattern or not slow()


def test_beginnings_do_not_multiply_what_is_followed(monkeypatch) -> None:
    tried, count = [], Context.count_tried

    def counted(self, capture):
        tried.append(len(capture))
        return count(self, capture)

    monkeypatch.setattr(Context, "count_tried", counted)
    query = parse("(r_arm any x2+ with l_arm any) x3+")
    recordings = random_library(Random(7), captures=1, most=120)
    found = {}
    for short in (0, leading.SHORT):
        tried.clear()
        monkeypatch.setattr(leading, "SHORT", short)
        found[short] = told(find_fast(query, recordings, overlaps="all")), sum(tried)
    assert found[0][0] == found[leading.SHORT][0] != []
    assert 10 * found[leading.SHORT][1] < found[0][1]


@pytest.mark.parametrize(
    "pattern",
    [
        "r_arm right with[1s] r_arm left",
        "l_arm any with r_arm high without r_arm high",  # what must not happen is never near
    ],
)
def test_lines_take_one_symbol_each_also_near_a_border(pattern: str) -> None:
    query = replace(parse(pattern), near=NEAR)
    found = 0
    for seed in some(200, 20):
        recordings = random_library(Random(seed))
        hits = told(find_fast(query, recordings, overlaps="all"))
        assert hits == told(find(query, recordings, overlaps="all"))
        found += len(hits)
    assert found


def test_of_hits_with_the_same_frames_the_clearest_comes_first() -> None:
    (recording,) = recordings_of(
        "fps 10 frames 13; r_arm: left high 0 0, left high 0 4, place high 5 6"
    )
    track = recording.tracks["r_arm"]
    symbols = track.symbols.copy()
    symbols["margin"] = 0.5, 0.85, 0.8
    recordings = [(recording.capture, {"r_arm": replace(track, symbols=symbols)})]
    query = parse("r_arm ... hold high -> high")
    assert told(find_fast(query, recordings)) == told(find(query, recordings)) == [(1, 0, 6, 0.8)]


def test_what_is_too_much_for_one_capture_is_tried_in_parts(monkeypatch) -> None:
    walked, once = [], walk.Walk.run

    def found(self, *given):
        walked.append(given)
        return once(self, *given)

    monkeypatch.setattr(limits, "most_rows", lambda size: 12 if size == walk.MATCH else 1 << 20)
    monkeypatch.setattr(walk.Walk, "run", found)
    query, many = parse("a: r_arm any ... b: any where a.level < b.level"), []
    for seed in range(10):
        recordings = random_library(Random(seed), captures=1)
        walked.clear()
        assert told(find_fast(query, recordings)) == told(find(query, recordings))
        many.append(len(walked))
    assert max(many) > 3


def test_claims_are_sets() -> None:
    random = Random(1)
    sets = [
        [{random.randrange(6) for _ in range(random.randrange(6))} for _ in "ab"] for _ in "x" * 50
    ]
    one, two = (together([_claims(pair[side]) for pair in sets]) for side in range(2))
    both = one.united_with(two)
    assert one.disjoint(two).tolist() == [not a & b for a, b in sets]
    assert [_numbers(both.at(np.array([place]))) for place in range(50)] == [a | b for a, b in sets]
    assert both.none.tolist() == [not a | b for a, b in sets]
    same = two.united_with(one)
    assert np.array_equal(both.first, same.first)
    assert np.array_equal(both.last, same.last)


def _claims(numbers: set[int]) -> Claims:
    found = matches.no_claims(1)
    for number in numbers:
        claim = np.array([number])
        found = found.united_with(single_claims(claim, claim))
    return found


def _numbers(claims: Claims) -> set[int]:
    ranges = zip(claims.first[:, 0].tolist(), claims.last[:, 0].tolist(), strict=True)
    return {it for first, last in ranges if first < FAR for it in range(first, last + 1)}


def test_nodes_tell_what_goes_on_in_what(monkeypatch) -> None:
    nodes = Nodes()
    first = nodes.add(2, np.array([-1, -1]), np.array([0, 1]))
    second = nodes.add(2, first, np.array([0, 0]))
    third = nodes.add(1, second[:1], np.array([0]))
    lines = np.array([0, 0, 1, 1, 2])
    ends = np.array([first[1], third[0], second[1], third[0], first[0]])
    assert nodes.behind(lines, ends).tolist() == [True, False, False, False, False]
    assert nodes.leading_to(second[:1]).tolist() == [True, True, True, False, False]
    monkeypatch.setattr(limits, "most_rows", lambda size: 10)
    with pytest.raises(OverBudget):
        nodes.behind(lines, ends)
