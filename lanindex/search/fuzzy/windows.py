"""Which symbols need to be aligned at all: those near some that cost little.

Of a match that may cost so much, one step of some few must be there for its share of that: rows
where none is are left out, and of the others only what a match around them can cover is aligned.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.search.fuzzy.costs import Kinds
from lanindex.search.fuzzy.net import MISSING, SKIPPED, Net

IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
Costs = NDArray[np.int16]

TILE = 512
"""Rows of a long track that are aligned as a stretch of their own, where matches are short."""

BLOCK = 1 << 18
"""Rows that are aligned at once."""

FEW = 4
"""How many times its rows a part must have, that windows around them are worth it."""


class Windows(NamedTuple):
    """Stretches of rows to be aligned, each in one capture.

    Attributes
    ----------
    low, high : ndarray
        (N,) rows, half-open.
    take : ndarray
        (N,) the first row of each whose matches count; those before have been looked at.
    """

    low: IntArray
    take: IntArray
    high: IntArray

    def blocks(self) -> Iterator[Windows]:
        """Yield them by so many as have about `BLOCK` rows."""
        sizes = np.cumsum(self.high - self.low)
        first = 0
        while first < len(sizes):
            done = int(sizes[first - 1]) if first else 0
            last = max(int(np.searchsorted(sizes, done + BLOCK, side="right")), first + 1)
            yield Windows(*(column[first:last] for column in self))
            first = last


def wanted(net: Net, tables: list[Costs], counts: IntArray, most: int) -> BoolArray:
    """Return which kinds of symbols a match must have one of: (K,).

    Parameters
    ----------
    tables : list of ndarray
        By step: (K,) what each kind costs at least.
    counts : ndarray
        (K,) how many symbols of each kind there are.
    most : int
        What a match may cost.
    """
    steps = net.unavoidable
    choices = [np.any([table <= most for table in tables], axis=0)]
    for number in range(most // MISSING + 1, len(steps) + 1):
        # were each of so many dearer than its share, or missing, all were dearer than they may
        fits = {step: tables[step] <= most // number for step in steps}
        rarest = sorted(steps, key=lambda it: int(counts[fits[it]].sum()))[:number]
        choices.append(np.any([fits[it] for it in rarest], axis=0))
    return min(choices, key=lambda it: int(counts[it].sum()))


def around(
    kinds: Kinds, rows: IntArray, able: BoolArray, net: Net, most: int, whole: bool = False
) -> Windows:
    """Return the windows that hold every match that covers one of some rows.

    Parameters
    ----------
    rows : ndarray
        (N,) int64, growing.
    able : ndarray
        (K,) which kinds may match any of the steps.
    whole : bool
        Whether the rows are beginnings, and the windows whole stretches.
    """
    if whole or net.reach(most) is None:
        begins = kinds.stretches
        stretch = np.unique(np.searchsorted(begins, rows, side="right") - 1)
        return tiled(kinds, begins[stretch], begins[stretch + 1], net, most)
    low = _away(kinds, rows, able, -1, net, most)
    high = _away(kinds, rows, able, 1, net, most) + 1
    long = high - low >= len(net.unavoidable) - most // MISSING
    low, high = low[long], high[long]
    first = np.flatnonzero(np.append(True, low[1:] >= high[:-1])[: len(low)])
    last = np.append(first[1:], len(low))[: len(first)] - 1
    return tiled(kinds, low[first], high[last], net, most)


def tiled(kinds: Kinds, low: IntArray, high: IntArray, net: Net, most: int) -> Windows:
    """Return windows of which none is long, where matches are short."""
    if net.reach(most) is None or not (high - low > 2 * TILE).any():
        return Windows(low, low, high)
    pieces = np.maximum((high - low + TILE - 1) // TILE, 1)
    begins = np.repeat(low, pieces)
    first = np.cumsum(pieces) - pieces
    take = begins + (np.arange(len(begins)) - np.repeat(first, pieces)) * TILE
    before = take > begins
    back = take.copy()
    any_kind = np.ones(len(kinds.counts), np.bool_)
    back[before] = _away(kinds, take[before], any_kind, -1, net, most)
    return Windows(back, take, np.minimum(take + TILE, np.repeat(high, pieces)))


def _away(
    kinds: Kinds, rows: IntArray, able: BoolArray, step: int, net: Net, most: int
) -> IntArray:
    """Return the last rows, up or down, that a match can reach from some."""
    shown = ~kinds.passing
    skipped = shown & ~able
    reach = net.reach(most)
    assert reach is not None
    there = rows.copy()
    left, spare = np.full(len(rows), reach), np.full(len(rows), most // SKIPPED)
    going = np.arange(len(rows))
    while len(going):
        here = there[going]
        inside = ~kinds.begins[here + max(step, 0)]
        going, further = going[inside], here[inside] + step
        code = kinds.code[further]
        left[going] -= shown[code]
        spare[going] -= skipped[code]
        inside = (left[going] >= 0) & (spare[going] >= 0)
        going = going[inside]
        there[going] = further[inside]
    return there
