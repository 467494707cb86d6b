"""Open a library by its name, and connect to it; errors of the database say what to do.

Statements are text, with ``:name`` for a value: a library in a file needs no more than SQLite's
own module, one on a server no more than psycopg. SQLAlchemy, which takes longer to import than
most searches take, makes and changes tables.
"""

from __future__ import annotations

import os
import re
import shlex
import sqlite3
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from threading import Lock, RLock, get_ident
from typing import TYPE_CHECKING, Any

from lanindex.data import shipped
from lanindex.errors import AbsentError, LibraryBusyError, LibraryError, LibraryVersionError
from lanindex.library.dialect import LOGIN, MEMORY, Dialect, Link, Target, Values
from lanindex.library.selection import printable
from lanindex.library.sqlite import SQLITE

if TYPE_CHECKING:
    from sqlalchemy import Connection

REVISION = "0005"
"""The revision of ``migrations/`` that `lanindex.library.schema` is; they sort by age as text."""

DEFAULT = "lanindex.db"

MOST_IDLE = 8
"""Connections that are kept for the next transactions; each has a cache of 2 MB."""

_OURS = {"alembic_version", "capture", "track"}
"""Tables by which a library of any revision is known."""

Progress = Callable[[str, int, int], None]
"""Called with what a job counts (``captures``), how many are done, and how many there are. It may
raise, which breaks off the job."""


def no_progress(noun: str, done: int, total: int) -> None:
    """Report nothing."""


def no_tick() -> None:
    """Go on."""


def dialect_of(link: Link) -> Dialect:
    """Return which kind of database a connection leads to."""
    return SQLITE if isinstance(link, sqlite3.Connection) else _postgres()


def _postgres() -> Dialect:
    from lanindex.library.postgres import POSTGRES

    return POSTGRES


def ask(link: Link, statement: str, values: Values | None = None) -> Any:
    """Execute a statement, and return the driver's cursor: rows as plain tuples."""
    return dialect_of(link).ask(link, statement, values)


