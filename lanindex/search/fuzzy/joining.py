"""All lines of a pattern together: what goes with what, at the least cost."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import Columns, Roster
from lanindex.search.automaton import NEGATIONS, Companion, Program
from lanindex.search.fuzzy.align import Ask
from lanindex.search.fuzzy.costs import Allowance
from lanindex.search.fuzzy.lines import ENDLESS, LIFTED, Found, Line, bounds_of, fits, slack_of
from lanindex.search.fuzzy.net import Net, nets_of
from lanindex.search.fuzzy.windows import BoolArray, IntArray
from lanindex.search.language.query import Choice, Lines, Query
from lanindex.search.language.times import Length
from lanindex.search.match.arrays import smallest_in
from lanindex.search.match.finder import Finder, Recordings, Watch
from lanindex.search.match.hits import Found as Exact

NOBODY = 1 << 62
"""The place of the one that goes with a match, where none does."""

PAIRS = 1 << 20
"""Pairs that are compared at once."""


class Limits(NamedTuple):
    """How exactly edges must agree, and how many frames may lie between; (N,) by leading match.

    Without a limit of its own a line shares a frame where `most` is -1.
    """

    slack: IntArray
    least: IntArray
    most: IntArray


class Others:
    """The matches of another line, by how good they are: the cheapest, of these the first over."""

    def __init__(self, found: Found, ask: Ask) -> None:
        self.best = np.lexsort((found.until, found.cost))
        self._ask = ask
        order = np.lexsort((found.start, found.capture))
        places = np.empty(len(order), np.int64)
        places[self.best] = np.arange(len(order))
        lifted = found.capture * LIFTED
        self._start, self._until = lifted[order], lifted[order] + found.until[order]
        self._start = self._start + found.start[order]
        self._place = places[order]
        self._sizes = np.frexp((self._until - self._start).astype(np.float64))[1]
        by_end = np.argsort(lifted + found.until, kind="stable")
        self._ends, self._place_of_end = (lifted + found.until)[by_end], places[by_end]

    def starting(self, low: IntArray, high: IntArray) -> IntArray:
        """Return the place of the best one that begins in each stretch of frames, both included."""
        return _best(self._start, self._place, low, high)

    def ending(self, low: IntArray, high: IntArray) -> IntArray:
        """Return the place of the best one that is over in each stretch of frames."""
        return _best(self._ends, self._place_of_end, low, high)

    def covering(
        self, start: tuple[IntArray, IntArray], until: tuple[IntArray, IntArray]
    ) -> IntArray:
        """Return the place of the best one with both its start and its end in such stretches.

        Those of about one length are looked at together: few others begin where they might.
        """
        found = np.full(len(start[0]), NOBODY)
        for size in np.unique(self._sizes).tolist():
            own = np.flatnonzero(self._sizes == size)
            begins, ends, places = self._start[own], self._until[own], self._place[own]
            low = np.searchsorted(begins, np.maximum(start[0], until[0] - (1 << max(size, 0))))
            high = np.searchsorted(begins, np.minimum(start[1], until[1]), side="right")
            for lanes, pairs in _pairs(low, high):
                self._ask()
                fits = (until[0][lanes] <= ends[pairs]) & (ends[pairs] <= until[1][lanes])
                np.minimum.at(found, lanes[fits], places[pairs[fits]])
        return found


def _best(keys: IntArray, places: IntArray, low: IntArray, high: IntArray) -> IntArray:
    first = np.searchsorted(keys, low)
    behind = np.maximum(np.searchsorted(keys, high, side="right"), first)
    return smallest_in(places, first, behind, NOBODY)


def _pairs(low: IntArray, high: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield all pairs of a range and a place in it, for ranges ``[low, high)``, some at once."""
    sizes = np.maximum(high - low, 0)
    sums = np.concatenate([[0], np.cumsum(sizes)])
    for begin in range(0, int(sums[-1]), PAIRS):
        numbers = np.arange(begin, min(begin + PAIRS, int(sums[-1])))
        lanes = np.searchsorted(sums, numbers, side="right") - 1
        yield lanes, low[lanes] + numbers - sums[lanes]


