"""Stages 0 and 1, compiled (extra ``fast``): curves of parts, resampled, turned and smoothed.

The same as `limbs` and `resample` do with numpy, which are the truth: equal numbers.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from lanindex.encoding.resample import Resampling

Floats = NDArray[np.float64]


@numba.njit
def _resampled(points, index, weights, slope, values):
    """Write values between points (S), two at least, of which slopes are written, too."""
    last = len(points) - 1
    slope[0], slope[last] = points[1] - points[0], points[last] - points[last - 1]
    for place in range(1, last):
        slope[place] = (points[place + 1] - points[place - 1]) / 2.0
    here, there, rise, fall = weights
    for frame in range(len(values)):
        place = index[frame]
        value = points[place] * here[frame] + points[place + 1] * there[frame]
        value += slope[place] * rise[frame]
        values[frame] = value + slope[place + 1] * fall[frame]


@numba.njit
def _add(values, others):
    for frame in range(len(others)):
        values[frame] += others[frame]


@numba.njit
def _smooth(rough, half, calm):
    """Write the moving average; loops without a question for each frame take a quarter."""
    frames = len(rough)
    calm[:] = rough
    for shift in range(1, half + 1):
        _add(calm[shift:], rough[: frames - shift])
        _add(calm[: frames - shift], rough[shift:])
    whole = 2.0 * half + 1.0
    for frame in range(frames):
        calm[frame] /= whole - max(half - frame, 0) - max(half - (frames - 1 - frame), 0)


@numba.njit(cache=True, nogil=True)
def _curves(places, ends, index, weights, sine, cosine, half, curves):
    """Write curves (3, P, N) of places (3, K, S); without an index each frame is one of theirs."""
    frames = curves.shape[2]
    points, rough = np.empty(places.shape[2]), np.empty((3, frames))
    slope = np.empty(len(points))
    half = min(half, frames - 1)
    for part in range(ends.shape[1]):
        for axis in range(3):
            child, parent = places[axis, ends[1, part]], places[axis, ends[0, part]]
            for frame in range(len(points)):
                points[frame] = child[frame] - parent[frame]
            if len(index):
                _resampled(points, index, weights, slope, rough[axis])
            else:
                rough[axis] = points
        forward, right = rough[0], rough[2]
        for frame in range(frames):
            ahead, aside = forward[frame], right[frame]
            forward[frame] = ahead * cosine[frame] - aside * sine[frame]
            right[frame] = ahead * sine[frame] + aside * cosine[frame]
        for axis in range(3):
            _smooth(rough[axis], half, curves[axis, part])


@numba.njit(cache=True, nogil=True)
def _calm(places, index, weights, half, found):
    """Write places (3, K, S), resampled and smoothed, (3, K, N); without an index as they are."""
    rough, slope = np.empty(found.shape[2]), np.empty(places.shape[2])
    half = min(half, len(rough) - 1)
    for axis in range(3):
        for joint in range(places.shape[1]):
            points = places[axis, joint]
            if len(index):
                _resampled(points, index, weights, slope, rough)
            else:
                rough[:] = points
            _smooth(rough, half, found[axis, joint])


def calm(points: Floats, work: Resampling, frames: range, width: int) -> Floats:
    """Return joints resampled and smoothed: see `lanindex.encoding.limbs.calm`."""
    index, weights = work.weights(frames)
    found = np.empty((3, points.shape[1], len(frames)))
    _calm(np.ascontiguousarray(points.T), index, weights, width // 2, found)
    return found.transpose(1, 2, 0)


def curves(
    near: Floats,
    ends: NDArray[np.int64],
    work: Resampling,
    frames: range,
    angle: Floats,
    width: int,
) -> Floats:
    """Return curves of some frames: see `lanindex.encoding.limbs.curves`."""
    index, weights = work.weights(frames)
    found = np.empty((3, ends.shape[1], len(frames)))
    _curves(
        np.ascontiguousarray(near.T),
        ends,
        index,
        weights,
        np.sin(angle),
        np.cos(angle),
        width // 2,
        found,
    )
    return found
