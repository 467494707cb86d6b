"""Touches of hands, head, trunk and legs, and hands that only pass."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from motions import mirrored, motion_of, noisy, scaled, thinned, turned
from random_touches import RATE, Tally, compared, drawn

from lanindex import encode, read_lnd
from lanindex.alphabet import JOINT_CODES
from lanindex.model import Motion
from lanindex.perform import perform

ARM = 560.0
BODY = {
    **{"Pelvis": (0, 900, 0), "Chest": (0, 1150, 0), "Neck": (0, 1400, 0), "Head": (20, 1560, 0)},
    **{"RShoulder": (0, 1350, 180), "RHip": (0, 900, 90), "RKnee": (20, 480, 90)},
    **{"RAnkle": (0, 80, 90), "RToe": (140, 20, 90)},
}
HANGS = (0, 790, 230)
"""Where the right palm hangs: beside the thigh, 140 mm from the line inside it."""


def reached(way: list[tuple[float, tuple[float, float, float]]], both: bool = False, rate: int = 60,
            hands: bool = True) -> Motion:  # fmt: skip
    """Return a standing body whose right palm, or both, goes from place to place.

    Parameters
    ----------
    way : list of tuple of float and tuple
        Seconds and places, mm: forward, up, right; minimum jerk between them.
    both : bool
        Whether the left palm is its mirror image; else it hangs.
    rate : int
        Frames a second.
    hands : bool
        Whether the hand joints are known.
    """
    seconds = np.arange(round(way[-1][0] * rate)) / rate
    palm = np.empty((len(seconds), 3))
    for (begin, one), (end, two) in pairwise(way):
        some = (seconds >= begin) & (seconds < end)
        share = (seconds[some] - begin) / (end - begin)
        share = share**3 * (10 - 15 * share + 6 * share**2)
        palm[some] = np.array(one) * (1 - share[:, None]) + np.array(two) * share[:, None]
    places = np.zeros((len(seconds), 20, 3))
    for name, place in BODY.items():
        places[:, JOINT_CODES[name]] = place
    _arm(places, "R", palm)
    mirror = np.array([1, 1, -1])
    for name in BODY:
        if name[0] == "R":
            places[:, JOINT_CODES["L" + name[1:]]] = np.array(BODY[name]) * mirror
    _arm(places, "L", (palm if both else np.tile(HANGS, (len(palm), 1))) * mirror)
    if not hands:
        places[:, [JOINT_CODES["RHand"], JOINT_CODES["LHand"]]] = np.nan
    return motion_of(places, Fraction(rate))


def _arm(places: np.ndarray, side: str, palm: np.ndarray) -> None:
    """Put an arm of two bones of 280 mm where its palm is; the elbow goes out, down and back."""
    shoulder = np.array(BODY["RShoulder"]) * [1, 1, 1 if side == "R" else -1]
    way = palm - shoulder
    size = np.linalg.norm(way, axis=1, keepdims=True)
    wrist = palm - way / size * 0.15 * ARM
    half = np.minimum(np.linalg.norm(wrist - shoulder, axis=1, keepdims=True) / ARM, 1)
    out = np.tile([-0.3, -0.5, 1.0 if side == "R" else -1.0], (len(palm), 1))
    out -= (out * way).sum(axis=1, keepdims=True) * way / size**2
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    elbow = (shoulder + wrist) / 2 + out * ARM / 2 * np.sqrt(1 - half**2)
    for joint, place in (("Shoulder", shoulder), ("Elbow", elbow), ("Wrist", wrist)):
        places[:, JOINT_CODES[side + joint]] = place
    places[:, JOINT_CODES[side + "Hand"]] = wrist + (palm - wrist) * 1.2


def told(motion: Motion) -> list[tuple[str, str, float, float]]:
    score, rate = encode(motion), float(motion.rate)
    found = [it for part in score.tracks if part.endswith("_touch") for it in score.symbols(part)]
    names = [it.part.removesuffix("_touch") for it in found]
    times = [(round(it.start / rate, 2), round(it.stop / rate, 2)) for it in found]
    return [(name, it.words, *time) for name, it, time in zip(names, found, times, strict=True)]


def there(place: tuple[float, float, float], long: float = 1.0) -> Motion:
    """Return a body whose right hand goes somewhere in 0.8 s, stays, and comes back."""
    return reached(
        [(0, HANGS), (1, HANGS), (1.8, place), (1.8 + long, place), (3, HANGS), (4, HANGS)]
    )


APART, MET = (350, 1150, 250), (350, 1150, 25)
CLAP = [(0, APART), (0.5, APART), (0.7, MET), (0.75, MET), (0.95, APART), (1.5, APART)]


@pytest.mark.parametrize(
    ("place", "thing"),
    [
        ((110, 1560, 60), "head"),
        ((120, 1100, 30), "trunk"),
        ((-120, 1000, 60), "trunk"),
        ((40, 1000, 210), "trunk"),
        ((120, 790, 110), None),
        ((40, 1230, -255), "arm"),
    ],
)
def test_what_a_hand_touches(place, thing):
    found = told(there(place))
    if thing is None:
        assert found == []
        return
    ((hand, what, start, stop),) = found
    assert (hand, what) == ("r_hand", thing)
    assert 1.55 < start < 1.8
    assert 2.8 <= stop < 3


def test_a_clap_is_brief():
    ((part, what, start, stop),) = told(reached(CLAP, both=True))
    assert (part, what) == ("hands", "hand")
    assert start == pytest.approx(0.65, abs=0.07)
    assert stop == pytest.approx(0.8, abs=0.07)


def test_a_wrist_will_do():
    assert [it[0] for it in told(reached(CLAP, both=True, hands=False))] == ["hands"]


def test_hanging_arms_touch_nothing():
    assert told(reached([(0, HANGS), (2, HANGS)], both=True)) == []
    assert told(reached([(0, (90, 790, 150)), (2, (90, 790, 150))], both=True)) == []


def test_a_hand_that_passes_touches_nothing():
    swing = [(it * 0.5, (x, 1000, 130)) for it, x in enumerate((-350, 350, -350, 350, -350))]
    assert told(reached(swing)) == []
    past = [(0, (350, 1000, 300)), (0.4, (350, 1300, -300))]
    crossing = reached(past)
    left = crossing.positions.copy()
    for joint in ("Elbow", "Wrist", "Hand"):
        left[:, JOINT_CODES["L" + joint]] = left[:, JOINT_CODES["R" + joint]] * [1, 1, -1] + [
            60,
            0,
            0,
        ]
    assert told(motion_of(left.astype(float), crossing.rate)) == []


@pytest.mark.parametrize("make", [lambda: reached(CLAP, both=True), lambda: there((110, 1560, 60))])
def test_laws(make):
    motion = make()
    ours = told(motion)
    assert len(ours) == 1
    for other in (turned(motion, 37), scaled(motion, 1.7)):
        assert told(other) == ours
    sides = {"r_hand": "l_hand", "hands": "hands"}
    assert told(mirrored(motion)) == [(sides[it[0]], *it[1:]) for it in ours]
    for other in (noisy(motion, 2.0), thinned(motion, 2)):
        (found,) = told(other)
        assert found[:2] == ours[0][:2]
        assert np.allclose(found[2:], ours[0][2:], atol=0.07)


def test_what_is_not_known_is_not_touched():
    motion = there((110, 1560, 60))
    places = motion.positions.copy()
    places[:, JOINT_CODES["Head"]] = np.nan
    assert told(motion_of(places.astype(float), motion.rate)) == []
    places[:, [JOINT_CODES[it] for it in ("RWrist", "LWrist")]] = np.nan
    assert "hands_touch" not in encode(motion_of(places.astype(float), motion.rate)).tracks


@pytest.mark.parametrize(("noise", "least", "most"), [(0.0, 1.0, 3), (2.0, 0.98, 4)])
def test_what_is_carried_out_comes_back(noise, least, most):
    tally = Tally()
    for seed in range(4):
        score = drawn(seed)
        compared(score, encode(perform(score, rate=RATE, noise=noise, seed=seed)), tally)
    assert tally.wanted == 40
    assert tally.exact >= least * tally.wanted
    assert tally.added == 0
    assert np.percentile([*tally.starts, *tally.stops], 95) <= most


def test_what_cannot_be_reached_is_said():
    text = "#unit1\ntouch r_hand_touch knee 1 2\ntouch l_hand_touch head 1 2\n"
    motion = perform(read_lnd(text), rate=30)
    assert motion.warnings == ("r_hand does not reach the knee: it stays where its arm points",)
    assert [it[:2] for it in told(motion)] == [("l_hand", "head")]
    low = perform(read_lnd(text.replace("r_hand_touch knee", "r_hand_touch head")), rate=30)
    assert low.warnings == ()
