"""All lines of a pattern together: what goes with what, at the least cost."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import Columns, Roster
from lanindex.search.automaton import NEGATIONS, Companion, Program
from lanindex.search.fuzzy.align import Ask
from lanindex.search.fuzzy.allowance import Allowance
from lanindex.search.fuzzy.beside import OUTSIDE, Limits, partners
from lanindex.search.fuzzy.clocks import ENDLESS, bounds_of, slack_of
from lanindex.search.fuzzy.lines import Found, Line, fits
from lanindex.search.fuzzy.net import Net, nets_of
from lanindex.search.language.query import Choice, Lines, Query
from lanindex.search.language.times import Length

Whole = NDArray[np.int64]
Mask = NDArray[np.bool_]


NOBODY = 1 << 40
"""What it costs where no match goes with another."""


class Beside(NamedTuple):
    """A line that must lie beside the leading one: how, one net a side, how far at most."""

    relation: str
    nets: tuple[Net, ...]
    within: Length | None = None


class Apart(NamedTuple):
    """A line that must not happen: how near, and what is looked for."""

    relation: str
    query: Query
    within: Length | None


class Plan(NamedTuple):
    """What a leading line asks for.

    Attributes
    ----------
    net : Net
        The leading line.
    beside : tuple of Beside
        Those that must lie beside it.
    apart : tuple of Apart
        Those that must not; no edits are allowed to them.
    steps : int
        Of all lines but those.
    most : int
        What a match may cost, in parts of an edit.
    """

    net: Net
    beside: tuple[Beside, ...]
    apart: tuple[Apart, ...]
    steps: int
    most: int

    @property
    def leaps(self) -> bool:
        """Whether another end than the nearest may go with what is asked for beside it."""
        nets = self.net, *(net for one in self.beside for net in one.nets)
        return bool(self.beside or self.apart) and any(net.leaps for net in nets)

    @classmethod
    def of(cls, program: Program, lines: Lines, allowance: Allowance) -> Plan:
        """Return the plan of a program of some lines.

        Raises
        ------
        UsageError
            Where it says what has no edits.
        """
        net, *halves = nets_of(program)
        beside = [Beside("with", (half,)) for half in halves]
        for companion in program.whole.companions:
            if companion.relation not in NEGATIONS:
                beside += _beside(companion)
        apart = tuple(
            Apart(it.relation, Query(Choice((Lines(it.line),))), it.within)
            for it in lines.others
            if it.relation in NEGATIONS
        )
        steps = len(net.states) + sum(max(len(it.states) for it in one.nets) for one in beside)
        dearest = net.dearest + sum(max(it.dearest for it in one.nets) for one in beside)
        return cls(net, tuple(beside), apart, steps, min(allowance.of(steps), dearest))


def _beside(companion: Companion) -> list[Beside]:
    """Return a line beside the leading one; where two parts move at once, one for each."""
    sides = [nets_of(program) for program in companion.programs]
    return [Beside(companion.relation, nets, companion.within) for nets in zip(*sides, strict=True)]


class Table(NamedTuple):
    """The matches of a plan.

    Attributes
    ----------
    capture, low, high : ndarray
        (N,) where, and the frames of it.
    cost, blur : ndarray
        (N,) of all lines together, as in `lanindex.search.fuzzy.lines.Found`.
    lines : list of tuple of Line, Found
        All that matches are made of.
    own : ndarray
        (N, L) by line of the pattern which of these it is; the leading line comes first.
    places : ndarray
        (N, L) which match of that.
    """

    capture: Whole
    low: Whole
    high: Whole
    cost: Whole
    blur: Whole
    lines: list[tuple[Line, Found]]
    own: Whole
    places: Whole

    def chosen(self, which: Whole | Mask) -> Table:
        """Return some of them."""
        columns = {name: getattr(self, name)[which] for name in self._fields if name != "lines"}
        return self._replace(**columns)

    def frames(self) -> tuple[Whole, Whole]:
        """Return from where to where the symbols of each match lie, (N,) each."""
        low, high = self.low.copy(), self.high.copy()
        for number, (line, found) in enumerate(self.lines):
            match, column = np.nonzero(self.own == number)
            place = self.places[match, column]
            start, stop = line.columns.start[found.first[place]], found.until[place]
            np.minimum.at(low, match, start)
            np.maximum.at(high, match, stop)
        return low, high

    def rows(self, match: int) -> list[tuple[Line, int, int, int]]:
        """Return the lines of a match, each with its first and last row, and what it costs."""
        found = []
        for own, place in zip(self.own[match].tolist(), self.places[match].tolist(), strict=True):
            line, matches = self.lines[own]
            columns = matches.first, matches.last, matches.cost
            found.append((line, *(int(column[place]) for column in columns)))
        return found


class Joining:
    """Sets the lines of a plan side by side.

    Parameters
    ----------
    plan : Plan
        What is looked for.
    roster : Roster
        Where.
    columns : Mapping of str to Columns
        Of all parts.
    most : int
        What a match may cost.
    clear : int
        As of `Line`.
    """

    def __init__(
        self, plan: Plan, roster: Roster, columns: Mapping[str, Columns], most: int, clear: int = 0
    ) -> None:
        self._plan, self._roster, self._most = plan, roster, most
        every = [(plan.net,), *(it.nets for it in plan.beside)]
        self._lines = [
            [Line(net, columns[net.part], roster, most, clear) for net in nets] for nets in every
        ]

    def found(self, among: Whole | None, ask: Ask) -> tuple[Whole | None, list[list[Found]]]:
        """Return in which of some captures all lines match, and all their matches there.

        The rarest line comes first: only where it matches the others are looked for.
        """
        rarity = [sum(line.rarity for line in sides) for sides in self._lines]
        found: list[list[Found]] = [[] for _ in rarity]
        for number in np.argsort(rarity, kind="stable").tolist():
            found[number] = [line.matches(among, ask) for line in self._lines[number]]
            among = np.unique(np.concatenate([it.capture for it in found[number]]))
        return among, found

    def bounds(self, steps: int, ask: Ask) -> tuple[Whole, NDArray[np.float64]]:
        """Return the captures in which all lines match, and how well a hit fits there at most."""
        among, found = self.found(None, ask)
        places = np.empty(0, np.int64) if among is None else among
        least = np.ones(len(places))
        for sides in found:
            best = np.zeros(len(places))
            for matches in sides:
                own = np.searchsorted(places, matches.capture)
                inside = own < len(places)
                inside[inside] = places[own[inside]] == matches.capture[inside]
                fit = fits(matches.cost[inside], matches.blur[inside], steps)
                np.maximum.at(best, own[inside], fit)
            least = np.minimum(least, best)
        return places, least

    def table(self, among: Whole | None, tolerance: Fraction, ask: Ask) -> Table:
        """Return what matches all lines in some captures, one for each row the first begins."""
        _, ((lead,), *others) = self.found(among, ask)
        flat = [(line, found) for sides, every in zip(self._lines, [[lead], *others], strict=True)
                for line, found in zip(sides, every, strict=True)]  # fmt: skip
        many = len(lead.capture)
        table = Table(
            *(lead.capture, lead.start, lead.until, lead.cost, lead.blur, flat),
            *(np.zeros((many, 1), np.int64), np.arange(many)[:, None]),
        )
        first = 1
        for beside, every in zip(self._plan.beside, others, strict=True):
            table = self._joined(table, beside, every, first, tolerance, ask)
            first += len(every)
        return table

    def _joined(
        self,
        table: Table,
        beside: Beside,
        every: list[Found],
        first: int,
        tolerance: Fraction,
        ask: Ask,
    ) -> Table:
        """Return a table with another line: of its matches, of either side, the cheapest ones."""
        lead = table.lines[0][1].chosen(table.places[:, 0])
        limits = self._limits(beside, tolerance, lead.capture)
        cost = np.full(len(lead.capture), NOBODY)
        own, place = np.zeros((2, len(cost)), np.int64)
        for number, found in enumerate(every):
            chosen = partners(beside.relation, lead, found, limits, ask)
            there = chosen >= 0
            if beside.relation == "with" and beside.nets[number].part == self._plan.net.part:
                there &= limits.most > 0  # no two movements of one part share a frame
            there[there] = found.cost[chosen[there]] < cost[there]
            cost[there] = found.cost[chosen[there]]
            own[there], place[there] = first + number, chosen[there]
        kept = np.flatnonzero(table.cost + cost <= self._most)
        joined = table.chosen(kept)
        columns = [
            _column(every, own[kept] - first, place[kept], name)
            for name in ("start", "until", "blur")
        ]
        low, high = joined.low, joined.high
        if beside.relation not in OUTSIDE:
            low, high = np.minimum(low, columns[0]), np.maximum(high, columns[1])
        return joined._replace(
            low=low,
            high=high,
            cost=joined.cost + cost[kept],
            blur=np.maximum(joined.blur, columns[2]),
            own=np.column_stack((joined.own, own[kept])),
            places=np.column_stack((joined.places, place[kept])),
        )

    def _limits(self, beside: Beside, tolerance: Fraction, capture: Whole) -> Limits:
        places, own = np.unique(capture, return_inverse=True)
        roster = self._roster.taken(places)
        least, most = bounds_of(roster, beside.within)
        if beside.relation == "with":
            most = np.where(most >= ENDLESS, -1, most)
        return Limits(slack_of(roster, tolerance)[own], np.maximum(least, 0)[own], most[own])


def _column(every: list[Found], own: Whole, place: Whole, name: str) -> Whole:
    """Return a column of matches, each of one of some tables."""
    column = np.zeros(len(own), np.int64)
    for number, found in enumerate(every):
        here = own == number
        column[here] = getattr(found, name)[place[here]]
    return column
