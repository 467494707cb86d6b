"""Where a joint's own right and up point: of a skeleton that stands at rest.

Many skeletons stand upright at rest, arms to the sides or down, and look ahead: what points to the
body's right then is known in every frame from how a joint is turned. Others have every bone along
one axis at rest; of these nothing is told.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES
from lanindex.model import Skeleton

Floats = NDArray[np.float64]

TURNING = ("Head",)
"""The joints of the body whose axes are told."""

_UPRIGHT, _ASKEW = 0.85, 0.26  # cosines: 32 degrees from an axis, 15 from a right angle
_BLOCK = 4096


def rest_axes(
    parents: Sequence[int], offsets: Any, body: NDArray[np.int16]
) -> NDArray[np.float64] | None:
    """Return which way right and up are at rest.

    Parameters
    ----------
    parents : sequence of int
        (J) parents before children, -1 for a root.
    offsets : array_like
        (J, 3) from the parent, at rest.
    body : ndarray
        (20,) which joints play the body, as in `Skeleton`.

    Returns
    -------
    ndarray or None
        (2, 3) unit vectors, up along an axis; None where no body stands at rest.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.body.facing import rest_axes
    >>> skeleton = lanindex.read("corpus/compass.bvh").skeleton
    >>> rest_axes(skeleton.parents, skeleton.offsets, skeleton.body)
    array([[-1.,  0.,  0.],
           [ 0.,  1.,  0.]])
    """
    index = [int(body[JOINT_CODES[s + it]]) for it in ("Hip", "Shoulder") for s in "RL"]
    if min(index) < 0:
        return None
    places = np.array(offsets, np.float64).reshape(-1, 3).tolist()
    for joint, parent in enumerate(parents):
        (x, y, z), (a, b, c) = places[joint], places[parent]
        places[joint] = [x + a, y + b, z + c] if parent >= 0 else [0.0, 0.0, 0.0]
    right_hip, left_hip, right, left = np.array([places[joint] for joint in index])
    hips, shoulders = _unit(right_hip - left_hip), _unit(right - left)
    trunk = _unit(right + left - right_hip - left_hip)
    axis = int(np.argmax(np.abs(trunk)))
    if abs(trunk[axis]) < _UPRIGHT or abs(hips @ trunk) > _ASKEW or hips @ shoulders < 1 - _ASKEW:
        return None
    up = np.zeros(3)
    up[axis] = np.sign(trunk[axis])
    across = hips - (hips @ up) * up
    return np.stack((_unit(across), up)) + 0.0


def _unit(vector: Floats) -> Floats:
    unit: Floats = vector / max(float(np.linalg.norm(vector)), 1e-9)
    return unit


def axes_of(
    skeleton: Skeleton, rotations: NDArray[np.float32] | None
) -> dict[str, NDArray[np.float32]]:
    """Return where what at rest points right and up points now, by joint of the body.

    Parameters
    ----------
    skeleton : Skeleton
        Its offsets are those of the rest that the rotations start from.
    rotations : ndarray or None
        (T, J, 4), as in `Motion`.

    Returns
    -------
    dict
        As in `Motion.axes`.
    """
    rest = rest_axes(skeleton.parents.tolist(), skeleton.offsets, skeleton.body)
    if rotations is None or rest is None:
        return {}
    found = {}
    for name in TURNING:
        joint = int(skeleton.body[JOINT_CODES[name]])
        if joint >= 0:
            found[name] = np.empty((len(rotations), 2, 3), np.float32)
            for start in range(0, len(rotations), _BLOCK):
                part = slice(start, start + _BLOCK)
                for number, axis in enumerate(rest):
                    found[name][part, number] = _turned(rotations[part, joint], axis)
    return found


def _turned(turns: NDArray[np.float32], vector: Floats) -> Floats:
    """Return a vector as unit quaternions (T, 4) turn it."""
    real, axes = turns[:, :1].astype(np.float64), turns[:, 1:].astype(np.float64)
    twice = 2 * np.cross(axes, vector)
    turned: Floats = vector + real * twice + np.cross(axes, twice)
    return turned
