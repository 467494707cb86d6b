"""What may carry the body, compiled (extra ``fast``).

The same as `carriers` does with numpy, which is the truth: equal flags.
"""

from __future__ import annotations

from math import inf, sqrt

import numba
import numpy as np

from lanindex.alphabet import CARRIERS
from lanindex.encoding.carriers import (
    AWAY,
    BASE,
    CROUCHES,
    HAND,
    HEIGHTS,
    HIGHER,
    KNEE,
    OTHER,
    PAIRS,
    SEAT,
    TOPPLES,
    TRUNK,
    Flags,
    Floats,
    Speeds,
)


@numba.njit
def _pace(points, joint, frame, rate):
    last = points.shape[2] - 1
    before, after = max(frame - 1, 0), min(frame + 1, last)
    scale = rate / 2 if after - before == 2 else rate
    x = (points[0, joint, after] - points[0, joint, before]) * scale
    y = (points[1, joint, after] - points[1, joint, before]) * scale
    z = (points[2, joint, after] - points[2, joint, before]) * scale
    return sqrt(x * x + z * z + y * y)


@numba.njit
def _off(points, masses, base, pairs, on, frame):
    """Return how far the body's middle is, over the ground, from what carries it."""
    middle = ahead = 0.0
    for joint in range(len(masses)):
        middle += points[0, joint, frame] * masses[joint]
        ahead += points[2, joint, frame] * masses[joint]
    found = inf
    for one, two in pairs.T:
        if on[one] and on[two]:
            x, z = points[0, base[one], frame], points[2, base[one], frame]
            a, b = points[0, base[two], frame] - x, points[2, base[two], frame] - z
            x, z = middle - x, ahead - z
            along = (x * a + z * b) / max(a * a + b * b, 1e-9)
            along = min(max(along, 0.0), 1.0)
            x, z = x - along * a, z - along * b
            found = min(found, sqrt(x * x + z * z))
    return found


@numba.njit(cache=True, nogil=True)
def _carriers(points, masses, feet, rate, speeds, heights, base, pairs, numbers, found):
    stirs, stands, slides = speeds
    higher, crouches, topples, away = numbers
    on, lies = np.empty(len(base), np.bool_), np.empty((2, len(heights)), np.bool_)
    for frame in range(points.shape[2]):
        up = points[1, :, frame]
        hips = min(up[0], up[1])
        calm = min(_pace(points, 0, frame, rate), _pace(points, 1, frame, rate))
        for row in range(len(heights)):
            high = hips if row == 0 else max(hips, up[2]) if row == 1 else up[row + 1]
            pace = calm if row < 2 else _pace(points, row + 1, frame, rate)
            lies[0, row] = high < heights[row] and pace < stands
            lies[1, row] = high < heights[row] * higher and pace < slides
        for side in range(2):
            on[side] = feet[side, frame]
            on[side + 2] = feet[side, frame] and up[len(up) - 2 + side] < away
            on[side + 4] = lies[1, side + 2]
        off = _off(points, masses, base, pairs, on, frame)
        crouched = hips < crouches and off > topples
        for state in range(2):
            own = lies[state]
            found[state, SEAT, frame] = own[0]
            found[state, TRUNK, frame] = own[1]
            found[state, KNEE, frame] = own[2] or own[3]
            found[state, HAND, frame] = (own[4] or own[5]) and off > topples / (1 + state)
            found[state, OTHER, frame] = crouched and calm < (stands if state else stirs)


def carriers(points: Floats, masses: Floats, feet: Flags, rate: float, speeds: Speeds) -> Flags:
    """Return what may carry: see `lanindex.encoding.carriers.carriers`."""
    found = np.empty((2, len(CARRIERS), points.shape[2]), bool)
    numbers = (HIGHER, CROUCHES, TOPPLES, AWAY)
    points, feet = np.ascontiguousarray(points), np.ascontiguousarray(feet)
    _carriers(points, masses, feet, rate, speeds, HEIGHTS, BASE, PAIRS, numbers, found)
    return found
