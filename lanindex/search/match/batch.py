"""Captures that are searched at once, with the rows of their parts and the events in them.

Rows are *shown* if the score shows them, else *passing*; nothing crosses a gap, so rows on both
sides of one are of different *stretches*.

Events are what may match a state of a program. A movement spans its row and is achieved in its last
frame; a stay (``at``) lasts from there until the part leaves; a rest (``hold``) from the row's end
to the next one's start. Of two parts at once each pair that shares a frame is one event.
"""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from math import floor

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import MOST_AMOUNT, is_limb
from lanindex.model.columns import (
    CELL,
    GRADES,
    PASSING,
    STARTING,
    THOUSANDTHS,
    Columns,
    Roster,
    columns_of,
    extras_of,
    graded,
    parted,
    ranges,
)
from lanindex.model.symbol import frozen
from lanindex.search.language.times import Clock, Length
from lanindex.search.language.words import AMOUNTS, STILL, WORD_KINDS
from lanindex.search.match.arrays import (
    FAR,
    AnyArray,
    BoolArray,
    IntArray,
    Table,
    grouped,
    once,
    spread,
    starts_of,
)
from lanindex.search.plan import NEGATIONS, Program, State, followers, reached

LARGE = 1 << 19
"""Rows of a part from which on batches have their full size; smaller libraries get smaller batches,
so that a search takes little memory beside the columns that it reads."""

FEWEST_ROWS = 1 << 14  # a batch may have in any library: each batch costs time of its own
CAPTURE = 4  # rows that a capture counts for at least: it has a length, bounds, a clock
MOST_STATES = 32  # steps of a line that `possible` looks at


