"""One line in many captures: where it nearly matches, and at what cost."""

from __future__ import annotations

from fractions import Fraction
from functools import cached_property
from math import floor
from operator import add
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import PASSING, STARTING, THOUSANDTHS, Columns, Roster, ranges
from lanindex.search.fuzzy.align import (
    NOTHING,
    Ask,
    Keys,
    Rows,
    Stretch,
    align,
    blur_of,
    blurs,
    cost_of,
    first_of,
    key_of,
    trace,
)
from lanindex.search.fuzzy.costs import CHANGE, NEVER, UNIT, kinds_of, substitutions
from lanindex.search.fuzzy.net import FAR, LATER, NEXT, SKIPPED, Net
from lanindex.search.fuzzy.windows import (
    FEW,
    BoolArray,
    IntArray,
    Windows,
    around,
    wanted,
)
from lanindex.search.language.times import Clock, Length

ENDLESS = 1 << 33
"""More frames than a capture has."""


def bounds_of(roster: Roster, length: Length | None) -> tuple[IntArray, IntArray]:
    """Return the fewest and the most frames that meet a length, (C,) each; `ENDLESS`: no limit."""
    if length is None:
        return np.zeros(len(roster), np.int64), np.full(len(roster), ENDLESS)
    clocks, which = _clocks(roster)
    bounds = [length.bounds(clock) for clock in clocks]
    limits = [
        (min(least, ENDLESS), ENDLESS if most is None else min(most, ENDLESS))
        for least, most in bounds
    ]
    least, most = np.array(limits, np.int64).reshape(-1, 2)[which].T
    return least, most


def slack_of(roster: Roster, tolerance: Fraction) -> IntArray:
    """Return how many frames a tolerance is, (C,), rounded down."""
    clocks, which = _clocks(roster)
    frames = [min(floor(tolerance * clock.rate), ENDLESS) for clock in clocks]
    return np.array(frames, np.int64)[which]


def _clocks(roster: Roster) -> tuple[list[Clock], NDArray[np.intp]]:
    """Return the different clocks of captures, and which each one has."""
    which = np.zeros(len(roster), np.int64)
    for column in (*roster.rate.T, *roster.speed.T):
        values, own = np.unique(column, return_inverse=True)
        _, which = np.unique(which * len(values) + own, return_inverse=True)
    _, first = np.unique(which, return_index=True)
    found = [
        Clock(Fraction(*rate), Fraction(*speed) / 60)
        for rate, speed in zip(
            roster.rate[first].tolist(), roster.speed[first].tolist(), strict=True
        )
    ]
    return found, which


def captures_of(columns: Columns, rows: IntArray) -> IntArray:
    """Return the places in the roster of some rows."""
    return np.searchsorted(columns.bounds, rows, side="right") - 1


class Ends:
    """The starts and ends of clips, for the rows of a part."""

    def __init__(self, columns: Columns, roster: Roster) -> None:
        self._columns = columns
        self._moves = np.flatnonzero(columns.cell & (PASSING | STARTING) == 0)
        self._starting = np.flatnonzero(columns.cell & STARTING != 0)
        self._from_start, self._to_end = np.ones((2, len(roster)), np.bool_)
        whose, begin, end = columns.gaps.T
        if len(whose):
            first = np.append(True, whose[1:] != whose[:-1])
            last = np.append(first[1:], True)
            self._from_start[whose[first]] = begin[first] == 0
            self._to_end[whose[last]] = end[last] == roster.frames[whose[last]]

    def from_start(self, rows: IntArray) -> NDArray[np.int32]:
        """Return what it costs to begin with some rows, (2, R): right at the start, and behind it.

        Right at the start each shown symbol before costs as if it were passed over. With a starting
        position, or where the part is not known all the way, nothing can begin.
        """
        capture = captures_of(self._columns, rows)
        begin = self._columns.bounds[capture]
        known = self._from_start[capture] & (self._columns.cell[rows] & STARTING == 0)
        known &= self._stretches(begin + 1, rows) == 0
        return _besides(known, np.searchsorted(self._moves, rows) - self._before(begin))

    def to_end(self, rows: IntArray) -> NDArray[np.int32]:
        """Return what it costs to end with some rows, (2, R): right at the end, and before it."""
        capture = captures_of(self._columns, rows)
        end = self._columns.bounds[capture + 1]
        known = self._to_end[capture] & (self._stretches(rows + 1, end) == 0)
        return _besides(known, self._before(end) - self._before(rows + 1))

    def _before(self, rows: IntArray) -> IntArray:
        return np.searchsorted(self._moves, rows)

    def _stretches(self, low: IntArray, high: IntArray) -> IntArray:
        """Return how many stretches begin between some rows and others, half-open."""
        return np.searchsorted(self._starting, high) - np.searchsorted(self._starting, low)


