"""From a query to hits that are nearly what it says."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from itertools import islice

import numpy as np

from lanindex.errors import UsageError
from lanindex.model import Capture, Hit, Span, Track
from lanindex.model.columns import Columns, columns_of
from lanindex.search.automaton import Companion, Program, plan
from lanindex.search.fuzzy.allowance import Allowance
from lanindex.search.fuzzy.costs import UNIT
from lanindex.search.fuzzy.lines import Line
from lanindex.search.fuzzy.net import Net
from lanindex.search.fuzzy.wholes import Partners, Plan, Whole, limits_of
from lanindex.search.language.query import Bracket, Choice, Item, Lines, Query
from lanindex.search.language.query import Line as Steps
from lanindex.search.plain import TOLERANCE
from lanindex.search.plain.candidates import Recording
from lanindex.search.plain.walk import Walker

BATCH = 2000
"""Captures that are aligned at once."""


def find(
    query: Query,
    recordings: Iterable[tuple[Capture, Mapping[str, Track]]],
    allowance: Allowance,
    *,
    tolerance: Fraction = TOLERANCE,
    overlaps: str = "none",
) -> Iterator[Hit]:
    """Find what is nearly a pattern.

    Parameters
    ----------
    query : Query
        What to find.
    recordings : iterable of tuple of Capture and Mapping of str to Track
        Where.
    allowance : Allowance
        How much a match may differ.
    tolerance : Fraction, optional
        Seconds within which edges agree.
    overlaps : str, optional
        ``none``: of matches that share frames the one that differs least; ``all``: one for every
        place where some begin.

    Yields
    ------
    Hit
        Capture by capture as they come, in each by start and end. Its fit is the smallest margin
        of the symbols that are what was asked for, in proportion less for all that was edited.

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
    ...     recordings = list(library.tracks(parts=["torso"]))
    >>> [len(list(find(query, recordings, Allowance.read(it)))) for it in ("0", "0.5")]
    [2, 5]
    """
    if query.rhythm or query.where:
        raise UsageError(
            'a fuzzy search cannot count edits in "where" and "rhythm"',
            remedy="Leave them out, or search without --fuzzy.",
        )
    programs = plan(replace(query, pattern=_opened(query.pattern)))
    plans = [Plan.of(program, allowance) for program in programs]
    return _find(programs, plans, recordings, tolerance, overlaps)


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


def _find(
    programs: tuple[Program, ...],
    plans: list[Plan],
    recordings: Iterable[tuple[Capture, Mapping[str, Track]]],
    tolerance: Fraction,
    overlaps: str,
) -> Iterator[Hit]:
    left = iter(recordings)
    while captures := list(islice(left, BATCH)):
        batch = _Batch(captures)
        for number, (capture, tracks) in enumerate(captures):
            place = _Place(batch, number, programs, tolerance)
            best: dict[tuple[str, int], tuple[Whole, int]] = {}
            for one in plans:
                for whole in place.wholes(one):
                    known = best.get(whole.begins)
                    if known is None or whole.rank < known[0].rank:
                        best[whole.begins] = whole, one.steps
            for whole, steps in _kept(list(best.values()), overlaps):
                yield _hit(capture, tracks, number, whole, steps)


class _Batch:
    """Some captures, and the lines that were aligned with all of them at once."""

    def __init__(self, recordings: list[tuple[Capture, Mapping[str, Track]]]) -> None:
        self.recordings = recordings
        self._captures = [capture for capture, _ in recordings]
        self._columns: dict[str, Columns] = {}
        self._lines: dict[tuple[Net, int], Line] = {}

    def line(self, net: Net, most: int) -> Line:
        """Return a line with its matches, which cost no more than they may."""
        if net.part not in self._columns:
            tracks = [held.get(net.part) for _, held in self.recordings]
            self._columns[net.part] = columns_of(net.part, self._captures, tracks)
        if (net, most) not in self._lines:
            columns = self._columns[net.part]
            self._lines[net, most] = Line.of(net, columns, self._captures, most)
        return self._lines[net, most]


class _Place:
    """One capture of a batch."""

    def __init__(
        self, batch: _Batch, number: int, programs: tuple[Program, ...], tolerance: Fraction
    ) -> None:
        self._batch, self._number = batch, number
        self._programs, self._tolerance = programs, tolerance
        self.capture, self.tracks = batch.recordings[number]

    def wholes(self, one: Plan) -> Iterator[Whole]:
        """Yield what matches all lines, one for each row where the first begins."""
        lead = self._batch.line(one.net, one.most)
        found = lead.within(self._number, self.capture.frames)
        found = found.chosen(~found.alone)
        cost, beside = found.cost, []
        for it in one.beside:
            partners = Partners(it.relation, lead, found)
            limits = limits_of(self.capture, it.within, self._tolerance)
            for net in it.nets:
                line = self._batch.line(net, one.most)
                partners.consider(line, line.within(self._number, self.capture.frames), limits)
            beside.append(partners)
            cost = cost + partners.cost
        for index in np.flatnonzero(cost <= one.most).tolist():
            low, high = int(found.start[index]), int(found.until[index])
            rows = (lead, int(found.first[index]), int(found.last[index]))
            whole = Whole(low, high, int(cost[index]), (rows,))
            for partners in beside:
                whole = partners.joined(whole, index)
            if not any(self._disturbed(companion, whole) for companion in one.apart):
                yield whole

    @cached_property
    def _walker(self) -> Walker:
        return Walker(Recording(self.capture, self.tracks), self._programs, self._tolerance)

    def _disturbed(self, companion: Companion, whole: Whole) -> bool:
        """Tell whether a line happens that must not; to such a one no edits are allowed."""
        limits = limits_of(self.capture, companion.within, self._tolerance)
        reach = -1 if limits.most is None else limits.most
        for program in companion.programs:
            for path in self._walker.paths(program):
                between = max(path.start - whole.high, whole.low - path.until)
                near = between <= reach or companion.relation == "never"
                if near and not path.alone:
                    rows = (row for line in path.lines() for row in line)
                    if not any(whole.uses(*row) for row in rows):
                        return True
        return False


def _kept(wholes: list[tuple[Whole, int]], overlaps: str) -> list[tuple[Whole, int]]:
    """Return the matches that are shown, in order of time."""
    kept: list[tuple[Whole, int]] = []
    for whole, steps in sorted(wholes, key=lambda it: it[0].rank):
        alone = all(whole.high <= it.low or it.high <= whole.low for it, _ in kept)
        if overlaps == "all" or alone:
            kept.append((whole, steps))
    return sorted(kept, key=lambda it: (it[0].low, it[0].high))


def _hit(
    capture: Capture, tracks: Mapping[str, Track], number: int, whole: Whole, steps: int
) -> Hit:
    lines, fit = [], 1.0
    for line, first, last in whole.lines:
        symbols = tracks[line.net.part].listed()
        rows = line.rows(number, first, last)
        lines.append(tuple(symbols[row] for row, _ in rows))
        fit = min([fit, *(symbols[row].margin for row, fits in rows if fits)])
    edited = whole.cost / UNIT / steps
    return Hit(capture, Span(whole.low, whole.high), fit * max(1 - edited, 0), tuple(lines))
