"""Why a query finds nothing: what each of its conditions keeps out, and what is found instead."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from math import inf
from time import monotonic, process_time

from lanindex.search.explain.changes import Change, changes, nodes_of, query_of
from lanindex.search.language.query import Item, Line, Query, Step, may_begin

SECONDS = 2.0
"""How long may be spent on looking for what would be found."""

MOST = 5
"""Patterns that are offered."""

_CLOCK_FACTOR = 4
"""How many times as long it may take by the clock on a busy machine."""

_FOR_LIMITS, _FOR_EDITS = 0.4, 0.7
"""The shares of the time until which limits are left out, and until which patterns alike are
tried; the rest is for the other conditions."""

_COMBINED = 60
"""Changes, and changes of what they led to, that are tried where no single one helps."""

HitCounts = tuple[int, int]
"""How many hits, and in how many captures."""

Count = Callable[[Query], HitCounts | None]
"""Counts the hits of a query; None: there was no time for it."""

Read = Callable[[str], Query | None]
"""Reads a pattern; None: it is not understood."""


@dataclass(frozen=True)
class Budget:
    """Seconds of work, counted from now; a busy machine may take longer by the clock."""

    seconds: float
    _worked: float = field(default_factory=process_time)
    _begun: float = field(default_factory=monotonic)

    def late(self, share: float = 1) -> bool:
        """Return whether a share of the time is over."""
        allowed = share * self.seconds
        return (
            process_time() - self._worked >= allowed
            or monotonic() - self._begun >= _CLOCK_FACTOR * allowed
        )


@dataclass(frozen=True, slots=True)
class LeftOut:
    """What a query finds without one of its conditions."""

    condition: str  # as written; empty: the choice of captures
    hits: int
    captures: int
    nearest: str = ""  # how near it came to be met, where that is a number
    step: str = ""  # which step says it, where several do

    def __str__(self) -> str:
        """Return it in a line."""
        near = f", {self.nearest}" if self.nearest else ""
        of = f' of "{self.step}"' if self.step else ""
        where = f'without "{self.condition}"{of}' if self.condition else "in all captures"
        return f"{where}: {_counted(self.hits, 'hit')}{near}"


@dataclass(frozen=True, slots=True)
class Suggestion:
    """A pattern that finds something, and how much."""

    pattern: str
    hits: int
    captures: int

    @property
    def counts(self) -> str:
        """How much it finds, in words."""
        return f"{_counted(self.hits, 'hit')} in {_counted(self.captures, 'capture')}"


@dataclass(frozen=True, slots=True)
class Advice:
    """What to do about a pattern that finds nothing.

    Attributes
    ----------
    pattern : str
        The pattern.
    never : tuple of str
        Its steps that match nothing at any time.
    left_out : tuple of LeftOut
        The conditions without which it finds something, in the order of the pattern.
    instead : tuple of Suggestion
        Patterns that find something, the nearest first.
    untried : int
        Changes for which there was no time.
    remark : str
        What to say before all this.

    Examples
    --------
    >>> import lanindex
    >>> with lanindex.open_library("dance.db") as library:
    ...     advice = library.suggest("arms low -> high")
    >>> print(advice.instead[0].pattern)
    arms low ... high
    >>> advice.brief
    'nearest: arms low ... high (18 hits in 7 captures)'
    """

    pattern: str
    never: tuple[str, ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    instead: tuple[Suggestion, ...] = ()
    untried: int = 0
    remark: str = ""

    def __str__(self) -> str:
        """Return it in lines, as for a terminal."""
        lines = [self.remark] if self.remark else []
        lines += [f'"{step}" is nowhere to be found' for step in self.never]
        lines += map(str, self.left_out)
        if self.instead:
            width = max(len(it.pattern) for it in self.instead)
            lines.append("The nearest patterns that find something:")
            lines += [f"  {it.pattern.ljust(width)}  {it.counts}" for it in self.instead]
        elif not self.left_out and not self.remark:
            tried = " that could be tried" if self.untried else ""
            lines.append(f"Nor does anything near it{tried} find something.")
        if self.untried:
            lines.append(f"{_counted(self.untried, 'change')} could not be tried in time.")
        return "\n".join(lines)

    @property
    def brief(self) -> str:
        """The same in one line."""
        if self.instead:
            return f"nearest: {self.instead[0].pattern} ({self.instead[0].counts})"
        remark = [self.remark] if self.remark else []
        return [*remark, *map(str, self.left_out), "nothing near it finds something"][0]


def _counted(number: int, noun: str) -> str:
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def advise(query: Query, count: Count, read: Read, *, budget: Budget | None = None) -> Advice:
    """Return why a query finds nothing, and what would be found.

    Each pattern in the advice parses to exactly the query that was counted.
    """
    budget = budget or Budget(SECONDS)
    return _Adviser(query, count, read, budget, counted={query: (0, 0)}).advice()


@dataclass(slots=True)
class _Adviser:
    """Tries the changes of a query, for as long as there is time."""

    query: Query
    count: Count
    read: Read
    budget: Budget
    counted: dict[Query, HitCounts]
    untried: int = 0
    left_out: dict[Change, LeftOut] = field(default_factory=dict)
    instead: list[tuple[Change, Suggestion]] = field(default_factory=list)

    def advice(self) -> Advice:
        """Try what is likeliest first: limits, then what is alike, then all other conditions."""
        every = changes(self.query)
        conditions = [it for it in every if it.condition]
        often = Counter(it.condition for it in conditions)
        conditions = [it if often[it.condition] > 1 else replace(it, step="") for it in conditions]
        self.attempt([it for it in conditions if it.limit], _FOR_LIMITS)
        self.attempt([it for it in every if not it.condition], _FOR_EDITS)
        never = tuple(self.never())
        self.attempt([it for it in conditions if not it.limit])
        if all(it.condition for it, _ in self.instead) and not self.untried:
            self.attempt(self.combined())
            self.untried = 0
        best = sorted(self.instead, key=lambda it: (it[0].cost, -it[1].hits))[:MOST]
        left_out = tuple(self.left_out[it] for it in conditions if it in self.left_out)
        instead = tuple(suggestion for _, suggestion in best)
        return Advice(str(self.query), never, left_out, instead, self.untried)

    def attempt(self, several: Iterable[Change], share: float = 1) -> None:
        """Count what changes find; once enough find something, skip those that cost more."""
        dearest = inf
        for change in several:
            if change.cost > dearest:
                return
            if self.budget.late(share):
                self.untried += 1
                continue
            hits, captures = self.keep(change)
            if hits and change.condition:
                said, near = change.condition, self.nearest(change)
                self.left_out[change] = LeftOut(said, hits, captures, near, change.step)
            if sum(not it.condition for it, _ in self.instead) >= MOST:
                dearest = change.cost

    def keep(self, change: Change) -> HitCounts:
        """Return how much a change finds, and offer it if that is anything."""
        query = change.query
        if query not in self.counted:
            found = self.count(query) if self.readable(query) else (0, 0)
            self.untried += found is None
            self.counted[query] = found or (0, 0)
            if found and found[0]:
                self.instead.append((change, Suggestion(str(query), *found)))
        return self.counted[query]

    def readable(self, query: Query) -> bool:
        """Return whether the text of a query parses to the same query."""
        return self.read(str(query)) == query

    def never(self) -> Iterator[str]:
        """Yield the steps that match nothing even alone."""
        steps = _alone(self.query)
        for said, alone in steps.items() if len(steps) > 1 else ():
            if self.readable(alone) and self.count(alone) == (0, 0):
                yield said

    def nearest(self, change: Change) -> str:
        """Return how near a limit came to be met, and offer the query with that limit."""

        def finds(query: Query) -> bool:
            found = self.count(query)
            if found is None:
                raise TimeoutError
            return bool(found[0])

        with suppress(TimeoutError):
            if near := change.nearest(finds):
                other, number = near
                self.keep(other)
                return change.number.format(number)
        return ""

    def combined(self) -> list[Change]:
        """Return what two changes make, the smallest ones first."""
        both = [
            Change(second.query, first.cost + second.cost)
            for first in changes(self.query)[:_COMBINED]
            for second in changes(first.query)[:_COMBINED]
        ]
        return sorted(both, key=lambda it: it.cost)


def _alone(query: Query) -> dict[str, Query]:
    """Return each step of a query on its own; the first of a line may be a starting position."""
    alone: dict[str, Query] = {}
    nodes = [node for node, _ in nodes_of(query)]
    firsts = [it.items[0] for it in nodes if isinstance(it, Line) and not it.start]
    for item in nodes:
        if isinstance(item, Item) and isinstance(item.unit, Step):
            step = replace(item.unit, named=True)
            begins = step.words and item in firsts and may_begin(item)
            there = replace(step, manner="at") if begins else step
            alone[str(step)] = query_of(Line((Item(there),)))
    return alone