def _besides(known: NDArray[np.bool_], between: IntArray) -> NDArray[np.int32]:
    costs = np.minimum(between * SKIPPED, FAR)
    return np.where(known, np.stack((costs, np.zeros_like(costs))), FAR).astype(np.int32)


LIFTED = 1 << 40
"""More than any frame or row; times a number of captures it still fits 64 bits."""


class Found(NamedTuple):
    """The matches of a line, (N,) by column, in order of the rows with which they begin.

    Attributes
    ----------
    capture : ndarray
        Places in the roster.
    start, until : ndarray
        Frames, half-open.
    cost : ndarray
        Parts of an edit.
    blur : ndarray
        What the symbols that fit lack to a margin of 1, in thousandths.
    first, last : ndarray
        Rows of the part.
    """

    capture: IntArray
    start: IntArray
    until: IntArray
    cost: IntArray
    blur: IntArray
    first: IntArray
    last: IntArray

    def chosen(self, which: IntArray | BoolArray) -> Found:
        """Return some of them."""
        return Found._make(column[which] for column in self)

    def cheapest(self) -> Found:
        """Return of those that begin alike the cheapest, of these the one that ends first."""
        order = np.argsort(self.first, kind="stable")
        first, rank = self.first[order], (self.cost * LIFTED + self.until)[order]
        begins = np.flatnonzero(np.diff(first, prepend=-1))
        best = np.minimum.reduceat(rank, begins) if len(begins) else rank
        places = np.flatnonzero(rank == np.repeat(best, np.diff(np.append(begins, len(first)))))
        return self.chosen(order[places[np.diff(first[places], prepend=-1) > 0]])


def fits(cost: IntArray, blur: IntArray, steps: int) -> NDArray[np.float64]:
    """Return how well matches fit, 0 to 1, of a plan with so many steps."""
    found: NDArray[np.float64] = (THOUSANDTHS - blur) / THOUSANDTHS
    return found * np.maximum(1 - cost / UNIT / steps, 0)


