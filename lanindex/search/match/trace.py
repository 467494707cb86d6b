"""Which symbols hits are made of, line by line: their ways are walked again, and followed back.

A search tells where hits are. For those that are shown their captures alone are walked once more,
from the first symbols of these hits: now each way notes how clear it is, and where it comes from.
Of the ways that have the frames of a hit the clearest is told, of those the one of most steps.
"""

from __future__ import annotations

from bisect import bisect
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from lanindex.search.automaton import Program, State
from lanindex.search.language.query import Query
from lanindex.search.match.arrays import FAR, BoolArray, IntArray, starts_of
from lanindex.search.match.backward import Ahead, cost_of, end_of
from lanindex.search.match.batch import Batch
from lanindex.search.match.conditions import Clauses, Source
from lanindex.search.match.context import Context, Due, Joins
from lanindex.search.match.hit_table import firsts
from lanindex.search.match.hits import Matched, Told, took
from lanindex.search.match.join import Joiner
from lanindex.search.match.leading import complete
from lanindex.search.match.matches import EVENT, Matches, Nodes
from lanindex.search.match.mirror_runs import Mirrored, MirrorRuns, repeats
from lanindex.search.match.relations import RELATIONS
from lanindex.search.match.rewrites import ONLY, Rewrites, enough
from lanindex.search.match.walk import Ends, Walk

COST, STEPS = range(-2, 0)
"""What is noted besides of each way, in its last columns: what is missing to a fit of 1, and of how
many steps it is."""


class Place(NamedTuple):
    """Where a hit is: what tells it from all others.

    Attributes
    ----------
    capture : int
        In the batch.
    parts : tuple of str
        Of its first symbols.
    rows : tuple of int
        Of these, rows in the batch.
    span : tuple of int
        Its frames.
    """

    capture: int
    parts: tuple[str, ...]
    rows: tuple[int, ...]
    span: tuple[int, int]


class Tracer:
    """Tells the hits of a query in some captures.

    Parameters
    ----------
    query : Query
        What was found.
    programs : tuple of Program
        Of the query.
    batch : Batch
        Of these captures alone: of one, where a program is two repeats that mirror each other.
    source : Source
        What columns do not tell.
    tick : callable
        Is called now and then, and may raise.
    """

    def __init__(
        self,
        query: Query,
        programs: tuple[Program, ...],
        batch: Batch,
        source: Source,
        tick: Callable[[], None],
    ) -> None:
        clauses = Clauses(query)
        repeated = [(program, repeats(clauses, program)) for program in programs]
        self._settings = [
            MirrorRuns(batch, lines) if lines else _Setting(batch, query, source, tick, program)
            for program, lines in repeated
        ]

    def told(self, places: Sequence[Place]) -> list[Told | None]:
        """Return the hits that are in some places, None: there is none.

        Raises
        ------
        TooMuch
            Where there are too many ways.
        """
        best: list[_Best | None] = [None] * len(places)
        for context in self._settings:
            for number, found in context.walk(places):
                before = best[number]
                if before is None or found[0] < before[0]:
                    best[number] = found
        return [it and Told(it[0][0], list(it[1].lines(it[2]))) for it in best]


class _Noting(Clauses):
    """The clauses of a query, and what is noted besides."""

    def __init__(self, query: Query) -> None:
        super().__init__(query)
        for it in ("cost", "steps"):
            self.columns["", it] = len(self.columns)

    def noted(self, batch: Batch, state: State, events: IntArray, seen: IntArray) -> IntArray:
        found = super().noted(batch, state, events, seen).copy()
        found[COST] = np.maximum(found[COST], batch.events(state).cost[events])
        found[STEPS] = np.maximum(found[STEPS], 0) + 1
        return found


