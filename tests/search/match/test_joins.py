"""Joins of simultaneous lines, against loops over all pairs."""

from dataclasses import replace

import numpy as np
import pytest
from effort import seeds

from lanindex.search.match import relations
from lanindex.search.match.arrays import best_of_each, in_order
from lanindex.search.match.hits import from_left
from lanindex.search.match.matches import NEVER, hull_rank
from lanindex.search.match.relations import Margins, SpanIndex, Spans
from lanindex.search.plan import NEGATIONS


def lines(random, many: int, captures: int = 3) -> Spans:
    start = random.integers(0, 30, many)
    until = start + random.integers(1, 9, many)
    return Spans(
        *(random.integers(0, captures, many), start, until, start, until, np.zeros(many, bool))
    )


def innermost(relation: str, one: Spans, other: SpanIndex, margins: Margins):
    """Yield, pair by pair, the hulls of each line and another that hold no other such hull."""
    line, beside_it = relations.pairs(relation, one, other, margins)
    low = np.minimum(one.low[line], other.spans.low[beside_it])
    high = np.maximum(one.high[line], other.spans.high[beside_it])
    hulls = {*zip(line.tolist(), low.tolist(), high.tolist(), strict=True)}
    for place, begin, end in hulls:
        inside = {(at, b, e) for at, b, e in hulls if at == place and b >= begin and e <= end}
        if inside == {(place, begin, end)}:
            yield place, begin, end


@pytest.mark.parametrize("seed", seeds(40))
def test_the_best_hulls_of_lines_that_share_frames(seed):
    random = np.random.default_rng(seed)
    one, other = lines(random, 25), SpanIndex(lines(random, int(random.integers(1, 30))))
    none = np.zeros(3, np.int64)
    margins = Margins(none, none + int(random.integers(-1, 4)), none)
    found = relations.hulls("with", one, other, margins)
    assert set(zip(*(it.tolist() for it in found), strict=True)) == set(
        innermost("with", one, other, margins)
    )
    assert (np.diff(found[0]) >= 0).all()
    named = set(found[0].tolist())
    assert named == set(relations.pairs("with", one, other, margins)[0].tolist())
    assert named == set(np.flatnonzero(relations.holds("with", one, other, margins)).tolist())


def overlap(one: Spans, at: int, other: Spans, beside_it: int) -> bool:
    """Return whether a line shares half of another, which may be a starting position alone."""
    frames = set(range(one.start[at], one.until[at]))
    beside = set(range(other.start[beside_it], other.until[beside_it]))
    shared = one.capture[at] == other.capture[beside_it] and len(frames & beside)
    return bool(shared) and (bool(other.alone[beside_it]) or 2 * shared >= len(beside))


@pytest.mark.parametrize("seed", seeds(20))
def test_lines_that_share_half_of_another(seed):
    random = np.random.default_rng(seed)
    one, beside = lines(random, 25), lines(random, int(random.integers(1, 30)))
    beside.alone = random.integers(0, 4, len(beside)) == 0
    other = SpanIndex(beside)
    none = np.zeros(3, np.int64)
    margins = Margins(none, none - 1, none)
    wanted = {
        (at, place)
        for at in range(len(one))
        for place in range(len(other))
        if overlap(one, at, beside, place)
    }
    found = relations.pairs("overlapping", one, other, margins)
    assert sorted(zip(*(it.tolist() for it in found), strict=True)) == sorted(wanted)
    held = set(np.flatnonzero(relations.holds("overlapping", one, other, margins)).tolist())
    assert {at for at, _ in wanted} <= held
    assert held == set(np.flatnonzero(relations.holds("with", one, other, margins)).tolist())
    hulls = relations.hulls("overlapping", one, other, margins)
    assert set(zip(*(it.tolist() for it in hulls), strict=True)) == set(
        innermost("overlapping", one, other, margins)
    )
    assert (np.diff(hulls[0]) >= 0).all()


