"""Why a query finds nothing: what each of its conditions keeps out, and what is found instead."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import islice
from math import inf
from time import monotonic, process_time

from lanindex.search.explain.changes import Condition, conditions, edited, places, query_of
from lanindex.search.language.query import Item, Line, Query, Step

SECONDS = 2.0
"""How long may be spent on looking for what would be found."""

MOST = 5
"""Patterns that are offered."""

_PATIENCE = 4
"""How many times as long it may take where others use the machine as well."""

_LEFT_OUT = 2.5
_OTHER_NUMBER = 1.05
"""What it costs to leave a condition out, and to ask for the nearest number; see `edited`."""

_FOR_LIMITS, _FOR_EDITS = 0.4, 0.7
"""The shares of the time until which lengths and counts are left out, and until which patterns
alike are tried; the rest is for the other conditions."""

_COMBINED = 60
"""Changes, and changes of what they led to, that are tried where no single one helps."""

Found = tuple[int, int]
"""How many hits, and in how many captures."""

Count = Callable[[Query], Found | None]
"""Counts the hits of a query; None: there was no time for it."""


@dataclass(frozen=True)
class Budget:
    """Seconds to work in, counted from now.

    The time of the clock is bounded too, at a multiple: so a busy machine gives the same answer as
    a quiet one, only later.
    """

    seconds: float
    _worked: float = field(default_factory=process_time)
    _begun: float = field(default_factory=monotonic)

    def late(self, share: float = 1) -> bool:
        """Tell whether a share of the time is over."""
        allowed = share * self.seconds
        return (
            process_time() - self._worked >= allowed
            or monotonic() - self._begun >= _PATIENCE * allowed
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
        Which.
    never : tuple of str
        Those of its steps that nothing is at any time.
    left_out : tuple of LeftOut
        The conditions without which it finds something, in the order of the pattern.
    instead : tuple of Suggestion
        Patterns that find something, the nearest first.
    untried : int
        Changes for which there was no time.
    remark : str
        What else there is to say, before all this.

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


def advise(
    query: Query,
    count: Count,
    read: Callable[[str], Query | None],
    *,
    budget: Budget | None = None,
) -> Advice:
    """Return why a query finds nothing, and what would be found.

    Parameters
    ----------
    query : Query
        Which finds nothing.
    count : Count
        Counts hits where it was looked for.
    read : callable
        Reads a pattern; returns None where it is not understood.
    budget : Budget, optional
        How long it may take, about; by default `SECONDS` from now.

    Returns
    -------
    Advice
        Each pattern in it parses to exactly the query that was counted.
    """
    return _Adviser(query, count, read, budget or Budget(SECONDS)).advice()


class _Adviser:
    """Tries what is near a query, for as long as there is time."""

    def __init__(
        self, query: Query, count: Count, read: Callable[[str], Query | None], budget: Budget
    ) -> None:
        self.query, self.count, self.read, self.budget = query, count, read, budget
        self.untried = 0
        self.tried: set[Query] = {query}
        self.found: list[tuple[float, Suggestion]] = []
        self.left_out: dict[Condition, LeftOut] = {}

    def advice(self) -> Advice:
        """Try what is likeliest first: limits, then what is alike, then all other conditions."""
        every = list(conditions(self.query))
        often = Counter(it.said for it in every)
        every = [it if often[it.said] > 1 else replace(it, step="") for it in every]
        self.without([it for it in every if it.limit], _FOR_LIMITS)
        self.offer(edited(self.query), _FOR_EDITS)
        never = tuple(self.never())
        self.without([it for it in every if not it.limit], 1)
        if all(cost == _LEFT_OUT for cost, _ in self.found) and not self.untried:
            self.offer(self.combined(), 1)
            self.untried = 0
        best = sorted(self.found, key=lambda it: (it[0], -it[1].hits))[:MOST]
        left_out = tuple(self.left_out[it] for it in every if it in self.left_out)
        instead = tuple(suggestion for _, suggestion in best)
        return Advice(str(self.query), never, left_out, instead, self.untried)

    def offer(self, changes: Iterable[tuple[float, Query]], share: float) -> None:
        """Keep what finds something, until there are enough; what costs alike is compared."""
        dearest = inf
        for cost, query in changes:
            if cost > dearest:
                return
            if self.budget.late(share):
                self.untried += 1
            elif self.readable(query) and query not in self.tried:
                self.keep(cost, query)
                if sum(other != _LEFT_OUT for other, _ in self.found) >= MOST:
                    dearest = min(dearest, cost)

    def keep(self, cost: float, query: Query) -> Found | None:
        """Return how much a query finds, and offer it if that is anything."""
        self.tried.add(query)
        found = self.count(query)
        if found is None:
            self.untried += 1
        elif found[0]:
            self.found.append((cost, Suggestion(str(query), *found)))
        return found

    def readable(self, query: Query) -> bool:
        """Tell whether the text of a query says just that."""
        return self.read(str(query)) == query

    def never(self) -> Iterator[str]:
        """Yield the steps of which there is none by itself."""
        steps = _alone(self.query)
        for said, alone in steps.items() if len(steps) > 1 else ():
            if self.readable(alone) and self.count(alone) == (0, 0):
                yield said

    def without(self, several: Iterable[Condition], share: float) -> None:
        """Keep what is found without each of some conditions."""
        for condition in several:
            if not self.readable(condition.rest):
                continue
            if self.budget.late(share):
                self.untried += 1
                continue
            found = self.keep(_LEFT_OUT, condition.rest)
            if found and found[0]:
                near = self.nearest(condition)
                self.left_out[condition] = LeftOut(condition.said, *found, near, condition.step)

    def nearest(self, condition: Condition) -> str:
        """Return how near a condition came to be met, and offer what that would find."""

        def finds(query: Query) -> bool:
            found = self.count(query)
            if found is None:
                raise TimeoutError
            return bool(found[0])

        with suppress(TimeoutError):
            if near := condition.nearest(finds):
                query, number = near
                if self.readable(query):
                    self.keep(_OTHER_NUMBER, query)
                return condition.told.format(number)
        return ""

    def combined(self) -> list[tuple[float, Query]]:
        """Return what two changes make, the smallest ones first."""
        both = [
            (cost + more, other)
            for cost, query in islice(_changes(self.query), _COMBINED)
            for more, other in islice(_changes(query), _COMBINED)
        ]
        return sorted(both, key=lambda it: it[0])


def _changes(query: Query) -> Iterator[tuple[float, Query]]:
    yield from edited(query)
    yield from ((_LEFT_OUT, condition.rest) for condition in conditions(query))


def _alone(query: Query) -> dict[str, Query]:
    """Return each step of a query as one of its own; the first of a line may be a beginning."""
    alone: dict[str, Query] = {}
    nodes = [it.node for it in places(query)]
    firsts = [it.items[0] for it in nodes if isinstance(it, Line)]
    for item in nodes:
        if isinstance(item, Item) and isinstance(item.unit, Step):
            step = replace(item.unit, named=True)
            beginning = step.manner == "move" and step.words and item in firsts
            there = replace(step, manner="at") if beginning else step
            alone[str(step)] = query_of(Line((Item(there),)))
    return alone
