"""Connections of both kinds, asked in one way: SQLite's own, and SQLAlchemy's.

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
