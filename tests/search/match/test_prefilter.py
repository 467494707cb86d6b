"""The prefilter: which captures remain candidates."""

from fractions import Fraction

import numpy as np
import pytest
from query_cases import recordings_of

from lanindex.model.columns import columns_of, roster_of
from lanindex.search.language import parse
from lanindex.search.match import finder
from lanindex.search.match.batch import Batch, possible, unavoidable
from lanindex.search.match.conditions import Clauses
from lanindex.search.match.context import Context
from lanindex.search.match.rewrites import Rewrites
from lanindex.search.plan import plan

TRACKS = (
    "capture one fps 10 frames 60; r_arm: place low 0 0, right mid 5 12; "
    "capture two fps 10 frames 60; r_arm: place low 0 0, right mid 5 12, place high 20 30; "
    "l_arm: place low 0 0, left high 4 9; "
    "capture three fps 10 frames 60; l_arm: left high 0 0, place low 4 9"
)


def columns_and_roster():
    recordings = list(recordings_of(TRACKS))
    captures = [it.capture for it in recordings]
    columns = {
        part: columns_of(part, captures, [it.tracks.get(part) for it in recordings])
        for part in ("r_arm", "l_arm")
    }
    return columns, roster_of(captures)


def may_match(text: str) -> list[bool]:
    columns, roster = columns_and_roster()
    return possible(plan(parse(text)), columns, len(roster)).tolist()


def can_begin(text: str) -> list[bool]:
    columns, roster = columns_and_roster()
    batch = Batch(roster, columns, np.arange(len(roster)), Fraction(0))
    (program,) = plan(parse(text))
    return Context(batch, Rewrites(program), Clauses(parse(text)), lambda _: []).possible().tolist()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("r_arm mid", [True, True, False]),
        ("r_arm mid -> high", [False, True, False]),
        ("r_arm mid -> high?", [True, True, False]),
        ("r_arm mid -> (high or low)", [True, True, False]),
        ("arm high", [False, True, True]),
        ("arms high", [False, True, False]),
        ("r_arm low with l_arm low", [False, True, False]),
        ("l_arm low with head", [False, False, False]),
        ("l_arm low without head", [False, True, True]),
        ("r_arm low never r_arm high", [True, True, False]),
        ("r_arm high or l_arm low", [False, True, True]),
    ],
)
def test_captures_that_lack_what_no_way_goes_without_are_left_out(text, expected):
    assert may_match(text) == expected


def test_what_may_be_left_out_is_avoidable():
    (program,) = plan(parse("r_arm low -> mid? -> (high or low) -> forward x2..3"))
    assert [state.number for state in unavoidable(program)] == [0, 4, 5]
    assert np.all([state.members == ("r_arm",) for state in program.states])


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("r_arm mid -> high", [False, True, False]),
        ("r_arm high -> mid", [False, False, False]),
        ("l_arm low -> high", [False, True, False]),
        ("r_arm mid with l_arm low -> high", [False, True, False]),
        ("r_arm mid with l_arm high -> low", [False, False, False]),
        ("r_arm mid without l_arm high -> low", [True, True, False]),
    ],
)
def test_events_tell_in_which_captures_all_needed_lines_can_begin(text, expected):
    assert can_begin(text) == expected


def test_captures_where_nothing_can_begin_are_not_searched(monkeypatch):
    searched = []

    def hits_of(context):
        searched.append(context.batch.places.tolist())
        return found(context)

    found = finder.hits_of
    monkeypatch.setattr(finder, "hits_of", hits_of)
    columns, roster = columns_and_roster()
    query = parse("r_arm mid -> high or l_arm high -> low")
    hits = finder.Finder(query, roster, columns, lambda places, parts: []).find()
    assert searched == [[1], [2]]
    assert hits.place.tolist() == [1, 2]
