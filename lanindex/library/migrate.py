"""Bring a library to the newest revision. Alembic is imported only when there is work to do."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lanindex.errors import LibraryError
from lanindex.library.check import check_connection
from lanindex.library.connect import (
    DEFAULT,
    REVISION,
    Target,
    connected,
    driver_of,
    give_back_room,
    has_view,
    loose_rows,
    opened,
    refuse_revision,
    revision,
    target,
    transaction,
    translated,
)
from lanindex.library.rows import VIEW, view_sql
from lanindex.library.segments import Distrust, read_spine
from lanindex.library.store import Store

if TYPE_CHECKING:
    from sqlalchemy import Connection

_PACKAGE = Path(__file__).parents[1]
_FOLDERS = (_PACKAGE / "_migrations", _PACKAGE.parent / "migrations")
"""Where the revisions are: in a wheel, in a checkout."""

_TIMEOUT = 30.0


@dataclass(frozen=True, slots=True)
class Status:
    """How new a library is."""

    place: str
    revision: str
    newest: str
    segments: int = 0
    symbols: int = 0
    pending: int = 0
    fault: str = ""

    @property
    def state(self) -> str:
        """``current``, ``older`` (upgrade it) or ``newer`` (than this program)."""
        if self.revision == self.newest:
            return "current"
        return "older" if self.revision < self.newest else "newer"


def scripts() -> Path:
    """Return the folder of the revisions."""
    for folder in _FOLDERS:
        if (folder / "env.py").is_file():
            return folder
    raise LibraryError(
        "this installation lacks its migrations",
        place=str(_FOLDERS[0]),
        remedy="Install LanIndex again.",
    )


def status(named: str | os.PathLike[str] = DEFAULT) -> Status:
    """Return how new a library is."""
    where = target(named)
    with _connected(where, readonly=True) as connection, transaction(connection):
        held = revision(connection, where.place)
        if held is None:
            refuse_revision(held, where.place)
        if held != REVISION:
            return Status(where.place, str(held), REVISION)
        try:
            segments, _, pending = read_spine(connection)
        except Distrust as fault:
            return Status(where.place, held, REVISION, fault=fault.found)
        symbols = sum(one.symbols for one in segments)
        return Status(where.place, held, REVISION, len(segments), symbols, len(pending))


def upgrade(named: str | os.PathLike[str] = DEFAULT) -> Status:
    """Bring a library to the newest revision, in one transaction, and return its status.

    Of one that has it, columns that cannot be trusted or are an earlier version's are made anew,
    and so is the view in words.
    """
    where = target(named)
    before = status(named)
    if before.state == "newer":
        refuse_revision(before.revision, where.place)
    if before.state == "older":
        with _connected(where, readonly=False) as connection:
            # SQLite rebuilds a table to change it, and dropping the old one would take along
            # all rows that hang on it.
            if driver := driver_of(connection):
                driver.execute("PRAGMA foreign_keys = OFF")
            with transaction(connection, writes=True):
                # Another process may have done it meanwhile
                if revision(connection, where.place) != REVISION:
                    run(connection, "head", where.place)
                    if loose := loose_rows(connection):
                        raise LibraryError(
                            f"after the upgrade {len(loose)} rows would hang on nothing",
                            place=where.place,
                            remedy="Nothing was changed. Ask for what is wrong with: "
                            "lanindex db check",
                        )
            give_back_room(connection)
    else:
        with _connected(where, readonly=True) as connection, transaction(connection):
            shows_all = has_view(connection, VIEW, view_sql())
        if not shows_all:
            with (
                _connected(where, readonly=False) as connection,
                transaction(connection, writes=True),
            ):
                connection.exec_driver_sql(f"DROP VIEW IF EXISTS {VIEW}")
                connection.exec_driver_sql(view_sql())
    if status(named).fault:
        with Store.open(named) as store:
            store.cache.compact()
    return status(named)


def run(connection: Connection, to: str, place: str) -> None:
    """Run the revisions up to one of them."""
    from alembic import command
    from alembic.config import Config
    from alembic.util import CommandError
    from sqlalchemy import inspect

    config = Config()
    config.set_main_option("script_location", str(scripts()).replace("%", "%%"))
    config.set_main_option("path_separator", "os")
    config.attributes["connection"] = connection
    try:
        # Tables under a view cannot be rebuilt. It shows what they hold and holds nothing itself:
        # the revisions know nothing of it.
        if VIEW in inspect(connection).get_view_names():
            connection.exec_driver_sql(f"DROP VIEW {VIEW}")
        command.upgrade(config, to)
        if revision(connection, place) == REVISION:
            connection.exec_driver_sql(view_sql())
    except CommandError as error:
        raise LibraryError(
            f"no way leads from its revision to {to}: {error}",
            place=place,
            remedy="Ingest the captures into a new library: all in it comes from them.",
        ) from error


def check(named: str | os.PathLike[str] = DEFAULT) -> list[str]:
    """Return what is wrong inside a library, a sentence each; an empty list if nothing is."""
    where = target(named)
    with (
        closing(opened(where, create=False, readonly=True, timeout=_TIMEOUT)) as connection,
        translated(where.place),
        transaction(connection),
    ):
        return check_connection(connection)


@contextmanager
def _connected(database: Target, *, readonly: bool) -> Iterator[Any]:
    connection = connected(database, create=False, readonly=readonly, timeout=_TIMEOUT)
    with closing(connection), translated(database.place):
        yield connection
