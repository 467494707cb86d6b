"""A line alone, for all captures at once: where a match that begins here ends.

The program is run backwards. Each event of each state gets a value: the first frame at which a
line can end that goes on from there and, of the ways that end there, the greatest fit. A line that
can go on where it could end does so: it runs on as long as it can.

Where states repeat without end, their events and what they lead to are a graph without circles,
for every arrow leads on in time; it is worked off from its ends.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lanindex.search.automaton import Edge, Exit, Program, components
from lanindex.search.match.arrays import BoolArray, IntArray, starts_of
from lanindex.search.match.batch import Batch
from lanindex.search.match.follow import NONE, Transitions, begins, ends, way_of
from lanindex.search.match.scan import Events

COST_BITS = 10
"""Of a value: the lowest ones tell what is missing to a fit of 1, in thousandths."""

_COST = (1 << COST_BITS) - 1


Ahead = tuple[IntArray, IntArray, IntArray, IntArray | None]
"""(N,) values of the events of an edge's next state; of each event before, where those that follow
begin and end: among these, or in a list of places."""


def value_of(end: IntArray, cost: IntArray) -> IntArray:
    """Return end and cost as one number: the smaller, the better."""
    return (end << COST_BITS) | cost


def end_of(value: IntArray) -> IntArray:
    """Return the frame that a value tells."""
    return value >> COST_BITS


def cost_of(value: IntArray) -> IntArray:
    """Return the cost that a value tells."""
    return value & _COST


def with_cost(value: IntArray, cost: IntArray) -> IntArray:
    """Return values that also pay this cost, if it is higher."""
    return np.where(value < NONE, (value & ~_COST) | np.maximum(value & _COST, cost), NONE)


def chosen(beyond: IntArray, own: IntArray, runs_on: bool) -> IntArray:
    """Return the values of going on, or of ending where one stands."""
    return np.where(beyond < NONE, beyond, own) if runs_on else np.minimum(beyond, own)


def may_leave(batch: Batch, program: Program, leaving: Exit) -> BoolArray:
    """Tell which events of a state may be left that way."""
    state = program.states[leaving.state]
    events = batch.events(state)
    fits = np.ones(len(events), bool)
    for arrow in leaving.to_end:
        fits &= ends(batch, state, events, arrow)
    return fits


def may_end(batch: Batch, program: Program, state: int) -> BoolArray:
    """Tell at which events of a state the line may end."""
    events = batch.events(program.states[state])
    fits = np.zeros(len(events), bool)
    for leaving in program.exits[state]:
        fits |= may_leave(batch, program, leaving)
    if program.states[state].manner != "via":
        fits &= ~events.passing
    return fits


class Backwards:
    """The values of all events of a program's states in a batch.

    Parameters
    ----------
    batch : Batch
        Where.
    program : Program
        What it remembers is left out.
    runs_on : bool
        Whether a line that can go on where it could end does so.

    Attributes
    ----------
    values : list of ndarray
        By state: (N,) int64, as from `value_of`, or `NONE`.
    beyond : list of ndarray
        By state: (N,) the value of going on from there, or `NONE`.
    """

    def __init__(self, batch: Batch, program: Program, *, runs_on: bool = True) -> None:
        self._batch, self._program, self._runs_on = batch, program, runs_on
        self.values: list[IntArray] = [np.empty(0, np.int64)] * len(program.states)
        self.beyond: list[IntArray] = list(self.values)
        for states in reversed(components(program)):
            if len(states) == 1 and not any(
                edge.entry.state == states[0] for edge in program.edges[states[0]]
            ):
                self._once(states[0])
            else:
                self._again(states)

    def own(self, state: int) -> IntArray:
        """Return the values of the events at which the line ends."""
        events = self._batch.events(self._program.states[state])
        fits = may_end(self._batch, self._program, state) & ~events.starting
        return np.where(fits, value_of(events.end, events.cost), NONE)

    def reach(self, edge: Edge, before: Events) -> Transitions:
        """Return where an edge leads from some events."""
        return Transitions(self._batch, way_of(self._program.states, edge), before)

    def entered(self, edge: Edge) -> IntArray:
        """Return the values of the events of an edge's next state, if it may enter there."""
        return self._entered(edge, self.values[edge.entry.state])

    def _entered(self, edge: Edge, values: IntArray) -> IntArray:
        state = self._program.states[edge.entry.state]
        for arrow in edge.entry.from_start:
            fits = begins(self._batch, state, self._batch.events(state), arrow)
            values = np.where(fits, values, NONE)
        return values

    def ahead(self, edge: Edge) -> Ahead:
        """Return the values that an edge enters, and which of them it leads to."""
        state = edge.exit.state
        low, high, targets = self.reach(
            edge, self._batch.events(self._program.states[state])
        ).listed()
        leaves = may_leave(self._batch, self._program, edge.exit)
        return self.entered(edge), low, np.where(leaves, high, low), targets

    def _beyond(self, state: int, within: frozenset[int] = frozenset()) -> IntArray:
        """Return the best values that a state's edges lead to, but for those among some states."""
        events = self._batch.events(self._program.states[state])
        best = np.full(len(events), NONE)
        for edge in self._program.edges[state]:
            if edge.entry.state not in within:
                found = self.reach(edge, events).smallest(self.entered(edge))
                if edge.exit.to_end:
                    found[~may_leave(self._batch, self._program, edge.exit)] = NONE
                np.minimum(best, found, out=best)
        return best

    def _once(self, state: int) -> None:
        cost = self._batch.events(self._program.states[state]).cost
        self.beyond[state] = with_cost(self._beyond(state), cost)
        self.values[state] = chosen(self.beyond[state], self.own(state), self._runs_on)

    def _again(self, states: list[int]) -> None:
        """Work out the values of states that lead to each other."""
        graph = _Graph()
        within = frozenset(states)
        for state in states:
            graph.add(state, self._batch.events(self._program.states[state]).cost)
        for state in states:
            graph.settle(state, self._beyond(state, within), self.own(state))
            events = self._batch.events(self._program.states[state])
            leaves = np.ones(len(events), bool)
            for edge in self._program.edges[state]:
                if edge.entry.state in within:
                    if edge.exit.to_end:
                        leaves = may_leave(self._batch, self._program, edge.exit)
                    entered = self._entered(edge, np.zeros(len(graph.costs[edge.entry.state]), int))
                    graph.join(edge, self.reach(edge, events), leaves, entered < NONE)
        values, beyond = graph.solve(self._runs_on)
        for state in states:
            own = slice(graph.first[state], graph.first[state] + len(graph.costs[state]))
            self.values[state], self.beyond[state] = values[own], beyond[own]


