"""In which captures the steps of a line occur in its order, whatever else it says.

Each row of a part is looked at once, with all places where a match could stand as the bits of one
number. What lies between movements, and how long stays and rests last, is left out, so that what
is not found here cannot match; what is found may.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import PASSING, STARTING, Columns
from lanindex.search.automaton import Edge, Program, State
from lanindex.search.fast.block import Block
from lanindex.search.fast.events import cells_of
from lanindex.search.fast.ragged import Mask, Whole
from lanindex.search.language.query import Arrow
from lanindex.search.language.times import Length

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


def in_order(order: Order, columns: Columns, captures: Whole, block: Block) -> Mask:
    """Return in which of some captures an order occurs, (N,) bool.

    Parameters
    ----------
    order : Order
        What is asked.
    columns : Columns
        Of its part.
    captures : ndarray
        (N,) int64, growing.
    block : Block
        Of all captures.
    """
    return plainly(order, columns, captures, _limits(order, block))


def _limits(order: Order, block: Block) -> tuple[Bits, Whole]:
    """Return the places with limits on time, (K,), and by capture the limits: (K, 2, C) frames."""
    places = np.array([bit for bit, _, _ in order.timed], np.uint64)
    limits = np.zeros((len(order.timed), 2, len(block) if order.timed else 0), np.int64)
    for number, (_, length, whole) in enumerate(order.timed):
        least, most = block.bounds(length)
        limits[number] = least * whole, most
    return places, limits


def plainly(order: Order, columns: Columns, captures: Whole, limits: tuple[Bits, Whole]) -> Mask:
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
    accepted: Bits, columns: Columns, rows: Whole, captures: Whole, limits: tuple[Bits, Whole]
) -> Bits:
    """Return the places that rows fit, without those that want them to last otherwise."""
    lasts = columns.stop[rows].astype(np.int64) - columns.start[rows]
    for place, (least, most) in zip(*limits, strict=True):
        wrong = (lasts < least[captures]) | (lasts > most[captures])
        accepted = np.where(wrong, accepted & ~place, accepted)
    return accepted
