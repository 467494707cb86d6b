"""A library cut into shards, which other processes search or count, and their hits as one.

A shard is a range of captures of one segment, or captures that are in none. What is found there
leaves the process as arrays: the table of its hits, and the captures that have any. The hits of
all shards are those of one search, in its order. Hits are made objects here, of the rows
of the captures that are looked at; this process reads no columns.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from math import ceil
from operator import itemgetter
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import LanindexError, LibraryError
from lanindex.library import segments
from lanindex.library.cache import MOST_PENDING
from lanindex.library.connect import Session, dialect_of
from lanindex.library.dialect import Link, Target
from lanindex.library.read import read_state
from lanindex.library.segment_files import Distrust
from lanindex.library.segments import Piece, Segment, Spine
from lanindex.library.store import Store
from lanindex.model.columns import (
    Columns,
    Roster,
    enrolled,
    extras_of,
    joined_columns,
)
from lanindex.pipeline.search import (
    SearchOptions,
    count_unmeasured,
    match_columns,
    moving_parts,
    note_lacking,
    note_refused_captures,
    out_of_memory,
    recordings_of,
)
from lanindex.pipeline.spread import Spread, Tick, Work
from lanindex.search.hits import extras_in
from lanindex.search.match import ExactHits, Finder
from lanindex.search.match.arrays import IntArray, once, together
from lanindex.search.match.batch import LARGE
from lanindex.search.match.finder import columns_in
from lanindex.search.match.hits import NO_HITS, HitTable

if TYPE_CHECKING:
    from lanindex.model import Capture, Hit
    from lanindex.search.fuzzy import FuzzyHits, FuzzyMatches, FuzzyPlan
    from lanindex.search.hits import Found
    from lanindex.search.language.query import Query
    from lanindex.search.match.finder import Recording, Watch

FEWEST = 64
"""Captures of a shard at least: each shard costs time of its own."""

MOST = 1000
"""Shards at the most: a scheduler takes a millisecond for each, one after the other."""

Item = TypeVar("Item")
Result = TypeVar("Result")


# A library in one state.


@dataclass(frozen=True, slots=True)
class State:
    """A library as it was when a job began, for processes that open it themselves."""

    target: Target = field(repr=False)  # it may have a password
    stamp: int
    tasks: int  # Into how many shards it is cut
    snapshot: str  # of the transaction that goes on while the job does; empty: nobody can write


class Held:
    """What this process has read of one state of a library, for work that is cut in one way."""

    def __init__(self) -> None:
        self._state: tuple[int, int] | None = None
        self._held = dict[Any, Any]()

    def at(self, stamp: int, tasks: int) -> None:
        """Forget what was read of another state, and ranges that were cut otherwise."""
        if self._state != (stamp, tasks):
            self._state, self._held = (stamp, tasks), {}

    def held(self, key: Any, read: Callable[[], Result]) -> Result:
        """Return what was read under a key, or read it."""
        own = self._held  # another thread may come to another state meanwhile
        if key not in own:
            own[key] = read()
        found: Result = own[key]
        return found


class _Opened(Held):
    """A library that this process keeps open, and what it has read of it."""

    def __init__(self, target: Target) -> None:
        super().__init__()
        self.store = Store(Session(target, readonly=True))


_own = WeakKeyDictionary[Store, Held]()
"""What the process that cuts has read."""

_opened: dict[Target, _Opened] = {}


def opened(target: Target) -> _Opened:
    """Return a library that this process keeps open."""
    if target not in _opened:
        _opened[target] = _Opened(target)
    return _opened[target]


@contextmanager
def reading(state: State) -> Iterator[tuple[_Opened, Link]]:
    """Open a library in a state, or raise: the one place that knows how a process comes to it.

    As long as the process that began the job reads the library, too, its state can be read.
    """
    library = opened(state.target)
    with library.store.session.reading(state.snapshot) as connection:
        if read_state(connection).stamp != state.stamp:
            raise LibraryError(
                "the library has changed while it was read",
                place=state.target.place,
                remedy="Run again.",
            )
        library.at(state.stamp, state.tasks)
        yield library, connection


# Shards.


class Shard(NamedTuple):
    """Some captures of a library.

    They lie at the places ``[first, last)`` of a segment, of which only the columns are named that
    a search reads; `chosen` are those searched, None: all. Without a segment, `chosen` are numbers.
    """

    segment: Segment | None
    first: int
    last: int
    chosen: NDArray[np.int64] | None

    def __len__(self) -> int:
        return self.last - self.first if self.chosen is None else len(self.chosen)


def cut(
    connection: Link,
    held: Held,
    parts: Collection[str],
    numbers: Collection[int] | None,
    tasks: int,
    *,
    trusted: bool = True,
) -> list[Shard]:
    """Return the captures of a library, or some by number, as shards.

    Segments are cut into ranges of about the same length in frames, which are the same whatever is
    searched for: who has read one can use it again.
    """
    spine = segments.read_spine(connection, trusted=trusted)
    if trusted and len(spine.pending) > MOST_PENDING:
        raise _Uncovered(len(spine.pending))
    key = tuple((one.id, str(one.entries["", "number"].checksum)) for one in spine.segments)
    lists = held.held(key, partial(_lists, connection, spine))
    wanted = None if numbers is None else np.array(sorted(numbers), np.int64)
    whole = max(1, sum(int(behind[-1]) for _, _, behind in lists))
    shards: list[Shard] = []
    for segment, (number, alive, behind) in zip(spine.segments, lists, strict=True):
        if wanted is not None:
            alive = alive[np.isin(number[alive], wanted)]
        named = {key: it for key, it in segment.entries.items() if key[0] in ("", *parts)}
        frames = int(behind[-1])
        count = max(1, min(ceil(tasks * frames / whole), len(number) // FEWEST))
        within = np.searchsorted(behind, frames * np.arange(1, count) // count) + 1
        for first, last in pairwise([0, *within.tolist(), len(number)]):
            own = alive[slice(*np.searchsorted(alive, (first, last)))]
            if len(own):
                all_of_it = len(own) == last - first
                chosen = None if all_of_it else own
                shards.append(Shard(segment._replace(entries=named), first, last, chosen))
    pending = np.array(spine.pending, np.int64)
    if wanted is not None:
        pending = pending[np.isin(pending, wanted)]
    count = max(1, min(tasks, len(pending) // FEWEST))
    shards += [Shard(None, 0, 0, some) for some in np.array_split(pending, count) if len(some)]
    return shards


def _lists(
    connection: Link, spine: Spine
) -> list[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]]:
    """Return of each segment's captures the numbers, the places of those alive, the frames so far.

    They are (C,), (D,) and (C,).
    """
    rosters, _ = segments.read_rosters(connection, spine)
    return [
        (
            roster.number,
            np.sort(segments.alive(spine, segment, roster.number)),
            roster.frames.cumsum(dtype=np.int64),
        )
        for segment, roster in zip(spine.segments, rosters, strict=True)
    ]


def numbers_in(connection: Link, shard: Shard) -> NDArray[np.int64]:
    """Return the numbers of a shard's captures, (C,)."""
    if shard.segment is None:
        assert shard.chosen is not None
        return shard.chosen
    where = shard.first, shard.last
    numbers = segments.read_column(connection, shard.segment, "", "number", where).astype(np.int64)
    return numbers if shard.chosen is None else numbers[shard.chosen - shard.first]