class Line:
    """A line in all captures.

    `most` is what a match may cost; `clear` how many steps of the margin, of
    `lanindex.search.fuzzy.costs.BUCKETS`, symbols have at least which cost nothing.
    """

    def __init__(self, net: Net, columns: Columns, roster: Roster, most: int, clear: int = 0):
        self.net, self.columns, self._roster = net, columns, roster
        self.most = min(most, net.dearest)
        kinds = self._kinds = kinds_of(columns)
        self._tables = [kinds.table(state) for state in net.states]
        for state, table in zip(net.states, self._tables, strict=True):
            if "change" not in state.fits[0] or self.most < CHANGE:
                table[(table == 0) & (kinds.bucket < clear)] = NEVER
        self._lengths = [
            bounds_of(roster, state.length) if state.length else None for state in net.states
        ]
        self._able = np.any([table <= self.most for table in self._tables], axis=0)
        self._seeds = wanted(net, self._tables, kinds.counts, self.most)
        self.rarity = int(kinds.counts[self._seeds].sum())
        """How many symbols there are of which a match has one."""

    def matches(self, among: IntArray | None, ask: Ask) -> Found:
        """Return its matches in some captures, the best one from each row where some begin.

        `among` are (D,) places of the captures, growing; None: all.
        """
        rows, whole = self._seeds_among(among)
        if self.net.stays:
            return self._of(*self._stays(rows, ask))
        return self._of(*self.moves(rows, whole, ask))

    def _seeds_among(self, among: IntArray | None) -> tuple[IntArray, bool]:
        """Return rows of which a match covers one, or the beginnings of all stretches."""
        bounds, begins = self.columns.bounds, self._kinds.begins
        within = (bounds[:-1], bounds[1:]) if among is None else (bounds[among], bounds[among + 1])
        if FEW * self.rarity > int((within[1] - within[0]).sum()):
            _, rows = ranges(*within)
            return (rows if self.net.stays else rows[begins[rows]]), True
        rows = self._kinds.where(self._seeds)
        if among is not None:
            place = np.searchsorted(within[0], rows, side="right") - 1
            rows = rows[(place >= 0) & (rows < within[1][place])]
        return rows, False

    def costs(self, rows: IntArray) -> NDArray[np.int16]:
        """Return what symbols cost as each of the steps: (K, R)."""
        costs = np.empty((len(self.net.states), len(rows)), np.int16)
        for number, (state, table) in enumerate(zip(self.net.states, self._tables, strict=True)):
            costs[number] = substitutions(state, table, self.columns, rows)
            lengths = self._lengths[number]
            if lengths is not None:
                capture = captures_of(self.columns, rows)
                frames = self.columns.stop[rows].astype(np.int64) - self.columns.start[rows]
                lasting = (lengths[0][capture] <= frames) & (frames <= lengths[1][capture])
                costs[number, ~lasting | (frames == 0)] = NEVER
        return costs

    def moves(self, seeds: IntArray, whole: bool, ask: Ask) -> tuple[Keys, IntArray, IntArray]:
        """Return keys, first and last rows of what matches around some rows."""
        windows = around(self._kinds, seeds, self._able, self.net, self.most, whole)
        found = [self._aligned(block, ask) for block in windows.blocks()]
        none = np.empty(0, np.int64)
        keys, first, last = map(np.concatenate, zip(*found, (none, none, none), strict=True))
        return keys, first, last

    def _aligned(self, windows: Windows, ask: Ask) -> tuple[Keys, IntArray, IntArray]:
        """Return the same of some windows."""
        bounds, rows = ranges(windows.low, windows.high)
        code, take = self._kinds.code[rows], np.repeat(windows.take, np.diff(bounds))
        able, shown = self._able[code], ~self._kinds.passing[code]
        new = self._kinds.begins[rows]  # a track begins anew behind a gap
        new[bounds[:-1]] = True
        kept = np.flatnonzero(able)
        skipped = np.cumsum(shown & ~able)[kept]
        stretch = np.cumsum(new, dtype=np.int32)[kept]
        rows = rows[kept]
        symbols = Rows(
            np.diff(stretch, prepend=0) > 0,
            shown[kept],
            np.diff(skipped, prepend=0),
            self.costs(rows),
            blurs(self.columns.margin[rows]),
            *self._besides(rows),
        )
        keys = align(self.net, symbols, self.most, ask)
        ends = np.flatnonzero((keys != NOTHING) & (rows >= take[kept]))
        return keys[ends], rows[first_of(keys[ends])], rows[ends]

    @cached_property
    def _ends(self) -> Ends:
        return Ends(self.columns, self._roster)

    def _besides(self, rows: IntArray) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Return what it costs besides to begin and to end at some rows, where the line asks."""
        nothing, net = np.zeros((2, 1), np.int32), self.net
        return (
            self._ends.from_start(rows) if _asks(net.entry) else nothing,
            self._ends.to_end(rows) if _asks(net.exit) else nothing,
        )

    def _stays(self, rows: IntArray, ask: Ask) -> tuple[Keys, IntArray, IntArray]:
        """Return the same where it asks where the part is."""
        ask()
        (costs,) = self.costs(rows).astype(np.int64)
        blur = np.where(costs == 0, blurs(self.columns.margin[rows]), np.int16(0))
        within = (costs <= self.most) & (self.columns.cell[rows] & PASSING == 0)
        keys = key_of(costs, blur)[within]
        return keys, rows[within], rows[within]

    def _of(self, keys: Keys, first: IntArray, last: IntArray) -> Found:
        """Return matches as columns, of those that begin alike the best."""
        columns = self.columns
        start, until = columns.start[first].astype(np.int64), columns.stop[last].astype(np.int64)
        capture = captures_of(self.columns, first)
        still = np.flatnonzero((first == last) & (columns.start[last] == until))
        if self.net.stays:
            start = np.maximum(start, until - 1)
            until = leaving(columns, self._roster, last)
        else:
            until[still] = np.maximum(leaving(columns, self._roster, last[still]), until[still] + 1)
        found = Found(capture, start, until, cost_of(keys), blur_of(keys), first, last).cheapest()
        if self.net.stays:
            return found.chosen(found.start < found.until)
        moves = (found.first < found.last) | (columns.start[found.first] < columns.stop[found.last])
        return found.chosen(moves)  # a starting position alone is no match

    def own(self, row: int) -> int:
        """Return a row as counted in its own capture."""
        return row - int(self.columns.bounds[captures_of(self.columns, np.array(row))])

    def rows(self, first: int, last: int, cost: int) -> tuple[int, ...]:
        """Return the rows of the match from one row to another that costs so much."""
        if self.net.stays:
            return (first,)
        rows = np.arange(first, last + 1)
        entry, leave = self._besides(rows[[0]]), self._besides(rows[[-1]])
        stretch = Stretch(
            self.costs(rows),
            blurs(self.columns.margin[rows]),
            self.columns.cell[rows] & PASSING == 0,
            _least(self.net.entry, entry[0]),
            _least(self.net.exit, leave[1]),
        )
        return tuple(first + row for row, _ in trace(self.net, stretch, cost))


def _least(ways: tuple[tuple[int, ...], ...], besides: NDArray[np.int32]) -> list[int]:
    """Return what it costs at least to begin or end with each step, at one row."""
    every = [0, *besides[:, 0].tolist()]
    return [min(map(add, costs, every)) for costs in zip(*ways, strict=True)]


def _asks(ways: tuple[tuple[int, ...], ...]) -> bool:
    """Tell whether a line speaks of the clip's start, or its end."""
    return any(cost < FAR for way in (NEXT, LATER) for cost in ways[way])


def leaving(columns: Columns, roster: Roster, rows: IntArray) -> IntArray:
    """Return when the part leaves what some rows show: (R,) frames."""
    capture = captures_of(columns, rows)
    end = columns.bounds[capture + 1]
    after = rows + 1
    going = np.arange(len(rows))
    while len(going):
        going = going[after[going] < end[going]]
        going = going[columns.cell[after[going]] & PASSING > 0]
        after[going] += 1
    leaves = roster.frames[capture].astype(np.int64)
    inside = after < end
    leaves[inside] = columns.start[after[inside]]
    if not len(columns.gaps):
        return leaves
    whose, _, until = columns.gaps.astype(np.int64).T
    start = columns.start[rows].astype(np.int64)
    place = np.searchsorted(whose * LIFTED + until, capture * LIFTED + start, side="right")
    place = np.minimum(place, np.searchsorted(whose, capture, side="right") - 1)
    known = (place >= 0) & (whose[place] == capture)
    return np.where(known, np.minimum(leaves, until[place]), leaves)
