"""Prefilter: in which captures a pattern can have a hit at all, judged by single symbols.

Each step that no match of a line can leave out needs one symbol at least of its directions and
levels. Captures that are left out have no hit; those that stay may have one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import CELL, Columns
from lanindex.search.automaton import NEGATIONS, Program, State, followers, reached
from lanindex.search.match.arrays import BoolArray
from lanindex.search.match.scan import cells_of

MOST_STATES = 32  # steps of a line that are looked at


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
                asked = np.flatnonzero(cells_of(state, member)[: CELL + 1]).tolist()
                own &= _cells_in(columns[part]) & np.uint64(sum(1 << it for it in asked)) > 0
        for companion in program.whole.companions:
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