class _Uncovered(Exception):
    """So many captures are in no segment that these are to be written first."""


def columns_at(
    state: State, shard: Shard, parts: Collection[str], extras: Collection[str], tick: Tick
) -> tuple[Store, Roster, dict[str, Columns]]:
    """Return a library, and the captures of a shard with the columns of some parts."""
    with reading(state) as (library, connection):
        if shard.segment is None:
            return library.store, *_pending(library, connection, shard, parts, extras, tick)
        segment, first, last = shard.segment, shard.first, shard.last
        key = segment.id, str(segment.entries["", "number"].checksum), first, last
        roster = library.held(
            key, lambda: segments.read_roster(connection, segment).at(np.arange(first, last))
        )
        columns = {}
        for part in parts:
            more = tuple(it for it in extras_of(part) if it in extras)
            read = partial(_range_of, connection, segment, part, more, (first, last), tick)
            columns[part] = library.held((*key, part, more), read)
    if shard.chosen is not None:
        places = shard.chosen - first
        roster = roster.at(places)
        columns = {part: one.at(places) for part, one in columns.items()}
    return library.store, roster, columns


def _range_of(
    connection: Link,
    segment: Segment,
    part: str,
    more: Collection[str],
    captures: tuple[int, int],
    tick: Tick,
) -> Columns:
    """Return the columns of a part in a range of a segment's captures."""
    if (part, "counts") not in segment.entries:
        return joined_columns(part, [None], [captures[1] - captures[0]])
    return segments.read_columns(connection, segment, part, more, tick, captures)


