"""A line's program as the alignment needs it: which step may follow which, and what is missing.

Only lines of one part that say nothing of time between their steps can be aligned; what else a
pattern says is refused by name, so that nothing is passed over in silence.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from lanindex.errors import UsageError
from lanindex.search.automaton import Program, State
from lanindex.search.fuzzy.costs import MOST, UNIT
from lanindex.search.language.query import Arrow

MISSING = UNIT
"""What a step costs that is missing."""

MOST_STEPS = 40
"""Steps of a line that can be aligned: the work grows with their number."""

SKIPPED = UNIT // 2
"""What a shown symbol costs that lies between two steps joined by ``->``."""

FAR = 1 << 14
"""What it costs to begin or end where a line cannot: more than any match."""

FREE, NEXT, LATER = range(3)
"""How a line lies to a clip's start or end: anywhere, right there (``->``), some way off."""


@dataclass(frozen=True, eq=False)
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
    entry, exit : tuple of tuple of int
        By way (`FREE`, `NEXT`, `LATER`) and step: what the steps cost that are missing before it,
        and after it.
    """

    part: str
    states: tuple[State, ...]
    edges: tuple[tuple[int, int, bool], ...]
    entry: tuple[tuple[int, ...], ...]
    exit: tuple[tuple[int, ...], ...]

    @property
    def stays(self) -> bool:
        """Whether it asks where the part is, not where it goes."""
        return self.states[0].manner == "at"

    @property
    def dearest(self) -> int:
        """What the best match of any symbols costs at most, where no step has a length."""
        return (MOST + MISSING) * len(self.states)

    @cached_property
    def doors(self) -> tuple[tuple[int, bool], ...]:
        """Where one may wait: before which step, and whether what lies between is free."""
        return tuple(sorted({(after, later) for _, after, later in self.edges}))

    @cached_property
    def comes(self) -> tuple[tuple[int, ...], ...]:
        """By door: from which steps one comes to it."""
        return tuple(
            tuple(before for before, after, later in self.edges if (after, later) == door)
            for door in self.doors
        )

    @cached_property
    def goes(self) -> tuple[tuple[int, ...], ...]:
        """By step: to which doors one goes from it."""
        places = {door: place for place, door in enumerate(self.doors)}
        return tuple(
            tuple(places[after, later] for before, after, later in self.edges if before == state)
            for state in range(len(self.states))
        )

    @cached_property
    def waits(self) -> tuple[tuple[int, ...], ...]:
        """By step: the doors before it."""
        return tuple(
            tuple(place for place, (after, _) in enumerate(self.doors) if after == state)
            for state in range(len(self.states))
        )

    @property
    def circles(self) -> bool:
        """Whether a step may come again: an open count."""
        return any(after <= before for before, after, _ in self.edges)

    @property
    def leaps(self) -> bool:
        """Whether anything may lie between two of its steps."""
        return any(later for _, _, later in self.edges)

    def missing(self, most: int) -> list[tuple[int, int, int]]:
        """Return from which doors one comes to which others by steps that are missing.

        Each with the fewest steps, where these cost no more than a match may: from, to, how many.
        """
        ways = []
        for door in range(len(self.doors)):
            fewest = {door: 0}
            reached = [door]
            for steps in range(1, min(most // MISSING, len(self.states)) + 1):
                onto = {far for near in reached for far in self.goes[self.doors[near][0]]}
                reached = sorted(onto - fewest.keys())
                fewest |= dict.fromkeys(reached, steps)
            ways += [(door, far, steps) for far, steps in fewest.items() if steps]
        return ways

    def reach(self, most: int) -> int | None:
        """Return how many shown symbols a match may cover; None: any number."""
        if self.circles or self.leaps:
            return None
        return len(self.states) + most // SKIPPED

    @cached_property
    def unavoidable(self) -> tuple[int, ...]:
        """The steps that no way through the line leads around."""
        return tuple(state for state in range(len(self.states)) if not self._avoids(state))

    def _avoids(self, left_out: int) -> bool:
        entries = {step for costs in self.entry for step, cost in enumerate(costs) if cost == 0}
        exits = {step for costs in self.exit for step, cost in enumerate(costs) if cost == 0}
        seen: set[int] = set()
        todo = entries - {left_out}
        while todo:
            seen |= todo
            after = {after for before, after, _ in self.edges if before in todo}
            todo = after - seen - {left_out}
        return bool(seen & exits)


def nets_of(program: Program) -> tuple[Net, ...]:
    """Return a program as nets, one for each of the parts that move together.

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
    back = [(after, before) for before, after in pairs]
    entries = [(it.state, it.from_start) for it in program.entries]
    exits = [(it.state, it.to_end) for leaving in program.exits for it in leaving]
    whole = Net(
        "",
        program.states,
        tuple(sorted(edges)),
        _ways(entries, pairs, len(program.states)),
        _ways(exits, back, len(program.states)),
    )
    return tuple(
        replace(whole, part=part, states=tuple(_of_member(it, member) for it in program.states))
        for member, part in enumerate(program.states[0].members)
    )


def _of_member(state: State, member: int) -> State:
    return replace(state, members=(state.members[member],), fits=(state.fits[member],))


def _ways(
    ends: Sequence[tuple[int, tuple[Arrow, ...]]], pairs: list[tuple[int, int]], steps: int
) -> tuple[tuple[int, ...], ...]:
    """Return by way and step what is missing up to it, of the steps where a line begins or ends."""
    ways = []
    for way in (FREE, NEXT, LATER):
        here = {state for state, arrows in ends if _way_of(arrows) == way}
        costs = [0 if state in here else FAR for state in range(steps)]
        ways.append(_spread(costs, pairs))
    return tuple(ways)


def _way_of(arrows: tuple[Arrow, ...]) -> int:
    if not arrows:
        return FREE
    return LATER if all(arrow.later for arrow in arrows) else NEXT


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
    ends = [it.from_start for it in program.entries]
    ends += [it.to_end for leaving in program.exits for it in leaving]
    arrows = [edge.arrow for edge in edges] + [arrow for it in ends for arrow in it]
    stays = len(states) == 1 and states[0].manner == "at" and states[0].length is None
    stays = stays and not any(ends) and len(states[0].members) == 1
    cannot = {
        "brackets with a length or a line beside them": any(
            group.length or group.companions for group in program.brackets
        ),
        '"overlapping"': any(it.relation == "overlapping" for it in program.whole.companions),
        '"hold", and "at" beside other steps or with a length': not stays
        and any(state.manner in ("at", "hold") for state in states),
        "the feet of a jump, degrees of turns and bends, what is touched or carries, "
        "and how fast or large a movement is": any(it.beside_cells for it in states),
        "arrows to another part": any(not edge.same for edge in edges),
        "limits on an arrow": any(arrow.length or arrow.skips for arrow in arrows),
    }
    for what, said in cannot.items():
        if said:
            raise UsageError(
                f"a fuzzy search cannot count edits in {what}",
                remedy="Leave that out, or search without --fuzzy.",
            )
