"""The hits of a fuzzy search as columns, made objects one by one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lanindex.model import Capture, Hit, Span, Symbol, Track
from lanindex.model.columns import Roster
from lanindex.search.fuzzy.joining import Table
from lanindex.search.fuzzy.lines import fits
from lanindex.search.match.arrays import AnyArray, IntArray
from lanindex.search.match.finder import Recordings
from lanindex.search.match.hits import Found as Exact
from lanindex.search.placed import Placed


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
    exact : lanindex.search.match.hits.Found, optional
        Hits without an edit besides; they count as of one plan more.
    """

    def __init__(
        self,
        roster: Roster,
        recordings: Recordings,
        parts: Sequence[str],
        tables: list[tuple[Table, int]],
        exact: Exact | None = None,
    ) -> None:
        self.roster, self.tables, self.exact = roster, tables, exact
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

    def numbers(self, places: IntArray) -> IntArray:
        """Return the numbers of captures by their places in the roster."""
        return self.roster.number[places]

    def hit(self, plan: int, match: int, fit: float) -> Hit:
        """Return a match of a plan as an object."""
        if self.exact is not None and plan == len(self.tables):
            return self.exact[match]
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


class Found(Placed):
    """The hits of a search as columns; each is made an object when it is asked for.

    Parameters
    ----------
    source : Source
        Where they come from.
    plan, match : ndarray
        (H,) int64: of which plan each is, and which of its matches.
    """

    def __init__(self, source: Source, plan: IntArray, match: IntArray) -> None:
        super().__init__(source, *np.zeros((3, len(plan)), np.int64))
        self._source, self._plan, self._match = source, plan, match
        self._fit = np.zeros(len(plan))
        for number, (table, steps) in enumerate(source.tables):
            here = plan == number
            own = match[here]
            self.place[here], self.low[here] = table.capture[own], table.low[own]
            self.high[here] = table.high[own]
            self._fit[here] = fits(table.cost[own], table.blur[own], steps)
        self._exact = np.flatnonzero(plan == len(source.tables))
        if found := self._exactly():
            here = self._exact
            self.place[here], self.low[here], self.high[here] = found.place, found.low, found.high

    @cached_property
    def fit(self) -> NDArray[np.float64]:
        """The smallest margin of what was asked for, less in proportion for what was edited."""
        if found := self._exactly():
            self._fit[self._exact] = found.clear()
        return self._fit

    def by_fit(self, most: int | None = None) -> Found:
        """Return the same hits, the clearest first; as `Placed.by_fit`."""
        found = self._exactly()
        if not found or most is None or most >= len(found):
            return super().by_fit()
        other = np.ones(len(self), np.bool_)
        other[self._exact] = False
        likely = np.append(np.flatnonzero(other), self._exact[found.clearest(most)])
        likely.sort()
        likely = likely[np.argsort(-self._some(likely).fit, kind="stable")]
        return self._some(np.append(likely, np.setdiff1d(self._exact, likely)))

    def _exactly(self) -> Exact | None:
        """Return those without an edit that are beside the others, if there are any."""
        exact = self._source.exact
        if exact is None or not len(self._exact):
            return None
        return exact.arranged(self._match[self._exact].tolist())

    def _hits(self, indices: Sequence[int]) -> list[Hit]:
        return [
            self._source.hit(
                int(self._plan[index]), int(self._match[index]), float(self._fit[index])
            )
            for index in indices
        ]

    def _some(self, chosen: AnyArray | slice) -> Found:
        return Found(self._source, self._plan[chosen], self._match[chosen])

    def clear(self) -> NDArray[np.float64]:
        """Return how clear each hit is, (H,) from 0 to 1."""
        return self.fit
