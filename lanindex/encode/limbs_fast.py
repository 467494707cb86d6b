"""Stages 0 and 1, compiled (extra ``fast``): curves of parts, resampled, turned and smoothed.

The same as `limbs` and `resample` do with numpy, which are the truth: equal numbers.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from lanindex.encode.resample import Resampling

Floats = NDArray[np.float64]


@numba.njit
def _slope(points, place):
    """Return the slope at one of many points, one-sided at the ends."""
    if place == 0:
        return points[1] - points[0]
    if place == len(points) - 1:
        return points[place] - points[place - 1]
    return (points[place + 1] - points[place - 1]) / 2.0


@numba.njit
def _resampled(points, index, weights, values):
    for frame in range(len(values)):
        place = index[frame]
        here, there = points[place], points[place + 1]
        value = here * weights[0, frame] + there * weights[1, frame]
        value += _slope(points, place) * weights[2, frame]
        values[frame] = value + _slope(points, place + 1) * weights[3, frame]


@numba.njit
def _smooth(rough, half, calm):
    last = len(rough) - 1
    for frame in range(last + 1):
        total, count = rough[frame], 1.0
        for shift in range(1, half + 1):
            if frame >= shift:
                total += rough[frame - shift]
                count += 1.0
            if frame + shift <= last:
                total += rough[frame + shift]
                count += 1.0
        calm[frame] = total / count


@numba.njit(cache=True, nogil=True)
def _curves(places, ends, index, weights, sine, cosine, half, curves):
    """Write curves (3, P, N) of places (3, K, S); without an index each frame is one of theirs."""
    frames = curves.shape[2]
    points, rough = np.empty(places.shape[2]), np.empty((3, frames))
    half = min(half, frames - 1)
    for part in range(ends.shape[1]):
        for axis in range(3):
            child, parent = places[axis, ends[1, part]], places[axis, ends[0, part]]
            for frame in range(len(points)):
                points[frame] = child[frame] - parent[frame]
            if len(index):
                _resampled(points, index, weights, rough[axis])
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
    rough = np.empty(found.shape[2])
    half = min(half, len(rough) - 1)
    for axis in range(3):
        for joint in range(places.shape[1]):
            points = places[axis, joint]
            if len(index):
                _resampled(points, index, weights, rough)
            else:
                rough[:] = points
            _smooth(rough, half, found[axis, joint])


def calm(points: Floats, work: Resampling, frames: range, width: int) -> Floats:
    """Return joints resampled and smoothed: see `lanindex.encode.limbs.calm`."""
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
    """Return curves of some frames: see `lanindex.encode.limbs.curves`."""
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
