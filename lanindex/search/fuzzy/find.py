"""From a query to hits that are nearly what it says."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import UsageError
from lanindex.model import Capture, Hit, Span, Symbol, Track
from lanindex.model.columns import Columns, Roster
from lanindex.search.automaton import plan
from lanindex.search.fuzzy.allowance import Allowance
from lanindex.search.fuzzy.costs import UNIT
from lanindex.search.fuzzy.lines import Line, clock_of
from lanindex.search.fuzzy.net import Net
from lanindex.search.fuzzy.wholes import Apart, Partners, Plan, Whole, limits_of
from lanindex.search.language.query import Bracket, Choice, Item, Lines, Query
from lanindex.search.language.query import Line as Steps
from lanindex.search.plain import TOLERANCE
from lanindex.search.plain import find as find_exactly

BLOCK = 1 << 16
"""Captures that are aligned at once."""

Watch = Callable[[int, int], None]

Recordings = Callable[[Sequence[int]], Iterable[tuple[Capture, Mapping[str, Track]]]]
"""Captures with their tracks, by their places in the roster."""


def find(
    query: Query,
    roster: Roster,
    columns: Mapping[str, Columns],
    recordings: Recordings,
    allowance: Allowance,
    *,
    tolerance: Fraction = TOLERANCE,
    overlaps: str = "none",
    watch: Watch | None = None,
) -> Iterator[Hit]:
    """Find what is nearly a pattern.

    Parameters
    ----------
    query : Query
        What to find.
    roster : Roster
        Where.
    columns : Mapping of str to Columns
        Of all ``query.parts``.
    recordings : callable
        Gives the captures that have hits, by their places in the roster.
    allowance : Allowance
        How much a match may differ.
    tolerance : Fraction, optional
        Seconds within which edges agree.
    overlaps : str, optional
        ``none``: of matches that share frames the one that differs least; ``all``: one for every
        place where some begin.
    watch : callable, optional
        Is told now and then how many captures are done, of how many; it may raise.

    Yields
    ------
    Hit
        By capture, start and end. Its fit is the smallest margin of the symbols that are what was
        asked for, in proportion less for all that was edited.

    Raises
    ------
    UsageError
        Where the pattern says what has no edits.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.search.fuzzy import Allowance, find
    >>> from lanindex.search.language import parse
    >>> query = parse("torso forward mid -> place high")
    >>> with lanindex.open_library("dance.db") as library:
    ...     roster, columns = library.columns(query.parts)
    ...     held = list(library.tracks(parts=query.parts))
    ...     for allowed in ("0", "0.5"):
    ...         hits = find(
    ...             query, roster, columns, lambda places: [held[it] for it in places],
    ...             Allowance.read(allowed),
    ...         )
    ...         print(len(list(hits)))
    2
    3
    """
    if query.rhythm or query.where:
        raise UsageError(
            'a fuzzy search cannot count edits in "where" and "rhythm"',
            remedy="Leave them out, or search without --fuzzy.",
        )
    plans = [
        Plan.of(program, lines, allowance)
        for pattern in query.patterns
        for lines in _opened(pattern).alternatives
        for program in plan(Query(Choice((lines,))))
    ]
    for first in range(0, len(roster), BLOCK):
        block = _Block(roster, columns, first, min(first + BLOCK, len(roster)))
        places = np.flatnonzero(block.possible(plans)).tolist()
        held = recordings([first + place for place in places])
        for place, (capture, tracks) in zip(places, held, strict=True):
            if watch:
                watch(first + place, len(roster))
            there = _Place(block, place, (capture, tracks), tolerance)
            yield from _hits(there, plans, overlaps)


def _opened(pattern: Choice) -> Choice:
    """Return a pattern without brackets around all of it, such as a pasted score has."""
    opened: list[Lines] = []
    for lines in pattern.alternatives:
        (item, *more) = lines.first.items
        bare = Steps((Item(item.unit),)) == lines.first and not more
        if isinstance(item.unit, Bracket) and bare:
            opened += [
                Lines(inner.first, (*inner.others, *lines.others))
                for inner in _opened(item.unit.pattern).alternatives
            ]
        else:
            opened.append(lines)
    return Choice(tuple(opened))


def _hits(place: _Place, plans: list[Plan], overlaps: str) -> Iterator[Hit]:
    """Yield the hits in a capture, in order of time."""
    best: dict[tuple[str, int], tuple[Whole, int]] = {}
    for one in plans:
        for whole in place.wholes(one):
            known = best.get(whole.begins)
            if known is None or whole.rank < known[0].rank:
                best[whole.begins] = whole, one.steps
    for whole, steps in _kept(list(best.values()), overlaps):
        yield place.hit(whole, steps)


class _Block:
    """Some captures of a roster, and the lines that were aligned with all of them at once."""

    def __init__(
        self, roster: Roster, columns: Mapping[str, Columns], first: int, last: int
    ) -> None:
        own = slice(first, last)
        self.roster = Roster(
            roster.number[own], roster.frames[own], roster.rate[own], roster.speed[own]
        )
        self._columns = {part: held.between(first, last) for part, held in columns.items()}
        self._lines: dict[tuple[Net, int], Line] = {}

    def line(self, net: Net, most: int) -> Line:
        """Return a line with its matches, which cost no more than they may."""
        if (net, most) not in self._lines:
            columns = self._columns[net.part]
            self._lines[net, most] = Line.of(net, columns, self.roster, most)
        return self._lines[net, most]

    def possible(self, plans: list[Plan]) -> NDArray[np.bool_]:
        """Return in which captures a plan may have a hit: each of its lines matches there."""
        possible = np.zeros(len(self.roster), np.bool_)
        for one in plans:
            every = self.line(one.net, one.most).captures
            for it in one.beside:
                every &= np.any([self.line(net, one.most).captures for net in it.nets], axis=0)
            possible |= every
        return possible


class _Place:
    """One capture of a block."""

    def __init__(
        self,
        block: _Block,
        place: int,
        recording: tuple[Capture, Mapping[str, Track]],
        tolerance: Fraction,
    ) -> None:
        self._block, self._place, self._recording = block, place, recording
        self._frames = int(block.roster.frames[place])
        self._clock = clock_of(block.roster.rate[place], block.roster.speed[place])
        self._tolerance = tolerance
        self._found: dict[Query, list[Hit]] = {}
        self._symbols: dict[str, list[Symbol]] = {}

    def wholes(self, one: Plan) -> Iterator[Whole]:
        """Yield what matches all lines, one for each row where the first begins."""
        lead = self._block.line(one.net, one.most)
        found = lead.within(self._place, self._frames)
        found = found.chosen(~found.alone)
        cost, beside = found.cost, []
        for it in one.beside:
            partners = Partners(it.relation, lead, found)
            limits = limits_of(self._clock, it.within, self._tolerance)
            for net in it.nets:
                line = self._block.line(net, one.most)
                partners.consider(line, line.within(self._place, self._frames), limits)
            beside.append(partners)
            cost = cost + partners.cost
        for index in np.flatnonzero(cost <= one.most).tolist():
            low, high = int(found.start[index]), int(found.until[index])
            rows = (lead, int(found.first[index]), int(found.last[index]))
            whole = Whole(low, high, int(cost[index]), (rows,))
            for partners in beside:
                whole = partners.joined(whole, index)
            if not any(self._disturbed(it, whole) for it in one.apart):
                yield whole

    def _disturbed(self, apart: Apart, whole: Whole) -> bool:
        """Tell whether a line has a hit that it must not have."""
        if apart.query not in self._found:
            hits = find_exactly(
                apart.query, [self._recording], tolerance=self._tolerance, overlaps="all"
            )
            self._found[apart.query] = list(hits)
        limits = limits_of(self._clock, apart.within, self._tolerance)
        reach = -1 if limits.most is None else limits.most
        return any(
            apart.relation == "never" or max(hit.start - whole.high, whole.low - hit.stop) <= reach
            for hit in self._found[apart.query]
            if not any(whole.uses(it.part, it.ordinal) for it in hit.symbols)
        )

    def hit(self, whole: Whole, steps: int) -> Hit:
        """Return a match as a hit."""
        capture, tracks = self._recording
        lines, fit = [], 1.0
        for line, first, last in whole.lines:
            part = line.net.part
            if part not in self._symbols:
                self._symbols[part] = tracks[part].listed()
            rows = line.rows(self._place, first, last)
            lines.append(tuple(self._symbols[part][row] for row, _ in rows))
            fit = min([fit, *(self._symbols[part][row].margin for row, fits in rows if fits)])
        edited = whole.cost / UNIT / steps
        return Hit(capture, Span(whole.low, whole.high), fit * max(1 - edited, 0), tuple(lines))


def _kept(wholes: list[tuple[Whole, int]], overlaps: str) -> list[tuple[Whole, int]]:
    """Return the matches that are shown, in order of time."""
    kept: list[tuple[Whole, int]] = []
    for whole, steps in sorted(wholes, key=lambda it: it[0].rank):
        alone = all(whole.high <= it.low or it.high <= whole.low for it, _ in kept)
        if overlaps == "all" or alone:
            kept.append((whole, steps))
    return sorted(kept, key=lambda it: (it[0].low, it[0].high))
