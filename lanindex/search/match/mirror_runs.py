"""Two repeats without end that mirror each other: how far they go on from each pair of symbols.

For each symbol of the one line and each of the other, the pairs of symbols that follow and mirror
each other are counted. The longest run of those that share a frame is the match of both lines, so
that nothing shorter need be tried and no partial match of either be kept.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

import numpy as np

from lanindex.alphabet import KINDS, kind_of, mirrored_part
from lanindex.model.columns import CELL
from lanindex.search.language.clauses import Mirrors
from lanindex.search.language.query import NEXT
from lanindex.search.match.arrays import BoolArray, IntArray, best_of_each
from lanindex.search.match.batch import Batch, Events
from lanindex.search.match.conditions import MIRRORED_CELLS, Clauses
from lanindex.search.match.hits import BestTrace, HitTable, Step, parts_number, table
from lanindex.search.plan import Program, State


class Repeats(NamedTuple):
    """The steps of two lines that mirror each other, and how often each comes at least."""

    leading: State
    other: State
    least: int


def repeats(clauses: Clauses, program: Program) -> Repeats | None:
    """Return what a program repeats, if it is a repeat with one beside it that mirrors it."""
    lines = [program, *(it for one in program.outermost.companions for it in one.programs)]
    if clauses.rhythm or len(clauses.conditions) != 1 or len(lines) != 2:
        return None
    (condition,), (companion,) = clauses.conditions, program.outermost.companions
    first, second = (line.states[0] for line in lines)
    if (
        not isinstance(condition, Mirrors)
        or not all(map(_is_repeat, lines))
        or (companion.relation, companion.within) != ("with", None)
        or first.members == second.members
        or any("amount" in KINDS[kind_of(it)].fields for it in (*first.members, *second.members))
        or {condition.first, condition.second}
        not in ({one, other} for one in first.labels for other in second.labels)
    ):
        return None
    return Repeats(first, second, max(len(line.states) for line in lines))


def _is_repeat(line: Program) -> bool:
    """Return whether a line is one part's movements in a row, all alike, without end."""
    first, last = line.states[0], len(line.states) - 1
    edges = [edge for edges in line.edges for edge in edges]
    exits = [leaving for exits in line.exits for leaving in exits]
    return (
        (first.manner, len(first.members), first.names_passing) == ("move", 1, False)
        and not line.brackets
        and all(
            (it.members, it.manner, it.fits, it.length, it.labels)
            == (first.members, first.manner, first.fits, first.length, first.labels)
            for it in line.states
        )
        and [(it.exit.state, it.entry.state) for it in edges]
        == [*((number, number + 1) for number in range(last)), (last, last)]
        and all(it.arrow == NEXT and it.same for it in edges)
        and [(it.state, it.from_start) for it in line.entries] == [(0, ())]
        and [(it.state, it.to_end) for it in exits] == [(last, ())]
    )


