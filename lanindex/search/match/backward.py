"""Backward: the best end of a match from each event of a line, for all captures at once.

The program is run from its end. Each event of each state gets a value: the first frame at which a
line can end that goes on from there and, of the matches that end there, the greatest fit. A line
that can go on where it could end does so: it runs on as long as it can.
"""

import numpy as np

from lanindex.search.limits import tick
from lanindex.search.match.arrays import BoolArray, IntArray, once, spread
from lanindex.search.match.batch import Batch, Events
from lanindex.search.match.follow import NONE, Transitions, begins, ends
from lanindex.search.plan import Edge, Exit, Program, components

COST_BITS = 10
"""The lowest bits of a value are its cost: what is missing to a fit of 1, in thousandths."""

_COST = (1 << COST_BITS) - 1


def value_of(end: IntArray, cost: IntArray) -> IntArray:
    """Return end and cost as one number: the smaller, the better."""
    return (end << COST_BITS) | cost


def end_of(value: IntArray) -> IntArray:
    """Return the frame of a value."""
    return value >> COST_BITS


def cost_of(value: IntArray) -> IntArray:
    """Return the cost of a value."""
    return value & _COST


def may_leave(batch: Batch, program: Program, leaving: Exit) -> BoolArray:
    """Tell at which events of its state an exit may be taken, (N,) bool."""
    state = program.states[leaving.state]
    events = batch.events(state)
    fits = np.ones(len(events), bool)
    for arrow in leaving.to_end:
        fits &= ends(batch, state, events, arrow)
    return fits


def ending_values(batch: Batch, program: Program) -> list[IntArray]:
    """Return by state the values of the events at which a line ends, `NONE` elsewhere."""
    found = []
    for state, exits in zip(program.states, program.exits, strict=True):
        events = batch.events(state)
        fits = np.zeros(len(events), bool)
        for leaving in exits:
            fits |= may_leave(batch, program, leaving)
        fits &= ~events.starting
        if state.manner != "via":
            fits &= ~events.passing
        found.append(np.where(fits, value_of(events.end, events.cost), NONE))
    return found


