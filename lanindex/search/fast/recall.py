"""A line walked with all that it has to remember: every way in which it can match.

It remembers whatever a pattern asks for: what stands beside brackets, what each line took however
often it repeats, what labels matched, how long each step lasted. Ways that stand at the same event
and remember the same are one. Where states lead to each other their events are gone through in
order of time, so that all that leads to an event is known before it is left.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lanindex.search.automaton import Edge, Exit, Group, Program
from lanindex.search.fast import budget
from lanindex.search.fast.answers import roots
from lanindex.search.fast.arrows import Reach, begins, way_of
from lanindex.search.fast.asked import MET
from lanindex.search.fast.beside import Stretches
from lanindex.search.fast.ends import Found, captures_of, ends_of
from lanindex.search.fast.expiry import Expiry
from lanindex.search.fast.lines import components, end_of, may_leave
from lanindex.search.fast.memory import (
    BEYOND,
    EVENT,
    GROUPS,
    LOW,
    ROOT,
    START,
    Memory,
    Nodes,
    beginning,
    carry_out,
    telling,
    together,
)
from lanindex.search.fast.ragged import FAR, Mask, Whole, best_of_each, spread
from lanindex.search.fast.setting import Hulls, Setting, Settled, open_groups
from lanindex.search.fast.tails import LAST, ONLY, Tails
from lanindex.search.fast.waves import by_rank, ranks_of

WAY = 512
"""Bytes of a way that is followed, with all that is made of it."""


class Recall:
    """Walks a program in a block.

    Parameters
    ----------
    setting : Setting
        Where, and what is asked.
    program : Program
        Any.
    timed : bool
        Whether the frames of its steps have to be in a rhythm.
    tracked : bool
        Whether it matters which way goes on in which.
    enough : str, optional
        Which of its ends will do, as in `tails`.
    """

    def __init__(
        self,
        setting: Setting,
        program: Program,
        *,
        timed: bool = False,
        tracked: bool = False,
        enough: str | None = None,
    ) -> None:
        self._setting, self._program, self._block = setting, program, setting.block
        self._timed, self._tracked, self.nodes = timed, tracked, Nodes()
        self._open = open_groups(program)
        self._depths = [len(groups) for groups in self._open]
        self._beats = GROUPS + 3 * (1 + max(self._depths))
        self._seen = self._beats + (len(setting.asked.rhythm) if timed else 0)
        self._due = setting.due(program)
        self._alive = setting.alive(program)
        self._enough, self._tails = enough, None
        if enough and not setting.asked:
            self._tails = Tails(setting, program, enough)
        self._expiry = Expiry(setting, program)
        self._reaches: dict[int, tuple[Reach, Whole | None]] = {}

    @property
    def wanders(self) -> bool:
        """Whether the line may go on for long before it ends."""
        settled = self._tails.settled if self._tails else [False] * len(self._open)
        return any(
            edge.arrow.later or edge.entry.state <= state
            for state, edges in enumerate(self._program.edges)
            for edge in (() if settled[state] else edges)
        )

    def roots(self) -> list[Mask]:
        """Return, by entry, at which events of its state the line may begin."""
        return [
            roots(self._block, self._program, it) & self._alive[it.state]
            for it in self._program.entries
        ]

    def found(self, begun: list[Mask] | None = None, within: Whole | None = None) -> Found:
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
        self._settling: list[Memory] = []
        program, ends = self._program, []
        at: dict[int, list[Memory]] = {state: [] for state in range(len(program.states))}
        for number, rows in enumerate(self._begun(begun or self.roots())):
            at[program.entries[number].state].append(rows)
        for states in components(program):
            circles = len(states) > 1 or any(
                edge.entry.state == states[0] for edge in program.edges[states[0]]
            )
            waves = self._in_time(states, at) if circles else self._at_once(states[0], at)
            for state, rows in waves:
                self._setting.tick()
                ends += self._leave(state, rows, at)
        none = np.empty((self._seen + len(self._setting.asked.columns), 0), np.int64)
        ends = [(0, beginning(none)), *ends]
        if self._settling:
            ends.append((-1, self._with_best_ends()))
        found = ends_of(self._setting, program, self._firsts, ends)
        if not self._tails or not all(self._tails.settled[it.state] for it in program.entries):
            found.cost[:] = -1  # of ways that settle later their first steps are not counted
        return found

    def _begun(self, begun: list[Mask]) -> Iterator[Memory]:
        """Yield the ways that begin by each entry."""
        before = 0
        self._firsts: list[Whole] = []
        for entry, fits in zip(self._program.entries, begun, strict=True):
            state, chosen = entry.state, np.flatnonzero(fits)
            events = self._block.events(self._program.states[state])
            if self._within is not None:
                start, end = events.start[chosen], events.end[chosen]
                chosen = chosen[end - start <= self._within[events.capture[chosen]]]
            self._firsts.append(chosen)
            columns = np.full((self._seen + len(self._setting.asked.columns), len(chosen)), -1)
            columns[ROOT] = before + np.arange(len(chosen))
            before += len(chosen)
            for level in range(1 + len(entry.opens)):
                group = GROUPS + 3 * level
                columns[group + START] = columns[group + LOW] = events.start[chosen]
                columns[group + BEYOND] = 0
            yield self._matched(beginning(columns), state, chosen, self._due.at(None, state))

    def _matched(self, rows: Memory, state: int, events: Whole, due: Settled) -> Memory:
        """Return ways with the events that they match next, those that are possible."""
        setting, told = self._setting, self._program.states[state]
        rows.columns[EVENT] = events
        if state in setting.contested.get(self._program, ()):
            claims = setting.claims(self._program, told, events)
            fits = np.flatnonzero(rows.taken.apart(claims))
            rows, claims = rows.at(fits), claims.at(fits)
            rows.taken = rows.taken.with_those(claims)
            events = events[fits]
        own = self._block.events(told).at(events)
        seen = setting.asked.noted(self._block, told, events, rows.columns[self._seen :])
        rows.columns[self._seen :] = seen
        if self._timed:
            rows, own = self._kept_in_time(rows, own.end - own.start), own
        if due.conditions:
            capture = self._block.events(told).capture[rows.columns[EVENT]]
            rows = rows.at(setting.met(due.conditions, capture, rows.columns[self._seen :]))
        for column in due.columns:
            noted = rows.columns[self._seen + column]
            noted[noted >= 0] = MET
        return rows

    def _kept_in_time(self, rows: Memory, frames: Whole) -> Memory:
        """Return the ways that a rhythm may still be kept by, with how long a step has lasted."""
        beats = rows.columns[self._beats : self._seen]
        place = (beats >= 0).sum(axis=0)
        fits = np.flatnonzero(place < len(beats))
        rows, place = rows.at(fits), place[fits]
        beats = rows.columns[self._beats : self._seen]
        beats[place, np.arange(len(place))] = frames[fits]
        return rows.at(np.flatnonzero(self._setting.asked.may_be_in_rhythm(beats)))

    def _at_once(self, state: int, at: dict[int, list[Memory]]) -> Iterator[tuple[int, Memory]]:
        """Yield the ways that stand at a state that does not lead to itself."""
        if at[state]:
            yield state, self._settled(state, at.pop(state))

    def _in_time(
        self, states: list[int], at: dict[int, list[Memory]]
    ) -> Iterator[tuple[int, Memory]]:
        """Yield the ways that stand at states that lead to each other, in order of time."""
        ranks = ranks_of(self._block, self._program, states)
        waves: dict[int, dict[int, list[Memory]]] = {}
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

    def _settled(self, state: int, tables: list[Memory]) -> Memory:
        """Return ways, those as one that stand at the same event and remember the same."""
        rows = self._standing(state, tables)
        alike, which = rows.alike()
        if self._tracked:
            alike.came = self.nodes.add(len(alike), rows.came, which)
        return alike

    def _standing(self, state: int, tables: list[Memory]) -> Memory:
        """Return the ways that stand at a state, but for those of captures that are refused."""
        self._followed += sum(map(len, tables))
        if self._followed > budget.rows(WAY):
            raise budget.TooMuch
        rows = together(tables)
        events = self._block.events(self._program.states[state])
        answered = self._setting.tried(events.capture[rows.columns[EVENT]])
        if answered is not None:
            rows = rows.at(np.flatnonzero(answered))
        return self._expiry.dropped(state, rows)

    def _leave(
        self, state: int, rows: Memory, at: dict[int, list[Memory]]
    ) -> list[tuple[int, Memory]]:
        """Let ways go on from a state, and return those that end there."""
        left: dict[tuple[object, ...], Memory] = {}
        ending = rows
        if self._tails and self._tails.free[state]:
            ending, rows = self._settled_best(state, rows)

        def leaving(way: Exit, rows: Memory) -> Memory:
            key = (way.closes, way.to_end, id(rows))
            if key not in left:
                fits = may_leave(self._block, self._program, way)[rows.columns[EVENT]]
                left[key] = self._closed(rows.at(np.flatnonzero(fits)), state, way.closes)
            return left[key]

        for edge in self._program.edges[state]:
            gone = self._over(edge, leaving(edge.exit, rows))
            if len(gone):
                at[edge.entry.state].append(gone)
        ends = []
        told = self._program.states[state]
        passing = self._block.events(told).passing
        for way in self._program.exits[state]:
            ended = leaving(way, ending)
            if told.manner != "via":
                ended = ended.at(np.flatnonzero(~passing[ended.columns[EVENT]]))
            late = self._due.late(state)
            if late:
                capture = self._block.events(told).capture[ended.columns[EVENT]]
                fits = self._setting.met(late, capture, ended.columns[self._seen :])
                ended = ended.at(fits)
            ends.append((state, ended))
        return ends

    def _settled_best(self, state: int, rows: Memory) -> tuple[Memory, Memory]:
        """Let ways end as they best do, and return those that still end here, or go on.

        These are starting positions alone, and what leads to something that others could want.
        """
        assert self._tails
        event = rows.columns[EVENT]
        best = self._tails.best[state][event]
        settled = rows.at(np.flatnonzero(best >= 0))
        settled.columns[EVENT] = best[best >= 0]
        self._settling.append(settled)
        ending, on = self._tails.ending[state][event], self._tails.on[state][event]
        return rows.at(np.flatnonzero(ending)), rows.at(np.flatnonzero(on))

    def _with_best_ends(self) -> Memory:
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
        capture = captures_of(self._setting, program, self._firsts)[rows.columns[ROOT]]
        own = GROUPS + 3
        rows = self._beside(rows, program.whole, own, (capture, end, end, end < 0))
        carry_out(rows.columns, own, end_of(rows.columns[EVENT]))
        return rows

    def _closed(self, rows: Memory, state: int, closes: tuple[Group, ...]) -> Memory:
        """Return ways with some groups closed, inner ones first."""
        events = self._block.events(self._program.states[state])
        depth = self._depths[state]
        for group in closes:
            event = rows.columns[EVENT]
            end, alone, capture = events.end[event], events.starting[event], events.capture[event]
            own = GROUPS + 3 * depth
            if group.length:
                frames = end - rows.columns[own + START]
                fits = self._block.meets(capture, frames, group.length) & ~alone
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
        self, rows: Memory, group: Group, own: int, frames: tuple[Whole, Whole, Whole, Mask]
    ) -> Memory:
        """Return ways with what stands beside a group that closes in some frames.

        These are capture, how far others are compared, the end, and whether it merely starts.
        """
        capture, until, end, alone = frames
        start, low = rows.columns[own + START], rows.columns[own + LOW]
        high = np.maximum(rows.columns[own + BEYOND], end)
        lines = Stretches(capture, start, until, low, high, alone)
        seen = rows.columns[self._seen :]
        memory = rows.taken, rows.owed, seen, rows.link
        hulls = Hulls(np.arange(len(rows)), lines.low, lines.high, *memory)
        whole = group is self._program.whole
        hulls = self._setting.company.close(group, lines, hulls, whole=whole)
        rows = rows.at(hulls.line)
        rows.columns[self._seen :] = hulls.seen
        rows.columns[own + LOW], rows.columns[own + BEYOND] = hulls.low, hulls.high
        rows.taken, rows.owed, rows.link = hulls.taken, hulls.owed, hulls.link
        return rows

    def _over(self, edge: Edge, rows: Memory) -> Memory:
        """Return the ways that go on over an edge."""
        state = edge.entry.state
        events = self._block.events(self._program.states[state])
        fits = self._alive[state].copy()
        if self._tails and self._tails.free[edge.exit.state]:
            fits &= self._tails.entered[state]
        for arrow in edge.entry.from_start:
            fits &= begins(self._block, self._program.states[state], events, arrow)
        sources, targets = self._led(edge, rows)
        here = fits[targets]
        sources, targets = sources[here], targets[here]
        gone = rows.at(sources)
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

    def _led(self, edge: Edge, rows: Memory) -> tuple[Whole, Whole]:
        """Return pairs of a way and an event to which an edge leads from it, if that is in time."""
        state = self._program.states[edge.entry.state]
        events, event = self._block.events(state), rows.columns[EVENT]
        if id(edge) not in self._reaches:
            before = self._block.events(self._program.states[edge.exit.state])
            reach = Reach(self._block, way_of(self._program.states, edge), before)
            ends = events.capture * FAR + events.end
            self._reaches[id(edge)] = reach, ends if (np.diff(ends) >= 0).all() else None
        reach, in_order = self._reaches[id(edge)]
        low, high, targets = reach.listed()
        low, high = low[event], high[event]
        latest, horizon = self._latest(edge, rows)
        if targets is None and in_order is not None:
            beyond = np.minimum(high, np.searchsorted(in_order, latest, "right"))
            high = np.minimum(high, np.searchsorted(in_order, np.minimum(latest, horizon), "right"))
            self._cut_off.append(rows.came[high < beyond])
        sources, places = spread(low, high)
        if targets is not None:
            places = targets[places]
        ends = events.capture[places] * FAR + events.end[places]
        fits = ends <= latest[sources]
        soon = ends <= horizon[sources]
        self._cut_off.append(rows.came[sources[fits & ~soon]])
        fits &= soon
        return sources[fits], places[fits]

    def is_cut_off(self, nodes: Whole) -> Mask:
        """Return which nodes may go on beyond the frames in which ways were looked for."""
        return self.nodes.leading_to(np.concatenate(self._cut_off))[nodes]

    def _latest(self, edge: Edge, rows: Memory) -> tuple[Whole, Whole]:
        """Return when what follows ways has to be over, and until when ways are looked for.

        Both with the capture, as one number.
        """
        before = self._block.events(self._program.states[edge.exit.state])
        capture = before.capture[rows.columns[EVENT]]
        frames = self._block.frames[capture]
        horizon = frames
        if self._within is not None:
            horizon = np.maximum(rows.columns[GROUPS + START] + self._within[capture], 0)
        groups = self._open[edge.exit.state]
        for level, group in enumerate(groups[: len(groups) - len(edge.exit.closes)], 1):
            if group.length:
                begun = rows.columns[GROUPS + 3 * level + START]
                frames = np.minimum(frames, begun + self._block.bounds(group.length)[1][capture])
        return capture * FAR + np.maximum(frames, 0), capture * FAR + horizon
