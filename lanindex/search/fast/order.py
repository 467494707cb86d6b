"""In which captures the steps of a line occur in its order, whatever else it says.

Each row of a part is looked at once, with all places where a match could stand as the bits of one
number. Times, lengths and gaps to other parts are left out, so that what is not found here cannot
match; what is found may.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import PASSING, STARTING, Columns
from lanindex.search.automaton import Edge, Program, State
from lanindex.search.fast import compiled
from lanindex.search.fast.events import cells_of
from lanindex.search.fast.ragged import Mask, Whole

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
        (2,) uint64: where a match may begin, and where it may end; at a passing row, and at others.
    following : ndarray
        (4, N) uint64: by place, those that may come with the next row of the score, with any later
        one of the stretch, with the same one, and with the same or any later one of the capture.
    """

    accepts: Bits
    first: Bits
    last: Bits
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
    first, last = _ends(own, begun, bits, elsewhere), np.zeros(2, np.uint64)
    following = np.zeros((4, len(own)), np.uint64)
    for place, state in enumerate(own):
        if state.manner == "at":  # it lasts for several rows
            following[NEXT, place] |= np.uint64(1 << place)
        elsewhere = 0
        for edge in program.edges[state.number]:
            bit = bits.get(edge.entry.state)
            if bit and edge.same:
                for kind in _kinds(edge, program):
                    following[kind, place] |= np.uint64(bit)
            else:
                found, leaves = _beyond(program, [edge.entry.state], bits)
                following[EVER, place] |= np.uint64(found)
                elsewhere |= bits[state.number] * leaves
        ending = {state.number} if program.exits[state.number] else set()
        last |= _ends(own, ending, bits, elsewhere)
    return Order(_accepted(own, part), first, last, following)


def _ends(states: list[State], ending: set[int], bits: dict[int, int], elsewhere: int) -> Bits:
    """Return where a match may begin or end, at a passing row and at others.

    It does so at those of `states` that are among `ending`, at a passing row only of `via`; and it
    goes on elsewhere from those of the set `elsewhere`.
    """
    through = sum(bits[it.number] for it in states if it.number in ending and it.manner == "via")
    every = sum(bits[it.number] for it in states if it.number in ending)
    return np.array([through | elsewhere, every | elsewhere], np.uint64)


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


def in_order(order: Order, columns: Columns, captures: Whole) -> Mask:
    """Return in which of some captures an order occurs, (N,) bool.

    Parameters
    ----------
    order : Order
        What is asked.
    columns : Columns
        Of its part.
    captures : ndarray
        (N,) int64, growing.
    """
    fast = compiled.chosen(len(columns))
    if fast is None:
        return plainly(order, columns, captures)
    found = np.zeros(len(captures), bool)
    asked = order.accepts, order.first, order.last, order.following
    fast.in_order(columns.cell, columns.bounds, captures, *asked, found)
    return found


def plainly(order: Order, columns: Columns, captures: Whole) -> Mask:
    """Return the same as `in_order`, without what is compiled: row by row in all captures.

    As soon as only a few captures are left that have so many rows, they are taken to match.
    """
    found = np.zeros(len(captures), bool)
    row, behind = columns.bounds[captures], columns.bounds[captures + 1]
    place = np.flatnonzero(row < behind)
    pending, later, ever = (np.zeros(len(place), np.uint64) for _ in range(3))
    while len(place) > FEW:
        cell = columns.cell[row[place]]
        begins, passing = cell & STARTING > 0, cell & PASSING > 0
        pending[begins] = later[begins] = 0
        accepted = order.accepts[cell]
        shown = (~passing).astype(np.int8)
        active = accepted & (order.first[shown] | pending | later | ever)
        pending[~passing] = 0
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
        found[place] = active & order.last[shown] > 0
        row[place] += 1
        on = (row[place] < behind[place]) & ~found[place]
        place, pending, later, ever = place[on], pending[on], later[on], ever[on]
    found[place] = True
    return found
