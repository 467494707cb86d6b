"""The symbols of one hit: which movements, stays and rests a line took, and how clearly.

A search tells only where hits are. Those that are shown are walked once more, in their own
capture alone, along the values that the search has found.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from lanindex.model import Symbol
from lanindex.search.automaton import Program, State
from lanindex.search.fast.answers import firsts, roots
from lanindex.search.fast.arrows import NONE
from lanindex.search.fast.block import Block
from lanindex.search.fast.lines import COST_BITS, Backwards, cost_of, end_of, may_leave


class Taken(NamedTuple):
    """What matched a state: parts and rows, and the frames of it."""

    state: State
    rows: tuple[tuple[str, int], ...]
    start: int
    end: int


def labelled(
    taken: Iterable[Taken], symbols: Mapping[tuple[str, int], Symbol]
) -> dict[str, tuple[Symbol, ...]]:
    """Return, by label, what matched under it; one stayed at or rested in lasts as long as that."""
    labels: dict[str, tuple[Symbol, ...]] = {}
    for it in taken:
        found = [symbols[row] for row in it.rows]
        if it.state.manner in ("at", "hold"):
            found = [replace(symbol, start=it.start, stop=it.end) for symbol in found]
        for label in it.state.labels:
            labels[label] = (*labels.get(label, ()), *found)
    return labels


def trace(
    block: Block,
    program: Program,
    parts: tuple[str, ...],
    rows: tuple[int, ...],
    low: int,
    value: int,
) -> list[Taken]:
    """Return what matched the states of a line that remembers nothing, in order.

    Parameters
    ----------
    block : Block
        Of the hit's capture alone.
    program : Program
        Which answers.
    parts, rows : tuple
        The first symbols.
    low : int
        The first frame: one symbol may be both a movement and a stay with which the line begins.
    value : int
        End and cost, as from `lanindex.search.fast.lines.value_of`.
    """
    backwards = Backwards(block, program)
    for entry in program.entries:
        state = program.states[entry.state]
        known = [parts]
        place, order = firsts(state, known)
        if place:
            continue
        events = block.events(state)
        fits = roots(block, program, entry) & (backwards.values[entry.state] == value)
        fits &= events.start == low
        for member, row in zip(order, rows, strict=False):
            fits &= events.first[member] == row
        if fits.any():
            return _followed(block, program, backwards, entry.state, int(np.flatnonzero(fits)[0]))
    raise AssertionError("a hit that is not there")


def _followed(
    block: Block, program: Program, backwards: Backwards, state: int, place: int
) -> list[Taken]:
    value = backwards.values[state][place]
    taken = []
    step: tuple[int, int] | None = (state, place)
    while step:
        taken.append(_taken(block, program.states[step[0]], step[1]))
        step = _next(block, program, backwards, step, int(value))
    return taken


def _next(
    block: Block, program: Program, backwards: Backwards, step: tuple[int, int], value: int
) -> tuple[int, int] | None:
    state, place = step
    events = block.events(program.states[state]).at(np.array([place]))
    for edge in program.edges[state]:
        if edge.exit.to_end and not may_leave(block, program, edge.exit)[place]:
            continue
        values = backwards.entered(edge)
        _, targets = backwards.reach(edge, events).pairs()
        reached = values[targets]
        fits = (reached < NONE) & (end_of(reached) == value >> COST_BITS)
        fits &= cost_of(reached) <= value & (1 << COST_BITS) - 1
        if fits.any():
            return edge.entry.state, int(targets[np.flatnonzero(fits)[0]])
    return None


def _taken(block: Block, state: State, place: int) -> Taken:
    events, rows = block.events(state), []
    for part, first, last in zip(state.members, events.first, events.last, strict=True):
        begin, end = int(first[place]), int(last[place])
        passing = block.rows(part).passing
        rows += [(part, row) for row in range(begin, end + 1) if begin == end or not passing[row]]
    return Taken(state, tuple(rows), int(events.start[place]), int(events.end[place]))
