"""Trace: which symbols make up each hit, line by line.

A search finds where hits are. For those that are looked at the same walk runs once more over their
captures, from their first symbols: now each partial match notes its cost and how many steps it is,
and keeps a link to the one it came from. Of the matches with the frames of a hit the one that fits
best is followed back, of those the one of most steps.
"""

from __future__ import annotations

from bisect import bisect
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from lanindex.search.language.query import Query
from lanindex.search.match.arrays import FAR, BoolArray, IntArray, best_of_each
from lanindex.search.match.backward import cost_of, end_of, may_leave
from lanindex.search.match.batch import Batch
from lanindex.search.match.conditions import Captures, Clauses
from lanindex.search.match.context import Context, Joins
from lanindex.search.match.follow import Transitions
from lanindex.search.match.hits import BestTrace, HitTable, HitTrace, Step, table
from lanindex.search.match.join import Joiner
from lanindex.search.match.leading import complete
from lanindex.search.match.matches import EVENT, Matches, Nodes, distinct
from lanindex.search.match.mirror_runs import repeats, traced_mirror_runs
from lanindex.search.match.relations import RELATIONS, EndBounds
from lanindex.search.match.rewrites import ONLY, Rewrites, enough
from lanindex.search.match.walk import Ends, Walk
from lanindex.search.plan import Program, State

COST, STEPS = range(-2, 0)
"""The last columns of each partial match: what is missing to a fit of 1, and its steps."""


def traced(
    hits: HitTable, query: Query, rewrites: Iterable[Rewrites], batch: Batch, captures: Captures
) -> list[HitTrace | None]:
    """Return what hits in a batch of their captures alone are made of, None: it is not there.

    Raises `OverBudget` if there are too many partial matches.
    """
    clauses = Clauses(query)
    best: list[BestTrace | None] = [None] * len(hits)
    for one in rewrites:
        lines = repeats(clauses, one.program)
        if lines:
            found = traced_mirror_runs(batch, lines, hits)
        else:
            found = _Context(batch, one, query, captures, hits).traced(hits)
        for number, trace in found:
            before = best[number]
            if before is None or trace[0] < before[0]:
                best[number] = trace
    return [it and HitTrace(it[0][0], list(it[1])) for it in best]


class _Clauses(Clauses):
    """The clauses of a query, with cost and steps noted besides."""

    @property
    def width(self) -> int:
        return super().width + 2

    def noted(self, batch: Batch, state: State, events: IntArray, notes: IntArray) -> IntArray:
        found = super().noted(batch, state, events, notes).copy()
        found[COST] = np.maximum(found[COST], batch.events(state).cost[events])
        found[STEPS] = np.maximum(found[STEPS], 0) + 1
        return found


class _Context(Context):
    """What the lines of a program share while hits are traced."""

    joins: _Joins

    def __init__(
        self, batch: Batch, rewrites: Rewrites, query: Query, captures: Captures, hits: HitTable
    ) -> None:
        super().__init__(batch, rewrites, _Clauses(query), captures)
        self.lying_in = _lying_in(self.program)
        # (captures,) where hits lie, and how long they are
        self.low, self.high = np.full(len(batch), FAR), np.zeros(len(batch), np.int64)
        np.minimum.at(self.low, hits.capture, hits.low)
        np.maximum.at(self.high, hits.capture, hits.high)
        self.joins = _Joins()

    def count_tried(self, capture: IntArray) -> BoolArray | None:
        """Refuse nothing: what was found can be traced."""
        return None

    def traced(self, hits: HitTable) -> Iterator[tuple[int, BestTrace]]:
        """Yield the places of hits that this program can lead, each with its best match."""
        end = enough(self.program)
        joiner = Joiner(self, lambda *line: _Walk(*line).as_companions())
        line = _Walk(joiner, self.program, end, timed=bool(self.clauses.rhythm))
        places = dict(zip(_beginnings(hits), range(len(hits)), strict=True))
        owners, begun, horizon = [], self.roots(self.program), []
        for entry, fits in zip(self.program.entries, begun, strict=True):
            state, chosen = self.program.states[entry.state], np.flatnonzero(fits)
            events, none = self.batch.events(state).at(chosen), np.zeros(len(chosen), np.int64)
            owner = np.full(len(fits), -1)
            begins = table(self.batch, state, events, (none, none, none))
            owner[chosen] = [places.get(it, -1) for it in _beginnings(begins)]
            fits &= owner >= 0
            owners.append(owner)
            horizon.append(hits.high[owner])
        if any(fits.any() for fits in begun):
            line.run(begun, None if self.program.open_ended else horizon)
            yield from line.best(owners, hits)