class _Lifted(NamedTuple):
    """Leading matches, in frames that tell captures apart: from where to where, and theirs."""

    start: IntArray
    until: IntArray
    begin: IntArray
    end: IntArray


def _shares(line: _Lifted, others: Others, limits: Limits) -> IntArray:
    low, high = line.start - limits.most, line.until + limits.most
    low, high = np.maximum(low, line.begin), np.minimum(high, line.end)
    # what begins near enough is near enough; what begins before must last long enough
    return np.minimum(
        others.starting(low, high), others.covering((line.begin, low - 1), (low, line.end))
    )


def _around(frames: IntArray, limits: Limits) -> tuple[IntArray, IntArray]:
    return frames - limits.slack, frames + limits.slack


RELATIONS: dict[str, Callable[[_Lifted, Others, Limits], IntArray]] = {
    "with": _shares,
    "during": lambda line, others, _: others.covering(
        (line.begin, line.start), (line.until, line.end)
    ),
    "starting with": lambda line, others, limits: others.starting(*_around(line.start, limits)),
    "ending with": lambda line, others, limits: others.ending(*_around(line.until, limits)),
    "exactly with": lambda line, others, limits: others.covering(
        _around(line.start, limits), _around(line.until, limits)
    ),
    "after": lambda line, others, limits: others.ending(
        np.maximum(line.start - limits.most, line.begin), line.start - limits.least
    ),
    "before": lambda line, others, limits: others.starting(
        line.until + limits.least, np.minimum(line.until + limits.most, line.end)
    ),
}
"""By relation: the place of the best match of the other line that goes with each leading one."""

OUTSIDE = ("during", "after", "before")
"""Relations that add no frames to a hit."""


def partners(relation: str, found: Found, others: Found, limits: Limits, ask: Ask) -> IntArray:
    """Return which of the others goes best with each leading match: (N,) places; -1: none."""
    table = Others(others, ask)
    begin = found.capture * LIFTED
    line = _Lifted(begin + found.start, begin + found.until, begin, begin + LIFTED - 1)
    place = RELATIONS[relation](line, table, limits)
    there = place < NOBODY
    chosen = np.full(len(place), -1)
    chosen[there] = table.best[place[there]]
    return chosen


UNMATCHED = 1 << 40
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

    ``apart`` must not happen, and no edits are allowed to it; ``steps`` counts those of all other
    lines, ``most`` is what a match may cost, in parts of an edit.
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
    """The matches of a plan, (N,) by column.

    Attributes
    ----------
    cost, blur : ndarray
        Of all lines together, as in `Found`.
    lines : list of tuple of Line, Found
        All that matches are made of.
    own, places : ndarray
        (N, L) by line of the pattern which of these it is, and which match of that; the leading
        line comes first.
    """

    capture: IntArray
    low: IntArray
    high: IntArray
    cost: IntArray
    blur: IntArray
    lines: list[tuple[Line, Found]]
    own: IntArray
    places: IntArray

    def chosen(self, which: IntArray | BoolArray) -> Table:
        """Return some of them."""
        columns = {name: getattr(self, name)[which] for name in self._fields if name != "lines"}
        return self._replace(**columns)

    def frames(self) -> tuple[IntArray, IntArray]:
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
    """Sets the lines of a plan side by side; ``most`` and ``clear`` are as of `Line`."""

    def __init__(
        self, plan: Plan, roster: Roster, columns: Mapping[str, Columns], most: int, clear: int = 0
    ) -> None:
        self._plan, self._roster, self._most = plan, roster, most
        every = [(plan.net,), *(it.nets for it in plan.beside)]
        self._lines = [
            [Line(net, columns[net.part], roster, most, clear) for net in nets] for nets in every
        ]

    def found(self, among: IntArray | None, ask: Ask) -> tuple[IntArray | None, list[list[Found]]]:
        """Return in which of some captures all lines match, and all their matches there.

        The rarest line comes first: only where it matches the others are looked for.
        """
        rarity = [sum(line.rarity for line in sides) for sides in self._lines]
        found: list[list[Found]] = [[] for _ in rarity]
        for number in np.argsort(rarity, kind="stable").tolist():
            found[number] = [line.matches(among, ask) for line in self._lines[number]]
            among = np.unique(np.concatenate([it.capture for it in found[number]]))
        return among, found

    def bounds(self, steps: int, ask: Ask) -> tuple[IntArray, NDArray[np.float64]]:
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

    def table(self, among: IntArray | None, tolerance: Fraction, ask: Ask) -> Table:
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
        cost = np.full(len(lead.capture), UNMATCHED)
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

    def _limits(self, beside: Beside, tolerance: Fraction, capture: IntArray) -> Limits:
        places, own = np.unique(capture, return_inverse=True)
        roster = self._roster.taken(places)
        least, most = bounds_of(roster, beside.within)
        if beside.relation == "with":
            most = np.where(most >= ENDLESS, -1, most)
        return Limits(slack_of(roster, tolerance)[own], np.maximum(least, 0)[own], most[own])


