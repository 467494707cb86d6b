"""Query + columns → hits: where they are in all captures at once, objects of those asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache

import numpy as np

from lanindex.model import Capture, Hit, Span, Symbol, Track
from lanindex.model.columns import THOUSANDTHS, Columns, Roster
from lanindex.model.symbol import listed
from lanindex.search import plain
from lanindex.search.automaton import Program, plan
from lanindex.search.fast import overlaps as staying
from lanindex.search.fast.answers import Answers, best, joined, of_line, roots
from lanindex.search.fast.arrows import NONE
from lanindex.search.fast.block import Block
from lanindex.search.fast.lines import Backwards, remembers, value_of
from lanindex.search.fast.ragged import Mask, Whole
from lanindex.search.fast.trace import trace
from lanindex.search.language.query import Query

Recordings = Callable[[Sequence[int]], Iterable[tuple[Capture, Mapping[str, Track]]]]
"""Captures with their tracks, by their places in the roster."""

MOST_ROWS = 1 << 18
"""How many rows of a part, or captures, are gone through at once."""

Watch = Callable[[int, int], None]
"""Is told, now and then, how many captures are done, of how many; it may raise."""


class Found:
    """The hits of a search as columns; each is made an object when it is asked for.

    Attributes
    ----------
    capture, low, high : ndarray
        (H,) int64: the place in the roster, and frames of the source, half-open.
    """

    def __init__(self, finder: Finder, answers: Answers, known: dict[int, list[Hit]]) -> None:
        self._finder, self._answers, self._known = finder, answers, known
        self.capture, self.low, self.high = answers.capture, answers.low, answers.high

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._answers)

    def __getitem__(self, index: int) -> Hit:
        """Return one hit."""
        place = range(len(self))[index]
        capture = int(self.capture[place])
        if capture in self._known:
            return self._known[capture][int(self._answers.rows[place, 0])]
        return self._finder.hit(self._answers.at(np.array([place])))


class Finder:
    """Searches for one query.

    Parameters
    ----------
    query : Query
        What to find.
    roster : Roster
        All captures.
    columns : Mapping of str to Columns
        The symbols of the query's parts; a part that is not there never moves.
    recordings : callable
        Gives captures and tracks, by places in the roster: of hits that are made objects, and of
        captures that only the plain matcher can tell about.
    tolerance : Fraction
        Seconds within which edges agree.
    """

    def __init__(
        self,
        query: Query,
        roster: Roster,
        columns: Mapping[str, Columns],
        recordings: Recordings,
        tolerance: Fraction = plain.TOLERANCE,
    ) -> None:
        self._query, self._roster, self._columns = query, roster, columns
        self._tolerance = tolerance
        self._programs = plan(query)
        self._parts: list[tuple[str, ...]] = []
        self._recording = lru_cache(maxsize=2)(lambda place: next(iter(recordings([place]))))
        self._recordings = recordings

    def find(self, overlaps: str = "none", watch: Watch | None = None) -> Found:
        """Return all hits.

        Parameters
        ----------
        overlaps : str
            ``none`` or ``all``, as in `lanindex.search.plain.find`.
        watch : callable, optional
            Is told how far the search is.
        """
        pieces: list[Answers] = []
        known: dict[int, list[Hit]] = {}
        for first, last in self._blocks():
            if watch:
                watch(first, len(self._roster))
            answers, doubtful = self._in_block(self._block(first, last))
            pieces.append(replace(answers, capture=answers.capture + first))
            told = self._told_plainly(np.flatnonzero(doubtful) + first)
            known.update(told)
            pieces += [_columns_of(place, hits) for place, hits in told.items()]
        answers = joined(pieces)
        answers = answers.at(np.argsort(answers.capture, kind="stable"))
        return Found(self, self._kept(answers, overlaps), known)

    def hit(self, answer: Answers) -> Hit:
        """Return the one answer of a table as an object."""
        place = int(answer.capture[0])
        taken = trace(
            self._block(place, place + 1),
            self._programs[int(answer.program[0])],
            self._parts[int(answer.parts[0])],
            tuple(answer.rows[0].tolist()),
            int(value_of(answer.high, answer.cost)[0]),
        )
        capture, tracks = self._recording(place)
        span = Span(int(answer.low[0]), int(answer.high[0]))
        rows = dict.fromkeys(row for it in taken for row in it.rows)
        symbols = {(part, row): _symbol(tracks[part], row) for part, row in rows}
        return Hit(
            capture,
            span,
            min(symbol.margin for symbol in symbols.values()),
            (tuple(symbols.values()),),
        )

    def _block(self, first: int, last: int) -> Block:
        return Block(self._roster, self._columns, first, last, self._tolerance)

    def _blocks(self) -> list[tuple[int, int]]:
        """Return how the captures are gone through: a block holds few enough rows."""
        parts = [self._columns[part] for part in self._query.parts if part in self._columns]
        ends, first, many = [], 0, len(self._roster)
        while first < many:
            last = min(first + MOST_ROWS, many)
            for columns in parts:
                limit = columns.bounds[first] + MOST_ROWS
                last = min(last, int(np.searchsorted(columns.bounds, limit, "right")) - 1)
            ends.append((first, max(last, first + 1)))
            first = ends[-1][1]
        return ends

    def _in_block(self, block: Block) -> tuple[Answers, Mask]:
        """Return all answers in a block, and the captures of which nothing is known yet."""
        found: list[Answers] = []
        doubtful = np.zeros(len(block), bool)
        for number, program in enumerate(self._programs):
            if remembers(program) or self._query.rhythm or self._query.where:
                doubtful |= possible(block, program)
            else:
                answers, doubts = of_line(block, number, program, self._parts)
                found += answers
                doubtful |= doubts
        answers = joined(found)
        answers = best(answers.at(~doubtful[answers.capture]))
        return self._from_own_rows(block, answers), doubtful

    def _from_own_rows(self, block: Block, answers: Answers) -> Answers:
        """Return answers whose rows are counted in their own captures."""
        rows = answers.rows.copy()
        for place, parts in enumerate(self._parts):
            own = answers.parts == place
            for member, part in enumerate(parts):
                rows[own, member] -= block.rows(part).bounds[answers.capture[own]]
        return replace(answers, rows=rows)

    def _kept(self, answers: Answers, overlaps: str) -> Answers:
        if overlaps == "all":
            return answers
        if not staying.counts(self._query):
            answers = answers.at(staying.nearest(answers.capture, answers.low, answers.high))
        return answers.at(staying.from_left(answers.capture, answers.low, answers.high))

    def _told_plainly(self, places: Whole) -> dict[int, list[Hit]]:
        """Return what the plain matcher finds in some captures, overlapping or not."""
        if not len(places):
            return {}
        recordings = list(self._recordings(places.tolist()))
        hits = plain.find(self._query, recordings, tolerance=self._tolerance, overlaps="all")
        own = {capture.id: place for place, (capture, _) in zip(places, recordings, strict=True)}
        told: dict[int, list[Hit]] = {int(place): [] for place in places}
        for hit in hits:
            told[int(own[hit.capture.id])].append(hit)
        return told


def possible(block: Block, program: Program) -> Mask:
    """Tell in which captures a program can match at all: with all that it remembers left out."""
    found = _line_possible(block, program)
    for companion in program.whole.companions:
        if companion.relation not in ("without", "never"):
            found &= np.any([possible(block, inner) for inner in companion.programs], axis=0)
    return found


def _line_possible(block: Block, program: Program) -> Mask:
    backwards = Backwards(block, program)
    found = np.zeros(len(block), bool)
    for entry in program.entries:
        fits = roots(block, program, entry) & (backwards.values[entry.state] < NONE)
        found[block.events(program.states[entry.state]).capture[fits]] = True
    return found


def _columns_of(place: int, hits: list[Hit]) -> Answers:
    """Return the hits of a capture as columns."""
    nothing = np.full(len(hits), -1)
    own = np.stack((np.arange(len(hits)), nothing), axis=1)  # which hit of the capture it is
    return Answers(
        np.full(len(hits), place),
        np.array([hit.span.start for hit in hits], np.int64),
        np.array([hit.span.stop for hit in hits], np.int64),
        np.array([round((1 - hit.fit) * THOUSANDTHS) for hit in hits], np.int64),
        *(nothing, nothing, own),
    )


def _symbol(track: Track, row: int) -> Symbol:
    (symbol,) = listed(track.part, track.symbols[row : row + 1])
    return replace(symbol, ordinal=row)
