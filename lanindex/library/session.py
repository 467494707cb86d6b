"""A library that is open: its connection, to whom it belongs, how it is closed."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from threading import get_ident
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from lanindex.errors import LibraryError
from lanindex.library.connect import (
    DEFAULT,
    Target,
    drop_journal,
    keep_journal,
    opened,
    reading,
    target,
    writing,
)
from lanindex.library.faults import translated
from lanindex.library.link import Link, Reader

if TYPE_CHECKING:
    from sqlalchemy import Connection


class Session:
    """An open library. Made by `open`; belongs to one thread."""

    def __init__(self, where: Target, connection: Any, *, readonly: bool = False) -> None:
        self._where, self._connection, self._wrote = where, connection, False
        self._thread, self._readonly = get_ident(), readonly

    @classmethod
    def open(
        cls,
        named: str | os.PathLike[str] = DEFAULT,
        *,
        create: bool = False,
        readonly: bool = False,
        timeout: float = 30.0,
    ) -> Self:
        """Open a library; use it as a context manager, or close it.

        Parameters
        ----------
        named : str or path-like
            A file, or an SQLAlchemy URL.
        create : bool
            Make it if there is none.
        readonly : bool
            Refuse to change it.
        timeout : float
            Seconds to wait for another process.

        Returns
        -------
        Session

        Raises
        ------
        LibraryError
            If there is none, it is no library, or it cannot be opened.
        LibraryVersionError
            If it is older or newer than this program.
        LibraryBusyError
            If another process holds it for longer than `timeout`.
        """
        where = target(named)
        connection = opened(where, create=create, readonly=readonly, timeout=timeout)
        return cls(where, connection, readonly=readonly)

    def __repr__(self) -> str:
        """Return the class and the place."""
        return f"<{type(self).__name__} {self.place}>"

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close it."""
        self.close()

    @property
    def place(self) -> str:
        """The library as it was named."""
        return self._where.place

    @property
    def is_open(self) -> bool:
        """Whether it has not been closed."""
        return not self._connection.closed

    def close(self) -> None:
        """Let go of the database; what is left is one file."""
        if self._connection.closed:
            return
        self._check_usable()
        try:
            if self._wrote:
                with translated(self.place):
                    drop_journal(self._connection)
        finally:
            self._connection.close()

    def _check_usable(self) -> None:
        if self._connection.closed:
            raise LibraryError(
                "this library has been closed", place=self.place, remedy="Open it again."
            )
        if get_ident() != self._thread:
            raise LibraryError(
                "this library was opened in another thread",
                place=self.place,
                remedy="Open it in each thread that uses it.",
            )

    @contextmanager
    def _reading(self) -> Iterator[Link]:
        self._check_usable()
        with translated(self.place), reading(self._connection):
            yield self._connection

    @contextmanager
    def _changing(self) -> Iterator[Connection]:
        from lanindex.library import write

        with self._writing() as connection:
            write.touch(connection)
            yield connection

    @contextmanager
    def _writing(self) -> Iterator[Connection]:
        """Begin a transaction for what changes nothing that a reader could tell."""
        self._check_usable()
        with translated(self.place):
            if isinstance(self._connection, Reader):
                self._connection.execute("UPDATE state SET id = id")  # SQLite refuses it
            if not self._wrote:
                keep_journal(self._connection)
                self._wrote = True
            with writing(self._connection):
                yield self._connection
