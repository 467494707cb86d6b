"""What must not happen beside a match: looked for exactly, by the engine."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import Columns, Roster
from lanindex.search.fuzzy.clocks import ENDLESS, bounds_of
from lanindex.search.fuzzy.lines import LIFTED
from lanindex.search.fuzzy.wholes import Apart, Table
from lanindex.search.match.finder import Finder, Recordings, Watch
from lanindex.search.match.hits import Found

Whole = NDArray[np.int64]
Mask = NDArray[np.bool_]


class Refusal:
    """Tells which matches a line disturbs that must not happen.

    Parameters
    ----------
    apart : Apart
        The line.
    roster : Roster
        All captures.
    columns : Mapping of str to Columns
        Of all parts.
    recordings : callable
        As of `lanindex.search.match.Finder`.
    tolerance : Fraction
        Seconds within which edges agree.
    watch : callable, optional
        Is told how far the search is.
    """

    def __init__(
        self,
        apart: Apart,
        roster: Roster,
        columns: Mapping[str, Columns],
        recordings: Recordings,
        tolerance: Fraction,
        watch: Watch | None,
    ) -> None:
        self._apart, self._roster, self._columns = apart, roster, columns
        self._recordings, self._tolerance, self._watch = recordings, tolerance, watch

    def disturbed(self, table: Table) -> Mask:
        """Return which matches of a table are disturbed: (N,)."""
        if not len(table.capture):
            return np.zeros(0, np.bool_)
        places = np.unique(table.capture)
        hits = self._hits(places)
        capture = np.searchsorted(places, table.capture)
        _, most = bounds_of(self._roster.taken(places), self._apart.within)
        reach = np.where(most >= ENDLESS, -1, most)[capture]
        never = self._apart.relation == "never"
        low = np.where(never, 0, np.maximum(table.low - reach, 0)) + capture * LIFTED
        high = np.where(never, LIFTED - 1, table.high + reach) + capture * LIFTED
        near = _between(hits, low, high)
        if not {line.net.part for line, _ in table.lines} & set(self._parts):
            return near > 0
        # what a match is made of lies in its frames: any hit outside of them disturbs it
        begin, end = table.frames()
        low = np.maximum(low, begin + capture * LIFTED)
        high = np.minimum(high, end + capture * LIFTED)
        own = _between(hits, low, high)
        found: Mask = near > own
        asked = np.flatnonzero((near == own) & (own > 0))
        pairs = list(self._overlapping(hits, low[asked], high[asked]))
        found[asked] = self._by_others(table, asked, pairs, hits)
        return found

    @property
    def _parts(self) -> frozenset[str]:
        return self._apart.query.parts

    def _hits(self, places: Whole) -> Found:
        """Return all hits of the line in some captures."""
        held = {part: self._columns[part].taken(places) for part in self._parts}
        own = places.tolist()
        finder = Finder(
            self._apart.query,
            self._roster.taken(places),
            held,
            lambda some, parts: self._recordings([own[place] for place in some], parts),
            self._tolerance,
        )
        return finder.find("all", self._watch)

    def _ask(self) -> None:
        if self._watch:
            self._watch(0, len(self._roster))

    def _overlapping(self, hits: Found, low: Whole, high: Whole) -> Iterator[Whole]:
        """Yield the hits, in order of capture and start, that reach into each such stretch."""
        begins, ends = hits.place * LIFTED + hits.low, hits.place * LIFTED + hits.high
        longest = int((ends - begins).max(initial=0))
        first = np.searchsorted(begins, low - longest).tolist()
        behind = np.searchsorted(begins, high, side="right").tolist()
        for begin, end, least in zip(first, behind, low.tolist(), strict=True):
            self._ask()
            yield np.flatnonzero(ends[begin:end] >= least) + begin

    def _by_others(
        self, table: Table, matches: Whole, pairs: list[Whole], hits: Found
    ) -> list[bool]:
        """Tell which matches hits disturb that have no symbol in common with them."""
        wanted = np.unique(np.concatenate([np.empty(0, np.int64), *pairs])).tolist()
        symbols = {}
        for index, hit in zip(wanted, hits.arranged(wanted), strict=True):
            symbols[index] = {(it.part, it.ordinal) for it in hit.symbols}
            self._ask()
        return [
            not all(_share(table, match, symbols[index]) for index in own.tolist())
            for match, own in zip(matches.tolist(), pairs, strict=True)
        ]


def _between(hits: Found, low: Whole, high: Whole) -> Whole:
    """Return how many hits reach into each stretch of lifted frames, both ends included."""
    begins = np.sort(hits.place * LIFTED + hits.low)
    ends = np.sort(hits.place * LIFTED + hits.high)
    # all that end before a stretch begin before it
    return np.searchsorted(begins, high, "right") - np.searchsorted(ends, low)


def _share(table: Table, match: int, symbols: set[tuple[str, int]]) -> bool:
    """Tell whether a match has one of some symbols, which are counted in its capture."""
    return any(
        line.net.part == part and line.own(first) <= row <= line.own(last)
        for line, first, last, _ in table.rows(match)
        for part, row in symbols
    )
