"""In which captures a pattern can have a hit at all, told from single symbols and their order.

Each step that no way through a line can leave out wants one symbol at least of its directions and
heights. Most captures lack one for some step; most others have them in another order: each row of a
part is looked at once, with all places where a match could stand as the bits of one number. What is
not found here cannot match; what is found may.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import CELL, PASSING, STARTING, Columns
from lanindex.search.automaton import NEGATIONS, Edge, Program, State
from lanindex.search.language.query import Arrow
from lanindex.search.language.times import Length
from lanindex.search.match.arrays import BoolArray, IntArray
from lanindex.search.match.batch import Batch
from lanindex.search.match.scan import cells_of

MOST_STATES = 63
"""Steps of a line that are numbered by the bits of one number."""

FEW = 64
"""Captures left of which the plain way looks no further: they may match."""

Bits = NDArray[np.uint64]


@dataclass(frozen=True, slots=True, eq=False)
class Order:
    """What a program asks of the rows of one part: a set of places is a number, a bit each.

    Attributes
    ----------
    accepts : ndarray
        (256,) uint64: by cell, the places that it fits.
    first, last : ndarray
        (2, 2) uint64: where a match may begin, and where it may end; and the same of those that do
        so only at the very start or end of a capture. At a passing row, and at others.
    timed : tuple of (int, Length, bool)
        The places that want their rows to last for some time, what it is, and whether that is all
        of it: of two parts at once either may last less long.
    following : ndarray
        (4, N) uint64: by place, those that may come with the next row of the score, with any later
        one of the stretch, with the same one, and with the same or any later one of the capture.
    """

    accepts: Bits
    first: Bits
    last: Bits
    timed: tuple[tuple[int, Length, bool], ...]
    following: Bits


NEXT, LATER, SAME, EVER = range(4)


def order_of(program: Program, part: str) -> Order | None:
    """Return what a program asks of the rows of a part, None if that is nothing or too much."""
    own = [state for state in program.states if part in state.members]
    if len(own) > MOST_STATES:
        return None
    bits = {state.number: 1 << place for place, state in enumerate(own)}
    begun = {entry.state for entry in program.entries}
    elsewhere, leaves = _beyond(program, begun - bits.keys(), bits)
    if leaves:
        return None
    free = {it.state for it in program.entries if not _close(it.from_start)}
    first = _ends(own, free, begun, bits, elsewhere)
    following, elsewhere = np.zeros((4, len(own)), np.uint64), 0
    for place, state in enumerate(own):
        if state.manner == "at":  # it lasts for several rows
            following[NEXT, place] |= np.uint64(1 << place)
        for edge in program.edges[state.number]:
            bit = bits.get(edge.entry.state)
            if bit and edge.same:
                for kind in _kinds(edge, program):
                    following[kind, place] |= np.uint64(bit)
            else:
                found, leaves = _beyond(program, [edge.entry.state], bits)
                following[EVER, place] |= np.uint64(found)
                elsewhere |= bits[state.number] * leaves
    exits = [it for leaving in program.exits for it in leaving]
    free = {it.state for it in exits if not _close(it.to_end)}
    last = _ends(own, free, {it.state for it in exits}, bits, elsewhere)
    timed = tuple(
        (bits[state.number], state.length, len(state.members) == 1)
        for state in own
        if state.length and state.manner in ("move", "via")
    )
    return Order(_accepted(own, part), first, last, timed, following)


def _close(arrows: Iterable[Arrow]) -> bool:
    """Tell whether nothing may lie between a step and the start, or the end, of its capture."""
    return any(arrow.bounds[1] == 0 for arrow in arrows)


def _ends(
    states: list[State], free: set[int], every: set[int], bits: dict[int, int], elsewhere: int
) -> Bits:
    """Return where a match may begin or end, as in `Order`.

    It does so anywhere at the states that are `free`, and at the start or end of a capture at
    `every` one; at a passing row only of `via`. It goes on from those of the set `elsewhere`.
    """
    found = np.zeros((2, 2), np.uint64)
    for row, ending in enumerate((free, every - free)):
        for state in states:
            if state.number in ending:
                found[row, 1] |= np.uint64(bits[state.number])
                found[row, 0] |= np.uint64(bits[state.number] * (state.manner == "via"))
    found[0] |= np.uint64(elsewhere)
    return found


def _kinds(edge: Edge, program: Program) -> Iterator[int]:
    """Yield how an edge leads on among the rows of its part."""
    source, target = program.states[edge.exit.state], program.states[edge.entry.state]
    yield LATER if edge.arrow.later else NEXT
    if target.manner == "hold" and source.manner not in ("at", "hold"):
        yield SAME


def _beyond(program: Program, states: Iterable[int], bits: dict[int, int]) -> tuple[int, bool]:
    """Return the places that are reached over states of other parts alone, and if the end is."""
    found, ends = 0, False
    todo = list(states)
    seen = set(todo)
    while todo:
        state = todo.pop()
        if state in bits:
            found |= bits[state]
            continue
        ends |= bool(program.exits[state])
        after = {edge.entry.state for edge in program.edges[state]} - seen
        seen |= after
        todo += after
    return found, ends


def _accepted(states: list[State], part: str) -> Bits:
    """Return by cell the places whose states it fits."""
    cells = np.arange(256)
    accepts = np.zeros(256, np.uint64)
    for place, state in enumerate(states):
        fits = np.zeros(256, bool)
        for member, other in enumerate(state.members):
            if other == part:
                fits |= cells_of(state, member) | bool(state.near)
        if state.manner in ("at", "hold") or not state.names_passing:
            fits &= cells & PASSING == 0
        accepts[fits] |= np.uint64(1 << place)
    return accepts


def in_order(order: Order, columns: Columns, captures: IntArray, batch: Batch) -> BoolArray:
    """Return in which of some captures an order occurs, (N,) bool.

    Parameters
    ----------
    order : Order
        What is asked.
    columns : Columns
        Of its part.
    captures : ndarray
        (N,) int64, growing.
    batch : Batch
        Of all captures.
    """
    return plainly(order, columns, captures, _limits(order, batch))


def _limits(order: Order, batch: Batch) -> tuple[Bits, IntArray]:
    """Return the places with limits on time, (K,), and by capture the limits: (K, 2, C) frames."""
    places = np.array([bit for bit, _, _ in order.timed], np.uint64)
    limits = np.zeros((len(order.timed), 2, len(batch) if order.timed else 0), np.int64)
    for number, (_, length, whole) in enumerate(order.timed):
        least, most = batch.bounds(length)
        limits[number] = least * whole, most
    return places, limits


def plainly(
    order: Order, columns: Columns, captures: IntArray, limits: tuple[Bits, IntArray]
) -> BoolArray:
    """Return the same as `in_order`, without what is compiled: row by row in all captures.

    As soon as only a few captures are left that have so many rows, they are taken to match.
    """
    found = np.zeros(len(captures), bool)
    row, behind = columns.bounds[captures], columns.bounds[captures + 1]
    place = np.flatnonzero(row < behind)
    pending, later, ever, closing = (np.zeros(len(place), np.uint64) for _ in range(4))
    seen = np.zeros(len(place), np.int64)
    while len(place) > FEW:
        cell = columns.cell[row[place]]
        begins, shown = cell & STARTING > 0, (cell & PASSING == 0).astype(np.int8)
        pending[begins] = later[begins] = 0
        accepted = _in_time(order.accepts[cell], columns, row[place], captures[place], limits)
        opening = order.first[1, shown] * (seen <= 1)
        active = accepted & (order.first[0, shown] | opening | pending | later | ever)
        pending[shown > 0] = closing[shown > 0] = 0
        seen += shown
        todo = active
        while todo.any():
            reached = [np.zeros(len(place), np.uint64) for _ in order.following]
            for number, leading in enumerate(order.following.T):
                here = todo >> np.uint64(number) & np.uint64(1)
                for bits, to in zip(reached, leading, strict=True):
                    bits |= here * to
            pending |= reached[NEXT]
            later |= reached[LATER]
            ever |= reached[EVER]
            todo = accepted & (reached[SAME] | reached[EVER]) & ~active
            active |= todo
        closing |= active & order.last[1, shown]
        found[place] = active & order.last[0, shown] > 0
        row[place] += 1
        ended = row[place] == behind[place]
        found[place[ended]] |= closing[ended] > 0
        on = ~ended & ~found[place]
        place, pending, later, ever = place[on], pending[on], later[on], ever[on]
        closing, seen = closing[on], seen[on]
    found[place] = True
    return found


def _in_time(
    accepted: Bits,
    columns: Columns,
    rows: IntArray,
    captures: IntArray,
    limits: tuple[Bits, IntArray],
) -> Bits:
    """Return the places that rows fit, without those that want them to last otherwise."""
    lasts = columns.stop[rows].astype(np.int64) - columns.start[rows]
    for place, (least, most) in zip(*limits, strict=True):
        wrong = (lasts < least[captures]) | (lasts > most[captures])
        accepted = np.where(wrong, accepted & ~place, accepted)
    return accepted


MOST_STATES = 32
"""Steps of a line that are looked at."""


class Prefilter:
    """Tells in which captures programs can match.

    Parameters
    ----------
    columns : Mapping of str to Columns
        By part; one that is not there never moves.
    batch : Batch
        All captures.
    """

    def __init__(self, columns: Mapping[str, Columns], batch: Batch) -> None:
        self._columns, self._batch, self._captures = columns, batch, len(batch)

    def possible(self, programs: Sequence[Program]) -> BoolArray:
        """Return in which captures one of some programs can match, (C,) bool."""
        found = np.zeros(self._captures, bool)
        for program in programs:
            found |= self._of(program)
        return found

    def _of(self, program: Program) -> BoolArray:
        found = self._with_all(program)
        self._put_in_order(program, found)
        return found

    def _with_all(self, program: Program) -> BoolArray:
        """Return which captures have the symbols of a program, and of the lines beside it."""
        found = np.ones(self._captures, bool)
        for state in unavoidable(program):
            for member in range(len(state.members)):
                found &= self._with(state, member)
        for companion in _needed(program):
            found &= np.any([self._with_all(it) for it in companion], axis=0)
        return found

    def _put_in_order(self, program: Program, found: BoolArray) -> None:
        """Leave out those captures that have them in another order: parts with few rows first."""
        parts = {part for state in program.states for part in state.members} & {*self._columns}
        for part in sorted(parts, key=lambda it: (len(self._columns[it]), it)):
            if order := order_of(program, part):
                captures = np.flatnonzero(found)
                found[captures] = in_order(order, self._columns[part], captures, self._batch)
        for companion in _needed(program):
            others = np.zeros(self._captures, bool)
            for inner in companion:
                own = found & ~others
                self._put_in_order(inner, own)
                others |= own
            found &= others

    def _with(self, state: State, member: int) -> BoolArray:
        """Return which captures have a symbol that a state asks for."""
        table, part = cells_of(state, member)[: CELL + 1], state.members[member]
        if part not in self._columns:
            return np.zeros(self._captures, bool)
        asked = sum(1 << cell for cell in np.flatnonzero(table).tolist())
        found: BoolArray = cells_in(self._columns[part]) & np.uint64(asked) > 0
        return found


_CELLS: WeakKeyDictionary[Columns, Bits] = WeakKeyDictionary()


def cells_in(columns: Columns) -> Bits:
    """Return which cells each capture has, a bit each: (C,) uint64; kept as long as the columns."""
    if columns not in _CELLS:
        bits = np.left_shift(np.uint64(1), columns.cell & CELL, dtype=np.uint64)
        some = np.flatnonzero(np.diff(columns.bounds))
        found = np.zeros(len(columns.bounds) - 1, np.uint64)
        if len(some):
            found[some] = np.bitwise_or.reduceat(bits, columns.bounds[some])
        _CELLS[columns] = found
    return _CELLS[columns]


def _needed(program: Program) -> list[tuple[Program, ...]]:
    """Return the lines that must be beside a program, each with its alternatives."""
    return [it.programs for it in program.whole.companions if it.relation not in NEGATIONS]


def unavoidable(program: Program) -> list[State]:
    """Return states that every way through a program takes; not those that a near symbol may fit.

    Of a long line only the first few are looked at.
    """
    return [
        state
        for state in program.states[:MOST_STATES]
        if not state.near and not _passes(program, state.number)
    ]


def _passes(program: Program, left_out: int) -> bool:
    """Tell whether a way leads through a program without one of its states."""
    todo = [entry.state for entry in program.entries if entry.state != left_out]
    seen = set(todo)
    while todo:
        state = todo.pop()
        if program.exits[state]:
            return True
        after = {edge.entry.state for edge in program.edges[state]} - seen - {left_out}
        seen |= after
        todo += after
    return False
