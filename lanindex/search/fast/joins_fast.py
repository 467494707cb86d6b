"""The loops of a search over many rows, compiled (extra ``fast``).

Each does what a function without it does, which is its test and its explanation.
"""

from __future__ import annotations

import numba
import numpy as np

from lanindex.model.columns import PASSING, STARTING

_ONE, _NONE = np.uint64(1), np.uint64(0)


@numba.njit(cache=True, nogil=True)
def in_order(cell, bounds, captures, accepts, first, last, following, found):
    """Note in which captures an order occurs, as `order.plainly` tells."""
    for place in range(len(captures)):
        pending, later, ever = _NONE, _NONE, _NONE
        for row in range(bounds[captures[place]], bounds[captures[place] + 1]):
            here = cell[row]
            shown = 0 if here & PASSING else 1
            if here & STARTING:
                pending, later = _NONE, _NONE
            accepted = accepts[here]
            active = accepted & (first[shown] | pending | later | ever)
            if shown:
                pending = _NONE
            todo, number = active, 0
            while todo:
                if todo & _ONE << np.uint64(number):
                    todo &= ~(_ONE << np.uint64(number))
                    pending |= following[0, number]
                    later |= following[1, number]
                    ever |= following[3, number]
                    more = accepted & (following[2, number] | following[3, number]) & ~active
                    active |= more
                    todo |= more
                number = (number + 1) & 63
            if active & last[shown]:
                found[place] = True
                break
