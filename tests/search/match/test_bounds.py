"""Budgets, deadlines, and hits of a library that has changed."""

import gc
from contextlib import contextmanager
from fractions import Fraction
from functools import partial
from random import Random

import numpy as np
import pytest
from dances import BOW
from effort import slow, some
from fast_search import find_fast, told
from generated_patterns import random_pattern
from plain_matcher import find
from plain_matcher.conditions import holds
from query_cases import recordings_of
from random_library import DIRECTIONS, PARTS, random_library

from lanindex.errors import LanindexError
from lanindex.model import Capture, Span, Track
from lanindex.model.symbol import blank
from lanindex.pipeline.library import open_library
from lanindex.search import limits
from lanindex.search.language import parse
from lanindex.search.language.times import Time
from lanindex.search.limits import deadline
from lanindex.search.match import arrays, leading, walk
from lanindex.search.match.batch import Batch
from lanindex.search.match.context import Context
from lanindex.search.match.finder import NARROWER, Finder, columns_in


@contextmanager
def patience(seconds: float):
    """Yield what breaks a search off in time."""
    with deadline(lambda *told: None, seconds, remedy=NARROWER) as told:
        yield partial(told, "captures")


def test_what_is_too_much_at_once_is_tried_in_parts_or_refused(monkeypatch):
    most = {arrays.PAIR: 2, walk.MATCH: 1}
    monkeypatch.setattr(limits, "most_rows", lambda size: most.get(size, 9))
    refused = 0
    for seed in some(100, 20):
        random = Random(seed)
        text = random_pattern(random, parts=PARTS, directions=DIRECTIONS, avoid={"stages"})
        recordings, query = random_library(random), parse(text)
        try:
            found = told(find_fast(query, recordings))
        except LanindexError:
            refused += 1
        else:
            assert found == told(find(query, recordings)), text
    assert 0 < refused < 50


def test_a_search_gives_up_in_time():
    recordings = [
        (it.capture, it.tracks) for it in recordings_of("fps 10 frames 9; head: place low 0 0")
    ]
    for pattern in ("head low ... high", "head low -> high rhythm 1:2"):
        with (
            pytest.raises(LanindexError, match=r"longer than 0 s.*0 of 1 captures.*Bound"),
            patience(0) as watch,
        ):
            find_fast(parse(pattern), recordings, watch=watch)


def test_a_search_gives_up_in_time_within_one_capture():
    recordings, calls = [random_library(Random(2), captures=1, most=8)[0]], []

    def watch(done, captures):
        calls.append(done)
        if len(calls) == 6:
            raise KeyboardInterrupt

    pattern = "r_arm any x1+ with l_arm any x1+ where match.length > 0s"
    with pytest.raises(KeyboardInterrupt):
        find_fast(parse(pattern), recordings, watch=watch)


def test_the_best_hits_are_told_in_time_and_others_whenever():
    recordings = [random_library(Random(2), captures=1, most=8)[0]]
    query = parse("r_arm any x1+ with l_arm any x1+")
    with patience(1000) as in_time:
        found = find_fast(query, recordings, watch=in_time, best=1)
    assert found[0].fit == max(hit.fit for hit in find_fast(query, recordings))
    searched = []

    def watch(done, captures):
        searched.append(done)

    find_fast(query, recordings, watch=watch)
    many = len(searched)

    def impatient(done, captures):
        searched.append(done)
        if len(searched) > 2 * many:
            raise KeyboardInterrupt

    hits = find_fast(query, recordings, watch=impatient)
    assert list(hits)
    searched = searched[:many]
    with pytest.raises(KeyboardInterrupt):
        find_fast(query, recordings, watch=impatient, best=1)


def test_repeats_that_mirror_each_other_are_not_tried_in_pairs(monkeypatch):
    monkeypatch.setattr(
        limits, "most_rows", lambda size: 10_000
    )  # else it grows with the fourth power
    query = parse("a: (r_arm any x1+) with b: (l_arm any x1+) where a mirrors b")
    recordings = [random_library(Random(9), captures=1, most=400)[0]]
    hits = list(find_fast(query, recordings, overlaps="all"))
    assert len(hits) > 40
    assert all(holds(query.where[0], hit) for hit in hits)
    assert max(len(hit.labels["a"]) for hit in hits) > 1


def test_what_ends_soon_is_found_without_what_ends_late(monkeypatch):
    followed, once = [], walk.Walk.run

    def found(self, *given):
        ends = once(self, *given)
        followed.append(len(ends.root))
        return ends

    monkeypatch.setattr(walk.Walk, "run", found)
    query, ways = parse("r_arm place ... not mid x1..2 -> rising? with head"), {}
    for most in (300, 1200):
        followed.clear()
        find_fast(query, [random_library(Random(1), captures=1, most=most)[0]])
        ways[most] = sum(followed)
    assert ways[300] > 500
    assert ways[1200] < 8 * ways[300]  # else it grows with the square


