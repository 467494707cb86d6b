"""Finds hits that nearly match a query."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property, partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import LanindexError, UsageError
from lanindex.model import Hit, Span, Symbol
from lanindex.model.columns import Columns, Roster
from lanindex.search.fuzzy.costs import BUCKETS, UNIT, Allowance
from lanindex.search.fuzzy.follow import NO_MATCHES, Line, Matches, joined
from lanindex.search.fuzzy.join import Plan, fits
from lanindex.search.hits import Hits
from lanindex.search.language.query import Bracket, Choice, Item, Lines, Query
from lanindex.search.language.query import Line as Steps
from lanindex.search.language.times import TOLERANCE
from lanindex.search.match.arrays import (
    FAR,
    AnyArray,
    IntArray,
    best_of_each,
    limited_to,
    once,
)
from lanindex.search.match.batch import Batch, split
from lanindex.search.match.finder import MOST_ROWS, Finder, Recordings, Watch
from lanindex.search.match.hits import ExactHits, staying
from lanindex.search.plan import plan

CLEAR = (14, 12, 8)  # margins, in steps, down to which the best hits are looked for in turn
MORE = 4  # captures that are tried at first for each hit that is wanted

Result = TypeVar("Result")


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
    memory: int | None = None,
    refused: list[LanindexError] | None = None,
) -> FuzzyHits:
    """Find what is nearly a pattern; a `UsageError` where the pattern says what has no edits.

    The parameters are those of `lanindex.search.match.Finder` and its `find`, but that overlaps
    ``none`` means the match that differs least of those that share frames. Hits come by capture,
    start and end, where they are not the best. Their fit is the smallest margin of the symbols that
    match without an edit, lowered in proportion to the edits.
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
    for number, net in enumerate(net for one in plans for net in one.nets):
        net.number = number

    def finder(query: Query) -> Finder:
        own = {part: columns[part] for part in query.parts}
        return Finder(query, roster, own, recordings, tolerance, memory)

    search = _Search(finder, finder(query), plans, len(roster), columns, overlaps, watch)
    with limited_to(memory):
        if any(one.leaps for one in plans):
            search.exact = search.exactly(query)
            found = search.found()
            found = found if best is None else found.by_fit(best)[:best]
        else:
            found = search.found() if best is None else search.best(best)
    errors = [error for _, error in sorted(search.refused.items())]
    if refused is not None:
        refused += errors
    elif errors:
        raise errors[0]
    return found


def _opened(pattern: Choice) -> Choice:
    """Return a pattern without brackets around all of it, such as a pasted score has."""
    opened: list[Lines] = []
    for lines in pattern.alternatives:
        unit = lines.first.items[0].unit
        if isinstance(unit, Bracket) and lines.first == Steps((Item(unit),)):
            opened += [
                Lines(inner.first, (*inner.others, *lines.others))
                for inner in _opened(unit.pattern).alternatives
            ]
        else:
            opened.append(lines)
    return Choice(tuple(opened))