class MirrorRuns:
    """Finds where two repeats mirror each other.

    Runs are (3, N): the first event of the one line, that of the other, how many pairs they are.
    """

    def __init__(self, batch: Batch, lines: Repeats) -> None:
        self._batch, self._lines = batch, lines
        self._leading, self._other = batch.events(lines.leading), batch.events(lines.other)
        ((part,), (beside,)) = lines.leading.members, lines.other.members
        self._image = MIRRORED_CELLS[_cells(batch, part, self._leading)]
        self._shown = _cells(batch, beside, self._other)
        if mirrored_part(part) != beside:
            self._shown = np.full(len(self._other), CELL + 1)  # the mirror image of none
        self._on, self._on_beside = (
            _is_followed(batch, *it) for it in ((part, self._leading), (beside, self._other))
        )

    def hits(self, tick: Callable[[], None]) -> HitTable:
        """Return the best match from each event of the line."""
        leading, other = self._leading, self._other
        behind = np.searchsorted(leading.capture, np.arange(len(self._batch)), "right")
        many = np.bincount(leading.capture, minlength=len(self._batch))
        here, run = np.arange(len(other)), np.zeros(len(other) + 1, np.int64)
        found = [np.empty((3, 0), np.int64)]
        for back in range(1, int(many.max(initial=0)) + 1):  # each capture's last symbol first
            tick()
            here = here[many[other.capture[here]] >= back]
            event = behind[other.capture[here]] - back
            follows = run[here + 1] * (self._on[event] & self._on_beside[here])
            length = (1 + follows) * (self._image[event] == self._shown[here])
            run[here] = length
            runs = np.stack((event, here, length))
            runs = runs[:, self._side_by_side(runs)]
            low, high = self._frames(runs)
            best = best_of_each((runs[0],), (-runs[2], high, -low))
            found.append(np.stack((runs[0], low, high))[:, best])
        event, low, high = np.concatenate(found, axis=1)
        order = np.argsort(event)
        frames = low[order], high[order], np.full(len(event), -1)
        return table(self._batch, self._lines.leading, leading.at(event[order]), frames)

    def _side_by_side(self, runs: IntArray) -> IntArray:
        """Return the places of the pairs of runs that share a frame, and are long enough.

        A starting position alone is no movement.
        """
        numbers = np.flatnonzero(runs[2] >= self._lines.least)
        event, beside, length = runs[:, numbers]
        leading, other, last = self._leading, self._other, length - 1
        fits = leading.start[event] < other.end[beside + last]
        fits &= other.start[beside] < leading.end[event + last]
        fits &= (length > 1) | ~(leading.starting[event] | other.starting[beside])
        chosen: IntArray = numbers[fits]
        return chosen

    def _frames(self, runs: IntArray) -> tuple[IntArray, IntArray]:
        """Return low and high of pairs of runs."""
        leading, other, (event, beside, length) = self._leading, self._other, runs
        low = np.minimum(leading.start[event], other.start[beside])
        return low, np.maximum(leading.end[event + length - 1], other.end[beside + length - 1])

    def traced(self, hits: HitTable) -> Iterator[tuple[int, BestTrace]]:
        """Yield the places of hits, each with the clearest match of its frames."""
        leading, bounds = (
            self._leading.first[0],
            self._batch.rows(self._lines.leading.members[0]).bounds,
        )
        rows = hits.rows[0] + bounds[hits.capture]
        events = np.searchsorted(leading, rows)
        there = np.append(leading, -1)[events] == rows
        there &= hits.parts == parts_number(self._lines.leading.members)
        for number, event in enumerate(events.tolist()):
            if there[number]:
                best = self._clearest(event, int(hits.low[number]), int(hits.high[number]))
                if best:
                    cost, beside, length = best
                    yield number, ((cost, -length), partial(self._steps, event, beside, length))

    def _clearest(self, event: int, low: int, high: int) -> tuple[int, int, int] | None:
        """Return cost, other event and length of the best runs from an event in some frames."""
        leading, other, found, length = self._leading, self._other, None, 0
        capture = leading.capture[event]
        here = np.flatnonzero((other.capture == capture) & (other.start >= low))
        cost, last = (
            np.zeros(len(here), np.int64),
            np.searchsorted(leading.capture, capture, "right"),
        )
        while event + length < last and leading.end[event + length] <= high:
            on = self._shown[here + length] == self._image[event + length]
            here, cost = here[on], np.maximum(cost, leading.cost[event + length])[on]
            cost, length = np.maximum(cost, other.cost[here + length]), length + 1
            runs = np.stack((np.full(len(here), event), here, np.full(len(here), length)))
            some = self._side_by_side(runs)
            begin, end = self._frames(runs[:, some])
            some = some[(begin == low) & (end == high)]
            if len(some):
                best = some[cost[some].argmin()]
                found = int(cost[best]), int(here[best]), length
            on = self._on_beside[here + length - 1] & self._on[event + length - 1]
            here, cost = here[on], cost[on]
        return found

    def _steps(self, event: int, beside: int, length: int) -> list[list[Step]]:
        """Return the steps of the line, then those of the one beside it."""
        return [
            [(state, first + it) for it in range(length)]
            for state, first in ((self._lines.leading, event), (self._lines.other, beside))
        ]


def _cells(batch: Batch, part: str, events: Events) -> IntArray:
    """Return direction and level of some events of a part, as one number."""
    return batch.rows(part).cell[events.first[0]].astype(np.int64) & CELL


def _is_followed(batch: Batch, part: str, events: Events) -> BoolArray:
    """Tell after which events the next one is what follows."""
    rows, row = batch.rows(part), events.first[0]
    found = np.zeros(len(row), bool)
    found[:-1] = (np.diff(rows.rank[row]) == 1) & (np.diff(rows.stretch[row]) == 0)
    return found
