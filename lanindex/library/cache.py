"""Keep the columns and texts of an open library in memory, and write, join and mend its segments.

What a search needs is read in one transaction, part by part, and kept until the change stamp
changes. Segments that cannot be trusted are mended on the way, and captures that are in none are
put into one. Neither changes what the library says.

Segments are written, joined and verified in steps, each in its own transaction. An interrupted step
leaves the library as it was before; no step changes rows of captures, tracks or symbols.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from functools import partial
from threading import Lock
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import LibraryError
from lanindex.library import segment_files, segments
from lanindex.library.connect import Session, ask, no_tick
from lanindex.library.dialect import Link
from lanindex.library.read import read_parts, read_state
from lanindex.library.segment_files import Distrust, Unreachable
from lanindex.library.segments import Segment, Spine
from lanindex.model.columns import Columns, Roster, enrolled, extras_of

CHUNK = 1 << 20
"""Symbols after which a segment that is made of rows is full."""

LARGEST = 1 << 24
"""Symbols of the largest segment that is made by joining: others wait while segments are joined."""

MOST_PENDING = 256
"""Captures outside segments that a search reads from their rows; more are put into a segment."""

_WRITE_TIMEOUT = 1.0
"""Seconds that a search waits to write."""

_BESIDE = "what is not there is read from the symbols, each time"

_TICK = 0.1
"""Seconds after which who waits for another thread is told."""

Step = Callable[[Link], bool]
"""Work in its own transaction; returns whether more of it may be left."""

Result = TypeVar("Result")


class _Held:
    """What has been read of a library since its change stamp became this one."""

    def __init__(self, stamp: int) -> None:
        self.stamp = stamp
        self.roster: Roster | None = None
        self.parts: set[str] | None = None
        self.columns = dict[str, Columns]()
        self.numbers, self.texts = list[int](), dict[str, Sequence[Any]]()
        self._locks = dict[str, Lock]()

    def missing(self, parts: Iterable[str], extra: Collection[str]) -> list[str]:
        """Return the parts of which not all columns are there."""
        return [
            part
            for part in parts
            if part not in self.columns
            or not {*extra}.intersection(extras_of(part)) <= {*self.columns[part].rows}
        ]

    @contextmanager
    def loading(self, names: Iterable[str], tick: Callable[[], None]) -> Iterator[None]:
        """Let one thread at a time load some parts; others are loaded meanwhile.

        Whoever waits here reads the library already, so that no writer waits between the two.
        """
        with ExitStack() as stack:
            for name in sorted(names):  # in one order, so that no two threads wait for each other
                lock = self._locks.setdefault(name, Lock())
                while not lock.acquire(timeout=_TICK):
                    tick()
                stack.callback(lock.release)
            yield


class ColumnCache:
    """Columns and texts of an open library, from its segments or, where these fail, its rows.

    All threads share them.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self._held = _Held(-1)
        self._mending = Lock()
        self._mended_at: int | None = None
        self._fault = ""  # What is wrong with the segments and not mended yet

    def columns(
        self,
        parts: Sequence[str],
        extra: Collection[str] = (),
        tick: Callable[[], None] = no_tick,
        only: NDArray[np.int64] | None = None,
    ) -> tuple[Roster, dict[str, Columns]]:
        """Return all captures and the columns of some parts, from segments or else from rows.

        `tick` is called with each column that is read, and may raise. With `only`, the numbers of
        some captures, (N,), nothing more is kept: where columns are missing, those of these
        captures are returned.
        """
        result, pending = None, 0
        fault, self._fault = self._fault, ""
        try:
            with self._session.reading() as connection:
                held = self._current(connection)
                if held.roster is None or held.missing(parts, extra):
                    ((pending,),) = ask(connection, "SELECT count(*) FROM segment_pending")
                if pending <= MOST_PENDING:
                    result = self._load(connection, held, parts, extra, tick, only)
        except Distrust as error:
            fault = error.found
        if result is not None and not fault:
            return result
        self.mend(held.stamp, fault, pending)
        with self._session.reading() as connection:
            held = self._current(connection)
            try:
                return self._load(connection, held, parts, extra, tick, only)
            except Distrust:
                return self._load(connection, held, parts, extra, tick, only, trusted=False)

    def mend(self, stamp: int, fault: str, pending: int) -> None:
        """Mend segments that have a fault or lack captures, once while the stamp is this."""
        with self._mending:
            if stamp != self._mended_at:
                self._note(f"were {fault}" if fault else f"lack {pending} of its captures")
                self._mend(fault)
                self._mended_at = stamp

    def _current(self, connection: Link) -> _Held:
        """Return what is held of the library as it is now; forget what was read before."""
        stamp, held = read_state(connection).stamp, self._held
        if stamp != held.stamp:
            held = self._held = _Held(stamp)
        return held

    def _load(
        self,
        connection: Link,
        held: _Held,
        parts: Sequence[str],
        extra: Collection[str],
        tick: Callable[[], None],
        only: NDArray[np.int64] | None,
        *,
        trusted: bool = True,
    ) -> tuple[Roster, dict[str, Columns]]:
        if only is not None and (held.roster is None or held.missing(parts, extra)):
            spine = segments.read_spine(connection, trusted=trusted)
            wanted_extra = dict.fromkeys(parts, extra)
            return segments.read_all_columns(connection, spine, wanted_extra, tick, only)
        with held.loading(held.missing(parts, extra), tick):
            missing = held.missing(parts, extra)  # another thread may have loaded them
            if missing or held.roster is None:
                wanted = {
                    part: {*extra, *(held.columns[part].rows if part in held.columns else ())}
                    for part in missing
                }
                spine = segments.read_spine(connection, trusted=trusted)
                roster, loaded = segments.read_all_columns(connection, spine, wanted, tick)
                held.roster = roster if held.roster is None else held.roster
                held.columns |= loaded
        return held.roster, {part: held.columns[part] for part in parts}

    def texts(
        self, connection: Link, names: Sequence[str]
    ) -> tuple[list[int], dict[str, Sequence[Any]]]:
        """Return the numbers of all captures, in order, and their texts by name of the column."""
        held = self._current(connection)
        with held.loading([name for name in names if name not in held.texts], no_tick):
            missing = [name for name in names if name not in held.texts]
            if missing:
                read = partial(segments.read_all_texts, connection, names=missing)
                held.numbers, texts = self.trusting(connection, read)
                held.texts |= texts
        return held.numbers, {name: held.texts[name] for name in names}

    def checked_parts(self, connection: Link, tick: Callable[[], None]) -> set[str]:
        """Return the parts that any capture has; all its tracks are checked; `tick` may raise."""
        held = self._current(connection)
        if held.parts is None:
            held.parts = read_parts(connection, tick)
        return held.parts

    def trusting(self, connection: Link, read: Callable[[Spine], Result]) -> Result:
        """Read from the segments or, where they cannot be trusted, from the rows.

        The segments are then mended when columns are asked for.
        """
        try:
            return read(segments.read_spine(connection))
        except Distrust as error:
            self._fault = error.found
        return read(segments.read_spine(connection, trusted=False))

    def compact(self) -> None:
        """Write segments of the captures that are in none, and join small segments.

        An interruption loses nothing. Where the segments cannot be written, a note says so, and
        searches take longer.
        """
        with self._session.reading() as connection, suppress(Distrust):
            spine = segments.read_spine(connection)
            if not spine.pending and not _to_join(connection, spine):
                return
        self._mend("")

    def move(self, where: str) -> None:
        """Keep the columns in files of a folder or a bucket, or (empty) in the library.

        Columns that cannot be trusted or reached are made anew there.
        """
        if where:
            with self._session.writing() as connection:
                segment_files.claim(connection, where)
        with self._session.writing() as connection:
            try:
                segments.move(connection, where)
            except Distrust as error:
                self._note(f"were {error.found}")
                segments.begin_anew(connection)
                segment_files.set_place(connection, where)
        self._mend("")

    def renew(self) -> None:
        """Read all columns, and make them anew if one of them is damaged."""
        try:
            with self._session.reading() as connection:
                verify(connection)
        except Distrust as error:
            self._mend(error.found)

    def _note(self, fault: str) -> None:
        self._session.note(f"the library's columns {fault}: they are made of its symbols now")

    def _mend(self, fault: str) -> None:
        """Rewrite the segments where the library can be written.

        A library that is open for reading is written by a connection of its own.
        """
        session, target = self._session, self._session.target
        try:
            if not session.readonly:
                self._settle(session, fault)
                return
            if target.in_memory:
                raise LibraryError("it is kept nowhere else", place=target.place)
            with closing(Session(target, timeout=_WRITE_TIMEOUT)) as writer:
                self._settle(writer, fault)
        except Unreachable:
            session.note(f"the library's columns are left as they are: {_BESIDE}")
        except LibraryError as error:
            session.note(f"the library's columns cannot be written ({error.found}): {_BESIDE}")

    def _settle(self, session: Session, fault: str) -> None:
        """Cover and join segments; if one is damaged, purge them first."""

        def step(work: Step) -> bool:
            with session.writing() as connection:
                return work(connection)

        if fault:
            step(purge)
        try:
            self._cover_and_join(step)
        except Distrust as error:
            self._note(f"were {error.found}")
            step(purge)
            self._cover_and_join(step)

    def _cover_and_join(self, step: Callable[[Step], bool]) -> None:
        left: list[int] = []

        def waiting(count: int) -> None:
            left.append(count)
            self._session.progress("captures", left[0] - count, left[0])

        while step(partial(cover, waiting=waiting)):
            pass
        if left:
            waiting(0)
        while step(join):
            pass


