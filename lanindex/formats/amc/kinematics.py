"""From the numbers of bones to where their joints are, and how they are turned.

A bone turns about axes of its own, fixed to its parent: those of the world at rest, turned by the
angles that its skeleton tells. (Written with matrices: parent · C · M · C⁻¹.)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.formats.amc.asf import Bone

Floats = NDArray[np.float64]

END = " End"
"""Behind a bone's name: the joint where it ends, where no other begins."""


def joints_of(bones: Sequence[Bone]) -> tuple[tuple[str, ...], tuple[int, ...], Floats]:
    """Return a skeleton's joints: where each bone begins, by its name, then where the last end.

    Returns (J, 3).
    """
    names = [bone.name.decode("utf-8", "replace") for bone in bones]
    last = _last(bones)
    parents = [*(bone.parent for bone in bones), *last]
    shifts = [(0.0,) * 3 if bone.parent < 0 else bone.shift for bone in bones]
    offsets = [(0.0,) * 3 if parent < 0 else shifts[parent] for parent in parents]
    return (*names, *(names[bone] + END for bone in last)), tuple(parents), np.array(offsets)


def axes_of(bones: Sequence[Bone], tilt: float) -> list[Floats]:
    """Return the axes that each bone turns about, as columns."""
    return [_axes(bone, tilt) for bone in bones]


def world(
    bones: Sequence[Bone], axes: Sequence[Floats], values: Floats, turn: float
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return where joints are, and their rotations from rest.

    Takes `values` (T, W); returns (T, J, 3), (T, J, 4).
    """
    count = len(values)
    last = _last(bones)
    places = np.empty((len(bones) + len(last), 3, count))
    turns = np.empty((len(bones) + len(last), 4, count))
    column = 0
    for index, bone in enumerate(bones):
        numbers = values[:, column : column + len(bone.dof)].T
        column += len(bone.dof)
        if bone.parent < 0:
            places[index] = np.array(bone.shift)[:, None]
            turned: Floats = np.zeros((4, count))
            turned[0] = 1.0
        else:
            places[index] = places[bone.parent]
            turned = turns[bone.parent]
            if bone.parent:
                places[index] += carried(turned, bones[bone.parent].shift)
        for code, number in reversed(list(zip(bone.dof, numbers, strict=True))):
            if code < 3:
                half = number * (turn / 2.0)
                turned = _followed(
                    turned, np.cos(half), np.outer(axes[index][:, code], np.sin(half))
                )
            else:
                places[index, code - 3] += number
        turns[index] = turned
    for index, above in enumerate(last, len(bones)):
        turns[index] = turns[above]
        places[index] = places[above] + carried(turns[above], bones[above].shift)
    return (
        np.ascontiguousarray(places.transpose(2, 0, 1), np.float32),
        np.ascontiguousarray(turns.transpose(2, 0, 1), np.float32),
    )


def _last(bones: Sequence[Bone]) -> list[int]:
    """Return the bones from which no other goes on."""
    above = {bone.parent for bone in bones}
    return [index for index in range(1, len(bones)) if index not in above]


def _axes(bone: Bone, tilt: float) -> Floats:
    axes = np.eye(3)
    for axis in bone.order:
        one, other = (axis + 1) % 3, (axis + 2) % 3
        cosine, sine = np.cos(bone.axis[axis] * tilt), np.sin(bone.axis[axis] * tilt)
        turn = np.eye(3)
        turn[one, one] = turn[other, other] = cosine
        turn[one, other], turn[other, one] = -sine, sine
        axes = turn @ axes
    return axes


def _followed(first: Floats, cosine: Floats, sines: Floats) -> Floats:
    """Return quaternions (4, T) with another turn within them: its real part, and the others."""
    (w, x, y, z), (a, b, c) = first, sines
    return np.stack(
        (
            w * cosine - x * a - y * b - z * c,
            w * a + x * cosine + y * c - z * b,
            w * b - x * c + y * cosine + z * a,
            w * c + x * b - y * a + z * cosine,
        )
    )


def carried(turn: NDArray[Any], vector: Sequence[float] | NDArray[Any]) -> NDArray[Any]:
    """Return vectors turned by quaternions.

    Takes `turn` (4, T), `vector` (3,), (3, T); returns (3, T).
    """
    (w, x, y, z), (a, b, c) = turn, vector
    d, e, f = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return np.stack(
        (a + w * d + y * f - z * e, b + w * e + z * d - x * f, c + w * f + x * e - y * d)
    )
