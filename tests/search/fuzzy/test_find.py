"""Fuzzy search over captures and lines."""

import weakref
from dataclasses import replace
from itertools import pairwise

import generated_patterns
import numpy as np
import pytest
from effort import examples
from hypothesis import given
from hypothesis import strategies as st
from plain_matcher import find as find_exactly
from query_cases import recordings_of

from lanindex.alphabet import DIRECTION_CODES, LEVEL_CODES
from lanindex.errors import LanindexError, UsageError
from lanindex.model import Span, Track
from lanindex.model.columns import columns_of, roster_of
from lanindex.pipeline.search import NEAR
from lanindex.search.fuzzy import MORE, Allowance, FuzzyHits, FuzzySearch
from lanindex.search.fuzzy import find as find_in_columns
from lanindex.search.language import parse
from lanindex.search.limits import running
from lanindex.search.match.finder import Finder
from lanindex.search.match.hits import CHECK_EVERY, ROUNDS, staying

TRACKS = (
    "fps 10 frames 100; r_arm: place low 0 0, right mid 5 12, r_forward high 12 20, "
    "place high 30 36, right mid 60 68, place low 70 75; "
    "l_arm: place low 0 0, left mid 5 15, place high 40 50"
)


def find(query, recordings, allowance, **options):
    """Find in captures and tracks."""
    captures, held = zip(*recordings, strict=True)
    columns = {
        part: columns_of(part, captures, [tracks.get(part) for tracks in held])
        for part in query.parts
    }
    taken = lambda places, parts: [recordings[place] for place in places]  # noqa: E731
    finder = Finder(query, roster_of(captures), columns, taken)
    return find_in_columns(finder, allowance, **options)


def recordings():
    return [(one.capture, one.tracks) for one in recordings_of(TRACKS)]


def spans(text: str, allowed: str, **options) -> list[tuple[int, int]]:
    found = find(parse(text), recordings(), Allowance.read(allowed), **options)
    return [(hit.span.start, hit.span.stop) for hit in found]


@pytest.mark.parametrize(
    ("text", "allowed", "expected"),
    [
        ("r_arm right mid -> r_forward high -> place high", "0", [(5, 36)]),
        ("r_arm right mid -> place high", "0", []),
        ("r_arm right mid -> place high", "0.5", [(5, 20)]),  # r_forward high is next to it
        ("r_arm place low -> r_forward high", "0", []),
        ("r_arm place low -> r_forward high", "0.5", [(0, 20)]),  # passes over right mid
        ("r_arm right mid ... place high", "0", [(5, 36)]),
        ("r_arm right mid ... high/low with l_arm place high", "0", [(5, 75)]),  # goes on for it
        ("r_arm right mid -> forward high", "0.5", [(5, 20)]),  # a neighbour
        ("r_arm right mid -> r_forward high -> left mid", "0.5", []),
        ("r_arm right mid -> r_forward high -> left mid", "1", [(5, 20)]),  # a step is missing
        ("r_arm right mid -> r_forward mid -> r_forward high", "0.25", [(5, 20)]),  # on the way
        ("r_arm right mid -> r_forward low -> r_forward high", "0.25", []),
        ("r_arm right mid -> r_forward high with l_arm left mid", "0", [(5, 20)]),
        ("r_arm right mid -> r_forward high with l_arm left high", "0.5", [(5, 20)]),
        ("r_arm right mid -> r_forward high with l_arm place low", "0", []),
        ("r_arm place high without l_arm", "0", [(30, 36)]),
        ("r_arm right mid without l_arm left mid", "0", [(60, 68)]),
        ("r_arm place high before l_arm high", "0", [(30, 36)]),
        ("r_arm right mid -> r_forward high -> place high <0.5s", "0", []),
        ("r_arm place low", "0", [(70, 75)]),  # a starting position alone is no movement
    ],
)
def test_what_is_allowed(text, allowed, expected):
    assert spans(text, allowed) == expected


def test_of_overlapping_matches_the_one_that_differs_least_stays():
    everything = spans("r_arm mid -> high", "1", overlaps="all")
    assert (5, 20) in everything
    assert len(everything) > 1
    kept = spans("r_arm mid -> high", "1")
    assert (5, 20) in kept
    assert all(a[1] <= b[0] for a, b in pairwise(kept))


def test_the_fit_falls_with_what_was_edited():
    exact, edited = (
        find(parse(text), recordings(), Allowance.read("1"))[0].fit
        for text in ("r_arm right mid -> r_forward high", "r_arm right mid -> forward high")
    )
    assert exact == 1
    assert edited == pytest.approx((1 - (31.4 - 22.5) / 45 / 2) / 2, abs=0.01)


