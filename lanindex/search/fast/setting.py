"""What walks through the lines of one query share, in one block: what is asked, and of what."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations_with_replacement, product
from math import floor
from typing import Any, NamedTuple, Protocol

import numpy as np

from lanindex.search.automaton import Companion, Group, Program, State
from lanindex.search.fast.abreast import standing
from lanindex.search.fast.answers import roots
from lanindex.search.fast.arrows import NONE
from lanindex.search.fast.asked import Asked
from lanindex.search.fast.beside import Stretches
from lanindex.search.fast.block import Block
from lanindex.search.fast.conditions import Clauses, Source, Told
from lanindex.search.fast.lines import Backwards, components, reached
from lanindex.search.fast.others import Others
from lanindex.search.fast.ragged import FAR, Mask, Numbers, Whole
from lanindex.search.fast.rows import Rows
from lanindex.search.fast.taken import Taken, nothing, one_each
from lanindex.search.language.clauses import Condition

MOST_TRIED = 1 << 22
"""Ways that are tried in one capture, and lines that join them, before it is refused."""


class Joins:
    """Which ends of other lines joined ways: noted only where hits are told."""

    def ended(self, line: Any, many: int) -> Whole:
        """Return numbers for the ends of a line, (many,) int64."""
        return np.full(many, -1)

    def add(self, link: Whole, end: Whole) -> Whole:
        """Return the links of ways that some ends join, (N,) int64 each."""
        return link


MANNERS = ("move", "at", "hold")
"""As what a symbol may be taken."""


@dataclass(slots=True, eq=False)
class Hulls:
    """Ways in which lines can be with what stands beside them.

    Attributes
    ----------
    line, low, high : ndarray
        (N,) int64: of which line, and the hull.
    taken, owed, seen, link
        As in `Memory`.
    """

    line: Whole
    low: Whole
    high: Whole
    taken: Taken
    owed: Whole
    seen: Whole
    link: Whole

    def at(self, chosen: Numbers) -> Hulls:
        """Return some of them."""
        return Hulls(
            *(self.line[chosen], self.low[chosen], self.high[chosen]),
            *(self.taken.at(chosen), self.owed[:, chosen], self.seen[:, chosen]),
            self.link[chosen],
        )


Alive = Callable[[Program], list[Mask]]
"""Gives by state of a line at which events it may stand."""


class Closing(Protocol):
    """What finds what stands beside a line."""

    def close(self, group: Group, lines: Stretches, hulls: Hulls, *, whole: bool) -> Hulls:
        """Return the ways in which a group can close."""

    def others(self, program: Program, companion: Companion) -> Others:
        """Return the ways of a line that stands beside another."""


class Settled(NamedTuple):
    """Conditions that can be told, and the columns that no other one asks for."""

    conditions: tuple[Condition, ...] = ()
    columns: tuple[int, ...] = ()


class Due:
    """When the conditions on the labels of one line can be told: once none of them can come again.

    Parameters
    ----------
    asked : Asked
        The clauses.
    program : Program
        The line.
    """

    def __init__(self, asked: Asked, program: Program) -> None:
        self._asked = asked
        known = {label for state in program.states for label in state.labels}
        self.own = [
            it for it in asked.conditions if it not in asked.of_all and asked.labels[it] <= known
        ]
        self._settled: list[frozenset[Condition]] = []
        following = [sorted({edge.entry.state for edge in edges}) for edges in program.edges]
        for state in program.states if self.own else ():
            coming = {
                label
                for number in reached(following, state.number)
                for label in program.states[number].labels
            }
            told = (it for it in self.own if not asked.labels[it] & coming)
            self._settled.append(frozenset(told))

    def at(self, before: int | None, state: int) -> Settled:
        """Return what can be told at a state, and could not at the one before."""
        if not self.own:
            return Settled()
        done = frozenset() if before is None else self._settled[before]
        fresh = self._settled[state] - done
        if not fresh:
            return Settled()
        open_still = {
            label
            for condition in self._asked.conditions
            if condition not in self._settled[state]
            for label in self._asked.labels[condition]
        }
        columns = [at for (label, _), at in self._asked.columns.items() if label not in open_still]
        return Settled(tuple(it for it in self.own if it in fresh), tuple(columns))

    def late(self, state: int) -> tuple[Condition, ...]:
        """Return what can be told only once the line ends at a state."""
        return tuple(it for it in self.own if it not in self._settled[state])


class Setting:
    """What walks through the lines of one query share.

    Parameters
    ----------
    block : Block
        Where.
    asked : Asked
        The clauses.
    source : Source
        What columns do not tell.
    tick : callable
        Is called now and then, and may raise.

    Attributes
    ----------
    contested : dict of Program to set of int
        By line, the states at which another one could want what it takes.
    outside : set of Program
        The lines that, with what stands beside them, could want what lines further out do.
    refused : ndarray
        (captures,) bool: those in which more than `MOST_TRIED` ways were tried.
    """

    company: Closing

    def __init__(
        self, block: Block, asked: Asked, source: Source, tick: Callable[[], None]
    ) -> None:
        self.block, self.asked, self.tick, self.joins = block, asked, tick, Joins()
        self.clauses, self._source = Clauses(asked, block, source), source
        self.refused = np.zeros(len(block), bool)
        self._tried = np.zeros(len(block), np.int64)
        self.contested: dict[Program, set[int]] = {}
        self.outside: set[Program] = set()
        self._rivals: dict[Program, set[Program]] = {}
        self._backwards: dict[Program, Backwards] = {}
        self._alive: dict[Program, list[Mask]] = {}
        self._wanted: dict[tuple[Program, str], Whole] = {}
        self._lanes: dict[str, int] = {}
        self._widths: list[int] = []
        self._begins = [0]
        self._due: dict[Program, Due] = {}

    def inside(self, block: Block) -> Setting:
        """Return the same in another block."""
        return Setting(block, self.asked, self._source, self.tick)

    def tried(self, capture: Whole) -> Mask | None:
        """Count ways by their captures; return which are not refused, None: all of them."""
        self._tried += np.bincount(capture, minlength=len(self.block))
        self.refused |= self._tried > MOST_TRIED
        return ~self.refused[capture] if self.refused.any() else None

    def due(self, program: Program) -> Due:
        """Return when the conditions on the labels of a line can be told."""
        if program not in self._due:
            self._due[program] = Due(self.asked, program)
        return self._due[program]

    def enter(self, program: Program) -> None:
        """Take note of what the lines of a program could want of each other."""
        lines: list[_Line] = []
        _list_lines(program, lines)
        for (one, first), (other, second) in combinations_with_replacement(enumerate(lines), 2):
            again = [it for it in lines if it.again and it.holds(one) and it.holds(other)]
            if (one != other or again) and self._compared(first.program, second.program):
                parting = [it for it in lines if it.holds(one) != it.holds(other)]
                self.outside.update(it.program for it in (*parting, *again))

    def _compared(self, one: Program, other: Program) -> bool:
        """Tell whether two lines could want the same, and note at which states."""
        found = False
        for first, second in product(_kinds(one), _kinds(other)):
            if touching(first[0], second[0]):
                self.contested.setdefault(one, set()).update(first[1])
                self.contested.setdefault(other, set()).update(second[1])
                self._rivals.setdefault(one, set()).add(other)
                self._rivals.setdefault(other, set()).add(one)
                found = True
        return found

    def backwards(self, program: Program) -> Backwards:
        """Return the values of a line."""
        if program not in self._backwards:
            self._backwards[program] = Backwards(self.block, program)
        return self._backwards[program]

    def alive(self, program: Program) -> list[Mask]:
        """Tell the same as `alive_in`."""
        if program not in self._alive:
            self._alive[program] = alive_in(self.block, program, self.backwards(program).values)
        return self._alive[program]

    def _wanting(self, program: Program, part: str) -> Whole:
        """Return how many rows of a part before each one another line could want, (rows + 1,)."""
        if (program, part) not in self._wanted:
            opened = np.zeros(len(self.block.rows(part)) + 1, np.int64)
            for other in self._rivals[program]:
                alive = self.alive(other)
                for number in self.contested[other]:
                    state = other.states[number]
                    events = self.block.events(state)
                    for member, own in enumerate(state.members):
                        if own == part:
                            fits = alive[number]
                            np.add.at(opened, events.first[member][fits], 1)
                            np.add.at(opened, events.last[member][fits] + 1, -1)
            before = np.cumsum(np.cumsum(opened)[:-1] > 0)
            self._wanted[program, part] = np.append(0, before)
        return self._wanted[program, part]

    def wanted(self, program: Program, state: int) -> Mask:
        """Tell which events of a state of a line another one could want, (N,) bool."""
        told = program.states[state]
        events = self.block.events(told)
        found = np.zeros(len(events), bool)
        for part, first, last in zip(told.members, events.first, events.last, strict=True):
            if state in self.contested.get(program, ()):
                before = self._wanting(program, part)
                found |= before[last + 1] > before[first]
        return found

    def claims(self, program: Program, state: State, events: Whole) -> Taken:
        """Return what events take at a state of a line, as far as another one could want it."""
        own = self.block.events(state).at(events)
        found = nothing(len(events))
        for part, first, last in zip(state.members, own.first, own.last, strict=True):
            before = self._wanting(program, part)
            wanted = before[last + 1] > before[first]
            if not wanted.any():
                continue
            rows = self.block.rows(part)
            lane = self.lane(manner_of(state), part)
            passing = rows.passing[first]
            begin = lane + np.where(passing, len(rows) + 1 + first, rows.rank[first])
            end = lane + np.where(passing, len(rows) + 1 + last, rows.rank[last])
            begin, end = np.where(wanted, begin, FAR), np.where(wanted, end, FAR)
            found = found.with_those(one_each(begin, end))
        return found

    def claimed(self) -> list[tuple[str, Rows]]:
        """Return the parts of which anything is claimed, with their rows."""
        return [(part, self.block.rows(part)) for part in self._lanes]

    @cached_property
    def slack(self) -> Whole:
        """By how many frames edges may differ that should agree, by capture."""
        clocks, own = self.block.clocks()
        slack = [floor(self.block.tolerance * clock.rate) for clock in clocks]
        return np.array(slack, np.int64)[own]

    def lane(self, manner: str, part: str) -> int:
        """Return from where on the claims of a part's movements, stays or rests are counted."""
        if part not in self._lanes:
            self._lanes[part] = len(self._widths)
            self._widths.append(2 * len(self.block.rows(part)) + 4)
            self._begins.append(self._begins[-1] + len(MANNERS) * self._widths[-1])
        lane = self._lanes[part]
        return self._begins[lane] + MANNERS.index(manner) * self._widths[lane]

    def forgiving(self, had: Taken) -> Taken:
        """Return what lines have taken, and the movements that led there; in no order."""
        if not had:
            return had
        begins, widths = np.array(self._begins), np.array([*self._widths, 1])
        lane = np.searchsorted(begins, had.first, "right") - 1
        passed = (had.first - begins[lane]) // widths[lane] * widths[lane]
        first = np.where(had.first < FAR, had.first - passed, FAR)
        last = np.where(had.first < FAR, had.last - passed, FAR)
        return Taken(np.concatenate((had.first, first)), np.concatenate((had.last, last)))

    def met(self, conditions: Iterable[Condition], capture: Whole, seen: Whole) -> Whole:
        """Return the places of the ways that meet conditions on labels."""
        told = Told(capture, seen, capture, capture, capture, capture)
        fits = np.ones(len(capture), bool)
        for condition in conditions:
            fits &= self.clauses.holds(condition, told)
        return np.flatnonzero(fits)

    def met_where_known(
        self, conditions: Iterable[Condition], capture: Whole, seen: Whole
    ) -> Whole:
        """Return the places of the ways that meet conditions on labels, or lack one of these."""
        fits = np.ones(len(capture), bool)
        for condition in conditions:
            known = np.ones(len(capture), bool)
            for label in self.asked.labels[condition]:
                known &= seen[self.asked.place(label)] >= 0
            some = np.flatnonzero(known & fits)
            fits[some] = False
            fits[some[self.met([condition], capture[some], seen[:, some])]] = True
        return np.flatnonzero(fits)


