"""`--why`: the steps that matched in one capture, or where matching stopped."""

import json
from dataclasses import replace
from fractions import Fraction

import pytest
from effort import thinned
from generated_patterns import random_patterns
from plain_matcher import find
from query_cases import cases, recordings_of, track

from lanindex.errors import LanindexError
from lanindex.model import Symbol
from lanindex.search.explain.why import away, doubts, nearest, records_of, trace
from lanindex.search.language import parse

(RECORDING,) = recordings_of(
    "fps 10 frames 100; "
    "r_arm: place low 0 0, right mid 5 12, place high 30 36, forward mid 50 60, left mid 60 70; "
    "l_arm: place low 0 0, left high 50 60; head: place high 0 0, forward high 33 40"
)

FOUND = [it for it in cases() if not it.error]

STOPS = {
    "r_arm back": (
        "",
        "r_arm back",
        "no movement of r_arm is back; the nearest is r_arm place high [30, 36) (margin 1.00)",
    ),
    "r_arm mid -> low": (
        "r_arm mid",
        "-> low",
        "after r_arm forward mid [50, 60) the next movement is left mid [60, 70), not low "
        "(margin 1.00)",
    ),
    "r_arm low -> high": (
        "r_arm low",
        "-> high",
        "after r_arm place low [0, 0) the next movement is right mid [5, 12), not high "
        "(margin 1.00)",
    ),
    "r_arm low rising -> mid": (  # a starting position is low, but it cannot rise
        "",
        "r_arm low rising",
        "no movement of r_arm is low rising; the nearest is r_arm right mid [5, 12) (margin 1.00)",
    ),
    "r_arm high ... back": (
        "r_arm high",
        "... back",
        "after r_arm place high [30, 36) the nearest movement is left mid [60, 70), not back "
        "(margin 1.00)",
    ),
    "r_arm left -> mid": (
        "r_arm left",
        "-> mid",
        "after r_arm left mid [60, 70) r_arm does not move again",
    ),
    "r_arm right ->[<1s] high": (
        "r_arm right",
        "->[<1s] high",
        "after r_arm right mid [5, 12) place high [30, 36) comes after 1.80 s, wanted [<1s]",
    ),
    "r_arm right -> high 2s+": (
        "r_arm right",
        "-> high 2s+",
        "after r_arm right mid [5, 12) place high [30, 36) takes 0.60 s, wanted 2s+",
    ),
    "r_arm high 1s+": ("", "r_arm high 1s+", "r_arm place high [30, 36) takes 0.60 s, wanted 1s+"),
    "r_arm right -> hold 3s+": (
        "r_arm right",
        "-> hold 3s+",
        'after r_arm right mid [5, 12) r_arm rests for 1.80 s, wanted "hold 3s+"',
    ),
    "r_arm forward -> hold": (
        "r_arm forward",
        "-> hold",
        'after r_arm forward mid [50, 60) r_arm goes on at once, wanted "hold"',
    ),
    "r_arm mid x3": ("", "r_arm mid x3", '"r_arm mid" is there 2 in a row at most'),
    "(r_arm right -> high) <1s": (
        "",
        "(r_arm right -> high) <1s",
        '"(r_arm right -> high)" takes 3.10 s, wanted <1s',
    ),
    "(r_arm right -> (high -> low)) <1s": (
        "r_arm right -> high",
        "-> low",
        "after r_arm place high [30, 36) the next movement is forward mid [50, 60), not low "
        "(margin 1.00)",
    ),
    "(r_arm right -> low) x2": (
        "r_arm right",
        "-> low",
        "after r_arm right mid [5, 12) the next movement is place high [30, 36), not low "
        "(margin 1.00)",
    ),
    "start -> r_arm high": (
        "",
        "r_arm high",
        "the first movement is r_arm right mid [5, 12), not high",
    ),
    "r_arm high -> end": (
        "r_arm high",
        "-> end",
        "after r_arm place high [30, 36) the clip does not end: "
        "the next movement is forward mid [50, 60)",
    ),
    "r_arm high -> l_arm low": (
        "r_arm high",
        "-> l_arm low",
        "after r_arm place high [30, 36) the next movement is l_arm left high [50, 60), not low "
        "(margin 1.00)",
    ),
    "r_hand high": ("", "r_hand high", "this capture does not tell where the r_hand is"),
    "head sinking": ("", "head sinking", 'there is no "head sinking"'),
    "r_arm high with head low": (
        "r_arm high",
        "with head low",
        "r_arm place high [30, 36), but meanwhile head forward high [33, 40), not low "
        "(margin 1.00)",
    ),
    "r_arm high with l_arm high": (
        "r_arm high",
        "with l_arm high",
        'r_arm place high [30, 36), but "l_arm high" is at [50, 60), 1.40 s away',
    ),
    "r_arm high without head": (
        "r_arm high",
        "without head",
        'r_arm place high [30, 36), but "head" is at [33, 40)',
    ),
    "r_arm right with r_hand": (
        "r_arm right",
        "with r_hand",
        "r_arm right mid [5, 12), but r_hand does not move",
    ),
    "r_arm high with head forward 3s+": (
        "r_arm high",
        "with head forward 3s+",
        "r_arm place high [30, 36), but head forward high [33, 40) takes 0.70 s, wanted 3s+",
    ),
    "arms low -> high": (
        "arms low",
        "-> high",
        "after r_arm place low [0, 0), l_arm place low [0, 0) the next movement is "
        "r_arm right mid [5, 12), not high (margin 1.00)",
    ),
}


