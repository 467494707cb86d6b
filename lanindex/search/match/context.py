"""What the lines of one query share, in one batch of captures."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations_with_replacement, product
from math import floor
from typing import Any, NamedTuple, Protocol

import numpy as np

from lanindex.search.automaton import NEGATIONS, Companion, Group, Program, State
from lanindex.search.language.clauses import Condition
from lanindex.search.match import matches, relations
from lanindex.search.match.arrays import FAR, AnyArray, BoolArray, IntArray
from lanindex.search.match.backward import Backwards, components, reached
from lanindex.search.match.batch import Batch
from lanindex.search.match.conditions import Clauses, Evaluator, Source, Told
from lanindex.search.match.follow import NONE
from lanindex.search.match.hit_table import roots
from lanindex.search.match.matches import Claims, Nodes, filled, nothing, one_each
from lanindex.search.match.relations import RELATIONS, Spans
from lanindex.search.match.rows import Rows


@dataclass(slots=True, eq=False)
class Others:
    """The ways of a line, of one side, that stands beside another.

    Attributes
    ----------
    lines : Spans
        Their frames.
    claims, unmet, seen
        What they remember, as in `Matches`.
    node : ndarray
        (N,) int64: where they end.
    end : ndarray
        (N,) int64: numbers in `Joins`.
    nodes : Nodes or None
        What goes on in what, of a line that runs on as long as it can.
    """

    lines: Spans
    claims: Claims
    unmet: IntArray
    seen: IntArray
    node: IntArray
    end: IntArray
    nodes: Nodes | None

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.node)

    def at(self, chosen: AnyArray) -> Others:
        """Return some of them."""
        memory = self.claims.at(chosen), self.unmet[:, chosen], self.seen[:, chosen]
        ends = self.node[chosen], self.end[chosen]
        return Others(self.lines.at(chosen), *memory, *ends, self.nodes)

    @property
    def free(self) -> bool:
        """Whether they remember nothing."""
        return not (self.claims or self.unmet.size) and int(self.seen.max(initial=-1)) < 0

    def last(self) -> Others:
        """Return those that do not go on in another one."""
        if not self.nodes:
            return self
        line = np.zeros(len(self), np.int64)
        last = self.at(np.flatnonzero(~self.nodes.behind(line, self.node)))
        last.nodes = None
        return last

    def keys(self) -> list[IntArray]:
        """Return what they look like from outside."""
        lines = self.lines
        frames = [lines.capture, lines.start, lines.until, lines.low, lines.high]
        rest = [*self.claims.first, *self.claims.last, *self.unmet, *self.seen]
        return [*frames, lines.alone.astype(np.int64), *rest]


def gathered(tables: list[Others]) -> Others:
    """Return the ways of all sides; it is not told any more which goes on in which."""
    return Others(
        relations.gathered([it.lines for it in tables]),
        matches.beside_each_other([it.claims for it in tables]),
        filled([it.unmet for it in tables]),
        np.concatenate([it.seen for it in tables], axis=1),
        np.concatenate([it.node for it in tables]),
        np.concatenate([it.end for it in tables]),
        None,
    )


MOST_TRIED = 1 << 22
"""Ways that are tried in one capture, and lines that join them, before it is refused."""


class Joins:
    """Which ends of other lines joined ways: noted only where hits are told."""

    def ended(self, line: Any, many: int) -> IntArray:
        """Return numbers for the ends of a line, (many,) int64."""
        return np.full(many, -1)

    def add(self, link: IntArray, end: IntArray) -> IntArray:
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
    claims, unmet, seen, link
        As in `Matches`.
    """

    line: IntArray
    low: IntArray
    high: IntArray
    claims: Claims
    unmet: IntArray
    seen: IntArray
    link: IntArray

    def at(self, chosen: AnyArray) -> Hulls:
        """Return some of them."""
        return Hulls(
            *(self.line[chosen], self.low[chosen], self.high[chosen]),
            *(self.claims.at(chosen), self.unmet[:, chosen], self.seen[:, chosen]),
            self.link[chosen],
        )


