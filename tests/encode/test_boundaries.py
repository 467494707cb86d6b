"""Values exactly on a border of the method always belong to the same side."""

from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

from lanindex.alphabet import PLACE
from lanindex.encoding import curves, ground, steps
from lanindex.encoding.arithmetic import smooth, window
from lanindex.encoding.profile import load

RATE = 100.0
BRIEF = round(ground.FLICKER * RATE)


def flights(
    frames: int, fall: float, pace: float = 0.0, lift: float = 0.1, rise: float = 0.0
) -> list[tuple[int, int]]:
    """Return the flights of a body that is without support for some frames, and so falls."""
    carries = np.ones((2, 40), bool)
    carries[:, 10 : 10 + frames] = False
    height = rise * np.arange(40) / RATE - fall / 2 * (np.arange(40) / RATE) ** 2
    lower = np.where(carries[0], 0.0, lift)
    bare = ground.unsupported(carries, RATE)
    return ground._flights(bare, lower, height, np.full(40, pace, np.float32), RATE)


@pytest.mark.parametrize(("count", "place"), [(1, 0), (5, 0), (6, 1), (10, 1), (11, 2)])
def test_a_fifth_of_the_other_values_is_smaller(count, place):
    values = np.random.default_rng(count).permutation(count)
    assert ground.fifth(values) == place


def test_a_flight_lasts_longer_than_a_flicker():
    assert flights(BRIEF, 9.81) == []
    assert flights(BRIEF + 1, 9.81) == [(10, 10 + BRIEF + 1)]


@pytest.mark.parametrize(("name", "pace"), [("FALL", 0.0), ("ONWARD", 3.0)])
def test_who_falls_just_fast_enough_flies(monkeypatch, name, pace):
    height = -7.0 / 2 * (np.arange(40) / RATE) ** 2
    fall = -ground._bent(height[12:20]) * RATE**2
    monkeypatch.setattr(ground, name, fall)
    assert flights(12, 7.0, pace) == [(10, 22)]
    monkeypatch.setattr(ground, name, np.nextafter(fall, 9))
    assert flights(12, 7.0, pace) == []


def test_who_is_just_as_fast_as_one_that_runs_does_not():
    between = (ground.ONWARD + ground.FALL) / 2
    assert flights(12, between, ground.RUNS) == []
    assert flights(12, between, np.nextafter(np.float32(ground.RUNS), np.float32(3))) == [(10, 22)]


def test_hips_sink_at_the_end_of_a_flight_but_at_that_of_the_capture():
    assert flights(12, 12.0, rise=2.0) == [(10, 22)]
    assert flights(12, 12.0, rise=3.0) == []
    assert flights(30, 12.0, rise=9.0) == [(10, 40)]


def test_feet_that_just_clear_the_ground_fly():
    assert flights(12, 12.0, lift=ground.CLEARS) == [(10, 22)]
    assert flights(12, 12.0, lift=np.nextafter(ground.CLEARS, 0)) == []


@pytest.mark.parametrize(
    ("speeds", "heights", "frames", "carry"),
    [
        ((0.2, 0.2), (0.3, 0.35), 26, (True, True)),  # the floor is where the lower foot is
        ((0.2, 0.2), (0.3, 0.4), 26, (True, False)),  # the other one is lifted,
        ((0.8, 0.2), (0.3, 0.4), 26, (True, False)),  # so that only the lower one can carry,
        ((0.8, 0.8), (0.3, 0.35), 26, (False, False)),  # else slow enough feet do,
        ((0.2, 0.2), (0.3, 0.3), 24, (False, False)),  # but not for a moment
        ((0.2, 0.2), (0.8, 0.8), 26, (False, False)),  # nor where something else carries
    ],
)
def test_who_does_not_fall_stands_on_the_lower_foot(speeds, heights, frames, carry):
    high, there = (np.repeat(np.array(it)[:, None], 40, axis=1) for it in (heights, carry))
    feet = SimpleNamespace(
        speed=np.repeat(np.array(speeds)[:, None], 40, axis=1), pace=np.zeros(40)
    )
    carries = np.ones((2, 40), bool)
    carries[:, 8 : 8 + frames] = False
    there[:, :8] = there[:, 8 + frames :] = False
    assert (ground._lowest(feet, high, carries, [], RATE) == there).all()
    assert not ground._lowest(feet, high, carries, [(8, 8 + frames)], RATE).any()


