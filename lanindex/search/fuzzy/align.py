"""What the best match of a line costs that ends with each symbol, for all captures at once.

The tracks are walked side by side, all their first symbols, then all their second ones, and so on;
what is remembered is for each arrow how cheaply one may stand before it. Cost and beginning share
a number, so that the smallest is the cheapest, and of the cheapest the one that begins last.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import PASSING, STARTING, Columns
from lanindex.search.fuzzy.net import MISSING, SKIPPED, Net

Keys = NDArray[np.int64]

_SHIFT = 32
_LATEST = (1 << _SHIFT) - 1
NOTHING = 1 << 60
"""The key where no match ends."""


def cost_of(keys: Keys) -> Keys:
    """Return what matches cost, in parts of an edit."""
    return keys >> _SHIFT


def first_of(keys: Keys) -> Keys:
    """Return the rows with which matches begin."""
    return _LATEST - (keys & _LATEST)


def keys_of(costs: Keys | np.int64, first: Keys) -> Keys:
    """Return the keys of matches, of their costs and the rows with which they begin."""
    return (costs << _SHIFT) + _LATEST - first


def align(net: Net, columns: Columns, costs: list[Keys], most: int) -> Keys:
    """Return the best match that ends with each symbol.

    Parameters
    ----------
    net : Net
        The line; no stay.
    columns : Columns
        Of its part.
    costs : list of ndarray
        By step: (S,) what each symbol costs as that one.
    most : int
        What a match may cost.

    Returns
    -------
    ndarray
        (S,) int64 keys, for `cost_of` and `first_of`; `NOTHING` where none ends.
    """
    lengths = np.diff(columns.bounds)
    order = np.argsort(-lengths, kind="stable")
    begins = columns.bounds[:-1][order]
    longest = int(lengths.max(initial=0))
    count = np.searchsorted(-lengths[order], -np.arange(longest), side="left")
    found = np.full(len(columns), NOTHING, np.int64)
    waiting = np.full((len(net.edges), len(lengths)), NOTHING, np.int64)
    for position in range(longest):
        rows = begins[: count[position]] + position
        cells = columns.cell[rows]
        here = waiting[:, : len(rows)]
        here[:, cells & STARTING != 0] = NOTHING  # a track begins anew behind a gap
        arrived = _arrived(net, rows, here, costs, most)
        best = np.full(len(rows), NOTHING, np.int64)
        for state, keys in enumerate(arrived):
            np.minimum(best, keys + (net.exit[state] << _SHIFT), out=best)
        found[rows] = _within(best, most)
        _wait(net, here, arrived, cells & PASSING == 0, most)
    return found


def _within(keys: Keys, most: int) -> Keys:
    return np.where(keys >> _SHIFT > most, NOTHING, keys)


def _arrived(net: Net, rows: Keys, waiting: Keys, costs: list[Keys], most: int) -> list[Keys]:
    """Return for each step the best match that stands there with these rows."""
    arrived = []
    for state, missing in enumerate(net.entry):
        keys = keys_of(np.int64(missing), rows)
        for number, (_, after, _) in enumerate(net.edges):
            if after == state:
                keys = np.minimum(keys, waiting[number])
        arrived.append(_within(keys + (costs[state][rows] << _SHIFT), most))
    return arrived


def _wait(
    net: Net, waiting: Keys, arrived: list[Keys], shown: NDArray[np.bool_], most: int
) -> None:
    """Let what stands before each arrow pass over a row, and what has arrived wait there."""
    passed = np.where(shown, SKIPPED << _SHIFT, 0)
    for number, (before, _, later) in enumerate(net.edges):
        kept = waiting[number] if later else waiting[number] + passed
        waiting[number] = np.minimum(kept, arrived[before])
    for _ in range(most // MISSING):
        for number, (before, _, _) in enumerate(net.edges):
            for other, (_, after, _) in enumerate(net.edges):
                if after == before:
                    missing = waiting[other] + (MISSING << _SHIFT)
                    np.minimum(waiting[number], missing, out=waiting[number])
    waiting[:] = _within(waiting, most)
