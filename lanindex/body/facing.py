"""Where a joint's own right and up point.

Many skeletons stand upright at rest, arms to the sides or down, and look ahead: what points to the
body's right then is known in every frame from how a joint is turned. Others have every bone along
one axis at rest. Their chest, which shoulders move little against, tells its own axes; and those of
the head are the same, if it seems to be upright as the chest is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES
from lanindex.model import Skeleton

Floats = NDArray[np.float64]

TURNING = ("Head",)
"""The joints of the body whose axes are told."""

_UPRIGHT, _ASKEW = 0.85, 0.26  # cosines: 32 degrees from an axis, 15 from a right angle
_ALONG, _UPSIDE = 0.87, 0.71  # cosines: 30 degrees from an axis, 45
_BLOCK = 4096


def rest_axes(
    parents: Sequence[int], offsets: Any, body: NDArray[np.int16]
) -> NDArray[np.float64] | None:
    """Return which way right and up are at rest.

    `parents` (J) parents before children, -1 for a root; `offsets` (J, 3) from the parent, at rest;
    `body` (20,) which joints play the body, as in `Skeleton`; returned (2, 3) unit vectors, up
    along an axis; None where no body stands at rest.
    """
    index = _corners(body)
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


def seen_axes(
    parents: Sequence[int],
    body: NDArray[np.int16],
    poses: Floats,
    turned: Callable[[int], Floats],
) -> Floats | None:
    """Return which way right and up are where bones lie along one axis at rest.

    `parents` (J) parents before children, -1 for a root; `body` (20,) which joints play the body,
    as in `Skeleton`; `poses` (T, J, 3) places in some frames; returned (2, 3) unit vectors along
    axes, the same for chest and head; None where the chest has no such axes, or the head plainly
    others.
    """
    found, index = _corners(body), int(body[JOINT_CODES["Head"]])
    if min(*found, index) < 0 or (chest := _above(parents, found[2:])) < 0:
        return None
    seen = []
    right_hip, left_hip, right, left = np.moveaxis(poses[:, found], 1, 0)
    turns, head = turned(chest), turned(index)
    for line, most in ((right - left, _ALONG), (right + left - right_hip - left_hip, _UPSIDE)):
        own, heads = _mean(turns, line), _mean(head, line)
        axis = int(np.argmax(np.abs(own)))
        unit = np.sign(own[axis]) * np.eye(3)[axis] + 0.0
        if not (own @ unit >= _ALONG and np.abs(heads * (1 - np.abs(unit))).max() <= most):
            return None  # nor where a place is not known
        seen.append(unit)
    return None if seen[0] @ seen[1] else np.stack(seen)


def _above(parents: Sequence[int], joints: Sequence[int]) -> int:
    """Return the lowest joint that two joints hang on, or -1."""
    chains = []
    for joint in joints:
        chain = [joint]
        while chain[-1] >= 0:
            chain.append(int(parents[chain[-1]]))
        chains.append(chain)
    return next(joint for joint in chains[0] if joint in chains[1])


def _corners(body: NDArray[np.int16]) -> list[int]:
    """Return the joints of right and left hip, right and left shoulder."""
    return [int(body[JOINT_CODES[s + it]]) for it in ("Hip", "Shoulder") for s in "RL"]


def _mean(turns: Floats, vectors: Floats) -> Floats:
    """Return where vectors (T, 3) point in the mean, as what turns (T, 3, 3) sees them."""
    lengths = np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-9)
    mean: Floats = np.einsum("tkc,tk->c", turns, vectors / lengths) / len(vectors)
    return mean


def _unit(vector: Floats) -> Floats:
    unit: Floats = vector / max(float(np.linalg.norm(vector)), 1e-9)
    return unit


def axes_of(
    skeleton: Skeleton, rotations: NDArray[np.float32] | None
) -> dict[str, NDArray[np.float32]]:
    """Return where what at rest points right and up points now, by joint of the body.

    `rotations` (T, J, 4), as in `Motion`.
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
                    found[name][part, number] = about(rotations[part, joint], axis)
    return found


def about(turns: NDArray[np.float32], vector: Floats) -> Floats:
    """Return a vector as unit quaternions (T, 4) turn it."""
    real, axes = turns[:, :1].astype(np.float64), turns[:, 1:].astype(np.float64)
    twice = 2 * np.cross(axes, vector)
    turned: Floats = vector + real * twice + np.cross(axes, twice)
    return turned
