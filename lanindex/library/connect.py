"""Open a library by its name, and connect to it; errors of the database say what to do.

A library in a file that is only read needs no more than SQLite's own module. SQLAlchemy, which
takes longer to import than most searches take, is for writing and for other databases. So
statements are text, with ``:name`` for a value.

An SQLite library is one file at rest. Its journal is a rollback journal, not a write-ahead log:
a log leaves two more files beside the library, cannot be read from a folder that may not be
written, and fails on network disks. While a process writes, it keeps the journal's file
(``PERSIST``), and on closing the journal goes. A transaction of 400 symbols so costs 2.4 ms on an
idle disk (6.2 with a journal that is deleted each time, 2.0 with a log) and 16 ms on a busy one
(21; 3): the price of waiting for the disk, so that a power cut loses nothing. The right to write
is taken when a transaction begins (``BEGIN IMMEDIATE``), so that two writers wait for each other
and never fail halfway.
"""

from __future__ import annotations

import os
import sqlite3
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from functools import partial
from itertools import chain
from operator import methodcaller
from pathlib import Path
from threading import Lock, RLock, get_ident
from typing import TYPE_CHECKING, Any, TypeAlias

from lanindex.data import shipped
from lanindex.errors import AbsentError, LibraryBusyError, LibraryError, LibraryVersionError
from lanindex.library.selection import printable

if TYPE_CHECKING:
    from sqlalchemy import Connection, Engine

REVISION = "0005"
"""The revision of ``migrations/`` that `lanindex.library.schema` is; they sort by age as text."""

DEFAULT = "lanindex.db"
MEMORY = ":memory:"

MOST = 999
"""Values in one statement: any SQLite takes so many."""

MOST_IDLE = 8
"""Connections that are kept for the next transactions; each has a cache of 2 MB."""

_OURS = {"alembic_version", "capture", "track"}
"""Tables by which a library of any revision is known."""

Progress = Callable[[str, int, int], None]
"""Called with what a job counts (``captures``), how many are done, and how many there are. It may
raise, which breaks off the job."""

Values = Mapping[str, Any] | Sequence[Mapping[str, Any]]
"""Of one statement, or of the same one many times."""


def no_progress(noun: str, done: int, total: int) -> None:
    """Report nothing."""


def no_tick() -> None:
    """Go on."""


Link: TypeAlias = "sqlite3.Connection | Connection"
"""SQLite's own to a file that is only read, else SQLAlchemy's."""


def ask(link: Link, statement: str, values: Values | None = None) -> Any:
    """Execute a statement, and return the driver's cursor: rows as plain tuples."""
    driver = driver_of(link)
    if driver is None:
        from sqlalchemy import text

        connection: Any = link
        return connection.execute(text(statement), values or {}).cursor
    if values is None or isinstance(values, Mapping):
        return driver.execute(statement, values or {})
    return driver.executemany(statement, values)


