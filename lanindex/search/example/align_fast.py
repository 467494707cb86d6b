"""The alignment of symbols, compiled (extra ``fast``): cell by cell, one pair after the other.

The same savings as in `align`, which is the truth; the two agree but for the last bits of sums.
"""

from __future__ import annotations

import numba
import numpy as np

from lanindex.search.example.align import PACE, REPLACED

_REPLACED, _PACE = np.float32(REPLACED), np.float32(PACE)


@numba.njit(inline="always")
def _apart(one, row, two, place):
    x = one[row, 0] - two[place, 0]
    y = one[row, 1] - two[place, 1]
    z = one[row, 2] - two[place, 2]
    return np.sqrt(x * x + y * y + z * z)


@numba.njit(cache=True, nogil=True)
def savings(
    points, sizes, paces, swings, low, high, others, widths, rhythms, sways, begin, end, found
):
    """Write the most that each pair saves behind its beginnings into `found`.

    Rows `low` to `high` of one side (points, sizes, paces, swings) go with rows `begin` to `end` of
    the other (others, widths, rhythms, sways); both have some.
    """
    longest = 1
    for lane in range(len(begin)):
        longest = max(longest, end[lane] - begin[lane])
    saved = np.empty(longest, np.float32)
    away = np.empty(longest, np.float32)
    for lane in range(len(low)):
        first, count = begin[lane], end[lane] - begin[lane]
        for place in range(count):
            saved[place] = 0
            away[place] = _apart(points, low[lane], others, first + place)
        for row in range(low[lane] + 1, high[lane]):
            corner, before = saved[0], away[0]
            away[0] = _apart(points, row, others, first)
            for place in range(1, count):
                other = first + place
                here = _apart(points, row, others, other)
                saving = sizes[row] + widths[other] - _REPLACED * (here + before)
                saving -= _PACE * abs(paces[row] - rhythms[other])
                saving -= abs(swings[row] - sways[other])
                best = max(saved[place], saved[place - 1], corner + saving)
                corner, before = saved[place], away[place]
                saved[place], away[place] = best, here
        found[lane] = saved[count - 1]
