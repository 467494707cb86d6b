"""How one curve goes, and what is told of it, compiled (extra ``fast``).

The same as `curves` does without, which are the truth: equal numbers.
"""

from __future__ import annotations

from math import hypot, sqrt

import numba
import numpy as np
from numpy.typing import NDArray

from lanindex.encoding.curves import FAINT, IDLES, MOVED, PAUSE, PLAIN, SWING, WIDTH


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


@numba.njit
def _lulls(pace, first, last, way, slow, least):
    """Return the frames, counted from the first, in which a pace stays low for long enough."""
    frames = last + 1 - first
    found = np.empty((frames // 2 + 1, 2), np.int64)
    count = start = 0
    for frame in range(frames + 1):
        if frame == frames or not way * pace[first + frame] < slow:
            if frame - start >= least and frame > start:
                found[count] = start, frame
                count += 1
            start = frame + 1
    return found[:count]


@numba.njit
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


@numba.njit
def _most(values, first, last):
    most = values[first]
    for frame in range(first, last + 1):
        most = max(most, values[frame])
    return most


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
    faint = min(max(FAINT * peak, nth(some, (plain + 1) // 2)), PLAIN / 2 * peak, rests)
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


@numba.njit
def _seen(curve, pace, first, last, low, high, rests):
    """Return from when to when a movement is seen: see `lanindex.encoding.curves.seen`."""
    own = PLAIN * _most(pace, first, last)
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
    top = first - low
    for frame in range(first - low, last - low + 1):
        if calm[frame] > calm[top]:
            top = frame
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


@numba.njit
def _slopes(curve, rate):
    """Return the central differences of a curve, one-sided at the ends, times a rate."""
    found, last = np.zeros(len(curve)), len(curve) - 1
    for frame in range(last + 1 if last else 0):
        before, after = max(frame - 1, 0), min(frame + 1, last)
        found[frame] = (curve[after] - curve[before]) / (after - before) * rate
    return found


@numba.njit
def _edges(first, last, rests, behind):
    """Return where rests part frames: (R + 1, 2), those that move."""
    edges = np.empty((len(rests) + 1, 2), np.int64)
    edges[0, 0], edges[-1, 1] = first, last
    for number in range(len(rests)):
        edges[number, 1] = first + rests[number, 0]
        edges[number + 1, 0] = min(first + rests[number, 1], behind)
    return edges


@numba.njit(cache=True, nogil=True)
def bend_parts(angle, width, rate, least):
    """Return the parts of swings, (R, 4): see `lanindex.encoding.curves._bend_parts`."""
    calm = _mean(angle, width)
    pace, fast = _slopes(calm, rate), _slopes(calm, rate)
    found, count = np.empty((len(angle), 4), np.int64), 0
    for frame in range(len(fast)):
        fast[frame] = abs(fast[frame])
    for first, last in _swings(calm, SWING):
        if abs(calm[last] - calm[first]) < SWING:
            continue
        way = 1 if calm[last] > calm[first] else -1
        rests = _lulls(pace, first, last, way, IDLES, least)
        edges = _edges(first, last, rests, last)
        for number in range(2 * len(edges) - 1):
            place = number // 2
            if number % 2:
                start, stop = edges[place, 1], edges[place + 1, 0]
                low, high = start, stop
            else:
                start, stop = edges[place]
                low = edges[place - 1, 1] if place else first
                high = edges[place + 1, 0] if place + 1 < len(edges) else last
            if start < stop:
                found[count, 0], found[count, 1] = way, stop
                found[count, 2:] = _seen(angle, fast, start, stop, low, high, IDLES / rate)
                count += 1
    return found[:count].copy()


@numba.njit
def _parts(angles, edges, first, last):
    """Write which edges are of parts that are long enough; return how many."""
    count, begin = 0, -1
    for start, stop in edges:
        if stop > start:
            begin = start if begin < 0 else begin
            if abs(angles[stop - 1] - angles[begin]) >= MOVED:
                edges[count] = begin, stop - 1
                count, begin = count + 1, -1
    if not count:
        edges[0] = first, last
    return max(count, 1)


@numba.njit(cache=True, nogil=True)
def moves(angles, width, rate, least):
    """Return from which frame to which angles go somewhere, (R, 2)."""
    aside, ahead = angles.real.copy(), angles.imag.copy()
    aside, ahead = _slopes(_mean(aside, width), rate), _slopes(_mean(ahead, width), rate)
    pace, found, count = np.empty(len(angles)), np.empty((len(angles), 2), np.int64), 0
    for frame in range(len(pace)):
        pace[frame] = hypot(aside[frame], ahead[frame])
    for first, last in _departures(angles, MOVED):
        rests = _lulls(pace, first, last, 1, PAUSE, least)
        edges = _edges(first, last + 1, rests, last + 1)
        many = _parts(angles, edges, first, last)
        for number in range(many):
            low = edges[number - 1, 1] if number else first
            high = edges[number + 1, 0] if number + 1 < many else last
            part = edges[number]
            found[count] = _seen(angles, pace, part[0], part[1], low, high, PAUSE / rate)
            count += 1
    return found[:count].copy()
