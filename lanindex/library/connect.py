"""From the name of a library to a connection: what is opened, made, or refused.

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
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from operator import methodcaller
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lanindex.errors import AbsentError, LibraryError, LibraryVersionError
from lanindex.library.link import Link, Reader, ask, driver_of, first_values, looking, translated
from lanindex.library.texts import printable

if TYPE_CHECKING:
    from sqlalchemy import Connection, Engine

REVISION = "0004"
"""The revision of ``migrations/`` that `lanindex.library.schema` is; they sort by age as text."""

DEFAULT = "lanindex.db"
MEMORY = ":memory:"

_OURS = {"alembic_version", "capture", "track"}
"""Tables by which a library of any revision is known."""

_TABLES = "SELECT name FROM sqlite_master WHERE type = 'table' AND substr(name, 1, 7) <> 'sqlite_'"


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
    """Understand a path or an SQLAlchemy URL."""
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


def _engine(where: Target, *, create: bool, timeout: float) -> Engine:
    """Return an engine whose transactions begin and wait as this page says."""
    import sqlalchemy
    from sqlalchemy.pool import NullPool

    if not where.sqlite:
        try:
            return sqlalchemy.create_engine(where.url, poolclass=NullPool)
        except (sqlalchemy.exc.SQLAlchemyError, ImportError) as error:
            raise LibraryError(f"no driver for this database: {error}", place=where.place) from None
    engine = sqlalchemy.create_engine(
        "sqlite://", creator=_opener(where.path, create, timeout), poolclass=NullPool
    )
    sqlalchemy.event.listen(engine, "begin", _begin)
    return engine


def _opener(
    path: Path | None,
    create: bool,
    timeout: float,
    factory: type[sqlite3.Connection] = sqlite3.Connection,
) -> Callable[[], sqlite3.Connection]:
    # A file that is only read is opened for writing where it may be, too: only then can a write
    # that was broken off be undone.
    name = f"{path.as_uri()}?mode={'rwc' if create else 'rw'}" if path else f"file:{MEMORY}"

    def connect() -> sqlite3.Connection:
        connection = sqlite3.connect(
            name, timeout=timeout, isolation_level=None, uri=True, factory=factory
        )
        connection.execute("PRAGMA foreign_keys = ON")
        connection.text_factory = _text
        return connection

    return connect


_text = methodcaller("decode", "utf-8", "surrogateescape")
"""Read a text. Bytes that are no UTF-8 were not stored so: a checksum names the capture."""


def _begin(connection: Connection) -> None:
    writes = connection.get_execution_options().get("writes", False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


def check_path(where: Target, *, create: bool) -> None:
    """Refuse a file that cannot be a library before anything touches it."""
    path = where.path
    if path is None:
        return
    try:
        path.stat()
    except PermissionError as error:
        raise LibraryError(
            "may not be looked at", place=where.place, wanted="a file that can be read"
        ) from error
    except OSError:
        pass  # it is not there: said below, where it must be
    if path.is_dir():
        raise LibraryError(
            "this is a folder", place=where.place, wanted="a file", remedy="Name one with --db."
        )
    if not create and not path.is_file():
        raise AbsentError(
            "there is no library here",
            place=where.place,
            remedy=f"Make one: lanindex ingest FOLDER --db {where.place}",
        )
    if not path.parent.is_dir():
        raise LibraryError(
            f"there is no folder {path.parent}", place=where.place, remedy="Make it first."
        )


def _reader(where: Target, timeout: float) -> Reader:
    found = _opener(where.path, False, timeout, Reader)()
    found.execute("PRAGMA query_only = ON")
    return found  # type: ignore[return-value]


def revision(connection: Link, place: str) -> str | None:
    """Return the revision of a library, or None where there are no tables at all.

    Reads ``alembic_version`` itself: importing Alembic takes longer than most searches.
    """
    names = _tables(connection)
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


def _tables(connection: Link) -> set[str]:
    if isinstance(connection, Reader):
        return set(first_values(ask(connection, _TABLES)))
    import sqlalchemy

    return set(sqlalchemy.inspect(connection).get_table_names())


def found_revision(connection: Link, place: str) -> str | None:
    """Return `revision`, in a transaction of its own."""
    with reading(connection):
        return revision(connection, place)


def refuse_revision(found: str | None, place: str) -> None:
    """Say what to do about a library that is empty, older or newer."""
    if found is None:
        raise LibraryError(
            "this file is empty",
            place=place,
            wanted="a library",
            remedy=f"Fill it: lanindex ingest FOLDER --db {place}",
        )
    if found < REVISION:
        raise LibraryVersionError(
            f"this library has revision {found}",
            place=place,
            wanted=REVISION,
            remedy=f"Bring it up to date: lanindex db upgrade --db {place}",
        )
    if found > REVISION:
        raise LibraryVersionError(
            f"this library was made by a newer LanIndex (revision {found})",
            place=place,
            wanted=REVISION,
            remedy="Install that LanIndex, or name another library with --db.",
        )


def keep_journal(connection: Link) -> None:
    """Keep the journal's file between transactions, which makes them cheap."""
    _journal(connection, found="delete", wanted="persist")


