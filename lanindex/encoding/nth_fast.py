"""The middle of some numbers, compiled (extra ``fast``): no more are put in order than need be.

numba takes seconds to compile its own sorting, anew for every kind of array.
"""

from __future__ import annotations

import numba


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
