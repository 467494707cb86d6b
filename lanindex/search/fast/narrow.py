"""In which captures a pattern can have a hit at all, told from single symbols.

Each step that no way through a line can leave out wants one symbol at least of its directions and
heights. Most captures lack one for some step; most others have them in another order.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from weakref import WeakKeyDictionary

import numpy as np

from lanindex.model.columns import CELL, Columns
from lanindex.search.automaton import NEGATIONS, Program, State
from lanindex.search.fast.block import Block
from lanindex.search.fast.events import cells_of
from lanindex.search.fast.order import Bits, in_order, order_of
from lanindex.search.fast.ragged import Mask

MOST_STATES = 32
"""Steps of a line that are looked at."""


class Narrowing:
    """Tells in which captures programs can match.

    Parameters
    ----------
    columns : Mapping of str to Columns
        By part; one that is not there never moves.
    block : Block
        All captures.
    """

    def __init__(self, columns: Mapping[str, Columns], block: Block) -> None:
        self._columns, self._block, self._captures = columns, block, len(block)

    def possible(self, programs: Sequence[Program]) -> Mask:
        """Return in which captures one of some programs can match, (C,) bool."""
        found = np.zeros(self._captures, bool)
        for program in programs:
            found |= self._of(program)
        return found

    def _of(self, program: Program) -> Mask:
        found = self._with_all(program)
        self._put_in_order(program, found)
        return found

    def _with_all(self, program: Program) -> Mask:
        """Return which captures have the symbols of a program, and of the lines beside it."""
        found = np.ones(self._captures, bool)
        for state in unavoidable(program):
            for member in range(len(state.members)):
                found &= self._with(state, member)
        for companion in _needed(program):
            found &= np.any([self._with_all(it) for it in companion], axis=0)
        return found

    def _put_in_order(self, program: Program, found: Mask) -> None:
        """Leave out those captures that have them in another order: parts with few rows first."""
        parts = {part for state in program.states for part in state.members} & {*self._columns}
        for part in sorted(parts, key=lambda it: (len(self._columns[it]), it)):
            if order := order_of(program, part):
                captures = np.flatnonzero(found)
                found[captures] = in_order(order, self._columns[part], captures, self._block)
        for companion in _needed(program):
            others = np.zeros(self._captures, bool)
            for inner in companion:
                own = found & ~others
                self._put_in_order(inner, own)
                others |= own
            found &= others

    def _with(self, state: State, member: int) -> Mask:
        """Return which captures have a symbol that a state asks for."""
        table, part = cells_of(state, member)[: CELL + 1], state.members[member]
        if part not in self._columns:
            return np.zeros(self._captures, bool)
        asked = sum(1 << cell for cell in np.flatnonzero(table).tolist())
        found: Mask = cells_in(self._columns[part]) & np.uint64(asked) > 0
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