def verify(connection: Link) -> None:
    """Load all segments, which checks them."""
    spine = segments.read_spine(connection)
    segments.check_files(spine)
    segments.read_rosters(connection, spine)
    for segment in spine.segments:
        segments.read_texts(connection, segment)
        segments.read_totals(connection, segment)
        for part in segment.parts:
            segments.read_columns(connection, segment, part)


def purge(connection: Link) -> bool:
    """Delete all segments if one of them is damaged, and return whether one is.

    Those that are out of reach stay: they may be whole.
    """
    try:
        verify(connection)
    except Unreachable:
        raise
    except Distrust:
        segments.begin_anew(connection)
        return True
    return False


def cover(connection: Link, waiting: Callable[[int], None]) -> bool:
    """Write a segment of captures that are in none, and return whether any are left."""
    pending = segments.read_spine(connection).pending
    pieces: list[segments.Piece] = []
    symbols = covered = 0
    waiting(len(pending))
    for piece in segments.batches(connection, pending):
        pieces.append(piece)
        covered += len(piece.roster)
        symbols += sum(map(len, piece.columns.values()))
        waiting(len(pending) - covered)
        if symbols >= CHUNK:
            break
    if not covered:
        return False
    whole = segments.together(pieces)
    segments.check_pending(whole.roster.number.tolist(), pending[:covered])
    segments.put(connection, whole.roster, whole.texts, whole.columns.values())
    segments.mark_covered(connection, pending[:covered])
    return covered < len(pending)


