"""Which symbols a match consists of: the alignment once more, for one match, with its way."""

from __future__ import annotations

from typing import NamedTuple

from lanindex.search.fuzzy.net import MISSING, SKIPPED, Net


class _Way(NamedTuple):
    """A way to a step: what it costs, and the rows with the steps that they match."""

    cost: int
    rows: tuple[tuple[int, int], ...]


def trace(net: Net, costs: list[list[int]], shown: list[bool]) -> tuple[tuple[int, int], ...]:
    """Return the cheapest match that begins with the first of some rows and ends with the last.

    Parameters
    ----------
    net : Net
        The line; no stay.
    costs : list of list of int
        By step, what each of the rows costs as that one.
    shown : list of bool
        Which of the rows a score shows.

    Returns
    -------
    tuple of tuple of int
        Row, from 0, and step.
    """
    last = len(shown) - 1
    waiting: dict[int, _Way] = {}
    arrived: dict[int, _Way] = {}
    for row in range(last + 1):
        arrived = {}
        for state, first in enumerate(net.entry):
            ways = [way for number, way in waiting.items() if net.edges[number][1] == state]
            ways += [_Way(first, ())] if row == 0 else []
            if ways:
                cost, rows = min(ways)
                arrived[state] = _Way(cost + costs[state][row], (*rows, (row, state)))
        waiting = _waited(net, waiting, arrived, SKIPPED if shown[row] else 0)
    ends = [_Way(way.cost + net.exit[state], way.rows) for state, way in arrived.items()]
    return min(ends).rows


def _waited(
    net: Net, waiting: dict[int, _Way], arrived: dict[int, _Way], passed: int
) -> dict[int, _Way]:
    """Return the ways that stand before each arrow behind one more row."""
    after: dict[int, _Way] = {}
    for number, (before, _, later) in enumerate(net.edges):
        held = waiting.get(number)
        ways = [_Way(held.cost + (0 if later else passed), held.rows)] if held else []
        ways += [arrived[before]] if before in arrived else []
        if ways:
            after[number] = min(ways)
    for _ in net.states:
        for number, (before, _, _) in enumerate(net.edges):
            for other, (_, onto, _) in enumerate(net.edges):
                if onto == before and other in after:
                    way = _Way(after[other].cost + MISSING, after[other].rows)
                    after[number] = min(after.get(number, way), way)
    return after
