"""From which states of a line the best end is enough: the matches that stand there are settled.

Of two partial matches that remember the same the one that ends first is better, as long as the
lines beside it stand beside the shorter one, too; of a line that must not happen the one that ends
last. So where no bracket is open or opens any more, and no other line could want a symbol, only the
best end is looked up. Matches that claim a symbol which another line could want go on one by one.
"""

from __future__ import annotations

import numpy as np

from lanindex.search.automaton import Edge, Program
from lanindex.search.match.arrays import BoolArray, IntArray
from lanindex.search.match.backward import Backwards, end_of, value_of
from lanindex.search.match.context import Context
from lanindex.search.match.follow import NONE
from lanindex.search.match.relations import FIRST, LAST
from lanindex.search.match.rewrites import ONLY, free_states

FEW = 4
"""Contested events a capture that are few."""

_LATEST = 1 << 31
"""More than any frame."""


class BestEnds:
    """Where the best end of a line is enough, and which that is: `FIRST`, `LAST` or `ONLY`.

    Attributes
    ----------
    free : list of bool
        By state, whether there may be best ends.
    best : list of ndarray
        By state, of each event: the value, as from `value_of`, of the best match from there that
        claims nothing more, -1: there is none.
    settled : list of bool
        By state, whether no matches, or only a few, go on one by one.
    on, ending, entered : list of ndarray
        By state, (N,) bool: from which events matches go on nevertheless, at which they may end,
        and which they may enter from a free state.
    """

    def __init__(self, context: Context, program: Program, end: str) -> None:
        self.free = free_states(program)
        for state in {it.state for it in program.entries if program.edges[it.state]}:
            # what goes on from a passing symbol may reach back before it
            begins = context.batch.events(program.states[state]).passing
            self.free[state] &= not (begins & context.alive(program)[state]).any()
        wanted = [context.wanted(program, it.number) for it in program.states]
        pairs = zip(wanted, context.alive(program), strict=True)
        few = sum((one & other).sum() for one, other in pairs) <= FEW * len(context.batch)
        starting = [context.batch.events(state).starting for state in program.states]
        if end == ONLY:
            if any(it.any() for it in wanted):
                self.free = [False] * len(self.free)
            first, last = (_best(context, program, wanted, it) for it in (FIRST, LAST))
            both = zip(first, last, strict=True)
            self.best = [np.where(end_of(one) == end_of(other), one, -1) for one, other in both]
            alive = context.alive(program)
            self.on = [(it < 0) & fits for it, fits in zip(self.best, alive, strict=True)]
            self.ending = self.on
            self.entered = [np.ones(len(it), bool) for it in self.best]
            self.settled = [
                free and not on.any() for free, on in zip(self.free, self.on, strict=True)
            ]
            return
        self.best, self.ending = _best(context, program, wanted, end), starting
        self.on = [np.zeros(len(it), bool) for it in wanted]
        if any(it.any() for it in wanted):
            self.on = [it < NONE for it in _Leading(context, program, wanted).beyond]
        self.entered = [one | other for one, other in zip(wanted, self.on, strict=True)]
        self.settled = [few and free for free in self.free]


def _best(context: Context, program: Program, wanted: list[BoolArray], end: str) -> list[IntArray]:
    """Return by state and event the values of the matches that end first, or last, -1: none."""
    found = []
    if end == FIRST and not any(it.any() for it in wanted):
        ahead = context.backwards(program).values
    else:
        ahead = _Ahead(context, program, wanted, end).values
    for values in ahead:
        told = values if end == FIRST else value_of(_LATEST - end_of(values), values * 0)
        found.append(np.where(values < NONE, told, -1))
    return found


class _Ahead(Backwards):
    """The best ends of matches that claim nothing more."""

    def __init__(
        self, context: Context, program: Program, wanted: list[BoolArray], end: str
    ) -> None:
        self._wanted, self._end = wanted, end
        super().__init__(context.batch, program)

    def own(self, state: int) -> IntArray:
        """Return the values of the events at which the line ends; for `LAST` later is less."""
        values = super().own(state)
        if self._end == FIRST:
            return values
        return np.where(values < NONE, value_of(_LATEST - end_of(values), values * 0), NONE)

    def _entered(self, edge: Edge, values: IntArray) -> IntArray:
        values = super()._entered(edge, values)
        return np.where(self._wanted[edge.entry.state], NONE, values)


class _Leading(Backwards):
    """Whether matches lead to a contested event."""

    def __init__(self, context: Context, program: Program, wanted: list[BoolArray]) -> None:
        alive = context.alive(program)
        self._wanted = [one & other for one, other in zip(wanted, alive, strict=True)]
        super().__init__(context.batch, program, runs_on=False)

    def own(self, state: int) -> IntArray:
        """Return 0 for contested events."""
        return np.where(self._wanted[state], 0, NONE)