def join(connection: Link) -> bool:
    """Join the newest segments where that is worth it, and return whether any were joined.

    A segment is joined with all newer ones once these hold as many symbols, so that a symbol is
    written again only when the size of its segment doubles. All are joined once a quarter of their
    captures is dead; where that is too much at once, a segment of which a quarter is dead is
    written anew.
    """
    spine = segments.read_spine(connection)
    old = _to_join(connection, spine)
    if not old:
        segment_files.collect(connection)  # those joined before this transaction, too
        return False
    dead = {number: last for number, last in spine.dead.items() if last >= old[0].id}
    roster = enrolled([segments.read_roster(connection, one) for one in old])
    order = segments.order_of(Spine(old, dead, []), roster.number)
    texts = segments.joined_texts([segments.read_texts(connection, one) for one in old], order)
    roster = roster if order is None else roster.at(order)
    segments.put(connection, roster, texts, _take_columns(connection, old, order))
    segments.drop(connection, old)
    return True


def _take_columns(
    connection: Link, old: list[Segment], order: NDArray[np.int64] | None
) -> Iterator[Columns]:
    """Yield the columns of segments part by part, and delete each: its room is used again."""
    for part in dict.fromkeys(part for one in old for part in one.parts):
        moved = segments.stored_columns(connection, old, part, order)
        segments.drop_part(connection, old, part)
        yield moved


def _to_join(connection: Link, spine: Spine) -> list[Segment]:
    """Return the segments to join, or the one to write anew."""
    sizes = [one.symbols + one.captures for one in spine.segments]
    lost = 4 * len(spine.dead) > sum(one.captures for one in spine.segments)
    for first in range(len(sizes)):
        rest = sum(sizes[first + 1 :])
        worth = (lost and first == 0) or (rest > 0 and sizes[first] <= rest)
        if worth and sizes[first] + rest <= LARGEST:
            return spine.segments[first:]
    for one in spine.segments if lost else ():
        alive = segments.alive(spine, one, segments.read_roster(connection, one).number)
        if 4 * len(alive) < 3 * one.captures:
            return [one]
    return []
