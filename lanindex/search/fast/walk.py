"""A line from each place where it can begin: every place where it can end.

Other than `lines`, which tells the best end of each beginning, this tells all of them, for a line
that stands beside another one. Rows of a table go from state to state; those that stand at the
same event, with the same beginning and the same brackets open, are one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lanindex.search.automaton import Edge, Entry, Exit, Group, Program
from lanindex.search.fast.answers import roots
from lanindex.search.fast.arrows import Reach, begins, way_of
from lanindex.search.fast.block import Block
from lanindex.search.fast.lines import components, may_leave
from lanindex.search.fast.ragged import (
    FAR,
    Mask,
    TooMuch,
    Whole,
    best_of_each,
    in_order,
    spread,
    starts_of,
)

ROOT, EVENT, OPENED = range(3)
"""What the columns of a row are: where it began, at which event it stands, and from `OPENED` on in
which frame each of the brackets began that are open."""


MOST_PLACES = 1 << 28
"""How many pairs of a beginning and an event a walk may note."""


class NotCovered(Exception):
    """What needs ways that remember more than where they are."""


@dataclass(slots=True, eq=False)
class Ends:
    """All ways in which a line can match, its outer groups still open.

    Attributes
    ----------
    entry, root : ndarray
        (N,) by which entry of the program a way begins, and at which event of its state.
    state, event : ndarray
        (N,) where it ends.
    used : ndarray
        (N, K) the events that it took at each of the states asked for; -1: none.
    """

    entry: Whole
    root: Whole
    state: Whole
    event: Whole
    used: Whole

    def at(self, chosen: Whole) -> Ends:
        """Return some of them."""
        return Ends(
            self.entry[chosen],
            self.root[chosen],
            self.state[chosen],
            self.event[chosen],
            self.used[chosen],
        )


def outer_groups(program: Program) -> tuple[Group, ...]:
    """Return the groups that open wherever a line begins and close wherever it ends."""
    opened = [entry.opens for entry in program.entries]
    closed = [leaving.closes[::-1] for exits in program.exits for leaving in exits]
    outer = []
    for groups in zip(*opened, *closed, strict=False):
        if any(group is not groups[0] for group in groups):
            break
        outer.append(groups[0])
    inner = [
        group
        for edges in program.edges
        for edge in edges
        for group in (*edge.exit.closes, *edge.entry.opens)
    ]
    return tuple(it for it in outer if it not in inner)


class Walk:
    """Walks a program in a block.

    Parameters
    ----------
    block : Block
        Where.
    program : Program
        Whose inner brackets have lengths only.
    used : tuple of int
        The states of which it shall be told what was taken there.
    begun : list of ndarray, optional
        By entry, at which events of its state the line may begin, (N,) bool; None: wherever it can.
    within : ndarray, optional
        (captures,) int64: in how many frames after its beginning each way must have ended.
    """

    def __init__(
        self,
        block: Block,
        program: Program,
        used: tuple[int, ...] = (),
        begun: list[Mask] | None = None,
        within: Whole | None = None,
    ) -> None:
        self._block, self._program, self._used = block, program, used
        self._begun = begun or [roots(block, program, entry) for entry in program.entries]
        self._soon, self._latest = within, np.empty(0, np.int64)
        self._ending_at: dict[int, tuple[Whole, bool]] = {}
        self._outer = len(outer_groups(program))
        self._depths = _depths(program, self._outer)
        self._taken = OPENED + max(self._depths)
        self._width = self._taken + len(used)
        self._reaches: dict[int, Reach] = {}

    def ends(self) -> Ends:
        """Return all ways in which the line can match.

        Raises
        ------
        NotCovered
            Where one begins with a passing symbol and goes on.
        TooMuch
            Where there are too many.
        """
        pieces = [self._from(number, entry) for number, entry in enumerate(self._program.entries)]
        columns = np.concatenate(pieces, axis=1)
        entry, root, state, event, *_ = columns
        return Ends(entry, root, state, event, columns[4:].T)

    def _from(self, number: int, entry: Entry) -> Whole:
        """Return entry, root, state and event of the ways that begin by one entry."""
        program = self._program
        events = self._block.events(program.states[entry.state])
        chosen = np.flatnonzero(self._begun[number])
        if self._soon is not None:
            frames = self._soon[events.capture]
            chosen = chosen[(events.end - events.start <= frames)[chosen]]
            self._latest = events.capture * FAR + events.start + frames
        if program.edges[entry.state] and events.passing[chosen].any():
            raise NotCovered
        rows = np.full((self._width, len(chosen)), -1)
        rows[ROOT] = rows[EVENT] = chosen
        for level in range(len(entry.opens) - self._outer):
            rows[OPENED + level] = events.start[chosen]
        self._take(rows, entry.state)
        at: dict[int, list[Whole]] = {state: [] for state in range(len(program.states))}
        at[entry.state].append(rows)
        found = []
        for states in components(program):
            self._within(entry, states, at)
            for state in states:
                here = _distinct(np.concatenate(at[state], axis=1)) if at[state] else rows[:, :0]
                for leaving in program.exits[state]:
                    ending = self._ending(here, leaving)
                    told = np.empty((4, ending.shape[1]), np.int64)
                    told[0], told[1], told[2], told[3] = number, ending[ROOT], state, ending[EVENT]
                    found.append(np.concatenate((told, ending[self._taken :])))
        return np.concatenate(found, axis=1)

    def _take(self, rows: Whole, state: int) -> None:
        """Note at which event of a state rows stand, if it is asked for."""
        if state in self._used:
            rows[self._taken + self._used.index(state)] = rows[EVENT]

    def _within(self, entry: Entry, states: list[int], at: dict[int, list[Whole]]) -> None:
        """Let the rows at some states that lead to each other go on until there are no new ones."""
        circles = len(states) > 1 or any(
            edge.entry.state == states[0] for edge in self._program.edges[states[0]]
        )
        seen = {state: self._seen(entry, state) for state in states} if circles else {}
        todo = {state: at[state] for state in states if at[state]}
        for state in seen:
            at[state] = []
        while todo:
            coming: dict[int, list[Whole]] = {}
            for state, pieces in todo.items():
                fresh = _distinct(np.concatenate(pieces, axis=1))
                if state in seen:
                    fresh = seen[state].fresh(fresh)
                    at[state].append(fresh)
                for edge in self._program.edges[state]:
                    rows = self._over(edge, fresh)
                    target = edge.entry.state
                    if rows.shape[1]:
                        (coming if target in states else at).setdefault(target, []).append(rows)
            todo = coming

    def _seen(self, entry: Entry, state: int) -> _Seen:
        """Return what notes which rows have been at a state."""
        if self._width > OPENED:
            return _Seen()
        first, events = (
            self._block.events(self._program.states[number]) for number in (entry.state, state)
        )
        bounds = np.searchsorted(events.capture, np.arange(len(self._block) + 1))
        counts = np.diff(bounds)[first.capture]
        return _Dense(np.cumsum(counts) - counts - bounds[first.capture], int(counts.sum()))

    def _ending(self, rows: Whole, leaving: Exit) -> Whole:
        """Return the rows that may end there, their inner groups closed."""
        state = self._program.states[leaving.state]
        events = self._block.events(state)
        fits = may_leave(self._block, self._program, leaving)
        if state.manner != "via":
            fits &= ~events.passing
        rows = rows[:, fits[rows[EVENT]]]
        closes = leaving.closes[: len(leaving.closes) - self._outer]
        return self._closed(rows, leaving.state, closes)[0]

    def _closed(self, rows: Whole, state: int, closes: tuple[Group, ...]) -> tuple[Whole, int]:
        """Return the rows whose brackets may close, and how many are open still."""
        events = self._block.events(self._program.states[state])
        depth = self._depths[state]
        for group in closes:
            depth -= 1
            if group.length:
                event = rows[EVENT]
                frames = events.end[event] - rows[OPENED + depth]
                fits = self._block.meets(events.capture[event], frames, group.length)
                rows = rows[:, fits & ~events.starting[event]]
            rows = rows.copy()
            rows[OPENED + depth] = -1
        return rows, depth

    def _over(self, edge: Edge, rows: Whole) -> Whole:
        """Return the rows to which an edge leads."""
        if edge.exit.to_end:
            rows = rows[:, may_leave(self._block, self._program, edge.exit)[rows[EVENT]]]
        rows, depth = self._closed(rows, edge.exit.state, edge.exit.closes)
        sources, targets = self._led(edge, rows)
        state = self._program.states[edge.entry.state]
        events = self._block.events(state)
        for arrow in edge.entry.from_start:
            fits = begins(self._block, state, events, arrow)[targets]
            sources, targets = sources[fits], targets[fits]
        led = rows[:, sources]
        led[EVENT] = targets
        for level in range(len(edge.entry.opens)):
            led[OPENED + depth + level] = events.start[targets]
        self._take(led, edge.entry.state)
        return led

    def _led(self, edge: Edge, rows: Whole) -> tuple[Whole, Whole]:
        """Return pairs of a row and an event to which an edge leads from it."""
        if id(edge) not in self._reaches:
            events = self._block.events(self._program.states[edge.exit.state])
            self._reaches[id(edge)] = Reach(self._block, way_of(self._program.states, edge), events)
        reach = self._reaches[id(edge)]
        low, high, targets = reach.listed()
        low, high = low[rows[EVENT]], high[rows[EVENT]]
        ends: Whole | None = None
        latest = self._latest
        if self._soon is not None:
            (ends, rising), latest = self._ends(edge.entry.state), self._latest[rows[ROOT]]
            if rising and targets is None:
                high, ends = np.minimum(high, np.searchsorted(ends, latest, "right")), None
        groups = reach.open_groups()
        if groups is not None and len(groups):
            # All that is later than a row is also later than an earlier one of the same beginning.
            group = groups[np.minimum(low, len(groups) - 1)]
            some = np.flatnonzero(low < high)
            others = [rows[column][some] for column in (ROOT, *range(OPENED, self._width))]
            first = some[best_of_each((group[some], *others), (low[some],))]
            sources, places = spread(low[first], high[first])
            sources = first[sources]
        else:
            sources, places = spread(low, high)
            places = targets[places] if targets is not None else places
        if ends is not None:
            fits = ends[places] <= latest[sources]
            sources, places = sources[fits], places[fits]
        return sources, places

    def _ends(self, state: int) -> tuple[Whole, bool]:
        """Return when a state's events end, with their captures as one number; if in order."""
        if state not in self._ending_at:
            events = self._block.events(self._program.states[state])
            ends = events.capture * FAR + events.end
            self._ending_at[state] = ends, bool((ends[1:] >= ends[:-1]).all())
        return self._ending_at[state]


