"""Finds hits that nearly match a query: lines beside each other, the best of overlapping matches.

Beside each match of the leading line stands the cheapest match of each other line; their costs are
added. Lines that must not happen have no edits: they are searched for exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import LanindexError, UsageError
from lanindex.model import Hit, Span, Symbol
from lanindex.model.columns import THOUSANDTHS, Columns
from lanindex.search.fuzzy.follow import (
    BUCKETS,
    NO_MATCHES,
    UNIT,
    Allowance,
    FuzzyLine,
    FuzzyMatches,
    Net,
    joined,
    nets_of,
)
from lanindex.search.hits import Hits
from lanindex.search.language.query import (
    Beside,
    Bracket,
    Choice,
    Item,
    Line,
    Lines,
    Query,
    query_of,
)
from lanindex.search.limits import running, tick
from lanindex.search.match import relations
from lanindex.search.match.arrays import (
    FAR,
    AnyArray,
    BoolArray,
    IntArray,
    best_of_each,
    in_pieces,
    once,
    smallest_in,
)
from lanindex.search.match.batch import Batch, split
from lanindex.search.match.finder import MOST_ROWS, Finder, Watch
from lanindex.search.match.hits import ExactHits, staying
from lanindex.search.match.relations import RELATIONS, Margins, SpanIndex, Spans, margins_of
from lanindex.search.plan import NEGATIONS, Companion, Program, plan

CLEAR = (14, 12, 8)  # margins, in steps, down to which the best hits are looked for in turn
MORE = 4  # captures that are tried at first for each hit that is wanted

NOBODY = 1 << 62  # the place of a match where there is none

ExactSearch = Callable[[Query, IntArray], ExactHits]
"""Searches exactly, in some captures of the roster."""

Result = TypeVar("Result")


def find(
    finder: Finder,
    allowance: Allowance,
    overlaps: str = "none",
    watch: Watch | None = None,
    best: int | None = None,
    refused: list[LanindexError] | None = None,
) -> FuzzyHits:
    """Find what is nearly the query of a finder; a `UsageError` where that has no edits.

    The other parameters are those of `Finder.find`, but that overlaps ``none`` means the match that
    differs least of those that share frames. Hits come by capture, start and end, where they are
    not the best. Their fit is the smallest margin of the symbols that match without an edit,
    lowered in proportion to the edits.
    """
    query = finder.query
    if query.rhythm or query.where:
        raise UsageError(
            'a fuzzy search cannot count edits in "where" and "rhythm"',
            remedy="Leave them out, or search without --fuzzy.",
        )
    opened = [lines for pattern in query.patterns for lines in _opened(pattern).alternatives]
    plans = [
        FuzzyPlan.of(program, lines, allowance)
        for lines in dict.fromkeys(opened)
        for program in plan(replace(query_of(lines), near=query.near))
    ]
    for number, net in enumerate(net for one in plans for net in one.nets):
        net.number = number

    search = _Search(finder, plans, overlaps, watch)
    with running(finder.memory, search.tell):
        if any(one.branches for one in plans):
            search.exact_hits = search.find_exactly(query)
            found = search.all_hits()
            found = found if best is None else found.by_fit(best)[:best]
        else:
            found = search.all_hits() if best is None else search.best(best)
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
        if isinstance(unit, Bracket) and lines.first == Line((Item(unit),)):
            opened += [
                Lines(inner.first, (*inner.others, *lines.others))
                for inner in _opened(unit.pattern).alternatives
            ]
        else:
            opened.append(lines)
    return Choice(tuple(opened))


@dataclass
class _Search:
    """A search for some plans; `finder` holds the captures, `exact_hits` are exact hits to add."""

    finder: Finder
    plans: list[FuzzyPlan]
    overlaps: str
    watch: Watch | None
    exact_hits: ExactHits | None = None
    refused: dict[int, LanindexError] = field(default_factory=dict)
    done: int = 0

    @cached_property
    def lines(self) -> list[tuple[FuzzyLine, int]]:
        """All lines by their numbers, each with how many steps its plan has."""
        plans = [one.within(self.finder.columns, one.most) for one in self.plans]
        return [(line, one.steps) for one in plans for sides in one.lines for line in sides]

    def find_exactly(self, query: Query, among: IntArray | None = None) -> ExactHits:
        """Return all exact hits, in some captures; None: in all."""
        finder = self.finder.of(query)
        found = finder.find("all", self.watch, refused=[], among=among)
        self.refused |= finder.refused
        return found

    def all_hits(self) -> FuzzyHits:
        """Return all hits."""
        return self._hits_in(self._plans_within(BUCKETS))

    def best(self, number: int) -> FuzzyHits:
        """Return so many hits that fit best, the clearest first.

        The clearest are looked for first, in the captures that can have such: at first in a few for
        each hit wanted, then in those whose bound reaches the last of the best so far.
        """
        for clear in CLEAR:
            plans = self._plans_within(BUCKETS - clear, clear)
            bounds = np.zeros(len(self.finder.roster))
            fitting = self._in_batches(lambda one, batch: one.bounds(batch), plans)
            for places, most in fitting:
                bounds[places] = np.max(most, axis=0)
            order = np.flatnonzero(bounds)
            order = order[np.argsort(-bounds[order], kind="stable")]
            plans, hits = self._plans_within(BUCKETS - clear), FuzzyHits(self, NO_MATCHES)
            least, searched, within = 0.0, 0, len(order)
            while within:  # captures that may hold one of the best
                some = order[searched : searched + min(within, searched or MORE * number)]
                hits = hits.with_those_of(self._hits_in(plans, np.sort(some)))
                best, searched = hits.by_fit()[:number], searched + len(some)
                rest = order[searched:]
                within = len(rest)
                if len(best) == number:
                    least, last = float(best.fit[-1]), best.place[-1]
                    ahead = (bounds[rest] > least) | (bounds[rest] == least) & (rest < last)
                    within = int(ahead.sum())
            if least >= clear / BUCKETS:
                return best
        return self.all_hits().by_fit()[:number]

    def _plans_within(self, most: int, clear: int = 0) -> list[FuzzyPlan]:
        """Return the plans for matches that fit well enough, in steps of a margin less than 1."""
        limit = UNIT * most // BUCKETS
        return [it.within(self.finder.columns, it.steps * limit, clear) for it in self.plans]

    def _in_batches(
        self,
        work: Callable[[FuzzyPlan, Batch], Result],
        plans: list[FuzzyPlan],
        places: IntArray | None = None,
    ) -> Iterator[tuple[IntArray, list[Result]]]:
        """Yield the places of a batch of captures, and what work makes of each plan there.

        They are some captures, or all that may match; one that is too much alone is refused.
        """
        if places is None:
            places = np.flatnonzero(np.any([one.possible() for one in plans], axis=0))

        def of_each(batch: IntArray, part: IntArray) -> list[Result]:
            self.done = int(batch[part[0]])
            tick()
            part_batch = self.finder.batch(batch[part])
            return [work(one, part_batch) for one in plans]

        for batch in split(self.finder.columns.values(), places, MOST_ROWS):
            for part, results in self.finder.in_parts(partial(of_each, batch), batch):
                if isinstance(results, LanindexError):
                    self.refused[int(batch[part[0]])] = results
                else:
                    yield batch[part], results

    def tell(self) -> None:
        """Tell how far the search is."""
        if self.watch:
            self.watch(self.done, len(self.finder.roster))

    def _hits_in(self, plans: list[FuzzyPlan], places: IntArray | None = None) -> FuzzyHits:
        """Return all hits in some captures; None: in all."""
        batches = self._in_batches(
            lambda one, batch: one.matches(batch, self.find_exactly), plans, places
        )
        matches = joined([NO_MATCHES, *(self._hits(plans, *it) for it in batches)])
        return FuzzyHits(self, matches.at(~np.isin(matches.capture, list(self.refused))))

    def _hits(
        self, plans: list[FuzzyPlan], places: IntArray, sets: list[FuzzyMatches]
    ) -> FuzzyMatches:
        """Return the hits among the matches of plans in a batch, by capture, start and end."""
        sets = [it._replace(capture=places[it.capture]) for it in sets]
        if self.exact_hits is not None:
            sets.append(self._exact_matches(self.exact_hits, joined(sets), places))
        matches = joined(sets)
        if len(sets) > 1:
            parts = [one.sides[0][0].part for one in plans]
            of_each = [*map(parts.index, parts), len(parts)][: len(sets)]
            part = np.repeat(of_each, [len(it.cost) for it in sets])
            keys = part, matches.capture, matches.line_rows[:, 0, 1]
            matches = matches.at(best_of_each(keys, (matches.cost, matches.high, -matches.low)))
        if self.overlaps == "none":
            rank = np.empty(len(matches.cost), np.int64)
            rank[np.lexsort((-matches.low, matches.high, matches.cost))] = np.arange(len(rank))
            matches = matches.at(staying(matches.capture, matches.low, matches.high, rank))
        return matches.at(np.lexsort((matches.high, matches.low, matches.capture)))

    def _exact_matches(
        self, exact: ExactHits, matches: FuzzyMatches, places: IntArray
    ) -> FuzzyMatches:
        """Return the exact hits of some captures where no match that costs nothing begins."""
        begun = (matches.capture * FAR + matches.low)[matches.cost == 0]
        own = np.isin(exact.place, places) & ~np.isin(exact.place * FAR + exact.low, begun)
        indices = np.flatnonzero(own)
        line_rows = np.full((len(indices), 1, 5), len(self.lines))
        line_rows[:, 0, 1] = indices  # the number behind all lines, and for a first row the place
        frames = exact.place[indices], exact.low[indices], exact.high[indices]
        return FuzzyMatches(*frames, 0 * indices, 0 * indices, line_rows)


class FuzzyHits(Hits):
    """The hits of a search as columns; each is made an object when it is asked for."""

    def __init__(self, search: _Search, matches: FuzzyMatches) -> None:
        super().__init__(search.finder, matches.capture, matches.low, matches.high)
        self._search, self._matches = search, matches

    @cached_property
    def fit(self) -> NDArray[np.float64]:
        """The smallest margin of symbols without an edit, lowered in proportion to the edits."""
        steps, found = np.array([*(it for _, it in self._search.lines), 1]), self._matches
        fit: NDArray[np.float64] = fits(found.cost, found.blur, steps[found.line_rows[:, 0, 0]])
        own, exact = self._exact_hits()
        fit[own] = exact.clear() if exact else 0
        return fit

    def clear(self) -> NDArray[np.float64]:
        """Return how clear each hit is, (H,) from 0 to 1."""
        return self.fit

    def by_fit(self, most: int | None = None) -> FuzzyHits:
        """Return the same hits, the clearest first; as `Hits.by_fit`."""
        own, exact = self._exact_hits()
        if not exact or most is None or most >= len(own):
            return super().by_fit()
        rest = np.delete(own, exact.clearest(most))  # of these nothing is made
        likely = np.delete(np.arange(len(self)), rest)
        likely = likely[np.argsort(-self._subset(likely).fit, kind="stable")]
        return self.at(np.append(likely, rest))

    def with_those_of(self, others: FuzzyHits) -> FuzzyHits:
        """Return these hits and those of other captures, by capture."""
        matches = joined((self._matches, others._matches))
        order = np.argsort(matches.capture, kind="stable")
        return FuzzyHits(self._search, matches.at(order))

    def _exact_hits(self) -> tuple[IntArray, ExactHits | None]:
        """Return which hits were found exactly, by place, and as such."""
        number, place = self._matches.line_rows[:, 0, :2].T
        own, exact = np.flatnonzero(number == len(self._search.lines)), self._search.exact_hits
        return own, exact.arranged(place[own].tolist()) if exact else None

    def _subset(self, rows: AnyArray | slice) -> FuzzyHits:
        return FuzzyHits(self._search, self._matches.at(rows))

    def _hits(self, indices: Sequence[int]) -> list[Hit]:
        lines, finder, exact = self._search.lines, self._search.finder, self._search.exact_hits
        places = once(self.place[list(indices)])
        if not finder.fetched.keys() >= {*places.tolist()}:
            finder.fetch(places.tolist())
        batch, hits = finder.batch(places), list[Hit]()
        listed: dict[tuple[int, str], list[Symbol]] = {}
        for index in indices:
            line_rows = self._matches.line_rows[index].tolist()
            if exact and line_rows[0][0] == len(lines):
                hits.append(exact[line_rows[0][1]])
                continue
            place, matched = int(self.place[index]), []
            capture, tracks = finder.fetched[place]
            for number, first, last, *_ in (it for it in line_rows if it[0] >= 0):
                line, part = lines[number][0], lines[number][0].net.part
                if (place, part) not in listed:
                    listed[place, part] = tracks[part].listed()
                rows = line.rows(batch, int(np.searchsorted(places, place)), first, last)
                matched.append(tuple(listed[place, part][row] for row, _ in rows))
            span = Span(int(self.low[index]), int(self.high[index]))
            hits.append(Hit(capture, span, float(self.fit[index]), tuple(matched)))
        return hits


class FuzzyPlan(NamedTuple):
    """What a leading line asks for."""

    sides: list[list[Net]]  # the leading line, and those that must lie beside it, one net a side
    beside: list[Companion]  # how these lie
    forbidden: list[Beside]  # lines that must not happen
    steps: int  # how many the lines have
    most: int  # what a match may cost, in parts of an edit
    lines: Sequence[list[FuzzyLine]] = ()  # as `sides`, where they are searched for

    @property
    def nets(self) -> list[Net]:
        """The nets of all lines."""
        return [net for nets in self.sides for net in nets]

    @property
    def branches(self) -> bool:
        """Whether another end than the nearest may go with what is asked for beside it."""
        return bool(self.beside or self.forbidden) and any(net.branches for net in self.nets)

    @classmethod
    def of(cls, program: Program, lines: Lines, allowance: Allowance) -> FuzzyPlan:
        """Return the plan of a program of some lines; a `UsageError` where that has no edits."""
        lead, *halves = nets_of(program)
        sides, beside = [[half] for half in halves], [Companion("with", ())] * len(halves)
        for it in program.outermost.companions:
            if it.relation not in NEGATIONS:
                nets = [list(nets) for nets in zip(*map(nets_of, it.programs), strict=True)]
                sides, beside = sides + nets, beside + [it] * len(nets)
        forbidden = [it for it in lines.others if it.relation in NEGATIONS]
        sides = [[lead], *sides]
        steps = sum(max(len(net.states) for net in nets) for nets in sides)
        return cls(sides, beside, forbidden, steps, allowance.of(steps))

    def within(self, columns: Mapping[str, Columns], most: int, clear: int = 0) -> FuzzyPlan:
        """Return the plan for matches that cost no more than `most`; `clear` as of `FuzzyLine`."""
        most = min(self.most, most)
        lines = [
            [FuzzyLine(it, columns[it.part], most, clear) for it in nets] for nets in self.sides
        ]
        return self._replace(most=most, lines=lines)

    def possible(self) -> BoolArray:
        """Return in which captures all lines may match, (captures,)."""
        sides = [np.any([line.possible() for line in sides], axis=0) for sides in self.lines]
        found: BoolArray = np.all(sides, axis=0)
        return found

    def bounds(self, batch: Batch) -> AnyArray:
        """Return how well a match in each capture fits at most, (captures,); 0: there is none."""
        least = np.ones(len(batch))
        for it in self._line_matches(batch):
            best = np.zeros(len(batch))
            np.maximum.at(best, it.capture, fits(it.cost, it.blur, self.steps))
            least = np.minimum(least, best)
        return least

    def matches(self, batch: Batch, find_exactly: ExactSearch) -> FuzzyMatches:
        """Return what matches all lines, one for each row where the leading one begins."""
        lead, *others = self._line_matches(batch)
        for companion, nets, other in zip(self.beside, self.sides[1:], others, strict=True):
            tick()
            margins = margins_of(batch, companion)
            if companion.relation == "with":  # no two movements of one part share a frame
                same = [net.number for net in nets if net.part == self.sides[0][0].part]
                near = margins.most[other.capture] > 0
                other = other.at(near | ~np.isin(other.line_rows[:, 0, 0], same))
            lead = self._beside(companion.relation, lead, other, margins)
        for forbidden in self.forbidden:
            lead = lead.at(~self._disturbed(forbidden, lead, batch, find_exactly))
        return lead

    def _line_matches(self, batch: Batch) -> list[FuzzyMatches]:
        """Return the matches of all lines, of both sides together."""
        return [joined([line.matches(batch) for line in sides]) for sides in self.lines]

    def _beside(
        self, relation: str, lead: FuzzyMatches, other: FuzzyMatches, margins: Margins
    ) -> FuzzyMatches:
        """Return the leading matches with the cheapest other one that stands beside each."""
        # of equally cheap ones the first side, and there the one that ends first
        other = other.at(np.lexsort((other.high, other.line_rows[:, 0, 0], other.cost)))
        lines = _spans(lead.capture, *lead.line_rows[:, 0, 3:].T)
        best = _first(relation, lines, _spans(*other[:3]), margins)
        kept = np.flatnonzero(best < NOBODY)
        kept = kept[lead.cost[kept] + other.cost[best[kept]] <= self.most]
        lead, other = lead.at(kept), other.at(best[kept])
        low, high = lead.low, lead.high
        if RELATIONS[relation].adds_frames:
            low, high = np.minimum(low, other.low), np.maximum(high, other.high)
        cost, blur = lead.cost + other.cost, np.maximum(lead.blur, other.blur)
        line_rows = np.concatenate((lead.line_rows, other.line_rows), axis=1)
        return FuzzyMatches(lead.capture, low, high, cost, blur, line_rows)

    def _disturbed(
        self,
        forbidden: Beside,
        matches: FuzzyMatches,
        batch: Batch,
        find_exactly: ExactSearch,
    ) -> BoolArray:
        """Return which matches have a match of a `without` line beside them, (N,) bool.

        Matches of that line that share a symbol with them do not count.
        """
        query = query_of(forbidden.line)
        exact = find_exactly(query, batch.places[once(matches.capture)])
        parts = {net.number: net.part for net in self.nets}
        shares = not query.parts.isdisjoint(parts.values())
        others = _spans(np.searchsorted(batch.places, exact.place), exact.low, exact.high)
        begin, end = matches.line_rows[:, :, 3].min(axis=1), matches.line_rows[:, :, 4].max(axis=1)
        disturbed, pairs = np.zeros(len(begin), np.bool_), [np.empty((2, 0), np.int64)]
        margins = margins_of(batch, Companion(forbidden.relation, (), forbidden.within))
        for match, hit in _pairs(
            forbidden.relation, _spans(*matches[:3]), SpanIndex(others), margins
        ):
            tick()
            # what a match is made of lies in its frames: any hit outside of them disturbs it
            near = shares & (exact.low[hit] <= end[match]) & (exact.high[hit] >= begin[match])
            disturbed[match[~near]] = True
            pairs.append(np.stack((match, hit))[:, near & ~disturbed[match]])
        match, hit = np.concatenate(pairs, axis=1)
        wanted = once(hit[~disturbed[match]]).tolist()
        symbols = {}
        for index, one in zip(wanted, exact.arranged(wanted), strict=True):
            tick()
            symbols[index] = [(it.part, it.ordinal) for it in one.symbols]
        for one, index in zip(match.tolist(), hit.tolist(), strict=True):
            disturbed[one] = disturbed[one] or not any(
                parts[net] == part and first <= row <= last
                for net, first, last, *_ in matches.line_rows[one].tolist()
                for part, row in symbols[index]
            )
        return disturbed


def fits(cost: IntArray, blur: IntArray, steps: AnyArray | int) -> AnyArray:
    """Return how well matches fit, 0 to 1, of plans with so many steps."""
    found: AnyArray = (THOUSANDTHS - blur) / THOUSANDTHS
    return found * np.maximum(1 - cost / UNIT / steps, 0)


def _spans(capture: IntArray, start: IntArray, until: IntArray) -> Spans:
    return Spans(capture, start, until, start, until, np.zeros(len(capture), np.bool_))


def _pairs(
    relation: str, lines: Spans, others: SpanIndex, margins: Margins
) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield all pairs of a line and another one beside it, by their places, some at a time."""
    first, last = relations.candidates(relation, lines, others, margins)
    for some in in_pieces(np.maximum(last - first, 0)):
        line, other = relations.pairs(relation, lines.at(some), others, margins)
        yield some[line], other


def _first(relation: str, lines: Spans, spans: Spans, margins: Margins) -> IntArray:
    """Return the first of some spans that stands beside each line, by place; or `NOBODY`."""
    others = SpanIndex(spans)
    if relation not in relations.BY_END + relations.BY_START or relation == "exactly with":
        found = np.full(len(lines), NOBODY)
        for line, other in _pairs(relation, lines, others, margins):
            np.minimum.at(found, line, other)
        return found
    order = others.order[others.by_end] if relation in relations.BY_END else others.order
    low, high = relations.candidates(relation, lines, others, margins)
    return smallest_in(order, low, high, NOBODY)
