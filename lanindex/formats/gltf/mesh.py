"""Something to see of a skeleton: an octahedron for each bone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

WIDTH = 0.08
"""Half of a bone's thickness, of its length."""

RING = 0.15
"""Where it is thickest, of its length."""

TIP = 0.02
"""Metres that the last joint of a limb is shown by."""

Floats = NDArray[np.float64]

_FACES = np.array(
    [[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 1, 4], [5, 1, 2], [5, 2, 3], [5, 3, 4], [5, 4, 1]]
)


def octahedra(
    places: Floats, parents: Sequence[int]
) -> tuple[Floats, NDArray[np.int64], NDArray[np.int64]]:
    """Return the bones of a skeleton as octahedra.

    Takes `places` (J, 3); returns (6 B, 3), (8 B, 3).
    """
    bones = [
        (parent, places[parent], places[joint])
        for joint, parent in enumerate(parents)
        if parent >= 0 and np.linalg.norm(places[joint] - places[parent]) > 1e-4
    ]
    ended = set(range(len(parents))) - {joint for joint, _, _ in bones}
    bones += [(joint, places[joint], places[joint] + [0, TIP, 0]) for joint in sorted(ended)]
    corners = np.concatenate([_corners(start, stop) for _, start, stop in bones])
    joints = np.repeat([joint for joint, _, _ in bones], 6)
    faces = np.concatenate([_FACES + 6 * number for number in range(len(bones))])
    return corners, joints, faces


def _corners(start: Floats, stop: Floats) -> Floats:
    """Return the corners of a bone: its head, four about it, its tail."""
    along = stop - start
    across = np.cross(along, np.eye(3)[np.abs(along).argmin()])
    across *= WIDTH * np.linalg.norm(along) / np.linalg.norm(across)
    other = np.cross(along, across) / np.linalg.norm(along)
    middle = start + RING * along
    ring = (middle + across, middle + other, middle - across, middle - other)
    return np.stack([start, *ring, stop])