@pytest.mark.parametrize("relation", ["during", "after", "before", "starting with", "ending with"])
def test_lines_hold_another_one_where_there_is_a_pair(relation):
    random = np.random.default_rng(len(relation))
    for _ in range(20):
        one, other = lines(random, 20), SpanIndex(lines(random, int(random.integers(1, 12))))
        none = np.zeros(3, np.int64)
        margins = Margins(none + random.integers(0, 3), none + random.integers(0, 9), none + 1)
        paired = set(relations.pairs(relation, one, other, margins)[0].tolist())
        assert set(np.flatnonzero(relations.holds(relation, one, other, margins))) == paired


ALL = [it for it in relations.RELATIONS if it not in NEGATIONS]


@pytest.mark.parametrize("seed", seeds(10))
@pytest.mark.parametrize("relation", ALL)
def test_lines_end_beside_others_within_their_bounds(relation, seed):
    random = np.random.default_rng(seed)
    one, other = lines(random, 25), SpanIndex(lines(random, int(random.integers(0, 12))))
    least = np.full(3, random.integers(0, 3))
    most = least + random.integers(0, 9) if relation in ("after", "before") else least - 1
    margins = Margins(least, most, np.full(3, random.integers(0, 3)))
    soonest = replace(one, until=one.until - random.integers(0, 5, len(one)))
    bounds = relations.end_bounds(relation, soonest, other, margins)
    line, beside = relations.pairs(relation, one, other, margins)
    assert (one.until[line] >= bounds.first[line]).all()
    assert (one.until[line] <= bounds.last[line]).all()
    low, high = one.start[line], one.until[line]
    if relations.RELATIONS[relation].adds_frames:
        low = np.minimum(low, other.spans.low[beside])
        high = np.maximum(high, other.spans.high[beside])
    assert (hull_rank(low, high) >= bounds.rank[line]).all()
    apart = np.setdiff1d(np.arange(len(one)), line)
    if not len(other):
        assert (bounds.rank[apart] == NEVER).all()


@pytest.mark.parametrize("relation", [it for it in ALL if relations.RELATIONS[it].adds_frames])
def test_pairs_may_leave_out_what_ends_late(relation):
    random = np.random.default_rng(len(relation))
    for _ in range(20):
        one, other = lines(random, 20), SpanIndex(lines(random, int(random.integers(1, 12))))
        none = np.zeros(3, np.int64)
        margins, most = Margins(none, none - 1, none + 1), random.integers(0, 30, len(one))
        pairs = set(zip(*relations.pairs(relation, one, other, margins), strict=True))
        soon = {(at, beside) for at, beside in pairs if other.spans.until[beside] <= most[at]}
        found = set(zip(*relations.pairs(relation, one, other, margins, most), strict=True))
        assert soon <= found <= pairs


def test_hits_from_left():
    random = np.random.default_rng(5)
    for _ in range(20):
        found = lines(random, 30)
        order = in_order((found.capture, found.start, found.until))
        hits = [it[order] for it in (found.capture, found.start, found.until)]
        kept, end = [], (-1, 0)
        for capture, low, high in zip(*(it.tolist() for it in hits), strict=True):
            kept.append((capture, low) >= end)
            end = (capture, high) if kept[-1] else end
        assert from_left(*hits).tolist() == kept


def test_rows_in_order_of_several_columns():
    random = np.random.default_rng(7)
    for most in (3, 1 << 20, 1 << 40):
        columns = tuple(random.integers(-most, most, 200) for _ in range(3))
        assert in_order(columns).tolist() == np.lexsort(columns[::-1]).tolist()
    assert in_order((np.array([2, 1, 2, 1]),)).tolist() == [1, 3, 0, 2]
    keys = (np.array([1, 0, 1, 0]),)
    assert best_of_each(keys, (np.array([5, 2, 4, 2]),)).tolist() == [1, 2]
