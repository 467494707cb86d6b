"""Which matches of another line go with those of the leading one, in all captures at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.search.fuzzy.align import Ask
from lanindex.search.fuzzy.lines import LIFTED, Found
from lanindex.search.match.arrays import smallest_in

Whole = NDArray[np.int64]

NOBODY = 1 << 62
"""The place of the one that goes with a match, where none does."""

PAIRS = 1 << 20
"""Pairs that are compared at once."""


class Limits(NamedTuple):
    """How exactly edges must agree, and how many frames may lie between; (N,) by leading match.

    Without a limit of its own a line shares a frame where `most` is -1.
    """

    slack: Whole
    least: Whole
    most: Whole


class Others:
    """The matches of another line, by how good they are: the cheapest, of these the first over.

    Parameters
    ----------
    found : Found
        The matches.
    ask : callable
        Is asked now and then whether to go on.
    """

    def __init__(self, found: Found, ask: Ask) -> None:
        self.best = np.lexsort((found.until, found.cost))
        self._ask = ask
        order = np.lexsort((found.start, found.capture))
        places = np.empty(len(order), np.int64)
        places[self.best] = np.arange(len(order))
        lifted = found.capture * LIFTED
        self._start, self._until = lifted[order], lifted[order] + found.until[order]
        self._start = self._start + found.start[order]
        self._place = places[order]
        self._sizes = np.frexp((self._until - self._start).astype(np.float64))[1]
        by_end = np.argsort(lifted + found.until, kind="stable")
        self._ends, self._place_of_end = (lifted + found.until)[by_end], places[by_end]

    def starting(self, low: Whole, high: Whole) -> Whole:
        """Return the place of the best one that begins in each stretch of frames, both included."""
        return _best(self._start, self._place, low, high)

    def ending(self, low: Whole, high: Whole) -> Whole:
        """Return the place of the best one that is over in each stretch of frames."""
        return _best(self._ends, self._place_of_end, low, high)

    def covering(self, start: tuple[Whole, Whole], until: tuple[Whole, Whole]) -> Whole:
        """Return the place of the best one with both its start and its end in such stretches.

        Those of about one length are looked at together: few others begin where they might.
        """
        found = np.full(len(start[0]), NOBODY)
        for size in np.unique(self._sizes).tolist():
            own = np.flatnonzero(self._sizes == size)
            begins, ends, places = self._start[own], self._until[own], self._place[own]
            low = np.searchsorted(begins, np.maximum(start[0], until[0] - (1 << max(size, 0))))
            high = np.searchsorted(begins, np.minimum(start[1], until[1]), side="right")
            for lanes, pairs in _pairs(low, high):
                self._ask()
                fits = (until[0][lanes] <= ends[pairs]) & (ends[pairs] <= until[1][lanes])
                np.minimum.at(found, lanes[fits], places[pairs[fits]])
        return found


def _best(keys: Whole, places: Whole, low: Whole, high: Whole) -> Whole:
    first = np.searchsorted(keys, low)
    behind = np.maximum(np.searchsorted(keys, high, side="right"), first)
    return smallest_in(places, first, behind, NOBODY)


def _pairs(low: Whole, high: Whole) -> Iterator[tuple[Whole, Whole]]:
    """Yield all pairs of a range and a place in it, for ranges ``[low, high)``, some at once."""
    sizes = np.maximum(high - low, 0)
    sums = np.concatenate([[0], np.cumsum(sizes)])
    for begin in range(0, int(sums[-1]), PAIRS):
        numbers = np.arange(begin, min(begin + PAIRS, int(sums[-1])))
        lanes = np.searchsorted(sums, numbers, side="right") - 1
        yield lanes, low[lanes] + numbers - sums[lanes]


class _Lifted(NamedTuple):
    """Leading matches, in frames that tell captures apart: from where to where, and theirs."""

    start: Whole
    until: Whole
    begin: Whole
    end: Whole


def _shares(line: _Lifted, others: Others, limits: Limits) -> Whole:
    low, high = line.start - limits.most, line.until + limits.most
    low, high = np.maximum(low, line.begin), np.minimum(high, line.end)
    # what begins near enough is near enough; what begins before must last long enough
    return np.minimum(
        others.starting(low, high), others.covering((line.begin, low - 1), (low, line.end))
    )


def _inside(line: _Lifted, others: Others, limits: Limits) -> Whole:
    return others.covering((line.begin, line.start), (line.until, line.end))


def _starts(line: _Lifted, others: Others, limits: Limits) -> Whole:
    return others.starting(line.start - limits.slack, line.start + limits.slack)


def _ends(line: _Lifted, others: Others, limits: Limits) -> Whole:
    return others.ending(line.until - limits.slack, line.until + limits.slack)


def _agrees(line: _Lifted, others: Others, limits: Limits) -> Whole:
    return others.covering(
        (line.start - limits.slack, line.start + limits.slack),
        (line.until - limits.slack, line.until + limits.slack),
    )


def _behind(line: _Lifted, others: Others, limits: Limits) -> Whole:
    low = np.maximum(line.start - limits.most, line.begin)
    return others.ending(low, line.start - limits.least)


def _before(line: _Lifted, others: Others, limits: Limits) -> Whole:
    high = np.minimum(line.until + limits.most, line.end)
    return others.starting(line.until + limits.least, high)


RELATIONS: dict[str, Callable[[_Lifted, Others, Limits], Whole]] = {
    "with": _shares,
    "during": _inside,
    "starting with": _starts,
    "ending with": _ends,
    "exactly with": _agrees,
    "after": _behind,
    "before": _before,
}
"""By relation: the place of the best match of the other line that goes with each leading one."""

OUTSIDE = ("during", "after", "before")
"""Relations that add no frames to a hit."""


def partners(relation: str, found: Found, others: Found, limits: Limits, ask: Ask) -> Whole:
    """Return which match of another line goes best with each of the leading one.

    Parameters
    ----------
    relation : str
        How they must lie.
    found, others : Found
        (N,) leading matches, and those of the other line.
    limits : Limits
        By leading match.
    ask : callable
        Is asked now and then whether to go on.

    Returns
    -------
    ndarray
        (N,) places in `others`; -1: none.
    """
    table = Others(others, ask)
    begin = found.capture * LIFTED
    line = _Lifted(begin + found.start, begin + found.until, begin, begin + LIFTED - 1)
    place = RELATIONS[relation](line, table, limits)
    there = place < NOBODY
    chosen = np.full(len(place), -1)
    chosen[there] = table.best[place[there]]
    return chosen
