"""Beginnings and ends of movements on synthetic curves."""

import numpy as np
import pytest
from effort import seeds

from lanindex.encoding.curves import begun, seen
from lanindex.perform.limbs import minimum_jerk

RATE = 60


def goes(start: int, stop: int, far: float, count: int = 300) -> np.ndarray:
    """Return a curve that goes so far, from rest to rest."""
    return far * minimum_jerk(np.clip((np.arange(count) - start) / (stop - start), 0, 1))


def when(curve: np.ndarray, rests: float = 10 / RATE) -> tuple[int, int]:
    pace = np.abs(np.gradient(curve))
    quick = np.flatnonzero(pace > pace.max() / 5)
    return seen(curve, pace, (quick[0], quick[-1]), (0, len(curve) - 1), rests)


@pytest.mark.parametrize("far", [20, -90, 40j])
@pytest.mark.parametrize("stop", [125, 160, 190])
def test_it_begins_and_ends_within_two_frames_of_when_it_does(far, stop):
    start, end = when(goes(100, stop, 1) * far)
    assert max(abs(start - 100), abs(end - stop)) <= 2


def test_what_noise_does_to_it():
    random, off = np.random.default_rng(0), []
    for _ in range(100):
        noisy = goes(100, 160, 40) + np.convolve(
            random.normal(0, 0.9, 304), np.ones(5) / 5, "valid"
        )
        start, end = seen(noisy, np.gradient(goes(100, 160, 40)), (110, 150), (0, 299), 10 / RATE)
        off += [abs(start - 100), abs(end - 160)]
    assert np.percentile(off, 95) <= 4


def test_a_wobble_before_it_is_not_part_of_it():
    wobble = 3 * np.sin(np.arange(300) / 8) * (np.arange(300) < 100)
    assert when(goes(100, 140, 60) + wobble)[0] == wobble[75:].argmin() + 75


def test_it_does_not_begin_before_the_point_from_which_it_goes():
    back = goes(60, 100, -30) + goes(100, 160, 90)
    start, _ = seen(back, np.abs(np.gradient(back)), (105, 155), (60, 299), 10 / RATE)
    assert start == back.argmin()


def test_it_stays_between_the_rests_around_it():
    curve = goes(100, 160, 60)
    assert seen(curve, np.gradient(curve), (120, 140), (120, 140), 10 / RATE) == (120, 140)


def test_seen_backwards_begin_and_end_change_places():
    curve = goes(100, 150, 60) + goes(130, 200, 30)
    start, end = when(curve)
    assert when(-curve[::-1]) == (299 - end, 299 - start)


def test_a_rest_that_trembles_is_no_movement():
    pace = np.array([2.0, 3, 2, 3, 2, 3, 4, 12, 16, 20, 18])
    assert begun(pace, 7, 5) > 3
    assert begun(pace, 7, 1) == 0  # but for what is never so fast in a rest


@pytest.mark.parametrize("seed", seeds(20))
def test_any_curve_has_borders_within_it(seed):
    random = np.random.default_rng(seed)
    for size in (2, 3, 5, 40, 400):
        steps = random.normal(0, 1, size) * random.integers(0, 2, size)
        curve = np.cumsum(np.round(steps, int(random.integers(0, 3))))
        first, last = sorted(random.choice(size, 2, replace=False).tolist())
        low, high = int(random.integers(0, first + 1)), int(random.integers(last, size))
        start, end = seen(curve, np.abs(np.gradient(curve)), (first, last), (low, high), 0.2)
        assert low <= start < end <= high
