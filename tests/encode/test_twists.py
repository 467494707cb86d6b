"""Bodies that twist and lean by plan are encoded as planned."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from motions import mirrored, noisy, thinned, turned

from lanindex import animate, encode, read, read_lnd
from lanindex.alphabet import JOINT_CODES
from lanindex.encoding.curves import MOVED, arrivals, moves
from lanindex.encoding.profile import load
from lanindex.encoding.twists import TWISTED
from lanindex.model import Motion, Score

PARTS = ("torso_twist", "head_turn", "torso_incline", "head_incline")
TOLD = """#unit0
twist torso_twist place 0 0 0
twist head_turn place 0 0 0
#unit1
twist torso_twist left 45 1 2
twist head_turn right 60 1 2
incline torso_incline forward 40 3 4
#unit2
twist torso_twist right 50 0 1
twist head_turn place 0 1 2
incline torso_incline place 0 1 2
incline head_incline r_forward 30 2 3
#unit3
twist torso_twist place 0 1 2
incline torso_incline l_forward 30 2 3
#unit_total 4
"""
SAID = {
    "torso_twist": ["place", "left 45deg", "right 50deg", "place"],
    "head_turn": ["place", "right 60deg", "place"],
    "torso_incline": ["place", "forward 40deg", "place", "l_forward 30deg"],
    "head_incline": ["place", "r_forward 30deg"],
}


def said(score: Score) -> dict[str, list[str]]:
    return {
        part: [it.words for it in score.symbols(part)] for part in PARTS if part in score.tracks
    }


@pytest.fixture(scope="module")
def body() -> Motion:
    return animate(read_lnd(TOLD), rate=120)


def ramp(*degrees: float, seconds: float = 0.5) -> np.ndarray:
    """Return angles that go from one to the next, and rest there for a second."""
    found = [np.full(60, degrees[0])]
    for one, other in pairwise(degrees):
        found += [np.linspace(one, other, round(60 * seconds)), np.full(60, other)]
    return np.concatenate(found) + 0j


def shown(angles: np.ndarray, eighths: bool = False) -> list[tuple[int, int]]:
    found = arrivals(angles, TWISTED, load("default"), eighths)
    return [tuple(row) for row in found[:, [2, 6]]]


def test_what_is_told_is_written_down(body):
    assert said(encode(body)) == SAID


def test_the_times_are_those_of_the_score(body):
    wanted = [(0, 0), (1, 2), (4, 5), (9, 10)]
    found = [(it.start / 120, it.stop / 120) for it in encode(body).symbols("torso_twist")]
    assert np.abs(np.subtract(found, wanted)).max() < 0.1


@pytest.mark.parametrize(
    "change", [lambda it: turned(it, 37), lambda it: thinned(it, 4), lambda it: noisy(it, 2.0)]
)
def test_place_rate_and_noise_change_little(body, change):
    found = said(encode(change(body)))
    for part, words in SAID.items():
        ours, others = ([it.split() for it in those] for those in (words, found[part]))
        assert [it[0] for it in ours] == [it[0] for it in others]
        degrees = (
            [int(amount.removesuffix("deg")) for it in those for amount in it[1:]]
            for those in (ours, others)
        )
        assert np.abs(np.subtract(*degrees)).max() <= 2


def test_a_mirror_shows_the_other_side(body):
    exchanged = {"left": "right", "right": "left", "l_forward": "r_forward"}
    exchanged["r_forward"] = "l_forward"
    wanted = {
        part: [" ".join(exchanged.get(word, word) for word in it.split()) for it in words]
        for part, words in SAID.items()
    }
    assert said(encode(mirrored(body))) == wanted


def test_a_part_stays_where_it_has_arrived():
    assert shown(ramp(0, 45, 80, 0, -40)) == [(8, 0), (0, 45), (0, 80), (8, 0), (4, 40)]


def test_a_stretch_begins_where_the_part_is():
    assert shown(ramp(50, 0)) == [(0, 50), (8, 0)]
    assert shown(ramp(-50)) == [(4, 50)]


def test_the_sway_of_a_walk_is_no_twist():
    sway = 29 * np.sin(np.arange(600) / 60 * 2 * np.pi) + 0j
    assert shown(sway) == [(8, 0)]
    assert len(shown(1.2 * sway)) > 10


def test_what_goes_less_than_a_swing_has_not_moved():
    assert moves(ramp(40, 40 + MOVED - 1, 40), load("default")) == []
    assert shown(ramp(40, 40 + MOVED + 1)) == [(0, 40), (0, 56)]


def test_small_steps_that_lead_far_are_one_swing():
    assert shown(ramp(0, 10, 20, 30, 40)) == [(8, 0), (0, 40)]


def test_slow_ways_are_seen_from_end_to_end():
    ((start, stop),) = moves(ramp(0, 60, seconds=10), load("default"))
    assert abs(start - 60) <= 6
    assert abs(stop - 660) <= 6


def test_a_lean_goes_round_in_eighths():
    lean = 40 * np.exp(1j * np.angle(np.exp(0.25j * np.pi * np.repeat(np.arange(9), 90))))
    assert [code for code, _ in shown(lean, True)] == [0, 1, 2, 3, 4, 5, 6, 7, 0]


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_a_frame_or_two(body, frames):
    cut = replace(
        body,
        positions=body.positions[:frames],
        axes={joint: axes[:frames] for joint, axes in body.axes.items()},
    )
    assert said(encode(cut)) == {part: ["place"] for part in PARTS}


def test_without_axes_the_head_has_no_track_and_no_word_is_said(body):
    score = encode(replace(body, axes={}))
    assert said(score) == {part: SAID[part] for part in ("torso_twist", "torso_incline")}
    assert score.warnings == encode(body).warnings


def test_a_gap_parts_the_tracks(body):
    places, axes = body.positions.copy(), body.axes["Head"].copy()
    places[300:400, JOINT_CODES["RShoulder"]] = np.nan
    places[300:400, body.skeleton.body[JOINT_CODES["RShoulder"]]] = np.nan
    axes[900:960] = np.nan
    score = encode(replace(body, positions=places, axes={"Head": axes}))
    known = {part: [(it.start, it.stop) for it in score.tracks[part].known] for part in PARTS}
    end = len(body)
    assert known["torso_twist"] == known["torso_incline"] == [(0, 300), (400, end)]
    assert known["head_turn"] == [(0, 300), (400, 900), (960, end)]
    assert known["head_incline"] == [(0, 900), (960, end)]
    assert [it.words for it in score.symbols("torso_twist")][:3] == [
        *("place", "left 45deg", "left 45deg")
    ]


def test_frames_before_the_movement_are_those_of_its_first(body):
    axes = {"Head": body.axes["Head"].copy()}
    axes["Head"][:30] = [[0, 0, 1], [0, 1, 0]]
    assert said(encode(replace(body, axes=axes, first=30)))["head_turn"] == SAID["head_turn"]


LABELLED = {
    "bvh/bandai1/dataset-1_bow_normal_001.bvh": ("torso_incline", ["forward", "place"]),
    "bvh/bandai1/dataset-1_walk_normal_001.bvh": ("torso_twist", []),
    "bvh/bandai1/dataset-1_kick_normal_001.bvh": ("torso_twist", ["left", "place"] * 3),
    "bvh/cmu_daz/10_01.bvh": ("torso_twist", ["right", "place"]),
    "bvh/cmu_daz/10_03.bvh": ("torso_twist", ["right", "place"]),
    "amc/cmu/11_01.amc": ("torso_twist", ["right", "place"]),
    "bvh/sfu_moda/AV_8Walk_Meredith_HVHA_Rep1.bvh": ("torso_twist", []),
}


@pytest.mark.parametrize("name", LABELLED)
def test_real_captures(captures: Path, name: str):
    part, wanted = LABELLED[name]
    assert [it.direction for it in encode(read(captures / name)).symbols(part)[1:]] == wanted


def test_two_formats_of_one_take_turn_the_head_alike(captures: Path):
    bvh, amc = (
        encode(read(captures / name, body_only=True)).symbols("head_turn")
        for name in ("bvh/cmu_cgspeed/01_01.bvh", "amc/cmu/01_01.amc")
    )
    assert (
        [it.direction for it in bvh]
        == [it.direction for it in amc]
        == [*("place", "right", "place")]
    )
    assert abs(bvh[1].amount - amc[1].amount) <= 2