def _beginnings(hits: HitTable) -> Iterator[tuple[int, ...]]:
    """Yield what tells hits apart: capture, parts and rows of the first symbols."""
    return zip(hits.capture.tolist(), hits.parts.tolist(), *hits.rows.tolist(), strict=True)


class _Walk(Walk):
    """A walk that notes where each partial match comes from."""

    _context: _Context

    def __init__(
        self, joiner: Joiner, program: Program, enough: str | None, *, timed: bool = False
    ) -> None:
        # where each beginning has one match, its value has all but the symbols
        only = ONLY if enough == ONLY else None
        super().__init__(joiner, program, timed=timed, tracked=True, enough=only)
        self._ahead: dict[int, tuple[IntArray, Transitions]] = {}

    def run(
        self,
        roots: list[BoolArray] | None = None,
        horizon: list[IntArray] | None = None,
        bounds: list[EndBounds] | None = None,
    ) -> Ends:
        """Return all matches; of a line that must lie in the hit those that can."""
        self.nodes, self._begins = Nodes(), list[int]()
        self._tables = list[tuple[int, Matches]]()
        context, beside = self._context, roots is None
        if beside and self._program in context.lying_in:
            low, high = context.low, context.high
            roots, horizon = context.roots(self._program), []
            for entry, fits in zip(self._program.entries, roots, strict=True):
                events = self._batch.events(self._program.states[entry.state])
                fits &= low[events.capture] <= events.start
                fits &= events.start <= high[events.capture]
                horizon.append(high[events.capture])
        self.ends = found = super().run(roots, horizon, bounds)
        if beside:
            columns = found.memory.columns.copy()
            columns[STEPS] = -1
            found = replace(found, memory=replace(found.memory, columns=columns))
        return found

    def _look_up_ends(self, state: int, rows: Matches) -> Matches:
        starting = super()._look_up_ends(state, rows)
        columns = self._looked_up[-1].columns
        columns[COST] = np.maximum(columns[COST], cost_of(columns[EVENT]))
        return starting

    def _merged(self, state: int, tables: list[Matches]) -> Matches:
        """Return matches; of those that remember the same the one that fits best, of most steps."""
        rows = self._arrived(state, tables)
        which = distinct([*rows.columns[:COST], *rows.rest()], len(rows))[1]
        best = rows.at(best_of_each((which,), (rows.columns[COST], -rows.columns[STEPS])))
        self._begins.append(self.nodes.many)
        self._tables.append((state, best))
        parent = self.nodes.add(len(best), rows.parent, which)
        return replace(best, parent=parent, link=np.full(len(best), -1))

    def best(self, owners: list[IntArray], hits: HitTable) -> Iterator[tuple[int, BestTrace]]:
        """Yield the best end of each hit; `owners` are the hits, by entry, that events begin."""
        chosen = complete(self._context, self, self.ends)
        ends = self.ends.at(chosen)
        owner = np.full(len(chosen), -1)
        for entry, own in enumerate(owners):
            here = ends.entry == entry
            owner[here] = own[ends.root[here]]
        same = (ends.spans.low == hits.low[owner]) & (ends.spans.high == hits.high[owner])
        fits = np.flatnonzero((owner >= 0) & same)
        cost, less = ends.memory.columns[COST, fits], -ends.memory.columns[STEPS, fits]
        for place in best_of_each((owner[fits],), (cost, less)).tolist():
            rank = int(cost[place]), int(less[place])
            yield int(owner[fits[place]]), (rank, self.lines(int(chosen[fits[place]])))

    def lines(self, end: int) -> Iterator[list[Step]]:
        """Yield the steps of the line up to an end, then those of each one beside it."""
        steps, joined = list[tuple[int, int]](), [self.ends.memory.link.item(end)]
        node = self.ends.node.item(end)
        if self.ends.row.item(end) < 0:
            entry = self._program.entries[self.ends.entry.item(end)]
            steps = self._by_values(entry.state, self.ends.root.item(end))[::-1]
        while node >= 0:
            state, event, node, link = self._node(node)
            steps.append((state, event))
            joined.append(link)
        states = self._program.states
        yield [(states[state], event) for state, event in reversed(steps)]
        for link in reversed(joined):
            for line, place in self._context.joins.listed(link):
                yield from line.lines(place)

    def _by_values(self, state: int, event: int) -> list[tuple[int, int]]:
        """Return the states and events of the clearest match from an event to its best end."""
        value = self._context.backwards(self._program).values[state][event]
        end, cost = int(end_of(value)), int(cost_of(value))
        steps: list[tuple[int, int]] = []
        following: tuple[int, int] | None = state, event
        while following:
            steps.append(following)
            following = self._following(*following, end, cost)
        return steps

    def _following(self, state: int, event: int, end: int, cost: int) -> tuple[int, int] | None:
        """Return the state and event that an event leads to, if it ends so and costs no more."""
        for edge in self._program.edges[state]:
            if id(edge) not in self._ahead:
                self._ahead[id(edge)] = self._context.backwards(self._program).ahead(edge)
            values, reach = self._ahead[id(edge)]
            places = reach.following(event)
            fits = (end_of(values[places]) == end) & (cost_of(values[places]) <= cost)
            if fits.any() and may_leave(self._batch, self._program, edge.exit)[event]:
                return edge.entry.state, int(places[fits.argmax()])
        return None

    def _node(self, node: int) -> tuple[int, int, int, int]:
        """Return the state of a node, its event, the node that it comes from, and its link."""
        number = bisect(self._begins, node) - 1
        state, rows = self._tables[number]
        place = node - self._begins[number]
        event = rows.columns.item(EVENT, place)
        return state, event, rows.parent.item(place), rows.link.item(place)