class _Setting(Context):
    """What the lines of a program share in one capture."""

    joiner: _Partners
    joins: _Joins

    def __init__(
        self,
        batch: Batch,
        query: Query,
        source: Source,
        tick: Callable[[], None],
        program: Program,
    ) -> None:
        super().__init__(batch, Rewrites(program), _Noting(query), source, tick)
        self.joins = _Joins()
        self._program, self._clauses_alone = program, Clauses(query)
        self.lying_in = _lying_in(program)
        self.span = np.empty(0, np.int64), np.empty(0, np.int64)
        self.joiner = _Partners(self)
        # where each beginning has one way, its value tells all but the symbols
        only = ONLY if enough(program) == ONLY else None
        self._line = _Line(self, program, timed=bool(self.clauses.rhythm), enough=only)

    def tried(self, capture: IntArray) -> BoolArray | None:
        """Refuse nothing: what was found can be told."""
        return None

    def due(self, program: Program) -> Due:
        """Return when the conditions on labels can be told: nothing of what is noted besides."""
        return Due(self._clauses_alone, program)

    def walk(self, places: Sequence[Place]) -> Iterator[tuple[int, _Best]]:
        """Yield of hits whose leading line this can be which they are, and their best way."""
        captures = [it.capture for it in places]
        lows, highs = np.array([it.span for it in places]).T
        low, high = np.full(len(self.batch), FAR), np.zeros(len(self.batch), np.int64)
        np.minimum.at(low, captures, lows)
        np.maximum.at(high, captures, highs)
        most = np.zeros(len(self.batch), np.int64)
        np.maximum.at(most, captures, highs - lows)
        self.span = low, high
        self.joiner.forget(self.lying_in)
        numbers = {(it.parts, it.rows): number for number, it in enumerate(places)}
        owners, begun = [], self._line.roots()
        for entry, fits in zip(self._program.entries, begun, strict=True):
            state = self._program.states[entry.state]
            known: list[tuple[str, ...]] = []
            order = firsts(state, known)[1]
            owner, chosen = np.full(len(fits), -1), np.flatnonzero(fits)
            rows = np.stack([self.batch.events(state).first[it][chosen] for it in order], axis=1)
            for event, own in zip(chosen.tolist(), map(tuple, rows.tolist()), strict=True):
                owner[event] = numbers.get((known[0], own), -1)
            fits &= owner >= 0
            owners.append(owner)
        if not any(fits.any() for fits in begun):
            return
        self._line.found(begun, None if self._program.open_ended else most)
        for end, number in self._line.best(owners, lows, highs):
            yield number, (self._line.rank(end), self._line, end)


class _Line(Walk):
    """A line that is walked with notes of where each way comes from."""

    _context: _Setting

    def __init__(
        self,
        context: _Setting,
        program: Program,
        *,
        timed: bool = False,
        enough: str | None = None,
    ) -> None:
        super().__init__(context, program, timed=timed, tracked=True, enough=enough)
        self._ahead: dict[int, Ahead] = {}
        if self._best_ends and not all(self._best_ends.settled[it.state] for it in program.entries):
            self._best_ends = None

    def found(self, begun: list[BoolArray] | None = None, within: IntArray | None = None) -> Ends:
        """Return all ways; of a line beside those that can lie in the hit, if they have to."""
        self.nodes, self._begins = Nodes(), list[int]()
        self._tables = list[tuple[int, Matches]]()
        context, beside = self._context, begun is None
        if begun is None and self._program in context.lying_in:
            low, high = context.span
            begun, within = self.roots(), np.maximum(high - low, 0)
            for entry, fits in zip(self._program.entries, begun, strict=True):
                events = self._batch.events(self._program.states[entry.state])
                fits &= (low[events.capture] <= events.start) & (
                    events.start <= high[events.capture]
                )
        self.ends = found = super().found(begun, within)
        if beside:
            columns = found.memory.columns.copy()
            columns[STEPS] = -1
            found = replace(found, memory=replace(found.memory, columns=columns))
        return found

    def _settled_best(self, state: int, rows: Matches) -> tuple[Matches, Matches]:
        found = super()._settled_best(state, rows)
        columns = self._settling[-1].columns
        columns[COST] = np.maximum(columns[COST], cost_of(columns[EVENT]))
        return found

    def _settled(self, state: int, tables: list[Matches]) -> Matches:
        """Return ways; of those that remember the same the clearest, and of most steps."""
        rows = self._standing(state, tables)
        cost, steps = rows.columns[COST].copy(), rows.columns[STEPS].copy()
        rows.columns[COST] = rows.columns[STEPS] = 0
        which = rows.alike()[1]
        rows.columns[COST], rows.columns[STEPS] = cost, steps
        order = np.lexsort((-steps, cost, which))
        best = rows.at(order[starts_of(which[order])])
        self._begins.append(self.nodes.many)
        self._tables.append((state, best))
        parent = self.nodes.add(len(best), rows.parent, which)
        return replace(best, parent=parent, link=np.full(len(best), -1))

    def best(
        self, owners: list[IntArray], low: IntArray, high: IntArray
    ) -> Iterator[tuple[int, int]]:
        """Yield the best end of each hit, and which hit that is.

        Parameters
        ----------
        owners : list of ndarray
            By entry, of which hit each event of its state is the first symbol, -1: of none.
        low, high : ndarray
            (H,) int64: the frames of each hit.
        """
        chosen = complete(self._context, self, self.ends, self._context.joiner)
        ends = self.ends.at(chosen)
        owner = np.full(len(chosen), -1)
        for entry, own in enumerate(owners):
            here = ends.entry == entry
            owner[here] = own[ends.root[here]]
        fits = np.flatnonzero((owner >= 0) & (ends.low == low[owner]) & (ends.high == high[owner]))
        columns = ends.memory.columns[:, fits]
        order = np.lexsort((-columns[STEPS], columns[COST], owner[fits]))
        first = order[starts_of(owner[fits][order])]
        yield from zip(chosen[fits[first]].tolist(), owner[fits[first]].tolist(), strict=True)

    def rank(self, end: int) -> tuple[int, int]:
        """Return what decides between ends of the same frames: the cost, then the most steps."""
        columns = self.ends.memory.columns
        return int(columns[COST, end]), -int(columns[STEPS, end])

    def lines(self, end: int) -> Iterator[list[Matched]]:
        """Yield what the line took on its way to an end, then what each one beside it took."""
        way, joined = list[Matched](), [int(self.ends.memory.link[end])]
        node = int(self.ends.node[end])
        if self.ends.row[end] < 0:
            state, event, _, _ = self._node(node)
            steps = self._by_values(state, event)[::-1]
            way += [took(self._batch, self._program.states[it], place) for it, place in steps[:-1]]
        while node >= 0:
            state, event, node, link = self._node(node)
            way.append(took(self._batch, self._program.states[state], event))
            joined.append(link)
        yield way[::-1]
        for link in reversed(joined):
            for line, place in self._context.joins.listed(link):
                yield from line.lines(place)

    def _by_values(self, state: int, event: int) -> list[tuple[int, int]]:
        """Return the states and events of the clearest way from an event to where it best ends."""
        value = self._context.backwards(self._program).values[state][event]
        end, cost = int(end_of(value)), int(cost_of(value))
        way: list[tuple[int, int]] = []
        following: tuple[int, int] | None = state, event
        while following:
            way.append(following)
            following = self._following(*following, end, cost)
        return way

    def _following(self, state: int, event: int, end: int, cost: int) -> tuple[int, int] | None:
        """Return the state and event that an event leads to, if it ends so and costs no more."""
        for edge in self._program.edges[state]:
            if id(edge) not in self._ahead:
                self._ahead[id(edge)] = self._context.backwards(self._program).ahead(edge)
            entered, low, high, targets = self._ahead[id(edge)]
            places = np.arange(low[event], high[event])
            places = places if targets is None else targets[places]
            ahead = entered[places]
            fits = (end_of(ahead) == end) & (cost_of(ahead) <= cost)
            if fits.any():
                return edge.entry.state, int(places[fits.argmax()])
        return None

    def _node(self, node: int) -> tuple[int, int, int, int]:
        """Return the state of a node, its event, the node that it comes from, and its link."""
        table = bisect(self._begins, node) - 1
        state, rows = self._tables[table]
        place = node - self._begins[table]
        return (
            state,
            int(rows.columns[EVENT, place]),
            int(rows.parent[place]),
            int(rows.link[place]),
        )


