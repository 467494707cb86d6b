"""What a model of Vicon (Plug-in Gait) says of segments → joints: where each has its origin.

Of each segment an export gives a turn (RX, RY, RZ: axis times angle, degrees), the origin (TX, TY,
TZ) and its length (SX, SY, SZ). Origins are the joints at the lower ends; the hips lie at the
upper ends of the thighs, along their z axes.

Source: Vicon, *Plug-in Gait Reference Guide*, kinematic segments.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

JOINTS = {
    "PEL": "Pelvis",
    "TRX": "Neck",
    "HED": "Head",
    **{
        side + segment: side + joint
        for side in "LR"
        for segment, joint in (
            ("CL", "Shoulder"),
            ("HU", "Elbow"),
            ("RA", "Wrist"),
            ("HN", "Hand"),
            ("FE", "Knee"),
            ("TI", "Ankle"),
            ("TO", "Toe"),
        )
    },
}
"""By segment, the joint at its origin."""

AXES = ["RX", "RY", "RZ", "TX", "TY", "TZ", "SX", "SY", "SZ"]

Triple = tuple[int, int, int]
Finish = Callable[[NDArray[Any]], NDArray[Any]]


def joints(names: list[str], axes: list[str]) -> tuple[tuple[str, ...], list[Triple], Finish]:
    """Return the joints that a header's segments tell."""
    called: list[str] = []
    points: list[Triple] = []
    thighs: list[tuple[str, int]] = []
    for column in range(2, min(len(names), len(axes) - 8)):
        subject, mark, segment = names[column].rpartition(":")
        if segment in JOINTS and [axis.upper() for axis in axes[column : column + 9]] == AXES:
            called.append(subject + mark + JOINTS[segment])
            points.append((column + 3, column + 4, column + 5))
            if segment[1:] == "FE":
                thighs.append((f"{subject}{mark}{segment[0]}Hip", column))
    knees = [points.index((column + 3, column + 4, column + 5)) for _, column in thighs]
    many = len(points)
    for _, column in thighs:
        points += [(column, column + 1, column + 2), (column + 6, column + 7, column + 8)]

    def finish(places: NDArray[Any]) -> NDArray[Any]:
        turns, lengths = places[:, many::2], places[:, many + 1 :: 2, 2:]
        hips = places[:, knees] + lengths * _upwards(np.radians(turns))
        return np.concatenate((places[:, :many], hips), axis=1)

    return (*called, *(name for name, _ in thighs)), points, finish


def _upwards(turns: NDArray[Any]) -> NDArray[Any]:
    """Return the z axis turned by axes times angles, (..., 3)."""
    angle = np.sqrt((turns * turns).sum(axis=-1, keepdims=True))
    axis = turns / np.where(angle > 0, angle, 1)
    up = np.array([0.0, 0.0, 1.0])
    across = np.cross(axis, up)
    along: NDArray[Any] = axis * axis[..., 2:]
    result: NDArray[Any] = up * np.cos(angle) + across * np.sin(angle) + along * (1 - np.cos(angle))
    return result
