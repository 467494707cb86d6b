"""In which captures a pattern can have a hit at all, told from single symbols.

Each step that no way through a line can leave out wants one symbol at least of its directions and
heights. What is not found here cannot match; what is found may.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import CELL, Columns
from lanindex.search.automaton import NEGATIONS, Program, State
from lanindex.search.match.arrays import BoolArray
from lanindex.search.match.scan import cells_of

Bits = NDArray[np.uint64]

MOST_STATES = 32
"""Steps of a line that are looked at."""


def possible(
    programs: Iterable[Program], columns: Mapping[str, Columns], captures: int
) -> BoolArray:
    """Return in which captures one of some programs can match, (captures,) bool.

    Parameters
    ----------
    programs : iterable of Program
        Of a query.
    columns : Mapping of str to Columns
        By part; one that is not there never moves.
    captures : int
        How many there are.
    """
    found = np.zeros(captures, bool)
    for program in programs:
        own = np.ones(captures, bool)
        for state in unavoidable(program):
            for member in range(len(state.members)):
                own &= _having(state, member, columns)
        for companion in program.whole.companions:
            if companion.relation not in NEGATIONS:
                own &= possible(companion.programs, columns, captures)
        found |= own
    return found


def _having(state: State, member: int, columns: Mapping[str, Columns]) -> BoolArray | bool:
    """Return which captures have a symbol that a state asks for, (captures,) bool."""
    if state.members[member] not in columns:
        return False
    table = cells_of(state, member)[: CELL + 1]
    asked = sum(1 << cell for cell in np.flatnonzero(table).tolist())
    found: BoolArray = cells_in(columns[state.members[member]]) & np.uint64(asked) > 0
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