class Backwards:
    """The values of all events of a program's states in a batch.

    What a program remembers is left out. `end_values` are those at which it ends, by state, as from
    `ending_values`; `fits` tells by state which events a match may take, (N,) bool.
    """

    def __init__(
        self, batch: Batch, program: Program, end_values: list[IntArray], fits: list[BoolArray]
    ) -> None:
        self._batch, self._program, self._end_values = batch, program, end_values
        self.fits = fits
        # by state, (N,): the value of each event, or `NONE`
        self.values: list[IntArray] = [np.empty(0, np.int64)] * len(program.states)
        self._transitions: dict[int, Transitions] = {}
        for states in reversed(components(program)):
            if any(edge.entry.state in states for it in states for edge in program.edges[it]):
                self._solve_together(states)
            else:
                (state,) = states
                own = self._beyond(state), end_values[state], self._events(state).cost
                self.values[state] = _combined(*own)
                self.values[state][~fits[state]] = NONE

    def ahead(self, edge: Edge) -> tuple[IntArray, Transitions]:
        """Return the values that an edge enters, `NONE` if it does not, and where it leads."""
        return self._entered(edge, self.values[edge.entry.state]), self.transitions(edge)

    def transitions(self, edge: Edge) -> Transitions:
        """Return where an edge leads from each event of its state."""
        if id(edge) not in self._transitions:
            before = self._events(edge.exit.state)
            found = Transitions(self._batch, self._program, edge, before)
            self._transitions[id(edge)] = found
        return self._transitions[id(edge)]

    def _events(self, state: int) -> Events:
        return self._batch.events(self._program.states[state])

    def _entered(self, edge: Edge, values: IntArray) -> IntArray:
        """Return the values of the events of an edge's next state that it may enter, or `NONE`."""
        state = self._program.states[edge.entry.state]
        for arrow in edge.entry.from_start:
            fits = begins(self._batch, state, self._batch.events(state), arrow)
            values = np.where(fits, values, NONE)
        return values

    def _beyond(self, state: int, within: frozenset[int] = frozenset()) -> IntArray:
        """Return the best values that a state's edges lead to, but for those among some states."""
        best = np.full(len(self._events(state)), NONE)
        for edge in self._program.edges[state]:
            if edge.entry.state not in within:
                tick()
                values = self._entered(edge, self.values[edge.entry.state])
                found = self.transitions(edge).smallest(values)
                found[~may_leave(self._batch, self._program, edge.exit)] = NONE
                np.minimum(best, found, out=best)
        return best

    def _solve_together(self, states: list[int]) -> None:
        """Work out the values of states that lead to each other.

        Their events are nodes of a graph without circles, for every arrow leads on in time.
        """
        within, costs = frozenset(states), [self._events(state).cost for state in states]
        bounds = np.cumsum([0, *map(len, costs)])
        first = dict(zip(states, bounds.tolist(), strict=False))
        many, pairs = int(bounds[-1]), [np.empty((2, 0), np.int64)]
        for state in states:
            for edge in self._program.edges[state]:
                if edge.entry.state in within:
                    found, waiting = self._pairs(edge, first, many)
                    pairs, many = pairs + found, many + waiting
        none = [np.full(many - int(bounds[-1]), NONE)]
        beyond = np.concatenate([*(self._beyond(it, within) for it in states), *none])
        end_values = np.concatenate([*(self._end_values[it] for it in states), *none])
        fits = np.concatenate([*(self.fits[it] for it in states), none[0] == NONE])
        cost = np.concatenate([*costs, 0 * none[0]])
        values = _solved(np.concatenate(pairs, axis=1), beyond, end_values, cost, fits)
        for state, begin, end in zip(states, bounds, bounds[1:], strict=False):
            self.values[state] = values[begin:end]

    def _pairs(self, edge: Edge, first: dict[int, int], many: int) -> tuple[list[IntArray], int]:
        """Return pairs (2, P) of nodes that an edge joins, and how many nodes it adds to `many`.

        An open arrow leads to the first event that may follow, *or to one behind it*: nodes of
        their own stand for that, one an event, so that the graph grows with the rows alone.
        """
        tick()
        source, target, reach = (
            first[edge.exit.state],
            first[edge.entry.state],
            self.transitions(edge),
        )
        leaves = may_leave(self._batch, self._program, edge.exit)
        zeros = np.zeros(len(self._events(edge.entry.state)), np.int64)
        enters = self._entered(edge, zeros) < NONE
        groups = reach.open_groups()
        pairs = reach.outliers if groups is not None else np.stack(reach.pairs())
        pairs = pairs[:, leaves[pairs[0]] & enters[pairs[1]]]
        pairs += np.array([[source], [target]])
        if groups is None:
            return [pairs], 0
        entered = np.flatnonzero(enters)
        on = np.flatnonzero(groups[1:] == groups[:-1])
        before = np.flatnonzero((reach.low < reach.high) & leaves)
        found = [
            pairs,
            np.stack((entered + many, entered + target)),
            np.stack((on + many, on + many + 1)),
            np.stack((before + source, reach.low[before] + many)),
        ]
        return found, len(groups)


def _combined(beyond: IntArray, end_values: IntArray, cost: IntArray) -> IntArray:
    """Return the values of events of some cost, from those of going on from them."""
    on = (beyond & ~_COST) | np.maximum(beyond & _COST, cost)
    return np.where(beyond < NONE, on, end_values)


def _solved(
    pairs: IntArray, beyond: IntArray, end_values: IntArray, cost: IntArray, fits: BoolArray
) -> IntArray:
    """Return the values of nodes, (N,), from those of going on from them elsewhere.

    Nodes are settled in rounds, once all that follow them are; those that do not fit have none.
    """
    before, after = pairs[:, np.argsort(pairs[1], kind="stable")]
    bounds = np.searchsorted(after, np.arange(len(end_values) + 1))
    left = np.bincount(before, minlength=len(end_values))
    values, ready = np.full(len(end_values), NONE), np.flatnonzero(left == 0)
    while len(ready):
        tick()
        own = _combined(beyond[ready], end_values[ready], cost[ready])
        values[ready] = np.where(fits[ready], own, NONE)
        one, place = spread(bounds[ready], bounds[ready + 1])
        leading = before[place]
        np.minimum.at(beyond, leading, values[ready[one]])
        np.subtract.at(left, leading, 1)
        ready = once(leading[left[leading] == 0])
    return values
