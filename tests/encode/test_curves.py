"""How one curve goes, plain and compiled: equal numbers, whatever the curve."""

import itertools

import numpy as np
import pytest

from lanindex.encoding import curves, onset, ways
from lanindex.encoding.bends import found
from lanindex.encoding.profile import load
from lanindex.encoding.swings import arrivals, swings

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
        events = np.concatenate([*found(np.abs(curve)[None], profile), ways.turns(curve, profile)])
        start, stop = events.T[:2]
        assert ((start >= 0) & (start <= stop) & (stop < len(curve))).all()
        assert all(0 <= a < b < len(curve) for a, b in swings(curve + 0j, profile))


@pytest.mark.parametrize("pace", [[1, 1, 1, 1], [0, 1, 1, 1], [2, 1, 1, 1]])
def test_an_even_pace_has_a_beginning(pace):
    for part in range(4):
        for rests in (0.5, 1.0, 3.0):
            assert 0 <= onset.begun(pace, part, rests) < len(pace)


@pytest.mark.parametrize("seed", range(60))
def test_compiled_curves_go_as_plain_ones(seed):
    fast = pytest.importorskip("lanindex.encoding.curves_fast")
    random, curve = np.random.default_rng(seed), line(seed)
    if seed % 2:
        curve = curve + random.normal(0, 0.5, len(curve))
    both, profile = curve + 1j * np.roll(curve, len(curve) // 3), load("default")
    for width in (1, 5, 61):
        assert fast.mean(curve, width).tobytes() == curves.mean(curve, width).tobytes()
    (bends,), (others,) = fast.bends(curve[None], profile), found(curve[None], profile)
    assert bends.tobytes() == others.tobytes()
    assert fast.turns(curve, profile).tobytes() == ways.turns(curve, profile).tobytes()
    for told in itertools.product((15.0, 30.0), (profile,), (False, True)):
        assert fast.arrivals(both, *told).tobytes() == arrivals(both, *told).tobytes()
