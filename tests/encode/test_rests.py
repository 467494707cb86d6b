"""Supports other than feet: kneeling, sitting, lying, on all fours."""

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from motions import mirrored, motion_of, noisy, scaled, turned

from lanindex import encode
from lanindex.alphabet import JOINT_CODES

LEG = 800.0
FLESH = {"Hip": 90.0, "Knee": 60.0, "Ankle": 70.0, "Toe": 20.0, "Wrist": 50.0, "Neck": 110.0}
"""Millimetres that a joint lies above the floor on which its part of the body lies."""

STAND = {"trunk": 0, "thigh": (0, 0), "shank": (0, 0), "foot": (80, 80), "arm": 0}
POSES = {
    "stand": STAND,
    "squat": {**STAND, "trunk": 45, "thigh": (115, 115), "shank": (-35, -35), "arm": 80},
    "bend": {**STAND, "trunk": 100, "thigh": (-15, -15)},
    "kneel": {**STAND, "shank": (-90, -90), "foot": (-90, -90)},
    "kneel on one": {**STAND, "thigh": (0, 90), "shank": (-103, 0), "foot": (-10, 80)},
    "sit": {**STAND, "thigh": (88, 88), "shank": (88, 88), "foot": (170, 170)},
    "chair": {**STAND, "thigh": (90, 90)},
    "lie": {
        **STAND,
        "trunk": -90,
        "thigh": (90, 90),
        "shank": (90, 90),
        "foot": (150, 150),
        "arm": 90,
    },
    "fours": {**STAND, "trunk": 80, "shank": (-90, -90), "foot": (-90, -90)},
}
"""Degrees from straight down to forward, the trunk's from straight up; of pairs right and left."""


def _way(degrees: float) -> np.ndarray:
    angle = np.radians(degrees)
    return np.array([np.sin(angle), -np.cos(angle), 0.0])


def _body(pose: dict) -> np.ndarray:
    """Return the places of the joints, (20, 3): facing +x, the lowest part on the floor."""
    places = {"Pelvis": np.zeros(3)}
    up = -_way(-pose["trunk"])
    for name, far in (("Chest", 250), ("Neck", 500), ("Head", 650)):
        places[name] = far * up
    for number, side in enumerate("RL"):
        out = np.array([0.0, 0.0, 1.0 if side == "R" else -1.0])
        at = places[side + "Hip"] = 90 * out
        for name, bone, size in (
            ("Knee", "thigh", 400),
            ("Ankle", "shank", 400),
            ("Toe", "foot", 150),
        ):
            at = places[side + name] = at + size * _way(pose[bone][number])
        at = places[side + "Shoulder"] = 450 * up + 180 * out
        for name, size in (("Elbow", 270), ("Wrist", 250), ("Hand", 90)):
            at = places[side + name] = at + size * _way(pose["arm"])
    low = min(it[1] - FLESH.get(name.lstrip("RL"), -1e4) for name, it in places.items())
    middle = (places["RToe"] + places["LToe"]) / 2
    found = np.array([places[name] for name in JOINT_CODES])
    return found - [middle[0], low, 0]


def acted(*names: str, rate: int = 60) -> object:
    """Return the motion of a body that takes poses, a second on the way and two in each."""
    frames = [np.tile(_body(POSES[names[0]]), (2 * rate, 1, 1))]
    for one, two in pairwise(names):
        for share in np.linspace(0, 1, rate):
            eased = share**3 * (10 - 15 * share + 6 * share**2)
            mixed = {
                name: np.add(np.multiply(POSES[one][name], 1 - eased), np.multiply(it, eased))
                for name, it in POSES[two].items()
            }
            frames.append(_body(mixed)[None])
        frames.append(np.tile(_body(POSES[two]), (2 * rate, 1, 1)))
    return motion_of(np.concatenate(frames), Fraction(rate))


def rests(motion) -> list[tuple[str, float, float]]:
    score = encode(motion)
    rate = float(score.rate)
    return [(it.words, it.start / rate, it.stop / rate) for it in score.symbols("other_support")]


@pytest.mark.parametrize(
    ("pose", "carrier"),
    [
        ("kneel", "knee"),
        ("kneel on one", "knee"),
        ("sit", "seat"),
        ("chair", "other"),
        ("lie", "trunk"),
        ("fours", "hand"),
    ],
)
def test_what_carries_is_told(pose, carrier):
    motion = acted("stand", pose, "stand")
    (found,) = rests(motion)
    assert found[0] == carrier
    assert found[1] == pytest.approx(3, abs=0.45)
    assert found[2] == pytest.approx(5, abs=0.45)
    assert [it.words for it in encode(motion).symbols("jump")] == []


@pytest.mark.parametrize("pose", ["squat", "bend"])
def test_feet_carry_who_squats_or_bends(pose):
    assert rests(acted("stand", pose, "stand")) == []


@pytest.mark.parametrize("pose", ["chair", "stand"])
@pytest.mark.parametrize(
    ("high", "stairs", "hangs"), [(1100, 1, True), (1100, 4, False), (400, 1, False)]
)
def test_feet_far_above_the_floor_do_not_stand_if_no_stairs_lead_there(pose, high, stairs, hangs):
    motion = acted("stand", *[pose] * stairs, "stand")
    lift = np.zeros(len(motion))
    for stair in range(stairs):
        begin = 120 + 180 * stair  # a second up, two that it stands there
        lift[begin : begin + 60] = high / stairs * (stair + np.linspace(0, 1, 60))
        lift[begin + 60 : begin + 180] = high / stairs * (stair + 1)
    lift[begin + 180 : begin + 240] = high * np.linspace(1, 0, 60)
    places = motion.positions + (lift[:, None, None] * (0, 1, 0)).astype(np.float32)
    score, still = encode(replace(motion, positions=places)), (begin + 90, begin + 150)  # frames
    told = [it.words for it in score.symbols("other_support") if it.start <= still[0] < it.stop]
    assert told == ["other"] * hangs
    stands = any(it.start < still[1] and it.stop > still[0] for it in score.symbols("r_stance"))
    assert stands != hangs
    assert any("far above the floor" in doubt for doubt in score.warnings) == hangs


def test_laws():
    motion = acted("stand", "kneel", "fours", "stand", "sit", "lie", "stand", "chair", "stand")
    ours = [it[0] for it in rests(motion)]
    assert ours == ["knee", "hand", "seat", "trunk", "other"]
    for other in (turned(motion, 37), scaled(motion, 1.7), mirrored(motion), noisy(motion, 2.0)):
        assert [it[0] for it in rests(other)] == ours