@dataclass
class _Search:
    """A search for some plans; `finder` holds the captures, `exact` are exact hits to add."""

    finder_of: Callable[[Query], Finder]
    finder: Finder
    plans: list[Plan]
    captures: int
    columns: Mapping[str, Columns]
    overlaps: str
    watch: Watch | None
    exact: ExactHits | None = None
    refused: dict[int, LanindexError] = field(default_factory=dict)
    done: int = 0

    @cached_property
    def lines(self) -> list[tuple[Line, int]]:
        """All lines by their numbers, each with how many steps its plan has."""
        plans = [one.within(self.columns, one.most) for one in self.plans]
        return [(line, one.steps) for one in plans for sides in one.lines for line in sides]

    def exactly(self, query: Query, among: IntArray | None = None) -> ExactHits:
        """Return all exact hits, in some captures; None: in all."""
        finder = self.finder_of(query)
        found = finder.find("all", self.watch, refused=[], among=among)
        self.refused |= finder.refused
        return found

    def found(self) -> FuzzyHits:
        """Return all hits."""
        return self._among(self._within(BUCKETS))

    def best(self, number: int) -> FuzzyHits:
        """Return so many hits that fit best, the clearest first.

        The clearest are looked for first, in the captures alone that can have such; where there are
        enough of them, no other can be among the best.
        """
        for clear in CLEAR:
            plans, bounds = self._within(BUCKETS - clear, clear), np.zeros(self.captures)
            fitting = self._in_batches(lambda one, batch: one.bounds(batch, self.ask), plans)
            for places, most in fitting:
                bounds[places] = np.max(most, axis=0)
            order = np.flatnonzero(bounds)
            order, many = order[np.argsort(-bounds[order], kind="stable")], MORE * number
            while len(order):
                some, rest = np.sort(order[:many]), bounds[order[many:]]
                found = self._among(self._within(BUCKETS - clear), some).by_fit()
                least = np.nextafter(rest[0], 1) if len(rest) else clear / BUCKETS
                if (found.fit >= least).sum() >= number:
                    return found[:number]
                order, many = order if len(rest) else order[:0], MORE * many
        return self.found().by_fit()[:number]

    def _within(self, most: int, clear: int = 0) -> list[Plan]:
        """Return the plans for matches that fit well enough, in steps of a margin less than 1."""
        limit = UNIT * most // BUCKETS
        return [it.within(self.columns, it.steps * limit, clear) for it in self.plans]

    def _in_batches(
        self,
        work: Callable[[Plan, Batch], Result],
        plans: list[Plan],
        places: IntArray | None = None,
    ) -> Iterator[tuple[IntArray, list[Result]]]:
        """Yield the places of a batch of captures, and what work makes of each plan there.

        They are some captures, or all that may match; one that is too much alone is refused.
        """
        if places is None:
            places = np.flatnonzero(np.any([one.possible() for one in plans], axis=0))

        def of_each(batch: IntArray, some: IntArray) -> list[Result]:
            self.done = int(batch[some[0]])
            self.ask()
            own = self.finder.batch(batch[some])
            return [work(one, own) for one in plans]

        for batch in split(self.columns.values(), places, MOST_ROWS):
            for some, found in self.finder.in_parts(partial(of_each, batch), batch):
                if isinstance(found, LanindexError):
                    self.refused[int(batch[some[0]])] = found
                else:
                    yield batch[some], found

    def ask(self) -> None:
        """Ask whether to go on."""
        if self.watch:
            self.watch(self.done, self.captures)

    def _among(self, plans: list[Plan], places: IntArray | None = None) -> FuzzyHits:
        """Return all hits in some captures; None: in all."""
        batches = self._in_batches(
            lambda one, batch: one.matches(batch, self.exactly, self.ask), plans, places
        )
        found = joined([NO_MATCHES, *(self._hits(plans, *it) for it in batches)])
        return FuzzyHits(self, found.at(~np.isin(found.capture, list(self.refused))))

    def _hits(self, plans: list[Plan], places: IntArray, sets: list[Matches]) -> Matches:
        """Return the hits among the matches of plans in a batch, by capture, start and end."""
        sets = [it._replace(capture=places[it.capture]) for it in sets]
        if self.exact is not None:
            sets.append(self._besides(self.exact, joined(sets), places))
        found = joined(sets)
        if len(sets) > 1:
            parts = [one.sides[0][0].part for one in plans]
            of_each = [*map(parts.index, parts), len(parts)][: len(sets)]
            part = np.repeat(of_each, [len(it.cost) for it in sets])
            keys = part, found.capture, found.taken[:, 0, 1]
            found = found.at(best_of_each(keys, (found.cost, found.high, -found.low)))
        if self.overlaps == "none":
            rank = np.empty(len(found.cost), np.int64)
            rank[np.lexsort((-found.low, found.high, found.cost))] = np.arange(len(rank))
            found = found.at(staying(found.capture, found.low, found.high, rank, self.ask))
        return found.at(np.lexsort((found.high, found.low, found.capture)))

    def _besides(self, exact: ExactHits, found: Matches, places: IntArray) -> Matches:
        """Return the exact hits of some captures where no match that costs nothing begins."""
        begun = (found.capture * FAR + found.low)[found.cost == 0]
        own = np.isin(exact.place, places) & ~np.isin(exact.place * FAR + exact.low, begun)
        here = np.flatnonzero(own)
        taken = np.full((len(here), 1, 5), len(self.lines))
        taken[:, 0, 1] = here  # the number behind all lines, and for a first row the place
        frames = exact.place[here], exact.low[here], exact.high[here]
        return Matches(*frames, 0 * here, 0 * here, taken)


