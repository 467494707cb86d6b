"""A query searched in columns: a table of its hits in all captures, and hits as objects."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from fractions import Fraction
from functools import partial
from itertools import chain
from typing import TypeVar

import numpy as np

from lanindex.errors import LanindexError, OutOfMemoryError
from lanindex.model import Capture, Hit, Span, Symbol, Track
from lanindex.model.columns import THOUSANDTHS, Columns, Roster, columns_of, roster_of
from lanindex.model.symbol import joined as rows_joined
from lanindex.model.symbol import listed
from lanindex.search.hits import Found, meets
from lanindex.search.language.query import Query
from lanindex.search.language.times import TOLERANCE
from lanindex.search.limits import OverBudget, running, tick
from lanindex.search.match.arrays import IntArray, once, together
from lanindex.search.match.batch import Batch, possible, split
from lanindex.search.match.conditions import Captures, Clauses
from lanindex.search.match.context import Context
from lanindex.search.match.hits import (
    NO_HITS,
    ExactHits,
    HitTable,
    HitTrace,
    Row,
    Step,
    best,
    from_left,
    labelled,
    nearest,
    rows_of,
)
from lanindex.search.match.leading import hits_of
from lanindex.search.match.rewrites import Rewrites
from lanindex.search.match.trace import traced
from lanindex.search.plan import counts, plan

Recording = tuple[Capture, Mapping[str, Track]]
"""A capture, and its tracks by part."""

Recordings = Callable[[Sequence[int], Collection[str]], Iterable[Recording]]
"""Captures with the tracks of some parts, by their places in the roster."""

Watch = Callable[[int, int], None]
"""Called now and then with how many captures are done, and of how many; it may raise."""

MANY = 1000  # captures from which on those that cannot have a hit are left out first
MOST_ROWS = 1 << 17  # rows of a part in a batch
NARROWER = 'Bound what it tries: write "...[<5s]" for "...", or search fewer captures.'
"""The remedy where a search takes too much time or memory."""

Result = TypeVar("Result")


class Finder:
    """Searches for one query in the columns of its parts; a part without columns never moves.

    Edges agree within `tolerance` seconds. A search may take `memory` bytes besides its columns and
    hits; None: a quarter of what is free. `recordings` gives the captures and tracks of hits that
    are made objects. `refused` are the captures that the last search left out, by place.
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
        self.query, self.roster, self.columns = query, roster, columns
        self.memory, self._tolerance, self._recordings = memory, tolerance, recordings
        self._programs, self._clauses = plan(query), Clauses(query)
        self._rewrites = [Rewrites(it) for it in self._programs]
        self._fetched: dict[int, Recording] = {}
        self.refused: dict[int, LanindexError] = {}
        self.library = 0  # rows of a part in all of it, where the columns are some; see `split`
        self._watch: Watch | None = None
        self._done = 0  # captures that are searched

    def find(
        self,
        overlaps: str = "none",
        watch: Watch | None = None,
        best: int | None = None,
        refused: list[LanindexError] | None = None,
        among: IntArray | None = None,
        found: Found | None = None,
    ) -> ExactHits:
        """Return all hits, or the `best` so many that fit best, the clearest first.

        Overlaps ``none``: from left to right, those that begin when the one before is over;
        ``all``: one for every place where the pattern can start. `refused` takes an error for each
        capture that is too rich for the pattern, or for the memory; None: the first one is raised.
        `among` are the only captures searched, (N,) int64, growing, by their places in the roster.
        `found` is called with each batch's hits, also those that are not among the best.
        """
        pieces: list[ExactHits] = []
        with self.searching(watch, refused):
            for table in self._hits_in(self._possible() if among is None else among):
                hits = self._in_matching_captures(table)
                pieces.append(ExactHits(self, hits, self._staying(hits, overlaps)))
                if found:
                    found(pieces)
            whole = ExactHits.joined(self, pieces)
            return whole if best is None else whole.by_fit(best)[:best]

    @contextmanager
    def searching(self, watch: Watch | None, refused: list[LanindexError] | None) -> Iterator[None]:
        """Run a search that tells where it is; `refused` as for `find`."""
        self._watch, self.refused = watch, {}
        try:
            with running(self.memory, self.tell):
                yield
            errors = [self.refused[place] for place in sorted(self.refused)]
            if refused is None and errors:
                raise errors[0]
            if refused is not None:
                refused += errors
        finally:
            self._watch = None  # hits that are looked at later on are not watched

    def tell(self) -> None:
        """Tell whoever watches at which captures the search is."""
        if self._watch:
            self._watch(self._done, len(self.roster))

    def of(self, query: Query) -> Finder:
        """Return what searches for another query in the same columns."""
        columns = {part: self.columns[part] for part in query.parts}
        shared = self._recordings, self._tolerance, self.memory
        return Finder(query, self.roster, columns, *shared)

    def fetched(self, places: Sequence[int]) -> Mapping[int, Recording]:
        """Return captures of which hits will be made objects; the last ones are kept."""
        held = self._fetched  # another thread may fetch others meanwhile
        if not held.keys() >= {*places}:
            recordings = self._recordings(places, self.query.parts)
            held = self._fetched = dict(zip(places, recordings, strict=True))
        return held

    def captures(self, places: Sequence[int]) -> list[Capture]:
        """Return captures by their places in the roster."""
        return [capture for capture, _ in self._recordings(places, ())]

    def hits(self, hits: HitTable) -> list[Hit]:
        """Return the hits of a table as objects."""
        fetched = self.fetched(once(hits.capture).tolist())
        made: dict[int, Hit] = {}
        with running(self.memory, None):
            for some, found in self.in_parts(
                partial(self._hit_objects, hits, fetched), hits.capture
            ):
                if isinstance(found, LanindexError):
                    raise found
                made.update(zip(some.tolist(), found, strict=True))
        return [made[place] for place in range(len(hits))]

    def _hit_objects(
        self, hits: HitTable, fetched: Mapping[int, Recording], indices: IntArray
    ) -> list[Hit]:
        """Return some of a table's hits as objects, all at once."""
        hits = hits.at(indices)
        places, hits.capture = np.unique(hits.capture, return_inverse=True)
        batch, captures_at = self.batch(places), self._captures(places)
        recordings = [fetched[place] for place in places.tolist()]
        traces: list[HitTrace] = []
        for place, one in enumerate(traced(hits, self.query, self._rewrites, batch, captures_at)):
            if one is None:
                raise LanindexError(
                    f"a hit at frame {hits.low[place]} is not there any more",
                    place=recordings[hits.capture[place]][0].path,
                    remedy="Please report this pattern.",
                )
            traces.append(one)
        steps = {step for one in traces for line in one.lines for step in line}
        symbols = _symbols_of(batch, steps, [tracks for _, tracks in recordings])
        captures = (recordings[place][0] for place in hits.capture.tolist())
        spans = map(Span, hits.low.tolist(), hits.high.tolist())
        return [
            _hit(batch, trace, symbols, capture, span)
            for trace, capture, span in zip(traces, captures, spans, strict=True)
        ]

    def in_parts(
        self, work: Callable[[IntArray], Result], captures: IntArray
    ) -> Iterator[tuple[IntArray, Result | LanindexError]]:
        """Yield the result of work on items, in halves of halves where all at once are too much.

        Each result comes with the places of its items; an item that alone is too much has an error.
        """
        todo = [np.arange(len(captures))]
        while todo:
            some = todo.pop()
            found: Result | None = None
            error = self._too_many
            try:
                found = work(some)
            except OverBudget:
                pass
            except MemoryError:
                error = self._too_large
            # the exception is gone by now, and so is what it held
            if found is not None:
                yield some, found
            elif len(some) == 1:
                yield some, error(int(captures[some[0]]))
            else:
                todo += reversed(np.array_split(some, 2))

    def _possible(self) -> IntArray:
        """Return the captures that can have a hit; all of them where they are few."""
        every = np.arange(len(self.roster))
        if len(every) < MANY:
            return every
        return np.flatnonzero(possible(self._programs, self.columns, len(every)))

    def batch(self, places: IntArray) -> Batch:
        """Return some captures as a batch."""
        return Batch(self.roster, self.columns, places, self._tolerance)

    def _captures(self, roster_places: IntArray) -> Captures:
        """Return a function from places in a batch to captures."""
        return lambda places: self.captures(roster_places[list(places)].tolist())

    def in_batches(
        self, work: Callable[[IntArray], Result], places: IntArray
    ) -> Iterator[tuple[IntArray, Result]]:
        """Yield some captures at a time, with the result of work on them.

        A capture that alone is too much is refused.
        """

        def of_part(batch: IntArray, part: IntArray) -> Result:
            self._done = int(batch[part[0]])
            tick()
            return work(batch[part])

        for batch in split(self.columns.values(), places, MOST_ROWS, self.library):
            for part, found in self.in_parts(partial(of_part, batch), batch):
                if isinstance(found, LanindexError):
                    self.refused[int(batch[part[0]])] = found
                else:
                    yield batch[part], found

    def _hits_in(self, places: IntArray) -> Iterator[HitTable]:
        """Yield all hits in some captures; captures that are refused get an error."""
        for _, (hits, rich) in self.in_batches(self._in_batch, places):
            self.refused.update((place, self._too_many(place)) for place in rich)
            yield hits

    def _in_batch(self, places: IntArray) -> tuple[HitTable, list[int]]:
        """Return all hits in some captures, and those of them that are too rich."""
        batch, tables = self.batch(places), [NO_HITS]
        rich = np.zeros(len(batch), bool)
        for rewrites in self._rewrites:
            context = Context(batch, rewrites, self._clauses, self._captures(places))
            some = np.flatnonzero(context.possible())
            if 2 * len(some) < len(batch):  # the rest would cost more than a batch of their own
                own = places[some]
                context = Context(self.batch(own), rewrites, self._clauses, self._captures(own))
            else:
                some = np.arange(len(batch))
            for hits in hits_of(context):
                hits.capture = some[hits.capture]
                tables.append(hits)
            rich[some] |= context.refused
        hits = together(tables)
        if rich.any():
            hits = hits.at(~rich[hits.capture])
        hits = best(hits)
        hits.capture = places[hits.capture]
        return hits, places[rich].tolist()

    def _too_many(self, place: int) -> LanindexError:
        """Return the error where a pattern fits a capture in more ways than can be tried."""
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

    def _in_matching_captures(self, hits: HitTable) -> HitTable:
        """Return the hits in captures that meet the conditions on the capture alone."""
        if not self._clauses.of_capture or not len(hits):
            return hits
        places = once(hits.capture)
        meet = [
            all(meets(capture, it) for it in self._clauses.of_capture)
            for first in range(0, len(places), MANY)
            for capture in self.captures(places[first : first + MANY].tolist())
        ]
        return hits.at(np.array(meet)[np.searchsorted(places, hits.capture)])

    def _staying(self, hits: HitTable, overlaps: str) -> IntArray:
        """Return the places of the hits that stay, as `find` says of `overlaps`."""
        kept, where = np.arange(len(hits)), (hits.capture, hits.low, hits.high)
        if overlaps == "all":
            return kept
        if not counts(self.query.pattern):
            kept = np.flatnonzero(nearest(*where))
        return kept[from_left(*(column[kept] for column in where))]


