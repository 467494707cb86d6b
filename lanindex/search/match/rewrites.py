"""What a search may leave out, read off the plan of its leading line before any capture is read.

A search could keep every partial match of every line, with every symbol that it has taken. Most
patterns need much less: no symbol can be wanted by two lines, one end a beginning is enough, or a
line beside the first can never stand there. `Rewrites` holds what can be left out.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from itertools import combinations_with_replacement, product

from lanindex.search.match.relations import FIRST, RELATIONS
from lanindex.search.plan import NEGATIONS, Companion, Group, Program, State, components

MANNERS = ("move", "at", "hold")
"""What a symbol may be taken as."""

ONLY = "only"
"""Of a line that runs on, the end of the only match that it can have is enough."""


def enough(program: Program) -> str | None:
    """Return which end of a leading line is enough, None: all of them are needed."""
    beside = [(RELATIONS[it.relation], it) for it in program.outermost.companions]
    if program.open_ended and beside:
        return ONLY if all(relation.holds_of_longer for relation, _ in beside) else None
    shorter = all(
        relation.holds_of_shorter and not (it.relation == "before" and it.within)
        for relation, it in beside
    )
    return FIRST if shorter else None


def enough_beside(program: Program, companion: Companion) -> str | None:
    """Return which end of a line beside another is enough, None: all of them are needed."""
    relation = RELATIONS[companion.relation]
    if program.open_ended and companion.relation not in NEGATIONS:
        return ONLY if relation.holds_of_longer_beside else None
    if companion.relation == "after" and companion.within:
        return None
    return relation.enough_beside


class Rewrites:
    """What may be left out in the search for one leading line."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.contested: dict[Program, set[int]] = {}  # states whose symbols another line could want
        self.rivals: dict[Program, set[Program]] = {}  # the lines that could want them
        self.outside: set[Program] = set()  # lines whose claims matter to lines further out
        self.hosts = defaultdict[Program, list[tuple[Program, Group]]](
            list
        )  # what lines are beside
        self.standing = {it: _standing(program, it) for it in program.outermost.companions}
        self._lines: list[_Line] = []
        self._list(program)
        for (one, first), (other, second) in combinations_with_replacement(
            enumerate(self._lines), 2
        ):
            again = [it for it in self._lines if it.again and it.holds(one) and it.holds(other)]
            if second.apart_from == one and not again:
                continue
            if (one != other or again) and self._compete(first, second):
                parting = [it for it in self._lines if it.holds(one) != it.holds(other)]
                self.outside.update(it.program for it in (*parting, *again))

    def programs(self, companion: Companion) -> tuple[Program, ...]:
        """Return the lines, one a side, that can stand beside another or disturb it."""
        return self.standing.get(companion, companion.programs)

    def _list(
        self,
        program: Program,
        *,
        again: bool = False,
        denied: int = 0,
        apart_from: int | None = None,
    ) -> None:
        """List a line and all lines beside it."""
        own = _Line(program, again, denied, apart_from, len(self._lines), 0)
        self._lines.append(own)
        repeated = {
            group
            for states in components(program)
            for state in states
            for edge in program.edges[state]
            if edge.entry.state in states
            for group in edge.exit.closes
        }
        for group in (program.outermost, *program.brackets):
            for companion in group.companions:
                deeper = denied + (companion.relation in NEGATIONS)
                apart = group is program.outermost and RELATIONS[companion.relation].shares_nothing
                for inner in self.programs(companion):
                    self.hosts[inner].append((program, group))
                    self._list(
                        inner,
                        again=group in repeated,
                        denied=deeper,
                        apart_from=own.first if apart else None,
                    )
        own.last = len(self._lines)

    def _compete(self, one: _Line, other: _Line) -> bool:
        """Return whether two lines could want the same symbol, and note at which states."""
        found = False
        one, other = sorted((one, other), key=lambda it: it.denied)
        first, second = one.program, other.program
        for (state, own), (beside, their) in product(_kinds(first), _kinds(second)):
            manner = manner_of(beside)
            # a stay or rest of the hit excuses the movement that led there
            led_there = one.denied < other.denied and manner == MANNERS[0]
            if (led_there or manner_of(state) == manner) and _overlap(state, beside):
                self.contested.setdefault(first, set()).update(own)
                self.contested.setdefault(second, set()).update(their)
                self.rivals.setdefault(first, set()).add(second)
                self.rivals.setdefault(second, set()).add(first)
                found = True
        return found


@dataclass(slots=True)
class _Line:
    """A line among all lines of a program; those beside it follow it, up to `last`."""

    program: Program
    again: bool  # it stands beside a bracket that repeats without end
    denied: int  # how many negations it is in
    apart_from: int | None  # the line with which it shares nothing
    first: int
    last: int

    def holds(self, place: int) -> bool:
        """Return whether a line is this one or stands beside it."""
        return self.first <= place < self.last


def _kinds(program: Program) -> list[tuple[State, list[int]]]:
    """Return the different states of a program, each with the numbers of those alike."""
    kinds: dict[object, tuple[State, list[int]]] = {}
    for state in program.states:
        fits = tuple(frozenset(it.items()) for it in state.fits)
        key = (state.members, state.manner, fits)
        kinds.setdefault(key, (state, []))[1].append(state.number)
    return list(kinds.values())


def manner_of(state: State) -> str:
    """Return what a state takes its symbols as; what is passed through is a movement."""
    return state.manner if state.manner in MANNERS else MANNERS[0]


def _overlap(one: State, other: State) -> bool:
    """Return whether two states can take the same symbol."""
    if one.near or other.near:  # a symbol near a border may be on either side of it
        return not set(one.members).isdisjoint(other.members)
    return any(
        part == another and all(fits[kind] & their[kind] for kind in fits.keys() & their.keys())
        for (part, fits), (another, their) in product(
            zip(one.members, one.fits, strict=True), zip(other.members, other.fits, strict=True)
        )
    )


def _standing(program: Program, companion: Companion) -> tuple[Program, ...]:
    """Return the lines that can stand beside all of a leading line, or disturb it.

    A part makes one movement at a time: runs of movements of one part that share a frame share a
    symbol, which two lines cannot, and which excuses a line that must not happen.
    """
    part = _run_of(program) if _shares_frame(program, companion) else None
    return tuple(it for it in companion.programs if part is None or _run_of(it) != part)


def _shares_frame(program: Program, companion: Companion) -> bool:
    """Return whether what stands beside a line shares a frame with the line itself."""
    if companion.within:
        return False
    if companion.relation != "without":
        return RELATIONS[companion.relation].shares_frame
    inside = any(group.companions for group in program.brackets)
    adding = any(RELATIONS[it.relation].adds_frames for it in program.outermost.companions)
    return not inside and not adding


def _run_of(program: Program) -> str | None:
    """Return the part of which a line takes movements that follow each other, if it is one."""
    edges = [edge for edges in program.edges for edge in edges]
    parts = {state.members for state in program.states}
    linked = all(edge.same and not edge.arrow.later for edge in edges)
    moving = all(state.manner == "move" for state in program.states)
    (members, *others) = parts
    return members[0] if linked and moving and len(members) == 1 and not others else None
