"""A line's program as the alignment needs it: which step may follow which, and what is missing.

Only lines of one part that say nothing of time between their steps can be aligned; what else a
pattern says is refused by name, so that nothing is passed over in silence.
"""

from __future__ import annotations

from dataclasses import dataclass

from lanindex.errors import UsageError
from lanindex.search.automaton import Program, State
from lanindex.search.fuzzy.costs import UNIT

MISSING = UNIT
"""What a step costs that is missing."""

MOST_STEPS = 40
"""Steps of a line that can be aligned: the work grows with their number."""

SKIPPED = UNIT // 2
"""What a shown symbol costs that lies between two steps joined by ``->``."""


@dataclass(frozen=True, slots=True, eq=False)
class Net:
    """A line to be aligned with tracks of one part.

    Attributes
    ----------
    part : str
        Whose.
    states : tuple of State
        Its steps, repeats written out.
    edges : tuple of tuple of (int, int, bool)
        From one step to another; whether anything may lie between.
    entry, exit : tuple of int
        By step: what the steps cost that are missing before it, and after it.
    """

    part: str
    states: tuple[State, ...]
    edges: tuple[tuple[int, int, bool], ...]
    entry: tuple[int, ...]
    exit: tuple[int, ...]

    @property
    def stays(self) -> bool:
        """Whether it asks where the part is, not where it goes."""
        return self.states[0].manner == "at"


def net_of(program: Program) -> Net:
    """Return a program as a net.

    Raises
    ------
    UsageError
        Where it says what has no edits.
    """
    _refuse(program)
    if len(program.states) > MOST_STEPS:
        raise UsageError(
            f"a fuzzy search for {len(program.states)} steps in a row",
            wanted=f"{MOST_STEPS} at most",
            remedy="Look for a shorter piece of it, or search without --fuzzy.",
        )
    edges = {
        (state, edge.entry.state, edge.arrow.later)
        for state, leaving in enumerate(program.edges)
        for edge in leaving
    }
    pairs = [(before, after) for before, after, _ in edges]
    number = len(program.states)
    far = MISSING * (number + 1)
    entries = {it.state for it in program.entries}
    exits = {state for state, leaving in enumerate(program.exits) if leaving}
    return Net(
        program.states[0].members[0],
        program.states,
        tuple(sorted(edges)),
        _spread([0 if state in entries else far for state in range(number)], pairs),
        _spread(
            [0 if state in exits else far for state in range(number)],
            [(after, before) for before, after in pairs],
        ),
    )


def _spread(costs: list[int], pairs: list[tuple[int, int]]) -> tuple[int, ...]:
    """Return the least cost of each step if every step on the way to it is missing."""
    changed = True
    while changed:
        changed = False
        for before, after in pairs:
            if costs[before] + MISSING < costs[after]:
                costs[after] = costs[before] + MISSING
                changed = True
    return tuple(costs)


def _refuse(program: Program) -> None:
    states = program.states
    edges = [edge for leaving in program.edges for edge in leaving]
    stays = len(states) == 1 and states[0].manner == "at" and states[0].length is None
    cannot = {
        "brackets with a length or a line beside them": any(
            group.length or group.companions for group in program.brackets
        ),
        '"hold", and "at" beside other steps or with a length': not stays
        and any(state.manner in ("at", "hold") for state in states),
        "arrows to another part": any(not edge.same for edge in edges),
        "both parts at once (name each: r_arm … with l_arm …)": len(states[0].members) > 1,
        "limits on an arrow": any(edge.arrow.length or edge.arrow.skips for edge in edges),
        '"start" and "end"': any(it.from_start for it in program.entries)
        or any(it.to_end for leaving in program.exits for it in leaving),
    }
    for what, said in cannot.items():
        if said:
            raise UsageError(
                f"a fuzzy search cannot count edits in {what}",
                remedy="Leave that out, or search without --fuzzy.",
            )
