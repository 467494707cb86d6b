"""Follow: where arrows lead, from events to ranges of other events.

``->`` leads to that part's next symbol, ``...`` to a later one; to another part it leads to what
begins when the step before is over, or later. Events stand in order of their rows, so that an
arrow leads to a range of them; a pair of events follows if both of its members do.
"""

from collections.abc import Sequence
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
FEW = 16  # where one in so many keys is looked up, a table of all of them is faster than a search

Ranges = tuple[IntArray, IntArray]
"""Ranges ``[low, high)``, (N,) each: of rows of one member, or of events."""

Limit = tuple[IntArray, IntArray, IntArray]
"""Keys of the events of a state, (M,), and from which to before which key follow others, (N,)."""


class Transitions:
    """Where an edge leads from some events: to those in `[low, high)` of its next state, (N,) each.

    Events stand in order of the rows of their first member. In this order the rows of a second
    member and the first frames hardly ever go back. Where they do, an edge also leads to events
    outside of the range: `outliers` are pairs (2, K) of an event before and one that follows, in
    order, and those of event n are in `[bounds[n], bounds[n + 1])`.
    """

    def __init__(self, batch: Batch, program: Program, edge: Edge, before: Events) -> None:
        self._batch, self._edge, self._before = batch, edge, before
        self._source, self._target = (program.states[it.state] for it in (edge.exit, edge.entry))
        self._events = events = batch.events(self._target)
        limits = [
            (events.first[member], *self._rows_ahead(member, part))
            for member, part in enumerate(self._target.members)
        ]
        if edge.arrow.length:
            first, last = (before.capture * FAR + it for it in self._frames_ahead())
            limits.append((events.capture * FAR + events.start, first, last + 1))
        widest, surest = zip(*(_places(*limit) for limit in limits), strict=True)
        self.low, self.high = least, most = _common(widest)
        self.outliers, self.bounds = np.empty((2, 0), np.int64), np.zeros(len(least) + 1, np.int64)
        if any(wide is not sure for wide, sure in zip(widest, surest, strict=True)):
            self.low, self.high = (np.clip(it, least, most) for it in _common(surest))
            self._find_outliers(limits, least, most)

    def _find_outliers(self, limits: list[Limit], least: IntArray, most: IntArray) -> None:
        """Find the pairs outside of the ranges, of those in some wider ones."""
        sides = spread(least, self.low), spread(self.high, most)
        pairs = np.concatenate([np.stack(side) for side in sides], axis=1)
        for keys, first, behind in limits:
            sources, targets = pairs
            found = keys[targets]
            pairs = pairs[:, (first[sources] <= found) & (found < behind[sources])]
        self.outliers = pairs[:, np.argsort(pairs[0], kind="stable")]
        self.bounds = np.searchsorted(self.outliers[0], np.arange(len(least) + 1))

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
        sources, targets = spread(self.low, self.high)
        return np.append(sources, self.outliers[0]), np.append(targets, self.outliers[1])

    def following(self, event: int) -> IntArray:
        """Return the events that follow one."""
        outliers = self.outliers[1, self.bounds[event] : self.bounds[event + 1]]
        return np.append(np.arange(self.low[event], self.high[event]), outliers)

    def smallest(self, values: IntArray) -> IntArray:
        """Return the smallest value among the events that follow each, `NONE` if none does.

        `values` (M,) int64 are those of the events of the next state.
        """
        groups = self.open_groups()
        if groups is None:
            found = smallest_in(values, self.low, self.high, NONE)
        else:
            found, some = np.full(len(self.low), NONE), np.flatnonzero(self.low < self.high)
            found[some] = smallest_from_here(values, groups)[self.low[some]]
        if len(self.outliers[1]):
            apart = values[self.outliers[1]]
            found = np.minimum(found, smallest_in(apart, self.bounds[:-1], self.bounds[1:], NONE))
        return found

    def open_groups(self) -> IntArray | None:
        """Return the groups of events within which an arrow leads on to the end, if it is such."""
        arrow = self._edge.arrow
        if not arrow.later or arrow.length or arrow.bounds[1] is not None:
            return None
        firsts = zip(self._target.members, self._events.first, strict=True)
        stretches = [self._batch.rows(part).stretch[first] for part, first in firsts]
        return np.cumsum(starts_of(*stretches)) - 1


def _places(keys: IntArray, first: IntArray, behind: IntArray) -> tuple[Ranges, Ranges]:
    """Return the ranges of places that hold all keys in `[first, behind)`, and that hold no others.

    Keys are (M,), mostly growing; where they always grow both are the same.
    """
    if (keys[1:] >= keys[:-1]).all():
        many = int(keys[-1]) + 2 if len(keys) else 2
        if len(first) * FEW < many:
            found = np.searchsorted(keys, first), np.searchsorted(keys, behind)
        else:
            below = np.zeros(many, np.int64)  # how many keys are less than each number
            np.cumsum(np.bincount(keys, minlength=many - 1), out=below[1:])
            found = below[np.minimum(first, many - 1)], below[np.minimum(behind, many - 1)]
        return found, found
    latest = np.maximum.accumulate(keys)
    soonest = np.minimum.accumulate(keys[::-1])[::-1]
    widest = np.searchsorted(latest, first), np.searchsorted(soonest, behind)
    return widest, (np.searchsorted(soonest, first), np.searchsorted(latest, behind))


def _common(ranges: Sequence[Ranges]) -> Ranges:
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
        fits &= _allows_count(count, arrow)
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
        fits &= _allows_count(count, arrow)
    if arrow.length:
        fits &= batch.meets(events.capture, frames - events.end, arrow.length)
    return fits


def _allows_count(count: IntArray, arrow: Arrow) -> BoolArray:
    """Tell which numbers of symbols in between an arrow allows."""
    least, most = arrow.bounds
    return (count >= least) & (count <= (FAR if most is None else most))
