"""Where arrows lead: from events to ranges of other events.

``->`` leads to that part's next symbol, ``...`` to a later one; to another part it leads to what
begins when the step before is over, or later. Events stand in order of their rows, so that an
arrow leads to a range of them; a pair of events follows if both of its members do.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lanindex.search.automaton import Edge, State
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
from lanindex.search.match.batch import Batch
from lanindex.search.match.rows import Rows
from lanindex.search.match.scan import Events, ordered

NONE = 1 << 42
"""A value that is none: more than any."""

AT_ONCE = 1 << 14
"""How many pairs of an event and one that follows it are looked at, to find the best."""

FEW = 16
"""What is less than one in so many rows is looked up, not counted."""


class Way(NamedTuple):
    """An arrow between two states: where from, over what, where to."""

    source: State
    arrow: Arrow
    target: State
    same: bool


class Ranges(NamedTuple):
    """Ranges of rows ``[low, high)`` of one member, one for each event before."""

    low: IntArray
    high: IntArray


def way_of(states: tuple[State, ...], edge: Edge) -> Way:
    """Return the arrow of an edge."""
    return Way(states[edge.exit.state], edge.arrow, states[edge.entry.state], edge.same)


def _origins(
    rows: Rows, way: Way, member: int, before: Events
) -> tuple[IntArray, IntArray, IntArray]:
    """Return the first row that may follow, the shown rows behind, the stretch (-1: none).

    Behind a stay's first row there may be one that is behind: a starting position, alone no stay.
    """
    holds = way.target.manner == "hold"
    if way.same:
        row = before.last[member]
        rests = holds and way.source.manner not in ("at", "hold")
        own_rest = ~rows.passing[row] if rests else np.zeros(len(row), bool)
        behind = rows.rank[row + 1].astype(np.int64)
        return row + 1 - own_rest, behind, rows.stretch[row].astype(np.int64)
    stretch = rows.stretch_at(before.capture, before.end)
    begun, frames = rows.beginnings(way.target.manner)
    if not len(begun):
        nothing = np.zeros(len(stretch), np.int64)
        return nothing, nothing, np.full(len(stretch), -1)
    keys = rows.stretch[begun].astype(np.int64) * FAR + frames
    place = np.searchsorted(keys, stretch * FAR + before.end)
    row = begun[np.minimum(place, len(begun) - 1)]
    found = (stretch >= 0) & (place < len(begun)) & (rows.stretch[row] == stretch)
    behind, origin = rows.rank[row].astype(np.int64), row
    if holds:
        behind = behind + 1
    else:
        origin = rows.row_of(behind)
    if way.target.manner == "at":
        behind = behind + rows.left_at_once[row]
    return origin, behind, np.where(found, stretch, -1)


def _rows_ahead(rows: Rows, way: Way, member: int, before: Events) -> Ranges:
    """Return the rows at which what follows may begin."""
    if not len(rows):
        nothing = np.zeros(len(before), np.int64)
        return Ranges(nothing, nothing)
    origin, behind, stretch = _origins(rows, way, member, before)
    least, most = way.arrow.bounds
    behind = behind - (way.target.manner == "hold")
    here = np.maximum(stretch, 0)
    low = np.maximum(origin, rows.row_of(behind + least)) if least else origin
    low = np.maximum(low, rows.stretch_rows[here])
    high = rows.stretch_rows[here + 1]
    if most is not None:
        high = np.minimum(high, rows.row_of(behind + most + 1))
    return Ranges(low, np.where(stretch >= 0, high, 0))


class Transitions:
    """Where an arrow leads from some events.

    Parameters
    ----------
    batch : Batch
        Where.
    way : Way
        The arrow.
    before : Events
        Where from.
    """

    def __init__(self, batch: Batch, way: Way, before: Events) -> None:
        self._batch, self._way, self._before = batch, way, before
        self._events = batch.events(way.target)
        self._ahead = [
            _rows_ahead(batch.rows(part), way, member, before)
            for member, part in enumerate(way.target.members)
        ]
        low, high = self._places(0)
        self._exact = ordered(self._events)
        if len(self._ahead) > 1 and self._exact:
            low_too, high_too = self._places(1)
            low, high = np.maximum(low, low_too), np.minimum(high, high_too)
        if way.arrow.length:
            low, high = self._in_time(low, high)
        self.low, self.high = low, high

    def _places(self, member: int) -> Ranges:
        first = self._events.first[member]
        ahead = self._ahead[member]
        many = len(self._batch.rows(self._way.target.members[member]))
        if FEW * len(ahead.low) < many:
            return Ranges(np.searchsorted(first, ahead.low), np.searchsorted(first, ahead.high))
        before = np.zeros(many + 2, np.int64)  # how many begin before each row
        np.cumsum(np.bincount(first, minlength=many + 1), out=before[1:])
        return Ranges(before[ahead.low], before[ahead.high])

    def _in_time(self, low: IntArray, high: IntArray) -> Ranges:
        """Narrow ranges down to what begins in time, where events stand in order of time."""
        if not self._exact or self._events.passing.any():
            self._exact = False
            return Ranges(low, high)
        before, (least, most) = self._before, self._times()
        keys = self._events.capture * FAR + self._events.start
        base = before.capture * FAR + before.end
        soonest = np.where(least > 0, np.searchsorted(keys, base + least), 0)
        latest = np.searchsorted(keys, base + most, "right")
        moving = before.passing & self._moves_on
        soonest, latest = np.where(moving, 0, soonest), np.where(moving, len(keys), latest)
        never = (most < 0) | (moving & (least > 0))
        return Ranges(np.maximum(low, soonest), np.where(never, 0, np.minimum(high, latest)))

    @property
    def _moves_on(self) -> bool:
        """Whether no time passes from a passing symbol: to the one that it leads to."""
        return self._way.same and not self._way.arrow.later

    def _times(self) -> tuple[IntArray, IntArray]:
        assert self._way.arrow.length
        least, most = self._batch.bounds(self._way.arrow.length)
        return least[self._before.capture], most[self._before.capture]

    def pairs(self, here: slice = slice(0, None)) -> tuple[IntArray, IntArray]:
        """Return all pairs of an event before, of some, and one that follows it, by place."""
        sources, targets = spread(self.low[here], self.high[here])
        sources += here.start
        if self._exact:
            return sources, targets
        fits = np.ones(len(sources), bool)
        for ahead, first in zip(self._ahead[1:], self._events.first[1:], strict=True):
            row = first[targets]
            fits &= (ahead.low[sources] <= row) & (row < ahead.high[sources])
        if self._way.arrow.length:
            fits &= self._timely(sources, targets)
        return sources[fits], targets[fits]

    def listed(self) -> tuple[IntArray, IntArray, IntArray | None]:
        """Return the ranges of what follows each event: of events, or of places in a list."""
        if self._exact:
            return self.low, np.maximum(self.high, self.low), None
        sources, targets = self.pairs()
        bounds = np.searchsorted(sources, np.arange(len(self._before) + 1))
        return bounds[:-1], bounds[1:], targets

    def _timely(self, sources: IntArray, targets: IntArray) -> BoolArray:
        between = self._events.start[targets] - self._before.end[sources]
        between = np.maximum(between, 0)
        between[self._before.passing[sources] & self._moves_on] = 0
        least, most = self._times()
        timely: BoolArray = (least[sources] <= between) & (between <= most[sources])
        return timely

    def smallest(self, values: IntArray) -> IntArray:
        """Return the smallest value among the events that follow each, `NONE` if none does.

        Parameters
        ----------
        values : ndarray
            (N,) int64, of the events that may follow.
        """
        found = np.full(len(self._before), NONE)
        if not len(values):
            return found
        if not self._exact:
            many = np.cumsum(np.maximum(self.high - self.low, 0)) // AT_ONCE
            cuts = [*np.flatnonzero(starts_of(many)).tolist(), len(many)]
            for here in map(slice, cuts, cuts[1:]):
                sources, targets = self.pairs(here)
                if len(sources):
                    places = np.flatnonzero(starts_of(sources))
                    found[sources[places]] = np.minimum.reduceat(values[targets], places)
            return found
        some = self.low < self.high
        low, high = self.low[some], self.high[some]
        groups = self.open_groups()
        if groups is not None:
            found[some] = smallest_from_here(values, groups)[low]
        else:
            found[some] = smallest_in(values, low, high, NONE)
        return found

    def open_groups(self) -> IntArray | None:
        """Return within which of its events an open arrow goes on to the next, if it is one."""
        arrow = self._way.arrow
        ends_nowhere = arrow.later and not arrow.length and arrow.bounds[1] is None
        return self._groups() if ends_nowhere and self._exact else None

    def _groups(self) -> IntArray:
        """Return which events no arrow parts, counted."""
        new = np.zeros(len(self._events), bool)
        for part, first in zip(self._way.target.members, self._events.first, strict=True):
            new |= starts_of(self._batch.rows(part).stretch[first])
        return np.cumsum(new) - 1


def begins(batch: Batch, state: State, events: Events, arrow: Arrow) -> BoolArray:
    """Tell to which events an arrow leads from the clip's start, (N,) bool."""
    least, most = arrow.bounds
    fits = ~events.passing if state.manner != "via" else np.ones(len(events), bool)
    for part, first in zip(state.members, events.first, strict=True):
        rows = batch.rows(part)
        if not len(first):
            break
        opening = rows.bounds[events.capture]
        stretch = rows.stretch[opening]
        behind = rows.rank[opening]
        start = np.append(rows.shown, len(rows) - 1)[behind]
        count = rows.rank[first] - behind
        if state.manner == "at":
            count = np.maximum(count - rows.left_at_once[start], 0)
        elif state.manner != "hold":
            count = count - rows.starting[start]
        if state.manner in ("at", "hold") and not arrow.later:
            fits &= events.start <= 0
        fits &= (rows.stretch[first] == stretch) & (rows.stretch_begin[stretch] <= 0)
        fits &= (count >= least) & (count <= (FAR if most is None else most))
    if arrow.length:
        fits &= batch.meets(events.capture, events.start, arrow.length)
    return fits


def ends(batch: Batch, state: State, events: Events, arrow: Arrow) -> BoolArray:
    """Tell from which events an arrow leads to the clip's end, (N,) bool."""
    least, most = arrow.bounds
    fits, frames = ~events.passing, batch.frames[events.capture]
    for part, last in zip(state.members, events.last, strict=True):
        rows = batch.rows(part)
        if not len(last):
            break
        count = rows.rank[rows.bounds[events.capture + 1]] - rows.rank[last + 1]
        fits &= rows.stretch_end[rows.stretch[last]] >= frames
        fits &= (count >= least) & (count <= (FAR if most is None else most))
    if arrow.length:
        fits &= batch.meets(events.capture, frames - events.end, arrow.length)
    return fits
