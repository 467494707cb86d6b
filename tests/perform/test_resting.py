"""Who kneels, sits, lies and goes on all fours as a score tells."""

import numpy as np
import pytest
from random_steps import RATE, Tally, compared
from random_steps import drawn as steps_drawn
from random_supports import OTHER, TRACKS, drawn

from lanindex import encode, read_lnd
from lanindex.alphabet import CARRIERS, JOINT_CODES
from lanindex.model import Motion
from lanindex.perform import perform


def act(*lines: str, units: int = 3) -> Motion:
    """Perform a score of one beat a second."""
    return perform(read_lnd("\n".join((f"#unit_total {units}", "#unit1", *lines))), rate=RATE)


def told(motion: Motion) -> list[tuple[str, int, int]]:
    return [(it.words, it.start, it.stop) for it in encode(motion).symbols(OTHER)]


def joint(motion: Motion, name: str, frame: int) -> np.ndarray:
    return motion.positions[frame, motion.skeleton.body[JOINT_CODES[name]]]


@pytest.mark.parametrize(("noise", "least"), [(0.0, 0.99), (2.0, 0.97)])
def test_what_is_carried_out_comes_back(noise, least):
    tally: dict[str, Tally] = {}
    for seed in range(10):
        score = drawn(seed)
        compared(score, encode(perform(score, rate=RATE, noise=noise, seed=seed)), tally, TRACKS)
    assert tally[OTHER].wanted == 80
    for part, counts in tally.items():
        assert counts.exact >= least * counts.wanted, part
        assert counts.added == 0, part
        if counts.wanted:
            assert np.percentile(counts.starts, 95) <= 3, part
            assert np.percentile(counts.stops, 95) <= 3, part


def bent(motion: Motion, names: tuple[str, str, str]) -> np.ndarray:
    """Return by how many degrees a joint is bent, frame by frame."""
    one, two, three = (
        motion.positions[:, motion.skeleton.body[JOINT_CODES[name]]].astype(float) for name in names
    )
    upper, lower = two - one, three - two
    cosine = np.sum(upper * lower, axis=1)
    cosine /= np.linalg.norm(upper, axis=1) * np.linalg.norm(lower, axis=1)
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


@pytest.mark.parametrize("score", [drawn, steps_drawn], ids=["rests", "steps"])
def test_bodies_take_no_pose_that_nobody_takes(score):
    for seed in range(6):
        motion = perform(score(seed), rate=30)
        assert motion.positions[..., 1].min() >= -10
        for side in "RL":
            knee = bent(motion, (f"{side}Hip", f"{side}Knee", f"{side}Ankle"))
            assert knee.max() <= 160
            hip, middle, ankle = (
                motion.positions[:, motion.skeleton.body[JOINT_CODES[side + it]]].astype(float)
                for it in ("Hip", "Knee", "Ankle")
            )
            across = np.subtract(
                *(motion.positions[:, motion.skeleton.body[JOINT_CODES[it]]] for it in
                  ("LHip", "RHip"))
            )  # fmt: skip
            forward = np.cross(ankle - hip, across)  # where a knee goes that bends as knees do
            assert np.sum((middle - hip) * forward, axis=1).min() >= -1e3


@pytest.mark.parametrize("what", CARRIERS)
def test_a_body_rests_from_the_beginning_to_the_end(what):
    motion = act(f"carrier other_support {what} 0 12")
    assert told(motion) == [(what, 0, 12 * RATE)]
    assert motion.warnings == ()


def test_who_lies_face_down_does():
    motion = act("direction torso forward mid 0.5 1.5", "carrier other_support trunk 2 5")
    ((what, start, stop),) = told(motion)
    assert (what, motion.warnings) == ("trunk", ())
    assert [start, stop] == pytest.approx([2 * RATE, 5 * RATE], abs=4)
    assert joint(motion, "Head", 200)[2] > joint(motion, "RHip", 200)[2] + 500


def test_legs_that_are_told_kneel_and_sit_as_they_are():
    one = act(
        "direction l_thigh forward mid 1.5 2.5",
        "direction l_shank place low 1.5 2.5",
        "carrier other_support knee 2 6",
    )
    assert [it[0] for it in told(one)] == ["knee"]
    assert joint(one, "RKnee", 250)[1] < 0.16 * 820
    thigh = joint(one, "LKnee", 250) - joint(one, "LHip", 250)
    assert thigh[2] > 0.9 * np.linalg.norm(thigh)  # forward
    sits = act(
        "direction r_leg forward mid 1.5 2.5",
        "direction l_leg forward mid 1.5 2.5",
        "carrier other_support seat 2 5",
    )
    assert [it[0] for it in told(sits)] == ["seat"]
    assert bent(sits, ("RHip", "RKnee", "RAnkle"))[240] < 30
    assert one.warnings == sits.warnings == ()


@pytest.mark.parametrize(
    ("lines", "warning"),
    [
        (
            ["carrier other_support seat 1 4", "support r_support place mid 2 3"],
            "a step at 2 s is left out: seat carries meanwhile",
        ),
        (
            ["support r_support place mid 1 2", "carrier other_support knee 2 4"],
            "knee carries at 2 s: there is no time to come down, or to rise",
        ),
        (
            ["carrier other_support seat 2 3", "carrier other_support seat 3.25 5"],
            "seat carries at 2 s: there is no time to come down, or to rise",
        ),
        (
            ["carrier other_support hand 2 2.25"],
            "hand carries at 2 s for so short a time that nobody sees it",
        ),
        (
            ["direction r_arm place high 2 3", "carrier other_support hand 2 5"],
            "r_hand does not prop at 2 s: it goes as told",
        ),
        (
            ["direction torso place high 2 3", "carrier other_support trunk 2 5"],
            "torso goes as told at 2 s: trunk may not carry",
        ),
        (
            ["direction r_arm place low 2 3", "carrier other_support trunk 2 5"],
            "r_arm would go through the floor at 2 s",
        ),
        (
            ["direction r_leg place high 2 3", "carrier other_support knee 2 5"],
            "r_thigh goes as knee needs it at 2 s, not as told",
        ),
        (
            ["bend r_leg_bend bend1 2 3", "carrier other_support knee 2 5"],
            "r_leg bends as knee needs it at 2 s, not as told",
        ),
        (
            ["touch r_hand_touch head 3 4", "carrier other_support hand 2 5"],
            "r_hand does not prop at 2 s: it goes as told",
        ),
        (
            ["direction r_leg forward low 0 1", "carrier other_support knee 3 5"],
            "r_leg goes as told only while something else than feet carries",
        ),
    ],
)
def test_what_cannot_be_is_said(lines, warning):
    assert warning in act(*lines).warnings


def test_one_support_becomes_the_next():
    motion = act("carrier other_support knee 2 4", "carrier other_support hand 4 6")
    assert [it[0] for it in told(motion)] == ["knee", "hand"]
    assert told(motion)[1][1:] == pytest.approx((240, 360), abs=3)
    assert motion.warnings == (
        "knee carries at 2 s: there is no time to come down, or to rise",
    )  # where the first one ends is told by a fifth of a second