@pytest.mark.parametrize("near", [0, NEAR])
def test_the_fit_falls_with_the_distance_of_a_symbol(near):
    (one,) = recordings_of("fps 9 frames 60; r_arm: place low 0 0, right mid 5 9, place high 20 30")
    fits = []
    for asked, ways in (("right", range(20, -1, -1)), ("r_forward", range(21))):
        for margin in ways:
            rows = one.tracks["r_arm"].symbols.copy()
            rows["margin"][1], rows["runner_level"][1] = margin / 20, LEVEL_CODES["mid"]
            rows["runner_direction"][1] = DIRECTION_CODES["r_forward"]
            tracks = {"r_arm": Track("r_arm", rows, one.tracks["r_arm"].known)}
            query = replace(parse(f"r_arm {asked} mid -> place high"), near=near)
            fits.append(find(query, [(one.capture, tracks)], Allowance.read("1"))[0].fit)
    assert fits == sorted(fits, reverse=True)
    assert fits[0] == 1 > fits[19] > 0.5 > fits[-1] > 0


def test_a_hit_that_is_found_exactly_has_the_same_fit_as_an_object():
    (one,) = recordings_of(TRACKS)
    tracks = dict(one.tracks)
    for part, track in one.tracks.items():
        rows = track.symbols.copy()
        rows["margin"] = 0.2
        tracks[part] = Track(part, rows, track.known)
    query = parse("r_arm right mid ... high/low with l_arm place high")
    found = find(query, [(one.capture, tracks)], Allowance.read("0"))
    assert found._exact_hits()[0].tolist() == [0]
    assert [hit.fit for hit in found] == found.fit.tolist() == [0.6]


def test_symbols_are_told_line_by_line():
    (hit,) = find(
        parse("r_arm place low -> r_forward high with l_arm left high"),
        recordings(),
        Allowance.read("1"),
    )
    assert [[str(it) for it in line] for line in hit.lines] == [
        ["r_arm place low [0, 0)", "r_arm r_forward high [12, 20)"],
        ["l_arm left mid [5, 15)"],
    ]


def test_a_score_is_opened():
    score = "direction r_arm right mid 0 1 direction r_arm r_forward high 1 2"
    beside = f"{score} direction l_arm left high 0 1"
    assert spans(beside, "0.5") == [(5, 20)]


def test_a_line_beside_may_begin_before_a_passing_symbol():
    """The latest beginning is cheapest; only the one before it shares a frame with the line."""
    (recording,) = recordings_of(
        "fps 10 frames 24; r_arm: place high 0 1; "
        "l_arm: right low 0 0, right low* 1 2, right mid 0 3"
    )
    query = parse("r_arm place high with l_arm low -> right mid")
    own = [(recording.capture, recording.tracks)]
    assert [hit.span for hit in find_exactly(query, own)] == [Span(0, 3)]
    assert [hit.span for hit in find(query, own, Allowance.read("0"))] == [Span(0, 3)]


@examples(150)
@given(
    generated_patterns.bare_lines(),
    st.sampled_from(("with", "without", "during", "before", "never")),
    generated_patterns.bare_lines("l_arm"),
    st.lists(generated_patterns.recordings(), min_size=1, max_size=3),
)
def test_whatever_is_found_exactly_costs_nothing(line, relation, other, recordings):
    query = parse(f"{line} {relation} {other}")
    nearly = list(find(query, recordings, Allowance.read("0"), overlaps="all"))
    for hit in find_exactly(query, recordings, overlaps="all"):
        assert any(it.capture is hit.capture for it in nearly)


@pytest.mark.parametrize(("text", "edits"), [("2", 128), ("0.5", 32), ("20%", 64), (" 1 ", 64)])
def test_allowances(text, edits):
    assert Allowance.read(text).of(7) == edits


@pytest.mark.parametrize("text", ["", "many", "-1", "%", "1/2", "2s", "1e3", "nan"])
def test_what_is_no_allowance(text):
    with pytest.raises(UsageError, match="edits"):
        Allowance.read(text)


@pytest.mark.parametrize(
    "text", ["a: r_arm high where a.length > 1s", "r_arm low -> mid rhythm 1:1"]
)
def test_conditions_have_no_edits(text):
    with pytest.raises(UsageError, match="cannot count edits"):
        find(parse(text), recordings(), Allowance.read("1"))


@examples(60)
@given(
    generated_patterns.bare_lines(),
    st.sampled_from(("", "with", "without", "during", "before", "or", "exactly with")),
    generated_patterns.bare_lines("l_arm"),
    st.lists(generated_patterns.recordings(), min_size=1, max_size=4),
    st.sampled_from(("0", "0.5", "1", "2")),
    st.integers(1, 6),
    st.sampled_from((0, NEAR)),
)
def test_the_best_are_those_that_sorting_all_would_put_first(
    line, relation, other, recordings, allowed, number, near
):
    query = replace(parse(f"{line} {relation} {other}" if relation else line), near=near)
    allowance = Allowance.read(allowed)
    every = find(query, recordings, allowance).by_fit()
    best = find(query, recordings, allowance, best=number)
    assert list(best) == list(every[:number])
    assert best.fit.tolist() == [hit.fit for hit in best]


