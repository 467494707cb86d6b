"""Joins matches of a line with matches of the lines beside it.

A match of a `without` or `never` line that shares a symbol with the hit does not count.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from lanindex.search.limits import check_budget
from lanindex.search.match import matches, relations
from lanindex.search.match.arrays import (
    FAR,
    MOST_AT_ONCE,
    BoolArray,
    IntArray,
    Table,
    in_pieces,
    once,
    spread,
    together,
)
from lanindex.search.match.context import Context
from lanindex.search.match.matches import NEVER, Claims, Nodes, distinct, hull_rank, united_columns
from lanindex.search.match.relations import (
    RELATIONS,
    EndBounds,
    Margins,
    SpanIndex,
    Spans,
    margins_of,
    smallest,
)
from lanindex.search.match.rewrites import enough_beside
from lanindex.search.plan import NEGATIONS, Companion, Group, Program


def unexcused(
    relation: str, lines: Spans, excusing: Claims, matches: Spans, claims: Claims, margins: Margins
) -> BoolArray:
    """Tell beside which lines there is a match that shares no symbol with the line, (N,) bool.

    There is one if more matches stand beside a line than share a symbol with it. How many may share
    one is told by binary search, which is enough for most lines: only the others list them.
    """
    limit = relations.limits(relation, lines, margins)
    base, behind = lines.capture * FAR, matches.capture * FAR
    starts, ends = np.sort(behind + matches.start), np.sort(behind + matches.until)
    beside = np.searchsorted(starts, base + limit.begin_last, "right")
    beside -= np.searchsorted(ends, base + limit.end_first)
    column, match = np.nonzero(claims.first < FAR)
    order = np.argsort(claims.first[column, match])
    column, match = column[order], match[order]
    begin, end = claims.first[column, match], claims.last[column, match]
    latest = np.maximum.accumulate(end)
    sharing = np.zeros(len(lines), np.int64)
    for first, last in zip(excusing.first, excusing.last, strict=True):
        sharing += np.searchsorted(begin, last, "right") - np.searchsorted(latest, first)
    excused = sharing.copy()
    unclear = np.flatnonzero((beside > 0) & (beside <= sharing))
    for some in in_pieces(sharing[unclear]):
        line = unclear[some]
        own, column = np.nonzero(excusing.first[:, line].T < FAR)
        first, last = excusing.first[column, line[own]], excusing.last[column, line[own]]
        low, high = np.searchsorted(latest, first), np.searchsorted(begin, last, "right")
        claim, place = spread(low, high)
        fits = end[place] >= first[claim]
        pairs = once(own[claim[fits]] * len(matches) + match[place[fits]])
        own, other = np.divmod(pairs, len(matches))
        fits = matches.start[other] <= limit.begin_last[line[own]]
        fits &= matches.until[other] >= limit.end_first[line[own]]
        fits &= matches.capture[other] == lines.capture[line[own]]
        excused[line] = np.bincount(own[fits], minlength=len(line))
    found: BoolArray = beside > excused
    return found


def by_line(pairs: IntArray, lines: int) -> IntArray:
    """Return what each line is paired with as columns, (most, lines), filled up with `FAR`."""
    pairs = pairs[:, np.lexsort(pairs[::-1])]
    counts = np.bincount(pairs[0], minlength=lines)
    most = int(counts.max(initial=0))
    check_budget(most * lines, 64)
    found = np.full((most, lines), FAR)
    begin = np.cumsum(counts) - counts
    found[np.arange(pairs.shape[1]) - begin[pairs[0]], pairs[0]] = pairs[1]
    return found


@dataclass(slots=True, eq=False)
class CompanionMatches(Table):
    """The matches of a line, of one side, that stands beside another."""

    lines: Spans
    claims: Claims  # these three as in `Matches`
    unmet: IntArray
    notes: IntArray
    node: IntArray  # (N,) int64: where they end
    end: IntArray  # (N,) int64: numbers in `Joins`

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.node)

    @property
    def free(self) -> bool:
        """Whether they remember nothing."""
        return not (self.claims or self.unmet.size) and int(self.notes.max(initial=-1)) < 0

    def keys(self) -> list[IntArray]:
        """Return the columns in which they differ for other lines."""
        lines = self.lines
        frames = [lines.capture, lines.start, lines.until, lines.low, lines.high]
        rest = [*self.claims.first, *self.claims.last, *self.unmet, *self.notes]
        return [*frames, lines.alone.astype(np.int64), *rest]


@dataclass(slots=True, eq=False)
class Hulls(Table):
    """Matches of lines together with what stands beside them."""

    line: IntArray  # (N,) int64: of which line
    low: IntArray  # (N,) int64 frames of the hull
    high: IntArray
    claims: Claims  # these four as in `Matches`
    unmet: IntArray
    notes: IntArray
    link: IntArray


class DistinctSpans(NamedTuple):
    """The different frames of lines that a relation compares: many matches share few of them."""

    spans: Spans  # of each place
    place: IntArray  # (N,) int64: by match, which of them; -1: none
    margins: Margins  # how near others must lie
    most: IntArray | None  # by when others have to end, for each place; None: any time will do

    def at(self, matches: IntArray) -> DistinctSpans:
        """Return where some matches stand."""
        if len(matches) == len(self.place):
            return self
        used, place = np.unique(self.place[matches], return_inverse=True)
        missing = int(len(used) > 0 and used[0] < 0)
        used = used[missing:]
        most = None if self.most is None else self.most[used]
        return DistinctSpans(self.spans.at(used), place - missing, self.margins, most)


@dataclass(eq=False)
class OtherLine:
    """A line beside another, of one side."""

    relation: str
    matches: CompanionMatches
    nodes: Nodes | None  # which match goes on in which, of a line that runs on as long as it can

    @cached_property
    def index(self) -> SpanIndex:
        """The matches by their frames."""
        return SpanIndex(self.matches.lines)

    def moving(self) -> OtherLine:
        """Return the same without starting positions alone."""
        return replace(self, matches=self.matches.at(~self.matches.lines.alone))

    def goes_on(self, line: IntArray, match: IntArray) -> BoolArray:
        """Tell, of pairs of a line and a match, which go on in another pair of the line."""
        assert self.nodes
        return self.nodes.behind(line, self.matches.node[match])


LineSearch = Callable[["Joiner", Program, str | None], tuple[CompanionMatches, Nodes | None]]
"""Returns the matches of a line with ends that are enough, and, of an open-ended one, its nodes."""


class Joiner:
    """Finds the lines beside others."""

    def __init__(self, context: Context, search: LineSearch) -> None:
        self.context, self._batch, self._search = context, context.batch, search
        self._others: dict[tuple[Program, str | None], tuple[CompanionMatches, Nodes | None]] = {}
        self._alone: dict[tuple[Program, ...], tuple[CompanionMatches, int]] = {}
        self._matches = matches.no_claims(0)

    def close(
        self,
        group: Group,
        lines: Spans,
        hulls: Hulls,
        *,
        outermost: bool,
        since: IntArray | None,
        most: IntArray | None,
    ) -> Hulls:
        """Return the hulls with which a group can close.

        `lines` are its own line as far as it has come, with one of `hulls` each; `outermost`: the
        group is all of a leading line. Claims matter `since` a frame of each line once it has
        closed. Hulls that end behind the frame `most` of their line may be left out.
        """
        needed = [it for it in group.companions if it.relation not in NEGATIONS]
        denied = [it for it in group.companions if it.relation in NEGATIONS]
        for companion in (*needed, *filter(self.context.rewrites.programs, denied)):
            if len(hulls.line):
                if companion.relation not in NEGATIONS:
                    last = since if companion is needed[-1] else None
                    hulls = self._with(
                        companion, lines, hulls, outermost=outermost, since=last, most=most
                    )
                    continue
                pieces = []
                for some in in_pieces(np.ones(len(hulls.line), np.int64)):
                    own = hulls.at(some)
                    pieces.append(self._without(companion, lines, own, outermost=outermost))
                hulls = together(pieces)
        return hulls

    def still_unmet(self, unmet: IntArray, claims: Claims) -> IntArray:
        """Return the forbidden matches that claims do not excuse yet, (M, N)."""
        if not unmet.size:
            return unmet[:0]
        left, (column, match) = unmet.copy(), np.nonzero(unmet < FAR)
        excusing = self.context.excusing(claims).at(match)
        excused = ~self._matches.at(unmet[column, match]).disjoint(excusing)
        left[column[excused], match[excused]] = FAR
        left = np.sort(left, axis=0)
        return left[: int((left < FAR).any(axis=1).sum())]

    def others(
        self, program: Program, companion: Companion
    ) -> tuple[CompanionMatches, Nodes | None]:
        """Return the matches of a line that stands beside another, as far as they matter.

        With them comes which goes on in which, of a line that runs on as long as it can.
        """
        end = enough_beside(program, companion)
        if (program, end) not in self._others:
            self._others[program, end] = self._search(self, program, end)
        return self._others[program, end]

    def end_bounds(
        self, group: Group, capture: IntArray, start: IntArray, end: IntArray
    ) -> EndBounds:
        """Return where a group may close that begins in some frames, (N,) int64.

        `end` is where its own line may end first.
        """
        lines = Spans(capture, start, end, start, end, np.zeros(len(end), bool))
        anywhere = np.full(len(end), FAR)
        bounds = EndBounds(end, anywhere, hull_rank(start, end))
        for companion in group.companions:
            if companion.relation in NEGATIONS:
                continue
            margins = margins_of(self._batch, companion)
            beside = EndBounds(anywhere, 0 * anywhere, np.full(len(end), NEVER))
            for program in self.context.rewrites.programs(companion):
                others = self.others(program, companion)[0].lines
                index = SpanIndex(others.at(~others.alone))
                own = relations.end_bounds(companion.relation, lines, index, margins)
                beside = beside.widened(own)
            bounds = bounds.narrowed(beside)
        return bounds

    def _with(
        self,
        companion: Companion,
        lines: Spans,
        hulls: Hulls,
        *,
        outermost: bool,
        since: IntArray | None,
        most: IntArray | None,
    ) -> Hulls:
        """Return hulls joined with the matches of a line that must stand beside them."""
        relation = companion.relation
        wanted = np.zeros(len(lines), bool)
        wanted[hulls.line] = True
        pieces, joins = [hulls.at(np.zeros(0, np.int64))], 0
        for alone in (False, True):
            own = np.flatnonzero(wanted & (lines.alone == alone))
            if not len(own) or (alone and relation in ("after", "before")):
                continue
            # many matches stand at few places
            compared = RELATIONS[relation].compares
            keys = [getattr(lines, it)[own] for it in ("capture", *compared)]
            once, alike = distinct(keys, len(own))
            stands = np.full(len(lines), -1)
            stands[own] = alike
            here = lines.at(own[once])  # those that stand alike have hulls of their own
            here.high = np.zeros(len(here), np.int64)
            here.low = here.start if "start" in compared else here.high + FAR - 1
            latest = None
            if most is not None:
                latest = np.zeros(len(here), np.int64)
                np.maximum.at(latest, alike, most[own])
            margins = margins_of(self._batch, companion)
            line = DistinctSpans(here, stands[hulls.line], margins, latest)
            for program in self.context.rewrites.programs(companion):
                beside = OtherLine(relation, *self.others(program, companion))
                if not alone:
                    beside = beside.moving()
                join = self._with_free if beside.matches.free else self._with_each
                for some in _pieces(beside, line):
                    some = some[~self.context.refused[lines.capture[hulls.line[some]]]]
                    joined = join(beside, line.at(some), hulls.at(some), outermost=outermost)
                    if since is not None and joined.claims:
                        capture = lines.capture[joined.line]
                        joined.claims = self.context.unexpired(
                            joined.claims, capture, since[joined.line]
                        )
                    answered = self.context.count_tried(lines.capture[joined.line])
                    if answered is not None:
                        joined = joined.at(answered)
                    pieces.append(self._reduced(joined))
            joins += len(self.context.rewrites.programs(companion))
        hulls = together(pieces)
        hulls = hulls.at(~self.context.refused[lines.capture[hulls.line]])
        if joins < 2:
            return hulls
        return self._reduced(hulls.at(np.argsort(hulls.line, kind="stable")))

    def _with_each(
        self, beside: OtherLine, line: DistinctSpans, hulls: Hulls, *, outermost: bool
    ) -> Hulls:
        """Return hulls with each of the others that can stand beside them."""
        relation, others, nodes = beside.relation, beside.matches, beside.nodes
        place, other = relations.pairs(relation, line.spans, beside.index, line.margins, line.most)
        match, place = relations.matched(line.place, place)
        other = other[place]
        fits = hulls.claims.at(match).disjoint(others.claims.at(other))
        match, other = match[fits], other[fits]
        notes = np.maximum(hulls.notes[:, match], others.notes[:, other])
        if outermost or not nodes:
            kept = self.context.met_where_known(others.lines.capture[other], notes)
            match, other, notes = match[kept], other[kept], notes[:, kept]
        if nodes:
            kept = np.flatnonzero(~beside.goes_on(match, other))
            match, other, notes = match[kept], other[kept], notes[:, kept]
        low, high = hulls.low[match], hulls.high[match]
        if RELATIONS[relation].adds_frames:
            low = np.minimum(low, others.lines.low[other])
            high = np.maximum(high, others.lines.high[other])
        claims = hulls.claims.at(match).united_with(others.claims.at(other))
        unmet = united_columns(hulls.unmet[:, match], others.unmet[:, other])
        link = self.context.joins.add(hulls.link[match], others.end[other])
        return Hulls(hulls.line[match], low, high, claims, unmet, notes, link)

    def _with_free(
        self, beside: OtherLine, line: DistinctSpans, hulls: Hulls, *, outermost: bool
    ) -> Hulls:
        """Return hulls with others that remember nothing: spans are joined, not matches."""
        relation, lines, nodes = beside.relation, beside.matches.lines, beside.nodes
        of_frames, adds_frames = self.context.clauses.of_frames, RELATIONS[relation].adds_frames
        index = beside.index
        if not nodes and not adds_frames:
            held = relations.holds(relation, line.spans, index, line.margins)
            return hulls.at(np.append(held, False)[line.place])
        if not nodes and not of_frames:
            place, low, high = relations.hulls(relation, line.spans, index, line.margins)
        else:
            place, other = relations.pairs(relation, line.spans, index, line.margins, line.most)
            if nodes:
                kept = ~beside.goes_on(place, other)
                place, other = place[kept], other[kept]
            if not adds_frames:
                return hulls.at(np.isin(line.place, place))
            low, high = lines.low[other], lines.high[other]
            if not of_frames:
                inner = smallest(place, low, high)
                place, low, high = place[inner], low[inner], high[inner]
        match, which = relations.matched(line.place, place)
        joined = hulls.at(match)
        joined.low = np.minimum(joined.low, low[which])
        joined.high = np.maximum(joined.high, high[which])
        return joined

    def _reduced(self, hulls: Hulls) -> Hulls:
        """Return hulls without those that hold a smaller one which remembers the same."""
        keys = [hulls.line, *hulls.claims.first, *hulls.claims.last, *hulls.unmet, *hulls.notes]
        if self.context.clauses.of_frames:
            chosen, _ = distinct([*keys, hulls.low, hulls.high], len(hulls.line))
            return hulls.at(np.sort(chosen))
        _, which = distinct(keys, len(hulls.line))
        return hulls.at(np.sort(smallest(which, hulls.low, hulls.high)))

    def _without(
        self, companion: Companion, lines: Spans, hulls: Hulls, *, outermost: bool
    ) -> Hulls:
        """Return the hulls without forbidden matches, but for those that may still be excused.

        These are noted as unmet; of all of a leading line none are: it claims nothing more.
        """
        others, base = self.forbidden(companion)
        capture, alone = lines.capture[hulls.line], lines.alone[hulls.line]
        low, high = hulls.low, np.maximum(hulls.high, lines.until[hulls.line])
        here = Spans(capture, low, high, low, high, alone)
        margins, free = margins_of(self._batch, companion), others.claims.none
        disturbed = np.zeros(len(here), bool)
        excusing = self.context.excusing(hulls.claims)
        unmet: list[IntArray] = []
        for still in (False, True):
            own = np.flatnonzero(alone == still)
            fits = np.ones(len(others), bool) if still else ~others.lines.alone
            some = others.lines.at(fits & free)
            if companion.relation == "never":
                disturbed[own] |= np.isin(capture[own], some.capture)
            else:
                disturbed[own] |= relations.holds("without", here.at(own), SpanIndex(some), margins)
            claiming = np.flatnonzero(fits & ~free)
            matches = others.lines.at(claiming)
            if outermost and not still:
                claims = others.claims.at(claiming)
                disturbed[own] |= unexcused(
                    companion.relation, here.at(own), excusing.at(own), matches, claims, margins
                )
                continue
            index = SpanIndex(matches)
            hull, other = relations.pairs(companion.relation, here.at(own), index, margins)
            hull, other = own[hull], claiming[other]
            apart = excusing.at(hull).disjoint(others.claims.at(other))
            if outermost:
                disturbed[hull[apart]] = True
            else:
                unmet.append(np.stack((hull[apart], other[apart] + base)))
        if unmet:
            pairs = np.concatenate(unmet, axis=1)
            hulls.unmet = united_columns(hulls.unmet, by_line(pairs, len(here)))
        return hulls.at(~disturbed)

    def forbidden(self, companion: Companion) -> tuple[CompanionMatches, int]:
        """Return the matches of a line that must not happen, and where their numbers begin."""
        programs = self.context.rewrites.programs(companion)
        if programs not in self._alone:
            others = together([self.others(program, companion)[0] for program in programs])
            others = others.at(np.flatnonzero((others.unmet >= FAR).all(axis=0)))
            lines = others.lines
            keys = [lines.capture, lines.start, lines.until, lines.alone.astype(np.int64)]
            keys += [*others.claims.first, *others.claims.last]
            others = others.at(distinct(keys, len(others))[0])
            self._alone[programs] = others, len(self._matches)
            self._matches = together([self._matches, others.claims])
        return self._alone[programs]


def _pieces(beside: OtherLine, line: DistinctSpans) -> Iterator[IntArray]:
    """Yield matches, so many at once that their pairs with others keep within the budget."""
    relation, others = beside.relation, beside.matches
    few = len(line.place) * len(others) <= MOST_AT_ONCE
    if few or (relation == "with" and others.free and others.lines.plain):  # few pairs are made
        yield np.arange(len(line.place))
        return
    limits = line.spans, beside.index, line.margins, line.most
    first, last, _ = relations.candidates(relation, *limits)
    yield from in_pieces(np.append(np.maximum(last - first, 0), 0)[line.place])
