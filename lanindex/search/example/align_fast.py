"""The alignment of symbols, compiled (extra ``fast``): cell by cell, one pair after the other.

The same costs as in `align`, which is the truth; the two agree but for the last bits of sums.
"""

from __future__ import annotations

import numba
import numpy as np

from lanindex.search.example.align import PACE, POSE, REPLACED

_REPLACED, _PACE, _POSE = np.float32(REPLACED), np.float32(PACE), np.float32(POSE)


@numba.njit(inline="always")
def _apart(one, row, two, place):
    x = one[row, 0] - two[place, 0]
    y = one[row, 1] - two[place, 1]
    z = one[row, 2] - two[place, 2]
    return np.sqrt(x * x + y * y + z * z)


@numba.njit(cache=True, nogil=True)
def differences(
    points, sizes, paces, swings, low, high, others, widths, rhythms, sways, begin, end, found
):
    """Write what each pair does not share into `found`.

    Rows `low` to `high` of one side (points, sizes, paces, swings) go with rows `begin` to `end` of
    the other (others, widths, rhythms, sways); both have some.
    """
    longest = 1
    for lane in range(len(begin)):
        longest = max(longest, end[lane] - begin[lane])
    cost = np.empty(longest, np.float32)
    away = np.empty(longest, np.float32)
    for lane in range(len(low)):
        first, count = begin[lane], end[lane] - begin[lane]
        row = low[lane]
        for place in range(count):
            away[place] = _apart(points, row, others, first + place)
        cost[0] = _POSE * away[0] + abs(swings[row] - sways[first])
        for place in range(1, count):
            cost[place] = cost[place - 1] + widths[first + place]
        for row in range(low[lane] + 1, high[lane]):
            corner, before = cost[0], away[0]
            cost[0] += sizes[row]
            away[0] = _apart(points, row, others, first)
            for place in range(1, count):
                other = first + place
                here = _apart(points, row, others, other)
                change = _REPLACED * (here + before)
                change += _PACE * abs(paces[row] - rhythms[other])
                change += abs(swings[row] - sways[other])
                best = min(cost[place] + sizes[row], cost[place - 1] + widths[other])
                best = min(best, corner + change)
                corner, before = cost[place], away[place]
                cost[place], away[place] = best, here
        found[lane] = cost[count - 1]