def _column(every: list[Found], own: IntArray, place: IntArray, name: str) -> IntArray:
    """Return a column of matches, each of one of some tables."""
    column = np.zeros(len(own), np.int64)
    for number, found in enumerate(every):
        here = own == number
        column[here] = getattr(found, name)[place[here]]
    return column


def disturbed(
    apart: Apart,
    table: Table,
    roster: Roster,
    columns: Mapping[str, Columns],
    recordings: Recordings,
    tolerance: Fraction,
    watch: Watch | None,
) -> BoolArray:
    """Return which matches of a table a line disturbs that must not happen: (N,).

    The line is looked for exactly, by the engine.
    """
    if not len(table.capture):
        return np.zeros(0, np.bool_)

    def ask() -> None:
        if watch:
            watch(0, len(roster))

    places = np.unique(table.capture)
    parts, own_places, own_roster = apart.query.parts, places.tolist(), roster.taken(places)
    hits = Finder(
        apart.query,
        own_roster,
        {part: columns[part].taken(places) for part in parts},
        lambda some, parts: recordings([own_places[place] for place in some], parts),
        tolerance,
    ).find("all", watch)
    capture = np.searchsorted(places, table.capture)
    _, most = bounds_of(own_roster, apart.within)
    reach = np.where(most >= ENDLESS, -1, most)[capture]
    never = apart.relation == "never"
    low = np.where(never, 0, np.maximum(table.low - reach, 0)) + capture * LIFTED
    high = np.where(never, LIFTED - 1, table.high + reach) + capture * LIFTED
    near = _between(hits, low, high)
    if not {line.net.part for line, _ in table.lines} & parts:
        return near > 0
    # what a match is made of lies in its frames: any hit outside of them disturbs it
    begin, end = table.frames()
    low = np.maximum(low, begin + capture * LIFTED)
    high = np.minimum(high, end + capture * LIFTED)
    own = _between(hits, low, high)
    found: BoolArray = near > own
    asked = np.flatnonzero((near == own) & (own > 0))
    pairs = list(_overlapping(hits, low[asked], high[asked], ask))
    wanted = np.unique(np.concatenate([np.empty(0, np.int64), *pairs])).tolist()
    symbols = {}
    for index, hit in zip(wanted, hits.arranged(wanted), strict=True):
        symbols[index] = {(it.part, it.ordinal) for it in hit.symbols}
        ask()
    found[asked] = [
        not all(_share(table, match, symbols[index]) for index in inside.tolist())
        for match, inside in zip(asked.tolist(), pairs, strict=True)
    ]
    return found


def _overlapping(hits: Exact, low: IntArray, high: IntArray, ask: Ask) -> Iterator[IntArray]:
    """Yield the hits, in order of capture and start, that reach into each such stretch."""
    begins, ends = hits.place * LIFTED + hits.low, hits.place * LIFTED + hits.high
    longest = int((ends - begins).max(initial=0))
    first = np.searchsorted(begins, low - longest).tolist()
    behind = np.searchsorted(begins, high, side="right").tolist()
    for begin, end, least in zip(first, behind, low.tolist(), strict=True):
        ask()
        yield np.flatnonzero(ends[begin:end] >= least) + begin


def _between(hits: Exact, low: IntArray, high: IntArray) -> IntArray:
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