class _Joins(Joins):
    """Which ends of lines joined matches, one after the other."""

    def __init__(self) -> None:
        self._lines: list[_Walk] = []
        self._begins = [0]
        self._added: list[tuple[IntArray, IntArray]] = []
        self._firsts = [0]

    def ended(self, line: Walk, many: int) -> IntArray:
        """Return numbers for the ends of a line."""
        assert isinstance(line, _Walk)
        begin = self._begins[-1]
        self._lines.append(line)
        self._begins.append(begin + many)
        return np.arange(begin, begin + many)

    def add(self, link: IntArray, end: IntArray) -> IntArray:
        """Return the links of matches that some ends join."""
        first = self._firsts[-1]
        self._added.append((link, end))
        self._firsts.append(first + len(end))
        return np.arange(first, first + len(end))

    def listed(self, link: int) -> list[tuple[_Walk, int]]:
        """Return the ends behind a link, the first that joined first: lines and places."""
        found: list[tuple[_Walk, int]] = []
        while link >= 0:
            number = bisect(self._firsts, link) - 1
            link, end = (int(it[link - self._firsts[number]]) for it in self._added[number])
            place = bisect(self._begins, end) - 1
            found.append((self._lines[place], end - self._begins[place]))
        return found[::-1]


def _lying_in(program: Program) -> set[Program]:
    """Return the lines beside a program that lie in the hit, wherever they are.

    Beside a line that runs on there may be others: what goes on behind the hit is no hit only if it
    is complete.
    """
    inside: set[Program] = set()
    outside: set[Program] = set()
    todo = [(program, not program.open_ended)]
    while todo:
        line, within = todo.pop()
        for companion in line.companions:
            adds = RELATIONS[companion.relation].adds_frames
            for inner in companion.programs:
                lies = within and adds and not inner.open_ended
                (inside if lies else outside).add(inner)
                todo.append((inner, lies))
    return inside - outside
