"""What each hand is nearest to, compiled (extra ``fast``).

The numbers are equal to those of `touch`.
"""

from math import sqrt

import numba
import numpy as np

from lanindex.encoding.curves_fast import size
from lanindex.encoding.touch import CLASPED, FAR, LEAVES, NEVER, Flags, Floats, Near, Plan, empty


@numba.njit(error_model="numpy")
def _look(points, ends, reach, ways, away, along):
    """Write a palm's distance from a line, divided by reach, and the position on the line.

    Separate loops, and divisions as numpy's, let the processor work on several frames at once.
    """
    palm, one, two = ends
    frames = len(away)
    for axis in range(3):
        for frame in range(frames):
            ways[axis, frame] = points[axis, palm, frame] - points[axis, one, frame]
        for frame in range(frames):
            ways[axis + 3, frame] = points[axis, two, frame] - points[axis, one, frame]
    for frame in range(frames):
        a, b, c = ways[0, frame], ways[1, frame], ways[2, frame]
        d, e, f = ways[3, frame], ways[4, frame], ways[5, frame]
        share = (a * d + c * f + b * e) / max(d * d + f * f + e * e, 1e-9)
        share = min(max(share, 0.0), 1.0)
        away[frame] = size(a - share * d, b - share * e, c - share * f) / reach
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
def _nearest(points, lines, reaches, off, rate, leaves, most, what, apart, pace):
    frames = points.shape[2]
    ways, away, share = np.empty((6, frames)), np.empty(frames, np.float32), np.empty(frames)
    nearest, along = np.empty((3, frames), np.int64), np.empty((3, frames))
    for number in range(lines.shape[1]):
        near, code, _, _, _, unless = lines[:, number]
        if unless == NEVER:
            what[near], apart[near], nearest[near], along[near] = code, most, number, 0.0
            continue
        _look(points, lines[2:5, number], reaches[number], ways, away, share)
        if number == 1:
            for frame in range(frames):
                off[CLASPED, frame] = away[frame] < leaves
        for frame in range(frames):
            if away[frame] < apart[near, frame] and not off[unless, frame]:
                what[near, frame], apart[near, frame] = code, away[frame]
                nearest[near, frame], along[near, frame] = number, share[frame]
    for near in range(3):
        _past(points, lines, nearest[near], along[near], apart[near], rate, most, pace[near])


def nearest(points: Floats, plan: Plan, off: Flags, rate: float) -> Near:
    """Return what hands are nearest to: see `lanindex.encoding.touch.nearest`."""
    found = empty(points.shape[2])
    _nearest(points, plan.lines, plan.reaches, off, rate, LEAVES, float(FAR), *found)
    return found