def _symbols_of(
    batch: Batch, steps: Iterable[Step], tracks: Sequence[Mapping[str, Track]]
) -> dict[Step, list[Symbol]]:
    """Return the symbols that steps took; `tracks` are those of the captures of the batch."""
    taken = rows_of(batch, steps)
    rows: dict[str, list[int]] = {}
    for part, row in set(chain.from_iterable(taken.values())):
        rows.setdefault(part, []).append(row)
    symbols: dict[Row, Symbol] = {}
    for part, own in rows.items():
        held, every = batch.rows(part), rows_joined(it[part].symbols for it in tracks if part in it)
        ordinals = (own - held.bounds[held.capture[own]]).tolist()
        made = listed(part, every[own], ordinals)  # one object a row, so that lines can tell them
        symbols.update(((part, row), it) for row, it in zip(own, made, strict=True))
    return {step: [symbols[row] for row in own] for step, own in taken.items()}


def _hit(
    batch: Batch,
    trace: HitTrace,
    symbols: Mapping[Step, Sequence[Symbol]],
    capture: Capture,
    span: Span,
) -> Hit:
    """Return a hit as an object."""
    lines = tuple(
        tuple({id(it): it for step in line for it in symbols[step]}.values())
        for line in trace.lines
    )
    labels = labelled(batch, chain.from_iterable(trace.lines), symbols)
    return Hit(capture, span, (THOUSANDTHS - trace.cost) / THOUSANDTHS, lines, labels)


def find_in(
    recordings: Sequence[Recording],
    query: Query,
    *,
    tolerance: Fraction = TOLERANCE,
    overlaps: str = "none",
    watch: Watch | None = None,
    best: int | None = None,
) -> ExactHits:
    """Find a query in a few captures that are at hand, each with its tracks by part."""

    def fetch(places: Sequence[int], parts: Collection[str]) -> list[Recording]:
        return [recordings[place] for place in places]

    finder = Finder(query, *columns_in(recordings, query.parts), fetch, tolerance)
    return finder.find(overlaps, watch, best)


def columns_in(
    recordings: Sequence[Recording], parts: Collection[str]
) -> tuple[Roster, dict[str, Columns]]:
    """Return captures and the symbols of some parts as columns, also of parts that no one has."""
    captures = [capture for capture, _ in recordings]
    columns = {
        part: columns_of(part, captures, [tracks.get(part) for _, tracks in recordings])
        for part in parts
    }
    return roster_of(captures), columns