def _pending(
    library: _Opened,
    connection: Link,
    shard: Shard,
    parts: Collection[str],
    extras: Collection[str],
    tick: Tick,
) -> tuple[Roster, dict[str, Columns]]:
    """Return captures that are in no segment, with the columns of some parts: from their rows."""
    assert shard.chosen is not None
    numbers = shard.chosen.tolist()
    pieces = list(segments.batches(connection, numbers, list(parts), tick))
    added: Piece = segments.together(pieces)
    segments.check_pending(added.roster.number.tolist(), numbers)
    columns = {
        part: segments.stored_columns(connection, [], part, None, extras, added) for part in parts
    }
    return added.roster, columns


# Work on all shards.


def results(
    spread: Spread,
    store: Store,
    parts: Collection[str],
    numbers: Collection[int] | None,
    work: Callable[[Item, Tick], Result],
    item: Callable[[Link, State, Shard], Item],
    watch: Watch,
    so_far: Callable[[Sequence[Result]], None] = lambda found: None,
) -> tuple[list[Result], int]:
    """Return what work on the shards of a library returns, and how many captures these are.

    Segments that cannot be trusted, or lack captures, are mended first, and rows are read where
    that does not help.
    """
    for trusted in (True, True, False):
        stamp, fault, lacking = -1, "", 0
        try:
            with store.session.reading() as connection:
                stamp, tasks = read_state(connection).stamp, min(spread.tasks, MOST)
                held = _own.setdefault(store, Held())
                held.at(stamp, tasks)
                shards = cut(connection, held, parts, numbers, tasks, trusted=trusted)
                snapshot = dialect_of(connection).snapshot(connection)
                state = State(store.session.target, stamp, tasks, snapshot)
                items = [item(connection, state, shard) for shard in shards]
                found = list[Result]()
                for one in _watched(spread, work, items, shards, watch):
                    found.append(one)
                    so_far(found)
                return found, sum(map(len, shards))
        except Distrust as error:
            fault = error.found
        except _Uncovered as error:
            (lacking,) = error.args
        store.cache.mend(stamp, fault, lacking)
    raise LibraryError("its columns cannot be read", place=store.place)


def _watched(
    spread: Spread, work: Work, items: Sequence[Any], shards: Sequence[Shard], watch: Watch
) -> Iterator[Any]:
    """Yield the results of work on items, one for each shard, as they come."""
    done, total = 0, sum(map(len, shards))

    def tick() -> None:
        watch(done, total)

    tick()
    for shard, one in zip(shards, spread.results(work, items, tick), strict=True):
        yield one
        done += len(shard)
        tick()


# The search of a shard, which another process makes.


class Task(NamedTuple):
    """A search in a shard."""

    state: State
    shard: Shard
    query: Query
    options: SearchOptions


class Told(NamedTuple):
    """What a shard tells of its search."""

    roster: Roster  # of the captures with hits
    prints: NDArray[np.uint64]  # (C,) of their columns
    exact: tuple[HitTable, IntArray]  # as `ExactHits.told`, by places in that roster
    fuzzy: FuzzyMatches | None
    refused: list[tuple[int, LanindexError]]  # by number of the capture
    moving: set[str]
    unmeasured: int