class _Graph:
    """Events of several states as nodes, and which of them follow which.

    An open arrow leads to the first event that may follow, *or to one behind it*: nodes of their
    own say that, one an event, so that the graph stays as small as the rows are many.
    """

    def __init__(self) -> None:
        self.first: dict[int, int] = {}
        self.costs: dict[int, IntArray] = {}
        self._count = 0
        self._base: list[tuple[int, IntArray, IntArray]] = []
        self._pairs: list[tuple[IntArray, IntArray]] = []

    def add(self, state: int, cost: IntArray) -> None:
        """Add a state's events."""
        self.first[state], self.costs[state] = self._count, cost
        self._count += len(cost)

    def settle(self, state: int, beyond: IntArray, own: IntArray) -> None:
        """Say what a state's events lead to outside, and where the line ends at them."""
        self._base.append((self.first[state], beyond, own))

    def join(self, edge: Edge, reach: Transitions, leaves: BoolArray, enters: BoolArray) -> None:
        """Add the pairs of events that follow each other over an edge."""
        source, target = self.first[edge.exit.state], self.first[edge.entry.state]
        groups = reach.open_groups() if edge.arrow.later else None
        if groups is None:
            before, after = reach.pairs()
            fits = leaves[before] & enters[after]
            self._pairs.append((before[fits] + source, after[fits] + target))
            return
        waiting, self._count = self._count, self._count + len(groups)
        entered = np.flatnonzero(enters)
        self._pairs.append((entered + waiting, entered + target))
        on = np.flatnonzero(groups[1:] == groups[:-1])
        self._pairs.append((on + waiting, on + waiting + 1))
        before = np.flatnonzero((reach.low < reach.high) & leaves)
        self._pairs.append((before + source, reach.low[before] + waiting))

    def solve(self, runs_on: bool) -> tuple[IntArray, IntArray]:
        """Return the values of all nodes, and those of going on from there.

        What leads nowhere is worked out first.
        """
        best, own = np.full(self._count, NONE), np.full(self._count, NONE)
        cost = np.zeros(self._count, np.int64)
        for first, beyond, ends_here in self._base:
            best[first : first + len(beyond)] = beyond
            own[first : first + len(beyond)] = ends_here
        for state, paid in self.costs.items():
            cost[self.first[state] : self.first[state] + len(paid)] = paid
        before = np.concatenate([it for it, _ in self._pairs])
        after = np.concatenate([it for _, it in self._pairs])
        order = np.argsort(after, kind="stable")
        before, after = before[order], after[order]
        bounds = np.searchsorted(after, np.arange(self._count + 1))
        left = np.bincount(before, minlength=self._count)
        last = np.flatnonzero(left == 0)
        values = np.full(self._count, NONE)
        for ready in _rounds(last, bounds, before, left):
            best[ready] = with_cost(best[ready], cost[ready])
            values[ready] = chosen(best[ready], own[ready], runs_on)
            low, counts = bounds[ready], bounds[ready + 1] - bounds[ready]
            leading = before[_places(low, counts)]
            np.minimum.at(best, leading, np.repeat(values[ready], counts))
        return values, best


def _places(low: IntArray, counts: IntArray) -> IntArray:
    begins_at = np.cumsum(counts) - counts
    return np.arange(int(counts.sum())) - np.repeat(begins_at - low, counts)


def _rounds(
    ready: IntArray, bounds: IntArray, before: IntArray, left: IntArray
) -> Iterator[IntArray]:
    """Yield the nodes all of whose followers have been yielded, round by round."""
    while len(ready):
        yield ready
        leading = before[_places(bounds[ready], bounds[ready + 1] - bounds[ready])]
        np.subtract.at(left, leading, 1)
        leading = np.sort(leading[left[leading] == 0])
        ready = leading[starts_of(leading)]
