"""From a query to hits that are nearly what it says."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import UsageError
from lanindex.model.columns import Columns, Roster
from lanindex.search.automaton import plan
from lanindex.search.fuzzy.align import Ask
from lanindex.search.fuzzy.costs import BUCKETS, UNIT, Allowance
from lanindex.search.fuzzy.found import Found, Source
from lanindex.search.fuzzy.joining import Joining, Plan, Table, disturbed
from lanindex.search.fuzzy.lines import LIFTED
from lanindex.search.fuzzy.windows import BoolArray, IntArray
from lanindex.search.language.query import Bracket, Choice, Item, Lines, Query
from lanindex.search.language.query import Line as Steps
from lanindex.search.language.times import TOLERANCE
from lanindex.search.match.arrays import best_of_each
from lanindex.search.match.finder import Finder, Recordings, Watch
from lanindex.search.match.hits import Found as Exact

CLEAR = (15, 14, 12, 8)
"""How clear the best hits are looked for, in steps of a margin, one after the other."""

MORE = 4
"""How many times the captures are looked at that would be enough had each a hit."""


def find(
    query: Query,
    roster: Roster,
    columns: Mapping[str, Columns],
    recordings: Recordings,
    allowance: Allowance,
    *,
    tolerance: Fraction = TOLERANCE,
    overlaps: str = "none",
    best: int | None = None,
    watch: Watch | None = None,
) -> Found:
    """Find what is nearly a pattern.

    Parameters
    ----------
    query : Query
        What to find.
    roster : Roster
        Where.
    columns : Mapping of str to Columns
        Of all ``query.parts``.
    recordings : callable
        Gives captures with the tracks of some parts, by their places in the roster.
    allowance : Allowance
        How much a match may differ.
    tolerance : Fraction, optional
        Seconds within which edges agree.
    overlaps : str, optional
        ``none``: of matches that share frames the one that differs least; ``all``: one for every
        place where some begin.
    best : int, optional
        Only so many, those that fit best, the clearest first.
    watch : callable, optional
        Is told now and then how many captures are done, of how many; it may raise.

    Returns
    -------
    Found
        By capture, start and end, where they are not the best. The fit is the smallest margin of
        the symbols that are what was asked for, in proportion less for all that was edited.

    Raises
    ------
    UsageError
        Where the pattern says what has no edits.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.search.fuzzy import Allowance, find
    >>> from lanindex.search.language import parse
    >>> query = parse("torso forward mid -> place high")
    >>> with lanindex.open_library("dance.db") as library:
    ...     roster, columns = library.columns(query.parts)
    ...     held = list(library.tracks(parts=query.parts))
    ...     for allowed in ("0", "0.5"):
    ...         hits = find(
    ...             query, roster, columns, lambda places, parts: [held[it] for it in places],
    ...             Allowance.read(allowed),
    ...         )
    ...         print(len(hits))
    2
    3
    """
    if query.rhythm or query.where:
        raise UsageError(
            'a fuzzy search cannot count edits in "where" and "rhythm"',
            remedy="Leave them out, or search without --fuzzy.",
        )
    opened = [lines for pattern in query.patterns for lines in _opened(pattern).alternatives]
    plans = [
        Plan.of(program, lines, allowance)
        for lines in dict.fromkeys(opened)
        for program in plan(Query(Choice((lines,))))
    ]
    search = _Search(plans, roster, columns, recordings, tolerance, overlaps, watch)
    if any(one.leaps for one in plans):
        exact = Finder(query, roster, columns, recordings, tolerance).find("all", watch)
        every = search.found(exact)
        return every if best is None else every.by_fit(best)[:best]
    return search.found() if best is None else search.best(best)


def _opened(pattern: Choice) -> Choice:
    """Return a pattern without brackets around all of it, such as a pasted score has."""
    opened: list[Lines] = []
    for lines in pattern.alternatives:
        (item, *more) = lines.first.items
        bare = Steps((Item(item.unit),)) == lines.first and not more
        if isinstance(item.unit, Bracket) and bare:
            opened += [
                Lines(inner.first, (*inner.others, *lines.others))
                for inner in _opened(item.unit.pattern).alternatives
            ]
        else:
            opened.append(lines)
    return Choice(tuple(opened))


class _Search:
    """A search for some plans."""

    def __init__(
        self,
        plans: list[Plan],
        roster: Roster,
        columns: Mapping[str, Columns],
        recordings: Recordings,
        tolerance: Fraction,
        overlaps: str,
        watch: Watch | None,
    ) -> None:
        self._plans, self._roster, self._columns = plans, roster, columns
        self._recordings, self._tolerance = recordings, tolerance
        self._overlaps, self._watch = overlaps, watch
        self._done = 0

    def _ask(self) -> None:
        if self._watch:
            self._watch(self._done, len(self._roster))

    def found(self, exact: Exact | None = None) -> Found:
        """Return all hits; of exact ones those, too, where none that costs nothing begins."""
        return self._among(None, BUCKETS, exact)

    def best(self, number: int) -> Found:
        """Return so many hits that fit best, the clearest first.

        The clearest are looked for first, in the captures alone that can have such; where there are
        enough of them, no other can be among the best.
        """
        for clear in CLEAR:
            places, bounds = self._possible(clear)
            order = np.argsort(-bounds, kind="stable")
            many = MORE * number
            while len(order):
                some, rest = np.sort(places[order[:many]]), bounds[order[many:]]
                found = self._among(some, BUCKETS - clear).by_fit()
                least = np.nextafter(rest[0], 1) if len(rest) else clear / BUCKETS
                if (found.fit >= least).sum() >= number:
                    return found[:number]
                order, many = order if len(rest) else order[:0], MORE * many
        return self.found().by_fit()[:number]

    def _limit(self, one: Plan, most: int) -> int:
        """Return what a match may cost that is to fit well enough, in steps of a margin less."""
        return min(one.most, one.steps * UNIT * most // BUCKETS)

    def _possible(self, clear: int) -> tuple[IntArray, NDArray[np.float64]]:
        """Return the captures in which matches can be as clear, and how well they fit at most."""
        most = np.zeros(len(self._roster))
        for one in self._plans:
            limit = self._limit(one, BUCKETS - clear)
            joining = Joining(one, self._roster, self._columns, limit, clear)
            places, bounds = joining.bounds(one.steps, self._ask)
            most[places] = np.maximum(most[places], bounds)
        found = np.flatnonzero(most)
        return found, most[found]

    def _among(self, places: IntArray | None, most: int, exact: Exact | None = None) -> Found:
        """Return all hits in some captures; None: in all."""
        roster, columns, recordings = self._roster, self._columns, self._recordings
        tables = []
        for number, one in enumerate(self._plans):
            if places is None:
                self._done = len(roster) * number // len(self._plans)
            self._ask()
            joining = Joining(one, roster, columns, self._limit(one, most))
            table = joining.table(places, self._tolerance, self._ask)
            for apart in one.apart:
                args = roster, columns, recordings, self._tolerance, self._watch
                table = table.chosen(~disturbed(apart, table, *args))
            tables.append((table, one.steps))
        held = [table for table, _ in tables]
        exact = None if exact is None else _besides(exact, held)
        plan, match = _kept(held, exact, self._overlaps, self._ask)
        return Found(Source(roster, recordings, list(columns), tables, exact), plan, match)


def _besides(exact: Exact, tables: list[Table]) -> Exact:
    """Return the exact hits where no match that costs nothing begins."""
    free = [table.chosen(table.cost == 0) for table in tables]
    begun = np.concatenate([table.capture * LIFTED + table.low for table in free])
    own = exact.place * LIFTED + exact.low
    return exact.arranged(np.flatnonzero(~np.isin(own, begun)).tolist())


def _kept(
    tables: list[Table], exact: Exact | None, overlaps: str, ask: Ask
) -> tuple[IntArray, IntArray]:
    """Return which matches are shown, by capture, start and end: of which table, and which."""
    leads = [(table.lines[0], table.places[:, 0]) for table in tables]
    parts = [line.net.part for (line, _), _ in leads]
    sets = [
        (it.capture, it.low, it.high, it.cost, found.first[places], parts.index(line.net.part))
        for it, ((line, found), places) in zip(tables, leads, strict=True)
    ]
    if exact is not None:
        places = np.arange(len(exact))
        sets.append((exact.place, exact.low, exact.high, 0 * places, places, len(parts)))
    match = np.concatenate([np.arange(len(it[0])) for it in sets])
    plan, part = (
        np.repeat(of_each, [len(it[0]) for it in sets])
        for of_each in (np.arange(len(sets)), [it[5] for it in sets])
    )
    capture, low, high, cost, first = (
        np.concatenate([it[number] for it in sets]) for number in range(5)
    )
    once = best_of_each((part, first), (cost, high, -low)) if len(sets) > 1 else match
    if overlaps == "none":
        rank = np.empty(len(once), np.int64)
        rank[np.lexsort((-low[once], high[once], cost[once]))] = np.arange(len(once))
        once = once[staying(capture[once], low[once], high[once], rank, ask)]
    order = once[np.lexsort((high[once], low[once], capture[once]))]
    return plan[order], match[order]


PATIENCE = 1 << 12
"""Matches after which it is asked again whether to go on."""

ROUNDS = 24
"""How often all knots are untied at once; what is left then is gone through one by one."""


def staying(
    capture: IntArray, low: IntArray, high: IntArray, rank: IntArray, ask: Ask
) -> BoolArray:
    """Return which matches stay if the best is taken first, and what overlaps it is left: (H,).

    `rank` tells which is the better: all different, smaller is better.
    """
    kept = np.zeros(len(low), np.bool_)
    begin, end = capture * LIFTED + low, capture * LIFTED + high
    left = np.argsort(begin, kind="stable")
    for _ in range(ROUNDS):
        if not len(left):
            return kept
        ask()
        # of what hangs together by overlaps the best one stays, which cuts it apart
        behind = np.maximum.accumulate(end[left])
        new = np.ones(len(left), np.bool_)
        new[1:] = begin[left[1:]] >= behind[:-1]
        first = np.flatnonzero(new)
        sizes = np.diff(np.append(first, len(left)))
        best = np.repeat(np.minimum.reduceat(rank[left], first), sizes)
        stays = left[rank[left] == best]
        kept[stays] = True
        apart = (end[left] <= np.repeat(begin[stays], sizes)) | (
            begin[left] >= np.repeat(end[stays], sizes)
        )
        left = left[apart]
    _one_by_one(kept, begin, end, left[np.argsort(rank[left])], ask)
    return kept


def _one_by_one(kept: BoolArray, begin: IntArray, end: IntArray, order: IntArray, ask: Ask) -> None:
    """Mark what stays of matches in order of their rank, which overlap nothing marked yet."""
    ends: list[int] = []
    begins: list[int] = []
    for number, index in enumerate(order.tolist()):
        if not number % PATIENCE:
            ask()
        low, high = int(begin[index]), int(end[index])
        place = bisect_left(ends, low + 1)
        if place == len(begins) or begins[place] >= high:
            begins.insert(place, low)
            ends.insert(place, high)
            kept[index] = True
