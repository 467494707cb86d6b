"""Columns and texts of an open library, kept as long as it stays as it was.

What a search asks for is read inside one transaction, part by part, once: as long as the change
stamp stays, it is given again. Segments that cannot be trusted are mended on the way, and captures
that are in none are put into one, which changes nothing that the library says.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from contextlib import closing
from functools import partial
from typing import Any

from lanindex.errors import LibraryError
from lanindex.library import compaction, segments, state
from lanindex.library.capture_texts import read_all_texts
from lanindex.library.columns import read_all_columns
from lanindex.library.compaction import Step
from lanindex.library.connect import opened, writing
from lanindex.library.link import Link, translated
from lanindex.library.segments import Distrust, Spine
from lanindex.library.session import Session
from lanindex.model.columns import Columns, Roster, enrolled, extras_of

MOST_PENDING = 256
"""Captures that a search takes from their rows each time rather than put them into a segment."""

_WRITE_TIMEOUT = 1.0
"""Seconds that a search waits to write."""

_ANEW = "they are made of its symbols now"
_BESIDE = "what is not there is read from the symbols, each time"


def _spine(connection: Link, trusted: bool) -> Spine:
    """Return what there is of columns: nothing where the segments are not trusted."""
    if trusted:
        return segments.read_spine(connection)
    return Spine([], {}, state.capture_numbers(connection))


class ColumnCache:
    """Columns and texts of an open library, from its segments or, where these fail, its rows."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._roster, self._columns = enrolled([]), dict[str, Columns]()
        self._columns_stamp: int | None = None
        self._numbers, self._texts = list[int](), dict[str, Sequence[Any]]()
        self._texts_stamp: int | None = None
        self._mended_at = -1
        self._fault = ""  # what was found wrong, and is not mended yet

    def columns(
        self, parts: Sequence[str], extra: Collection[str] = ()
    ) -> tuple[Roster, dict[str, Columns]]:
        """Return all captures and the columns of some parts, from wherever they can be trusted."""
        result, fault = self._from_segments(parts, extra, MOST_PENDING)
        fault, self._fault = fault or self._fault, ""
        if result is None or fault:
            with self._session.reading() as connection:
                stamp = int(state.read_state(connection).stamp)
                pending = segments.count_pending(connection)
            if stamp != self._mended_at:
                if not fault:
                    self._session.note(
                        f"the library's columns lack {pending} of its captures: {_ANEW}"
                    )
                self._mend(fault)
                self._mended_at = stamp
            result, _ = self._from_segments(parts, extra)
        if result is None:
            with self._session.reading() as connection:
                result = self._load(connection, parts, extra, trusted=False)
        return result

    def _from_segments(
        self, parts: Sequence[str], extra: Collection[str], most: int | None = None
    ) -> tuple[tuple[Roster, dict[str, Columns]] | None, str]:
        """Return what the segments give; else None, and what is wrong with them, if anything is."""
        try:
            with self._session.reading() as connection:
                same = state.read_state(connection).stamp == self._columns_stamp
                loaded = most is None or (same and not self._missing(parts, extra))
                if loaded or segments.count_pending(connection) <= (most or 0):
                    return self._load(connection, parts, extra), ""
        except Distrust as error:
            return None, error.found
        return None, ""

    def _missing(self, parts: Sequence[str], extra: Collection[str]) -> list[str]:
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
        stamp = state.read_state(connection).stamp
        if stamp != self._columns_stamp:
            self._columns, self._columns_stamp = {}, None
        missing = self._missing(parts, extra)
        if missing or self._columns_stamp is None:
            whole = read_all_columns(connection, _spine(connection, trusted), missing)
            for part in missing:
                loaded = self._columns[part].rows if part in self._columns else ()
                self._columns[part] = whole.columns(connection, part, {*extra, *loaded})
            self._roster, self._columns_stamp = whole.roster, stamp
        return self._roster, {part: self._columns[part] for part in parts}

    def texts(
        self, names: Sequence[str], connection: Link | None = None
    ) -> tuple[list[int], dict[str, Sequence[Any]]]:
        """Return the numbers of all captures, in order, and their texts, by name of the column.

        Where the segments cannot be trusted they come from the rows, and the segments are mended
        when columns are asked for.
        """
        if connection is None:
            try:
                with self._session.reading() as own:
                    return self._load_texts(own, names)
            except Distrust as error:
                self.distrust(error)
            with self._session.reading() as own:
                return self._load_texts(own, names, trusted=False)
        try:
            return self._load_texts(connection, names)
        except Distrust as error:
            self.distrust(error)
            return self._load_texts(connection, names, trusted=False)

    def _load_texts(
        self, connection: Link, names: Sequence[str], *, trusted: bool = True
    ) -> tuple[list[int], dict[str, Sequence[Any]]]:
        stamp = state.read_state(connection).stamp
        if stamp != self._texts_stamp:
            self._texts, self._texts_stamp = {}, None
        missing = [name for name in names if name not in self._texts]
        if missing or self._texts_stamp is None:
            self._numbers, texts = read_all_texts(connection, _spine(connection, trusted), missing)
            self._texts |= texts
            self._texts_stamp = stamp
        return self._numbers, {name: self._texts[name] for name in names}

    def distrust(self, error: Distrust) -> None:
        """Remember that the segments are to be mended."""
        self._fault = error.found

    def compact(self) -> None:
        """Write segments of the captures that are in none, and join small segments.

        An interruption loses nothing. Where the segments cannot be written, a note says so, and
        searches take longer.
        """
        with self._session.reading() as connection:
            idle = compaction.is_compacted(connection)
        if not idle:
            self._mend("")

    def _mend(self, fault: str) -> None:
        """Rewrite the segments where the library can be written.

        A library that is open for reading is written by a connection of its own.
        """
        session, target = self._session, self._session.target
        if fault:
            self._note_fault(fault)
        try:
            if not session.readonly:
                self._settle(self._step, fault)
                return
            if target.sqlite and target.path is None:
                raise LibraryError("it is kept nowhere else", place=target.place)
            with closing(
                opened(target, create=False, readonly=False, timeout=_WRITE_TIMEOUT)
            ) as connection:

                def step(work: Step) -> bool:
                    with translated(target.place), writing(connection):
                        return work(connection)

                self._settle(step, fault)
        except LibraryError as error:
            session.note(f"the library's columns cannot be written ({error.found}): {_BESIDE}")

    def _step(self, work: Step) -> bool:
        with self._session.writing() as connection:
            return work(connection)

    def _note_fault(self, fault: str) -> None:
        self._session.note(f"the library's columns were {fault}: {_ANEW}")

    def _settle(self, step: Callable[[Step], bool], fault: str) -> None:
        """Cover and join segments; purge them first if one is damaged."""
        if fault:
            step(compaction.purge)
        try:
            self._cover_and_join(step)
        except Distrust as error:
            self._note_fault(error.found)
            step(compaction.purge)
            self._cover_and_join(step)

    def _cover_and_join(self, step: Callable[[Step], bool]) -> None:
        left: list[int] = []

        def waiting(count: int) -> None:
            left.append(count)
            self._session.progress("captures", left[0] - count, left[0])

        while step(partial(compaction.cover, waiting=waiting)):
            pass
        if left:
            waiting(0)
        while step(compaction.join):
            pass
