"""The hits of a fuzzy search as columns, made objects one by one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from lanindex.model import Capture, Hit, Span, Symbol, Track
from lanindex.model.columns import Roster
from lanindex.search.fast.source import Recordings
from lanindex.search.fuzzy.lines import fits
from lanindex.search.fuzzy.wholes import Table

TOGETHER = 64
"""How many captures are fetched at once where all hits are made objects."""

Whole = NDArray[np.int64]


class Source:
    """Where hits come from.

    Parameters
    ----------
    roster : Roster
        All captures.
    recordings : callable
        Gives captures with their tracks, by places in the roster.
    parts : sequence of str
        Of which tracks are fetched.
    tables : list of tuple of Table, int
        The matches of each plan, and how many steps it has.
    """

    def __init__(
        self,
        roster: Roster,
        recordings: Recordings,
        parts: Sequence[str],
        tables: list[tuple[Table, int]],
    ) -> None:
        self.roster, self.tables = roster, tables
        self._recordings, self._parts = recordings, parts
        self._fetched: dict[int, tuple[Capture, Mapping[str, Track]]] = {}
        self._symbols: dict[tuple[int, str], list[Symbol]] = {}

    def fetch(self, places: Sequence[int]) -> None:
        """Fetch captures of which hits will be made objects; forget the others."""
        held = self._recordings(places, self._parts)
        self._fetched = dict(zip(places, held, strict=True))
        self._symbols = {}

    def captures(self, places: Sequence[int]) -> list[Capture]:
        """Return captures by their places in the roster."""
        return [capture for capture, _ in self._recordings(places, ())]

    def hit(self, plan: int, match: int, fit: float) -> Hit:
        """Return a match of a plan as an object."""
        table, _ = self.tables[plan]
        place = int(table.capture[match])
        if place not in self._fetched:
            self.fetch([place])
        capture, _ = self._fetched[place]
        lines = []
        for line, first, last, cost in table.rows(match):
            symbols = self._listed(place, line.net.part)
            rows = line.rows(first, last, cost)
            lines.append(tuple(symbols[line.own(row)] for row in rows))
        return Hit(capture, Span(int(table.low[match]), int(table.high[match])), fit, tuple(lines))

    def _listed(self, place: int, part: str) -> list[Symbol]:
        if (place, part) not in self._symbols:
            self._symbols[place, part] = self._fetched[place][1][part].listed()
        return self._symbols[place, part]


class Found(Sequence[Hit]):
    """The hits of a search as columns; each is made an object when it is asked for.

    Parameters
    ----------
    source : Source
        Where they come from.
    plan, match : ndarray
        (H,) int64: of which plan each is, and which of its matches.

    Attributes
    ----------
    place : ndarray
        (H,) int64: which capture of the roster.
    low, high : ndarray
        (H,) int64: frames of the source, half-open.
    fit : ndarray
        (H,) float64: the smallest margin of the symbols that are what was asked for, in
        proportion less for all that was edited.
    """

    def __init__(self, source: Source, plan: Whole, match: Whole) -> None:
        self._source, self._plan, self._match = source, plan, match
        self.place, self.low, self.high = np.zeros((3, len(plan)), np.int64)
        self.fit = np.zeros(len(plan))
        for number, (table, steps) in enumerate(source.tables):
            here = plan == number
            own = match[here]
            self.place[here], self.low[here] = table.capture[own], table.low[own]
            self.high[here] = table.high[own]
            self.fit[here] = fits(table.cost[own], table.blur[own], steps)

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._match)

    @overload
    def __getitem__(self, index: int) -> Hit: ...
    @overload
    def __getitem__(self, index: slice) -> Found: ...
    def __getitem__(self, index: int | slice) -> Hit | Found:
        """Return one hit, or some of them."""
        if isinstance(index, slice):
            return Found(self._source, self._plan[index], self._match[index])
        own = range(len(self))[index]
        return self._source.hit(int(self._plan[own]), int(self._match[own]), float(self.fit[own]))

    def __iter__(self) -> Iterator[Hit]:
        """Yield all hits, in whatever order they stand; captures are fetched many at once."""
        first, places = 0, set[int]()
        for index, place in enumerate([*self.place.tolist(), -1]):
            if place < 0 or (len(places) == TOGETHER and place not in places):
                self._source.fetch(sorted(places))
                yield from (self[one] for one in range(first, index))
                first, places = index, set()
            places.add(place)

    @property
    def captures(self) -> int:
        """In how many captures they are."""
        return len(np.unique(self.place))

    def tally(self) -> list[tuple[int, int]]:
        """Return the numbers of the captures, each with how many hits it has."""
        places, counts = np.unique(self.place, return_counts=True)
        numbers = self._source.roster.number[places].tolist()
        return list(zip(numbers, counts.tolist(), strict=True))

    def counts(self) -> list[tuple[Capture, int]]:
        """Return the captures, each with how many hits it has."""
        places, counts = np.unique(self.place, return_counts=True)
        return list(zip(self._source.captures(places.tolist()), counts.tolist(), strict=True))

    def spans(self) -> Iterator[tuple[Capture, Span]]:
        """Yield capture and frames of each hit."""
        places = np.unique(self.place).tolist()
        captures = dict(zip(places, self._source.captures(places), strict=True))
        columns = (self.place.tolist(), self.low.tolist(), self.high.tolist())
        for place, low, high in zip(*columns, strict=True):
            yield captures[place], Span(low, high)

    def arranged(self, order: Sequence[int]) -> Found:
        """Return the same hits in another order."""
        own = np.array(order, np.int64)
        return Found(self._source, self._plan[own], self._match[own])

    def by_fit(self) -> Found:
        """Return the same hits, the clearest first."""
        return self.arranged(np.argsort(-self.fit, kind="stable").tolist())

    def numpy(self) -> NDArray[Any]:
        """Return the hits as an array, as `lanindex.search.hits.Hits.numpy`."""
        fields = [("capture_id", "i8"), ("start", "i8"), ("stop", "i8"), ("fit", "f4")]
        found = np.empty(len(self), fields)
        found["capture_id"] = self._source.roster.number[self.place]
        found["start"], found["stop"], found["fit"] = self.low, self.high, self.fit
        return found
