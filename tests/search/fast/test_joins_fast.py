"""What is compiled against what is not, in what lines beside one another need."""

import numpy as np
import pytest
from both_ways import fast, plain

from lanindex.model.columns import PASSING, STARTING, Columns
from lanindex.search import compiled
from lanindex.search.automaton import plan
from lanindex.search.fast import beside, overlaps
from lanindex.search.fast.beside import Margins, Others, Stretches
from lanindex.search.fast.chains import chains_of
from lanindex.search.fast.events import events_of
from lanindex.search.fast.linked import rows_of
from lanindex.search.fast.ragged import best_of_each, in_order
from lanindex.search.fast.rows import Rows
from lanindex.search.language import parse


def both(monkeypatch, ask):
    """Return what is told plainly, and what the compiled loops tell."""
    told = []
    for way in (plain, fast):
        monkeypatch.setattr(compiled, "chosen", way)
        told.append(ask())
    return told


def lines(random, many: int, captures: int = 3) -> Stretches:
    start = random.integers(0, 30, many)
    until = start + random.integers(1, 9, many)
    return Stretches(
        *(random.integers(0, captures, many), start, until, start, until, np.zeros(many, bool))
    )


@pytest.mark.parametrize("seed", range(40))
def test_the_best_hulls_of_lines_that_share_frames(seed, monkeypatch):
    random = np.random.default_rng(seed)
    one, other = lines(random, 25), Others(lines(random, int(random.integers(1, 30))))
    none = np.zeros(3, np.int64)
    margins = Margins(none, none + int(random.integers(-1, 4)), none)
    plain, fast = both(monkeypatch, lambda: beside.hulls("with", one, other, margins))
    assert set(zip(*map(list, plain), strict=True)) == set(zip(*map(list, fast), strict=True))
    assert (np.diff(fast[0]) >= 0).all()
    named = set(plain[0].tolist())
    assert named == set(beside.pairs("with", one, other, margins)[0].tolist())
    assert named == set(np.flatnonzero(beside.holds("with", one, other, margins)).tolist())


@pytest.mark.parametrize("relation", ["during", "after", "before", "starting with", "ending with"])
def test_lines_hold_another_one_where_there_is_a_pair(relation):
    random = np.random.default_rng(len(relation))
    for _ in range(20):
        one, other = lines(random, 20), Others(lines(random, int(random.integers(1, 12))))
        none = np.zeros(3, np.int64)
        margins = Margins(none + random.integers(0, 3), none + random.integers(0, 9), none + 1)
        paired = set(beside.pairs(relation, one, other, margins)[0].tolist())
        assert set(np.flatnonzero(beside.holds(relation, one, other, margins))) == paired


def test_hits_from_left(monkeypatch):
    random = np.random.default_rng(5)
    for _ in range(20):
        found = lines(random, 30)
        order = in_order((found.capture, found.start, found.until))
        hits = [it[order] for it in (found.capture, found.start, found.until)]
        plain, fast = both(monkeypatch, lambda hits=hits: overlaps.from_left(*hits))
        assert plain.tolist() == fast.tolist()


@pytest.mark.parametrize(
    "text", ["r_arm mid", "r_arm low -> high", "r_arm low -> left mid -> high", "r_arm any x3"]
)
def test_the_rows_of_a_chain(text, monkeypatch):
    random = np.random.default_rng(len(text))
    many, captures = 4000, 100
    bounds = np.sort(random.integers(0, many, captures + 1))
    bounds[[0, -1]] = 0, many
    flags = random.choice(np.array([0, 0, 0, PASSING, PASSING, STARTING], np.uint8), many)
    cell = ((random.integers(1, 10, many) | random.integers(1, 4, many) << 4) | flags).astype("u1")
    times = np.arange(many, dtype=np.int32)
    columns = Columns(
        *("r_arm", bounds, cell, cell, np.zeros(many, np.uint16), times, times + 1),
        gaps=np.empty((0, 3), np.int32),
    )
    (program,) = plan(parse(text))
    some = np.flatnonzero(random.random(captures) < 0.7)
    for chain in chains_of(program):
        plain, fast = both(monkeypatch, lambda chain=chain: rows_of(columns, chain, some))
        assert {*zip(*plain.tolist(), strict=True)} == {*zip(*fast.tolist(), strict=True)}
        assert fast.shape[1]


def rows_of_some(seed: int) -> Rows:
    """Return rows of a few captures, some passing, some starting positions, some left at once."""
    random = np.random.default_rng(seed)
    many, captures = 300, 12
    bounds = np.sort(random.integers(0, many, captures + 1))
    bounds[[0, -1]] = 0, many
    flags = random.choice(np.array([0, 0, 0, PASSING, STARTING], np.uint8), many)
    start = np.arange(many, dtype=np.int32) * 3 + random.integers(0, 2, many)
    start -= np.repeat(start[bounds[:-1].clip(max=many - 1)], np.diff(bounds))
    stop = start + np.where(flags == STARTING, 0, random.integers(1, 3, many))
    columns = Columns(
        *("r_arm", bounds, random.integers(1, 4, many).astype("u1") | flags, flags),
        *(random.integers(0, 1000, many).astype("u2"), start.astype("i4"), stop.astype("i4")),
        gaps=np.array([[2, 0, 50], [5, 3, 9], [5, 20, 70]], np.int32),
    )
    return Rows(columns, np.arange(captures), np.full(captures, 1000))


@pytest.mark.parametrize("seed", range(20))
def test_stays(seed, monkeypatch):
    rows = rows_of_some(seed)
    for text in ("r_arm at any", "r_arm at forward", "r_arm at not r_forward"):
        (state,) = plan(parse(text))[0].states
        plain, fast = both(monkeypatch, lambda state=state: events_of(rows, state, 0))
        for name in ("capture", "start", "end", "until", "cost", "passing", "starting"):
            assert getattr(plain, name).tolist() == getattr(fast, name).tolist()
        assert plain.first[0].tolist() == fast.first[0].tolist()
        assert plain.last[0].tolist() == fast.last[0].tolist()
        assert len(plain)


def test_rows_in_order_of_several_columns():
    random = np.random.default_rng(7)
    for most in (3, 1 << 20, 1 << 40):
        columns = tuple(random.integers(-most, most, 200) for _ in range(3))
        assert in_order(columns).tolist() == np.lexsort(columns[::-1]).tolist()
    assert in_order((np.array([2, 1, 2, 1]),)).tolist() == [1, 3, 0, 2]
    keys = (np.array([1, 0, 1, 0]),)
    assert best_of_each(keys, (np.array([5, 2, 4, 2]),)).tolist() == [1, 2]