Alive = Callable[[Program], list[BoolArray]]
"""Gives by state of a line at which events it may stand."""


class Closing(Protocol):
    """What finds what stands beside a line."""

    def close(self, group: Group, lines: Spans, hulls: Hulls, *, whole: bool) -> Hulls:
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
    clauses : Clauses
        The clauses.
    program : Program
        The line.
    """

    def __init__(self, clauses: Clauses, program: Program) -> None:
        self._clauses = clauses
        known = {label for state in program.states for label in state.labels}
        self.own = [
            it
            for it in clauses.conditions
            if it not in clauses.of_all and clauses.labels[it] <= known
        ]
        self._settled: list[frozenset[Condition]] = []
        following = [sorted({edge.entry.state for edge in edges}) for edges in program.edges]
        for state in program.states if self.own else ():
            coming = {
                label
                for number in reached(following, state.number)
                for label in program.states[number].labels
            }
            told = (it for it in self.own if not clauses.labels[it] & coming)
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
            for condition in self._clauses.conditions
            if condition not in self._settled[state]
            for label in self._clauses.labels[condition]
        }
        columns = [
            at for (label, _), at in self._clauses.columns.items() if label not in open_still
        ]
        return Settled(tuple(it for it in self.own if it in fresh), tuple(columns))

    def late(self, state: int) -> tuple[Condition, ...]:
        """Return what can be told only once the line ends at a state."""
        return tuple(it for it in self.own if it not in self._settled[state])


class Context:
    """What walks through the lines of one query share.

    Parameters
    ----------
    batch : Batch
        Where.
    clauses : Clauses
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

    joiner: Closing

    def __init__(
        self, batch: Batch, clauses: Clauses, source: Source, tick: Callable[[], None]
    ) -> None:
        self.batch, self.clauses, self.tick, self.joins = batch, clauses, tick, Joins()
        self.evaluator, self._source = Evaluator(clauses, batch, source), source
        self.refused = np.zeros(len(batch), bool)
        self._tried = np.zeros(len(batch), np.int64)
        self.contested: dict[Program, set[int]] = {}
        self.outside: set[Program] = set()
        self._rivals: dict[Program, set[Program]] = {}
        self._backwards: dict[Program, Backwards] = {}
        self._alive: dict[Program, list[BoolArray]] = {}
        self._wanted: dict[tuple[Program, str], IntArray] = {}
        self._lanes: dict[str, int] = {}
        self._widths: list[int] = []
        self._begins = [0]
        self._due: dict[Program, Due] = {}

    def inside(self, batch: Batch) -> Context:
        """Return the same in another batch."""
        return Context(batch, self.clauses, self._source, self.tick)

    def tried(self, capture: IntArray) -> BoolArray | None:
        """Count ways by their captures; return which are not refused, None: all of them."""
        self._tried += np.bincount(capture, minlength=len(self.batch))
        self.refused |= self._tried > MOST_TRIED
        return ~self.refused[capture] if self.refused.any() else None

    def due(self, program: Program) -> Due:
        """Return when the conditions on the labels of a line can be told."""
        if program not in self._due:
            self._due[program] = Due(self.clauses, program)
        return self._due[program]

    def enter(self, program: Program) -> None:
        """Take note of what the lines of a program could want of each other."""
        lines: list[_Line] = []
        _list_lines(program, lines)
        for (one, first), (other, second) in combinations_with_replacement(enumerate(lines), 2):
            again = [it for it in lines if it.again and it.holds(one) and it.holds(other)]
            if (one != other or again) and self._compared(first, second):
                parting = [it for it in lines if it.holds(one) != it.holds(other)]
                self.outside.update(it.program for it in (*parting, *again))

    def _compared(self, one: _Line, other: _Line) -> bool:
        """Tell whether two lines could want the same, and note at which states."""
        found = False
        one, other = sorted((one, other), key=lambda it: it.denied)
        first, second = one.program, other.program
        for (state, own), (beside, their) in product(_kinds(first), _kinds(second)):
            manner = manner_of(beside)
            # what must not happen does not count where a stay or a rest of the hit came by it
            came_by_it = one.denied < other.denied and manner == MANNERS[0]
            if (came_by_it or manner_of(state) == manner) and touching(state, beside):
                self.contested.setdefault(first, set()).update(own)
                self.contested.setdefault(second, set()).update(their)
                self._rivals.setdefault(first, set()).add(second)
                self._rivals.setdefault(second, set()).add(first)
                found = True
        return found

    def backwards(self, program: Program) -> Backwards:
        """Return the values of a line."""
        if program not in self._backwards:
            self._backwards[program] = Backwards(self.batch, program)
        return self._backwards[program]

    def alive(self, program: Program) -> list[BoolArray]:
        """Tell the same as `alive_in`."""
        if program not in self._alive:
            self._alive[program] = alive_in(self.batch, program, self.backwards(program).values)
        return self._alive[program]

    def _wanting(self, program: Program, part: str) -> IntArray:
        """Return how many rows of a part before each one another line could want, (rows + 1,)."""
        if (program, part) not in self._wanted:
            opened = np.zeros(len(self.batch.rows(part)) + 1, np.int64)
            for other in self._rivals[program]:
                alive = self.alive(other)
                for number in self.contested[other]:
                    state = other.states[number]
                    events = self.batch.events(state)
                    for member, own in enumerate(state.members):
                        if own == part:
                            fits = alive[number]
                            np.add.at(opened, events.first[member][fits], 1)
                            np.add.at(opened, events.last[member][fits] + 1, -1)
            before = np.cumsum(np.cumsum(opened)[:-1] > 0)
            self._wanted[program, part] = np.append(0, before)
        return self._wanted[program, part]

    def wanted(self, program: Program, state: int) -> BoolArray:
        """Tell which events of a state of a line another one could want, (N,) bool."""
        told = program.states[state]
        events = self.batch.events(told)
        found = np.zeros(len(events), bool)
        for part, first, last in zip(told.members, events.first, events.last, strict=True):
            if state in self.contested.get(program, ()):
                before = self._wanting(program, part)
                found |= before[last + 1] > before[first]
        return found

    def claims(self, program: Program, state: State, events: IntArray) -> Claims:
        """Return what events take at a state of a line, as far as another one could want it."""
        own = self.batch.events(state).at(events)
        found = nothing(len(events))
        for part, first, last in zip(state.members, own.first, own.last, strict=True):
            before = self._wanting(program, part)
            wanted = before[last + 1] > before[first]
            if not wanted.any():
                continue
            rows = self.batch.rows(part)
            lane = self.lane(manner_of(state), part)
            passing = rows.passing[first]
            begin = lane + np.where(passing, len(rows) + 1 + first, rows.rank[first])
            end = lane + np.where(passing, len(rows) + 1 + last, rows.rank[last])
            begin, end = np.where(wanted, begin, FAR), np.where(wanted, end, FAR)
            found = found.with_those(one_each(begin, end))
        return found

    def claimed(self) -> list[tuple[str, Rows]]:
        """Return the parts of which anything is claimed, with their rows."""
        return [(part, self.batch.rows(part)) for part in self._lanes]

    @cached_property
    def slack(self) -> IntArray:
        """By how many frames edges may differ that should agree, by capture."""
        clocks, own = self.batch.clocks()
        slack = [floor(self.batch.tolerance * clock.rate) for clock in clocks]
        return np.array(slack, np.int64)[own]

    def lane(self, manner: str, part: str) -> int:
        """Return from where on the claims of a part's movements, stays or rests are counted."""
        if part not in self._lanes:
            self._lanes[part] = len(self._widths)
            self._widths.append(2 * len(self.batch.rows(part)) + 4)
            self._begins.append(self._begins[-1] + len(MANNERS) * self._widths[-1])
        lane = self._lanes[part]
        return self._begins[lane] + MANNERS.index(manner) * self._widths[lane]

    def forgiving(self, had: Claims) -> Claims:
        """Return what lines have taken, and the movements that led there; in no order."""
        if not had:
            return had
        begins, widths = np.array(self._begins), np.array([*self._widths, 1])
        lane = np.searchsorted(begins, had.first, "right") - 1
        passed = (had.first - begins[lane]) // widths[lane] * widths[lane]
        first = np.where(had.first < FAR, had.first - passed, FAR)
        last = np.where(had.first < FAR, had.last - passed, FAR)
        return Claims(np.concatenate((had.first, first)), np.concatenate((had.last, last)))

    def met(self, conditions: Iterable[Condition], capture: IntArray, seen: IntArray) -> IntArray:
        """Return the places of the ways that meet conditions on labels."""
        told = Told(capture, seen, capture, capture, capture, capture)
        fits = np.ones(len(capture), bool)
        for condition in conditions:
            fits &= self.evaluator.holds(condition, told)
        return np.flatnonzero(fits)

    def met_where_known(
        self, conditions: Iterable[Condition], capture: IntArray, seen: IntArray
    ) -> IntArray:
        """Return the places of the ways that meet conditions on labels, or lack one of these."""
        fits = np.ones(len(capture), bool)
        for condition in conditions:
            known = np.ones(len(capture), bool)
            for label in self.clauses.labels[condition]:
                known &= seen[self.clauses.place(label)] >= 0
            some = np.flatnonzero(known & fits)
            fits[some] = False
            fits[some[self.met([condition], capture[some], seen[:, some])]] = True
        return np.flatnonzero(fits)


