"""Which lines can stand beside another at all, told from what they ask for alone.

A line of linked movements takes every movement of its part from its first to its last. Two such
lines of one part that share a frame take the same movement, which serves one of them only.
"""

from __future__ import annotations

from lanindex.search.automaton import Companion, Program
from lanindex.search.fast.beside import FORBIDDEN, NO_FRAMES


def standing(program: Program, companion: Companion) -> tuple[Program, ...]:
    """Return the lines that can stand beside all of a leading line, or disturb it."""
    part = _run_of(program) if _sharing(program, companion) else None
    return tuple(it for it in companion.programs if part is None or _run_of(it) != part)


def _sharing(program: Program, companion: Companion) -> bool:
    """Tell whether what stands beside a line shares a frame with the line itself."""
    if companion.within:
        return False
    if companion.relation != "without":
        return companion.relation in ("with", "during")
    inside = [it for group in program.brackets for it in group.companions]
    relations = {it.relation for it in program.whole.companions}
    return not inside and relations <= {*FORBIDDEN, *NO_FRAMES}


def _run_of(program: Program) -> str | None:
    """Return the part of which a line takes movements that follow each other, if it is one."""
    edges = [edge for edges in program.edges for edge in edges]
    parts = {state.members for state in program.states}
    linked = all(edge.same and not edge.arrow.later for edge in edges)
    moving = all(state.manner == "move" for state in program.states)
    (members, *others) = parts
    return members[0] if linked and moving and len(members) == 1 and not others else None
