"""What is left of a line once it has nothing more to remember: its best end will do.

Of two ways that remember the same the one that ends first is better, wherever what stands beside
the line is there all the same; of what must not happen that is enough which ends last. So from a
state behind which no bracket opens or closes, and for all that no other line could want, only the
best end is looked up; ways that take what another line could want go on one by one.
"""

from __future__ import annotations

import numpy as np

from lanindex.search.automaton import NEGATIONS, Companion, Edge, Program
from lanindex.search.match.arrays import BoolArray, IntArray
from lanindex.search.match.backward import Backwards, end_of, reached, value_of
from lanindex.search.match.context import Context, open_groups
from lanindex.search.match.follow import NONE
from lanindex.search.match.relations import FIRST, LAST, RELATIONS

ONLY = "only"
"""Of a line that runs on, the end of the only match that it can have is enough."""

FEW = 4
"""How many things a capture that others could want are few."""

_LATEST = 1 << 31
"""More than any frame."""


def enough(program: Program) -> str | None:
    """Return which end of a leading line is enough, None: all of them are needed."""
    beside = [(RELATIONS[it.relation], it) for it in program.whole.companions]
    if program.open_ended:
        return ONLY if all(relation.holds_of_longer for relation, _ in beside) else None
    shorter = all(
        relation.holds_of_shorter and not (it.relation == "before" and it.within)
        for relation, it in beside
    )
    return FIRST if shorter else None


def enough_beside(program: Program, companion: Companion) -> str | None:
    """Return which end of a line beside another is enough, None: all of them are needed."""
    relation = RELATIONS[companion.relation]
    if program.open_ended and companion.relation not in NEGATIONS:
        return ONLY if relation.holds_of_longer_beside else None
    if companion.relation == "after" and companion.within:
        return None
    return relation.enough_beside


class BestEnds:
    """From which states of a line its best end is enough, and where that is.

    Parameters
    ----------
    context : Context
        Where; nothing is asked of labels.
    program : Program
        The line.
    end : str
        `FIRST`, `LAST` or `ONLY`.

    Attributes
    ----------
    free : list of bool
        By state, whether there may be best ends.
    best : list of ndarray
        By state, of each event: the value, as from `value_of`, of the best way that takes nothing
        more that another line could want, -1: there is none.
    settled : list of bool
        By state, whether no ways, or only a few, go on one by one.
    on, ending, entered : list of ndarray
        By state, (N,) bool: from which events ways go on nevertheless, at which they may end, and
        which they may enter from a free state.
    """

    def __init__(self, context: Context, program: Program, end: str) -> None:
        self.free = _free(program)
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
    """Return by state and event the values of ways that end first, or last, -1: there is none."""
    found = []
    if end == FIRST and not any(it.any() for it in wanted):
        ahead = context.backwards(program).values
    else:
        ahead = _Ahead(context, program, wanted, end).values
    for values in ahead:
        told = values if end == FIRST else value_of(_LATEST - end_of(values), values * 0)
        found.append(np.where(values < NONE, told, -1))
    return found


def _free(program: Program) -> list[bool]:
    """Tell from which states on no bracket is open, and none opens any more."""
    following = [sorted({edge.entry.state for edge in edges}) for edges in program.edges]
    most = 1 if program.whole.companions else 0
    inside = [len(groups) > most for groups in open_groups(program)]
    inside = [
        within or any(edge.entry.opens or edge.exit.closes for edge in edges)
        for within, edges in zip(inside, program.edges, strict=True)
    ]
    return [
        not any(inside[it] for it in {state, *reached(following, state)})
        for state in range(len(program.states))
    ]


class _Ahead(Backwards):
    """The best ends of ways that take nothing more that another line could want."""

    def __init__(
        self, context: Context, program: Program, wanted: list[BoolArray], end: str
    ) -> None:
        self._wanted, self._end = wanted, end
        super().__init__(context.batch, program)

    def own(self, state: int) -> IntArray:
        """Return the values of the events at which the line ends: the furthest least, if asked."""
        values = super().own(state)
        if self._end == FIRST:
            return values
        return np.where(values < NONE, value_of(_LATEST - end_of(values), values * 0), NONE)

    def _entered(self, edge: Edge, values: IntArray) -> IntArray:
        values = super()._entered(edge, values)
        return np.where(self._wanted[edge.entry.state], NONE, values)


class _Leading(Backwards):
    """Where ways lead to what another line could want."""

    def __init__(self, context: Context, program: Program, wanted: list[BoolArray]) -> None:
        alive = context.alive(program)
        self._wanted = [one & other for one, other in zip(wanted, alive, strict=True)]
        super().__init__(context.batch, program, runs_on=False)

    def own(self, state: int) -> IntArray:
        """Return the values of the events that another line could want."""
        return np.where(self._wanted[state], 0, NONE)
