"""Quaternions, against scipy's rotations."""

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from lanindex.formats import turning

ONE, OTHER = (Rotation.random(200, random_state=seed) for seed in (1, 2))
POINTS = np.random.default_rng(3).normal(size=(200, 3))


def own(turns: Rotation) -> np.ndarray:
    return turns.as_quat()[:, [3, 0, 1, 2]]


def same(found: np.ndarray, wanted: Rotation) -> None:
    assert np.abs((found * own(wanted)).sum(axis=-1)).min() > 1 - 1e-12


def test_turns_in_a_row_and_back() -> None:
    same(turning.product(own(ONE), own(OTHER)), ONE * OTHER)
    same(turning.inverse(own(ONE)), ONE.inv())


def test_points_and_matrices() -> None:
    np.testing.assert_allclose(turning.rotated(own(ONE), POINTS), ONE.apply(POINTS), atol=1e-12)
    np.testing.assert_allclose(turning.matrices(own(ONE)), ONE.as_matrix(), atol=1e-12)
    halves = Rotation.from_rotvec(np.pi * np.eye(3))  # where the sum of the diagonal is -1
    for turns in (ONE, OTHER, halves):
        same(turning.quaternions(turns.as_matrix()), turns)


def test_the_way_between() -> None:
    parts = np.linspace(0, 1, 200)
    found = turning.between(own(ONE), -own(OTHER), parts)
    for number, part in enumerate(parts):
        ends = Rotation.concatenate([ONE[number], OTHER[number]])
        same(found[number], Slerp([0, 1], ends)([part])[0:1])
    close = turning.between(own(ONE), own(ONE), parts)
    same(close, ONE)


def test_scales_are_handed_down() -> None:
    """With a scale of 1 that is not still, places are the same as without."""
    numbers = np.random.default_rng(4)
    shifts, turns = numbers.normal(size=(4, 9, 3)), own(Rotation.random(36, random_state=5))
    turns = turns.reshape(4, 9, 4)
    ones = np.ones((9, 3))

    def places(by: np.ndarray) -> np.ndarray:
        points, turned = np.empty((9, 4, 3)), np.empty((9, 4, 4))
        parents = (-1, 0, 1, 1)
        within = lambda node: (shifts[node], turns[node], by)  # noqa: E731
        turning.place(range(4), range(4), parents, within, points, turned)
        return points

    ways = places(ones)
    np.testing.assert_allclose(ways, places(ones * (1 + 1e-12)), atol=1e-9)
    first = shifts[0] + Rotation.from_quat(turns[0][:, [1, 2, 3, 0]]).apply(shifts[1])
    np.testing.assert_allclose(ways[:, 1], first, atol=1e-12)
    np.testing.assert_allclose(places(2 * ones)[:, 1], 2 * first - shifts[0], atol=1e-12)