class Rows:
    """The rows of one part in some captures, which are counted from 0.

    `places` (N,) int64 are those captures in the roster, growing, and `frames` (N,) their lengths.
    Their columns are narrow: rows are many, and few of them are looked at.
    """

    def __init__(self, columns: Columns, places: IntArray, frames: IntArray) -> None:
        self.frames, self._columns = frames, columns
        self._grades: dict[str, AnyArray] = {}
        firsts, behind = columns.bounds[places], columns.bounds[places + 1]
        self._here: AnyArray | slice
        if len(places) and places[-1] - places[0] < len(places):  # views, where all are wanted
            self.bounds = np.append(firsts, behind[-1]) - firsts[0]
            self._here = slice(int(firsts[0]), int(behind[-1]))
        else:
            self.bounds, here = ranges(firsts, behind)
            self._here = here.astype(np.int32)
        # (S,) int32 each but for the cell, uint8 as in `Columns`
        self.capture = np.repeat(np.arange(len(places), dtype=np.int32), np.diff(self.bounds))
        self.cell = columns.cell[self._here]
        self.start: AnyArray = columns.start[self._here]
        self.stop: AnyArray = columns.stop[self._here]
        self.passing: BoolArray = (self.cell & PASSING) > 0
        self.starting: BoolArray = (self.cell & STARTING) > 0
        begins = self.starting.copy()
        begins[self.bounds[:-1][self.bounds[:-1] < self.bounds[1:]]] = True
        if not is_limb(columns.part) and len(columns.seen):
            begins |= parted(places[self.capture], self.start, columns.seen)
        self.stretch = np.cumsum(begins, dtype=np.int32) - 1  # (S,) counted over all captures
        self.stretch_rows = np.append(np.flatnonzero(begins), len(self.cell))  # (stretches + 1,)
        self.stretch_begin, self.stretch_end = self._stretch_bounds(columns.seen, places)

    def __len__(self) -> int:
        return len(self.cell)

    def _stretch_bounds(self, seen: AnyArray, places: IntArray) -> tuple[IntArray, IntArray]:
        """Return the first frame of each stretch and the one behind its last, (stretches,)."""
        rows = self.stretch_rows[:-1]
        capture, start = self.capture[rows], self.start[rows].astype(np.int64)
        begin, end = np.zeros_like(start), self.frames[capture]
        if not len(rows) or not len(seen):
            return begin, end
        seen = seen[slice(*np.searchsorted(seen[:, 0], places[[0, -1]] + (0, 1)))].astype(np.int64)
        own = places[capture]
        begin = np.where(np.isin(own, seen[:, 0]), start, begin)
        seen = seen[seen[:, 1] < seen[:, 2]]  # a part that was never seen has one without frames
        place = np.searchsorted(seen[:, 0] * FAR + seen[:, 1], own * FAR + start, "right") - 1
        known, first, last = np.append(seen, [[-1, 0, 0]], axis=0)[place].T
        inside = (known == own) & (start <= last)
        return np.where(inside, first, begin), np.where(inside, last, end)

    def of_rows(self, values: AnyArray) -> AnyArray:
        """Return those of these rows, (S,), of values of all rows of the columns."""
        found: AnyArray = values[self._here]
        return found

    @cached_property
    def runner(self) -> AnyArray:
        """The cell across the nearest border of each row, (S,) uint8."""
        return self._columns.runner[self._here]

    @cached_property
    def amount(self) -> AnyArray:
        """The amount of each row, (S,) int16; -1: it has none."""
        held = self._columns.amount
        return np.full(len(self), -1, np.int16) if held is None else held[self._here]

    def measure(self, name: str) -> AnyArray:
        """Return swings or a measure of each row, (S,) as columns have it; 0: not known."""
        held: AnyArray | None = getattr(self._columns, name)
        if held is None:
            if len(self) and name in extras_of(self._columns.part):
                raise ValueError(f"the {name} of {self._columns.part} was not read")
            return np.zeros(len(self), np.uint16)
        return held[self._here]

    def grade(self, kind: str) -> AnyArray:
        """Return the grade of each row's speed or size, (S,) int8; -1: it is not known."""
        if kind not in self._grades:
            values = self.measure(GRADES[kind])
            self._grades[kind] = graded(self._columns.part, kind, values)
        return self._grades[kind]

    @cached_property
    def cost(self) -> AnyArray:
        """What is missing to a margin of 1, in thousandths, (S,) int16."""
        return THOUSANDTHS - self._columns.margin[self._here].astype(np.int16)

    @cached_property
    def shown(self) -> AnyArray:
        """Which rows are shown, int32."""
        return np.flatnonzero(~self.passing).astype(np.int32)

    @cached_property
    def rank(self) -> AnyArray:
        """How many shown rows come before each, (S + 1,) int32."""
        rank = np.zeros(len(self) + 1, np.int32)
        np.cumsum(~self.passing, out=rank[1:])
        return rank

    def until(self, rows: IntArray) -> IntArray:
        """Return until when each of some shown rows is the last."""
        behind, stretch = self.rank[rows + 1], self.stretch[rows]
        after = self.row_of(behind + 1) - 1
        follows = (behind < len(self.shown)) & (self.stretch[after] == stretch)
        return np.where(follows, self.start[after], self.stretch_end[stretch])

    @cached_property
    def change(self) -> AnyArray:
        """How each row's level compares with the one before it, (S,) int8 codes."""
        codes = WORD_KINDS["change"].codes
        level = ((self.cell >> 4) & 3).astype(np.int8) - 1
        change = np.where(level >= 0, np.int8(codes["neither"]), np.int8(-1))
        before, after = level[self.shown[:-1]], level[self.shown[1:]]
        changed = (np.diff(self.stretch[self.shown]) == 0) & (before != after)
        changed &= np.minimum(before, after) >= 0
        codes_there = np.where(before < after, codes["rising"], codes["sinking"]).astype(np.int8)
        change[self.shown[1:][changed]] = codes_there[changed]
        return change

    @cached_property
    def arrival(self) -> AnyArray:
        """The frame in which each row is achieved, (S,) int32."""
        arrival: AnyArray = np.where(self.starting, self.start, self.stop - 1)
        return arrival

    @cached_property
    def left_at_once(self) -> BoolArray:
        """Which rows are starting positions that alone are no stay, (S,) bool."""
        left, rows = np.zeros(len(self), bool), np.flatnonzero(self.starting)
        left[rows] = self.until(rows) <= self.start[rows]
        return left

    def row_of(self, rank: IntArray) -> IntArray:
        """Return the first row before which at least so many rows are shown."""
        row: IntArray = self._behind[np.clip(rank, 0, len(self._behind) - 1)].astype(np.int64)
        return row

    @cached_property
    def _behind(self) -> AnyArray:
        """The first row, those behind each shown one, and that behind the last, int32."""
        return np.concatenate(([0], self.shown + 1, [len(self)]), dtype=np.int32)

    def beginnings(self, manner: str) -> tuple[IntArray, IntArray]:
        """Return the shown rows that begin something, and when: a movement, stay or rest."""
        rows, frames = self.shown, self.start
        if manner == "at":
            frames = self.arrival
        elif manner == "hold":
            rows, frames = rows[self.stop[rows] < self.until(rows)], self.stop
        else:
            rows = rows[~self.starting[rows]]
        return rows.astype(np.int64), frames[rows].astype(np.int64)

    @cached_property
    def _stretch_keys(self) -> IntArray:
        """Capture and first frame of each stretch as one number, growing."""
        capture = self.capture[self.stretch_rows[:-1]].astype(np.int64)
        keys: IntArray = capture * FAR + self.stretch_begin
        return keys

    def stretch_at(self, capture: IntArray, frame: IntArray) -> IntArray:
        """Return the stretch of a capture that a frame lies in, -1: in none."""
        keys = self._stretch_keys
        if not len(keys):
            return np.full(len(frame), -1)
        place = np.searchsorted(keys, capture * FAR + frame, "right") - 1
        found = np.searchsorted(keys, keys[np.maximum(place, 0)])
        same = self.capture[self.stretch_rows[found]] == capture
        return np.where((place >= 0) & same & (frame < self.stretch_end[found]), found, -1)