def traced(text, recording=RECORDING, **options):
    return trace(parse(text), recording.capture, recording.tracks, **options)


@pytest.mark.parametrize("text", STOPS)
def test_where_the_walk_ends(text):
    (stop,) = traced(text).stops
    assert (stop.reached, stop.wanted, stop.reason) == STOPS[text]


def test_alternatives_end_each_for_itself():
    ends = traced("r_arm back or l_arm low").stops
    assert [stop.wanted for stop in ends] == ["r_arm back", "l_arm low"]
    ends = traced("r_arm back high either side").stops
    assert [stop.wanted for stop in ends] == ["r_arm back high", "l_arm back high"]


def test_what_is_found_is_told_symbol_by_symbol():
    seen = traced("r_arm mid -> high with head")
    ((hit, steps),) = seen.hits
    assert (seen.stops, hit.span.start, hit.span.stop) == ((), 5, 40)
    said = [str(symbol) for step in steps for symbol in step.symbols]
    assert said == [
        *("r_arm right mid [5, 12)", "r_arm place high [30, 36)", "head forward high [33, 40)")
    ]


def test_records_are_json_of_one_kind():
    keys = "capture capture_id pattern found start_frame end_frame fit steps wanted instead reason"
    for text in ("r_arm mid -> high", "r_arm mid -> low", "r_arm back or head low"):
        for record in map(json.dumps, records_of(traced(text))):
            assert list(json.loads(record)) == keys.split()
    (record,) = records_of(traced("r_arm mid -> low"))
    assert (record["found"], record["wanted"]) == (False, "-> low")
    assert record["instead"]["start_frame"] == 60
    assert record["instead"]["margin"] == 1


@pytest.mark.parametrize("case", thinned(FOUND, 4), ids=str)
def test_whatever_is_not_found_has_a_reason(case):
    query = parse(case.pattern)
    for recording in case.recordings:
        here = [(recording.capture, recording.tracks)]
        found = list(find(query, here, tolerance=case.tolerance))
        seen = trace(query, recording.capture, recording.tracks, tolerance=case.tolerance)
        assert [hit for hit, _ in seen.hits] == found
        assert bool(seen.stops) != bool(found)
        assert all(stop.reason and stop.wanted for stop in seen.stops)


@pytest.mark.parametrize("text", thinned(random_patterns(11, 100), 4))
def test_any_pattern_is_followed(text):
    seen = traced(text)
    assert seen.hits or all(stop.reason for stop in seen.stops)


def symbol(direction, level, margin=1.0, runner=(None, None)):
    return Symbol("l_arm", 1, direction, level, 0, 5, 0, 5, False, 0, 0, margin, *runner, None)


def step(text):
    return parse(text).pattern.alternatives[0].first.items[0].unit


def test_nearness_counts_cells_and_knows_the_runner_up():
    asked = step("l_arm side high")
    assert away(symbol("left", "high"), asked) == 0
    assert away(symbol("left", "mid"), asked) == 1
    assert away(symbol("l_forward", "low"), asked) == 3
    assert away(symbol("right", "high"), asked) == 4
    assert away(symbol("place", "high"), asked) == 1
    near = symbol("left", "mid", 0.2, ("left", "high"))
    assert 0 < away(near, asked) < 0.5
    assert nearest([symbol("place", "high"), near, symbol("left", "low")], asked) == near
    assert nearest([], asked) is None
    assert doubts(near) == "margin 0.20, else left high"
    assert away(symbol(None, None), asked) > 9
    assert away(symbol("back", "low"), step("l_arm rising")) == 0
    assert away(symbol("left", "low"), step("l_arm not low")) == 1


def test_how_near_a_touch_comes_to_what_is_asked():
    (knee,) = track("r_hand_touch", "knee 5 9", 10).listed()
    assert away(knee, step("r_hand_touch knee")) == 0
    assert away(knee, step("r_hand_touch not trunk")) == 0
    assert away(knee, step("r_hand_touch trunk/arm")) == 1


def test_the_tolerance_is_that_of_the_search():
    text = "r_arm high starting with head"
    assert traced(text).stops
    assert traced(text, tolerance=Fraction(1)).hits


def test_a_capture_that_is_too_rich_has_its_reason() -> None:
    error = LanindexError("Too many partial matches")
    (record,) = replace(traced("r_arm mid -> low"), hits=(), stops=(), refused=error).dicts()
    assert (record["found"], record["reason"]) == (False, "Too many partial matches")
