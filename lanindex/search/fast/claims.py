"""Which movements several lines side by side could want, and what of a program is covered.

One movement, stay or rest serves one line only, and what must not happen is forgiven where the hit
uses it, or came there by it. Where lines can want none in common, because they
speak of other parts, manners or cells, nothing has to be remembered. Else each line remembers what
it took at the states where another one could want it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import combinations, product

from lanindex.search.automaton import Companion, Group, Program, State
from lanindex.search.fast.beside import FORBIDDEN
from lanindex.search.fast.lines import components
from lanindex.search.fast.walk import NotCovered, outer_groups


@dataclass(slots=True)
class Contested:
    """What the lines of a program and those beside it have to remember.

    Attributes
    ----------
    states : dict of Program to tuple of int
        By line, the states at which another one could want what it takes.
    outside : set of Program
        The lines that, with what stands beside them, could want what lines further out do.
    """

    states: dict[Program, tuple[int, ...]]
    outside: set[Program]


MANNERS = ("move", "at", "hold")
"""As what a symbol may be taken."""


def contested(program: Program) -> Contested:
    """Return what the lines of a program and those beside it have to remember.

    Raises
    ------
    NotCovered
        Where ways must remember more: lines beside a bracket that is not all of its line,
        repeats without end that would have to remember what they took.
    """
    for line in all_lines(program):
        _check(line)
    if any(_led_to(*lines) for lines in _forgivable(program)):
        raise NotCovered
    states: dict[Program, set[int]] = {}
    for one, other in _rivals(program):
        for first, second in product(one.states, other.states):
            if alike(first, second):
                states.setdefault(one, set()).add(first.number)
                states.setdefault(other, set()).add(second.number)
    for line in states:
        if line.open_ended or any(_circles(line)):
            raise NotCovered
    _check_forbidden(program, [])
    outside: set[Program] = set()
    _look_outside(program, [], outside)
    return Contested({it: tuple(sorted(numbers)) for it, numbers in states.items()}, outside)


def _look_outside(program: Program, around: list[Program], found: set[Program]) -> None:
    """Add the lines beside a program that could want what others around them do."""
    companions = [it for group in outer_groups(program) for it in group.companions]
    for companion in companions:
        forbidden = companion.relation in FORBIDDEN
        others = [program, *around]
        for other in companions:
            if other is not companion and not (forbidden and other.relation in FORBIDDEN):
                others += [line for inner in other.programs for line in all_lines(inner)]
        for inner in companion.programs:
            if could_want([inner], others):
                found.add(inner)
            _look_outside(inner, others, found)


def could_want(lines: Iterable[Program], others: Iterable[Program]) -> bool:
    """Tell whether lines, or what stands beside them, could want what others do."""
    wanting = [inner for line in lines for inner in all_lines(line)]
    return any(_clash(one, other) for one, other in product(wanting, others))


def _check(program: Program) -> None:
    outer = outer_groups(program)
    inner = [
        group
        for edges in program.edges
        for edge in edges
        for group in (*edge.entry.opens, *edge.exit.closes)
    ]
    inner += [group for entry in program.entries for group in entry.opens if group not in outer]
    if any(group.companions for group in inner) or (inner and program.open_ended):
        raise NotCovered


def check_running_on(program: Program) -> None:
    """Refuse lines whose longest way cannot be told before what stands beside them.

    Raises
    ------
    NotCovered
        Where a program is such a line.
    """
    groups = outer_groups(program)
    companions = [it for group in groups for it in group.companions]
    relations = {it.relation for it in companions}
    bounded = any(group.length for group in groups) or any(
        it.relation == "before" and it.within for it in companions
    )
    if bounded or relations & {"ending with", "exactly with"}:
        raise NotCovered
    if relations & {"during", "before", "without"} and relations & {"with", "starting with"}:
        raise NotCovered


def _circles(program: Program) -> Iterator[bool]:
    for states in components(program):
        yield len(states) > 1 or any(
            edge.entry.state == states[0] for edge in program.edges[states[0]]
        )


def _companions(group: Group, *, forbidden: bool) -> list[Companion]:
    return [it for it in group.companions if (it.relation in FORBIDDEN) == forbidden]


def all_lines(program: Program) -> Iterator[Program]:
    """Yield all lines of a program, those that must not happen too; the leading one first."""
    yield program
    for group in outer_groups(program):
        for companion in group.companions:
            for inner in companion.programs:
                yield from all_lines(inner)


def _needed(program: Program) -> Iterator[Program]:
    """Yield the lines that must be there, the leading one first."""
    yield program
    for group in outer_groups(program):
        for companion in _companions(group, forbidden=False):
            for inner in companion.programs:
                yield from _needed(inner)


def _rivals(program: Program) -> Iterator[tuple[Program, Program]]:
    """Yield the pairs of lines that must not take the same."""
    together = list(_needed(program))
    yield from combinations(together, 2)
    for inner in _not_to_happen(together):
        yield from product(together, _needed(inner))
        yield from _rivals(inner)


def _forgivable(program: Program) -> Iterator[tuple[Program, Program]]:
    """Yield the pairs of which the second line does not count where it takes what the first did."""
    together = list(_needed(program))
    for inner in _not_to_happen(together):
        yield from product(together, _needed(inner))
        yield from _forgivable(inner)


def _not_to_happen(lines: Iterable[Program]) -> Iterator[Program]:
    for line in lines:
        for group in outer_groups(line):
            for companion in _companions(group, forbidden=True):
                yield from companion.programs


def _check_forbidden(program: Program, outside: list[Program]) -> None:
    """Refuse what must not happen in a bracket if a line outside could forgive it.

    A match that uses a symbol of the hit does not count, of the hit as a whole; but what is outside
    is found only once the bracket is.
    """
    groups = outer_groups(program)
    for place, group in enumerate(groups):
        later = [
            line
            for around in groups[:place]
            for companion in _companions(around, forbidden=False)
            for inner in companion.programs
            for line in _needed(inner)
        ]
        for companion in _companions(group, forbidden=True):
            for inner in companion.programs:
                if any(
                    _clash(line, one) for line in all_lines(inner) for one in (*outside, *later)
                ):
                    raise NotCovered
                # what must not happen beside what must not happen: nothing may be in common at all
                _check_forbidden(inner, [*outside, *_needed(program), *_needed(inner)])
        beside = _companions(group, forbidden=False)
        for companion in beside:
            others = [
                line
                for other in beside
                if other is not companion
                for inner in other.programs
                for line in _needed(inner)
            ]
            for inner in companion.programs:
                _check_forbidden(inner, [*outside, *later, *others, program])


def _clash(one: Program, other: Program) -> bool:
    return any(touching(*states) for states in product(one.states, other.states))


def _led_to(one: Program, other: Program) -> bool:
    """Tell whether a stay or rest of a line can be what a movement of another one led to."""
    return any(
        manner_of(first) != MANNERS[0] == manner_of(second) and touching(first, second)
        for first, second in product(one.states, other.states)
    )


def manner_of(state: State) -> str:
    """Return as what a state takes what it takes: what is gone through is a movement."""
    return state.manner if state.manner in MANNERS else MANNERS[0]


def alike(one: State, other: State) -> bool:
    """Tell whether two states can take the same."""
    return manner_of(one) == manner_of(other) and touching(one, other)


def touching(one: State, other: State) -> bool:
    """Tell whether two states can take the same symbol, whatever as."""
    if one.near or other.near:  # a symbol near a border may be on either side of it
        return not set(one.members).isdisjoint(other.members)
    return any(
        part == another and all(said[kind] & told[kind] for kind in said.keys() & told.keys())
        for (part, said), (another, told) in product(
            zip(one.members, one.fits, strict=True), zip(other.members, other.fits, strict=True)
        )
    )
