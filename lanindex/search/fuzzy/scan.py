"""Lines aligned by the compiled loops (extra ``fast``)."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import THOUSANDTHS, Columns
from lanindex.search.fuzzy.align import Ask, Keys
from lanindex.search.fuzzy.costs import Kinds
from lanindex.search.fuzzy.net import FREE, MISSING, SKIPPED, Net

POSITION = 300
"""Symbols that the plain way aligns while it goes on by one in the longest stretch."""

AT_ONCE = 1 << 25
"""Symbols times steps and arrows after which it is asked again whether to go on."""


def scan(
    fast: ModuleType,
    net: Net,
    kinds: Kinds,
    columns: Columns,
    tables: NDArray[np.int16],
    most: int,
    seeds: tuple[Keys, bool],
    ask: Ask,
) -> tuple[Keys, Keys]:
    """Return the matches of a line by the compiled way: keys and last rows.

    Parameters
    ----------
    fast : module
        The compiled loops.
    net : Net
        The line; no stay, no lengths, no changes of level, no start and no end.
    kinds, columns : Kinds, Columns
        Of its part.
    tables : ndarray
        (K, kinds) by step, what each kind costs.
    most : int
        What a match may cost.
    seeds : tuple of ndarray, bool
        Rows that matches must cover one of; or the beginnings of all stretches to be looked at.
    ask : callable
        Is asked now and then whether to go on.
    """
    bits = np.int64(1) << np.arange(len(tables))
    steps = ((tables <= most) * bits[:, None]).sum(axis=0)
    needed = int(bits[list(net.unavoidable)].sum()) if most < MISSING else 0
    part = kinds.code, kinds.begins, columns.margin, kinds.passing, steps
    reach = net.reach(most)
    numbers = -1 if reach is None else reach, most // SKIPPED, most, THOUSANDTHS, needed
    ends = np.array((net.entry[FREE], net.exit[FREE]), np.int64)
    ways = _ways(net, most)
    rows = max(AT_ONCE // (len(net.states) + sum(map(len, ways))), 1)
    keys, last, first, row = [], [], 0, 0
    while first < len(seeds[0]):
        ask()
        *found, first, row = fast.scanned(
            seeds[0], first, row, seeds[1], rows, part, tables, ends, ways, numbers
        )
        keys.append(found[0])
        last.append(found[1])
    none = np.empty(0, np.int64)
    return np.concatenate([none, *keys]), np.concatenate([none, *last])


def _ways(net: Net, most: int) -> tuple[NDArray[Any], ...]:
    """Return a net as the compiled way has it."""
    waits = np.full((2, len(net.states)), len(net.doors))  # a door that nobody waits at
    for state, doors in enumerate(net.waits):
        waits[: len(doors), state] = doors
    comes = [(door, state) for door, it in enumerate(net.comes) for state in it]
    return (
        waits,
        np.array([not later for _, later in net.doors], np.bool_),
        np.array(comes, np.int64).reshape(-1, 2),
        np.array(net.missing(most), np.int64).reshape(-1, 3),
    )
