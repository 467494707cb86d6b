"""Lines side by side: how tables of lines stand to each other, for all captures at once.

Each other line is compared with the first, its first start to its last end; so all that matters of
it is where it begins and ends, and where the hull of it and of what stands beside it does. Which
of all ways is best, without trying them: the hull that ends first, and of those the one that begins
last.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lanindex.search.fast.ragged import FAR, Mask, Whole, spread, starts_of
from lanindex.search.fast.ways import Used, smallest, stacked

FORBIDDEN = ("without", "never")
"""Relations of what must not happen."""

NO_FRAMES = ("during", "after", "before")
"""Relations of lines that add no frames to the hit."""


@dataclass(slots=True, eq=False)
class Stretches:
    """Lines that were found: their frames, and the frames of all beside them too.

    Attributes
    ----------
    capture, start, until, low, high : ndarray
        (N,) int64.
    alone : ndarray
        (N,) bool: whether it is no more than a starting position.
    used : tuple of Used
        What they took that another line could want.
    """

    capture: Whole
    start: Whole
    until: Whole
    low: Whole
    high: Whole
    alone: Mask
    used: tuple[Used, ...] = ()

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.capture)

    def at(self, chosen: Whole | Mask) -> Stretches:
        """Return some of them."""
        found = Stretches(*(getattr(self, name)[chosen] for name in _FIELDS))
        found.used = tuple(it.at(chosen) for it in self.used)
        return found

    @property
    def plain(self) -> bool:
        """Whether nothing beside them adds frames."""
        return bool(((self.low == self.start) & (self.high == self.until)).all())


_FIELDS = ("capture", "start", "until", "low", "high", "alone")


def gathered(tables: list[Stretches]) -> Stretches:
    """Return the lines of several tables as one."""
    capture, start, until, low, high, alone = (
        np.concatenate([getattr(it, name) for it in tables]) for name in _FIELDS
    )
    found = Stretches(capture, start, until, low, high, alone)
    found.used = stacked([(it.used, len(it)) for it in tables])
    return found


@dataclass(slots=True, eq=False)
class Margins:
    """How far apart lines may lie, by capture.

    Attributes
    ----------
    least, most : ndarray
        (captures,) int64 frames that may lie between two lines.
    slack : ndarray
        (captures,) int64 frames by which edges may differ that should agree.
    """

    least: Whole
    most: Whole
    slack: Whole


def shares(lines: Stretches, others: Stretches, margins: Margins) -> Mask:
    """Tell which lines have another one that shares a frame with them, or lies near enough.

    Compared are the frames from `low` to `high`.
    """
    if not len(others):
        return np.zeros(len(lines), bool)
    order = np.lexsort((others.start, others.capture))
    starts = (others.capture * FAR + others.start)[order]
    latest = np.maximum.accumulate((others.capture * FAR + others.until)[order])
    near = margins.most[lines.capture] + 1
    base = lines.capture * FAR
    place = np.searchsorted(starts, base + lines.high + near) - 1
    shared: Mask = (place >= 0) & (latest[place] > base + np.maximum(lines.low - near, -1))
    return shared


def holds(relation: str, lines: Stretches, others: Stretches, margins: Margins) -> Mask:
    """Tell which lines have another one around, after or before them."""
    if not len(others):
        return np.zeros(len(lines), bool)
    base = lines.capture * FAR
    if relation == "during":
        order = np.lexsort((others.start, others.capture))
        starts = (others.capture * FAR + others.start)[order]
        latest = np.maximum.accumulate((others.capture * FAR + others.until)[order])
        place = np.searchsorted(starts, base + lines.start, "right") - 1
        around: Mask = (place >= 0) & (latest[place] >= base + lines.until)
        return around
    least = np.maximum(margins.least[lines.capture], 0)
    most = margins.most[lines.capture]
    if relation == "after":
        keys = np.sort(others.capture * FAR + others.until)
        first = base + np.maximum(lines.start - most, 0)
        last = base + lines.start - least
        last = np.where(lines.start < least, first - 1, last)
    else:
        keys = np.sort(others.capture * FAR + others.start)
        first, last = base + lines.until + least, base + np.minimum(lines.until + most, FAR - 1)
    found: Mask = np.searchsorted(keys, first) < np.searchsorted(keys, last, "right")
    return found


def hulls(
    relation: str, lines: Stretches, others: Stretches, margins: Margins
) -> tuple[Whole, Whole, Whole]:
    """Return the hulls of the lines that stand beside each, but for those that hold another.

    Returns
    -------
    tuple of ndarray
        Which line, and low and high of the other.
    """
    if relation == "ending with":
        line, other = _ending(lines, others, margins)
    elif relation == "with":
        line, other = _sharing(lines, others, margins)
    else:
        line, other = _starting(lines, others, margins)
        if relation == "exactly with":
            apart = np.abs(others.until[other] - lines.until[line])
            fits = apart <= margins.slack[lines.capture[line]]
            line, other = line[fits], other[fits]
    return smallest(line, others.low[other], others.high[other])


def pairs(
    relation: str, lines: Stretches, others: Stretches, margins: Margins
) -> tuple[Whole, Whole]:
    """Return all pairs of a line and another one that stands beside it."""
    if relation == "ending with":
        return _ending(lines, others, margins)
    if relation in ("starting with", "exactly with"):
        line, other = _starting(lines, others, margins)
        apart_by = np.abs(others.until[other] - lines.until[line])
        fits = (relation != "exactly with") | (apart_by <= margins.slack[lines.capture[line]])
        return line[fits], other[fits]
    order = np.lexsort((others.start, others.capture))
    keys = (others.capture * FAR + others.start)[order]
    base, latest = lines.capture * FAR, np.full(len(lines), FAR - 1)
    if relation in ("with", "without", "during"):
        latest = lines.until + np.maximum(margins.most[lines.capture], 0)
    line, place = spread(np.searchsorted(keys, base), np.searchsorted(keys, base + latest, "right"))
    other = order[place]
    start, until = lines.start[line], lines.until[line]
    begin, end = others.start[other], others.until[other]
    least, most = (it[lines.capture[line]] for it in (margins.least, margins.most))
    if relation == "during":
        fits = (begin <= start) & (until <= end)
    elif relation == "never":
        fits = np.ones(len(line), bool)
    else:
        between = {"after": start - end, "before": begin - until}.get(
            relation, np.maximum(begin - until, start - end)
        )
        if relation in ("after", "before"):
            fits = (between >= np.maximum(least, 0)) & (between <= most)
        else:
            fits = between <= most
    return line[fits], other[fits]


def _starting(lines: Stretches, others: Stretches, margins: Margins) -> tuple[Whole, Whole]:
    """Return pairs that begin together."""
    order = np.lexsort((others.start, others.capture))
    keys = (others.capture * FAR + others.start)[order]
    base, slack = lines.capture * FAR, margins.slack[lines.capture]
    low = np.searchsorted(keys, base + np.maximum(lines.start - slack, 0))
    line, place = spread(low, np.searchsorted(keys, base + lines.start + slack, "right"))
    return line, order[place]


def _ending(lines: Stretches, others: Stretches, margins: Margins) -> tuple[Whole, Whole]:
    """Return pairs that end together."""
    order = np.lexsort((others.until, others.capture))
    keys = (others.capture * FAR + others.until)[order]
    base, slack = lines.capture * FAR, margins.slack[lines.capture]
    low = np.searchsorted(keys, base + np.maximum(lines.until - slack, 0))
    line, place = spread(low, np.searchsorted(keys, base + lines.until + slack, "right"))
    return line, order[place]


def _sharing(lines: Stretches, others: Stretches, margins: Margins) -> tuple[Whole, Whole]:
    """Return pairs that share a frame, or lie near enough.

    Of others that begin together and have nothing beside them only the first that ends late enough.
    """
    order = np.lexsort((others.until, others.start, others.capture))
    capture, start, until = others.capture[order], others.start[order], others.until[order]
    new = starts_of(capture) | starts_of(start)
    bounds = np.append(np.flatnonzero(new), len(order))
    heads = (capture * FAR + start)[bounds[:-1]]
    near = margins.most[lines.capture] + 1
    base = lines.capture * FAR
    low = np.searchsorted(heads, base)
    line, head = spread(low, np.searchsorted(heads, base + lines.until + near))
    after = np.maximum(lines.start[line] - near[line], -1)
    place = _first_after(until, bounds[head], bounds[head + 1], after)
    if others.plain:
        fits = place < bounds[head + 1]
        return line[fits], order[place[fits]]
    pair, place = spread(place, bounds[head + 1])
    return line[pair], order[place]


def _first_after(values: Whole, low: Whole, high: Whole, after: Whole) -> Whole:
    """Return the first place in each range of growing values that holds more than `after`."""
    low, high = low.copy(), high.copy()
    while (low < high).any():
        middle = (low + high) >> 1
        more = values[np.minimum(middle, len(values) - 1)] > after
        open_still = low < high
        high = np.where(open_still & more, middle, high)
        low = np.where(open_still & ~more, middle + 1, low)
    return low


def matched(one: Whole, other: Whole) -> tuple[Whole, Whole]:
    """Return all pairs of places of equal numbers in two lists, of which the second is in order."""
    first = np.searchsorted(other, one)
    return spread(first, np.searchsorted(other, one, "right"))


def outermost(lines: Stretches) -> Whole:
    """Return the lines that no other one of their capture holds: what they share, it shares too."""
    found = []
    for alone in (False, True):
        own = np.flatnonzero(lines.alone == alone)
        order = own[np.lexsort((-lines.until[own], lines.start[own], lines.capture[own]))]
        until = (lines.capture * FAR + lines.until)[order]
        kept = np.ones(len(order), bool)
        kept[1:] = until[1:] > np.maximum.accumulate(until)[:-1]
        found.append(order[kept])
    return np.concatenate(found)
