"""Which hits stay where they may not overlap: the nearest ones, then from left to right."""

from __future__ import annotations

import numpy as np

from lanindex.search.fast.ragged import FAR, Mask, Whole, in_order, starts_of


def nearest(capture: Whole, low: Whole, high: Whole) -> Mask:
    """Return which hits start last of those of a capture that end together."""
    best: Mask = np.zeros(len(low), bool)
    order = in_order((capture, high, -low))
    new = starts_of(capture[order]) | starts_of(high[order])
    best[order[new]] = True
    return best


def from_left(capture: Whole, low: Whole, high: Whole) -> Mask:
    """Return which hits begin at or after the end of the one that stayed before them.

    Parameters
    ----------
    capture, low, high : ndarray
        (H,) in order of capture, start, end.
    """
    kept: Mask = np.zeros(len(low), bool)
    after = np.searchsorted(capture * FAR + low, capture * FAR + high)
    here = np.flatnonzero(starts_of(capture)) if len(low) else after
    while len(here):
        kept[here] = True
        behind = after[here]
        inside = behind < len(low)
        behind, here = behind[inside], here[inside]
        here = behind[capture[behind] == capture[here]]
    return kept