def alive_in(block: Block, program: Program, values: list[Whole]) -> list[Mask]:
    """Tell by state at which of its events a line may stand, with what it remembers left out.

    An end can be reached from there; where no other state leads there, the line may begin there.
    """
    found = []
    entered = {edge.entry.state for edges in program.edges for edge in edges}
    for state, exits, value in zip(program.states, program.exits, values, strict=True):
        fits = (value < NONE) | (block.events(state).starting & bool(exits))
        if state.number not in entered:
            entries = [it for it in program.entries if it.state == state.number]
            fits &= np.any([roots(block, program, it) for it in entries], axis=0)
        found.append(fits)
    return found


def open_groups(program: Program) -> list[tuple[Group, ...]]:
    """Return the brackets that are open at each state, the inner ones last."""
    found: list[tuple[Group, ...]] = [()] * len(program.states)
    todo = [(entry.state, entry.opens) for entry in program.entries]
    seen: set[int] = set()
    while todo:
        state, groups = todo.pop()
        if state not in seen:
            seen.add(state)
            found[state] = groups
            for edge in program.edges[state]:
                left = groups[: len(groups) - len(edge.exit.closes)]
                todo.append((edge.entry.state, (*left, *edge.entry.opens)))
    return found


@dataclass(slots=True)
class _Line:
    """A line in the list of a program's lines: with where it stands, and all beside it behind it.

    `again`: whether it stands beside a bracket that may come again without end.
    """

    program: Program
    again: bool
    first: int
    last: int

    def holds(self, place: int) -> bool:
        """Return whether a line is this one, or stands beside it."""
        return self.first <= place < self.last


def _list_lines(program: Program, lines: list[_Line], *, again: bool = False) -> None:
    """List a line and all beside it."""
    own = _Line(program, again, len(lines), 0)
    lines.append(own)
    repeated = {
        group
        for states in components(program)
        for state in states
        for edge in program.edges[state]
        if edge.entry.state in states
        for group in edge.exit.closes
    }
    for group in (program.whole, *program.brackets):
        for companion in group.companions:
            whole = group is program.whole
            for inner in standing(program, companion) if whole else companion.programs:
                _list_lines(inner, lines, again=group in repeated)
    own.last = len(lines)


def _kinds(program: Program) -> list[tuple[State, list[int]]]:
    """Return the different states of a program, each with the numbers of those alike."""
    kinds: dict[object, tuple[State, list[int]]] = {}
    for state in program.states:
        fits = tuple(frozenset(it.items()) for it in state.fits)
        key = (state.members, state.manner, fits)
        kinds.setdefault(key, (state, []))[1].append(state.number)
    return list(kinds.values())


def manner_of(state: State) -> str:
    """Return as what a state takes what it takes: what is gone through is a movement."""
    return state.manner if state.manner in MANNERS else MANNERS[0]


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
