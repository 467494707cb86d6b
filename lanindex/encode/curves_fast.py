"""How one curve goes, compiled (extra ``fast``).

The same as `curves`, `onset` and `limbs.smooth` do with numpy, which are the truth: equal numbers.
"""

from __future__ import annotations

from math import sqrt

import numba
import numpy as np
from numpy.typing import NDArray

from lanindex.encode.curves import Ends, Floats
from lanindex.encode.limbs_fast import _smooth
from lanindex.encode.onset import FAINT, PLAIN, WIDTH


@numba.njit(cache=True, nogil=True)
def _mean(curve, width):
    calm = np.empty(len(curve))
    _smooth(curve, min(width // 2, len(curve) - 1), calm)
    return calm


def mean(curve: Floats, width: int) -> Floats:
    """Return the centred moving average: see `lanindex.encode.curves.mean`."""
    found: Floats = _mean(np.ascontiguousarray(curve), width)
    return found


@numba.njit(cache=True, nogil=True)
def _swings(curve, least):
    found = np.empty((len(curve), 2), np.int64)
    count = anchor = best = 0
    last = len(curve) - 1
    for frame in range(1, last + 1):
        if frame < last:
            before, after = curve[frame] - curve[frame - 1], curve[frame + 1] - curve[frame]
            if np.sign(before) == np.sign(after):
                continue
        way, now = curve[best] - curve[anchor], curve[frame] - curve[anchor]
        if now * way >= 0 and abs(now) >= abs(way):
            best = frame
        elif abs(curve[frame] - curve[best]) >= least:
            if best > anchor:
                found[count] = anchor, best
                count += 1
            anchor, best = best, frame
    if best > anchor:
        found[count] = anchor, best
        count += 1
    return found[:count]


def swings(curve: Floats, least: float) -> list[Ends]:
    """Return from where to where a curve goes one way: see `lanindex.encode.curves.swings`."""
    return [(start, stop) for start, stop in _swings(curve, least).tolist()]


@numba.njit(cache=True, nogil=True)
def _lulls(pace, slow, least):
    found = np.empty((len(pace) // 2 + 1, 2), np.int64)
    count = start = 0
    for frame in range(len(pace) + 1):
        if frame == len(pace) or not pace[frame] < slow:
            if frame - start >= least and frame > start:
                found[count] = start, frame
                count += 1
            start = frame + 1
    return found[:count]


def lulls(pace: Floats, slow: float, least: int) -> list[Ends]:
    """Return where a pace stays below another: see `lanindex.encode.curves.lulls`."""
    return [(start, stop) for start, stop in _lulls(pace, slow, least).tolist()]


@numba.njit(cache=True, nogil=True)
def _departures(angles, least):
    found = np.empty((len(angles), 2), np.int64)
    count = anchor = best = 0
    here = far = angles[0]
    reach = 0.0
    for frame in range(len(angles)):
        angle = angles[frame]
        away = abs(angle - here)
        if away >= reach:
            best, far, reach = frame, angle, away
        elif abs(angle - far) >= least:
            if reach >= least:
                found[count] = anchor, best
                count += 1
            anchor, here = best, far
            best, far, reach = frame, angle, abs(angle - here)
    if reach >= least:
        found[count] = anchor, best
        count += 1
    return found[:count]


def departures(angles: NDArray[np.complex128], least: float) -> list[Ends]:
    """Return from where to where angles go away: see `lanindex.encode.curves.departures`."""
    return [(start, stop) for start, stop in _departures(angles, least).tolist()]


@numba.njit
def _begun(pace, at, step, count, part, rests):
    """Return when a movement begins in `count` frames, of which the first is `at`."""
    peak = pace[at + step * part]
    for frame in range(part + 1, count):
        peak = max(peak, pace[at + step * frame])
    if peak <= 0:
        return 0.0
    plain = part
    while pace[at + step * plain] < PLAIN * peak:
        plain += 1
    some = np.empty(plain + 1)
    for frame in range(plain + 1):
        some[frame] = pace[at + step * frame]
    some.sort()
    faint = min(max(FAINT * peak, some[(plain + 1) // 2]), PLAIN / 2 * peak, rests)
    last = plain - 1
    while last >= 0 and pace[at + step * last] > faint:
        last -= 1
    if last < 0:
        return 0.0
    clear, then = min(faint * PLAIN / FAINT, peak), last + 1
    while pace[at + step * then] < clear:
        then += 1
    low, over = pace[at + step * last], pace[at + step * (last + 1)]
    under, high = pace[at + step * (then - 1)], pace[at + step * then]
    one = last + (faint - low) / (over - low)
    two = then - (high - clear) / (high - under)
    return max(one - (two - one) * FAINT / (PLAIN - FAINT), 0.0)


@numba.njit(cache=True, nogil=True)
def _seen(curve, pace, first, last, low, high, rests):
    own = PLAIN * pace[first : last + 1].max()
    one = two = -1
    for frame in range(first, last + 1):
        if pace[frame] >= own:
            one, two = frame if one < 0 else one, frame
    half = max(int(np.rint(WIDTH / 2 * (two - one))), 1)
    way = curve[last] - curve[first]
    size = max(sqrt(way.real * way.real + way.imag * way.imag), 1e-9)
    count = high - low + 1
    along, calm = np.empty(count), np.empty(count)
    for frame in range(count):
        point = curve[low + frame]
        along[frame] = point.real * (way.real / size) + point.imag * (way.imag / size)
    for frame in range(count):
        on, back = min(frame + half, count - 1), max(frame - half, 0)
        calm[frame] = (along[on] - along[back]) / (2 * half)
    top = first - low + int(calm[first - low : last - low + 1].argmax())
    begin = _begun(calm, 0, 1, top + 1, first - low, rests)
    end = count - 1 - _begun(calm, count - 1, -1, count - top, high - last, rests)
    lowest, highest = top, top
    for frame in range(top, -1, -1):
        if along[frame] < along[lowest]:
            lowest = frame
    for frame in range(top, count):
        if along[frame] > along[highest]:
            highest = frame
    starts = min(max(int(np.rint(begin)), lowest), count - 2)
    stops = min(int(np.rint(end)), highest)
    return low + starts, low + max(stops, starts + 1)


def seen(
    curve: NDArray[np.float64] | NDArray[np.complex128],
    pace: Floats,
    part: Ends,
    within: Ends,
    rests: float,
) -> Ends:
    """Return from when to when a movement is seen: see `lanindex.encode.onset.seen`."""
    start, stop = _seen(curve, pace, *part, *within, rests)
    return int(start), int(stop)
