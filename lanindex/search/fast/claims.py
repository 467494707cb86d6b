"""Whether lines side by side could want the same movement, and what of a program is covered.

One movement, stay or rest serves one line only. Where two lines can want none in common, because
they speak of other parts, manners or cells, nothing has to be remembered of what was used.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, product

from lanindex.search.automaton import Companion, Program, State
from lanindex.search.fast.beside import FORBIDDEN
from lanindex.search.fast.walk import outer_groups

_MANNERS = {"via": "move"}
"""Manners that use up the same."""


def covered(program: Program) -> bool:
    """Tell whether the engine may answer a program with all that stands beside it."""
    return _covered(program) and not _contested(program)


def _covered(program: Program) -> bool:
    outer = outer_groups(program)
    inner = [
        group
        for edges in program.edges
        for edge in edges
        for group in (*edge.entry.opens, *edge.exit.closes)
    ]
    inner += [group for entry in program.entries for group in entry.opens if group not in outer]
    if any(group.companions for group in inner) or (inner and program.open_ended):
        return False
    return all(_covered(it) for companion in _companions(program) for it in companion.programs)


def _companions(program: Program) -> list[Companion]:
    return [companion for group in outer_groups(program) for companion in group.companions]


def _contested(program: Program) -> bool:
    """Tell whether two lines that matter to each other could want the same."""
    together = list(_needed(program))
    if any(_clash(one, other) for one, other in combinations(together, 2)):
        return True
    for companion in _forbidden(program):
        for inner in companion.programs:
            if _contested(inner):
                return True
            if any(_clash(one, other) for one, other in product(together, _needed(inner))):
                return True
    return False


def _needed(program: Program) -> Iterator[Program]:
    """Yield the lines that must be there, the leading one first."""
    yield program
    for companion in _companions(program):
        if companion.relation not in FORBIDDEN:
            for inner in companion.programs:
                yield from _needed(inner)


def _forbidden(program: Program) -> Iterator[Companion]:
    """Yield what must not happen beside any of the lines that must be there."""
    for companion in _companions(program):
        if companion.relation in FORBIDDEN:
            yield companion
        else:
            for inner in companion.programs:
                yield from _forbidden(inner)


def _clash(one: Program, other: Program) -> bool:
    return any(_alike(*states) for states in product(one.states, other.states))


def _alike(one: State, other: State) -> bool:
    """Tell whether two states can match the same."""
    if _MANNERS.get(one.manner, one.manner) != _MANNERS.get(other.manner, other.manner):
        return False
    return any(
        part == another and all(said[kind] & told[kind] for kind in said.keys() & told.keys())
        for (part, said), (another, told) in product(
            zip(one.members, one.fits, strict=True), zip(other.members, other.fits, strict=True)
        )
    )