def find(task: Task, tick: Tick) -> Told:
    """Search a shard."""
    query, options, extras = task.query, task.options, extras_in(task.query)
    with out_of_memory(task.state.target.place):
        store, roster, columns = columns_at(task.state, task.shard, query.parts, extras, tick)

        matching = partial(match_columns, roster, columns)
        recordings = recordings_of(store, matching, roster.number)
        finder = options.finder(query, roster, columns, recordings)
        finder.library = LARGE  # what a batch takes beside these columns, a process has
        hits = options.found_by(finder, lambda *_: tick(), [])
        refused = [(int(roster.number[it]), error) for it, error in sorted(finder.refused.items())]
        with_hits = once(hits.place)
        own = {part: one.at(with_hits) for part, one in columns.items()}
        return Told(
            roster.at(with_hits),
            prints_of(query, len(with_hits), own),
            *_told(hits, with_hits),
            refused,
            moving_parts(columns),
            count_unmeasured(len(roster), columns, extras),
        )


def _told(
    hits: ExactHits | FuzzyHits, captures: IntArray
) -> tuple[tuple[HitTable, IntArray], FuzzyMatches | None]:
    """Return hits as arrays, by the places of their captures among those with hits."""
    matches = None
    if isinstance(hits, ExactHits):
        table, rows = hits.told()
    else:
        matches, exact = hits.told()
        matches = matches._replace(capture=np.searchsorted(captures, matches.capture))
        table, rows = exact.told() if exact else (NO_HITS, NO_HITS.capture)
    return (replace(table, capture=np.searchsorted(captures, table.capture)), rows), matches


def prints_of(query: Query, captures: int, columns: Mapping[str, Columns]) -> NDArray[np.uint64]:
    """Return a number for each capture, (C,), that tells what a search reads of it."""
    found, extras = np.zeros(captures, np.uint64), extras_in(query)
    for part in sorted(query.parts):
        found = found * np.uint64(31) + columns[part].prints(extras)
    return found


# The hits of all shards.


class Anew:
    """Makes hits objects by searching the captures again that are looked at: of their rows."""

    def __init__(
        self,
        store: Store,
        query: Query,
        options: SearchOptions,
        roster: Roster,
        prints: NDArray[np.uint64],
    ) -> None:
        self.roster, self._prints, self._query, self._options = roster, prints, query, options
        self._recordings = recordings_of(store, self._matching, roster.number)
        self._held: tuple[IntArray, Finder] | None = None

    def captures(self, places: Sequence[int]) -> list[Capture]:
        """Return captures by their places in the roster."""
        return [capture for capture, _ in self._recordings(places, ())]

    def hits(self, hits: HitTable) -> list[Hit]:
        """Return the hits of a table as objects."""
        places, finder = self.finder(hits.capture)
        return finder.hits(replace(hits, capture=np.searchsorted(places, hits.capture)))

    def finder(self, captures: IntArray) -> tuple[IntArray, Finder]:
        """Return a finder for some captures at least, and their places; the last one is kept."""
        held = self._held  # another thread may look at others meanwhile
        if held is None or not np.isin(captures, held[0]).all():
            places = once(captures)
            recordings = list(self._recordings(places.tolist(), self._query.parts))

            def chosen(places: Sequence[int], parts: Collection[str]) -> list[Recording]:
                return [recordings[place] for place in places]

            columns = columns_in(recordings, self._query.parts)
            held = self._held = places, self._options.finder(self._query, *columns, chosen)
        return held

    def _matching(
        self, places: Sequence[int], parts: Collection[str], found: Sequence[Recording]
    ) -> bool:
        """Return whether captures are as they were searched, see `recordings_of`."""
        rows = np.array(places, np.int64)
        roster, columns = columns_in(found, parts)
        same = roster.same_as(self.roster.at(rows))
        if same and parts:
            same = np.array_equal(prints_of(self._query, len(rows), columns), self._prints[rows])
        return same


class FuzzyAnew:
    """The same for hits of a fuzzy search."""

    def __init__(
        self, anew: Anew, plans: list[FuzzyPlan], overlaps: str, exact_hits: ExactHits
    ) -> None:
        self.plans, self._anew, self._overlaps = plans, anew, overlaps
        self.exact_hits: ExactHits | None = exact_hits
        self.roster, self.captures = anew.roster, anew.captures

    def hits(self, matches: FuzzyMatches, fit: NDArray[np.float64]) -> list[Hit]:
        """Return matches as objects, of which each fits so well, (N,)."""
        from lanindex.search.fuzzy import FuzzySearch

        places, finder = self._anew.finder(matches.capture)
        search = FuzzySearch(finder, self.plans, self._overlaps, self.exact_hits)
        own = matches._replace(capture=np.searchsorted(places, matches.capture))
        return search.hits(own, fit)


