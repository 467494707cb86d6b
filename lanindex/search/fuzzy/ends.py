"""What it costs that a match begins some way behind a clip's start, or is over before its end."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import PASSING, STARTING, Columns, Roster
from lanindex.search.fuzzy.net import FAR, SKIPPED

Whole = NDArray[np.int64]


class Ends:
    """The starts and ends of clips, for the rows of a part.

    Parameters
    ----------
    columns : Columns
        Of the part.
    roster : Roster
        The captures.
    """

    def __init__(self, columns: Columns, roster: Roster) -> None:
        self._columns = columns
        self._moves = np.flatnonzero(columns.cell & (PASSING | STARTING) == 0)
        self._starting = np.flatnonzero(columns.cell & STARTING != 0)
        self._from_start, self._to_end = np.ones((2, len(roster)), np.bool_)
        whose, begin, end = columns.gaps.T
        if len(whose):
            first = np.append(True, whose[1:] != whose[:-1])
            last = np.append(first[1:], True)
            self._from_start[whose[first]] = begin[first] == 0
            self._to_end[whose[last]] = end[last] == roster.frames[whose[last]]

    def from_start(self, rows: Whole) -> NDArray[np.int32]:
        """Return what it costs to begin with some rows, (2, R): right at the start, and behind it.

        Right at the start each shown symbol before costs as if it were passed over. With a starting
        position, or where the part is not known all the way, nothing can begin.
        """
        capture = self._captures(rows)
        begin = self._columns.bounds[capture]
        known = self._from_start[capture] & (self._columns.cell[rows] & STARTING == 0)
        known &= self._stretches(begin + 1, rows) == 0
        return _besides(known, np.searchsorted(self._moves, rows) - self._before(begin))

    def to_end(self, rows: Whole) -> NDArray[np.int32]:
        """Return what it costs to end with some rows, (2, R): right at the end, and before it."""
        capture = self._captures(rows)
        end = self._columns.bounds[capture + 1]
        known = self._to_end[capture] & (self._stretches(rows + 1, end) == 0)
        return _besides(known, self._before(end) - self._before(rows + 1))

    def _captures(self, rows: Whole) -> Whole:
        return np.searchsorted(self._columns.bounds, rows, side="right") - 1

    def _before(self, rows: Whole) -> Whole:
        return np.searchsorted(self._moves, rows)

    def _stretches(self, low: Whole, high: Whole) -> Whole:
        """Return how many stretches begin between some rows and others, half-open."""
        return np.searchsorted(self._starting, high) - np.searchsorted(self._starting, low)


def _besides(known: NDArray[np.bool_], between: Whole) -> NDArray[np.int32]:
    costs = np.minimum(between * SKIPPED, FAR)
    return np.where(known, np.stack((costs, np.zeros_like(costs))), FAR).astype(np.int32)
