"""In which captures a pattern can have a hit at all, told from single symbols.

Each step that no way through a line can leave out wants one symbol at least of its directions and
heights. Most captures lack one for some step, and need not be looked at any closer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from lanindex.model.columns import Columns
from lanindex.search.automaton import NEGATIONS, Program, State
from lanindex.search.fast.events import cells_of
from lanindex.search.fast.planes import CELLS, part_of
from lanindex.search.fast.ragged import Mask

MOST_STATES = 32
"""Steps of a line that are looked at."""


class Narrowing:
    """Tells in which captures programs can match.

    Parameters
    ----------
    columns : Mapping of str to Columns
        By part; one that is not there never moves.
    captures : int
        How many there are.
    """

    def __init__(self, columns: Mapping[str, Columns], captures: int) -> None:
        self._columns, self._captures = columns, captures
        self._known: dict[tuple[str, bytes], Mask] = {}

    def possible(self, programs: Sequence[Program]) -> Mask:
        """Return in which captures one of some programs can match, (C,) bool."""
        found = np.zeros(self._captures, bool)
        for program in programs:
            found |= self._of(program)
        return found

    def _of(self, program: Program) -> Mask:
        found = np.ones(self._captures, bool)
        for state in unavoidable(program):
            for member in range(len(state.members)):
                found &= self._with(state, member)
        for companion in program.whole.companions:
            if companion.relation not in NEGATIONS:
                found &= self.possible(companion.programs)
        return found

    def _with(self, state: State, member: int) -> Mask:
        """Return which captures have a symbol that a state asks for."""
        table, part = cells_of(state, member), state.members[member]
        key = part, table.tobytes()
        if key not in self._known:
            found = np.zeros(self._captures, bool)
            if part in self._columns:
                rows = part_of(self._columns[part])
                found = rows.captures_with(rows.shown_as(state.fits[member], CELLS))
                passed = rows.passed[table[rows.cell[rows.passed]]]
                found[rows.captures(passed)] = True
            self._known[key] = found
        return self._known[key]


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