class _Joins(Joins):
    """Which ends of lines joined ways, one after the other."""

    def __init__(self) -> None:
        self._lines: list[_Line] = []
        self._begins = [0]
        self._added: list[tuple[IntArray, IntArray]] = []
        self._firsts = [0]

    def ended(self, line: Walk, many: int) -> IntArray:
        """Return numbers for the ends of a line."""
        assert isinstance(line, _Line)
        begin = self._begins[-1]
        self._lines.append(line)
        self._begins.append(begin + many)
        return np.arange(begin, begin + many)

    def add(self, link: IntArray, end: IntArray) -> IntArray:
        """Return the links of ways that some ends join."""
        first = self._firsts[-1]
        self._added.append((link, end))
        self._firsts.append(first + len(end))
        return np.arange(first, first + len(end))

    def listed(self, link: int) -> list[tuple[_Line, int]]:
        """Return the ends that a link tells of, the first that joined first: lines and places."""
        found: list[tuple[_Line, int]] = []
        while link >= 0:
            table = bisect(self._firsts, link) - 1
            link, end = (int(it[link - self._firsts[table]]) for it in self._added[table])
            place = bisect(self._begins, end) - 1
            found.append((self._lines[place], end - self._begins[place]))
        return found[::-1]


_Best = tuple[tuple[int, int], "_Line | Mirrored", int]
"""What decides between ways to a hit, less being better; the line, and the place of the way."""


class _Partners(Joiner):
    """What stands beside lines: looked for in the hit alone, where it has to lie in that."""

    def forget(self, programs: set[Program]) -> None:
        """Forget the ways of some lines."""
        self._found = {it: found for it, found in self._found.items() if it[0] not in programs}

    def _walk(self, program: Program, enough: str | None) -> Walk:
        assert isinstance(self._context, _Setting)
        return _Line(self._context, program, enough=enough if enough == ONLY else None)


def _lying_in(program: Program) -> set[Program]:
    """Return the lines beside a program that lie in the hit, wherever they are."""
    inside: set[Program] = set()
    outside: set[Program] = set()
    todo = [(program, True)]
    while todo:
        line, within = todo.pop()
        for group in (line.whole, *line.brackets):
            for companion in group.companions:
                adds = RELATIONS[companion.relation].adds_frames
                for inner in companion.programs:
                    lies = within and adds and not inner.open_ended
                    (inside if lies else outside).add(inner)
                    todo.append((inner, lies))
    return inside - outside
