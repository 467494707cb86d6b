"""Rotations from positions: one fixed direction, and half turns, which have many axes."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lanindex.rotation import euler, rotations

CHAIN = np.array([-1, 0])
HALF = {
    "up to down, about x": ((0, 1, 0), (1, 0, 0)),
    "down to up, about x": ((0, -1, 0), (1, 0, 0)),
    "right to left, about the vertical": ((1, 0, 0), (0, 1, 0)),
    "aslant, about what is most upright": ((0.6, 0.8, 0), (-0.8, 0.6, 0)),
}
"""From where to its opposite, and the axis."""


def turn_of(rest: tuple[float, ...], now: tuple[float, ...], size: float = 1.0) -> np.ndarray:
    """Return the turn (3, 3) of a joint whose one bone pointed to `rest` and points to `now`."""
    points = np.array([[(0.0, 0.0, 0.0), now]]) * size
    return rotations(points, np.array([(0.0, 0.0, 0.0), rest]) * size, CHAIN)[0, 0]


@pytest.mark.parametrize(("rest", "axis"), HALF.values(), ids=HALF)
@pytest.mark.parametrize("size", [1e-3, 1.0, 400.0])
def test_half_turns_are_made_about_one_axis(rest, axis, size):
    opposite = tuple(-number for number in rest)
    turn = turn_of(rest, opposite, size)
    assert turn @ np.array(rest) == pytest.approx(np.array(opposite))
    assert turn @ np.array(axis) == pytest.approx(np.array(axis))
    assert np.linalg.det(turn) == pytest.approx(1)


def test_half_turns_stand_beside_other_turns():
    rest = np.array([(0.0, 0, 0), (0, 1, 0)])
    ways = np.array([(0.0, 1, 0), (0, -1, 0), (1, 0, 0), (0, -1, 0)])
    points = np.stack([np.zeros_like(ways), ways], axis=1)
    turns = rotations(points, rest, CHAIN)[:, 0]
    assert turns @ rest[1] == pytest.approx(ways)
    assert turns[0] == pytest.approx(np.eye(3))


def test_one_direction_is_kept_by_the_smallest_turn():
    numbers = np.random.default_rng(1)
    for rest, now in numbers.normal(size=(20, 2, 3)):
        turn = turn_of(tuple(rest), tuple(now))
        cosine = rest @ now / np.linalg.norm(rest) / np.linalg.norm(now)
        assert turn @ rest / np.linalg.norm(rest) == pytest.approx(now / np.linalg.norm(now))
        assert np.trace(turn) == pytest.approx(1 + 2 * cosine)


def test_a_bone_of_no_length_follows_its_parent():
    offsets = np.array([(0.0, 0, 0), (0, 1, 0), (0, 0, 0), (0, 0, 0)])
    turn = Rotation.from_euler("z", 40, degrees=True)
    tip = turn.apply([0, 1, 0])
    points = np.array([[(0, 0, 0), tip, tip, tip]])
    turns = rotations(points, offsets, np.array([-1, 0, 1, 2]))[0]
    for found in turns:
        assert found == pytest.approx(turn.as_matrix())


@pytest.mark.parametrize("mirrored", [False, True])
def test_several_directions_are_fitted_without_a_mirror(mirrored):
    rest = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
    turn = Rotation.from_euler("xyz", [20, 30, 100], degrees=True).as_matrix()
    now = rest @ turn.T * (1, 1, -1 if mirrored else 1)
    found = rotations(now[None], rest, np.array([-1, 0, 0, 0]))[0, 0]
    assert np.linalg.det(found) == pytest.approx(1)
    if not mirrored:
        assert found == pytest.approx(turn)


def test_bones_in_one_line_keep_their_first():
    rest = np.array([(0.0, 0, 0), (0, 1, 0), (0, 2, 0)])
    now = np.array([[(0.0, 0, 0), (1, 0, 0), (0, 0, 2)]])
    assert rotations(now, rest, np.array([-1, 0, 0]))[0, 0] @ rest[1] == pytest.approx([1, 0, 0])


@pytest.mark.parametrize("x", [-90.0, 90.0])
def test_where_x_is_a_quarter_turn_z_does_all(x):
    turn = Rotation.from_euler("ZXY", [30, x, 20], degrees=True).as_matrix()
    angles = euler(turn[None])[0]
    assert angles[2] == 0
    assert Rotation.from_euler("ZXY", angles, degrees=True).as_matrix() == pytest.approx(turn)


def test_angles_do_not_jump():
    degrees = np.arange(0.0, 800, 20)
    turns = Rotation.from_euler("z", degrees[:, None], degrees=True).as_matrix()
    assert euler(turns)[:, 0] == pytest.approx(degrees)