def insert(link: Link, table: str, names: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """Write rows."""
    dialect_of(link).insert(link, table, names, rows)


def among(numbers: Iterable[int]) -> str:
    """Return whole numbers as the list that a column is ``IN``."""
    return f"({','.join([str(int(number)) for number in numbers]) or 'NULL'})"


def first_values(rows: Iterable[Sequence[Any]]) -> list[Any]:
    """Return the first value of each row."""
    return [row[0] for row in rows]


def faults() -> tuple[type[Exception], ...]:
    """Return the types of a database's errors; those of packages only where they are imported.

    An error of Unicode is one, too: even the messages of SQLite may be damaged in a damaged file.
    """
    packages = {"psycopg": "Error", "sqlalchemy.exc": "SQLAlchemyError"}
    imported = [getattr(sys.modules.get(it), name, None) for it, name in packages.items()]
    return sqlite3.Error, UnicodeDecodeError, *(it for it in imported if it is not None)


def _fault(error: BaseException) -> tuple[str, BaseException]:
    """Return the name of a database's error, and the error without what SQLAlchemy adds."""
    origin = getattr(error, "orig", None) or error
    ours = isinstance(origin, sqlite3.Error | UnicodeDecodeError)
    return (SQLITE if ours else _postgres()).fault(origin), origin


def is_damage(error: BaseException) -> bool:
    """Return whether an error of a database tells of damage in it."""
    return _fault(error)[0].startswith((*SQLITE.damage, *_postgres().damage))


@contextmanager
def translated(place: str) -> Iterator[None]:
    """Raise errors of the database as a LibraryError."""
    try:
        yield
    except faults() as error:
        name, origin = _fault(error)
        known = shipped("library/faults.toml")
        short = "_".join(name.split("_")[:2]) if "_" in name else name[:2]
        fault = known.get(name) or known.get(short) or known["OTHER"]
        line = str(origin).strip().partition("\n")[0]
        says = printable(re.sub(r"^(connection .* failed: )?(FATAL: +)?", "", line))
        kind = LibraryBusyError if fault.get("busy") else LibraryError
        raise kind(fault["found"].format(says=says), place=place, remedy=fault["remedy"]) from error


def target(named: str | os.PathLike[str]) -> Target:
    """Return where the library of a path or an SQLAlchemy URL is."""
    text = os.fspath(named)
    if "://" not in text:
        return in_file(text)
    kind, _, rest = text.partition("://")
    if kind.partition("+")[0] == "sqlite":
        return in_file(rest.partition("?")[0][1:] or MEMORY)
    shown = re.sub(r"(://[^:/@?]*:)[^@]*(?=@)|([?&](?:ssl)?password=)[^&]*", r"\1\2***", text)
    if kind not in ("postgresql", "postgres", "postgresql+psycopg") or not LOGIN.fullmatch(rest):
        wanted = "a path, or postgresql+psycopg://USER@HOST/DATABASE"
        raise LibraryError("this URL names no kind of library", place=shown, wanted=wanted)
    return Target(shown, text, None)


def in_file(text: str) -> Target:
    """Return where the library in a file is."""
    return Target(text, "", None if text == MEMORY else Path(text).absolute())


def connected(where: Target, *, create: bool, readonly: bool, timeout: float) -> Link:
    """Return a connection to a database of any content."""
    _check_path(where, create=create)
    dialect = _postgres() if where.url else SQLITE
    with translated(where.place):
        return dialect.connect(where, create=create, readonly=readonly, timeout=timeout)


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
            remedy=f"Make one: lanindex ingest FOLDER --db {shlex.quote(database.place)}",
        )
    if not path.parent.is_dir():
        raise LibraryError(
            f"there is no folder {path.parent}", place=database.place, remedy="Make it first."
        )


def opened(database: Target, *, create: bool, readonly: bool, timeout: float) -> Link:
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
    names = dialect_of(connection).tables(connection)
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
    if stored_revision is None and "://" in place:
        raise AbsentError(
            "there is no library in this database",
            place=place,
            remedy=f"Make one: lanindex ingest FOLDER --db {shlex.quote(place)}",
        )
    if stored_revision is None:
        raise LibraryError(
            "this file is empty",
            place=place,
            wanted="a library",
            remedy=f"Fill it: lanindex ingest FOLDER --db {shlex.quote(place)}",
        )
    if stored_revision < REVISION:
        raise LibraryVersionError(
            f"this library has revision {stored_revision}",
            place=place,
            wanted=REVISION,
            remedy=f"Bring it up to date: lanindex db upgrade --db {shlex.quote(place)}",
        )
    if stored_revision > REVISION:
        raise LibraryVersionError(
            f"this library was made by a newer LanIndex (revision {stored_revision})",
            place=place,
            wanted=REVISION,
            remedy="Install that LanIndex, or name another library with --db.",
        )


def make_tables(link: Link, place: str) -> None:
    """Make all tables at the newest revision, unless another process has just done so."""
    import sqlalchemy

    from lanindex.library.rows import VIEW, view_sql
    from lanindex.library.schema import state, tables, version

    with altering(link) as connection:
        if revision(link, place) is not None:
            return
        tables.create_all(connection)
        new = {"id": 1, "stamp": 0, "captures": 0, "numbers": 0, "columns": 0}
        connection.execute(sqlalchemy.insert(state).values(new))
        version.create(connection)
        connection.execute(sqlalchemy.insert(version).values(version_num=REVISION))
        dialect_of(link).make_view(link, VIEW, view_sql())


