"""How far torso and head lean out of the vertical, and which way.

Source: ``encoding/BODY.md``, "Inclines".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lanindex.encoding.swings import Angles

Floats = NDArray[np.float64]

INCLINED = 15.0
"""Degrees: what leans less is in place."""


def leaning(upward: Floats, turn: Floats) -> Angles:
    """Return how far something leans to the right, and (the imaginary part) forward.

    `upward` (N, 3) float64: where it points, in the axes of the capture; `turn` (N,) radians, the
    heading; returned (N,) complex128, degrees.
    """
    east, up, south = upward.T
    flat = np.hypot(east, south)
    size = np.degrees(np.arctan2(flat, up)) / np.maximum(flat, 1e-9)
    lean: Angles = size * (south + 1j * east) * np.exp(-1j * turn)
    return lean