class FuzzyHits(Hits):
    """The hits of a search as columns; each is made an object when it is asked for."""

    def __init__(self, search: _Search, matches: Matches) -> None:
        super().__init__(search.finder, matches.capture, matches.low, matches.high)
        self._search, self._matches = search, matches

    @cached_property
    def fit(self) -> NDArray[np.float64]:
        """The smallest margin of symbols without an edit, lowered in proportion to the edits."""
        steps, found = np.array([*(it for _, it in self._search.lines), 1]), self._matches
        fit: NDArray[np.float64] = fits(found.cost, found.blur, steps[found.taken[:, 0, 0]])
        own, exact = self._exactly()
        fit[own] = exact.clear() if exact else 0
        return fit

    def clear(self) -> NDArray[np.float64]:
        """Return how clear each hit is, (H,) from 0 to 1."""
        return self.fit

    def by_fit(self, most: int | None = None) -> FuzzyHits:
        """Return the same hits, the clearest first; as `Hits.by_fit`."""
        own, exact = self._exactly()
        if not exact or most is None or most >= len(own):
            return super().by_fit()
        rest = np.delete(own, exact.clearest(most))  # of these nothing is made
        likely = np.delete(np.arange(len(self)), rest)
        likely = likely[np.argsort(-self._some(likely).fit, kind="stable")]
        return self.at(np.append(likely, rest))

    def _exactly(self) -> tuple[IntArray, ExactHits | None]:
        """Return which hits were found exactly, by place, and as such."""
        number, place = self._matches.taken[:, 0, :2].T
        own, exact = np.flatnonzero(number == len(self._search.lines)), self._search.exact
        return own, exact.arranged(place[own].tolist()) if exact else None

    def _some(self, chosen: AnyArray | slice) -> FuzzyHits:
        return FuzzyHits(self._search, self._matches.at(chosen))

    def _hits(self, indices: Sequence[int]) -> list[Hit]:
        lines, finder, exact = self._search.lines, self._search.finder, self._search.exact
        places = once(self.place[list(indices)])
        if not finder.fetched.keys() >= {*places.tolist()}:
            finder.fetch(places.tolist())
        batch, hits = finder.batch(places), list[Hit]()
        listed: dict[tuple[int, str], list[Symbol]] = {}
        for index in indices:
            taken = self._matches.taken[index].tolist()
            if exact and taken[0][0] == len(lines):
                hits.append(exact[taken[0][1]])
                continue
            place, matched = int(self.place[index]), []
            capture, tracks = finder.fetched[place]
            for number, first, last, *_ in (it for it in taken if it[0] >= 0):
                line, part = lines[number][0], lines[number][0].net.part
                if (place, part) not in listed:
                    listed[place, part] = tracks[part].listed()
                rows = line.rows(batch, int(np.searchsorted(places, place)), first, last)
                matched.append(tuple(listed[place, part][row] for row, _ in rows))
            span = Span(int(self.low[index]), int(self.high[index]))
            hits.append(Hit(capture, span, float(self.fit[index]), tuple(matched)))
        return hits
