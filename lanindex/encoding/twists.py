"""How the chest is turned against the pelvis, and the head against the chest.

Source: ``encoding/BODY.md``, "Twists".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lanindex.encoding.arithmetic import cross, dot
from lanindex.encoding.swings import Angles

Floats = NDArray[np.float64]

TWISTED = 30.0
"""Degrees: what is turned less is in place."""

TRUNK = ("RHip", "LHip", "RShoulder", "LShoulder")


def torso(places: dict[str, Floats]) -> Angles:
    """Return how far the shoulders are turned to the right of the hips, (N,) degrees."""
    hips, shoulders = (places["R" + it] - places["L" + it] for it in ("Hip", "Shoulder"))
    return between(hips, shoulders, trunk(places))


def head(places: dict[str, Floats]) -> Angles:
    """Return how far the head is turned to the right of the shoulders, (N,) degrees."""
    shoulders = places["RShoulder"] - places["LShoulder"]
    return between(shoulders, places["Head right"], trunk(places))


def trunk(places: dict[str, Floats]) -> Floats:
    """Return the way from the middle of the hips to that of the shoulders, (N, 3)."""
    hips, shoulders = (places["R" + it] + places["L" + it] for it in ("Hip", "Shoulder"))
    way: Floats = (shoulders - hips) / 2
    return way


def between(first: Floats, second: Floats, about: Floats) -> Angles:
    """Return by how many degrees lines are turned against others about an axis.

    `first, second, about` (N, 3) float64; returned (N,) complex128, degrees to the right, at most
    180; to the left they are below 0.
    """
    axis = about.T / np.maximum(np.sqrt(dot(about.T, about.T)), 1e-9)
    one, other = (some.T - dot(some.T, axis) * axis for some in (first, second))
    left = dot(cross(one, other), axis)
    angles: Angles = np.degrees(np.arctan2(-left, dot(one, other))) + 0j
    return angles
