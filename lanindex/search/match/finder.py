"""A query searched in columns: where its hits are in all captures, objects of those asked for."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

import numpy as np

from lanindex.errors import LanindexError, OutOfMemoryError
from lanindex.model import Capture, Hit, Span, Symbol, Track
from lanindex.model.columns import THOUSANDTHS, Columns, Roster, columns_of, roster_of
from lanindex.model.symbol import joined as rows_joined
from lanindex.model.symbol import listed
from lanindex.search.automaton import Program, counts, plan
from lanindex.search.conditions import holds
from lanindex.search.language.query import Query
from lanindex.search.language.times import TOLERANCE
from lanindex.search.match import hit_table, prefilter
from lanindex.search.match.arrays import IntArray
from lanindex.search.match.batch import Batch, split
from lanindex.search.match.budget import TooMuch, limited_to
from lanindex.search.match.conditions import Clauses
from lanindex.search.match.context import Context
from lanindex.search.match.hit_table import HitTable, best, joined, own_rows
from lanindex.search.match.hits import Found, Told, labelled
from lanindex.search.match.leading import hits_of, may_match
from lanindex.search.match.mirror_runs import repeats
from lanindex.search.match.rewrites import Rewrites
from lanindex.search.match.trace import Place, Tracer

Recordings = Callable[
    [Sequence[int], Collection[str]], Iterable[tuple[Capture, Mapping[str, Track]]]
]
"""Captures with the tracks of some parts, by their places in the roster."""


@dataclass(slots=True)
class Source:
    """What columns do not tell of the captures of a batch."""

    recordings: Recordings
    places: IntArray
    batch: Batch
    programs: tuple[Program, ...]

    def captures(self, places: Sequence[int]) -> list[Capture]:
        """Return captures by their places in the batch."""
        return [it for it, _ in self.recordings(self.places[list(places)].tolist(), ())]

    def swings(self, part: str) -> IntArray:
        """Return how often each row of a part swings, -1 where nothing can match anyway."""
        rows = self.batch.rows(part)
        found = np.full(len(rows), -1)
        matching = np.any([may_match(self.batch, it) for it in self.programs], axis=0)
        places = np.flatnonzero(matching & (np.diff(rows.bounds) > 0))
        recordings = self.recordings(self.places[places].tolist(), (part,))
        for place, (_, tracks) in zip(places.tolist(), recordings, strict=True):
            found[slice(*rows.bounds[place : place + 2])] = tracks[part].symbols["swings"]
        return found


MANY = 1000
"""Captures of which it is asked first which of them can have a hit."""

MOST_ROWS = 1 << 16
"""How many rows of a part, or captures, are gone through at once."""

NARROWER = 'Bound what it tries: write "...[<5s]" for "...", or search fewer captures.'
"""What to do where a search takes too much time or memory."""

Watch = Callable[[int, int], None]
"""Is told, now and then, how many captures are done, of how many; it may raise."""


Recording = tuple[Capture, Mapping[str, Track]]
"""A capture, and its tracks by part."""


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
        Gives captures and tracks, by places in the roster: of hits that are made objects.
    tolerance : Fraction
        Seconds within which edges agree.
    memory : int, optional
        Bytes that the search may take, besides its columns and hits; a quarter of what is free.
    """

    def __init__(
        self,
        query: Query,
        roster: Roster,
        columns: Mapping[str, Columns],
        recordings: Recordings,
        tolerance: Fraction = TOLERANCE,
        memory: int | None = None,
    ) -> None:
        self._memory = memory
        self._query, self._roster, self._columns = query, roster, columns
        self._tolerance = tolerance
        self._programs = plan(query)
        self._rewrites = [Rewrites(it) for it in self._programs]
        self._parts: list[tuple[str, ...]] = []
        self._recordings = recordings
        self._fetched: dict[int, Recording] = {}
        self._clauses = Clauses(query)
        self._watch: Watch | None = None
        self._meet: dict[int, bool] = {}

    def find(
        self,
        overlaps: str = "none",
        watch: Watch | None = None,
        best: int | None = None,
        refused: list[LanindexError] | None = None,
    ) -> Found:
        """Return all hits.

        Parameters
        ----------
        overlaps : str
            ``none``: from left to right, those that begin when the one before is over; ``all``: one
            for every place where the pattern can start.
        watch : callable, optional
            Is told how far the search is.
        best : int, optional
            Only so many, those that fit best, the clearest first.
        refused : list of LanindexError, optional
            Takes an error for each capture that is too rich for the pattern, or for the memory;
            the others are answered. None: the first one is raised.
        """
        self._refused: dict[int, LanindexError] = {}
        batches = split(self._columns.values(), self._possible(), MOST_ROWS)
        with limited_to(self._memory):
            answers = joined([it for places in batches for it in self._among(places, watch)])
        errors = [self._refused[place] for place in sorted(self._refused)]
        if refused is None and errors:
            raise errors[0]
        if refused is not None:
            refused += errors
        if (answers.capture[1:] < answers.capture[:-1]).any():
            answers = answers.at(np.argsort(answers.capture, kind="stable"))
        answers = self._in_those_asked_for(answers)
        found = Found(self, answers, self._kept(answers, overlaps))
        if best is None:
            return found
        self._watch = watch  # not of hits that are looked at later on
        found = found.by_fit(best)[:best]
        self._watch = None
        return found

    def fetch(self, places: Sequence[int]) -> None:
        """Fetch captures of which hits will be made objects; forget the others."""
        self._fetched = dict(zip(places, self._recordings(places, self._query.parts), strict=True))

    def captures(self, places: Sequence[int]) -> list[Capture]:
        """Return captures by their places in the roster."""
        return [capture for capture, _ in self._recordings(places, ())]

    def numbers(self, places: IntArray) -> IntArray:
        """Return the numbers of captures by their places in the roster."""
        return self._roster.number[places]

    def hits(self, answers: HitTable) -> list[Hit]:
        """Return the answers of a table as objects."""
        captures = answers.capture.tolist()
        if not self._fetched.keys() >= {*captures}:
            self.fetch(sorted({*captures}))
        with limited_to(self._memory):
            told = self._told(answers)
        wanted: dict[str, dict[tuple[int, int], None]] = {}
        for place, one in zip(captures, told, strict=True):
            for part, row in (row for line in one.lines for it in line for row in it.rows):
                wanted.setdefault(part, {})[place, row] = None
        symbols: dict[tuple[int, str, int], Symbol] = {}
        for part, rows in wanted.items():
            tracks = ((self._fetched[place][1][part], row) for place, row in rows)
            table = rows_joined(track.symbols[row : row + 1] for track, row in tracks)
            made = listed(part, table, [row for _, row in rows])
            symbols.update(
                ((place, part, row), it) for (place, row), it in zip(rows, made, strict=True)
            )
        low, high = answers.low.tolist(), answers.high.tolist()
        return [
            self._hit(one, place, Span(*span), symbols)
            for one, place, *span in zip(told, captures, low, high, strict=True)
        ]

    def _hit(
        self, told: Told, place: int, span: Span, symbols: Mapping[tuple[int, str, int], Symbol]
    ) -> Hit:
        """Return a hit as an object."""
        taken = [it for line in told.lines for it in line]
        own = {row: symbols[(place, *row)] for it in taken for row in it.rows}
        lines = tuple(
            tuple(own[row] for row in dict.fromkeys(row for it in line for row in it.rows))
            for line in told.lines
        )
        fit = (THOUSANDTHS - told.cost) / THOUSANDTHS
        return Hit(self._fetched[place][0], span, fit, lines, labelled(taken, own))

    def _told(self, answers: HitTable) -> list[Told]:
        """Return what each line of hits took; rows are counted in their own captures."""
        here, captures = np.unique(answers.capture, return_inverse=True)
        if len(here) > 1 and any(
            repeats(self._clauses, it) for it in self._programs
        ):  # these tell the hits of one capture
            order = np.argsort(captures, kind="stable")
            pieces = np.split(order, np.flatnonzero(np.diff(captures[order])) + 1)
            return self._told_apart(answers, pieces)
        batch = self._batch(here)
        source = Source(self._recordings, here, batch, self._programs)
        tick = self._tick(int(here[0]), self._watch)
        teller = Tracer(self._query, self._programs, batch, source, tick)
        begins = {part: batch.rows(part).bounds.tolist() for part in self._query.parts}
        places = [
            Place(capture, parts, tuple(begins[it][capture] + row for it, row in rows), span)
            for capture, parts, rows, span in self._places(answers, captures)
        ]
        found: list[Told | None] | None = None
        refused = self._too_many
        try:
            found = teller.told(places)
        except TooMuch:
            pass
        except MemoryError:
            refused = self._too_large
        if found is None:  # too much at once: fewer hits are tried
            if len(answers) == 1:
                raise refused(int(here[0]))
            return self._told_apart(answers, np.array_split(np.arange(len(answers)), 2))
        told = []
        for place, one in zip(places, found, strict=True):
            if one is None:
                raise LanindexError(
                    f"a hit at frame {place.span[0]} is not there any more",
                    place=self._fetched[int(here[place.capture])][0].path,
                    remedy="Please report this pattern.",
                )
            told.append(one)
        return told

    def _places(
        self, answers: HitTable, captures: IntArray
    ) -> Iterator[tuple[int, tuple[str, ...], list[tuple[str, int]], tuple[int, int]]]:
        """Yield of hits the capture, the parts and rows of the first symbols, and the frames."""
        spans = zip(answers.low.tolist(), answers.high.tolist(), strict=True)
        first = zip(captures.tolist(), answers.parts.tolist(), answers.rows.tolist(), strict=True)
        for (capture, place, rows), span in zip(first, spans, strict=True):
            parts = self._parts[place]
            yield capture, parts, list(zip(parts, rows, strict=False)), span

    def _told_apart(self, answers: HitTable, pieces: Sequence[IntArray]) -> list[Told]:
        """Return the same as `_told`, some hits at a time."""
        found: dict[int, Told] = {}
        for some in pieces:
            found.update(zip(some.tolist(), self._told(answers.at(some)), strict=True))
        return [found[place] for place in range(len(answers))]

    def _possible(self) -> IntArray:
        """Return the captures that can have a hit, as far as it is asked."""
        every = np.arange(len(self._roster))
        if len(every) < MANY:
            return every
        return np.flatnonzero(prefilter.possible(self._programs, self._columns, len(every)))

    def _batch(self, places: IntArray) -> Batch:
        """Return some captures as a batch."""
        return Batch(self._roster, self._columns, places, self._tolerance)

    def _among(self, places: IntArray, watch: Watch | None) -> list[HitTable]:
        """Return all answers in some captures."""
        if watch:
            watch(int(places[0]), len(self._roster))
        answers: HitTable | None = None
        refused = self._too_many
        try:
            answers = self._in_block(self._batch(places), places, watch)
        except TooMuch:
            pass
        except MemoryError:
            refused = self._too_large
        if answers is None:  # too much at once; the error is gone by now, and so is what it held
            if len(places) == 1:
                self._refused[int(places[0])] = refused(int(places[0]))
                return []
            halves = np.array_split(places, 2)
            return [it for half in halves for it in self._among(half, watch)]
        answers.capture = places[answers.capture]
        return [answers]

    def _in_block(self, batch: Batch, here: IntArray, watch: Watch | None) -> HitTable:
        """Return all answers in a batch."""
        found: list[HitTable] = []
        source = Source(self._recordings, here, batch, self._programs)
        tick = self._tick(int(here[0]), watch)
        rich = np.zeros(len(batch), bool)
        for number, rewrites in enumerate(self._rewrites):
            context = Context(batch, rewrites, self._clauses, source, tick)
            found += hits_of(context, number, self._parts)
            rich |= context.refused
        for place in here[rich].tolist():
            self._refused[place] = self._too_many(place)
        if rich.any():
            found = [it.at(~rich[it.capture]) for it in found]
        return own_rows(best(joined(found)), self._parts, lambda part: batch.rows(part).bounds)

    def _too_many(self, place: int) -> LanindexError:
        """Return what is said where a pattern fits a capture in more ways than can be tried."""
        (capture,) = self.captures([place])
        return LanindexError(
            "the pattern fits in too many ways",
            place=capture.path,
            remedy='Put fewer "..." into repeats, name the part after "without", or ask less of '
            'labels in "where"',
        )

    def _too_large(self, place: int) -> LanindexError:
        """Return the error where one capture alone needs more memory than there is."""
        (capture,) = self.captures([place])
        return OutOfMemoryError(
            "the search ran out of memory in this capture", place=capture.path, remedy=NARROWER
        )

    def _in_those_asked_for(self, answers: HitTable) -> HitTable:
        """Return the answers in captures that are as conditions on the capture alone ask."""
        if not self._clauses.of_capture or not len(answers):
            return answers
        places = np.unique(answers.capture).tolist()
        for first in range(0, len(places), MANY):
            some = [it for it in places[first : first + MANY] if it not in self._meet]
            for place, capture in zip(some, self.captures(some), strict=True):
                hit = Hit(capture, Span(0, 0), 1.0, ())
                self._meet[place] = all(holds(it, hit) for it in self._clauses.of_capture)
        meet = np.array([self._meet[place] for place in places])
        return answers.at(np.isin(answers.capture, np.array(places)[meet]))

    def _kept(self, answers: HitTable, overlaps: str) -> IntArray:
        """Return which answers are hits."""
        kept, where = np.arange(len(answers)), (answers.capture, answers.low, answers.high)
        if overlaps == "all":
            return kept
        if not counts(self._query.pattern):
            kept = np.flatnonzero(hit_table.nearest(*where))
        return kept[hit_table.from_left(*(column[kept] for column in where))]

    def _tick(self, place: int, watch: Watch | None) -> Callable[[], None]:
        """Return what tells that the search is still at a capture."""
        many = len(self._roster)
        return partial(watch, place, many) if watch else lambda: None


def find_in(
    recordings: Sequence[Recording],
    query: Query,
    *,
    tolerance: Fraction = TOLERANCE,
    overlaps: str = "none",
    watch: Watch | None = None,
    best: int | None = None,
) -> Found:
    """Find a query in a few captures that are at hand, each with its tracks by part."""

    def fetch(places: Sequence[int], parts: Collection[str]) -> list[Recording]:
        return [recordings[place] for place in places]

    finder = Finder(query, *columns_in(recordings, query.parts), fetch, tolerance)
    return finder.find(overlaps, watch, best)


def columns_in(
    recordings: Sequence[Recording], parts: Collection[str]
) -> tuple[Roster, dict[str, Columns]]:
    """Return captures and the symbols of some parts as columns; a part that no one has is none."""
    captures = [capture for capture, _ in recordings]
    columns = {
        part: columns_of(part, captures, [tracks.get(part) for _, tracks in recordings])
        for part in parts
        if any(part in tracks for _, tracks in recordings)
    }
    return roster_of(captures), columns
