"""Frames that the search for other supports leaves out hold none."""

import numpy as np
import pytest
from effort import seeds

from lanindex.encoding.rests import JOINTS, carriers, lowest, masses, points

LEG, FLOOR, RATE = 800.0, 0.2, 60.0


def sinking(seed: int, frames: int) -> dict[str, np.ndarray]:
    """Return joints, some of them, that come down to the floor, and up again."""
    random = np.random.default_rng(seed)
    must = {side + it for side in "RL" for it in ("Hip", "Ankle")}
    names = [it for it in JOINTS if it in must or seed == 0 or random.random() < 0.8]
    where = np.cumsum(random.normal(0, 3, (frames, len(names), 3)), axis=0)
    where += random.normal(0, 200, (len(names), 3))
    fall = np.abs(np.linspace(-1, 1, frames))[:, None] * random.uniform(0, 900, len(names))
    where[..., 1] = FLOOR * LEG + np.abs(where[..., 1]) * 0.2 + fall
    return dict(zip(names, where.transpose(1, 0, 2), strict=True))


def told(places: dict[str, np.ndarray], some: slice, feet: np.ndarray) -> np.ndarray:
    body = points(places, LEG, FLOOR, some)
    return carriers(body, masses(tuple(places)), feet[:, some], RATE)


@pytest.mark.parametrize("seed", seeds(12))
def test_what_is_left_out_carries_nothing(seed):
    places = sinking(seed, 400)
    for one in places.values():
        one[300:, 1] += 900
    feet = np.random.default_rng(seed).random((2, 400)) < 0.5
    whole = told(places, slice(0, 400), feet)
    some = lowest(places, LEG, FLOOR)
    assert 0 < some.stop < 400
    assert np.array_equal(whole[..., some], told(places, some, feet))
    assert not whole[..., : some.start].any()
    assert not whole[..., some.stop :].any()
    for one in places.values():
        one[:, 1] += 900
    assert lowest(places, LEG, FLOOR) == slice(0, 0)


def test_all_of_the_weight_is_somewhere():
    for names in (JOINTS, ("RHip", "LHip", "RAnkle", "LAnkle"), JOINTS[:3]):
        found = masses(tuple(names))
        assert found.sum() == pytest.approx(1)
        assert all(name in names for name, mass in zip(JOINTS, found, strict=True) if mass)
