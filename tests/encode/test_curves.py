"""Curves: plain and compiled loops give equal numbers."""

import itertools

import numpy as np
import pytest
from effort import seeds

from lanindex.encoding import curves
from lanindex.encoding.bends import bends
from lanindex.encoding.curves import arrivals, moves, turns
from lanindex.encoding.profile import load

SLOPES = [0, 0.1, 0.2, 0.25, 1 / 3, 0.5, 1, 2, -0.25, -1, -2]


def line(seed: int) -> np.ndarray:
    """Return a curve of few straight pieces, so that equal values and paces come often."""
    random = np.random.default_rng(seed)
    pieces = random.integers(1, 8)
    steps = np.repeat(random.choice(SLOPES, pieces), random.integers(1, 80, pieces))
    return np.append(0.0, steps).cumsum()


@pytest.mark.parametrize("seed", seeds(10))
def test_straight_pieces_are_written_down(seed):
    for number in range(seed, 600, 10):
        curve, profile = line(number), load("default")
        events = np.concatenate([*bends(np.abs(curve)[None], profile), turns(curve, profile)])
        start, stop = events.T[:2]
        assert ((start >= 0) & (start <= stop) & (stop < len(curve))).all()
        assert all(0 <= a < b < len(curve) for a, b in moves(curve + 0j, profile))


@pytest.mark.parametrize("phase", range(0, 360, 30))
def test_the_sway_of_a_walk_does_not_count_in_a_turn(phase):
    time = np.arange(480) / 60
    sway = 12 * np.sin(2 * np.pi * time + np.radians(phase))
    (turn,) = turns(90 * np.clip((time - 3) / 1.5, 0, 1) + sway, load("default"))
    assert abs(curves.Event(*turn).amount - 90) <= 5


def told(hips, chest) -> list[int]:
    """Return the degrees of the turns of headings that rest half a second at each of some."""
    times = np.ravel([(3 + 0.7 * it, 3.5 + 0.7 * it) for it in range(len(hips))])
    ways = [np.interp(np.arange(600) / 60, times, np.repeat(it, 2)) for it in (hips, chest)]
    return [curves.Event(*it).amount for it in turns(ways[0], load("default"), ways[1])]


def test_what_the_shoulders_do_not_turn_is_no_turn():
    assert told([0, 90], [0, 90]) == told([0, 90], [0, 60]) == [90]
    assert told([0, 90], [0, 10]) == told([0, 90], [0, -60]) == []


def test_what_is_no_turn_does_not_bound_one():
    assert told([0, 90, 30], [0, 90, 30]) == [90, 60]
    (turn,) = told([0, 90, 30], [0, 90, 90])
    assert 45 <= turn <= 75  # the mean of half a second at 90 and another at 30


@pytest.mark.parametrize("pace", [[1, 1, 1, 1], [0, 1, 1, 1], [2, 1, 1, 1]])
def test_an_even_pace_has_a_beginning(pace):
    for part in range(4):
        for rests in (0.5, 1.0, 3.0):
            assert 0 <= curves.begun(np.array(pace, float), part, rests) < len(pace)


@pytest.mark.slow
@pytest.mark.parametrize("seed", seeds(60))
def test_compiled_curves_go_as_plain_ones(seed):
    pytest.importorskip("numba")
    random, curve = np.random.default_rng(seed), line(seed)
    if seed % 2:
        curve = curve + random.normal(0, 0.5, len(curve))
    both, profile = curve + 1j * np.roll(curve, len(curve) // 3), load("default")
    (bent,), (others,) = bends(curve[None], profile, fast=True), bends(curve[None], profile)
    assert bent.tobytes() == others.tobytes()
    for told in itertools.product((15.0, 30.0), (profile,), (False, True)):
        assert arrivals(both, *told, fast=True).tobytes() == arrivals(both, *told).tobytes()
