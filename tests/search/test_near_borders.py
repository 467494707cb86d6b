"""`--near`: symbols near the border of their cell."""

from dataclasses import replace

import pytest
from plain_matcher import find as find_plainly
from query_cases import recordings_of

from lanindex.alphabet import DIRECTION_CODES, LEVEL_CODES
from lanindex.model import Track
from lanindex.pipeline.search import NEAR
from lanindex.search.language import parse
from lanindex.search.match import find_in

TRACKS = (
    "fps 10 frames 60; r_arm: place low 0 0, right mid 5 12, place high 20 30; head: left mid 0 0"
)


def spans(text: str, margin: float, near: int = NEAR) -> list[tuple[int, int, float]]:
    """Return the hits where the second symbol is as near as that to r_forward mid."""
    (recording,) = recordings_of(TRACKS)
    rows = recording.tracks["r_arm"].symbols.copy()
    rows["margin"][1] = margin
    rows["runner_direction"][1] = DIRECTION_CODES["r_forward"]
    rows["runner_level"][1] = LEVEL_CODES["mid"]
    tracks = {**recording.tracks, "r_arm": Track("r_arm", rows, recording.tracks["r_arm"].known)}
    query = replace(parse(text), near=near)
    recordings = [(recording.capture, tracks)]
    hits = list(find_in(recordings, query))
    assert hits == list(find_plainly(query, recordings))
    return [(hit.start, hit.stop, hit.fit) for hit in hits]


def test_it_matches_from_both_sides_of_the_border():
    assert spans("r_arm r_forward mid", 0.1, near=0) == []
    assert spans("r_arm r_forward mid", 0.1) == [(5, 12, 0.12)]  # 0.15 of 1.25
    assert spans("r_arm right mid", 0.1) == [(5, 12, 0.28)]  # 0.35 of 1.25
    assert spans("r_arm not right", 0.1) == [(5, 12, 0.12), (20, 30, 1.0)]


def test_it_does_not_from_further_off():
    assert spans("r_arm r_forward mid", 0.25) == []
    assert spans("r_arm r_forward mid -> high", 0.24) == [(5, 30, 0.008)]


def test_stays_and_rests_are_as_generous():
    assert spans("r_arm at r_forward mid", 0.1) == [(11, 20, 0.12)]
    assert spans("r_arm hold r_forward", 0.1) == [(12, 20, 0.12)]


def test_what_must_not_happen_is_taken_as_it_is_written():
    assert spans("r_arm high never r_arm r_forward", 0.1) == [(20, 30, 1.0)]
    assert spans("r_arm high never r_arm right", 0.1) == []


def fits(cell: str, margins: range, near: int = NEAR) -> list[float]:
    return [spans(f"r_arm {cell} mid", margin / 1000, near)[0][2] for margin in margins]


@pytest.mark.parametrize("margin", [0, 1, 499, 500, 999, 1000])
def test_without_it_the_fit_is_the_margin(margin):
    assert fits("right", range(margin, margin + 1), near=0) == [margin / 1000]


def test_the_further_off_the_smaller_the_fit():
    own, across = fits("right", range(0, 1001, 10)), fits("r_forward", range(NEAR))
    assert own == sorted(own)
    assert across == sorted(across, reverse=True)
    assert own[-1] == 1
    assert own[0] == across[0]
    assert across[-1] >= 0
