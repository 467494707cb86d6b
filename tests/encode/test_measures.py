"""Speed, size and straightness of known movements, and a plain twin."""

import math
from itertools import pairwise
from pathlib import Path

import motions
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lanindex.alphabet import MEASURES
from lanindex.encoding import encode, measures
from lanindex.encoding.limbs import Limbs
from lanindex.encoding.profile import load
from lanindex.formats import read
from lanindex.model import Motion, Span
from lanindex.model.columns import GRADES, LIMITS, graded, stored
from lanindex.model.symbol import blank

LENGTH = 500.0
PROFILE = load("default")


def measured(curve, spans, begin=0, length=LENGTH):
    """Return the measures of symbols: (S, 3); `spans` are frames of the stretch, half-open."""
    table = blank(len(spans) + 1)
    table["start"][0] = table["stop"][0] = begin
    table["start"][1:], table["stop"][1:] = (np.array(spans) + begin).T
    known, rate = Span(0, len(curve)), PROFILE.rate
    limbs = Limbs(("r_arm",), known, rate, begin, np.array([curve]), np.array([length]))
    measures.measure(table, [len(table)], limbs, PROFILE)
    assert all(table[name][0] < 0 for name in MEASURES)
    return np.stack([table[name][1:].astype(float) for name in MEASURES], axis=1)


def plainly(curve, start, stop, length=LENGTH):
    """Return the measures of a symbol, point by point."""
    first = max(start - 1, 0)
    last = min(max(stop - 1, first), len(curve) - 1)
    speeds = []
    for frame in range(first, last + 1):
        low, high = max(frame - 1, 0), min(frame + 1, len(curve) - 1)
        speeds.append(60 * math.dist(curve[high], curve[low]) / (high - low) if high > low else 0)

    def step(one, other):
        sizes = [math.hypot(*one), math.hypot(*other)]
        dot = sum(a * b for a, b in zip(one, other, strict=True)) / math.prod(sizes)
        return math.acos(min(max(dot, -1), 1)), (sizes[1] - sizes[0]) / length

    way = [*range(first, last, 3), last]
    gone = sum(math.hypot(*step(curve[a], curve[b])) for a, b in pairwise(way))
    turned, stretched = step(curve[first], curve[last])
    straight = math.hypot(turned, stretched) / gone if gone else 1
    return max(speeds) / length, math.degrees(turned), straight


def swing(degrees, frames, reach=LENGTH):
    """Return the curve of an arm that swings forward from hanging, at one speed."""
    angles = np.radians(np.linspace(0, degrees, frames))
    return reach * np.stack((np.sin(angles), -np.cos(angles), np.zeros(frames)), axis=1)


def test_a_stretched_arm_swings_straight():
    ((speed, size, straight),) = measured(swing(90, 31), [(0, 31)])
    assert (size, straight) == (90, 1)
    assert speed == pytest.approx(math.pi, abs=0.01)  # a quarter of its circle in half a second


def test_a_punch_is_straight_and_goes_nowhere():
    curve = np.linspace((100, 0, 0), (500, 0, 0), 11)
    ((speed, size, straight),) = measured(curve, [(1, 11)])
    assert (speed, size, straight) == (pytest.approx(4.8, abs=0.01), 0, 1)


def test_who_goes_back_has_not_gone_straight():
    curve = np.concatenate((swing(60, 31), swing(60, 31)[-2::-1]))
    assert measured(curve, [(0, 61)])[0, 1:].tolist() == [0, 0]
    (half,) = measured(curve, [(0, 46)])
    assert half[1] == 30
    assert half[2] == pytest.approx(1 / 3, abs=0.01)


def test_a_detour_is_not_straight():
    aside = np.linspace(0, math.pi, 31)
    curve = swing(90, 31) + 150 * np.sin(aside)[:, None] * (0, 0, 1)
    ((_, size, straight),) = measured(curve, [(0, 31)])
    assert size == 90
    assert 0.8 < straight < 0.95


@given(seed=st.integers(0, 1 << 30), frames=st.integers(1, 80), begin=st.integers(0, 9))
def test_the_twin_agrees(seed, frames, begin):
    random = np.random.default_rng(seed)
    curve = np.cumsum(random.normal(0, 30, (frames, 3)), axis=0) + random.normal(0, 200, 3)
    borders = np.sort(random.integers(0, frames + 1, (random.integers(1, 6), 2)), axis=1)
    found = measured(curve, borders, begin)
    for (start, stop), own in zip(borders.tolist(), found, strict=True):
        speed, size, straight = plainly(curve.tolist(), start, stop)
        assert own[0] == pytest.approx(min(speed, 40.94), abs=0.00501)
        assert own[1] == pytest.approx(size, abs=0.501)
        assert own[2] == pytest.approx(straight, abs=0.00501)


def test_a_hand_at_its_own_shoulder_points_nowhere():
    curve = np.zeros((9, 3))
    curve[5:] = 0, -500, 0
    assert np.isfinite(measured(curve, [(0, 4), (4, 9)])).all()


def of_all(motion: Motion) -> dict[tuple[str, int], tuple[float, ...]]:
    score = encode(motion)
    return {
        (part, one.ordinal): (one.speed, one.size, one.straightness)
        for part in score.tracks
        for one in score.symbols(part)
        if one.speed is not None
    }


@pytest.mark.parametrize("change", ["turned", "moved", "scaled", "mirrored"])
def test_the_laws(captures: Path, change: str):
    motion = read(next(captures.glob("bvh/bandai1/*punch_normal_001.bvh")))
    how = {
        "turned": lambda: motions.turned(motion, 37),
        "moved": lambda: motions.moved(motion, (512, -64, 256)),
        "scaled": lambda: motions.scaled(motion, 0.7),
        "mirrored": lambda: motions.mirrored(motion),
    }
    before, after = of_all(motion), of_all(how[change]())
    if change == "mirrored":
        sides = {"r_": "l_", "l_": "r_"}
        after = {
            (sides.get(part[:2], part[:2]) + part[2:], row): it for (part, row), it in after.items()
        }
    assert before.keys() == after.keys()
    apart = np.abs(np.array([np.subtract(before[key], after[key]) for key in before]))
    assert (apart <= np.array([0.011, 1, 0.011])).all()  # on a border of the rounding


@pytest.mark.parametrize("kind", GRADES)
def test_a_limit_has_no_word(kind):
    low, high = LIMITS["arm"][GRADES[kind]]
    values = np.array([-1, low - 1, low, high, high + 1])
    assert graded("l_arm", kind, stored(GRADES[kind], values)).tolist() == [-1, 0, 1, 1, 2]


def test_of_a_part_that_nobody_knows_no_speed_has_a_word():
    assert graded("tail", "pace", np.array([500])).tolist() == [-1]
