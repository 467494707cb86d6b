"""Walks a line forward, as a table of partial matches with all that each has to remember.

A partial match remembers whatever a pattern needs later: what stands beside brackets, the symbols
that it has claimed, what labels matched, how long each step lasted. Partial matches that stand at
the same event and remember the same are one. Where states lead to each other, events are taken in
order of time, so that all that leads to an event is known before it is left.

Of two partial matches that remember the same the one that ends first is better, as long as the
lines beside it stand beside the shorter one, too; of a line that must not happen the one that ends
last. So where no bracket has a length or lines beside it, and no other line could want a symbol,
the best end is looked up instead.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lanindex.search.limits import check_budget
from lanindex.search.match.arrays import (
    FAR,
    BoolArray,
    IntArray,
    Table,
    grouped,
    in_pieces,
    smallest_from_here,
    spread,
    starts_of,
    together,
)
from lanindex.search.match.backward import (
    Backwards,
    cost_of,
    end_of,
    ending_values,
    may_leave,
    value_of,
)
from lanindex.search.match.conditions import MET
from lanindex.search.match.context import Context
from lanindex.search.match.follow import NONE, begins
from lanindex.search.match.join import CompanionMatches, Hulls, Joiner
from lanindex.search.match.matches import (
    BEYOND,
    EVENT,
    FRAME_BITS,
    GROUPS,
    LATEST,
    LOW,
    NEVER,
    ROOT,
    START,
    Matches,
    Nodes,
    beginning,
    close_group,
    distinct,
    no_claims,
)
from lanindex.search.match.relations import (
    FIRST,
    LAST,
    RELATIONS,
    EndBounds,
    Margins,
    SpanIndex,
    Spans,
    holds,
    margins_of,
)
from lanindex.search.match.rewrites import ONLY
from lanindex.search.plan import Companion, Edge, Exit, Group, Program, components, open_groups

MATCH = 512
"""Bytes of a partial match that is followed, with all that is made of it."""


def _by_root(roots: list[BoolArray], frames: Sequence[IntArray]) -> IntArray:
    """Return numbers of events, by entry (N,) each, for the roots among them, (R,)."""
    return np.concatenate([it[fits] for fits, it in zip(roots, frames, strict=True)])


def best_ends(context: Context, program: Program, enough: str | None) -> list[IntArray] | None:
    """Return by state and event the values of the matches whose ends are `enough`, -1: none.

    None: each match has to be walked, because it must remember something on its way.
    """
    if not enough or context.clauses or program.brackets or program in context.rewrites.contested:
        return None
    alive = context.alive(program)
    for state in {it.state for it in program.entries if program.edges[it.state]}:
        # what goes on from a passing symbol may reach back before it
        if (context.batch.events(program.states[state]).passing & alive[state]).any():
            return None
    if enough == FIRST:
        return _known(context.backwards(program).values)
    last = _known(latest_ends(context, program))
    if enough == LAST:
        return last
    first = _known(context.backwards(program).values)
    alike = (np.array_equal(end_of(one), end_of(it)) for one, it in zip(first, last, strict=True))
    return first if all(alike) else None


def latest_ends(context: Context, program: Program) -> list[IntArray]:
    """Return by state and event the values of the latest ends, or `NONE`."""
    end_values = [_latest_first(it) for it in ending_values(context.batch, program)]
    fits = context.backwards(program).fits
    latest = Backwards(context.batch, program, end_values, fits)
    return [_latest_first(it) for it in latest.values]


def _known(values: list[IntArray]) -> list[IntArray]:
    """Return values with -1 where there is none."""
    return [np.where(it < NONE, it, -1) for it in values]


def _latest_first(values: IntArray) -> IntArray:
    """Return values of which a later end is the smaller one, without costs; or turn them back."""
    return np.where(values < NONE, value_of(LATEST - end_of(values), values * 0), NONE)


class Expiry:
    """Drops the claims of a line that no other line can want any more."""

    def __init__(self, joiner: Joiner, program: Program) -> None:
        self._context, self._joiner, self._program = joiner.context, joiner, program
        context = joiner.context
        self._open = open_groups(program)
        self._earliest: dict[Companion, tuple[IntArray, IntArray]] = {}
        self._ahead: dict[int, IntArray] = {}
        self.known = (
            bool(context.rewrites.contested.get(program) or program.companions)
            and program not in context.rewrites.outside
            and all(map(_ends_later, program.companions))
        )

    def dropped(self, state: int, rows: Matches) -> Matches:
        """Return matches that stand at a state without their expired claims."""
        if not (self.known and rows.claims):
            return rows
        events = self._context.batch.events(self._program.states[state])
        event = rows.columns[EVENT]
        capture, here = events.capture[event], events.start[event]
        since = self._since(self._open[state], rows, capture, here)
        rows.claims = self._context.unexpired(rows.claims, capture, since)
        return rows

    def once_closed(self, state: int, depth: int, rows: Matches) -> IntArray | None:
        """Return since when claims matter once a group closes at a state, (N,); None: always."""
        if not self.known:
            return None
        events = self._context.batch.events(self._program.states[state])
        event = rows.columns[EVENT]
        if state not in self._ahead:
            self._ahead[state] = self._starts_ahead(state)
        here = self._ahead[state][event]
        return self._since(self._open[state][: depth - 1], rows, events.capture[event], here)

    def _starts_ahead(self, state: int) -> IntArray:
        """Return the first frame of all events that may follow each event of a state, (N,)."""
        batch, program = self._context.batch, self._program
        found = np.full(len(batch.events(program.states[state])), FAR - 1)
        for edge in program.edges[state]:
            after = batch.events(program.states[edge.entry.state])
            transitions = self._context.backwards(program).transitions(edge)
            found = np.minimum(found, transitions.smallest(after.start))
        return found

    def _since(
        self, groups: tuple[Group, ...], rows: Matches, capture: IntArray, start: IntArray
    ) -> IntArray:
        """Return from which frame on claims matter to what is beside some open groups, or opens."""
        since, levels = start, [self._program.outermost, *groups]
        for group in (*levels, *self._program.brackets):
            if not group.companions:
                continue
            level = levels.index(group) if group in levels else None
            begun = start if level is None else rows.columns[GROUPS + 3 * level + START]
            for companion in group.companions:
                since = np.minimum(since, self._from(companion, capture, begun))
        return since

    def _from(self, companion: Companion, capture: IntArray, starts: IntArray) -> IntArray:
        """Return the first frame of all lines that can stand beside what began in some frames."""
        if companion not in self._earliest:
            found = [self._joiner.others(it, companion)[0].lines for it in companion.programs]
            owner, until, start = (
                np.concatenate([getattr(it, name) for it in found])
                for name in ("capture", "until", "start")
            )
            order = np.argsort(owner * FAR + until, kind="stable")
            earliest = smallest_from_here(start[order], owner[order])
            keys = (owner * FAR + until)[order]
            self._earliest[companion] = keys, np.append(owner[order] * FAR + earliest, FAR << 20)
        keys, earliest = self._earliest[companion]
        slack = self._context.batch.slack[capture]
        place = np.searchsorted(keys, capture * FAR + starts - slack)
        frames: IntArray = np.minimum(earliest[place] - capture * FAR, FAR - 1)
        return frames


def _ends_later(companion: Companion) -> bool:
    """Return whether a line claims nothing that ends before what it stands beside begins."""
    lone = not any(it.companions for it in companion.programs)
    return RELATIONS[companion.relation].ends_later and not companion.within and lone


@dataclass(slots=True, eq=False)
class Ends(Table):
    """Ends of matches of a line, (N,) each."""

    entry: IntArray  # by which entry of the program it began
    root: IntArray  # at which event of that entry's state
    spans: Spans
    part: IntArray  # of its last symbol
    row: IntArray
    cost: IntArray  # what is missing to a fit of 1, in thousandths; -1: not known
    node: IntArray
    memory: Matches  # the rest


class Walk:
    """Walks a line of a program.

    `timed`: the lengths of its steps have to be in a rhythm; `tracked`: it matters which match goes
    on in which; `enough`: which of its ends is enough, as in `best_ends`; `rooted`: matches
    remember where they began. If they do not, `nodes` tell what each beginning leads to.
    """

    def __init__(
        self,
        joiner: Joiner,
        program: Program,
        *,
        timed: bool = False,
        tracked: bool = False,
        enough: str | None = None,
        rooted: bool = True,
    ) -> None:
        self._context = context = joiner.context
        self.joiner, self._program, self._batch = joiner, program, context.batch
        self._timed, self._rooted, self._tracked = timed, rooted, tracked or not rooted
        self.nodes = Nodes()
        self._open = open_groups(program)
        self._depths = [len(groups) for groups in self._open]
        self._beats = GROUPS + 3 * (1 + max(self._depths))
        self._notes = self._beats + (len(context.clauses.rhythm) if timed else 0)
        self._settled = context.settled(program)
        self._alive = [self._opening(*it) for it in enumerate(context.alive(program))]
        self._runs_on, self.best_ends = enough == ONLY, best_ends(context, program, enough)
        self._expiry = Expiry(joiner, program)
        self._soonest: dict[int, IntArray] = {}  # by state, as `_soonest_ends`

    def _opening(self, state: int, fits: BoolArray) -> BoolArray:
        """Return which events of a state fit beside which the brackets that they open may close."""
        entries = [it.entry for edges in self._program.edges for it in edges]
        opened = [it.opens for it in (*self._program.entries, *entries) if it.state == state]
        events = self._batch.events(self._program.states[state])
        for group in self._program.brackets:
            if group.companions and opened and all(group in it for it in opened):
                some = np.flatnonzero(fits & ~events.starting)
                own = events.at(some)
                bounds = self.joiner.end_bounds(group, own.capture, own.start, own.end)
                fits = fits.copy()
                fits[some] = bounds.rank < NEVER
        return fits

    @property
    def wanders(self) -> bool:
        """Whether the line may go on for long before it ends."""
        return self.best_ends is None and any(
            edge.arrow.later or edge.entry.state <= state
            for state, edges in enumerate(self._program.edges)
            for edge in edges
        )

    def run(
        self,
        roots: list[BoolArray] | None = None,
        horizon: list[IntArray] | None = None,
        bounds: list[EndBounds] | None = None,
    ) -> Ends:
        """Return the ends of all matches of the line.

        They begin where the line can, or by entry at some events, (N,) bool each; lines end by the
        frames `horizon`, by entry (N,) int64 each, and within their `bounds`.
        `OverBudget` if there are more than the budget allows.
        """
        self._followed = 0
        self._cut_off = [np.empty(0, np.int64)]
        self._looked_up: list[Matches] = []
        program, ends = self._program, []
        at: dict[int, list[Matches]] = {state: [] for state in range(len(program.states))}
        roots = roots or self._context.roots(program)
        self._horizon = horizon and _by_root(roots, horizon)
        self._bounds = bounds and EndBounds(
            *(_by_root(roots, it) for it in zip(*bounds, strict=True))
        )
        self._most = None  # the last frame of a hull from each root that can be the best
        if self._bounds and self._horizon is not None and not self._program.open_ended:
            self._most = np.maximum(self._horizon, self._bounds.rank >> FRAME_BITS)
        for number, rows in enumerate(self._beginnings(roots)):
            state = program.entries[number].state
            at[state].append(rows if self.best_ends is None else self._look_up_ends(state, rows))
        for states in components(program):
            circles = len(states) > 1 or any(
                edge.entry.state == states[0] for edge in program.edges[states[0]]
            )
            waves = self._in_time(states, at)
            if not circles:
                waves = ((it, self._merged(it, at.pop(it))) for it in states if at[it])
            ending: defaultdict[Exit, list[Matches]] = defaultdict(list)
            for state, rows in waves:
                self._leave(state, rows, at, ending)
            ends += [(it.state, self._ended(it, tables)) for it, tables in ending.items()]
        if self._looked_up:
            ends.append((-1, self._with_best_ends()))
        none = beginning(np.empty((self._notes + self._context.clauses.width, 0), np.int64))
        return together([self._as_ends(*it) for it in ((0, none), *ends)])

    def as_companions(self) -> tuple[CompanionMatches, Nodes | None]:
        """Return the matches that may stand beside another line, and which goes on in which."""
        context, program, ends = self._context, self._program, self.run()
        memory, notes = ends.memory, ends.memory.columns[self._notes :]
        found = CompanionMatches(
            ends.spans,
            memory.claims if program in context.rewrites.outside else no_claims(len(memory)),
            self.joiner.still_unmet(memory.unmet, memory.claims),
            notes,
            ends.node,
            context.joins.ended(self, len(memory)),
        ).at(context.met_where_known(ends.spans.capture, notes))
        if program.open_ended and self.best_ends is None:
            return found, self.nodes
        return found.at(distinct(found.keys(), len(found))[0]), None

    def _as_ends(self, state: int, rows: Matches) -> Ends:
        """Return matches that end at a state; at state -1 they have values instead of events."""
        root, event = rows.columns[ROOT], rows.columns[EVENT]
        unknown, states = np.full(len(rows), -1), self._program.states
        if state < 0:
            capture, until, end = self._captures(root), end_of(event), end_of(event)
            alone, part, row, cost = np.zeros(len(rows), bool), unknown, unknown, unknown
            if not self._program.outermost.companions:
                cost = cost_of(event)
        else:
            events = self._batch.events(states[state]).at(event)
            capture, end, alone = events.capture, events.end, events.starting
            until, row = np.where(alone, events.until, end), events.last[-1]
            part = np.full(len(rows), self._context.clauses.codes[states[state].members[-1]])
            cost = unknown
        start, low, beyond = rows.columns[GROUPS : GROUPS + 3]
        spans = Spans(capture, start, until, low, np.maximum(beyond, end), alone)
        bounds = np.cumsum([0, *map(len, self.firsts)])
        entry = np.searchsorted(bounds, root, "right") - 1
        first = np.concatenate(self.firsts)[root]
        return Ends(entry, first, spans, part, row, cost, rows.parent, rows)

    def _captures(self, root: IntArray) -> IntArray:
        """Return the captures of some roots."""
        states = (self._program.states[entry.state] for entry in self._program.entries)
        events = (self._batch.events(state) for state in states)
        pairs = zip(events, self.firsts, strict=True)
        return np.concatenate([it.capture[first] for it, first in pairs])[root]

    def _beginnings(self, roots: list[BoolArray]) -> Iterator[Matches]:
        """Yield the matches that begin by each entry."""
        before = 0
        self.firsts: list[IntArray] = []
        for entry, fits in zip(self._program.entries, roots, strict=True):
            state, chosen = entry.state, np.flatnonzero(fits)
            events = self._batch.events(self._program.states[state])
            self.firsts.append(chosen)
            columns = np.full((self._notes + self._context.clauses.width, len(chosen)), -1)
            columns[ROOT] = before + np.arange(len(chosen))
            before += len(chosen)
            for level in range(1 + len(entry.opens)):
                group = GROUPS + 3 * level
                columns[group + START] = columns[group + LOW] = events.start[chosen]
                columns[group + BEYOND] = 0
            rows = beginning(columns)
            if not self._rooted:
                columns[ROOT] = columns[GROUPS + START] = 0
                rows.parent = self.nodes.begin(len(rows))
            yield self._with_events(rows, state, chosen)

    def _with_events(self, rows: Matches, state: int, events: IntArray) -> Matches:
        """Return the matches that can take these events, with the events' claims and notes."""
        context, own_state = self._context, self._program.states[state]
        rows.columns[EVENT] = events
        if state in context.rewrites.contested.get(self._program, ()):
            claims = context.claims(self._program, own_state, events)
            fits = np.flatnonzero(rows.claims.disjoint(claims))
            rows, claims = rows.at(fits), claims.at(fits)
            rows.claims = rows.claims.united_with(claims)
            events = events[fits]
        taken_events = self._batch.events(own_state).at(events)
        notes = context.clauses.noted(self._batch, own_state, events, rows.columns[self._notes :])
        rows.columns[self._notes :] = notes
        if self._timed:
            rows = self._kept_in_time(rows, taken_events.end - taken_events.start)
        settled = self._settled[state]
        if settled.conditions:
            capture = self._batch.events(own_state).capture[rows.columns[EVENT]]
            rows = rows.at(context.met(settled.conditions, capture, rows.columns[self._notes :]))
            for column in settled.columns:
                noted = rows.columns[self._notes + column]
                noted[noted >= 0] = MET
        return self._undisturbed(state, rows)

    def _undisturbed(self, state: int, rows: Matches) -> Matches:
        """Return the matches that share no frame with a forbidden one that nothing excuses.

        The hull of a match only grows: what disturbs it now disturbs all that it leads to.
        """
        for others, margins in self._forbidden:
            events, event = self._batch.events(self._program.states[state]), rows.columns[EVENT]
            low, end = rows.columns[GROUPS + LOW], events.end[event]
            starting = events.starting[event]
            here = Spans(events.capture[event], low, end, low, end, starting)
            disturbed = holds("without", here, others, margins)
            rows = rows.at(starting | ~disturbed)
        return rows

    @cached_property
    def _forbidden(self) -> list[tuple[SpanIndex, Margins]]:
        """The matches of `without` lines beside all of the line that claim nothing."""
        found = []
        for companion in self._program.outermost.companions:
            if companion.relation == "without" and self._context.rewrites.programs(companion):
                others = self.joiner.forbidden(companion)[0]
                free = others.lines.at(others.claims.none & ~others.lines.alone)
                found.append((SpanIndex(free), margins_of(self._batch, companion)))
        return found

    def _kept_in_time(self, rows: Matches, frames: IntArray) -> Matches:
        """Return the matches that may still keep the rhythm, with the length of their last step."""
        beats = rows.columns[self._beats : self._notes]
        place = (beats >= 0).sum(axis=0)
        fits = np.flatnonzero(place < len(beats))
        rows, place = rows.at(fits), place[fits]
        beats = rows.columns[self._beats : self._notes]
        beats[place, np.arange(len(place))] = frames[fits]
        return rows.at(self._context.clauses.may_be_in_rhythm(beats))

    def _in_time(
        self, states: list[int], at: dict[int, list[Matches]]
    ) -> Iterator[tuple[int, Matches]]:
        """Yield the matches that stand at states that lead to each other, in order of time."""
        ranks = self._ranks(states)
        waves: defaultdict[tuple[int, int], list[Matches]] = defaultdict(list)
        now = -1
        while True:
            for state in states:
                for rows in at[state]:
                    ranked = ranks[state][rows.columns[EVENT]]
                    order = np.argsort(ranked, kind="stable")
                    starts = np.flatnonzero(starts_of(ranked[order]))
                    for own in np.split(order, starts[1:]) if len(order) else ():
                        rank = int(ranked[own[0]])
                        assert rank > now, "an arrow that leads back"
                        waves[rank, state].append(rows.at(own))
                at[state] = []
            if not waves:
                return
            now, state = min(waves)
            yield state, self._merged(state, waves.pop((now, state)))

    def _ranks(self, states: list[int]) -> dict[int, IntArray]:
        """Return the order of time of the events of some states in their captures."""
        events = [self._batch.events(self._program.states[state]) for state in states]
        capture = np.concatenate([it.capture for it in events])
        end = np.concatenate([it.end for it in events])
        row = np.concatenate([it.last[0] for it in events])
        ranks, first = grouped((capture, end, row))[1], np.full(len(self._batch), len(row))
        np.minimum.at(first, capture, ranks)
        bounds = np.cumsum([len(it) for it in events])[:-1]
        return dict(zip(states, np.split(ranks - first[capture], bounds), strict=True))

    def _merged(self, state: int, tables: list[Matches]) -> Matches:
        """Return matches, one of those that stand at the same event and remember the same."""
        rows, low = self._arrived(state, tables), None
        if not self._rooted:
            low = rows.columns[GROUPS + LOW].copy()
            rows.columns[GROUPS + LOW] = FAR
        alike, which = rows.deduplicated()
        if self._tracked:
            alike.parent = self.nodes.add(len(alike), rows.parent, which, low)
        return alike

    def _arrived(self, state: int, tables: list[Matches]) -> Matches:
        """Return the matches that stand at a state, without those in refused captures."""
        self._followed += sum(map(len, tables))
        check_budget(self._followed, MATCH)
        refused = self._context.refused
        if refused.any():
            capture = self._batch.events(self._program.states[state]).capture
            tables = [it.at(~refused[capture[it.columns[EVENT]]]) for it in tables]
        return self._expiry.dropped(state, together(tables))

    def _edges(self, state: int) -> tuple[Edge, ...]:
        """Return the edges that are walked from a state."""
        return self._program.edges[state] if self.best_ends is None else ()

    def _leave(
        self,
        state: int,
        rows: Matches,
        at: dict[int, list[Matches]],
        ending: defaultdict[Exit, list[Matches]],
    ) -> None:
        """Send matches over the edges of a state, and collect those that may end there."""
        closed: dict[Exit, Matches] = {}
        for edge in self._edges(state):
            if edge.exit not in closed:
                closed[edge.exit] = self._closed(rows, edge.exit)
            for gone in self._followed_over(edge, closed[edge.exit]):
                at[edge.entry.state].append(gone)
        for leaving in self._program.exits[state]:
            ending[leaving].append(closed.get(leaving, rows))

    def _ended(self, leaving: Exit, tables: list[Matches]) -> Matches:
        """Return the matches that end by an exit; they are closed already if an edge takes it."""
        state, rows = self._program.states[leaving.state], together(tables)
        if self._bounds:
            end = self._batch.events(state).end[rows.columns[EVENT]]
            rows = rows.at(end >= self._bounds.first[rows.columns[ROOT]])
        if all(edge.exit != leaving for edge in self._edges(leaving.state)):
            rows = self._closed(rows, leaving)
        may_end = ~self._batch.events(state).passing | (state.manner == "via")
        return rows.at(may_end[rows.columns[EVENT]])

    def _look_up_ends(self, state: int, rows: Matches) -> Matches:
        """Settle matches by their best ends; return starting positions, which may end alone."""
        assert self.best_ends is not None
        event = rows.columns[EVENT]
        best = self.best_ends[state][event]
        settled = rows.at(best >= 0)
        settled.columns[EVENT] = best[best >= 0]
        self._looked_up.append(settled)
        alone = self._batch.events(self._program.states[state]).starting[event]
        if self._runs_on:
            alone &= best < 0
        return rows.at(alone)

    def _with_best_ends(self) -> Matches:
        """Return the settled matches with what stands beside them, and values for events."""
        rows, program = together(self._looked_up), self._program
        if program.outermost.companions:
            end = end_of(rows.columns[EVENT])
            capture, offset = self._captures(rows.columns[ROOT]), GROUPS + 3
            rows = self._beside(rows, program.outermost, offset, (capture, end, end, end < 0))
            close_group(rows.columns, offset, end_of(rows.columns[EVENT]))
        return rows

    def _closed(self, rows: Matches, leave: Exit) -> Matches:
        """Return the matches that may take an exit, with its groups closed, inner ones first."""
        state = leave.state
        events = self._batch.events(self._program.states[state])
        depth = self._depths[state]
        if leave.to_end:
            fits = may_leave(self._batch, self._program, leave)[rows.columns[EVENT]]
            rows = rows.at(fits)
        for group in leave.closes:
            event = rows.columns[EVENT]
            end, alone, capture = events.end[event], events.starting[event], events.capture[event]
            offset = GROUPS + 3 * depth
            if group.length:
                frames = end - rows.columns[offset + START]
                fits = self._batch.meets(capture, frames, group.length) & ~alone
                rows = rows.at(fits)
                event = rows.columns[EVENT]
                end, alone = events.end[event], events.starting[event]
                capture = events.capture[event]
            if group.companions:
                until = np.where(alone, events.until[event], end)
                since = self._expiry.once_closed(state, depth, rows)
                rows = self._beside(rows, group, offset, (capture, until, end, alone), since)
                end = events.end[rows.columns[EVENT]]
            else:
                rows = rows.at(np.arange(len(rows)))
            close_group(rows.columns, offset, end)
            depth -= 1
        return rows

    def _beside(
        self,
        rows: Matches,
        group: Group,
        offset: int,
        frames: tuple[IntArray, IntArray, IntArray, BoolArray],
        since: IntArray | None = None,
    ) -> Matches:
        """Return matches with what stands beside a group that closes in some frames.

        These are the capture, the frame up to which other lines are compared, the end, and whether
        it is a starting position alone.
        """
        capture, until, end, alone = frames
        start, low = rows.columns[offset + START], rows.columns[offset + LOW]
        high = np.maximum(rows.columns[offset + BEYOND], end)
        lines = Spans(capture, start, until, low, high, alone)
        notes = rows.columns[self._notes :]
        memory = rows.claims, rows.unmet, notes, rows.link
        hulls = Hulls(np.arange(len(rows)), lines.low, lines.high, *memory)
        outermost = group is self._program.outermost
        most = self._most[rows.columns[ROOT]] if outermost and self._most is not None else None
        hulls = self.joiner.close(group, lines, hulls, outermost=outermost, since=since, most=most)
        rows = rows.at(hulls.line)
        rows.columns[self._notes :] = hulls.notes
        rows.columns[offset + LOW], rows.columns[offset + BEYOND] = hulls.low, hulls.high
        rows.claims, rows.unmet, rows.link = hulls.claims, hulls.unmet, hulls.link
        return rows

    def _followed_over(self, edge: Edge, rows: Matches) -> Iterator[Matches]:
        """Yield the matches that an edge leads on, some at a time."""
        if not len(rows):
            return
        state = edge.entry.state
        events, alive = self._batch.events(self._program.states[state]), self._alive[state]
        for arrow in edge.entry.from_start:
            alive = alive & begins(self._batch, self._program.states[state], events, arrow)
        for sources, targets in self._targets(edge, rows):
            here = np.flatnonzero(alive[targets])
            answered = self._context.count_tried(events.capture[targets[here]])
            if answered is not None:
                here = here[answered]
            if len(here):
                yield self._advanced(edge, rows.at(sources[here]), targets[here])

    def _advanced(self, edge: Edge, rows: Matches, targets: IntArray) -> Matches:
        """Return matches with the events that an edge leads to."""
        state = edge.entry.state
        events = self._batch.events(self._program.states[state])
        start, end = events.start[targets], events.end[targets]
        opened = self._depths[state] - len(edge.entry.opens)
        for level in range(1 + self._depths[state]):
            low, beyond = (rows.columns[GROUPS + 3 * level + it] for it in (LOW, BEYOND))
            if level > opened:
                rows.columns[GROUPS + 3 * level + START] = low[:] = start
                beyond[:] = 0
            else:
                np.minimum(low, start, out=low)
                beyond[beyond <= end] = 0
        return self._with_events(rows, state, targets)

    def _targets(self, edge: Edge, rows: Matches) -> Iterator[tuple[IntArray, IntArray]]:
        """Yield pairs of a match and an event to which an edge leads from it in time."""
        state = self._program.states[edge.entry.state]
        events, event = self._batch.events(state), rows.columns[EVENT]
        reach = self._context.backwards(self._program).transitions(edge)
        low, high = reach.low[event], reach.high[event]
        limits = self._latest(edge, rows)
        if limits:
            soonest, (latest, horizon) = self._soonest_ends(edge.entry.state), limits
            beyond = np.minimum(high, np.searchsorted(soonest, latest, "right"))
            soon = np.searchsorted(soonest, np.minimum(latest, horizon), "right")
            high = np.minimum(high, soon)
            self._cut_off.append(rows.parent[high < beyond])
        before = self._batch.events(self._program.states[edge.exit.state])
        refused, capture = self._context.refused, before.capture[event]
        ranges = [(low, high, None)]
        if len(reach.outliers[1]):
            ranges.append((reach.bounds[event], reach.bounds[event + 1], reach.outliers[1]))
        for low, high, listed in ranges:
            for some in in_pieces(np.maximum(high - low, 0)):
                if refused.any():
                    some = some[~refused[capture[some]]]
                sources, places = spread(low[some], high[some])
                sources = some[sources]
                places = places if listed is None else listed[places]
                if limits:
                    ends = events.capture[places] * FAR + events.end[places]
                    fits, nearby = ends <= latest[sources], ends <= horizon[sources]
                    self._cut_off.append(rows.parent[sources[fits & ~nearby]])
                    sources, places = sources[fits & nearby], places[fits & nearby]
                if self._bounds:
                    first = self._bounds.first[rows.columns[ROOT][sources]]
                    fits = self._latest_ends[edge.entry.state][places] >= first
                    sources, places = sources[fits], places[fits]
                yield sources, places

    @cached_property
    def _latest_ends(self) -> list[IntArray]:
        """The latest frame in which the line may end from each event, by state, (N,) each."""
        return [end_of(it) for it in latest_ends(self._context, self._program)]

    def _soonest_ends(self, state: int) -> IntArray:
        """Return capture and first end of each event of a state and all behind it as one number."""
        if state not in self._soonest:
            events = self._batch.events(self._program.states[state])
            ends = events.capture * FAR + events.end
            self._soonest[state] = np.minimum.accumulate(ends[::-1])[::-1]
        return self._soonest[state]

    def is_cut_off(self, nodes: IntArray) -> BoolArray:
        """Return which nodes may go on beyond the horizon."""
        return self.nodes.leading_to(np.concatenate(self._cut_off))[nodes]

    def _latest(self, edge: Edge, rows: Matches) -> tuple[IntArray, IntArray] | None:
        """Return by when what follows matches has to end, and the horizon of the search.

        Both are (N,) and hold the capture and the frame as one number. None: any time will do.
        """
        groups = self._open[edge.exit.state]
        groups = groups[: len(groups) - len(edge.exit.closes)]
        limited = self._bounds or self._horizon is not None
        if not limited and not any(group.length for group in groups):
            return None
        before = self._batch.events(self._program.states[edge.exit.state])
        capture = before.capture[rows.columns[EVENT]]
        frames = self._batch.frames[capture]
        if self._bounds:
            frames = np.minimum(frames, self._bounds.last[rows.columns[ROOT]])
        horizon = frames
        if self._horizon is not None:
            horizon = self._horizon[rows.columns[ROOT]]
        for level, group in enumerate(groups, 1):
            if group.length:
                begun = rows.columns[GROUPS + 3 * level + START]
                frames = np.minimum(frames, begun + self._batch.bounds(group.length)[1][capture])
        return capture * FAR + np.maximum(frames, 0), capture * FAR + horizon


def companions(
    joiner: Joiner, program: Program, enough: str | None
) -> tuple[CompanionMatches, Nodes | None]:
    """Return the matches of a line that may stand beside another, and which goes on in which."""
    return Walk(joiner, program, tracked=program.open_ended, enough=enough).as_companions()
