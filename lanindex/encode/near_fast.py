"""What each hand is nearest to, compiled (extra ``fast``).

The same as `near` does with numpy, which is the truth: equal numbers.
"""

from __future__ import annotations

from math import cos, radians, sqrt

import numba
import numpy as np

from lanindex.encode.near import (
    CLASPED,
    FAR,
    HANGS,
    LEAVES,
    NEVER,
    RIGHT_HANGS,
    STRAIGHT,
    Floats,
    Near,
    Plan,
    empty,
)


@numba.njit
def _size(x, y, z):
    return sqrt(x * x + z * z + y * y)


@numba.njit
def _hang(points, rows, straight, cosine, hangs):
    """Write when an arm hangs beside the trunk."""
    wrist, shoulder, hip, neck = rows
    x, y, z = points
    for frame in range(len(hangs)):
        a, d = x[wrist, frame] - x[shoulder, frame], x[hip, frame] - x[neck, frame]
        b, e = y[wrist, frame] - y[shoulder, frame], y[hip, frame] - y[neck, frame]
        c, f = z[wrist, frame] - z[shoulder, frame], z[hip, frame] - z[neck, frame]
        arm, along = _size(a, b, c), a * d + c * f + b * e
        hangs[frame] = arm > straight and along > cosine * arm * _size(d, e, f)


@numba.njit(error_model="numpy")
def _look(points, ends, reach, away, along):
    """Write how far a palm is from a line, as a part of what touches, and from where on it."""
    x, y, z = points
    palm, one, two = ends
    for frame in range(len(away)):
        a, d = x[palm, frame] - x[one, frame], x[two, frame] - x[one, frame]
        b, e = y[palm, frame] - y[one, frame], y[two, frame] - y[one, frame]
        c, f = z[palm, frame] - z[one, frame], z[two, frame] - z[one, frame]
        share = (a * d + c * f + b * e) / max(d * d + f * f + e * e, 1e-9)
        share = min(max(share, 0.0), 1.0)
        away[frame] = _size(a - share * d, b - share * e, c - share * f) / reach
        along[frame] = share


@numba.njit
def _past(points, lines, line, along, apart, rate, far, pace):
    """Write how fast a palm passes what is nearest."""
    last = len(pace) - 1
    for frame in range(last + 1):
        before, after = max(frame - 1, 0), min(frame + 1, last)
        scale, share = rate / 2 if after - before == 2 else rate, along[frame]
        palm, one, two = lines[2:5, line[frame]]
        total = 0.0
        for axis in (0, 2, 1):
            curve = points[axis]
            own = (curve[palm, after] - curve[palm, before]) * scale
            first = (curve[one, after] - curve[one, before]) * scale
            other = (curve[two, after] - curve[two, before]) * scale
            past = own - (1 - share) * first - share * other
            total += past * past
        pace[frame] = far if apart[frame] == far else sqrt(total)


@numba.njit(cache=True, nogil=True)
def _nearest(points, arms, lines, reaches, rate, numbers, what, apart, pace):
    straight, cosine, leaves, far = numbers
    frames = points.shape[2]
    off = np.zeros((5, frames), np.bool_)
    for side in range(2):
        if arms[:, side].min() >= 0:
            _hang(points, arms[:, side], straight, cosine, off[RIGHT_HANGS + side])
    away, share = np.empty(frames, np.float32), np.empty(frames)
    nearest, along = np.empty((3, frames), np.int64), np.empty((3, frames))
    for number in range(lines.shape[1]):
        near, code, _, _, _, unless = lines[:, number]
        if unless == NEVER:
            what[near], apart[near], nearest[near], along[near] = code, far, number, 0.0
            continue
        _look(points, lines[2:5, number], reaches[number], away, share)
        if number == 1:
            for frame in range(frames):
                off[CLASPED, frame] = away[frame] < leaves
        for frame in range(frames):
            if away[frame] < apart[near, frame] and not off[unless, frame]:
                what[near, frame], apart[near, frame] = code, away[frame]
                nearest[near, frame], along[near, frame] = number, share[frame]
    for near in range(3):
        _past(points, lines, nearest[near], along[near], apart[near], rate, far, pace[near])


def nearest(points: Floats, told: Plan, rate: float) -> Near:
    """Return what hands are nearest to: see `lanindex.encode.near.nearest`."""
    found = empty(points.shape[2])
    numbers = np.array((STRAIGHT, cos(radians(HANGS)), LEAVES, FAR))
    _nearest(points, told.arms, told.lines, told.reaches, rate, numbers, *found)
    return found
