"""One line in a batch of captures: where it nearly matches, and at what cost."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import PASSING, Columns, Roster
from lanindex.search.automaton import State
from lanindex.search.fuzzy.align import NOTHING, align, cost_of, first_of, keys_of
from lanindex.search.fuzzy.beside import Found
from lanindex.search.fuzzy.costs import MOST, substitutions
from lanindex.search.fuzzy.net import Net
from lanindex.search.fuzzy.trace import trace
from lanindex.search.language.times import Clock

NEVER = 100 * MOST
"""What a symbol costs that does not last as long as a step wants: no edit mends that."""


_ENDLESS = 1 << 40


class Line(NamedTuple):
    """A line's net in a batch.

    Attributes
    ----------
    net : Net
        The line.
    columns : Columns
        Of its part.
    costs : list of ndarray
        By step: (S,) what each symbol costs as that one.
    keys : ndarray
        (S,) the best match that ends with each symbol.
    """

    net: Net
    columns: Columns
    costs: list[NDArray[np.int64]]
    keys: NDArray[np.int64]

    @classmethod
    def of(cls, net: Net, columns: Columns, roster: Roster, most: int) -> Line:
        """Return a line whose matches cost no more than they may."""
        costs = [substitutions(state, 0, columns) for state in net.states]
        for state, own in zip(net.states, costs, strict=True):
            own[~_lasting(state, columns, roster)] = NEVER
        if not net.stays:
            return cls(net, columns, costs, align(net, columns, costs, most))
        within = (costs[0] <= most) & (columns.cell & PASSING == 0)
        keys = keys_of(costs[0], np.arange(len(columns)))
        return cls(net, columns, costs, np.where(within, keys, NOTHING))

    @property
    def captures(self) -> NDArray[np.bool_]:
        """In which captures it matches: (C,)."""
        ends = np.flatnonzero(self.keys != NOTHING)
        matched = np.zeros(len(self.columns.bounds) - 1, np.bool_)
        matched[np.searchsorted(self.columns.bounds, ends, side="right") - 1] = True
        return matched

    def within(self, capture: int, frames: int) -> Found:
        """Return its matches in one capture, the best one from each row where some begin."""
        begin, end = self.columns.bounds[capture : capture + 2].tolist()
        last = np.flatnonzero(self.keys[begin:end] != NOTHING)
        keys = self.keys[begin:end][last]
        first, cost = first_of(keys) - begin, cost_of(keys)
        start, stop = (
            column[begin:end].astype(np.int64) for column in (self.columns.start, self.columns.stop)
        )
        leaves = _leaving(self.columns, capture, frames)
        if self.net.stays:
            arrives = np.where(start == stop, start, stop - 1)[last]
            found = Found(arrives, leaves[last], cost, first, last, last < 0)
            return found.chosen(found.start < found.until)
        alone = (first == last) & (start == stop)[last]
        until = np.where(alone, np.maximum(leaves[last], start[last] + 1), stop[last])
        return Found(start[first], until, cost, first, last, alone).cheapest()

    def rows(self, capture: int, first: int, last: int) -> tuple[tuple[int, bool], ...]:
        """Return the rows of a match, from the track's first one on, and whether each fits."""
        begin = int(self.columns.bounds[capture])
        rows = slice(begin + first, begin + last + 1)
        costs = [own[rows].tolist() for own in self.costs]
        if self.net.stays:
            return ((first, costs[0][0] == 0),)
        shown = (self.columns.cell[rows] & PASSING == 0).tolist()
        return tuple(
            (first + row, costs[state][row] == 0) for row, state in trace(self.net, costs, shown)
        )


def clock_of(rate: NDArray[np.int64], speed: NDArray[np.int64]) -> Clock:
    """Return the clock of a capture, of its rate and speed as a roster holds them."""
    return Clock(Fraction(*rate.tolist()), Fraction(*speed.tolist()) / 60)


def _lasting(state: State, columns: Columns, roster: Roster) -> NDArray[np.bool_]:
    """Return which symbols last as long as a step wants; a starting position has no length."""
    if state.length is None:
        return np.ones(len(columns), np.bool_)
    clocks, which = np.unique(np.hstack([roster.rate, roster.speed]), axis=0, return_inverse=True)
    bounds = [state.length.bounds(clock_of(clock[:2], clock[2:])) for clock in clocks]
    limits = np.array([(least, _ENDLESS if most is None else most) for least, most in bounds])
    least, most = np.repeat(limits.reshape(-1, 2)[which], np.diff(columns.bounds), axis=0).T
    frames = columns.stop.astype(np.int64) - columns.start
    lasting: NDArray[np.bool_] = (frames > 0) & (least <= frames) & (frames <= most)
    return lasting


def _leaving(columns: Columns, capture: int, frames: int) -> NDArray[np.int64]:
    """Return when the part leaves what each row of a capture shows: (N,) frames."""
    begin, end = columns.bounds[capture : capture + 2].tolist()
    start = columns.start[begin:end].astype(np.int64)
    shown = np.flatnonzero(columns.cell[begin:end] & PASSING == 0)
    after = np.searchsorted(shown, np.arange(len(start)), side="right")
    leaves = np.append(start[shown], frames)[after]
    known = columns.gaps[columns.gaps[:, 0] == capture]
    ends = known[:, 2].astype(np.int64) if len(known) else np.array([frames])
    inside = np.minimum(np.searchsorted(ends, start, side="right"), len(ends) - 1)
    found: NDArray[np.int64] = np.minimum(leaves, ends[inside])
    return found
