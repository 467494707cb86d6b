"""Relations between lines, as interval joins over all captures at once.

A line is compared with the first one by its first start and its last end. `RELATIONS` says what
else the matcher needs to know of each relation; `limits` and `pairs` say what it means.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from lanindex.search.match.arrays import (
    FAR,
    BoolArray,
    IntArray,
    Table,
    in_order,
    smallest_in,
    spread,
    starts_of,
)
from lanindex.search.match.batch import Batch
from lanindex.search.match.matches import LATEST, NEVER, hull_rank
from lanindex.search.plan import Companion

FIRST, LAST = "first", "last"
"""Which end of a line is enough, of all that have the same beginning."""


@dataclass(frozen=True, slots=True)
class Relation:
    """What a search may save for a relation; the defaults save nothing, and are always right."""

    adds_frames: bool = True  # the hit spans the other line, too
    compares: tuple[str, ...] = ("start", "until")  # edges of the first line that limit the other
    holds_of_shorter: bool = False  # of the first line, if of one that goes on from there
    holds_of_longer: bool = False  # of the first line, if of one that ends sooner
    enough_beside: str | None = None  # which end of the other line is enough
    holds_of_longer_beside: bool = False  # of the other line, if of one that ends sooner
    ends_later: bool = False  # the other line ends after the first one begins
    shares_frame: bool = False  # unless it has a limit
    shares_nothing: bool = False  # neither frames nor symbols


RELATIONS = {
    "with": Relation(
        holds_of_longer=True, holds_of_longer_beside=True, ends_later=True, shares_frame=True
    ),
    "overlapping": Relation(holds_of_longer=True, ends_later=True, shares_frame=True),
    "during": Relation(
        adds_frames=False,
        holds_of_shorter=True,
        enough_beside=LAST,
        holds_of_longer_beside=True,
        ends_later=True,
        shares_frame=True,
    ),
    "starting with": Relation(
        compares=("start",),
        holds_of_shorter=True,
        holds_of_longer=True,
        enough_beside=FIRST,
        holds_of_longer_beside=True,
        ends_later=True,
    ),
    "ending with": Relation(compares=("until",), ends_later=True),
    "exactly with": Relation(ends_later=True),
    "after": Relation(
        adds_frames=False,
        compares=("start",),
        holds_of_shorter=True,
        holds_of_longer=True,
        enough_beside=FIRST,
        shares_nothing=True,
    ),
    "before": Relation(
        adds_frames=False,
        compares=("until",),
        holds_of_shorter=True,
        enough_beside=FIRST,
        holds_of_longer_beside=True,
        ends_later=True,
        shares_nothing=True,
    ),
    "without": Relation(adds_frames=False, holds_of_shorter=True, enough_beside=LAST),
    "never": Relation(
        adds_frames=False, holds_of_shorter=True, holds_of_longer=True, enough_beside=LAST
    ),
}


BY_END = ("after", "ending with")
BY_START = ("before", "starting with", "exactly with")
"""Relations of which others are found by their ends or starts alone."""


@dataclass(slots=True, eq=False)
class Spans(Table):
    """Lines that were found: their frames, and those of all beside them; (N,) int64 each."""

    capture: IntArray
    start: IntArray
    until: IntArray
    low: IntArray
    high: IntArray
    alone: BoolArray  # it is no more than a starting position

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.capture)

    @property
    def plain(self) -> bool:
        """Whether nothing beside them adds frames."""
        return bool(((self.low == self.start) & (self.high == self.until)).all())


class SpanIndex:
    """Lines in order of capture, start and end, to be found by their frames."""

    def __init__(self, lines: Spans) -> None:
        self.spans, starts = lines, lines.capture * FAR + lines.start
        self.order = np.arange(len(lines))  # where each of them stood
        same = starts[1:] == starts[:-1]
        if not ((starts[1:] > starts[:-1]) | same & (lines.until[1:] >= lines.until[:-1])).all():
            self.order = np.lexsort((lines.until, starts))
            lines, starts = lines.at(self.order), starts[self.order]
        self.lines, self.starts = lines, starts  # capture and start as one number, growing

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.lines)

    @cached_property
    def latest(self) -> IntArray:
        """The latest end of each and all before it, with the capture as one number, growing."""
        latest: IntArray = np.maximum.accumulate(self.lines.capture * FAR + self.lines.until)
        return latest

    @cached_property
    def by_end(self) -> IntArray:
        """The places of the lines in order of their ends."""
        return np.argsort(self.lines.capture * FAR + self.lines.until, kind="stable")

    @cached_property
    def ends(self) -> IntArray:
        """Capture and end as one number, growing."""
        ends: IntArray = (self.lines.capture * FAR + self.lines.until)[self.by_end]
        return ends

    @cached_property
    def heads(self) -> IntArray:
        """Where lines begin that start together, and how many there are of all."""
        return np.append(np.flatnonzero(starts_of(self.starts)), len(self))


@dataclass(slots=True, eq=False)
class Margins:
    """How far apart lines may lie, by capture; (captures,) int64 frames each."""

    least: IntArray  # between two lines
    most: IntArray
    slack: IntArray  # by which edges may differ that should agree


def margins_of(batch: Batch, companion: Companion) -> Margins:
    """Return how far apart a line and the one beside it may lie."""
    least = np.zeros(len(batch), np.int64)
    most = least + (FAR >> 1 if companion.relation in ("after", "before") else -1)
    if companion.within:
        least, most = batch.bounds(companion.within)
    return Margins(least, most, batch.slack)


class Limits(NamedTuple):
    """Between which frames another line has to begin and to end, both included; (N,) each."""

    begin_first: IntArray
    begin_last: IntArray
    end_first: IntArray
    end_last: IntArray

    def at(self, lines: IntArray | BoolArray) -> Limits:
        """Return those of some lines."""
        return Limits(*(it[lines] for it in self))


def limits(relation: str, lines: Spans, margins: Margins) -> Limits:
    """Return within which limits another line stands in a relation to each."""
    start, until = lines.start, lines.until
    first, last = np.zeros(len(lines), np.int64), np.full(len(lines), FAR - 1)
    found = {"begin_first": first, "begin_last": last, "end_first": first, "end_last": last}
    least, most, slack = (it[lines.capture] for it in (margins.least, margins.most, margins.slack))
    least = np.maximum(least, 0)
    if relation in ("with", "without", "overlapping"):
        found |= {"begin_last": until + most, "end_first": start - most}
    elif relation == "during":
        found |= {"begin_last": start, "end_first": until}
    elif relation == "after":
        found |= {"end_first": start - most, "end_last": start - least}
    elif relation == "before":
        found |= {"begin_first": until + least, "begin_last": until + most}
    if relation in ("starting with", "exactly with"):
        found |= {"begin_first": start - slack, "begin_last": start + slack}
    if relation in ("ending with", "exactly with"):
        found |= {"end_first": until - slack, "end_last": until + slack}
    return Limits(
        np.maximum(found["begin_first"], 0),
        np.minimum(found["begin_last"], FAR - 1),
        np.maximum(found["end_first"], 0),
        found["end_last"],
    )


def candidates(
    relation: str, lines: Spans, others: SpanIndex, margins: Margins, most: IntArray | None = None
) -> tuple[IntArray, IntArray, bool]:
    """Return the range of others that may stand in a relation to each line, (N,) both.

    They are places in order of their ends where the third is true, else in order of their starts.
    Others end by the frame `most` (N,) of their line, but for relations that add no frames.
    """
    base, limit = lines.capture * FAR, limits(relation, lines, margins)
    if relation in BY_END:
        first = np.searchsorted(others.ends, base + limit.end_first)
        return first, np.searchsorted(others.ends, base + limit.end_last, "right"), True
    last = np.searchsorted(others.starts, base + limit.begin_last, "right")
    if relation in BY_START:
        return np.searchsorted(others.starts, base + limit.begin_first), last, False
    first = np.searchsorted(others.latest, base + limit.end_first)
    if most is not None and RELATIONS[relation].adds_frames:
        ends = np.searchsorted(others.ends, base + limit.end_first)
        behind = np.searchsorted(others.ends, base + np.maximum(most, 0), "right")
        if np.maximum(behind - ends, 0).sum() < np.maximum(last - first, 0).sum():
            return ends, behind, True
    return first, last, False


class EndBounds(NamedTuple):
    """Bounds of where lines may end beside others, and of their hulls; (N,) int64 each."""

    first: IntArray  # the first frame in which a line may end
    last: IntArray
    rank: IntArray  # of the best hull, as `hull_rank` says; `NEVER`: no other stands beside it

    def narrowed(self, other: EndBounds) -> EndBounds:
        """Return the bounds where both must hold."""
        first, last = np.maximum(self.first, other.first), np.minimum(self.last, other.last)
        rank = np.where(first <= last, np.maximum(self.rank, other.rank), NEVER)
        return EndBounds(first, last, rank)

    def widened(self, other: EndBounds) -> EndBounds:
        """Return the bounds where either must hold."""
        first, last = np.minimum(self.first, other.first), np.maximum(self.last, other.last)
        return EndBounds(first, last, np.minimum(self.rank, other.rank))


def end_bounds(relation: str, lines: Spans, others: SpanIndex, margins: Margins) -> EndBounds:
    """Return where lines may end beside others; `lines` end where they first may by themselves."""
    base, soonest = lines.capture * FAR, limits(relation, lines, margins)
    latest = limits(relation, replace(lines, until=np.full(len(lines), FAR >> 1)), margins)
    order = others.by_end
    starts, ends = others.lines.start, others.lines.until
    if relation == "overlapping":  # the middle of the other lies behind the line's start
        keys = 2 * others.lines.capture * FAR + starts + ends
        order = np.argsort(keys, kind="stable")
        begin = np.searchsorted(keys[order], 2 * (base + lines.start))
        behind = np.searchsorted(keys[order], 2 * (base + FAR))
    elif relation in BY_START:
        order = np.arange(len(others))
        begin = np.searchsorted(others.starts, base + soonest.begin_first)
        behind = np.searchsorted(others.starts, base + latest.begin_last, "right")
    else:
        begin = np.searchsorted(others.ends, base + soonest.end_first)
        behind = np.searchsorted(others.ends, base + latest.end_last, "right")
    first, last = lines.until, np.full(len(lines), FAR)
    slack = margins.slack[lines.capture]
    if relation == "with":
        soon = smallest_in(starts[order], begin, behind, 0) - margins.most[lines.capture]
        first = np.maximum(first, soon)
    elif relation == "overlapping":
        first = np.maximum(first, smallest_in((starts + ends)[order], begin, behind, 0) // 2)
    elif relation == "during":
        place = np.searchsorted(others.starts, base + lines.start, "right")
        last = np.append(0, others.latest)[place] - base
    elif relation in ("ending with", "exactly with"):
        first = np.maximum(first, smallest_in(ends[order], begin, behind, 0) - slack)
        last = slack - smallest_in(-ends[order], begin, behind, 0)
    rank = own = hull_rank(lines.start, lines.until)
    if RELATIONS[relation].adds_frames:
        ranks = hull_rank(others.lines.low, others.lines.high)[order]
        best = smallest_in(ranks, begin, behind, NEVER)
        best = best & ~LATEST | np.maximum(best & LATEST, own & LATEST)  # the line is in the hull
        rank = np.maximum(own, best)
    rank = np.where((begin < behind) & (first <= last), rank, NEVER)
    return EndBounds(first, last, rank)


def holds(relation: str, lines: Spans, others: SpanIndex, margins: Margins) -> BoolArray:
    """Tell which lines have another one that stands in a relation to them.

    Of those that lie exactly with them only the beginnings are compared; of those that overlap
    them it is enough that they share a frame.
    """
    first, last, _ = candidates(relation, lines, others, margins)
    held: BoolArray = first < last
    return held


def pairs(
    relation: str, lines: Spans, others: SpanIndex, margins: Margins, most: IntArray | None = None
) -> tuple[IntArray, IntArray]:
    """Return all pairs of a line and another one that stands beside it, by place.

    Others that end behind the frame `most` (N,) of their line may be left out.
    """
    first, last, by_end = candidates(relation, lines, others, margins, most)
    line, other = spread(first, last)
    if relation in BY_END:
        return line, others.order[others.by_end[other]]
    other = others.by_end[other] if by_end else other
    limit = limits(relation, lines, margins)
    start, until = others.lines.start[other], others.lines.until[other]
    if by_end:
        fits = start <= limit.begin_last[line]
    else:
        fits = (limit.end_first[line] <= until) & (until <= limit.end_last[line])
    if most is not None and RELATIONS[relation].adds_frames:
        fits &= until <= most[line]
    if relation == "overlapping":
        shared = np.minimum(lines.until[line], until) - np.maximum(lines.start[line], start)
        fits &= (2 * shared >= until - start) | others.lines.alone[other]
    return line[fits], others.order[other[fits]]


def hulls(
    relation: str, lines: Spans, others: SpanIndex, margins: Margins
) -> tuple[IntArray, IntArray, IntArray]:
    """Return which line, growing, low and high of the hulls with others: (M,) each.

    A hull that holds another one of its line is left out.
    """
    if relation == "with":
        return _sharing_hulls(lines, others, limits(relation, lines, margins))
    line, other = pairs(relation, lines, others, margins)
    low = np.minimum(lines.low[line], others.spans.low[other])
    high = np.maximum(lines.high[line], others.spans.high[other])
    kept = smallest(line, low, high)
    return line[kept], low[kept], high[kept]


def _sharing_hulls(
    lines: Spans, others: SpanIndex, limit: Limits
) -> tuple[IntArray, IntArray, IntArray]:
    """Return the same as `hulls` of lines that share a frame with others, or lie near enough.

    Of those that begin no sooner only the first to end counts, and of those that began before only
    such as end before that one does.
    """
    base, until = lines.capture * FAR, others.lines.until
    soonest, settled = lines.high, np.zeros(len(lines), bool)
    if others.lines.plain:
        first = np.searchsorted(others.latest, base + limit.end_first)
        own = np.searchsorted(others.starts, base + lines.low)
        behind = np.searchsorted(others.starts, base + limit.begin_last, "right")
        soonest = np.maximum(smallest_in(until, own, behind, FAR), lines.high)
        before = smallest_in(until, np.minimum(first, own), own, FAR)
        settled = (soonest < FAR) & ((soonest == lines.high) | (before >= soonest))
    left, done = np.flatnonzero(~settled), np.flatnonzero(settled)
    line, other = _sharing(lines.at(left), others, limit.at(left))
    line = left[line]
    low = np.minimum(lines.low[line], others.spans.low[other])
    high = np.maximum(lines.high[line], others.spans.high[other])
    kept = smallest(line, low, high)
    line = np.append(line[kept], done)
    order = np.argsort(line, kind="stable")
    low, high = np.append(low[kept], lines.low[done]), np.append(high[kept], soonest[done])
    return line[order], low[order], high[order]


def _sharing(lines: Spans, others: SpanIndex, limit: Limits) -> tuple[IntArray, IntArray]:
    """Return pairs that share a frame, or lie near enough.

    Of others that begin together and have nothing beside them only the first that ends late enough.
    """
    base, heads = lines.capture * FAR, others.heads
    first = np.searchsorted(others.latest[heads[1:] - 1], base + limit.end_first)
    behind = np.searchsorted(others.starts[heads[:-1]], base + limit.begin_last, "right")
    line, head = spread(first, behind)
    keys = np.repeat(np.arange(len(heads) - 1) * FAR, np.diff(heads)) + others.lines.until
    place = np.searchsorted(keys, head * FAR + np.maximum(limit.end_first[line], 0))
    if others.lines.plain:
        fits = place < heads[head + 1]
        return line[fits], others.order[place[fits]]
    pair, place = spread(place, heads[head + 1])
    return line[pair], others.order[place]


def matched(one: IntArray, other: IntArray) -> tuple[IntArray, IntArray]:
    """Return all pairs of places of equal numbers in two lists, of which the second is in order."""
    first = np.searchsorted(other, one)
    return spread(first, np.searchsorted(other, one, "right"))


def smallest(line: IntArray, low: IntArray, high: IntArray) -> IntArray:
    """Return the places of the hulls that hold no other one of their line, by line."""
    if (line[1:] > line[:-1]).all():
        return np.arange(len(line))
    order = in_order((line, high, -low))
    begins = (line * FAR + low)[order]
    kept = np.ones(len(order), bool)
    kept[1:] = begins[1:] > np.maximum.accumulate(begins)[:-1]
    return order[kept]
