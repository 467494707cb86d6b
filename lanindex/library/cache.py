"""Keep the columns and texts of an open library in memory, and write, join and mend its segments.

What a search needs is read in one transaction, part by part, and kept until the change stamp
changes. Segments that cannot be trusted are mended on the way, and captures that are in none are
put into one. Neither changes what the library says.

Segments are written, joined and verified in steps, each in its own transaction. An interrupted step
leaves the library as it was before; no step changes rows of captures, tracks or symbols.
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import closing, suppress
from functools import partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import LibraryError
from lanindex.library import segments
from lanindex.library.connect import Link, Session, ask
from lanindex.library.read import read_state
from lanindex.library.segments import Distrust, Segment, Spine
from lanindex.model.columns import Columns, Roster, enrolled, extras_of

CHUNK = 1 << 20
"""Symbols after which a segment that is made of rows is full."""

LARGEST = 1 << 27
"""Symbols of the largest segment that is made by joining: a value in SQLite has a billion bytes at
the most, and readers wait while segments are joined."""

MOST_PENDING = 256
"""Captures outside segments that a search reads from their rows; more are put into a segment."""

_WRITE_TIMEOUT = 1.0
"""Seconds that a search waits to write."""

_BESIDE = "what is not there is read from the symbols, each time"

Step = Callable[[Link], bool]
"""Work in its own transaction; returns whether more of it may be left."""

Result = TypeVar("Result")


class ColumnCache:
    """Columns and texts of an open library, from its segments or, where these fail, its rows."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._stamp: int | None = None
        self._roster: Roster | None = None
        self._columns = dict[str, Columns]()
        self._numbers, self._texts = list[int](), dict[str, Sequence[Any]]()
        self._mended_at: int | None = None
        self._fault = ""  # What is wrong with the segments and not mended yet

    def columns(
        self, parts: Sequence[str], extra: Collection[str] = ()
    ) -> tuple[Roster, dict[str, Columns]]:
        """Return all captures and the columns of some parts, from segments or else from rows."""
        result, pending = None, 0
        fault, self._fault = self._fault, ""
        try:
            with self._session.reading() as connection:
                self._drop_old(connection)
                if self._roster is None or self._missing_parts(parts, extra):
                    ((pending,),) = ask(connection, "SELECT count(*) FROM segment_pending")
                if pending <= MOST_PENDING:
                    result = self._load(connection, parts, extra)
        except Distrust as error:
            fault = error.found
        if result is not None and not fault:
            return result
        if self._stamp != self._mended_at:
            self._note(f"were {fault}" if fault else f"lack {pending} of its captures")
            self._mend(fault)
            self._mended_at = self._stamp
        with self._session.reading() as connection:
            self._drop_old(connection)
            try:
                return self._load(connection, parts, extra)
            except Distrust:
                return self._load(connection, parts, extra, trusted=False)

    def _drop_old(self, connection: Link) -> None:
        """Forget what was read before the library changed."""
        stamp = read_state(connection).stamp
        if stamp != self._stamp:
            self._stamp, self._roster, self._columns, self._texts = stamp, None, {}, {}

    def _missing_parts(self, parts: Sequence[str], extra: Collection[str]) -> list[str]:
        return [
            part
            for part in parts
            if part not in self._columns
            or not {*extra}.intersection(extras_of(part)) <= {*self._columns[part].rows}
        ]

    def _load(
        self,
        connection: Link,
        parts: Sequence[str],
        extra: Collection[str],
        *,
        trusted: bool = True,
    ) -> tuple[Roster, dict[str, Columns]]:
        missing = self._missing_parts(parts, extra)
        if missing or self._roster is None:
            wanted = {
                part: {*extra, *(self._columns[part].rows if part in self._columns else ())}
                for part in missing
            }
            spine = segments.read_spine(connection, trusted=trusted)
            self._roster, loaded = segments.read_all_columns(connection, spine, wanted)
            self._columns |= loaded
        return self._roster, {part: self._columns[part] for part in parts}

    def texts(
        self, connection: Link, names: Sequence[str]
    ) -> tuple[list[int], dict[str, Sequence[Any]]]:
        """Return the numbers of all captures, in order, and their texts by name of the column."""
        self._drop_old(connection)
        missing = [name for name in names if name not in self._texts]
        if missing:
            read = partial(segments.read_all_texts, connection, names=missing)
            self._numbers, texts = self.trusting(connection, read)
            self._texts |= texts
        return self._numbers, {name: self._texts[name] for name in names}

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
            if not spine.pending and _first_to_join(spine) >= len(spine.segments):
                return
        self._mend("")

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
            if target.sqlite and target.path is None:
                raise LibraryError("it is kept nowhere else", place=target.place)
            with closing(Session(target, timeout=_WRITE_TIMEOUT)) as writer:
                self._settle(writer, fault)
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
    segments.read_rosters(connection, spine)
    for segment in spine.segments:
        segments.read_texts(connection, segment)
        for part in segment.parts:
            segments.read_columns(connection, segment, part)


def purge(connection: Link) -> bool:
    """Delete all segments if one of them is damaged, and return whether one is."""
    try:
        verify(connection)
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
    captures is dead.
    """
    spine = segments.read_spine(connection)
    old = spine.segments[_first_to_join(spine) :]
    if not old:
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


def _first_to_join(spine: Spine) -> int:
    """Return the index of the first segment to join; the number of segments if there is none."""
    sizes = [one.symbols + one.captures for one in spine.segments]
    lost = 4 * len(spine.dead) > sum(one.captures for one in spine.segments)
    for first in range(len(sizes)):
        rest = sum(sizes[first + 1 :])
        worth = (lost and first == 0) or (rest > 0 and sizes[first] <= rest)
        if worth and sizes[first] + rest <= LARGEST:
            return first
    return len(sizes)
