"""Two repeats without end that mirror each other: how far on they do from each pair of symbols.

Of each symbol of the one line and each of the other it is counted how many pairs follow, one after
the other, that mirror each other. The longest of those that share a frame is what the lines run on
to; nothing shorter need be tried, and no way of either line be noted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from lanindex.alphabet import KINDS, kind_of, mirrored_part
from lanindex.model.columns import CELL
from lanindex.search.automaton import Program, State
from lanindex.search.language.clauses import Mirrors
from lanindex.search.language.query import NEXT
from lanindex.search.match.arrays import BoolArray, IntArray, best_of_each
from lanindex.search.match.batch import Batch
from lanindex.search.match.conditions import MIRRORED_CELLS, Clauses
from lanindex.search.match.hit_table import HitTable, table
from lanindex.search.match.hits import Matched, took
from lanindex.search.match.scan import Events


class Repeats(NamedTuple):
    """The steps of two lines that mirror each other, and how often each comes at least."""

    own: State
    other: State
    least: int


def repeats(clauses: Clauses, program: Program) -> Repeats | None:
    """Return what a program repeats, if it is a repeat with one beside it that mirrors it."""
    lines = [program, *(it for one in program.whole.companions for it in one.programs)]
    if clauses.rhythm or len(clauses.conditions) != 1 or len(lines) != 2:
        return None
    (condition,), (companion,) = clauses.conditions, program.whole.companions
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
    """Tell whether a line is one part's movements in a row, all alike, without end."""
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
    """Finds where repeats mirror each other.

    Parameters
    ----------
    batch : Batch
        Where.
    lines : Repeats
        As `repeats` gives them.
    """

    def __init__(self, batch: Batch, lines: Repeats) -> None:
        self._batch, self._lines = batch, lines
        self._own, self._other = batch.events(lines.own), batch.events(lines.other)
        ((part,), (beside,)) = lines.own.members, lines.other.members
        self._image = MIRRORED_CELLS[_cells(batch, part, self._own)]
        self._shown = _cells(batch, beside, self._other)
        if mirrored_part(part) != beside:
            self._shown = np.full(len(self._other), CELL + 1)  # the mirror image of none
        self._on, self._on_beside = (
            _goes_on(batch, *it) for it in ((part, self._own), (beside, self._other))
        )

    def answers(
        self, number: int, parts: list[tuple[str, ...]], tick: Callable[[], None]
    ) -> list[HitTable]:
        """Return the answers of the program, whose number it is; `parts` as in `Finder`."""
        own, other = self._own, self._other
        behind = np.searchsorted(own.capture, np.arange(len(self._batch)), "right")
        many = np.bincount(own.capture, minlength=len(self._batch))
        here, run = np.arange(len(other)), np.zeros(len(other) + 1, np.int64)
        found = [np.empty((3, 0), np.int64)]
        for back in range(1, int(many.max(initial=0)) + 1):  # each capture's last symbol first
            tick()
            here = here[many[other.capture[here]] >= back]
            event = behind[other.capture[here]] - back
            follows = run[here + 1] * (self._on[event] & self._on_beside[here])
            length = (1 + follows) * (self._image[event] == self._shown[here])
            run[here] = length
            found.append(self._longest(event, here, length))
        event, low, high = np.concatenate(found, axis=1)
        order = np.argsort(event)
        frames = low[order], high[order], np.full(len(event), -1)
        return [table(number, self._lines.own, parts, own.at(event[order]), frames)]

    def _longest(self, event: IntArray, beside: IntArray, length: IntArray) -> IntArray:
        """Return of each event the best pair of runs there is: event, low, high, (3, N)."""
        some = self._side_by_side(event, beside, length)
        event, beside, length = event[some], beside[some], length[some]
        low, high = self._frames(event, beside, length)
        best = best_of_each((event,), (-length, high, -low))
        return np.stack((event[best], low[best], high[best]))

    def _side_by_side(self, event: IntArray, beside: IntArray, length: IntArray) -> IntArray:
        """Return the places of the pairs of runs that share a frame, and are long enough.

        A starting position alone is no movement.
        """
        some = np.flatnonzero(length >= self._lines.least)
        event, beside, length = event[some], beside[some], length[some]
        own, other, last = self._own, self._other, length - 1
        fits = own.start[event] < other.end[beside + last]
        fits &= other.start[beside] < own.end[event + last]
        fits &= (length > 1) | ~(own.starting[event] | other.starting[beside])
        chosen: IntArray = some[fits]
        return chosen

    def _frames(
        self, event: IntArray, beside: IntArray, length: IntArray
    ) -> tuple[IntArray, IntArray]:
        """Return low and high of pairs of runs."""
        own, other, last = self._own, self._other, length - 1
        low = np.minimum(own.start[event], other.start[beside])
        return low, np.maximum(own.end[event + last], other.end[beside + last])

    def walk(
        self, places: Sequence[tuple[int, tuple[str, ...], tuple[int, ...], tuple[int, int]]]
    ) -> Iterator[tuple[int, tuple[tuple[int, int], Mirrored, int]]]:
        """Yield of hits in one capture which they are, and their best way; as a line does."""
        for number, (_, parts, rows, span) in enumerate(places):
            found = self._runs(parts, rows, span)
            if found and len(found.cost):
                place = int(found.cost.argmin())
                yield number, ((int(found.cost[place]), -found.length), found, place)

    def _runs(
        self, parts: tuple[str, ...], rows: tuple[int, ...], span: tuple[int, int]
    ) -> Mirrored | None:
        """Return the runs of one capture that begin with some symbol and have some frames."""
        own, other = self._own, self._other
        event = int(np.searchsorted(own.first[0], rows[0]))
        if parts != self._lines.own.members or own.first[0][event : event + 1] != rows[:1]:
            return None
        here, length = np.flatnonzero(other.start >= span[0]), 0
        cost, found = np.zeros(len(here), np.int64), (here[:0], here[:0], 0)
        while event + length < len(own) and own.end[event + length] <= span[1]:
            on = self._shown[here + length] == self._image[event + length]
            here, cost = here[on], np.maximum(cost, own.cost[event + length])[on]
            cost, length = np.maximum(cost, other.cost[here + length]), length + 1
            runs = np.full(len(here), event), here, np.full(len(here), length)
            some = self._side_by_side(*runs)
            low, high = self._frames(*(it[some] for it in runs))
            some = some[(low == span[0]) & (high == span[1])]
            if len(some):
                found = here[some], cost[some], length
            on = self._on_beside[here + length - 1] & self._on[event + length - 1]
            here, cost = here[on], cost[on]
        return Mirrored(self._batch, self._lines, event, *found)


class Mirrored(NamedTuple):
    """Runs of one symbol that have the frames of a hit, and what is missing to their fits."""

    batch: Batch
    lines_of: Repeats
    event: int
    beside: IntArray
    cost: IntArray
    length: int

    def lines(self, place: int) -> Iterator[list[Matched]]:
        """Yield what the line took, then what the one beside it took."""
        own, other, _ = self.lines_of
        for state, first in (own, self.event), (other, int(self.beside[place])):
            yield [took(self.batch, state, first + it) for it in range(self.length)]


def _cells(batch: Batch, part: str, events: Events) -> IntArray:
    """Return direction and level of some events of a part, as one number."""
    return batch.rows(part).cell[events.first[0]].astype(np.int64) & CELL


def _goes_on(batch: Batch, part: str, events: Events) -> BoolArray:
    """Tell of which events the one behind is what follows."""
    rows, row = batch.rows(part), events.first[0]
    found = np.zeros(len(row), bool)
    found[:-1] = (np.diff(rows.rank[row]) == 1) & (np.diff(rows.stretch[row]) == 0)
    return found
