"""Join with costs: beside each match of the leading line the cheapest match of each other line.

Their costs are added. Lines that must not happen have no edits: they are searched for exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from lanindex.model.columns import THOUSANDTHS, Columns
from lanindex.search.fuzzy.costs import UNIT, Allowance
from lanindex.search.fuzzy.follow import Ask, Line, Matches, Net, joined, nets_of
from lanindex.search.language.query import Beside, Choice, Lines, Query
from lanindex.search.match import arrays, relations
from lanindex.search.match.arrays import AnyArray, BoolArray, IntArray
from lanindex.search.match.batch import Batch
from lanindex.search.match.hits import ExactHits
from lanindex.search.match.relations import (
    BY_END,
    BY_START,
    RELATIONS,
    Margins,
    SpanIndex,
    Spans,
    margins_of,
)
from lanindex.search.plan import NEGATIONS, Companion, Program

NOBODY = 1 << 62  # the place of a match where there is none

Exactly = Callable[[Query, IntArray], ExactHits]  # searches exactly, in some captures of the roster


class Plan(NamedTuple):
    """What a leading line asks for."""

    sides: list[list[Net]]  # the leading line, and those that must lie beside it, one net a side
    beside: list[Companion]  # how these lie
    apart: list[Beside]  # lines that must not happen
    steps: int  # how many the lines have
    most: int  # what a match may cost, in parts of an edit
    lines: Sequence[list[Line]] = ()  # as `sides`, where they are searched for

    @property
    def nets(self) -> list[Net]:
        """The nets of all lines."""
        return [net for nets in self.sides for net in nets]

    @property
    def leaps(self) -> bool:
        """Whether another end than the nearest may go with what is asked for beside it."""
        return bool(self.beside or self.apart) and any(net.leaps for net in self.nets)

    @classmethod
    def of(cls, program: Program, lines: Lines, allowance: Allowance) -> Plan:
        """Return the plan of a program of some lines; a `UsageError` where that has no edits."""
        lead, *halves = nets_of(program)
        sides, beside = [[half] for half in halves], [Companion("with", ())] * len(halves)
        for it in program.whole.companions:
            if it.relation not in NEGATIONS:
                nets = [list(nets) for nets in zip(*map(nets_of, it.programs), strict=True)]
                sides, beside = sides + nets, beside + [it] * len(nets)
        apart = [it for it in lines.others if it.relation in NEGATIONS]
        sides = [[lead], *sides]
        steps = sum(max(len(net.states) for net in nets) for nets in sides)
        return cls(sides, beside, apart, steps, allowance.of(steps))

    def within(self, columns: Mapping[str, Columns], most: int, clear: int = 0) -> Plan:
        """Return the plan for matches that cost no more than `most`; `clear` as of `Line`."""
        most = min(self.most, most)
        lines = [[Line(it, columns[it.part], most, clear) for it in nets] for nets in self.sides]
        return self._replace(most=most, lines=lines)

    def possible(self) -> BoolArray:
        """Return in which captures all lines may match, (captures,)."""
        sides = [np.any([line.possible() for line in sides], axis=0) for sides in self.lines]
        found: BoolArray = np.all(sides, axis=0)
        return found

    def bounds(self, batch: Batch, ask: Ask) -> AnyArray:
        """Return how well a match in each capture fits at most, (captures,); 0: there is none."""
        least = np.ones(len(batch))
        for it in self._found(batch, ask):
            best = np.zeros(len(batch))
            np.maximum.at(best, it.capture, fits(it.cost, it.blur, self.steps))
            least = np.minimum(least, best)
        return least

    def matches(self, batch: Batch, exactly: Exactly, ask: Ask) -> Matches:
        """Return what matches all lines, one for each row where the leading one begins."""
        lead, *others = self._found(batch, ask)
        for companion, nets, other in zip(self.beside, self.sides[1:], others, strict=True):
            ask()
            margins = margins_of(batch, companion)
            if companion.relation == "with":  # no two movements of one part share a frame
                same = [net.number for net in nets if net.part == self.sides[0][0].part]
                near = margins.most[other.capture] > 0
                other = other.at(near | ~np.isin(other.taken[:, 0, 0], same))
            lead = self._beside(companion.relation, lead, other, margins)
        for apart in self.apart:
            lead = lead.at(~self._disturbed(apart, lead, batch, exactly, ask))
        return lead

    def _found(self, batch: Batch, ask: Ask) -> list[Matches]:
        """Return the matches of all lines, of both sides together."""
        return [joined([line.matches(batch, ask) for line in sides]) for sides in self.lines]

    def _beside(self, relation: str, lead: Matches, other: Matches, margins: Margins) -> Matches:
        """Return the leading matches with the cheapest other one that stands beside each."""
        # of equally cheap ones the first side, and there the one that ends first
        other = other.at(np.lexsort((other.high, other.taken[:, 0, 0], other.cost)))
        lines = _spans(lead.capture, *lead.taken[:, 0, 3:].T)
        best = _first(relation, lines, _spans(*other[:3]), margins)
        kept = np.flatnonzero(best < NOBODY)
        kept = kept[lead.cost[kept] + other.cost[best[kept]] <= self.most]
        lead, other = lead.at(kept), other.at(best[kept])
        low, high = lead.low, lead.high
        if RELATIONS[relation].adds_frames:
            low, high = np.minimum(low, other.low), np.maximum(high, other.high)
        cost, blur = lead.cost + other.cost, np.maximum(lead.blur, other.blur)
        taken = np.concatenate((lead.taken, other.taken), axis=1)
        return Matches(lead.capture, low, high, cost, blur, taken)

    def _disturbed(
        self, apart: Beside, found: Matches, batch: Batch, exactly: Exactly, ask: Ask
    ) -> BoolArray:
        """Return which matches have a match of a `without` line beside them, (N,) bool.

        Matches of that line that share a symbol with them do not count.
        """
        query = Query(Choice((Lines(apart.line),)))
        exact = exactly(query, batch.places[arrays.once(found.capture)])
        parts = {net.number: net.part for net in self.nets}
        shares = not query.parts.isdisjoint(parts.values())
        others = _spans(np.searchsorted(batch.places, exact.place), exact.low, exact.high)
        begin, end = found.taken[:, :, 3].min(axis=1), found.taken[:, :, 4].max(axis=1)
        disturbed, pairs = np.zeros(len(begin), np.bool_), [np.empty((2, 0), np.int64)]
        margins = margins_of(batch, Companion(apart.relation, (), apart.within))
        for match, hit in _pairs(apart.relation, _spans(*found[:3]), SpanIndex(others), margins):
            ask()
            # what a match is made of lies in its frames: any hit outside of them disturbs it
            near = shares & (exact.low[hit] <= end[match]) & (exact.high[hit] >= begin[match])
            disturbed[match[~near]] = True
            pairs.append(np.stack((match, hit))[:, near & ~disturbed[match]])
        match, hit = np.concatenate(pairs, axis=1)
        wanted = arrays.once(hit[~disturbed[match]]).tolist()
        symbols = {}
        for index, one in zip(wanted, exact.arranged(wanted), strict=True):
            ask()
            symbols[index] = [(it.part, it.ordinal) for it in one.symbols]
        for one, index in zip(match.tolist(), hit.tolist(), strict=True):
            disturbed[one] = disturbed[one] or not any(
                parts[net] == part and first <= row <= last
                for net, first, last, *_ in found.taken[one].tolist()
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
    for some in arrays.in_pieces(np.maximum(last - first, 0)):
        line, other = relations.pairs(relation, lines.at(some), others, margins)
        yield some[line], other


def _first(relation: str, lines: Spans, spans: Spans, margins: Margins) -> IntArray:
    """Return the first of some spans that stands beside each line, by place; or `NOBODY`."""
    others = SpanIndex(spans)
    if relation not in BY_END + BY_START or relation == "exactly with":
        found = np.full(len(lines), NOBODY)
        for line, other in _pairs(relation, lines, others, margins):
            np.minimum.at(found, line, other)
        return found
    order = others.order[others.by_end] if relation in BY_END else others.order
    low, high = relations.candidates(relation, lines, others, margins)
    return arrays.smallest_in(order, low, high, NOBODY)