def insert(link: Link, table: str, names: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """Write rows, many in a statement, which SQLite's module does faster than one by one."""
    begin, driver = f"INSERT INTO {table} ({', '.join(names)}) VALUES ", driver_of(link)
    if driver is None and rows:
        named = ", ".join([f":{name}" for name in names])
        ask(link, f"{begin}({named})", [dict(zip(names, row, strict=True)) for row in rows])
    elif driver is not None:
        row, many = f"({', '.join('?' * len(names))})", MOST // len(names)
        for first in range(0, len(rows), many):
            some = rows[first : first + many]
            driver.execute(begin + ", ".join([row] * len(some)), [*chain.from_iterable(some)])


def driver_of(link: Link) -> sqlite3.Connection | None:
    """Return SQLite's own connection, which is faster than SQLAlchemy; None if there is none."""
    if isinstance(link, sqlite3.Connection):
        return link
    if link.closed:
        return None
    driver = link.connection.driver_connection
    return driver if isinstance(driver, sqlite3.Connection) else None


def among(numbers: Iterable[int]) -> str:
    """Return whole numbers as the list that a column is ``IN``."""
    return f"({','.join([str(int(number)) for number in numbers]) or 'NULL'})"


def first_values(rows: Iterable[Sequence[Any]]) -> list[Any]:
    """Return the first value of each row."""
    return [row[0] for row in rows]


def faults() -> tuple[type[Exception], ...]:
    """Return the types of a database's errors; SQLAlchemy's only where it is imported.

    An error of Unicode is one, too: even the messages of SQLite may be damaged in a damaged file.
    """
    imported = sys.modules.get("sqlalchemy.exc")
    return sqlite3.Error, UnicodeDecodeError, *([imported.SQLAlchemyError] if imported else [])


def name_of(error: BaseException) -> str:
    """Return SQLite's name of a database's error; empty where there is none."""
    return getattr(getattr(error, "orig", None) or error, "sqlite_errorname", None) or ""


@contextmanager
def translated(place: str) -> Iterator[None]:
    """Raise errors of the database as a LibraryError."""
    try:
        yield
    except faults() as error:
        origin = getattr(error, "orig", None) or error
        name = "SQLITE_CORRUPT" if isinstance(origin, UnicodeDecodeError) else name_of(error)
        short = "_".join(name.split("_")[:2])
        unknown = f"the database says: {origin}", "Ask it for what is wrong with: lanindex db check"
        known = shipped("library/faults.toml")
        found, remedy = known.get(name) or known.get(short) or unknown
        kind = LibraryBusyError if short == "SQLITE_BUSY" else LibraryError
        raise kind(found, place=place, remedy=remedy) from error


@dataclass(frozen=True, slots=True)
class Target:
    """Where a library is."""

    place: str
    url: str
    path: Path | None

    @property
    def sqlite(self) -> bool:
        """Whether SQLite keeps it."""
        return not self.url


def target(named: str | os.PathLike[str]) -> Target:
    """Return where the library of a path or an SQLAlchemy URL is."""
    text = os.fspath(named)
    if "://" not in text:
        return Target(text, "", None if text == MEMORY else Path(text).absolute())
    import sqlalchemy

    try:
        url = sqlalchemy.make_url(text)
        backend = url.get_backend_name()
    except sqlalchemy.exc.SQLAlchemyError as error:
        raise LibraryError(
            "this URL names no database that SQLAlchemy knows",
            place=text,
            wanted="a path, or sqlite:///PATH",
        ) from error
    if backend == "sqlite":
        return target(url.database or MEMORY)
    return Target(url.render_as_string(), text, None)


def connected(database: Target, *, create: bool, readonly: bool, timeout: float) -> Any:
    """Return a connection to a database of any content."""
    _check_path(database, create=create)
    with translated(database.place):
        if database.sqlite and readonly and not create:
            reader = _sqlite_connection(database.path, False, timeout)
            reader.execute("PRAGMA query_only = ON")
            return reader
        return _engine(database, create=create, timeout=timeout).connect()


def _check_path(database: Target, *, create: bool) -> None:
    """Refuse a file that cannot be a library before anything touches it."""
    path = database.path
    if path is None:
        return
    try:
        path.stat()
    except PermissionError as error:
        raise LibraryError(
            "may not be looked at", place=database.place, wanted="a file that can be read"
        ) from error
    except OSError:
        pass  # It is not there: refused below where it must be
    if path.is_dir():
        raise LibraryError(
            "this is a folder", place=database.place, wanted="a file", remedy="Name one with --db."
        )
    if not create and not path.is_file():
        raise AbsentError(
            "there is no library here",
            place=database.place,
            remedy=f"Make one: lanindex ingest FOLDER --db {database.place}",
        )
    if not path.parent.is_dir():
        raise LibraryError(
            f"there is no folder {path.parent}", place=database.place, remedy="Make it first."
        )


def _engine(database: Target, *, create: bool, timeout: float) -> Engine:
    """Return an engine whose transactions begin and wait as described above."""
    import sqlalchemy
    from sqlalchemy.pool import NullPool

    if not database.sqlite:
        try:
            return sqlalchemy.create_engine(database.url, poolclass=NullPool)
        except (sqlalchemy.exc.SQLAlchemyError, ImportError) as error:
            raise LibraryError(
                f"no driver for this database: {error}", place=database.place
            ) from None

    def begin(connection: Connection) -> None:
        writes = connection.get_execution_options().get("writes", False)
        connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")

    creator = partial(_sqlite_connection, database.path, create, timeout)
    engine = sqlalchemy.create_engine("sqlite://", creator=creator, poolclass=NullPool)
    sqlalchemy.event.listen(engine, "begin", begin)
    return engine


def _sqlite_connection(path: Path | None, create: bool, timeout: float) -> sqlite3.Connection:
    # A file that is only read is opened for writing where it may be, too: only then can a write
    # that was broken off be undone.
    name = f"{path.as_uri()}?mode={'rwc' if create else 'rw'}" if path else f"file:{MEMORY}"
    connection = sqlite3.connect(
        name, timeout=timeout, isolation_level=None, uri=True, check_same_thread=False
    )
    connection.execute("PRAGMA foreign_keys = ON")
    # Bytes that are no UTF-8 are damage: a checksum names the capture.
    connection.text_factory = methodcaller("decode", "utf-8", "surrogateescape")
    return connection


def opened(database: Target, *, create: bool, readonly: bool, timeout: float) -> Any:
    """Return a connection to a library at the newest revision."""
    connection = connected(database, create=create, readonly=readonly, timeout=timeout)
    try:
        with translated(database.place):
            with transaction(connection):
                stored_revision = revision(connection, database.place)
            if stored_revision is None and create:
                make_tables(connection, database.place)
                stored_revision = REVISION
        refuse_revision(stored_revision, database.place)
    except BaseException:
        connection.close()
        raise
    return connection


def revision(connection: Link, place: str) -> str | None:
    """Return the revision of a library, or None where there are no tables at all.

    Reads ``alembic_version`` itself: importing Alembic takes longer than most searches.
    """
    if isinstance(connection, sqlite3.Connection):
        asked = "SELECT name FROM sqlite_master WHERE type = 'table' "
        names = {*first_values(ask(connection, f"{asked} AND substr(name, 1, 7) <> 'sqlite_'"))}
    else:
        import sqlalchemy

        names = {*sqlalchemy.inspect(connection).get_table_names()}
    if not names:
        return None
    asked = "SELECT version_num FROM alembic_version"
    stamps = first_values(ask(connection, asked)) if names >= _OURS else []
    if len(stamps) != 1:
        raise LibraryError(
            "this is another program's database",
            place=place,
            wanted="a library",
            remedy="Name a library, or a new file, with --db.",
        )
    return printable(str(stamps[0]))


def refuse_revision(stored_revision: str | None, place: str) -> None:
    """Refuse a library that is empty, older or newer, with what to do about it."""
    if stored_revision is None:
        raise LibraryError(
            "this file is empty",
            place=place,
            wanted="a library",
            remedy=f"Fill it: lanindex ingest FOLDER --db {place}",
        )
    if stored_revision < REVISION:
        raise LibraryVersionError(
            f"this library has revision {stored_revision}",
            place=place,
            wanted=REVISION,
            remedy=f"Bring it up to date: lanindex db upgrade --db {place}",
        )
    if stored_revision > REVISION:
        raise LibraryVersionError(
            f"this library was made by a newer LanIndex (revision {stored_revision})",
            place=place,
            wanted=REVISION,
            remedy="Install that LanIndex, or name another library with --db.",
        )


def make_tables(connection: Connection, place: str) -> None:
    """Make all tables at the newest revision, unless another process has just done so."""
    import sqlalchemy

    from lanindex.library.schema import state, tables, version

    with transaction(connection, writes=True):
        if revision(connection, place) is not None:
            return
        tables.create_all(connection)
        new = {"id": 1, "stamp": 0, "captures": 0, "numbers": 0, "columns": 0}
        connection.execute(sqlalchemy.insert(state).values(new))
        version.create(connection)
        connection.execute(sqlalchemy.insert(version).values(version_num=REVISION))


@contextmanager
def transaction(connection: Link, *, writes: bool = False) -> Iterator[None]:
    """Begin a transaction that sees one state of the library or, if it `writes`, may change it."""
    begun: AbstractContextManager[Any] = nullcontext()
    if isinstance(connection, sqlite3.Connection):
        connection.execute("BEGIN")
    else:
        connection.execution_options(writes=writes)
        begun = connection.begin()
    try:
        with begun:
            yield
    finally:
        # A reader has nothing to commit. A commit that another process kept from happening leaves
        # SQLite's transaction open, and SQLAlchemy thinks it closed.
        driver = driver_of(connection)
        if driver is not None and driver.in_transaction:
            driver.rollback()


def change_journal(connection: Link, before: str, after: str) -> None:
    """Change the mode of the journal; a write-ahead log that its owner has chosen stays."""
    driver = driver_of(connection)
    if driver is not None:
        mode = driver.execute("PRAGMA journal_mode").fetchone()[0]
        if mode == before:
            driver.execute(f"PRAGMA journal_mode = {after}")


def is_sqlite(connection: Link) -> bool:
    """Return whether SQLite keeps a library."""
    return isinstance(connection, sqlite3.Connection) or connection.dialect.name == "sqlite"


class Session:
    """The connections of an open library and its transactions; several threads may use it.

    Each transaction takes a connection that no other one uses: there are as many as transactions
    are open at once. Those that write come one after the other. A library in memory has one
    connection, and belongs to the thread that opened it.
    """

    def __init__(
        self,
        target: Target,
        *,
        create: bool = False,
        readonly: bool = False,
        timeout: float = 30.0,
        note: Callable[[str], None] | None = None,
        progress: Progress | None = None,
    ) -> None:
        self.target, self.readonly = target, readonly
        self.notes: list[str] = []
        self.note = note or self.notes.append
        self.progress = progress or no_progress
        self._open = partial(opened, target, readonly=readonly, timeout=timeout)
        self.connection: Any = self._open(create=create)
        self._idle = [self.connection]
        self.is_open, self._wrote, self._thread = True, False, get_ident()
        self._pool, self._write = Lock(), RLock()

    def close(self) -> None:
        """Let go of the database; what is left is one file.

        A transaction that another thread has begun goes on to its end.
        """
        with self._write:
            if not self.is_open:
                return
            self._check_usable()
            try:
                if self._wrote:  # this connection, or another one
                    with self._taken() as connection, translated(self.target.place):
                        change_journal(connection, "delete", "persist")
                        change_journal(connection, "persist", "delete")
            finally:
                with self._pool:
                    self.is_open, idle, self._idle = False, self._idle, []
                for one in idle:
                    one.close()

    @contextmanager
    def reading(self) -> Iterator[Link]:
        """Begin a transaction that sees one state of the library."""
        with (
            self._taken() as connection,
            translated(self.target.place),
            transaction(connection),
        ):
            yield connection

    @contextmanager
    def writing(self) -> Iterator[Connection]:
        """Begin a transaction that writes what no reader notices."""
        with self._write, self._taken() as connection, translated(self.target.place):
            if isinstance(connection, sqlite3.Connection):
                connection.execute("UPDATE state SET id = id")  # SQLite refuses it
            change_journal(connection, "delete", "persist")
            self._wrote = True
            with transaction(connection, writes=True):
                yield connection

    @contextmanager
    def _taken(self) -> Iterator[Any]:
        """Take a connection that no other thread uses."""
        with self._pool:
            self._check_usable()
            connection = self._idle.pop() if self._idle else None
        if connection is None:
            connection = self._open(create=False)
        try:
            yield connection
        finally:
            with self._pool:
                kept = self.is_open and len(self._idle) < MOST_IDLE
                if kept:
                    self._idle.append(connection)
            if not kept:
                connection.close()

    def _check_usable(self) -> None:
        if not self.is_open:
            raise LibraryError(
                "this library has been closed", place=self.target.place, remedy="Open it again."
            )
        in_memory = self.target.sqlite and self.target.path is None
        if in_memory and get_ident() != self._thread:
            raise LibraryError(
                "this library is in memory, and was opened in another thread",
                place=self.target.place,
                remedy="Keep it in a file, which serves all threads.",
            )