def joined(
    store: Store, query: Query, options: SearchOptions, told: Sequence[Told]
) -> ExactHits | FuzzyHits:
    """Return the hits of all shards, by capture, or the best of them."""
    roster = enrolled([one.roster for one in told])
    order = np.argsort(roster.number)
    prints = np.concatenate([np.empty(0, np.uint64), *(one.prints for one in told)])
    anew = Anew(store, query, options, roster.at(order), prints[order])
    ranks = np.empty(len(order), np.int64)
    ranks[order] = np.arange(len(order))
    ranked, first = list[IntArray](), 0  # by shard the places of its captures in the whole roster
    for one in told:
        ranked.append(ranks[first : first + len(one.roster)])
        first += len(one.roster)
    tables, rows, before = [NO_HITS], [NO_HITS.capture], 0
    for one, places in zip(told, ranked, strict=True):
        table, own = one.exact
        tables.append(replace(table, capture=places[table.capture]))
        rows.append(own + before)
        before += len(table)
    whole, chosen = together(tables), np.concatenate(rows)
    if (whole.capture[1:] < whole.capture[:-1]).any():  # captures of segments may lie crosswise
        by_capture = np.argsort(whole.capture, kind="stable")
        place = np.empty(len(whole), np.int64)
        place[by_capture] = np.arange(len(whole))
        whole, chosen = whole.at(by_capture), place[chosen]
    exact = ExactHits(anew, whole, chosen)
    if options.allowance is None:
        in_order = (exact.place[1:] >= exact.place[:-1]).all()
        hits = exact if in_order else exact.at(np.argsort(exact.place, kind="stable"))
        return hits if options.best is None else hits.by_fit(options.best)[: options.best]
    from lanindex.search import fuzzy

    maker = FuzzyAnew(anew, fuzzy.plans_of(query, options.allowance), options.overlaps, exact)
    matches, before = [fuzzy.NO_MATCHES], 0
    for one, places in zip(told, ranked, strict=True):
        assert one.fuzzy is not None
        line_rows = one.fuzzy.line_rows.copy()
        line_rows[line_rows[:, 0, 0] == len(fuzzy.steps_of(maker.plans)), 0, 1] += before
        before += len(one.exact[1])
        matches.append(one.fuzzy._replace(capture=places[one.fuzzy.capture], line_rows=line_rows))
    every = fuzzy.joined(matches)
    found = fuzzy.FuzzyHits(maker, every.at(np.argsort(every.capture, kind="stable")))
    return found if options.best is None else found.by_fit(options.best)[: options.best]


def search(
    spread: Spread,
    store: Store,
    query: Query,
    numbers: Sequence[int] | None,
    options: SearchOptions,
    watch: Watch,
    refused: list[LanindexError],
    note: Callable[[str], None],
    found: Found | None = None,
) -> ExactHits | FuzzyHits:
    """Find a pattern in a library as `lanindex.pipeline.search.search` does, by other processes."""
    query = replace(query, near=options.near)
    joined(store, query, options, [])  # raises where a fuzzy search cannot count edits

    def task(_: Link, state: State, shard: Shard) -> Task:
        return Task(state, shard, query, options)

    def so_far(told: Sequence[Told]) -> None:
        # All are joined anew, so only when they are twice as many as the last time
        if found and len(told).bit_count() == 1:
            found([joined(store, query, options, told)])

    told, captures = results(spread, store, query.parts, numbers, find, task, watch, so_far)
    moving = set[str]().union(*(one.moving for one in told))
    note_lacking(note, query, captures, moving, sum(one.unmeasured for one in told))
    rich = sorted((it for one in told for it in one.refused), key=itemgetter(0))
    note_refused_captures(note, [error for _, error in rich], refused)
    return joined(store, query, options, told)