@dataclass(slots=True, eq=False)
class Events(Table):
    """Movements, stays or rests, in order of their rows."""

    capture: IntArray  # (N,)
    first: tuple[IntArray, ...]  # (N,) a member: its first row
    last: tuple[IntArray, ...]  # (N,) a member: its last row, another one of stays only
    start: IntArray  # (N,) frames, half-open
    end: IntArray
    until: IntArray  # (N,) the end for sharing frames
    cost: IntArray  # (N,) what is missing to a fit of 1, in thousandths
    passing: BoolArray  # (N,) whether a member is passing
    starting: BoolArray  # (N,) whether a member is a starting position

    def __len__(self) -> int:
        return len(self.capture)


def cells_of(state: State, member: int) -> BoolArray:
    """Return which cells a state asks for, (256,) bool, whatever their flags."""
    return _cells(frozenset(state.fits[member].items()))


@lru_cache(256)
def _cells(fits: frozenset[tuple[str, frozenset[int]]]) -> BoolArray:
    cells = np.arange(256)
    table = np.ones(256, bool)
    fields = {"direction": (cells & 15) - 1, "level": ((cells & CELL) >> 4) - 1}
    for kind, codes in fits:
        if kind in fields:
            table &= np.isin(fields[kind], sorted(codes))
    return frozen(table)


def fitting(rows: Rows, state: State, member: int) -> tuple[BoolArray, IntArray]:
    """Return which rows fit a member of a state, and what each lacks to a fit of 1.

    With `near` a row also fits by the cell across its nearest border, if that is near enough.
    """
    table, wanted = cells_of(state, member), state.fits[member]
    fits, cost = table[rows.cell], rows.cost
    if state.near:
        margin = THOUSANDTHS - cost.astype(np.int64)
        across = ~fits & table[rows.runner] & (margin < state.near)
        # the border lies so much further out
        inside = state.near + np.where(across, -margin, margin)
        cost = THOUSANDTHS - inside * THOUSANDTHS // (state.near + THOUSANDTHS)
        fits |= across
    if "change" in wanted:
        fits &= np.isin(rows.change, sorted(wanted["change"]))
    for kind in AMOUNTS:
        if kind in wanted:
            fits &= _amounts(wanted[kind])[rows.amount]
    if STILL in wanted:
        fits &= rows.measure("swings") == 0
    for kind in GRADES:
        if kind in wanted:
            fits &= np.isin(rows.grade(kind), sorted(wanted[kind]))
    return fits, cost


@lru_cache(64)
def _amounts(codes: frozenset[int]) -> BoolArray:
    """Return which amounts are among some codes; the last entry is for rows without an amount."""
    table = np.zeros(MOST_AMOUNT + 2, bool)
    table[list(codes)] = True
    return frozen(table)


