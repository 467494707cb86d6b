"""The loops over single curves of `curves`, `arithmetic` and `places`, compiled (extra ``fast``).

They give equal numbers.
"""

from math import hypot, sqrt

import numba
import numpy as np
from numba.extending import overload, register_jitable
from numpy.typing import NDArray

from lanindex.encoding import curves
from lanindex.encoding.bends import bend_parts
from lanindex.encoding.curves import PAUSE, move_frames


@numba.njit
def nth(values, place):
    """Return the number that `place` others come before; the numbers change their places."""
    low, high, random = 0, len(values) - 1, 1
    while low < high:
        random = (random * 16807) % 2147483647  # no shape of a curve makes it slow
        pivot = values[low + random % (high - low + 1)]
        left, right = low, high
        while left <= right:
            while values[left] < pivot:
                left += 1
            while values[right] > pivot:
                right -= 1
            if left <= right:
                values[left], values[right] = values[right], values[left]
                left, right = left + 1, right - 1
        if place <= right:
            high = right
        elif place >= left:
            low = left
        else:
            break
    return values[place]


@numba.njit
def middle(values):
    """Return the median of numbers, one at least; they change their places."""
    upper = nth(values, len(values) // 2)
    return (nth(values, (len(values) - 1) // 2) + upper) / 2


Floats = NDArray[np.float64]


@numba.njit
def size(x, y, z):
    """Return the size of a vector, summed as `lanindex.encoding.arithmetic.sizes` does."""
    return sqrt(x * x + z * z + y * y)


@numba.njit
def _add(values, others):
    for frame in range(len(others)):
        values[frame] += others[frame]


@numba.njit
def _smooth(rough, half, calm):
    """Write the moving average; loops without a question for each frame take a quarter."""
    frames = len(rough)
    for frame in range(frames):
        calm[frame] = rough[frame]
    for shift in range(1, half + 1):
        _add(calm[shift:], rough[: frames - shift])
        _add(calm[: frames - shift], rough[shift:])
    whole = 2.0 * half + 1.0
    for frame in range(frames):
        calm[frame] /= whole - max(half - frame, 0) - max(half - (frames - 1 - frame), 0)


@numba.njit(cache=True, nogil=True)
def smoothed(rough, half):
    """Return the moving averages of curves, (R, N): see `lanindex.encoding.arithmetic.smooth`."""
    calm = np.empty(rough.shape)
    for row in range(len(rough)):
        _smooth(rough[row], half, calm[row])
    return calm


@numba.njit(cache=True, nogil=True)
def resampled(points, index, weights):
    """Return values between points (R, S), (R, N): see `lanindex.encoding.places.Resampling`."""
    values, slope = np.empty((len(points), len(index))), np.empty(points.shape[1])
    here, there, rise, fall = weights
    last = len(slope) - 1
    for row in range(len(points)):
        own = points[row]
        slope[0], slope[last] = own[1] - own[0], own[last] - own[last - 1]
        for place in range(1, last):
            slope[place] = (own[place + 1] - own[place - 1]) / 2.0
        for frame in range(len(index)):
            place = index[frame]
            value = own[place] * here[frame] + own[place + 1] * there[frame]
            value += slope[place] * rise[frame]
            values[row, frame] = value + slope[place + 1] * fall[frame]
    return values


@numba.njit
def _mean(curve, width):
    calm = np.empty(len(curve))
    _smooth(curve, min(width // 2, len(curve) - 1), calm)
    return calm


@numba.njit
def _slopes(curve, rate):
    """Return the central differences of a curve, one-sided at the ends, times a rate."""
    found, last = np.zeros(len(curve)), len(curve) - 1
    for frame in range(last + 1 if last else 0):
        before, after = max(frame - 1, 0), min(frame + 1, last)
        found[frame] = (curve[after] - curve[before]) / (after - before) * rate
    return found


@overload(curves.ranked)
def _ranked(values, place):
    return lambda values, place: nth(values.copy(), place)


_CALLED = (curves.begun, curves.departures, curves.lulls, curves.move_parts, curves.seen)
for _function in (*_CALLED, curves.swings, curves.turning_points, bend_parts, move_frames):
    register_jitable(_function)  # compiled with the loops below that call it, and cached with them


@numba.njit(cache=True, nogil=True)
def bend_frames(angle, degree, width, rate, least):
    """Return what `bend_parts` does, of one angle (N,)."""
    calm = _mean(angle, width)
    return bend_parts(angle, calm, _slopes(calm, rate), degree, rate, least)


@numba.njit(cache=True, nogil=True)
def moves(angles, width, rate, least):
    """Return what `lanindex.encoding.curves.moves` does."""
    pace = _slopes(_mean(angles.real.copy(), width), rate)
    ahead = _slopes(_mean(angles.imag.copy(), width), rate)
    for frame in range(len(pace)):
        pace[frame] = hypot(pace[frame], ahead[frame])
    return move_frames(angles, angles, pace, PAUSE / rate, least)
