"""Which matches stay where they may not overlap: those that differ least."""

from __future__ import annotations

from bisect import bisect_left

import numpy as np
from numpy.typing import NDArray

from lanindex.search.fuzzy.align import Ask
from lanindex.search.fuzzy.lines import LIFTED

Whole = NDArray[np.int64]
Mask = NDArray[np.bool_]

PATIENCE = 1 << 12
"""Matches after which it is asked again whether to go on."""

ROUNDS = 24
"""How often all knots are untied at once; what is left then is gone through one by one."""


def staying(capture: Whole, low: Whole, high: Whole, rank: Whole, ask: Ask) -> Mask:
    """Return which matches stay if the best is taken first, and what overlaps it is left.

    Parameters
    ----------
    capture, low, high : ndarray
        (H,) where each is, and its frames.
    rank : ndarray
        (H,) which is the better: all different, smaller is better.
    ask : callable
        Is asked now and then whether to go on.

    Returns
    -------
    ndarray
        (H,) bool.
    """
    kept = np.zeros(len(low), np.bool_)
    begin, end = capture * LIFTED + low, capture * LIFTED + high
    left = np.argsort(begin, kind="stable")
    for _ in range(ROUNDS):
        if not len(left):
            return kept
        ask()
        # of what hangs together by overlaps the best one stays, which cuts it apart
        behind = np.maximum.accumulate(end[left])
        new = np.ones(len(left), np.bool_)
        new[1:] = begin[left[1:]] >= behind[:-1]
        first = np.flatnonzero(new)
        sizes = np.diff(np.append(first, len(left)))
        best = np.repeat(np.minimum.reduceat(rank[left], first), sizes)
        stays = left[rank[left] == best]
        kept[stays] = True
        apart = (end[left] <= np.repeat(begin[stays], sizes)) | (
            begin[left] >= np.repeat(end[stays], sizes)
        )
        left = left[apart]
    _one_by_one(kept, begin, end, left[np.argsort(rank[left])], ask)
    return kept


def _one_by_one(kept: Mask, begin: Whole, end: Whole, order: Whole, ask: Ask) -> None:
    """Mark what stays of matches in order of their rank, which overlap nothing marked yet."""
    ends: list[int] = []
    begins: list[int] = []
    for number, index in enumerate(order.tolist()):
        if not number % PATIENCE:
            ask()
        low, high = int(begin[index]), int(end[index])
        place = bisect_left(ends, low + 1)
        if place == len(begins) or begins[place] >= high:
            begins.insert(place, low)
            ends.insert(place, high)
            kept[index] = True