def events_of(rows: Rows, state: State, member: int) -> Events:
    """Return the events that may match a member of a state."""
    fits, cost = fitting(rows, state, member)
    if state.manner == "at":
        return _stays(rows, fits, cost)
    if state.manner == "hold":
        row = rows.shown[fits[rows.shown]].astype(np.int64)
        return _waiting(rows, row, row, rows.stop[row], cost[row])
    row = np.flatnonzero(fits if state.names_passing else fits & ~rows.passing)
    start, end = rows.start[row].astype(np.int64), rows.stop[row].astype(np.int64)
    starting = rows.starting[row]
    until, waiting = end.copy(), np.flatnonzero(starting)
    until[waiting] = np.maximum(rows.until(row[waiting]), start[waiting] + 1)
    capture, cost = rows.capture[row].astype(np.int64), cost[row].astype(np.int64)
    return Events(capture, (row,), (row,), start, end, until, cost, rows.passing[row], starting)


def _stays(rows: Rows, fits: BoolArray, cost: IntArray) -> Events:
    """Return the stays where rows fit: of shown rows in a row in one stretch."""
    shown = np.flatnonzero(fits[rows.shown])
    row = rows.shown[shown].astype(np.int64)
    begins = np.flatnonzero(starts_of(shown - np.arange(len(shown)), rows.stretch[row]))
    if not len(row):
        return _waiting(rows, row, row, row, row)
    first, last = row[begins], row[np.append(begins[1:], len(row)) - 1]
    worst = np.maximum.reduceat(cost[row], begins)
    return _waiting(rows, first, last, rows.arrival[first], worst)


def _waiting(
    rows: Rows, first: IntArray, last: IntArray, start: AnyArray, cost: AnyArray
) -> Events:
    """Return the stays or rests of some rows that last until the part leaves, if any time."""
    end, no = rows.until(last), np.zeros(len(first), bool)
    capture, start, cost = (it.astype(np.int64) for it in (rows.capture[first], start, cost))
    found = Events(capture, (first,), (last,), start, end, end, cost, no, no)
    return found.at(start < end)


def _overlapping(one: Events, other: Events) -> tuple[IntArray, IntArray]:
    """Return all pairs of events of a capture that share a frame, in order."""
    ones, others = (it.capture * FAR + it.start for it in (one, other))
    by_one, by_other = (np.argsort(keys, kind="stable") for keys in (ones, others))
    ones, others = ones[by_one], others[by_other]
    # Either the other begins while the one lasts, or the one after the other did, while it lasts.
    until = one.capture * FAR + one.until
    low = np.searchsorted(others, one.capture * FAR + one.start)
    first, second = spread(low, np.searchsorted(others, until))
    until = other.capture * FAR + other.until
    low = np.searchsorted(ones, other.capture * FAR + other.start, "right")
    fourth, third = spread(low, np.searchsorted(ones, until))
    left = np.concatenate((first, by_one[third]))
    right = np.concatenate((by_other[second], fourth))
    order = np.lexsort((right, left))
    return left[order], right[order]


def paired(manner: str, one: Events, other: Events) -> Events:
    """Return the pairs of two parts' events that share a frame.

    Two movements span both; two stays or rests last while both do.
    """
    left, right = _overlapping(one, other)
    one, other = one.at(left), other.at(right)
    together = manner in ("at", "hold")
    start = (np.maximum if together else np.minimum)(one.start, other.start)
    end = np.minimum(one.until, other.until) if together else np.maximum(one.end, other.end)
    return Events(
        one.capture,
        one.first + other.first,
        one.last + other.last,
        start,
        end,
        end if together else np.maximum(one.until, other.until),
        np.maximum(one.cost, other.cost),
        one.passing | other.passing,
        one.starting | other.starting,
    )


