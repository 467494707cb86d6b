"""The connection of an open library: to which thread it belongs, its transactions, its end."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import get_ident
from typing import TYPE_CHECKING, Any

from lanindex.errors import LibraryError
from lanindex.library.connect import (
    Target,
    drop_journal,
    keep_journal,
    opened,
    reading,
    writing,
)
from lanindex.library.link import Link, Reader, translated

if TYPE_CHECKING:
    from sqlalchemy import Connection

Progress = Callable[[str, int, int], None]
"""Called with what a job counts (``captures``), how many are done, and how many there are. It may
raise, which breaks off the job."""


def no_progress(noun: str, done: int, total: int) -> None:
    """Report nothing."""


class Session:
    """The connection of an open library; it belongs to one thread."""

    def __init__(
        self,
        target: Target,
        *,
        create: bool,
        readonly: bool,
        timeout: float,
        note: Callable[[str], None] | None,
        progress: Progress | None,
    ) -> None:
        self.target, self.readonly = target, readonly
        self.notes: list[str] = []
        self.note = note or self.notes.append
        self.progress = progress or no_progress
        self.connection: Any = opened(target, create=create, readonly=readonly, timeout=timeout)
        self._wrote, self._thread = False, get_ident()

    @property
    def is_open(self) -> bool:
        """Whether it has not been closed."""
        return not self.connection.closed

    def close(self) -> None:
        """Let go of the database; what is left is one file."""
        if not self.is_open:
            return
        self._check_usable()
        try:
            if self._wrote:
                with translated(self.target.place):
                    drop_journal(self.connection)
        finally:
            self.connection.close()

    @contextmanager
    def reading(self) -> Iterator[Link]:
        """Begin a transaction that sees one state of the library."""
        self._check_usable()
        with translated(self.target.place), reading(self.connection):
            yield self.connection

    @contextmanager
    def changing(self) -> Iterator[Connection]:
        """Begin a transaction that changes what the library holds, and raise its change stamp."""
        from lanindex.library import write

        with self.writing() as connection:
            write.touch(connection)
            yield connection

    @contextmanager
    def writing(self) -> Iterator[Connection]:
        """Begin a transaction that changes nothing that a reader can tell."""
        self._check_usable()
        with translated(self.target.place):
            if isinstance(self.connection, Reader):
                self.connection.execute("UPDATE state SET id = id")  # SQLite refuses it
            if not self._wrote:
                keep_journal(self.connection)
                self._wrote = True
            with writing(self.connection):
                yield self.connection

    def _check_usable(self) -> None:
        if not self.is_open:
            raise LibraryError(
                "this library has been closed", place=self.target.place, remedy="Open it again."
            )
        if get_ident() != self._thread:
            raise LibraryError(
                "this library was opened in another thread",
                place=self.target.place,
                remedy="Open it in each thread that uses it.",
            )