def drop_journal(connection: Link) -> None:
    """Leave the library as one file."""
    _journal(connection, found="persist", wanted="delete")


def _journal(connection: Link, *, found: str, wanted: str) -> None:
    # A library that its owner has given a write-ahead log keeps it.
    driver = driver_of(connection)
    if driver is not None:
        mode = driver.execute("PRAGMA journal_mode").fetchone()[0]
        if mode == found:
            driver.execute(f"PRAGMA journal_mode = {wanted}")


def is_sqlite(connection: Link) -> bool:
    """Return whether SQLite keeps a library."""
    return isinstance(connection, Reader) or connection.dialect.name == "sqlite"


def loosen_bonds(connection: Connection) -> None:
    """Let rows be changed and dropped without what hangs on them."""
    driver = driver_of(connection)
    if driver is not None:
        driver.execute("PRAGMA foreign_keys = OFF")


def give_back_room(connection: Connection) -> None:
    """Make the file as small as what is in it; leave it where there is no room to do so."""
    driver = driver_of(connection)
    if driver is not None:
        with suppress(sqlite3.Error):  # it is as good as before
            driver.execute("VACUUM")


def make_tables(connection: Connection, place: str) -> None:
    """Make all tables at the newest revision, unless another process has just done so."""
    import sqlalchemy

    from lanindex.library.schema import state, tables, version

    with writing(connection):
        if revision(connection, place) is not None:
            return
        tables.create_all(connection)
        new = {"id": 1, "stamp": 0, "captures": 0, "numbers": 0, "columns": 0}
        connection.execute(sqlalchemy.insert(state).values(new))
        version.create(connection)
        connection.execute(sqlalchemy.insert(version).values(version_num=REVISION))


def writing(connection: Connection) -> AbstractContextManager[None]:
    """Begin a transaction that holds the right to write: a context manager."""
    return _transaction(connection, writes=True)


def reading(connection: Link) -> AbstractContextManager[None]:
    """Begin a transaction that sees one state of the library: a context manager."""
    if isinstance(connection, Reader):
        return looking(connection)
    return _transaction(connection, writes=False)


@contextmanager
def _transaction(connection: Connection, *, writes: bool) -> Iterator[None]:
    connection.execution_options(writes=writes)
    try:
        with connection.begin():
            yield
    except BaseException:
        # A commit that another process kept from happening leaves SQLite's transaction open,
        # and SQLAlchemy thinks it closed.
        driver = driver_of(connection)
        if driver is not None and driver.in_transaction:
            driver.rollback()
        raise


def connected(where: Target, *, create: bool, readonly: bool, timeout: float) -> Any:
    """Return a connection to whatever is there; of a file that is only read a `Reader`."""
    check_path(where, create=create)
    with translated(where.place):
        if where.sqlite and readonly and not create:
            return _reader(where, timeout)
        return _engine(where, create=create, timeout=timeout).connect()


def opened(where: Target, *, create: bool, readonly: bool, timeout: float) -> Any:
    """Return a connection to a library at the newest revision."""
    connection = connected(where, create=create, readonly=readonly, timeout=timeout)
    try:
        with translated(where.place):
            found = found_revision(connection, where.place)
            if found is None and create:
                make_tables(connection, where.place)
                found = REVISION
        refuse_revision(found, where.place)
    except BaseException:
        connection.close()
        raise
    return connection