@contextmanager
def transaction(link: Link, *, writes: bool = False, snapshot: str = "") -> Iterator[None]:
    """Begin a transaction that sees one state of the library or, if it `writes`, may change it.

    The state is that of a `snapshot`, if one is named.
    """
    dialect = dialect_of(link)
    try:
        dialect.begin(link, writes=writes, snapshot=snapshot)
        yield
        if writes:
            link.commit()
    finally:
        dialect.end(link)  # a reader has nothing to commit


@contextmanager
def savepoint(link: Link) -> Iterator[None]:
    """Take back what is written inside a transaction if it fails, and only that."""
    ask(link, "SAVEPOINT one")
    try:
        yield
    except BaseException:
        with suppress(*faults()):  # all is taken back already where a disk is full
            ask(link, "ROLLBACK TO SAVEPOINT one")
        raise
    ask(link, "RELEASE SAVEPOINT one")


@contextmanager
def altering(link: Link) -> Iterator[Connection]:
    """Begin a transaction that changes tables, and yield SQLAlchemy's connection inside it."""
    # SQLAlchemy asks the server for its version when it connects, and ends what is begun then
    with dialect_of(link).engine(link).connect() as connection, transaction(link, writes=True):
        yield connection


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
        self.connection = self._open(create=create)
        self._idle = [self.connection]
        self.is_open, self._wrote, self._thread = True, False, get_ident()
        self._pool, self._write = Lock(), RLock()
        self._whole: tuple[int, Link] | None = None  # see `together`, and the thread that is in it

    def close(self) -> None:
        """Let go of the database, of which one file is left if it is in a file.

        A transaction that another thread has begun goes on to its end.
        """
        with self._write:
            if not self.is_open:
                return
            self._check_usable()
            try:
                if self._wrote:  # this connection, or another one
                    with self._taken() as link, translated(self.target.place):
                        dialect_of(link).after_writing(link)
            finally:
                with self._pool:
                    self.is_open, idle, self._idle = False, self._idle, []
                for one in idle:
                    one.close()

    @contextmanager
    def reading(self, snapshot: str = "") -> Iterator[Link]:
        """Begin a transaction that sees one state of the library, if named that of a snapshot."""
        if self._whole and self._whole[0] == get_ident():
            yield self._whole[1]
            return
        with (
            self._taken() as link,
            translated(self.target.place),
            transaction(link, snapshot=snapshot),
        ):
            yield link

    @contextmanager
    def writing(self) -> Iterator[Link]:
        """Begin a transaction that writes what no reader notices."""
        if self._whole and self._whole[0] == get_ident():
            with savepoint(self._whole[1]):
                yield self._whole[1]
            return
        with self._write, self._taken() as link, translated(self.target.place):
            dialect_of(link).before_writing(link)
            self._wrote = True
            with transaction(link, writes=True):
                yield link

    @contextmanager
    def together(self) -> Iterator[None]:
        """Make one transaction of all that this thread writes until the end; it reads that, too.

        A disk takes as long to keep many captures as one.
        """
        with self.writing() as link:
            self._whole = get_ident(), link
            try:
                yield
            finally:
                self._whole = None

    @contextmanager
    def _taken(self) -> Iterator[Link]:
        """Take a connection that no other thread uses."""
        link = None
        while link is None:
            with self._pool:
                self._check_usable()
                link = self._idle.pop() if self._idle else None
            if link is None:
                link = self._open(create=False)
            elif dialect_of(link).is_broken(link):  # the server has been started anew
                link = None
        try:
            yield link
        finally:
            with self._pool:
                kept = self.is_open and len(self._idle) < MOST_IDLE
                if kept:
                    self._idle.append(link)
            if not kept:
                link.close()

    def _check_usable(self) -> None:
        if not self.is_open:
            raise LibraryError(
                "this library has been closed", place=self.target.place, remedy="Open it again."
            )
        if self.target.in_memory and get_ident() != self._thread:
            raise LibraryError(
                "this library is in memory, and was opened in another thread",
                place=self.target.place,
                remedy="Keep it in a file, which serves all threads.",
            )
