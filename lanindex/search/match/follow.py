"""Follow: where arrows lead, from events to ranges of other events.

``->`` leads to that part's next symbol, ``...`` to a later one; to another part it leads to what
begins when the step before is over, or later. Events stand in order of their rows, so that an
arrow leads to a range of them; a pair of events follows if both of its members do.
"""

from __future__ import annotations

from functools import reduce

import numpy as np

from lanindex.search.language.query import Arrow
from lanindex.search.match.arrays import (
    FAR,
    BoolArray,
    IntArray,
    smallest_from_here,
    smallest_in,
    spread,
    starts_of,
)
from lanindex.search.match.batch import Batch, Events, Rows
from lanindex.search.plan import Edge, Entry, Program, State

NONE = 1 << 42  # a value that is none: more than any
FEW = 16  # what is less than one in so many rows is looked up, not counted

Ranges = tuple[IntArray, IntArray]
"""Ranges ``[low, high)``, (N,) each: of rows of one member, or of events."""


class Transitions:
    """Where an edge leads from some events: to those in `[low, high)` of its next state, (N,) each.

    Where the members of pairs are in different orders, or passing symbols are to follow in time,
    what follows an event is no range; then `[low, high)` are places in a list of events, `targets`.
    """

    def __init__(self, batch: Batch, program: Program, edge: Edge, before: Events) -> None:
        self._batch, self._edge, self._before = batch, edge, before
        self._source, self._target = (program.states[it.state] for it in (edge.exit, edge.entry))
        self._events = events = batch.events(self._target)
        self.targets: IntArray | None = None
        rows = [self._rows_ahead(*it) for it in enumerate(self._target.members)]
        ranges = [self._places(member, *it) for member, it in enumerate(rows)]
        frames = self._frames_ahead() if edge.arrow.length else None
        if frames:
            # rows stand in order, their first frames nearly so: these ranges may hold too much
            starts, own = events.capture * FAR + events.start, before.capture * FAR
            latest, soonest = np.maximum.accumulate(starts), np.minimum.accumulate(starts[::-1])
            first, last = (own + it for it in frames)
            low = np.searchsorted(latest, first)
            ranges.insert(0, (low, np.searchsorted(soonest[::-1], last, "right")))
        if events.ordered and not (frames and events.passing.any()):
            self.low, self.high = _common(ranges)
            return
        sources, targets = spread(*_common(ranges[: len(ranges) - len(rows) + 1]))
        fits = np.ones(len(sources), bool)
        for (low, high), first in zip(rows[1:], events.first[1:], strict=True):
            fits &= (low[sources] <= first[targets]) & (first[targets] < high[sources])
        if frames:
            first, last = frames
            start = events.start[targets]
            fits &= (first[sources] <= start) & (start <= last[sources])
        self.targets = targets[fits]
        bounds = np.searchsorted(sources[fits], np.arange(len(before) + 1))
        self.low, self.high = bounds[:-1], bounds[1:]

    def _rows_ahead(self, member: int, part: str) -> Ranges:
        """Return the rows of a member at which what follows may begin."""
        rows, (least, most) = self._batch.rows(part), self._edge.arrow.bounds
        if not len(rows):
            nothing = np.zeros(len(self._before), np.int64)
            return nothing, nothing
        ahead = self._same_part(rows, member) if self._edge.same else self._other_part(rows)
        origin, behind, stretch = ahead
        here = np.maximum(stretch, 0)
        low = np.maximum(origin, rows.row_of(behind + least)) if least else origin
        low = np.maximum(low, rows.stretch_rows[here])
        high = rows.stretch_rows[here + 1]
        if most is not None:
            high = np.minimum(high, rows.row_of(behind + most + 1))
        return low, np.where(stretch >= 0, high, 0)

    def _same_part(self, rows: Rows, member: int) -> tuple[IntArray, IntArray, IntArray]:
        """Return the first row that may follow, the shown rows up to there, the stretch."""
        row, holds = self._before.last[member], self._target.manner == "hold"
        rests = holds and self._source.manner not in ("at", "hold")
        own_rest = ~rows.passing[row] if rests else np.zeros(len(row), bool)
        behind = rows.rank[row + 1].astype(np.int64) - holds
        return row + 1 - own_rest, behind, rows.stretch[row].astype(np.int64)

    def _other_part(self, rows: Rows) -> tuple[IntArray, IntArray, IntArray]:
        """Return the same as `_same_part`; stretch -1: there is none."""
        manner, before = self._target.manner, self._before
        stretch = rows.stretch_at(before.capture, before.end)
        begun, frames = rows.beginnings(manner)
        if not len(begun):
            nothing = np.zeros(len(stretch), np.int64)
            return nothing, nothing, np.full(len(stretch), -1)
        keys = rows.stretch[begun].astype(np.int64) * FAR + frames
        place = np.searchsorted(keys, stretch * FAR + before.end)
        row = begun[np.minimum(place, len(begun) - 1)]
        found = (stretch >= 0) & (place < len(begun)) & (rows.stretch[row] == stretch)
        behind = rows.rank[row].astype(np.int64)
        origin = row if manner == "hold" else rows.row_of(behind)
        if manner == "at":
            behind = behind + rows.left_at_once[row]  # a starting position that is no stay
        return origin, behind, np.where(found, stretch, -1)

    def _places(self, member: int, low: IntArray, high: IntArray) -> Ranges:
        """Return the events whose member begins at some rows ahead."""
        first = self._events.first[member]
        many = len(self._batch.rows(self._target.members[member]))
        if FEW * len(low) < many:
            return np.searchsorted(first, low), np.searchsorted(first, high)
        before = np.zeros(many + 2, np.int64)  # how many begin before each row
        np.cumsum(np.bincount(first, minlength=many + 1), out=before[1:])
        return before[low], before[high]

    def _frames_ahead(self) -> Ranges:
        """Return between which frames, both included, what follows in time begins."""
        assert self._edge.arrow.length
        before = self._before
        least, most = (it[before.capture] for it in self._batch.bounds(self._edge.arrow.length))
        first = np.where(least > 0, before.end + least, 0)
        last = np.where(most < 0, -1, before.end + most)
        if self._edge.same and not self._edge.arrow.later:
            # no time passes from a passing symbol to the one that it leads to
            first = np.where(before.passing, np.where(least > 0, FAR - 1, 0), first)
            last = np.where(before.passing & (most >= 0), FAR - 2, last)
        return first, last

    def pairs(self) -> tuple[IntArray, IntArray]:
        """Return all pairs of an event before and one that follows it, by place."""
        sources, places = spread(self.low, self.high)
        return sources, places if self.targets is None else self.targets[places]

    def smallest(self, values: IntArray) -> IntArray:
        """Return the smallest value among the events that follow each, `NONE` if none does.

        `values` (M,) int64 are those of the events of the next state.
        """
        groups = self.open_groups()
        if groups is None:
            values = values if self.targets is None else values[self.targets]
            return smallest_in(values, self.low, self.high, NONE)
        found, some = np.full(len(self.low), NONE), np.flatnonzero(self.low < self.high)
        found[some] = smallest_from_here(values, groups)[self.low[some]]
        return found

    def open_groups(self) -> IntArray | None:
        """Return the groups of events within which an arrow leads on to the end, if it is such."""
        arrow = self._edge.arrow
        limited = arrow.length or arrow.bounds[1] is not None
        if not arrow.later or limited or self.targets is not None:
            return None
        firsts = zip(self._target.members, self._events.first, strict=True)
        stretches = [self._batch.rows(part).stretch[first] for part, first in firsts]
        return np.cumsum(starts_of(*stretches)) - 1


