"""Ways in which lines can be with what stands beside them, and what they took of each other."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np

from lanindex.search.fast.ragged import FAR, Mask, Whole, best_of_each, in_order


class Used(NamedTuple):
    """What lines took at one state.

    Attributes
    ----------
    what : tuple of str
        Manner and part.
    first, last : ndarray
        (N,) rows; the last before the first: nothing.
    """

    what: tuple[str, str]
    first: Whole
    last: Whole

    def at(self, chosen: Whole | Mask) -> Used:
        """Return what some of them took."""
        return Used(self.what, self.first[chosen], self.last[chosen])


def apart(own: tuple[Used, ...], other: tuple[Used, ...]) -> Mask:
    """Tell which pairs of lines have taken nothing in common, one line of each on either side."""
    clash = np.zeros(len(own[0].first), bool)
    for one, another in product(own, other):
        if one.what == another.what:
            some = (one.first <= one.last) & (another.first <= another.last)
            clash |= some & (one.first <= another.last) & (another.first <= one.last)
    return ~clash


def stacked(tables: list[tuple[tuple[Used, ...], int]]) -> tuple[Used, ...]:
    """Return what the lines of several tables took, of which one has so many."""
    total, begin, found = sum(many for _, many in tables), 0, []
    for used, many in tables:
        for it in used:
            first, last = np.zeros(total, np.int64), np.full(total, -1)
            first[begin : begin + many], last[begin : begin + many] = it.first, it.last
            found.append(Used(it.what, first, last))
        begin += many
    return tuple(found)


@dataclass(slots=True, eq=False)
class Ways:
    """Ways in which lines can be with what stands beside them.

    Attributes
    ----------
    line, low, high : ndarray
        (N,) of which line, and the hull.
    used : tuple of Used
        What those beside it took.
    """

    line: Whole
    low: Whole
    high: Whole
    used: tuple[Used, ...] = ()

    def at(self, chosen: Whole | Mask) -> Ways:
        """Return some of them."""
        used = tuple(it.at(chosen) for it in self.used)
        return Ways(self.line[chosen], self.low[chosen], self.high[chosen], used)


def smallest(line: Whole, low: Whole, high: Whole) -> tuple[Whole, Whole, Whole]:
    """Return the hulls of each line that hold no other one of its own, in order of the lines."""
    if (line[1:] > line[:-1]).all():
        return line, low, high
    order = in_order((line, high, -low))
    line, low, high = line[order], low[order], high[order]
    best = np.maximum.accumulate(line * FAR + low)
    kept = np.ones(len(line), bool)
    kept[1:] = (line[1:] * FAR + low[1:]) > best[:-1]
    return line[kept], low[kept], high[kept]


def reduced(ways: Ways) -> Ways:
    """Return ways without those that another one is better than: of what took the same."""
    if not ways.used:
        return Ways(*smallest(ways.line, ways.low, ways.high))
    rows = tuple(column for it in ways.used for column in it[1:])
    return ways.at(best_of_each((ways.line, ways.low, ways.high, *rows), ()))


def united(tables: list[Ways]) -> Ways:
    """Return the ways of several tables, in order of their lines."""
    line, low, high = (
        np.concatenate([getattr(it, name) for it in tables]) for name in ("line", "low", "high")
    )
    used = stacked([(it.used, len(it.line)) for it in tables])
    return Ways(line, low, high, used).at(np.argsort(line, kind="stable"))
