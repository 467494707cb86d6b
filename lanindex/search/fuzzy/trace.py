"""Which symbols a match consists of: the alignment once more, for one match, with its way."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.search.fuzzy.net import MISSING, SKIPPED, Net


class _Way(NamedTuple):
    """A way to a step: its cost, what is not clear, and the rows with the steps they match."""

    cost: int
    blur: int
    rows: tuple[tuple[int, int], ...]


class Stretch(NamedTuple):
    """The rows of a match.

    Attributes
    ----------
    costs : ndarray
        (K, R) int16: by step, what each of the rows costs as that one.
    blur : ndarray
        (R,) what each lacks to a margin of 1, in thousandths.
    shown : ndarray
        (R,) which of them a score shows.
    entry, exit : list of int
        By step, what it costs to begin with it at the first row, and to end at the last.
    """

    costs: NDArray[np.int16]
    blur: NDArray[np.int16]
    shown: NDArray[np.bool_]
    entry: list[int]
    exit: list[int]


def trace(net: Net, rows: Stretch, most: int) -> tuple[tuple[int, int], ...]:
    """Return the best match that begins with the first of some rows and ends with the last.

    Of the cheapest it is the clearest.

    Parameters
    ----------
    net : Net
        The line; no stay.
    rows : Stretch
        The rows.
    most : int
        What it costs.

    Returns
    -------
    tuple of tuple of int
        Row, from 0, and step.
    """
    behind = np.cumsum(rows.shown)
    onto: list[list[tuple[int, int]]] = [[] for _ in net.doors]
    for near, far, steps in net.missing(most):
        onto[near].append((far, steps))
    waiting: dict[int, _Way] = {}
    arrived: dict[int, _Way] = {}
    before = 0
    for row in np.flatnonzero((rows.costs <= most).any(axis=0)).tolist():
        passed = int(behind[row] - rows.shown[row] - before) * SKIPPED  # what matches no step
        waiting = _over(net, waiting, {}, passed)
        arrived = _arrived(net, rows, row, waiting, most)
        waiting = _over(net, waiting, arrived, SKIPPED if rows.shown[row] else 0)
        waiting = _missing(onto, waiting, most)
        before = int(behind[row])
    ends = [_Way(it.cost + rows.exit[state], *it[1:]) for state, it in arrived.items()]
    return min(ends).rows


def _arrived(
    net: Net, rows: Stretch, row: int, waiting: dict[int, _Way], most: int
) -> dict[int, _Way]:
    """Return the ways that stand at each step with a row."""
    arrived = {}
    blur = int(rows.blur[row])
    for state, cost in enumerate(rows.costs[:, row].tolist()):
        ways = [waiting[door] for door in net.waits[state] if door in waiting]
        ways += [_Way(rows.entry[state], 0, ())] if row == 0 else []
        if ways and cost <= most:
            best = min(ways)
            unclear = max(best.blur, blur) if cost == 0 else best.blur
            arrived[state] = _Way(best.cost + cost, unclear, (*best.rows, (row, state)))
    return arrived


def _over(
    net: Net, waiting: dict[int, _Way], arrived: dict[int, _Way], passed: int
) -> dict[int, _Way]:
    """Return the ways that wait behind some more rows, those added that have arrived."""
    after: dict[int, _Way] = {}
    for door, (_, later) in enumerate(net.doors):
        ways = [arrived[state] for state in net.comes[door] if state in arrived]
        if door in waiting:
            held = waiting[door]
            ways.append(_Way(held.cost + (0 if later else passed), *held[1:]))
        if ways:
            after[door] = min(ways)
    return after


def _missing(
    onto: list[list[tuple[int, int]]], waiting: dict[int, _Way], most: int
) -> dict[int, _Way]:
    """Return the ways that wait once steps may be missing; none that costs too much."""
    after = dict(waiting)
    for near, way in waiting.items():
        for far, steps in onto[near]:
            missing = _Way(way.cost + MISSING * steps, *way[1:])
            after[far] = min(missing, after.get(far, missing))
    return {door: way for door, way in after.items() if way.cost <= most}
