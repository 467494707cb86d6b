"""Connections of both kinds, asked in one way, and their errors in words that a person can act on.

A library in a file that is only read needs no more than SQLite's own module. SQLAlchemy, which
takes longer to import than most searches take, is for what writes and for other databases. So
whatever reads says what it asks as text, with ``:name`` for a value.
"""

from __future__ import annotations

import sqlite3
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeAlias

from lanindex.errors import LibraryBusyError, LibraryError

if TYPE_CHECKING:
    from sqlalchemy import Connection, TextClause


class Reader(sqlite3.Connection):
    """A connection to a file that is only read."""

    closed = False

    def close(self) -> None:
        """Let go of the file."""
        super().close()
        self.closed = True


Link: TypeAlias = "Reader | Connection"

Values = Mapping[str, Any] | Sequence[Mapping[str, Any]]
"""Of one statement, or of the same one many times."""


def ask(link: Link, statement: str, values: Values | None = None) -> Any:
    """Carry out a statement, and return the driver's cursor: rows as plain tuples."""
    driver = driver_of(link)
    if driver is None:
        return _through_sqlalchemy(link, statement, values or {})
    if values is None or isinstance(values, Mapping):
        return driver.execute(statement, values or {})
    return driver.executemany(statement, values)


def driver_of(link: Link) -> sqlite3.Connection | None:
    """Return SQLite's own connection, if it is open and one: SQLAlchemy's detour takes longer."""
    if link.closed:
        return None
    if isinstance(link, Reader):
        return link
    driver = link.connection.driver_connection
    return driver if isinstance(driver, sqlite3.Connection) else None


def _through_sqlalchemy(connection: Any, statement: str, values: Values) -> Any:
    return connection.execute(_text(statement), values).cursor


@lru_cache(maxsize=128)
def _text(statement: str) -> TextClause:
    from sqlalchemy import text

    return text(statement)


def among(numbers: Iterable[int]) -> str:
    """Return whole numbers as the list that a column is ``IN``."""
    return f"({','.join([str(int(number)) for number in numbers]) or 'NULL'})"


def first_values(found: Iterable[Sequence[Any]]) -> list[Any]:
    """Return the first value of each row."""
    return [row[0] for row in found]


@contextmanager
def looking(reader: Reader) -> Iterator[None]:
    """Begin a transaction that sees one state of a file; there is nothing to commit."""
    reader.execute("BEGIN")
    try:
        yield
    finally:
        if reader.in_transaction:
            reader.rollback()


def faults() -> tuple[type[Exception], ...]:
    """Return what a database's errors are; SQLAlchemy's only where somebody has imported it.

    An error of Unicode is one, too: not even what SQLite says of a damaged file can be read then.
    """
    imported = sys.modules.get("sqlalchemy.exc")
    return sqlite3.Error, UnicodeDecodeError, *([imported.SQLAlchemyError] if imported else [])


_AGAIN = "What was stored before is whole; run again"

_FAULTS: dict[str, tuple[type[LibraryError], str, str]] = {
    "SQLITE_BUSY": (
        LibraryBusyError,
        "another process holds the library",
        "Wait until it has ended (or end it), then run again.",
    ),
    "SQLITE_READONLY": (
        LibraryError,
        "the library or its folder may not be written",
        "Give yourself the right to write both, or name another library with --db.",
    ),
    "SQLITE_READONLY_ROLLBACK": (
        LibraryError,
        "a write was broken off here and cannot be undone without the right to write",
        "Open the library once with the right to write it and its folder.",
    ),
    "SQLITE_FULL": (LibraryError, "the disk is full", f"{_AGAIN} when there is room."),
    "SQLITE_IOERR": (
        LibraryError,
        "the disk cannot be read or written",
        f"{_AGAIN} when the disk is well (is it full, or gone?).",
    ),
    "SQLITE_NOTADB": (
        LibraryError,
        "this is not a library",
        "Name a library, or a new file, with --db.",
    ),
    "SQLITE_CORRUPT": (
        LibraryError,
        "the library is damaged",
        "Ingest the captures into a new library: all in it comes from them.",
    ),
    "SQLITE_CANTOPEN": (
        LibraryError,
        "the library cannot be opened",
        "Check that its folder exists and that you may read and write both.",
    ),
}
"""By SQLite's name of the result, the longer one first looked for."""

_UNKNOWN = "Ask it for what is wrong with: lanindex db check"


def _named(error: BaseException) -> str:
    if isinstance(error, UnicodeDecodeError):  # not even what SQLite says of it can be read
        return "SQLITE_CORRUPT"
    return getattr(error, "sqlite_errorname", None) or ""


def library_error(error: Exception, place: str) -> LibraryError:
    """Return the LibraryError that says what a database's error means."""
    origin = getattr(error, "orig", None) or error
    name = _named(origin)
    fault = _FAULTS.get(name) or _FAULTS.get("_".join(name.split("_")[:2]))
    if fault is None:
        return LibraryError(f"the database says: {origin}", place=place, remedy=_UNKNOWN)
    kind, found, remedy = fault
    return kind(found, place=place, remedy=remedy)


@contextmanager
def translated(place: str) -> Iterator[None]:
    """Raise every error of the database inside as a LibraryError."""
    try:
        yield
    except faults() as error:
        raise library_error(error, place) from error
