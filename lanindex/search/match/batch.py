"""Captures that are searched at once, with what any step of a pattern finds in them."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from fractions import Fraction
from functools import lru_cache

import numpy as np

from lanindex.model.columns import Columns, Roster
from lanindex.search.automaton import State
from lanindex.search.language.times import Clock, Length
from lanindex.search.match.arrays import FAR, BoolArray, IntArray, starts_of
from lanindex.search.match.rows import Rows
from lanindex.search.match.scan import Events, events_of, paired

LARGE = 1 << 19
"""Rows of a part in a library whose batches are as large as any: in smaller ones they are smaller,
so that what a search takes stays little beside the columns that it reads."""

FEWEST_ROWS = 1 << 14
"""How many rows a batch may have in any library: each batch costs some time of its own."""

MOST_CLOCKS = 16
"""Clocks that are looked for one by one, before all are put in order."""


class Batch:
    """Some captures of a roster; here they are counted from 0.

    Parameters
    ----------
    roster : Roster
        All captures.
    columns : Mapping of str to Columns
        By part; a part that is not there never moves.
    places : ndarray
        (N,) int64, growing: which captures.
    tolerance : Fraction
        Seconds by which edges may differ that should agree.
    """

    def __init__(
        self, roster: Roster, columns: Mapping[str, Columns], places: IntArray, tolerance: Fraction
    ) -> None:
        self.places, self.tolerance = places, tolerance
        self.roster, self._columns = roster, columns
        self.frames = roster.frames[places].astype(np.int64)
        self._clocks: tuple[list[Clock], IntArray] | None = None
        self._rows: dict[str, Rows] = {}
        self._events: dict[tuple[object, ...], Events] = {}
        self._of_state: dict[State, Events] = {}
        self._bounds: dict[Length, tuple[IntArray, IntArray]] = {}

    def __len__(self) -> int:
        """Return how many captures there are."""
        return len(self.places)

    def taken(self, places: IntArray) -> Batch:
        """Return some of the captures as a batch of their own."""
        return Batch(self.roster, self._columns, self.places[places], self.tolerance)

    def rows(self, part: str) -> Rows:
        """Return the rows of a part; none, where there is no such part."""
        if part not in self._rows:
            columns = self._columns.get(part)
            if columns is None:
                columns = _nothing(part, len(self.roster))
            self._rows[part] = Rows(columns, self.places, self.frames)
        return self._rows[part]

    def events(self, state: State) -> Events:
        """Return what may match a state, of the lengths that it may have."""
        if state in self._of_state:
            return self._of_state[state]
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
        self._of_state[state] = self._events[key]
        return self._events[key]

    def clocks(self) -> tuple[list[Clock], IntArray]:
        """Return the clocks that captures have, and each capture's among them."""
        if self._clocks is None:
            self._clocks = clocks_of(self.roster, self.places)
        return self._clocks

    def bounds(self, length: Length) -> tuple[IntArray, IntArray]:
        """Return by capture the fewest and the most frames that meet a condition on length."""
        if length not in self._bounds:
            clocks, own = self.clocks()
            least, most = frames_of(length, clocks)
            self._bounds[length] = least[own], most[own]
        return self._bounds[length]

    def meets(self, capture: IntArray, frames: IntArray, length: Length) -> BoolArray:
        """Tell which numbers of frames meet a condition on length, (N,) bool."""
        least, most = self.bounds(length)
        meets: BoolArray = (least[capture] <= frames) & (frames <= most[capture])
        return meets


def clocks_of(
    roster: Roster, places: IntArray | slice = slice(None)
) -> tuple[list[Clock], IntArray]:
    """Return the clocks that captures have, and each capture's among them."""
    if _KEPT not in roster.kept:
        told, number = _different(np.concatenate((roster.rate, roster.speed), axis=1))
        roster.kept[_KEPT] = told, number.astype(np.int32)
    different, number = roster.kept[_KEPT]
    own = number[places].astype(np.int64)
    if len(different) > MOST_CLOCKS:
        used, own = np.unique(own, return_inverse=True)
        different = different[used]
    clocks = [Clock(Fraction(a, b), Fraction(c, d) / 60) for a, b, c, d in different.tolist()]
    return clocks, own


_KEPT = "lanindex.search.match.batch"
"""Where it is kept with a roster which different clocks there are, and each capture's: 4 bytes."""


def split(columns: Collection[Columns], places: IntArray, most: int) -> list[IntArray]:
    """Return captures, some at once: those in which no part has more rows than so many.

    Parameters
    ----------
    columns : collection of Columns
        Of the parts.
    places : ndarray
        (N,) int64, growing: which captures.
    most : int
        How many at once in a `LARGE` library, captures too; one capture may have more.
    """
    library = max(map(len, columns), default=0)
    rows = max(min(most, FEWEST_ROWS), most * min(library, LARGE) // LARGE)
    longest = np.ones(len(places), np.int64)
    for own in columns:
        longest = np.maximum(longest, own.bounds[places + 1] - own.bounds[places])
    slab = np.cumsum(longest) // rows
    return np.split(places, np.flatnonzero(starts_of(slab))[1:]) if len(places) else []


def frames_of(length: Length, clocks: list[Clock]) -> tuple[IntArray, IntArray]:
    """Return by clock the fewest and the most frames that meet a condition on length."""
    told = [_bounds(length, clock) for clock in clocks]
    least = np.array([min(it, FAR >> 1) for it, _ in told], np.int64)
    most = np.array([FAR >> 1 if it is None else min(it, FAR >> 1) for _, it in told], np.int64)
    return least, most


@lru_cache(1024)
def _bounds(length: Length, clock: Clock) -> tuple[int, int | None]:
    return length.bounds(clock)


def _different(told: IntArray) -> tuple[IntArray, IntArray]:
    """Return the different rows of a table, and which of them each row is; mostly they are few."""
    different: list[IntArray] = []
    own, left = np.zeros(len(told), np.int64), np.arange(len(told))
    while len(left):
        if len(different) == MOST_CLOCKS:
            found, own = np.unique(told, axis=0, return_inverse=True)
            return found, own.reshape(-1)
        row, same = told[left[0]], np.ones(len(left), bool)
        for column, number in zip(told.T, row, strict=True):
            same &= column[left] == number
        own[left[same]] = len(different)
        different.append(row)
        left = left[~same]
    return np.array(different, np.int64).reshape(-1, told.shape[1]), own


def _key(state: State) -> tuple[object, ...]:
    """Return what the events of a state depend on; copies of a repeated step share it."""
    fits = tuple(frozenset(said.items()) for said in state.fits)
    return state.members, state.manner, fits, state.names_passing, state.length, state.near


def _nothing(part: str, captures: int) -> Columns:
    none = np.empty(0, np.uint8)
    times = np.empty(0, np.int32)
    return Columns(
        part,
        np.zeros(captures + 1, np.int64),
        *(none, none, none.astype(np.uint16), times, times),
        np.empty((0, 3), np.int32),
    )