def _common(ranges: list[Ranges]) -> Ranges:
    """Return what several ranges have in common."""
    low = reduce(np.maximum, (low for low, _ in ranges))
    return low, np.maximum(low, reduce(np.minimum, (high for _, high in ranges)))


def roots(batch: Batch, program: Program, entry: Entry) -> BoolArray:
    """Tell at which events of its state a line may begin, (N,) bool."""
    state = program.states[entry.state]
    events = batch.events(state)
    fits = ~events.passing | (state.manner == "via")
    for arrow in entry.from_start:
        fits &= begins(batch, state, events, arrow)
    return fits


def begins(batch: Batch, state: State, events: Events, arrow: Arrow) -> BoolArray:
    """Tell to which events an arrow leads from the clip's start, (N,) bool."""
    fits = ~events.passing | (state.manner == "via")
    for part, first in zip(state.members, events.first, strict=True):
        rows = batch.rows(part)
        if not len(first):
            break
        opening = rows.bounds[events.capture]
        stretch, behind = rows.stretch[opening], rows.rank[opening]
        start = np.append(rows.shown, len(rows) - 1)[behind]
        count = rows.rank[first] - behind
        if state.manner == "at":
            count = np.maximum(count - rows.left_at_once[start], 0)
        elif state.manner != "hold":
            count = count - rows.starting[start]
        if state.manner in ("at", "hold") and not arrow.later:
            fits &= events.start <= 0
        fits &= (rows.stretch[first] == stretch) & (rows.stretch_begin[stretch] <= 0)
        fits &= _counted(count, arrow)
    if arrow.length:
        fits &= batch.meets(events.capture, events.start, arrow.length)
    return fits


def ends(batch: Batch, state: State, events: Events, arrow: Arrow) -> BoolArray:
    """Tell from which events an arrow leads to the clip's end, (N,) bool."""
    fits, frames = ~events.passing, batch.frames[events.capture]
    for part, last in zip(state.members, events.last, strict=True):
        rows = batch.rows(part)
        if not len(last):
            break
        count = rows.rank[rows.bounds[events.capture + 1]] - rows.rank[last + 1]
        fits &= rows.stretch_end[rows.stretch[last]] >= frames
        fits &= _counted(count, arrow)
    if arrow.length:
        fits &= batch.meets(events.capture, frames - events.end, arrow.length)
    return fits


def _counted(count: IntArray, arrow: Arrow) -> BoolArray:
    """Tell which numbers of symbols in between an arrow allows."""
    least, most = arrow.bounds
    return (count >= least) & (count <= (FAR if most is None else most))