@pytest.mark.parametrize(("fall", "flies"), [(5.0, False), (6.0, False), (8.0, True), (10.0, True)])
def test_an_adult_who_sinks_more_slowly_than_a_body_falls_does_not_fly(fall, flies):
    assert bool(flights(30, fall / 0.82, pace=1.5)) == flies


@pytest.mark.parametrize(
    ("first", "second", "foot", "together"),
    [
        (20, 20 + BRIEF, 1, True),  # the later foot at the last moment
        (20, 21 + BRIEF, 1, False),
        (20, 22, 0, False),  # the same foot
        (20 + BRIEF, 20 + BRIEF, 1, True),  # the earlier one, too
        (21 + BRIEF, 21 + BRIEF, 1, False),
        (19, 22, 1, False),  # in the air
    ],
)
def test_feet_land_together_within_a_flicker(first, second, foot, together):
    body = SimpleNamespace(bare=[(10, 20)])
    landings = [(5, first, 0), (6, second, foot)]
    found = steps._together(body, landings, BRIEF)
    assert found[1] == landings[1]
    assert found[0] == (5, second if together else first, 0)
    assert (steps._flown(body, first, BRIEF) is not None) == (20 <= first <= 20 + BRIEF)


def test_a_way_of_just_the_least_length_has_a_direction():
    assert steps.sector(0.25, 0.0, 0.25) == (2, 0.0)
    assert steps.sector(np.nextafter(0.25, 0), 0.0, 0.25)[0] == PLACE


def test_a_piece_of_just_the_least_length_stays():
    codes = np.repeat([0, 1, 2], [5, 3, 5])
    assert curves.pieces(codes.copy(), 3) == [(0, 5), (5, 8), (8, 13)]
    assert curves.pieces(codes.copy(), 4) == [(0, 8), (8, 13)]


def test_a_lull_is_slower_and_just_long_enough():
    pace = np.array([0.0, 0, 5, 1, 0])
    assert curves.lulls(pace, 1, 2) == [(0, 2)]
    assert curves.lulls(pace, 1, 3) == []


def turned(degrees: float) -> np.ndarray:
    """Return a heading that rests, turns in a tenth of a second, and rests."""
    return np.clip(np.arange(300) - 147.0, 0, 6) / 6 * degrees


def test_a_turn_of_just_the_least_angle_is_one(monkeypatch):
    profile, heading = load("default"), turned(31.2)
    calm = smooth(heading, window(curves.STRIDE, Fraction(60)))
    (_, start), (stop, _) = curves.lulls(np.abs(np.gradient(calm)) * 60, curves.PAUSE, 24)
    done = float(calm[stop - 1] - calm[start])
    monkeypatch.setattr(curves, "TURNS", done)
    assert len(curves.turns(heading, profile)) == 1
    monkeypatch.setattr(curves, "TURNS", np.nextafter(done, 90))
    assert len(curves.turns(heading, profile)) == 0


def test_angles_that_go_just_far_enough_go_somewhere():
    far = np.array([0, 0, curves.MOVED, curves.MOVED]) + 0j
    still = np.zeros(4)
    assert curves.move_parts(far, still + 99, 0, 3, 2) == [(0, 3)]
    assert curves.departures(far, curves.MOVED) == [(0, 3)]
    near = far * (1 - 1e-9)
    assert curves.departures(near, curves.MOVED) == []