def alive_in(batch: Batch, program: Program, values: list[IntArray]) -> list[BoolArray]:
    """Tell by state at which of its events a line may stand, with what it remembers left out.

    An end can be reached from there; where no other state leads there, the line may begin there.
    """
    found = []
    entered = {edge.entry.state for edges in program.edges for edge in edges}
    for state, exits, value in zip(program.states, program.exits, values, strict=True):
        fits = (value < NONE) | (batch.events(state).starting & bool(exits))
        if state.number not in entered:
            entries = [it for it in program.entries if it.state == state.number]
            fits &= np.any([roots(batch, program, it) for it in entries], axis=0)
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

    `again`: whether it stands beside a bracket that may come again without end; `denied`: how many
    negations it is in.
    """

    program: Program
    again: bool
    denied: int
    first: int
    last: int

    def holds(self, place: int) -> bool:
        """Return whether a line is this one, or stands beside it."""
        return self.first <= place < self.last


def _list_lines(
    program: Program, lines: list[_Line], *, again: bool = False, denied: int = 0
) -> None:
    """List a line and all beside it."""
    own = _Line(program, again, denied, len(lines), 0)
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
            whole, deeper = group is program.whole, denied + (companion.relation in NEGATIONS)
            for inner in standing(program, companion) if whole else companion.programs:
                _list_lines(inner, lines, again=group in repeated, denied=deeper)
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


def standing(program: Program, companion: Companion) -> tuple[Program, ...]:
    """Return the lines that can stand beside all of a leading line, or disturb it."""
    part = _run_of(program) if _sharing(program, companion) else None
    return tuple(it for it in companion.programs if part is None or _run_of(it) != part)


def _sharing(program: Program, companion: Companion) -> bool:
    """Tell whether what stands beside a line shares a frame with the line itself."""
    if companion.within:
        return False
    if companion.relation != "without":
        return RELATIONS[companion.relation].shares_frame
    inside = [it for group in program.brackets for it in group.companions]
    adding = any(RELATIONS[it.relation].adds_frames for it in program.whole.companions)
    return not inside and not adding


def _run_of(program: Program) -> str | None:
    """Return the part of which a line takes movements that follow each other, if it is one."""
    edges = [edge for edges in program.edges for edge in edges]
    parts = {state.members for state in program.states}
    linked = all(edge.same and not edge.arrow.later for edge in edges)
    moving = all(state.manner == "move" for state in program.states)
    (members, *others) = parts
    return members[0] if linked and moving and len(members) == 1 and not others else None
