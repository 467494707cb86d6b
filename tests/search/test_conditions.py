"""Conditions of ``where``: comparisons, and missing values, which are false."""

from dataclasses import replace
from fractions import Fraction

import pytest
from query_cases import recordings_of

from lanindex.model import Capture, Meter
from lanindex.search.hits import names_in
from lanindex.search.language import parse
from lanindex.search.match import find_in

CAPTURE = Capture(
    *(1, "walk.bvh", "bvh", "0" * 64, "walk", Fraction(30000, 1001), 300, Meter(Fraction(120))),
    {"Subject": "7", "style": "old", "empty": ""},
)
TRACKS = (
    "fps 30 frames 300; r_arm: right high 30 60, place low 90 99; head: place mid 90 120; "
    "l_arm: left high 32 60"
)
PATTERN = "b: (a: r_arm high -> low) -> e: mid? with c: head any with d: l_arm high where "


@pytest.fixture(scope="module")
def recording():
    (found,) = recordings_of(TRACKS)
    tracks = {}
    for part, track in found.tracks.items():
        symbols = track.symbols.copy()
        symbols["margin"], symbols["swings"] = 0.75, 3
        if part == "head":
            symbols["direction"] = -1
        tracks[part] = replace(track, symbols=symbols)
    return CAPTURE, tracks


@pytest.fixture
def true(recording):
    """Return what tells whether a condition is true of the one hit that there is."""
    return lambda text: len(find_in([recording], parse(PATTERN + text))) == 1


@pytest.mark.parametrize(
    "text",
    [
        "a.length = 30f and a.length = 1001ms and a.length != 1s",
        "a.length = 2.002b and a.start + a.length = a.end",
        "b.end - b.start = 69f and b.length > 2s",
        "b.level = low and b.direction = place and b.part = r_arm",
        "a.level > mid and a.level >= high and b.level < a.level",
        "a.margin = 0.75 and a.swings = 3 and a.swings - a.margin > 2",
        "match.start = 30f and match.length = 90f and match.level = low",
        'clip.label = "walk" and clip.label != "run" and clip.path > "run"',
        'clip.subject > 6 and clip.subject = "7" and clip.style = "old"',
        "clip.style != 6 and clip.fps < 30 and clip.frames >= 300",
        "a mirrors d and d mirrors a",
    ],
)
def test_what_holds(text, true):
    assert true(text)


@pytest.mark.parametrize(
    "text",
    [
        "a.length < 30f",
        "a.level < high",
        "b.direction = right",
        "clip.style > 6",
        'clip.label = "Walk"',
        "a mirrors b",
        "a mirrors c",
    ],
)
def test_what_does_not_hold(text, true):
    assert not true(text)


@pytest.mark.parametrize("compare", ["=", "!=", "<", "<=", ">", ">="])
def test_what_is_missing_makes_it_false(compare, true):
    assert not true(f"e.start {compare} 1s")
    assert not true(f"clip.nothing {compare} 1")
    assert not true(f'clip.empty {compare} "x"')
    assert not true(f"a.start - e.start {compare} 1s")
    assert not true("c.direction != left")
    assert not true("e mirrors a")


def test_the_names_that_conditions_speak_of():
    where = parse(PATTERN + 'a mirrors d and b.start > match.start and clip.label = "x"').where
    assert names_in(where) == {"a", "b", "d", "match", "clip"}
