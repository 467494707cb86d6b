"""Lines of one part that `chains` cannot answer: walked row by row, where that is compiled.

Without the extra ``fast`` there is no such way, and `lines` tells the same from whole columns.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from lanindex.model.columns import PASSING, Columns, Roster
from lanindex.search.automaton import Program
from lanindex.search.fast.answers import Answers
from lanindex.search.fast.block import clocks_of, frames_of
from lanindex.search.fast.events import cells_of
from lanindex.search.fast.lines import cost_of, end_of, remembers
from lanindex.search.fast.planes import compiled, part_of
from lanindex.search.fast.ragged import Numbers, Whole
from lanindex.search.language.times import Length
from lanindex.search.language.words import WORD_KINDS

MOST_STATES = 63
"""Steps of a line that are numbered by the bits of one number."""

MOST_EDGES = 1024
"""Arrows of a line that is walked row by row."""

TOGETHER = 1 << 19
"""Rows after which it is seen whether the search shall be broken off."""

_MANNERS = {"move": 0, "via": 0, "at": 1, "hold": 2}


@dataclass(frozen=True, slots=True)
class Alone:
    """A line of one part as tables: see `alone_fast.backwards` for what stands in them."""

    states: tuple[Numbers, ...]
    edges: tuple[Numbers, ...]
    limits: tuple[Length, ...]


def alone_of(program: Program, columns: Mapping[str, Columns]) -> Alone | None:
    """Return a line as tables; None where it is no line of one part, or not to be walked so."""
    own = columns.get(program.states[0].members[0])
    if not _covered(program) or not compiled(len(own) if own else 0):
        return None
    lengths = [state.length for state in program.states]
    lengths += [edge.arrow.length for edges in program.edges for edge in edges]
    limits = tuple(dict.fromkeys(it for it in lengths if it))
    return Alone(_states(program, limits), _edges(program, limits), limits)


def _covered(program: Program) -> bool:
    states, edges = program.states, [edge for edges in program.edges for edge in edges]
    if remembers(program) or program.whole.companions or program.brackets:
        return False
    if len(states) > MOST_STATES or len(edges) > MOST_EDGES:
        return False
    if any(it.members != states[0].members or it.near for it in states):
        return False
    if any(it.from_start for it in program.entries) or any(it.entry.from_start for it in edges):
        return False
    if any(it.to_end for exits in program.exits for it in exits):
        return False
    if any(it.exit.to_end for it in edges) or len(states[0].members) > 1:
        return False
    entered = [it.state for it in program.entries]
    return not any(states[it].manner == "via" and program.edges[it] for it in entered)


def _states(program: Program, limits: tuple[Length, ...]) -> tuple[Numbers, ...]:
    cells, states = np.arange(256), program.states
    accepts, changes = np.zeros(256, np.uint64), np.zeros(4, np.uint64)
    for state in states:
        bit = np.uint64(1 << state.number)
        fits = cells_of(state, 0)
        if state.manner in ("at", "hold") or not state.names_passing:
            fits &= cells & PASSING == 0
        accepts[fits] |= bit
        wanted = state.fits[0].get("change", range(-1, len(WORD_KINDS["change"].codes)))
        for code in wanted:
            changes[code + 1] |= bit
    manners = np.array([_MANNERS[state.manner] for state in states])
    entered = {entry.state for entry in program.entries}
    changing = any("change" in state.fits[0] for state in states)
    return (
        accepts,
        changes if changing else changes[:0],
        np.argsort(-manners, kind="stable"),
        manners,
        np.array([state.manner == "via" for state in states]),
        np.array([state.number in entered for state in states]),
        np.array([bool(program.exits[state.number]) for state in states]),
        np.array([_numbered(state.length, limits) for state in states]),
    )


def _numbered(length: Length | None, limits: tuple[Length, ...]) -> int:
    return limits.index(length) if length else -1


def _edges(program: Program, limits: tuple[Length, ...]) -> tuple[Numbers, ...]:
    edges = [edge for edges in program.edges for edge in edges]
    bounds = [edge.arrow.bounds for edge in edges]
    return (
        np.cumsum([0, *map(len, program.edges)]),
        np.array([edge.entry.state for edge in edges], np.int64),
        np.array([least for least, _ in bounds], np.int64),
        np.array([-1 if most is None else most for _, most in bounds], np.int64),
        np.array([edge.arrow.later for edge in edges], bool),
        np.array([_numbered(edge.arrow.length, limits) for edge in edges], np.int64),
    )


def walked(alone: Alone, roster: Roster, columns: Columns, program: int, place: int) -> Answers:
    """Return the answers of a line in all captures, rows counted over all of them.

    Parameters
    ----------
    alone : Alone
        The line.
    roster : Roster
        All captures.
    columns : Columns
        Of its part.
    program, place : int
        Which program it is, and where its part stands in the list of `Finder`.
    """
    from lanindex.search.fast.alone_fast import backwards

    part = part_of(columns)
    clocks, own = clocks_of(roster)
    limits = np.zeros((max(len(alone.limits), 1), len(clocks), 2), np.int64)
    for number, length in enumerate(alone.limits):
        limits[number] = np.stack(frames_of(length, clocks), axis=1)
    rows = part.bounds, part.cell, part.margin, part.start, part.stop
    longest, many = int(np.diff(part.bounds).max(initial=0)), len(alone.states[3])
    shapes = *[(longest + 1, many)] * 2, *[(longest + 2,)] * 3
    room = tuple(np.empty(shape, np.int64) for shape in shapes)
    begins = np.arange(0, max(len(part), 1), TOGETHER)
    cuts = [*np.searchsorted(part.bounds, begins).tolist(), len(roster)]
    pieces = [
        backwards(
            first,
            last,
            rows,
            room,
            roster.frames,
            columns.gaps,
            alone.states,
            alone.edges,
            limits,
            own,
        )
        for first, last in pairwise(cuts)
    ]
    found, low, values = (np.concatenate(it) for it in zip(*pieces, strict=True))
    same = np.broadcast_to(np.array([[program], [place]]), (2, len(found)))
    ends: tuple[Whole, Whole] = end_of(values), cost_of(values)
    symbols = np.stack((found, np.full(len(found), -1)), axis=1)
    return Answers(part.captures(found), low, *ends, same[0], same[1], symbols)
