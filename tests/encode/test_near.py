"""What hands are near: compiled loop, plain loop and one frame at a time agree."""

import numpy as np
import pytest
from effort import seeds

from lanindex.alphabet import TOUCHED
from lanindex.encoding import touch
from lanindex.encoding.touch import Near, nearest, plan, points

JOINTS = (
    *("RWrist", "LWrist", "RHip", "LHip", "Neck", "Chest", "Head"),
    *(side + it for side in "RL" for it in ("Hand", "Shoulder", "Elbow", "Knee", "Ankle", "Toe")),
)
ARM, RATE = 500.0, 60.0


def wandering(seed: int, frames: int) -> dict[str, np.ndarray]:
    """Return joints, some of them, that wander about near each other."""
    random = np.random.default_rng(seed)
    names = [*JOINTS[:2], *(it for it in JOINTS[2:] if seed == 0 or random.random() < 0.8)]
    steps = random.normal(0, 15, (frames, len(names), 3))
    steps[0] = random.normal(0, 300 if seed % 3 else 30, steps.shape[1:])
    return dict(zip(names, np.cumsum(steps, axis=0).transpose(1, 0, 2), strict=True))


def same(one: Near, other: Near) -> bool:
    return all(a.tobytes() == b.tobytes() for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize("frames", [1, 2, 3, 120, 400])
@pytest.mark.parametrize("seed", seeds(12))
def test_both_ways_are_equal(seed, frames):
    fast = pytest.importorskip("lanindex.encoding.touch_fast")
    places = wandering(seed, frames)
    told = plan(tuple(places))
    one, other = points(places, ARM, told), points(places, ARM, told)
    assert same(nearest(one, told, RATE), nearest(other, told, RATE, fast=True))
    assert one.tobytes() == other.tobytes()
    assert len(fast._nearest.signatures) == 1  # compiled once for all


def test_blocks_leave_no_trace(monkeypatch):
    places = wandering(0, 100)
    told = plan(tuple(places))
    where = points(places, ARM, told)
    whole = nearest(where, told, RATE)
    monkeypatch.setattr(touch, "FEW", 7)
    monkeypatch.setattr(touch, "MANY", 23)
    assert same(nearest(where, told, RATE), whole)


@pytest.mark.parametrize("seed", seeds(12))
def test_the_nearest_of_all_is_told(seed):
    places = wandering(seed, 200)
    told = plan(tuple(places))
    where = points(places, ARM, told)
    found = nearest(where, told, RATE)
    ways = np.gradient(where, axis=2) * RATE
    for frame in range(0, 200, 17):
        for whose in range(3):
            best, what, pace = touch.FAR, 0, touch.FAR
            for line, (mine, code, palm, one, two, unless) in enumerate(told.lines.T):
                palm, one, two = (np.array((where[:, it, frame], ways[:, it, frame]))
                                  for it in (palm, one, two))  # fmt: skip
                line_size = ((two[0] - one[0]) ** 2).sum()
                share = (palm[0] - one[0]) @ (two[0] - one[0]) / max(line_size, 1e-9)
                share = min(max(share, 0), 1)
                way, past = palm - (1 - share) * one - share * two
                away = np.linalg.norm(way) / told.reaches[line]
                if (
                    mine == whose
                    and away < best
                    and not left_out(unless, found, where, told, frame)
                ):
                    best, what, pace = away, code, np.linalg.norm(past)
            assert TOUCHED[found.what[whose, frame]] == TOUCHED[what]
            assert found.apart[whose, frame] == pytest.approx(best, rel=1e-6)
            assert found.pace[whose, frame] == pytest.approx(pace, rel=1e-5)


def left_out(unless: int, found: Near, where: np.ndarray, told: touch.Plan, frame: int) -> bool:
    if unless in (touch.ALWAYS, touch.NEVER):
        return unless == touch.NEVER
    if unless == touch.CLASPED:
        return found.apart[0, frame] < touch.LEAVES
    rows = told.arms[:, unless - touch.RIGHT_HANGS]
    if min(rows) < 0:
        return False
    wrist, shoulder, hip, neck = where[:, rows, frame].T
    arm, trunk = wrist - shoulder, hip - neck
    cosine = arm @ trunk / np.linalg.norm(arm) / np.linalg.norm(trunk)
    return np.linalg.norm(arm) > touch.STRAIGHT and np.degrees(np.arccos(cosine)) < touch.HANGS
