"""Which way lines are aligned: the plain one, or the compiled one (extra ``fast``)."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from lanindex.search.fuzzy.align import NOTHING, Ask, Keys, Rows
from lanindex.search.fuzzy.align import align as align_plainly
from lanindex.search.fuzzy.net import Net

WORTH = 30_000_000
"""Symbols times steps from which on numba's import (half a second) is risked."""

POSITION = 300
"""Symbols that the plain way aligns while it goes on by one in the longest stretch."""

AT_ONCE = 1 << 26
"""Symbols times steps and arrows after which it is asked again whether to go on."""

_FAST = "lanindex.search.fuzzy.align_fast"


def align(net: Net, rows: Rows, most: int, ask: Ask) -> Keys:
    """Return the best match that ends with each symbol, as `lanindex.search.fuzzy.align` does."""
    begins = np.flatnonzero(rows.new)
    longest = int(np.diff(np.append(begins, len(rows.new))).max(initial=0))
    work = (len(rows.new) + POSITION * longest) * len(net.states)
    found = compiled() if work >= WORTH or _FAST in sys.modules else None
    if found is None:
        return align_plainly(net, rows, most, ask)
    return align_with(found, net, rows, most, ask)


@cache
def compiled() -> Callable[..., Any] | None:
    """Load the compiled way; without numba, or a folder for its cache, there is none."""
    try:
        from lanindex.search.fuzzy import align_fast
    except (ImportError, RuntimeError):
        return None
    found: Callable[..., Any] = align_fast.aligned
    return found


def align_with(aligned: Callable[..., Any], net: Net, rows: Rows, most: int, ask: Ask) -> Keys:
    """Return the same by the compiled way."""
    found = np.full(len(rows.new), NOTHING, np.int64)
    doors = np.array(net.doors, np.int64).reshape(-1, 2)
    comes = _pairs([(door, state) for door, it in enumerate(net.comes) for state in it])
    goes = _pairs([(door, state) for state, it in enumerate(net.goes) for door in it])
    waiting = np.full(len(doors), NOTHING, np.int64)
    arrived = np.full(len(net.states), NOTHING, np.int64)
    step = max(AT_ONCE // ((len(net.states) + len(comes)) * net.rounds(most)), 1)
    for low in range(0, len(found), step):
        ask()
        aligned(
            *(rows.new, rows.shown, rows.costs, rows.blur, rows.entry, rows.exit),
            *(np.array(net.entry, np.int64), np.array(net.exit, np.int64)),
            *(doors, comes, goes, net.rounds(most), most),
            *(low, min(low + step, len(found)), waiting, arrived, found),
        )
    return found


def _pairs(pairs: list[tuple[int, int]]) -> Keys:
    return np.array(pairs, np.int64).reshape(-1, 2)
