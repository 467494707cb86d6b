"""A line walked with all that it has to remember: every way in which it can match.

It remembers whatever a pattern asks for: what stands beside brackets, what each line claimed
however often it repeats, what labels matched, how long each step lasted. Matches that stand at the
same event and remember the same are one. Where states lead to each other their events are gone
through in order of time, so that all that leads to an event is known before it is left.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from lanindex.search.automaton import Companion, Edge, Exit, Group, Program
from lanindex.search.match import budget
from lanindex.search.match.arrays import (
    FAR,
    AnyArray,
    BoolArray,
    IntArray,
    best_of_each,
    in_pieces,
    smallest_from_here,
    spread,
    starts_of,
)
from lanindex.search.match.backward import components, cost_of, end_of, may_leave
from lanindex.search.match.batch import Batch
from lanindex.search.match.best import ONLY, BestEnds
from lanindex.search.match.conditions import MET
from lanindex.search.match.context import MANNERS, Context, Hulls, Settled, open_groups
from lanindex.search.match.follow import Transitions, begins, way_of
from lanindex.search.match.hit_table import roots
from lanindex.search.match.matches import (
    BEYOND,
    EVENT,
    GROUPS,
    LOW,
    ROOT,
    START,
    Claims,
    Matches,
    Nodes,
    beginning,
    carry_out,
    in_sets,
    telling,
    together,
)
from lanindex.search.match.relations import LAST, RELATIONS, Spans


def ranks_of(batch: Batch, program: Program, states: list[int]) -> dict[int, IntArray]:
    """Return the order of time of the events of some states in their captures."""
    events = [batch.events(program.states[state]) for state in states]
    capture, end = (
        np.concatenate([getattr(it, name) for it in events]) for name in ("capture", "end")
    )
    row = np.concatenate([it.last[0] for it in events])
    order = np.lexsort((row, end, capture))
    new = starts_of(capture[order]) | starts_of(end[order]) | starts_of(row[order])
    dense = np.cumsum(new)
    first = np.searchsorted(capture[order], capture[order])
    ranks = np.empty(len(order), np.int64)
    ranks[order] = dense - dense[first] if len(order) else dense
    bounds = np.cumsum([0, *(len(it) for it in events)])
    return {state: ranks[bounds[place] : bounds[place + 1]] for place, state in enumerate(states)}


def by_rank(ranks: IntArray, rows: Matches) -> Iterator[tuple[int, Matches]]:
    """Yield ways by their ranks, those of the same rank together."""
    order = np.argsort(ranks, kind="stable")
    starts = np.flatnonzero(starts_of(ranks[order]))
    for own in np.split(order, starts[1:]) if len(order) else ():
        yield int(ranks[own[0]]), rows.at(own)


class Expiry:
    """Tells which claims of a line are still wanted.

    Parameters
    ----------
    context : Context
        Where.
    program : Program
        The line.
    """

    def __init__(self, context: Context, program: Program) -> None:
        self._context, self._program = context, program
        self._open = open_groups(program)
        groups = (program.whole, *program.brackets)
        self._companions = [it for group in groups for it in group.companions]
        self._earliest: dict[Companion, tuple[IntArray, IntArray]] = {}
        self.known = (
            bool(context.contested.get(program) or self._companions)
            and program not in context.outside
            and all(map(_ends_later, self._companions))
        )

    def dropped(self, state: int, rows: Matches) -> Matches:
        """Return ways that stand at a state, without the claims that nothing can want any more."""
        if not (self.known and rows.claims):
            return rows
        events = self._context.batch.events(self._program.states[state])
        event = rows.columns[EVENT]
        capture, here = events.capture[event], events.start[event]
        since = here
        for group in (self._program.whole, *self._open[state], *self._program.brackets):
            if not group.companions:
                continue
            levels = [self._program.whole, *self._open[state]]
            level = levels.index(group) if group in levels else None
            begun = here if level is None else rows.columns[GROUPS + 3 * level + START]
            for companion in group.companions:
                since = np.minimum(since, self._from(companion, capture, begun))
        rows.claims = self._after(rows.claims, capture, since)
        return rows

    def _from(self, companion: Companion, capture: IntArray, begun: IntArray) -> IntArray:
        """Return the first frame of all lines that can stand beside what has begun then."""
        if companion not in self._earliest:
            found = [self._context.joiner.others(it, companion).lines for it in companion.programs]
            owner, until, start = (
                np.concatenate([getattr(it, name) for it in found])
                for name in ("capture", "until", "start")
            )
            order = np.argsort(owner * FAR + until, kind="stable")
            earliest = smallest_from_here(start[order], owner[order])
            keys = (owner * FAR + until)[order]
            self._earliest[companion] = keys, np.append(owner[order] * FAR + earliest, FAR << 20)
        keys, earliest = self._earliest[companion]
        slack = self._context.slack[capture]
        place = np.searchsorted(keys, capture * FAR + begun - slack)
        frames: IntArray = np.minimum(earliest[place] - capture * FAR, FAR - 1)
        return frames

    def _after(self, had: Claims, capture: IntArray, since: IntArray) -> Claims:
        """Return the claims of movements, stays and rests that do not end before a frame."""
        first = had.first.copy()
        for part, rows in self._context.claimed():
            for manner in MANNERS:
                lane = self._context.lane(manner, part)
                shown = rows.shown
                ends = rows.stop[shown] if manner == "move" else rows.until(shown)
                keys = rows.capture[shown].astype(np.int64) * FAR + ends
                begin = lane + np.searchsorted(keys, capture * FAR + since)
                own = (first >= lane) & (first <= lane + len(rows))
                first = np.where(own, np.maximum(first, begin), first)
        return in_sets(first, had.last)


def _ends_later(companion: Companion) -> bool:
    """Tell whether a line takes nothing that ends before what it stands beside begins."""
    lone = not any(
        group.companions for it in companion.programs for group in (it.whole, *it.brackets)
    )
    return RELATIONS[companion.relation].ends_later and not companion.within and lone


WAY = 512
"""Bytes of a way that is followed, with all that is made of it."""


@dataclass(slots=True, eq=False)
class Ends:
    """Ends of ways through a line.

    Attributes
    ----------
    entry, root : ndarray
        (N,) by which entry it began, and at which event.
    capture, start, until, low, high : ndarray
        (N,) int64 frames, those of all beside it in `low` and `high`.
    alone : ndarray
        (N,) bool: whether it is no more than a starting position.
    part, row : ndarray
        (N,) int64: its last symbol.
    cost : ndarray
        (N,) int64: what is missing to a fit of 1, in thousandths; -1: that is not known.
    node : ndarray
        (N,) int64.
    memory : Matches
        The rest.
    """

    entry: IntArray
    root: IntArray
    capture: IntArray
    start: IntArray
    until: IntArray
    low: IntArray
    high: IntArray
    alone: BoolArray
    part: IntArray
    row: IntArray
    cost: IntArray
    node: IntArray
    memory: Matches

    def at(self, chosen: AnyArray) -> Ends:
        """Return some of them."""
        columns = {name: getattr(self, name)[chosen] for name in _ENDS}
        return replace(self, **columns, memory=self.memory.at(chosen))


_ENDS = (
    "entry",
    "root",
    "capture",
    "start",
    "until",
    "low",
    "high",
    "alone",
    "part",
    "row",
    "cost",
    "node",
)


def ends_of(
    context: Context, program: Program, firsts: list[IntArray], ends: list[tuple[int, Matches]]
) -> Ends:
    """Return ends as one table.

    Parameters
    ----------
    context : Context
        Where.
    program : Program
        Of the line.
    firsts : list of ndarray
        By entry, at which events ways began.
    ends : list of tuple of int and Matches
        States, and the ways that end there; of state -1 only their values are known, as from
        `value_of`: instead of events.
    """
    memory = together([rows for _, rows in ends])
    many = [len(rows) for _, rows in ends]
    state = np.repeat([number for number, _ in ends], many)
    columns, cost = np.full((4, len(memory)), -1), np.full(len(memory), -1)
    alone = np.zeros(len(memory), bool)
    settled = memory.columns[EVENT][state < 0]
    columns[:2, state < 0] = end_of(settled)
    if not program.whole.companions:
        cost[state < 0] = cost_of(settled)
    for number in set(state[state >= 0].tolist()):
        own = np.flatnonzero(state == number)
        told = program.states[number]
        events = context.batch.events(told).at(memory.columns[EVENT][own])
        until = np.where(events.starting, events.until, events.end)
        part = np.full(len(own), context.clauses.code(told.members[-1]))
        columns[:, own] = until, events.end, part, events.last[-1]
        alone[own] = events.starting
    until, end, part, row = columns
    high = np.maximum(memory.columns[GROUPS + BEYOND], end)
    bounds = np.cumsum([0, *map(len, firsts)])
    entry = np.searchsorted(bounds, memory.columns[ROOT], "right") - 1
    first = np.concatenate(firsts)[memory.columns[ROOT]]
    capture = captures_of(context, program, firsts)[memory.columns[ROOT]]
    start, low = memory.columns[GROUPS + START], memory.columns[GROUPS + LOW]
    frames = (capture, start, until, low, high)
    return Ends(entry, first, *frames, alone, part, row, cost, memory.parent, memory)


def captures_of(context: Context, program: Program, firsts: list[IntArray]) -> IntArray:
    """Return the captures of ways that began by some entries at some events."""
    states = (program.states[entry.state] for entry in program.entries)
    events = (context.batch.events(state) for state in states)
    return np.concatenate([it.capture[first] for it, first in zip(events, firsts, strict=True)])


class Walk:
    """Walks a program in a batch.

    Parameters
    ----------
    context : Context
        Where, and what is asked.
    program : Program
        Any.
    timed : bool
        Whether the frames of its steps have to be in a rhythm.
    tracked : bool
        Whether it matters which way goes on in which.
    enough : str, optional
        Which of its ends will do, as in `best`.
    """

    def __init__(
        self,
        context: Context,
        program: Program,
        *,
        timed: bool = False,
        tracked: bool = False,
        enough: str | None = None,
    ) -> None:
        self._context, self._program, self._batch = context, program, context.batch
        self._timed, self._tracked, self.nodes = timed, tracked, Nodes()
        self._open = open_groups(program)
        self._depths = [len(groups) for groups in self._open]
        self._beats = GROUPS + 3 * (1 + max(self._depths))
        self._seen = self._beats + (len(context.clauses.rhythm) if timed else 0)
        self._due = context.due(program)
        self._alive = context.alive(program)
        self._enough, self._best_ends = enough, None
        if enough and not context.clauses:
            self._best_ends = BestEnds(context, program, enough)
        self._expiry = Expiry(context, program)
        self._reaches: dict[int, tuple[Transitions, IntArray | None]] = {}

    @property
    def wanders(self) -> bool:
        """Whether the line may go on for long before it ends."""
        settled = self._best_ends.settled if self._best_ends else [False] * len(self._open)
        return any(
            edge.arrow.later or edge.entry.state <= state
            for state, edges in enumerate(self._program.edges)
            for edge in (() if settled[state] else edges)
        )

    def roots(self) -> list[BoolArray]:
        """Return, by entry, at which events of its state the line may begin."""
        return [
            roots(self._batch, self._program, it) & self._alive[it.state]
            for it in self._program.entries
        ]

    def found(self, begun: list[BoolArray] | None = None, within: IntArray | None = None) -> Ends:
        """Return all ways in which the line can match.

        Parameters
        ----------
        begun : list of ndarray, optional
            By entry, at which events of its state, (N,) bool; None: wherever it can.
        within : ndarray, optional
            (captures,) int64: in how many frames after its beginning each way must have ended.

        Raises
        ------
        TooMuch
            Where there are too many.
        """
        self._followed, self._within = 0, within
        self._cut_off = [np.empty(0, np.int64)]
        self._settling: list[Matches] = []
        program, ends = self._program, []
        at: dict[int, list[Matches]] = {state: [] for state in range(len(program.states))}
        for number, rows in enumerate(self._begun(begun or self.roots())):
            at[program.entries[number].state].append(rows)
        for states in components(program):
            circles = len(states) > 1 or any(
                edge.entry.state == states[0] for edge in program.edges[states[0]]
            )
            waves = self._in_time(states, at) if circles else self._at_once(states[0], at)
            for state, rows in waves:
                self._context.tick()
                ends += self._leave(state, rows, at)
        none = np.empty((self._seen + len(self._context.clauses.columns), 0), np.int64)
        ends = [(0, beginning(none)), *ends]
        if self._settling:
            ends.append((-1, self._with_best_ends()))
        found = ends_of(self._context, program, self._firsts, ends)
        if not self._best_ends or not all(
            self._best_ends.settled[it.state] for it in program.entries
        ):
            found.cost[:] = -1  # of ways that settle later their first steps are not counted
        return found

    def _begun(self, begun: list[BoolArray]) -> Iterator[Matches]:
        """Yield the ways that begin by each entry."""
        before = 0
        self._firsts: list[IntArray] = []
        for entry, fits in zip(self._program.entries, begun, strict=True):
            state, chosen = entry.state, np.flatnonzero(fits)
            events = self._batch.events(self._program.states[state])
            if self._within is not None:
                start, end = events.start[chosen], events.end[chosen]
                chosen = chosen[end - start <= self._within[events.capture[chosen]]]
            self._firsts.append(chosen)
            columns = np.full((self._seen + len(self._context.clauses.columns), len(chosen)), -1)
            columns[ROOT] = before + np.arange(len(chosen))
            before += len(chosen)
            for level in range(1 + len(entry.opens)):
                group = GROUPS + 3 * level
                columns[group + START] = columns[group + LOW] = events.start[chosen]
                columns[group + BEYOND] = 0
            yield self._matched(beginning(columns), state, chosen, self._due.at(None, state))

    def _matched(self, rows: Matches, state: int, events: IntArray, due: Settled) -> Matches:
        """Return ways with the events that they match next, those that are possible."""
        context, told = self._context, self._program.states[state]
        rows.columns[EVENT] = events
        if state in context.contested.get(self._program, ()):
            claims = context.claims(self._program, told, events)
            fits = np.flatnonzero(rows.claims.apart(claims))
            rows, claims = rows.at(fits), claims.at(fits)
            rows.claims = rows.claims.with_those(claims)
            events = events[fits]
        own = self._batch.events(told).at(events)
        seen = context.clauses.noted(self._batch, told, events, rows.columns[self._seen :])
        rows.columns[self._seen :] = seen
        if self._timed:
            rows, own = self._kept_in_time(rows, own.end - own.start), own
        if due.conditions:
            capture = self._batch.events(told).capture[rows.columns[EVENT]]
            rows = rows.at(context.met(due.conditions, capture, rows.columns[self._seen :]))
        for column in due.columns:
            noted = rows.columns[self._seen + column]
            noted[noted >= 0] = MET
        return rows

    def _kept_in_time(self, rows: Matches, frames: IntArray) -> Matches:
        """Return the ways that a rhythm may still be kept by, with how long a step has lasted."""
        beats = rows.columns[self._beats : self._seen]
        place = (beats >= 0).sum(axis=0)
        fits = np.flatnonzero(place < len(beats))
        rows, place = rows.at(fits), place[fits]
        beats = rows.columns[self._beats : self._seen]
        beats[place, np.arange(len(place))] = frames[fits]
        return rows.at(np.flatnonzero(self._context.clauses.may_be_in_rhythm(beats)))

    def _at_once(self, state: int, at: dict[int, list[Matches]]) -> Iterator[tuple[int, Matches]]:
        """Yield the ways that stand at a state that does not lead to itself."""
        if at[state]:
            yield state, self._settled(state, at.pop(state))

    def _in_time(
        self, states: list[int], at: dict[int, list[Matches]]
    ) -> Iterator[tuple[int, Matches]]:
        """Yield the ways that stand at states that lead to each other, in order of time."""
        ranks = ranks_of(self._batch, self._program, states)
        waves: dict[int, dict[int, list[Matches]]] = {}
        now = -1
        while True:
            for state in states:
                for rows in at[state]:
                    for rank, some in by_rank(ranks[state][rows.columns[EVENT]], rows):
                        assert rank > now, "an arrow that leads back"
                        waves.setdefault(rank, {}).setdefault(state, []).append(some)
                at[state] = []
            if not waves:
                return
            now = min(waves)
            yield from ((it, self._settled(it, tables)) for it, tables in waves.pop(now).items())

    def _settled(self, state: int, tables: list[Matches]) -> Matches:
        """Return ways, those as one that stand at the same event and remember the same."""
        rows = self._standing(state, tables)
        alike, which = rows.alike()
        if self._tracked:
            alike.parent = self.nodes.add(len(alike), rows.parent, which)
        return alike

    def _standing(self, state: int, tables: list[Matches]) -> Matches:
        """Return the ways that stand at a state, but for those of captures that are refused."""
        self._followed += sum(map(len, tables))
        if self._followed > budget.rows(WAY):
            raise budget.TooMuch
        rows = together(tables)
        events = self._batch.events(self._program.states[state])
        answered = self._context.tried(events.capture[rows.columns[EVENT]])
        if answered is not None:
            rows = rows.at(np.flatnonzero(answered))
        return self._expiry.dropped(state, rows)

    def _leave(
        self, state: int, rows: Matches, at: dict[int, list[Matches]]
    ) -> list[tuple[int, Matches]]:
        """Let ways go on from a state, and return those that end there."""
        left: dict[tuple[object, ...], Matches] = {}
        ending = rows
        if self._best_ends and self._best_ends.free[state]:
            ending, rows = self._settled_best(state, rows)

        def leaving(way: Exit, rows: Matches) -> Matches:
            key = (way.closes, way.to_end, id(rows))
            if key not in left:
                fits = may_leave(self._batch, self._program, way)[rows.columns[EVENT]]
                left[key] = self._closed(rows.at(np.flatnonzero(fits)), state, way.closes)
            return left[key]

        for edge in self._program.edges[state]:
            for gone in self._over(edge, leaving(edge.exit, rows)):
                at[edge.entry.state].append(gone)
                self._context.tick()
        ends = []
        told = self._program.states[state]
        passing = self._batch.events(told).passing
        for way in self._program.exits[state]:
            ended = leaving(way, ending)
            if told.manner != "via":
                ended = ended.at(np.flatnonzero(~passing[ended.columns[EVENT]]))
            late = self._due.late(state)
            if late:
                capture = self._batch.events(told).capture[ended.columns[EVENT]]
                fits = self._context.met(late, capture, ended.columns[self._seen :])
                ended = ended.at(fits)
            ends.append((state, ended))
        return ends

    def _settled_best(self, state: int, rows: Matches) -> tuple[Matches, Matches]:
        """Let ways end as they best do, and return those that still end here, or go on.

        These are starting positions alone, and what leads to something that others could want.
        """
        assert self._best_ends
        event = rows.columns[EVENT]
        best = self._best_ends.best[state][event]
        settled = rows.at(np.flatnonzero(best >= 0))
        settled.columns[EVENT] = best[best >= 0]
        self._settling.append(settled)
        ending, on = self._best_ends.ending[state][event], self._best_ends.on[state][event]
        return rows.at(np.flatnonzero(ending)), rows.at(np.flatnonzero(on))

    def _with_best_ends(self) -> Matches:
        """Return the ways that are settled with what stands beside them, and ends for events."""
        rows, program = together(self._settling), self._program
        root, end = rows.columns[ROOT], end_of(rows.columns[EVENT])
        if (root[1:] <= root[:-1]).any():
            keys = [*rows.columns[EVENT + 1 :], *rows.rest()]
            if self._enough == ONLY:
                keys.append(end)
            rank = -end if self._enough == LAST else rows.columns[EVENT]
            rows = rows.at(best_of_each((root, *telling(keys)), (rank,)))
        if not program.whole.companions:
            return rows
        end = end_of(rows.columns[EVENT])
        capture = captures_of(self._context, program, self._firsts)[rows.columns[ROOT]]
        own = GROUPS + 3
        rows = self._beside(rows, program.whole, own, (capture, end, end, end < 0))
        carry_out(rows.columns, own, end_of(rows.columns[EVENT]))
        return rows

    def _closed(self, rows: Matches, state: int, closes: tuple[Group, ...]) -> Matches:
        """Return ways with some groups closed, inner ones first."""
        events = self._batch.events(self._program.states[state])
        depth = self._depths[state]
        for group in closes:
            event = rows.columns[EVENT]
            end, alone, capture = events.end[event], events.starting[event], events.capture[event]
            own = GROUPS + 3 * depth
            if group.length:
                frames = end - rows.columns[own + START]
                fits = self._batch.meets(capture, frames, group.length) & ~alone
                rows = rows.at(np.flatnonzero(fits))
                event = rows.columns[EVENT]
                end, alone = events.end[event], events.starting[event]
                capture = events.capture[event]
            if group.companions:
                until = np.where(alone, events.until[event], end)
                rows = self._beside(rows, group, own, (capture, until, end, alone))
                end = events.end[rows.columns[EVENT]]
            else:
                rows = rows.at(np.arange(len(rows)))
            carry_out(rows.columns, own, end)
            depth -= 1
        return rows

    def _beside(
        self,
        rows: Matches,
        group: Group,
        own: int,
        frames: tuple[IntArray, IntArray, IntArray, BoolArray],
    ) -> Matches:
        """Return ways with what stands beside a group that closes in some frames.

        These are capture, how far others are compared, the end, and whether it merely starts.
        """
        capture, until, end, alone = frames
        start, low = rows.columns[own + START], rows.columns[own + LOW]
        high = np.maximum(rows.columns[own + BEYOND], end)
        lines = Spans(capture, start, until, low, high, alone)
        seen = rows.columns[self._seen :]
        memory = rows.claims, rows.unmet, seen, rows.link
        hulls = Hulls(np.arange(len(rows)), lines.low, lines.high, *memory)
        whole = group is self._program.whole
        hulls = self._context.joiner.close(group, lines, hulls, whole=whole)
        rows = rows.at(hulls.line)
        rows.columns[self._seen :] = hulls.seen
        rows.columns[own + LOW], rows.columns[own + BEYOND] = hulls.low, hulls.high
        rows.claims, rows.unmet, rows.link = hulls.claims, hulls.unmet, hulls.link
        return rows

    def _over(self, edge: Edge, rows: Matches) -> Iterator[Matches]:
        """Yield the ways that go on over an edge, some at a time."""
        state = edge.entry.state
        events = self._batch.events(self._program.states[state])
        fits = self._alive[state].copy()
        if self._best_ends and self._best_ends.free[edge.exit.state]:
            fits &= self._best_ends.entered[state]
        for arrow in edge.entry.from_start:
            fits &= begins(self._batch, self._program.states[state], events, arrow)
        for sources, targets in self._led(edge, rows):
            here = fits[targets]
            if here.any():
                yield self._gone(edge, rows.at(sources[here]), targets[here])

    def _gone(self, edge: Edge, gone: Matches, targets: IntArray) -> Matches:
        """Return ways with the events that an edge leads to."""
        state = edge.entry.state
        events = self._batch.events(self._program.states[state])
        start, end = events.start[targets], events.end[targets]
        opened = self._depths[state] - len(edge.entry.opens)
        for level in range(1 + self._depths[state]):
            low, beyond = (gone.columns[GROUPS + 3 * level + it] for it in (LOW, BEYOND))
            if level > opened:
                gone.columns[GROUPS + 3 * level + START] = low[:] = start
                beyond[:] = 0
            else:
                np.minimum(low, start, out=low)
                beyond[beyond <= end] = 0
        return self._matched(gone, state, targets, self._due.at(edge.exit.state, state))

    def _led(self, edge: Edge, rows: Matches) -> Iterator[tuple[IntArray, IntArray]]:
        """Yield pairs of a way and an event to which an edge leads from it, if that is in time."""
        state = self._program.states[edge.entry.state]
        events, event = self._batch.events(state), rows.columns[EVENT]
        if id(edge) not in self._reaches:
            before = self._batch.events(self._program.states[edge.exit.state])
            reach = Transitions(self._batch, way_of(self._program.states, edge), before)
            ends = events.capture * FAR + events.end
            self._reaches[id(edge)] = reach, ends if (np.diff(ends) >= 0).all() else None
        reach, in_order = self._reaches[id(edge)]
        low, high, targets = reach.listed()
        low, high = low[event], high[event]
        latest, horizon = self._latest(edge, rows)
        if targets is None and in_order is not None:
            beyond = np.minimum(high, np.searchsorted(in_order, latest, "right"))
            high = np.minimum(high, np.searchsorted(in_order, np.minimum(latest, horizon), "right"))
            self._cut_off.append(rows.parent[high < beyond])
        for some in in_pieces(np.maximum(high - low, 0)):
            sources, places = spread(low[some], high[some])
            sources = some[sources]
            if targets is not None:
                places = targets[places]
            ends = events.capture[places] * FAR + events.end[places]
            fits = ends <= latest[sources]
            soon = ends <= horizon[sources]
            self._cut_off.append(rows.parent[sources[fits & ~soon]])
            fits &= soon
            yield sources[fits], places[fits]

    def is_cut_off(self, nodes: IntArray) -> BoolArray:
        """Return which nodes may go on beyond the frames in which ways were looked for."""
        return self.nodes.leading_to(np.concatenate(self._cut_off))[nodes]

    def _latest(self, edge: Edge, rows: Matches) -> tuple[IntArray, IntArray]:
        """Return when what follows ways has to be over, and until when ways are looked for.

        Both with the capture, as one number.
        """
        before = self._batch.events(self._program.states[edge.exit.state])
        capture = before.capture[rows.columns[EVENT]]
        frames = self._batch.frames[capture]
        horizon = frames
        if self._within is not None:
            horizon = np.maximum(rows.columns[GROUPS + START] + self._within[capture], 0)
        groups = self._open[edge.exit.state]
        for level, group in enumerate(groups[: len(groups) - len(edge.exit.closes)], 1):
            if group.length:
                begun = rows.columns[GROUPS + 3 * level + START]
                frames = np.minimum(frames, begun + self._batch.bounds(group.length)[1][capture])
        return capture * FAR + np.maximum(frames, 0), capture * FAR + horizon
