"""Hits as a table: where a pattern begins and how it ends best; each is made an object lazily."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from operator import itemgetter
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import TRACKS
from lanindex.model import Capture, Hit, Symbol
from lanindex.model.columns import THOUSANDTHS, Roster, ranges
from lanindex.search.hits import TOGETHER, Hits
from lanindex.search.limits import tick
from lanindex.search.match.arrays import (
    FAR,
    AnyArray,
    BoolArray,
    IntArray,
    Table,
    best_of_each,
    in_order,
    once,
    starts_of,
    together,
)
from lanindex.search.match.batch import Batch, Events
from lanindex.search.plan import State

ROUNDS = 24  # in which all groups of overlapping matches are split at once; then one by one
CHECK_EVERY = 1 << 12  # matches taken one by one between two calls of `tick`


def staying(capture: IntArray, low: IntArray, high: IntArray, rank: IntArray) -> BoolArray:
    """Return which matches stay if the best is taken first, and what overlaps it is left: (H,).

    `rank` tells which is the better: all different, smaller is better.
    """
    kept = np.zeros(len(low), np.bool_)
    begin, end = capture * FAR + low, capture * FAR + high
    left = np.argsort(begin, kind="stable")
    for _ in range(ROUNDS if len(left) else 0):
        tick()
        # of matches joined by overlaps the best one stays, which splits them
        new = begin[left] >= np.append(0, np.maximum.accumulate(end[left])[:-1])
        group = np.cumsum(new) - 1
        best = np.minimum.reduceat(rank[left], np.flatnonzero(new))[group]
        stays = left[rank[left] == best]
        kept[stays] = True
        left = left[(end[left] <= begin[stays[group]]) | (begin[left] >= end[stays[group]])]
        if not len(left):
            break
    taken: list[tuple[int, int]] = []
    for number, one in enumerate(left[np.argsort(rank[left])].tolist()):
        if not number % CHECK_EVERY:
            tick()
        span = int(begin[one]), int(end[one])
        place = bisect_left(taken, span)
        free = not place or taken[place - 1][1] <= span[0]
        if free and (place == len(taken) or span[1] <= taken[place][0]):
            taken.insert(place, span)
            kept[one] = True
    return kept


@dataclass(slots=True, eq=False)
class HitTable(Table):
    """Beginnings of a pattern, each with its best end."""

    capture: IntArray  # (H,)
    low: IntArray  # (H,) frames
    high: IntArray
    cost: (
        IntArray  # (H,) what is missing to a fit of 1, in thousandths; ~least if only that is known
    )
    parts: IntArray  # (H,) of the first symbols, as from `parts_number`
    rows: IntArray  # (2, H) of the first symbols, counted in their captures; -1: there is one only

    def __len__(self) -> int:
        return len(self.capture)


_NONE = np.empty(0, np.int64)
NO_HITS = HitTable(_NONE, _NONE, _NONE, _NONE, _NONE, np.empty((2, 0), np.int64))


def parts_number(parts: Sequence[str]) -> int:
    """Return one number for some parts in order."""
    return sum((1 + TRACKS.index(part)) << 10 * place for place, part in enumerate(parts))


def table(
    batch: Batch, state: State, events: Events, ends: tuple[IntArray, IntArray, IntArray]
) -> HitTable:
    """Return hits that begin at some events of a state, with low, high and cost of each."""
    members = sorted(zip(state.members, events.first, strict=True), key=itemgetter(0))
    parts = np.full(len(events), parts_number([part for part, _ in members]))
    rows = np.full((2, len(events)), -1)
    for place, (part, first) in enumerate(members):
        rows[place] = first - batch.rows(part).bounds[events.capture]
    return HitTable(events.capture, *ends, parts, rows)


def best(hits: HitTable) -> HitTable:
    """Return the best hit from each beginning, in order of capture, start, end and fit.

    The best one ends first; of these it begins last, and of those it fits best.
    """
    keys = (hits.capture, hits.parts, *hits.rows)
    first = best_of_each(keys, ())
    if len(first) < len(hits):
        chosen = best_of_each(keys, (hits.high, -hits.low, hits.cost))
        hits = hits.at(chosen[np.argsort(first)])
    return hits.at(in_order((hits.capture, hits.low, hits.high, hits.cost)))


def nearest(capture: IntArray, low: IntArray, high: IntArray) -> BoolArray:
    """Return which hits start last of those of a capture that end together, (H,) bool."""
    last: BoolArray = np.zeros(len(low), bool)
    last[best_of_each((capture, high), (-low,))] = True
    return last


def from_left(capture: IntArray, low: IntArray, high: IntArray) -> BoolArray:
    """Return which hits begin at or after the end of the one that stayed before them.

    All are (H,), in order of capture, start, end.
    """
    kept: BoolArray = np.zeros(len(low), bool)
    after = np.searchsorted(capture * FAR + low, capture * FAR + high)
    here = np.flatnonzero(starts_of(capture))
    while len(here):
        kept[here] = True
        behind = after[here]
        inside = behind < len(low)
        behind, here = behind[inside], here[inside]
        here = behind[capture[behind] == capture[here]]
    return kept


Step = tuple[State, int]
"""A state, and the event that matched it."""

Row = tuple[str, int]
"""A part, and one of its rows in a batch."""


class HitTrace(NamedTuple):
    """What a hit is made of: its cost, and the steps of each line, the leading one first."""

    cost: int
    lines: list[list[Step]]


BestTrace = tuple[tuple[int, int], Iterable[list[Step]]]
"""Cost and negative number of steps of the best match, and its lines, the leading one first."""


def rows_of(batch: Batch, steps: Iterable[Step]) -> dict[Step, list[Row]]:
    """Return the rows that some steps took."""
    by_state: dict[State, list[int]] = {}
    for state, event in steps:
        by_state.setdefault(state, []).append(event)
    found: dict[Step, list[Row]] = {}
    for state, chosen in by_state.items():
        events = batch.events(state)
        rows: list[list[Row]] = [[] for _ in chosen]
        for part, *ends in zip(state.members, events.first, events.last, strict=True):
            passing = batch.rows(part).passing
            first, last = (it[chosen].tolist() for it in ends)
            for own, begin, end in zip(rows, first, last, strict=True):
                if begin == end:
                    own.append((part, begin))
                else:
                    own += [(part, it) for it in range(begin, end + 1) if not passing[it]]
        found |= {(state, event): own for event, own in zip(chosen, rows, strict=True)}
    return found


def labelled(
    batch: Batch, steps: Iterable[Step], symbols: Mapping[Step, Sequence[Symbol]]
) -> dict[str, tuple[Symbol, ...]]:
    """Return, by label, what matched under it; a stay or rest lends its symbols its frames."""
    labels: dict[str, tuple[Symbol, ...]] = {}
    for state, event in steps:
        if not state.labels:
            continue
        found = symbols[state, event]
        if state.manner in ("at", "hold"):
            events = batch.events(state)
            start, stop = events.start.item(event), events.end.item(event)
            found = [replace(symbol, start=start, stop=stop) for symbol in found]
        for label in state.labels:
            labels[label] = (*labels.get(label, ()), *found)
    return labels


class Maker(Protocol):
    """Makes objects of what a search found in the captures of a roster."""

    roster: Roster

    def captures(self, places: Sequence[int]) -> list[Capture]:
        """Return captures by their places in the roster."""

    def hits(self, hits: HitTable) -> list[Hit]:
        """Return the hits of a table as objects."""


class ExactHits(Hits):
    """The hits of a search as columns; each is made an object when it is asked for.

    The table holds all hits in order of capture, start, end, and fit where it is known; `chosen`,
    (H,) int64, are these hits. Those with the same frames are the first, second ... by fit.
    """

    def __init__(self, maker: Maker, table: HitTable, rows: IntArray) -> None:
        columns = table.capture[rows], table.low[rows], table.high[rows]
        super().__init__(maker.captures, maker.roster.number, *columns)
        self._maker, self._table, self._rows = maker, table, rows

    @classmethod
    def joined(cls, maker: Maker, pieces: Sequence[ExactHits]) -> ExactHits:
        """Return hits of one maker that come in pieces, each of other captures, in their order."""
        firsts = np.cumsum([0, *(len(piece._table) for piece in pieces)])
        rows = [piece._rows + first for piece, first in zip(pieces, firsts, strict=False)]
        table = together([NO_HITS, *(piece._table for piece in pieces)])
        return cls(maker, table, np.concatenate([_NONE, *rows]))

    @cached_property
    def _alike(self) -> IntArray:
        """Where hits with the same frames begin in the table, and how many there are."""
        new = starts_of(self._table.capture, self._table.low, self._table.high)
        return np.append(np.flatnonzero(new), len(self._table))

    def _subset(self, rows: AnyArray | slice) -> ExactHits:
        return ExactHits(self._maker, self._table, self._rows[rows])

    def told(self) -> tuple[HitTable, IntArray]:
        """Return no more of the table than these hits need, and which of its rows they are."""
        groups = np.searchsorted(self._alike, self._rows, "right")
        alike = once(groups)
        rows = ranges(self._alike[alike - 1], self._alike[alike])[1]
        return self._table.at(rows), np.searchsorted(rows, self._rows)

    def _hits(self, indices: Sequence[int]) -> list[Hit]:
        places = self._rows[list(indices)]
        groups = np.searchsorted(self._alike, places, "right")
        # only the fit says which of those with the same frames comes first
        unclear = {
            (first, last)
            for first, last in zip(self._alike[groups - 1], self._alike[groups], strict=True)
            if last - first > 1 and (self._table.cost[first:last] < 0).any()
        }
        wanted = sorted({*places.tolist(), *(it for ends in unclear for it in range(*ends))})
        made = dict(zip(wanted, self._maker.hits(self._table.at(np.array(wanted))), strict=True))
        for first, last in unclear:
            hits = sorted((made[it] for it in range(first, last)), key=lambda hit: -hit.fit)
            made.update(zip(range(first, last), hits, strict=True))
        return [made[place] for place in places.tolist()]

    def clear(self) -> NDArray[np.float64]:
        """Return the fit of each hit, (H,) from 0 to 1; hits are made where it is not known."""
        cost = self._table.cost[self._rows]
        fits = THOUSANDTHS - cost
        unknown = np.flatnonzero(cost < 0)
        fits[unknown] = [round(hit.fit * THOUSANDTHS) for hit in self._subset(unknown)]
        clear: NDArray[np.float64] = fits / THOUSANDTHS
        return clear

    def by_fit(self, most: int | None = None) -> ExactHits:
        """Return the same hits, the clearest first; as `Hits.by_fit`.

        Where only some will be looked at, no more are made than may be among those.
        """
        if most is None or most >= len(self):
            return super().by_fit()
        clearest = self.clearest(most)
        rest = np.delete(np.arange(len(self)), clearest)
        return self.at(np.append(clearest, rest))

    def clearest(self, most: int) -> IntArray:
        """Return the places of so many hits, the clearest first, ties as they stand.

        Those that might be are made, the likely ones first.
        """
        least = self._least_missing()
        likely = np.argsort(least, kind="stable")
        found, missing = np.empty((2, 0), np.int64)
        for first in range(0, len(likely), TOGETHER):
            if len(found) == most:
                following = int(likely[first])
                if (missing[-1], found[-1]) < (least[following], following):
                    break
            some = np.sort(likely[first : first + TOGETHER])
            found = np.append(found, some)
            clear = self._subset(some).clear()
            missing = np.append(missing, np.rint(THOUSANDTHS * (1 - clear)).astype(np.int64))
            order = np.lexsort((found, missing))[:most]
            found, missing = found[order], missing[order]
        return found

    def _least_missing(self) -> IntArray:
        """Return what is missing at least to a fit of 1, of the clearest with the same frames."""
        cost = self._table.cost
        least = np.where(cost < 0, ~cost, cost)
        if len(least):
            least = np.minimum.reduceat(least, self._alike[:-1])
        found: IntArray = least[np.searchsorted(self._alike, self._rows, "right") - 1]
        return found