class Batch:
    """Some captures of a roster; here they are counted from 0.

    `places` (N,) int64 are those captures in the roster, growing. A part without columns never
    moves. Edges that should agree may differ by `tolerance` seconds.
    """

    def __init__(
        self, roster: Roster, columns: Mapping[str, Columns], places: IntArray, tolerance: Fraction
    ) -> None:
        self.places, self.tolerance = places, tolerance
        self._roster, self._columns = roster, columns
        self.frames = roster.frames[places].astype(np.int64)
        self._clocks: tuple[list[Clock], IntArray] | None = None
        self._rows: dict[str, Rows] = {}
        self._events: dict[object, Events] = {}
        self._bounds: dict[Length, tuple[IntArray, IntArray]] = {}

    def __len__(self) -> int:
        return len(self.places)

    def rows(self, part: str) -> Rows:
        """Return the rows of a part; none, where there is no such part."""
        if part not in self._rows:
            columns = self._columns.get(part)
            if columns is None:
                bounds = np.zeros(len(self._roster) + 1, np.int64)
                columns = replace(columns_of(part, [], []), bounds=bounds)
            self._rows[part] = Rows(columns, self.places, self.frames)
        return self._rows[part]

    def events(self, state: State) -> Events:
        """Return the events that may match a state, of the lengths that it allows."""
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
            if _KEPT not in self._roster.kept:
                ratios = np.concatenate((self._roster.rate, self._roster.speed), axis=1)
                first, which = grouped(tuple(ratios.T))
                self._roster.kept[_KEPT] = ratios[first], which.astype(np.int32)
            ratios, which = self._roster.kept[_KEPT]
            own = which[self.places]
            used = once(own)
            clocks = [
                Clock(Fraction(a, b), Fraction(c, d) / 60) for a, b, c, d in ratios[used].tolist()
            ]
            self._clocks = clocks, np.searchsorted(used, own)
        return self._clocks

    @cached_property
    def slack(self) -> IntArray:
        """By how many frames edges may differ that should agree, by capture."""
        clocks, own = self.clocks()
        slack = [floor(self.tolerance * clock.rate) for clock in clocks]
        return np.array(slack, np.int64)[own]

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
    fits = tuple(frozenset(wanted.items()) for wanted in state.fits)
    return state.members, state.manner, fits, state.names_passing, state.length, state.near


def split(
    columns: Collection[Columns], places: IntArray, most: int, library: int = 0
) -> list[IntArray]:
    """Split captures into batches of at most `most` rows of each part; a capture has `CAPTURE`.

    Batches are smaller in a library smaller than `LARGE`; a single capture may have more rows.
    `library` is how many rows of a part it has, where these columns are only some of it.
    """
    library = library or max(map(len, columns), default=0)
    rows = max(min(most, FEWEST_ROWS), most * min(library, LARGE) // LARGE)
    longest = np.full(len(places), CAPTURE)
    for own in columns:
        np.maximum(longest, np.diff(own.bounds)[places], out=longest)
    slab = np.cumsum(longest) // rows
    return np.split(places, np.flatnonzero(starts_of(slab))[1:]) if len(places) else []


def possible(
    programs: Iterable[Program], columns: Mapping[str, Columns], captures: int
) -> BoolArray:
    """Return in which captures one of some programs can match, (captures,) bool."""
    found = np.zeros(captures, bool)
    for program in programs:
        own = np.ones(captures, bool)
        for state in unavoidable(program):
            for member, part in enumerate(state.members):
                if part not in columns:
                    own[:] = False
                    continue
                wanted = np.flatnonzero(cells_of(state, member)[: CELL + 1]).tolist()
                own &= _cells_in(columns[part]) & np.uint64(sum(1 << it for it in wanted)) > 0
        for companion in program.outermost.companions:
            if companion.relation not in NEGATIONS:
                own &= possible(companion.programs, columns, captures)
        found |= own
    return found


def _cells_in(columns: Columns) -> NDArray[np.uint64]:
    """Return which cells each capture has, a bit each: (C,) uint64; kept with the columns."""
    if __name__ not in columns.kept:
        bits = np.left_shift(np.uint64(1), columns.cell & CELL, dtype=np.uint64)
        some = np.flatnonzero(np.diff(columns.bounds))
        found = np.zeros(len(columns.bounds) - 1, np.uint64)
        if len(some):
            found[some] = np.bitwise_or.reduceat(bits, columns.bounds[some])
        columns.kept[__name__] = found
    kept: NDArray[np.uint64] = columns.kept[__name__]
    return kept


def unavoidable(program: Program) -> list[State]:
    """Return states that every match of a program takes; not those that a near symbol may fit."""
    return [
        state
        for state in program.states[:MOST_STATES]
        if not state.near and not _can_leave_out(program, state.number)
    ]


def _can_leave_out(program: Program, state: int) -> bool:
    following = [[it for it in after if it != state] for after in followers(program)]
    begins = {entry.state for entry in program.entries} - {state}
    taken = begins.union(*(reached(following, it) for it in begins))
    return any(program.exits[it] for it in taken)
