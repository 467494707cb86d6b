"""Partial matches that may be dropped: dominated ends, lines that cannot overlap."""

from random import Random

import numpy as np
import pytest
from effort import seeds, slow, some
from fast_search import find_fast, told
from plain_matcher import find
from random_library import random_library

from lanindex.search import limits
from lanindex.search.language import parse
from lanindex.search.match import leading, walk
from lanindex.search.match.arrays import FAR, filled
from lanindex.search.match.join import unexcused
from lanindex.search.match.matches import Claims, single_claims
from lanindex.search.match.relations import Margins, SpanIndex, Spans, pairs
from lanindex.search.match.rewrites import Rewrites
from lanindex.search.plan import plan

PATTERNS = [
    # the end that comes first, and the one that comes last
    "r_arm any ... any without head",
    "r_arm any ... any before head any ... any",
    "r_arm any ... any before[<1s] head",
    "r_arm low ... any after head any ... any",
    "r_arm any ... any after[<1s] head any ... any",
    "r_arm any during head any ... any",
    "r_arm at any starting with arm any ... any",
    "r_arm any ... any starting with l_arm any never head high",
    "r_arm any ... any overlapping head any",
    "r_arm any overlapping head any ... any",
    "r_arm any overlapping head low ... high",
    "r_arm via any -> any ... any without head",
    "r_arm low without (l_arm any ... any with head)",
    # what others could want
    "arm low ... any without r_arm high -> end",
    "r_arm at low ... any never arms",
    "r_arm any without[0.5s] arm any -> any",
    "r_arm any -> any without r_arm hold",
    # runs on
    "r_arm any x1+ with l_arm any x1+ with head any x1+",
    "arm any x2+ with arm any x2+ never head high",
    "r_arm any x2+ ... low x1+ with l_arm any",
    "r_arm any with l_arm any x1+ without head any x1+",
    "r_arm any overlapping l_arm any x1+",
    "r_arm any x1+ overlapping arm any -> any",
    # disturbed as soon as they reach a forbidden line
    "r_arm any x1+ without l_arm high",
    "r_arm any x1+ without[0.3s] l_arm high",
    "(r_arm any ... any) x1+ without arm high",
    "r_arm at any x1+ without l_arm at high without head",
    "r_arm any x1+ with l_arm any without head high",
    "arms any x1+ without r_leg",
    # cannot be abreast
    "arm any with arm any",
    "arm any -> any during arm any x2+",
    "arm any -> any without arm low",
    "arm any -> any with[0.5s] arm low",
    "arm any with head without arm low",
    # share no symbol
    "r_arm low ... any after r_arm any ... any",
    "arm any -> any before arm any x2+",
    "arms any after (r_arm any with r_arm at any)",
    "(r_arm any after r_arm any) x2+",
    "r_arm any x1+ after r_arm low -> any with r_arm at any",
]
RUNNING = [
    "r_arm low ... high without head",
    "r_arm any ... any before head any ... any",
    "r_arm any ... any never l_arm any ... any",
    "r_arm any x1+ with l_arm any x1+",
    "arm any x3+ with arm any x3+",
    "arm low ... any without r_arm any -> end",
    "r_arm any x3+ without l_arm high",
]


@pytest.mark.parametrize("pattern", PATTERNS)
def test_what_is_left_out_is_never_better(pattern: str) -> None:
    query, hits = parse(pattern), 0
    for seed in some(30, 2):
        recordings = random_library(Random(seed))
        found = find_fast(query, recordings, overlaps="all")
        assert told(found) == told(find(query, recordings, overlaps="all")), seed
        hits += len(found)
    assert hits or not slow()


@pytest.mark.parametrize("pattern", RUNNING)
def test_ways_are_no_more_than_a_few_times_the_rows(pattern: str, monkeypatch) -> None:
    recordings = random_library(Random(7), captures=1, most=400)
    rows = sum(len(track.symbols) for track in recordings[0][1].values())
    assert rows > 500
    monkeypatch.setattr(
        limits, "most_rows", lambda size: 2 * rows if size == walk.MATCH else 1 << 25
    )
    calls, best_of_all = [], leading._best_ends
    monkeypatch.setattr(
        leading, "_best_ends", lambda *given: calls.append(given) or best_of_all(*given)
    )
    find_fast(parse(pattern), recordings)
    assert 0 < len(calls) <= len(plan(parse(pattern)))  # of too many ways, half is tried at a time


def test_lines_of_one_part_are_abreast_only_where_they_can_be() -> None:
    wanted = {
        "r_arm high -> low with arm high": {"l_arm"},
        "r_arm high during arm low x1+": {"l_arm"},
        "r_arm high overlapping arm low -> any": {"l_arm"},
        "r_arm high without arm": {"l_arm"},
        "r_arm high with head without arm": {"r_arm", "l_arm"},
        "r_arm high ... low with arm high": {"r_arm", "l_arm"},
        "r_arm high with[1s] arm high": {"r_arm", "l_arm"},
        "r_arm high with arm at high": {"r_arm", "l_arm"},
    }
    for pattern, parts in wanted.items():
        (program,) = plan(parse(pattern))
        found = Rewrites(program).programs(program.outermost.companions[-1])
        assert {line.states[0].members[0] for line in found} == parts, pattern


def test_lines_that_are_over_before_others_claim_nothing_from_them() -> None:
    wanted = {
        "r_arm any after r_arm any": False,
        "r_arm any before r_arm any x2+": False,
        "r_arm any with l_arm any after r_arm any": False,
        "r_arm any with (l_arm any after r_arm any)": True,
        "(r_arm any after r_arm any) x2+": True,
        "r_arm any after r_arm any after r_arm any": True,
    }
    for pattern, contested in wanted.items():
        (program,) = plan(parse(pattern))
        assert bool(Rewrites(program).contested) is contested, pattern


@pytest.mark.parametrize("seed", seeds(30))
def test_matches_are_counted_as_if_they_were_paired(seed: int) -> None:
    random = np.random.default_rng(seed)
    (lines, forgiving), (matches, had) = (_lines(random, many) for many in (12, 30))
    for relation, most in (("without", -1), ("without", 2), ("never", -1)):
        margins = Margins(*(np.full(3, it) for it in (0, most, 0)))
        line, match = pairs(relation, lines, SpanIndex(matches), margins)
        wanted = np.zeros(len(lines), bool)
        wanted[line[forgiving.at(line).disjoint(had.at(match))]] = True
        found = unexcused(relation, lines, forgiving, matches, had, margins)
        assert found.tolist() == wanted.tolist()


def _lines(random: np.random.Generator, many: int) -> tuple[Spans, Claims]:
    start = random.integers(0, 20, many)
    until = start + random.integers(1, 6, many)
    frames = (random.integers(0, 3, many), start, until, start, until)
    first = random.integers(0, 12, many)
    some = random.random(many) < 0.7
    one = single_claims(np.where(some, first, FAR), np.where(some, first + 1, FAR))
    other = first + random.integers(4, 9, many)
    both = Claims(*(filled([single_claims(other, other).first]) for _ in "ab"))
    return Spans(*frames, np.zeros(many, bool)), one.united_with(both)
