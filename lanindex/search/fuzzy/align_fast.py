"""The alignment of a line with tracks, compiled (extra ``fast``): symbol by symbol.

`lanindex.search.fuzzy.align` is the truth; the two give equal keys.
"""

from __future__ import annotations

import numba
import numpy as np

from lanindex.search.fuzzy.align import BLUR, COST, FIRST, LATEST, NOTHING
from lanindex.search.fuzzy.net import MISSING, SKIPPED

_MISSING, _SKIPPED = np.int64(MISSING) << COST, np.int64(SKIPPED) << COST


@numba.njit(inline="always")
def _besides(ways, besides, state, row, most):
    """Return what it costs at least to begin, or to end, with a step at a row."""
    least = np.int64(NOTHING >> COST)
    for way in range(len(ways)):
        if ways[way, state] <= most:
            more = besides[way - 1, row] if way > 0 else 0
            least = min(least, np.int64(ways[way, state]) + more)
    return least


@numba.njit(inline="always")
def _waited(doors, goes, rounds, most, waiting):
    """Let steps be missing, and forget what costs more than it may."""
    if most >= MISSING:
        for _ in range(rounds):
            for pair in range(len(goes)):  # by the step that is left out, in order
                onto, state = goes[pair]
                for door in range(len(doors)):
                    if doors[door, 0] == state:
                        waiting[onto] = min(waiting[onto], waiting[door] + _MISSING)
    for door in range(len(doors)):
        if waiting[door] >> COST > most:
            waiting[door] = NOTHING


@numba.njit(inline="always")
def _arrive(row, costs, blur, entry, begins, doors, most, waiting, arrived):
    """Write the best match that stands at each step with a row; tell whether there is one."""
    alive = False
    for state in range(len(costs)):
        key = (_besides(entry, begins, state, row, most) << COST) + (
            np.int64(LATEST - row) << FIRST
        )
        for door in range(len(doors)):
            if doors[door, 0] == state:
                key = min(key, waiting[door])
        cost = np.int64(costs[state, row])
        key += cost << COST
        if cost == 0 and key & BLUR < blur[row]:
            key = key & ~BLUR | blur[row]
        if key >> COST > most:
            key = np.int64(NOTHING)
        arrived[state] = key
        alive |= key < NOTHING
    return alive


@numba.njit(cache=True, nogil=True)
def aligned(new, shown, costs, blur, begins, ends, entry, leave, doors, comes, goes, rounds, most,
            low, high, waiting, arrived, found):  # fmt: skip
    """Write the best match that ends with each of the rows `low` to `high` into `found`.

    `begins` and `ends` are what it costs besides to begin or end at a row, `entry` and `leave` what
    is missing before and after a step; `doors` tell the step behind each and whether what lies
    between is free, `comes` and `goes` are pairs of a door and a step: from which one comes to it,
    and to which door one goes from it. `waiting` is kept from one call to the next.
    """
    for row in range(low, high):
        if new[row]:
            waiting[:] = NOTHING
        alive = _arrive(row, costs, blur, entry, begins, doors, most, waiting, arrived)
        best = np.int64(NOTHING)
        for state in range(len(costs)):
            if arrived[state] < NOTHING:
                more = _besides(leave, ends, state, row, most) << COST
                best = min(best, arrived[state] + more)
        found[row] = best if best >> COST <= most else NOTHING
        for door in range(len(doors)):
            alive |= waiting[door] < NOTHING
            if shown[row] and not doors[door, 1]:
                waiting[door] += _SKIPPED
        if alive:
            for pair in range(len(comes)):
                door = comes[pair, 0]
                waiting[door] = min(waiting[door], arrived[comes[pair, 1]])
            _waited(doors, goes, rounds, most, waiting)
        else:
            waiting[:] = NOTHING
