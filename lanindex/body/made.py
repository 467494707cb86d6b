"""Joints that a capture lacks and others tell: weighted sums of them.

A middle of two joints or markers, or a regression that is linear in markers, is a line of a table.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

MADE: Mapping[str, Mapping[str, float]] = {
    "Pelvis": {"LHip": 0.5, "RHip": 0.5},
}
"""Joint of the body: the joints that it is made of where the file lacks it, and their shares."""


GAP = Fraction(1, 5)
"""Seconds that a joint may be unknown and is filled; longer ones stay open."""


def weighted(parts: Iterable[tuple[Floats, float]]) -> Floats:
    """Return a place made of others.

    `parts` (..., 3) float64 each, and its share; one at least; returned (..., 3) float64; NaN where
    one of them is unknown.
    """
    (first, share), *others = parts
    place = first * share
    for other, share in others:
        place += other * share
    return place
