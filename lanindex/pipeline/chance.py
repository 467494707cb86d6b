"""Whether two groups differ by more than chance would have it, in many things at once.

Observations change groups by chance, again and again; what is looked for is the largest difference
in any column, each in its own spread; so intervals and p hold for all columns together.

Source: Westfall and Young (1993), *Resampling-based multiple testing*, the largest statistic.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
IntArray = NDArray[np.int64]

DRAWS, SURE, GATHERED = 999, 0.95, 400
"""How often captures change groups by chance, how sure an interval is, and how many observations
a group has at most: more captures are gathered by chance into so many."""


def gathered(group: IntArray) -> tuple[IntArray, int, IntArray]:
    """Return which observation each capture belongs to, how many there are, and each one's group.

    They are captures, or as many as `GATHERED` for a group, filled by chance.
    """
    random = np.random.default_rng(0)
    unit, sides, first = np.zeros(len(group), np.int64), [], 0
    for side in range(int(group.max()) + 1 if len(group) else 0):
        own = random.permutation(np.flatnonzero(group == side))
        many = min(len(own), GATHERED)
        unit[own] = first + np.arange(len(own)) % max(many, 1)
        sides += [side] * many
        first += many
    return unit, first, np.array(sides, np.int64)


def by_chance(values: Floats, sides: IntArray) -> tuple[Floats, Floats, Floats, float]:
    """Compare two groups, sides (U,) 0 or 1, in values (U, M) of U observations, NaN unknown.

    Returns the means (2, M), the spread (M,) of their difference, p (M,) over all columns,
    and the number of spreads within which everything stays in `SURE` of the draws.
    """
    told = np.isfinite(values)
    filled = np.where(told, values, 0.0)
    random = np.random.default_rng(0)
    drawn = np.stack([sides, *(random.permutation(sides) for _ in range(DRAWS))]).astype(float)
    numbers = np.stack((1 - drawn, drawn)) @ told.astype(float)
    sums = np.stack((1 - drawn, drawn)) @ filled
    means = np.divide(sums, numbers, out=np.zeros_like(sums), where=numbers > 0)
    count = told.sum(axis=0)
    middle = filled.sum(axis=0) / np.maximum(count, 1)
    square = np.where(told, (values - middle) ** 2, 0.0).sum(axis=0) / np.maximum(count - 1, 1)
    spread = np.sqrt(square * (1 / np.maximum(numbers[:, 0], 1)).sum(axis=0))
    both = (numbers > 0).all(axis=0)
    apart = np.where(both, np.abs(means[1] - means[0]), 0.0)
    apart = np.divide(apart, spread, out=np.zeros_like(apart), where=spread > 1e-12)
    largest = apart.max(axis=1)
    p = (largest[:, None] >= apart[0] - 1e-12).mean(axis=0)
    return means[:, 0], spread, p, float(np.quantile(largest, SURE, method="higher"))
