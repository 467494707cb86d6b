"""In which captures the steps of a line occur in its order."""

from fractions import Fraction
from random import Random

import numpy as np
import pytest
from fast_search import find_fast
from grammar_patterns import random_pattern
from query_cases import recordings_of
from random_library import DIRECTIONS, PARTS, random_library

from lanindex.model.columns import columns_of, roster_of
from lanindex.search.automaton import plan
from lanindex.search.language import parse
from lanindex.search.match import prefilter
from lanindex.search.match.batch import Batch

TRACKS = (
    "capture one fps 10 frames 60; r_arm: place low 0 0, right mid 5 12, left low* 20 25, "
    "place high 20 30, right low 40 50; "
    "capture two fps 10 frames 60; r_arm: place high 0 0, right mid 20 30, place low 40 50; "
    "capture three fps 10 frames 60; l_arm: left high 0 0, place low 4 9"
)


@pytest.fixture(autouse=True)
def few_captures(monkeypatch):
    """Look on, however few captures are left."""
    monkeypatch.setattr(prefilter, "FEW", 0)


def found(text: str, recordings, part: str = "r_arm") -> list[bool]:
    captures = [it.capture for it in recordings]
    columns = columns_of(part, captures, [it.tracks.get(part) for it in recordings])
    (program,) = plan(parse(text))
    asked = prefilter.order_of(program, part)
    assert asked is not None
    batch = Batch(roster_of(captures), {}, np.arange(len(captures)), Fraction(1, 10))
    return prefilter.in_order(asked, columns, np.arange(len(captures)), batch).tolist()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("r_arm mid -> high", [True, False, False]),
        ("r_arm high -> mid", [False, True, False]),
        ("r_arm mid -> low", [False, True, False]),
        ("r_arm mid -> left low -> high", [True, False, False]),
        ("r_arm mid ... low", [True, True, False]),
        ("r_arm low -> hold -> mid", [True, False, False]),
        ("r_arm at not mid -> at mid -> at low", [False, True, False]),
        ("r_arm high -> l_arm any -> r_arm low", [True, True, False]),
        ("r_arm mid <1s", [True, False, False]),
        ("r_arm mid 0.8s..2s", [False, True, False]),
        ("start -> r_arm mid", [True, True, False]),
        ("start -> r_arm high -> mid", [False, True, False]),
        ("start -> r_arm mid -> left low -> high", [True, False, False]),
        ("start -> r_arm high -> low", [False, False, False]),
        ("r_arm high -> end", [False, False, False]),
        ("r_arm mid -> low -> end", [False, True, False]),
    ],
)
def test_what_is_in_another_order_is_not_found(text, expected):
    assert found(text, list(recordings_of(TRACKS))) == expected


def test_of_what_a_way_goes_without_nothing_is_asked():
    (program,) = plan(parse("l_arm low -> (l_arm high or r_arm high)"))
    assert prefilter.order_of(program, "r_arm") is None


def test_a_line_of_too_many_steps_asks_for_nothing():
    (program,) = plan(parse("r_arm low -> high x64"))
    assert prefilter.order_of(program, "r_arm") is None


def test_it_leaves_out_no_hit():
    left_out = 0
    for case in range(150):
        random = Random(f"order {case}")
        query = parse(random_pattern(random, parts=PARTS, directions=DIRECTIONS, avoid={"stages"}))
        recordings = random_library(random)
        captures = [capture for capture, _ in recordings]
        hits = {hit.capture.id for hit in find_fast(query, recordings)}
        may = {
            captures[it].id
            for program in plan(query)
            for it in possible(program, recordings, captures)
        }
        assert hits <= may, query.text
        left_out += len(captures) - len(may)
    assert left_out > 0


def possible(program, recordings, captures) -> list[int]:
    fits = np.ones(len(captures), bool)
    batch = Batch(roster_of(captures), {}, np.arange(len(captures)), Fraction(1, 10))
    for part in {part for state in program.states for part in state.members}:
        columns = columns_of(part, captures, [tracks.get(part) for _, tracks in recordings])
        asked = prefilter.order_of(program, part)
        if asked:
            fits &= prefilter.in_order(asked, columns, np.arange(len(captures)), batch)
    return np.flatnonzero(fits).tolist()