def test_the_best_are_found_where_few_captures_are_looked_at(monkeypatch):
    recordings = [(one.capture, one.tracks) for one in recordings_of(TRACKS)] * 300
    asked = []
    query = parse("r_arm right mid -> r_forward high -> place high")
    captures, held = zip(*recordings, strict=True)
    columns = {"r_arm": columns_of("r_arm", captures, [tracks["r_arm"] for tracks in held])}

    def taken(places, parts):
        asked.extend(places)
        return [recordings[place] for place in places]

    looked_at, among = [], FuzzySearch._hits_in

    def counted(search, plans, places):
        looked_at.append(len(places))
        return among(search, plans, places)

    monkeypatch.setattr(FuzzySearch, "_hits_in", counted)
    allowance = Allowance.read("2")
    finder = Finder(query, roster_of(captures), columns, taken)
    best = find_in_columns(finder, allowance, best=2)
    assert [hit.fit for hit in best] == [1, 1]
    assert max(looked_at) <= 2 * MORE
    assert len(asked) == 2


def test_counts_and_spans_make_no_hits(monkeypatch):
    found = find(parse("r_arm high"), recordings(), Allowance.read("1"))
    monkeypatch.setattr(FuzzyHits, "_hits", None)
    assert found.tally() == [(recordings()[0][0].id, len(found))]
    assert found.counts() == [(recordings()[0][0], len(found))]
    assert [span.start for _, span in found.spans()] == found.numpy()["start"].tolist()
    assert len(found.tally()) == 1
    assert len(found.by_fit()[:1]) == 1


def test_nothing_is_kept_of_columns_that_nobody_has():
    (one,) = recordings_of(TRACKS)
    columns = {"r_arm": columns_of("r_arm", [one.capture], [one.tracks["r_arm"]])}
    left = [weakref.ref(columns["r_arm"]), weakref.ref(columns["r_arm"].cell)]
    query, allowance = parse("r_arm low -> high"), Allowance.read("1")
    finder = Finder(query, roster_of([one.capture]), columns, None)
    assert len(find_in_columns(finder, allowance))
    del columns, finder
    assert [it() for it in left] == [None, None]


@pytest.mark.parametrize("text", ["r_arm low ... high", "r_arm low -> high", "r_arm at high"])
def test_a_search_that_may_not_go_on_ends(text):
    def watch(done, captures):
        raise LanindexError(f"{done} of {captures}")

    with pytest.raises(LanindexError, match="0 of 1"):
        find(parse(text), recordings(), Allowance.read("1"), watch=watch)


@pytest.mark.parametrize(
    ("text", "allowed", "expected"),
    [
        ("start -> r_arm right mid", "0", [(5, 12)]),
        ("start -> r_arm r_forward high", "0", []),
        ("start -> r_arm r_forward high", "0.5", [(12, 20)]),  # passes over right mid
        ("start ... r_arm r_forward high", "0", [(12, 20)]),
        ("r_arm place low -> end", "0", [(70, 75)]),
        ("r_arm right mid -> end", "0", []),
        ("r_arm right mid -> end", "0.5", [(60, 68)]),
        ("r_arm right mid ... end", "0", [(5, 12), (60, 68)]),
        ("arms high", "0", []),  # they share no frame
        ("arms mid", "0", [(5, 15)]),
        ("arms mid -> high", "0.5", [(5, 50)]),
    ],
)
def test_the_ends_of_a_clip_and_both_arms(text, allowed, expected):
    assert spans(text, allowed) == expected


@examples(100)
@given(st.lists(st.tuples(st.integers(0, 1), st.integers(0, 60), st.integers(1, 20))))
def test_the_best_stays_and_what_overlaps_it_is_left(drawn):
    capture, low, size = np.array(drawn, np.int64).reshape(-1, 3).T
    high, kept = low + size, []
    for it in range(len(low)):  # the order is the rank
        apart = (capture[kept] != capture[it]) | (high[kept] <= low[it]) | (high[it] <= low[kept])
        if apart.all():
            kept.append(it)
    rank = np.arange(len(low))
    found = staying(capture, low, high, rank)
    assert np.flatnonzero(found).tolist() == kept


def test_what_overlaps_in_a_row_is_settled_without_comparing_all():
    many = 20_000
    low = np.arange(many) * 5  # each is better than the next, and overlaps it
    asked = []
    with running(None, lambda: asked.append(1)):
        kept = staying(low * 0, low, low + 8, np.arange(many))
    assert kept.tolist() == [True, False] * (many // 2)
    assert len(asked) <= ROUNDS + many // CHECK_EVERY + 1
