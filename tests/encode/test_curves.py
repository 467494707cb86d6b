"""How one curve goes, plain and compiled: equal numbers, whatever the curve."""

import itertools

import numpy as np
import pytest

from lanindex.encode import curves, onset, ways
from lanindex.encode.bends import _found
from lanindex.encode.profile import load
from lanindex.encode.swings import swings

SLOPES = [0, 0.1, 0.2, 0.25, 1 / 3, 0.5, 1, 2, -0.25, -1, -2]


def line(seed: int) -> np.ndarray:
    """Return a curve of few straight pieces, so that equal values and paces come often."""
    random = np.random.default_rng(seed)
    pieces = random.integers(1, 8)
    steps = np.repeat(random.choice(SLOPES, pieces), random.integers(1, 80, pieces))
    return np.append(0.0, steps).cumsum()


@pytest.mark.parametrize("seed", range(10))
def test_straight_pieces_are_written_down(seed):
    for number in range(seed, 600, 10):
        curve, profile = line(number), load("default")
        events = [*_found(np.abs(curve), profile), *ways.turns(np.radians(curve), profile)]
        assert all(0 <= one.start <= one.stop < len(curve) for one in events)
        assert all(0 <= a < b < len(curve) for a, b in swings(curve + 0j, profile))


@pytest.mark.parametrize("pace", [[1, 1, 1, 1], [0, 1, 1, 1], [2, 1, 1, 1]])
def test_an_even_pace_has_a_beginning(pace):
    for part in range(4):
        for rests in (0.5, 1.0, 3.0):
            assert 0 <= onset.begun(pace, part, rests) < len(pace)


@pytest.mark.parametrize("seed", range(60))
def test_compiled_curves_go_as_plain_ones(seed):
    fast = pytest.importorskip("lanindex.encode.curves_fast")
    random, curve = np.random.default_rng(seed), line(seed)
    if seed % 2:
        curve = curve + random.normal(0, 0.5, len(curve))
    both = curve + 1j * np.roll(curve, len(curve) // 3)
    for width in (1, 5, 61):
        assert fast.mean(curve, width).tobytes() == curves.mean(curve, width).tobytes()
    pace = np.abs(np.diff(curve))
    for slow, frames in itertools.product((0.2, 0.5, 9.0), (0, 1, 5)):
        assert fast.lulls(pace, slow, frames) == curves.lulls(pace, slow, frames)
    for least in (0.5, 15.0):
        assert fast.swings(curve, least) == curves.swings(curve, least)
        assert fast.departures(both, least) == curves.departures(both, least)
    for some in (curve, both):
        pace = np.abs(np.gradient(some))
        for _ in range(20):
            low, first, last, high = np.sort(random.choice(len(curve), 4)).tolist()
            if first < last:
                told = some, pace, (first, last), (low, high), random.choice([0.05, 0.3, 1.0])
                assert fast.seen(*told) == onset.seen(*told)
