"""Captures that are searched at once, with the rows and events found in them so far."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache

import numpy as np

from lanindex.model.columns import Columns, Roster, columns_of
from lanindex.search.automaton import State
from lanindex.search.language.times import Clock, Length
from lanindex.search.match.arrays import FAR, BoolArray, IntArray, grouped, once, starts_of
from lanindex.search.match.scan import Events, Rows, events_of, paired

LARGE = 1 << 19
"""Rows of a part in a library whose batches are as large as any: in smaller ones they are smaller,
so that what a search takes stays little beside the columns that it reads."""

FEWEST_ROWS = 1 << 14  # that a batch may have in any library: each costs some time of its own


class Batch:
    """Some captures of a roster; here they are counted from 0.

    `places` (N,) int64 are those captures in the roster, growing. A part without columns never
    moves. Edges that should agree may differ by `tolerance` seconds.
    """

    def __init__(
        self, roster: Roster, columns: Mapping[str, Columns], places: IntArray, tolerance: Fraction
    ) -> None:
        self.places, self.tolerance = places, tolerance
        self.roster, self._columns = roster, columns
        self.frames = roster.frames[places].astype(np.int64)
        self._clocks: tuple[list[Clock], IntArray] | None = None
        self._rows: dict[str, Rows] = {}
        self._events: dict[object, Events] = {}
        self._bounds: dict[Length, tuple[IntArray, IntArray]] = {}

    def __len__(self) -> int:
        return len(self.places)

    def taken(self, places: IntArray) -> Batch:
        """Return some of the captures as a batch of their own."""
        return Batch(self.roster, self._columns, self.places[places], self.tolerance)

    def rows(self, part: str) -> Rows:
        """Return the rows of a part; none, where there is no such part."""
        if part not in self._rows:
            columns = self._columns.get(part)
            if columns is None:
                bounds = np.zeros(len(self.roster) + 1, np.int64)
                columns = replace(columns_of(part, [], []), bounds=bounds)
            self._rows[part] = Rows(columns, self.places, self.frames)
        return self._rows[part]

    def events(self, state: State) -> Events:
        """Return what may match a state, of the lengths that it may have."""
        key = _key(state)
        if key not in self._events:
            members = [
                events_of(self.rows(part), state, member)
                for member, part in enumerate(state.members)
            ]
            found = members[0] if len(members) == 1 else paired(state.manner, *members)
            if state.length:
                meets = self.meets(found.capture, found.end - found.start, state.length)
                found = found.at(meets & ~found.starting)
            self._events[key] = found
        return self._events[key]

    def clocks(self) -> tuple[list[Clock], IntArray]:
        """Return the different clocks of the captures, and each capture's among them, (N,)."""
        if self._clocks is None:
            if _KEPT not in self.roster.kept:
                ratios = np.concatenate((self.roster.rate, self.roster.speed), axis=1)
                first, which = grouped(tuple(ratios.T))
                self.roster.kept[_KEPT] = ratios[first], which.astype(np.int32)
            ratios, which = self.roster.kept[_KEPT]
            own = which[self.places]
            used = once(own)
            clocks = [
                Clock(Fraction(a, b), Fraction(c, d) / 60) for a, b, c, d in ratios[used].tolist()
            ]
            self._clocks = clocks, np.searchsorted(used, own)
        return self._clocks

    def bounds(self, length: Length) -> tuple[IntArray, IntArray]:
        """Return the fewest and the most frames of each capture that meet a condition on length."""
        if length not in self._bounds:
            clocks, own = self.clocks()
            ends = [_bounds(length, clock) for clock in clocks]
            least, most = np.array(ends, np.int64).reshape(-1, 2).T
            self._bounds[length] = least[own], most[own]
        return self._bounds[length]

    def meets(self, capture: IntArray, frames: IntArray, length: Length) -> BoolArray:
        """Tell which numbers of frames meet a condition on length, (N,) bool."""
        least, most = self.bounds(length)
        meets: BoolArray = (least[capture] <= frames) & (frames <= most[capture])
        return meets


_KEPT = "lanindex.search.match.batch"
"""Where a roster keeps its different clocks and which of them each capture has: 4 bytes."""


@lru_cache(1024)
def _bounds(length: Length, clock: Clock) -> tuple[int, int]:
    least, most = length.bounds(clock)
    return min(least, FAR >> 1), FAR >> 1 if most is None else min(most, FAR >> 1)


@lru_cache(1024)
def _key(state: State) -> object:
    """Return what the events of a state depend on; copies of a repeated step share it."""
    fits = tuple(frozenset(asked.items()) for asked in state.fits)
    return state.members, state.manner, fits, state.names_passing, state.length, state.near


def split(columns: Collection[Columns], places: IntArray, most: int) -> list[IntArray]:
    """Return captures, some at once: those in which no part has more than `most` rows.

    So many there are in a `LARGE` library, captures too; one capture may have more.
    """
    library = max(map(len, columns), default=0)
    rows = max(min(most, FEWEST_ROWS), most * min(library, LARGE) // LARGE)
    longest = np.ones(len(places), np.int64)
    for own in columns:
        longest = np.maximum(longest, own.bounds[places + 1] - own.bounds[places])
    slab = np.cumsum(longest) // rows
    return np.split(places, np.flatnonzero(starts_of(slab))[1:]) if len(places) else []