@pytest.mark.parametrize(
    "pattern",
    [
        # a condition on one step, or on the last one, narrows what the step takes
        "r_arm any ... head any ... a: r_arm any where a.swings > 9",
        "a: r_arm any ... l_arm any ... r_arm any where a.level = high and match.swings > 9",
        # an alternative without a label that is compared is left out
        "(a: r_arm high x3 or head any ... any) ... b: r_arm any where a mirrors b",
        # a line ends within what must hold it, or not at all
        "a: r_arm any ... b: any during head any where a.level < b.level",
        # a bracket opens where what stands beside it may
        "r_arm any ... ((l_arm any ... any) with (r_arm high x40)) ... r_arm any",
        # what stands beside a bracket is looked for where the bracket may open
        "r_arm any -> ((head high x40) with (l_arm any ... any ... any))?",
        # of a line that runs on, the first end is looked up
        "r_arm any ... any -> high x0..2",
    ],
)
def test_what_cannot_match_is_not_tried(monkeypatch, pattern):
    tried, once = [], Context.count_tried

    def counted(self, capture):
        tried.append(len(capture))
        return once(self, capture)

    monkeypatch.setattr(Context, "count_tried", counted)
    find_fast(parse(pattern), [random_library(Random(1), captures=1, most=300)[0]])
    assert sum(tried) < 3500  # else it grows with the square, and is up to two millions


def test_what_is_looked_for_soon_at_first_is_found_as_plainly(monkeypatch):
    monkeypatch.setattr(leading, "SHORT", 0)
    monkeypatch.setattr(leading, "SOON", 1)
    monkeypatch.setattr(leading, "WIDER", 2)
    monkeypatch.setattr(leading, "Time", lambda number, unit: Time(number, "f"))
    widened, once = [], leading.final

    def settled(context, left, horizon, *rest):
        widened.append(horizon is not None)
        return once(context, left, horizon, *rest)

    monkeypatch.setattr(leading, "final", settled)
    tries = 120 if slow() else 60
    for seed in range(tries):
        random = Random(seed)
        text = random_pattern(random, parts=PARTS, directions=DIRECTIONS, avoid={"stages"})
        recordings, query = random_library(random), parse(text)
        for overlaps in ("all", "none"):
            options = {"tolerance": Fraction(1, 5), "overlaps": overlaps}
            found = told(find_fast(query, recordings, **options))
            assert found == told(find(query, recordings, **options)), text
    assert sum(widened) > tries / 4


@pytest.fixture
def place(tmp_path):
    (tmp_path / "bow.lnd").write_text(BOW)
    with open_library(tmp_path / "l.db", create=True) as library:
        library.ingest(tmp_path)
    return tmp_path / "l.db"


def test_hits_can_be_looked_at_once_the_library_is_closed(place):
    with open_library(place) as library:
        hits = library.search("r_arm forward")
        shown = list(library.search("r_arm forward"))
    assert shown
    assert list(hits) == shown
    assert hits.counts() == [(shown[0].capture, len(shown))]


def test_hits_of_what_is_gone_or_others_are_refused(place):
    with open_library(place) as library:
        hits = library.search("r_arm forward")
        (place.parent / "bow.lnd").write_text(BOW.replace("2.5", "2.25"))
        library.ingest(place.parent)
        with pytest.raises(LanindexError, match=r"gone, or others now.*Search again"):
            list(hits)
        library.remove("bow.lnd")
        with pytest.raises(LanindexError, match=r"1 captures with hits are gone.*Search again"):
            list(hits)


def test_a_thousand_steps_in_a_row_come_to_an_end():
    capture, tracks = random_library(Random(0))[0]
    assert len(find_fast(parse("r_arm any x1000"), [(capture, tracks)])) == 0


def test_two_parts_at_once_need_no_more_memory_the_longer_a_capture_is():
    blocks, length = 4_000, 40
    tracks, frames = {}, blocks * length
    for part, begins in (("r_arm", (0, 7, 14)), ("l_arm", (0, 0, 20))):
        symbols = blank(blocks * 3)
        for row, begin in enumerate(begins):
            own = symbols[row::3]
            own["start"] = np.arange(blocks) * length + begin
            own["stop"] = own["start"] + (14 if part == "l_arm" and not row else 7)
            own["direction"] = 0
            own["level"] = np.where(np.arange(blocks) % 2, 2, 0)
        if part == "l_arm":  # the first row is passed through on the way to the second
            symbols["passing"][::3] = True
            symbols["stop"][1::3] += 13
        tracks[part] = Track(part, symbols, (Span(0, frames),))
    capture = Capture(1, "long", "bvh", "", "", Fraction(60), frames)
    query = parse("arms low ... high")
    columns = columns_in([(capture, tracks)], query.parts)
    finder = Finder(query, *columns, lambda places, parts: [], memory=1)
    hits = finder.find()
    assert len(hits) == blocks // 2


@pytest.mark.parametrize(
    "pattern", ["r_arm low", "r_arm any -> any with l_arm any", "r_arm any x2+ without head any"]
)
def test_what_a_search_holds_is_free_when_it_ends(pattern):
    recordings, query = random_library(Random(3)), parse(pattern)
    gc.collect()
    gc.disable()
    try:
        find_fast(query, recordings)
        assert not [it for it in gc.get_objects() if isinstance(it, Context | Batch)]
    finally:
        gc.enable()