def _depths(program: Program, outer: int) -> list[int]:
    """Return how many brackets with something to remember are open at each state."""
    depths = [0] * len(program.states)
    todo = [(entry.state, len(entry.opens) - outer) for entry in program.entries]
    seen = set(todo)
    while todo:
        state, depth = todo.pop()
        depths[state] = depth
        for edge in program.edges[state]:
            after = depth - len(edge.exit.closes) + len(edge.entry.opens)
            if (edge.entry.state, after) not in seen:
                seen.add((edge.entry.state, after))
                todo.append((edge.entry.state, after))
    return depths


def _distinct(rows: Whole) -> Whole:
    order = in_order(tuple(rows))
    rows = rows[:, order]
    new = np.zeros(rows.shape[1], bool)
    for column in rows:
        new |= starts_of(column)
    return rows[:, new]


class _Seen:
    """Notes which rows have been at a state."""

    def __init__(self) -> None:
        self._rows: Whole | None = None

    def fresh(self, rows: Whole) -> Whole:
        """Return those of distinct rows that have not been there before."""
        known = rows[:, :0] if self._rows is None else self._rows
        both = np.concatenate((known, rows), axis=1)
        order = np.lexsort(both[::-1])
        both = both[:, order]
        new = np.zeros(both.shape[1], bool)
        for column in both:
            new |= starts_of(column)
        found = rows[:, np.sort(order[new & (order >= known.shape[1])]) - known.shape[1]]
        self._rows = np.concatenate((known, found), axis=1)
        return found


class _Dense(_Seen):
    """The same of rows that differ by where they began and where they stand alone.

    Parameters
    ----------
    base : ndarray
        (roots,) int64: what an event's number is added to, to be a place of its own.
    places : int
        How many places there are.
    """

    def __init__(self, base: Whole, places: int) -> None:
        if places > MOST_PLACES:
            raise TooMuch
        self._base, self._there = base, np.zeros(places, bool)

    def fresh(self, rows: Whole) -> Whole:
        """Return those of distinct rows that have not been there before."""
        places = self._base[rows[ROOT]] + rows[EVENT]
        found = rows[:, ~self._there[places]]
        self._there[places] = True
        return found
