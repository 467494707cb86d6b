"""A library in a file of SQLite, by Python's own module.

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

import sqlite3
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from itertools import chain
from operator import methodcaller
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lanindex.library.dialect import MEMORY, MOST, Dialect, Link, Target, Values

if TYPE_CHECKING:
    import sqlalchemy

_TICK = 0.1
"""Seconds after which who waits for SQLite is told."""


class Sqlite(Dialect):
    """SQLite."""

    damage = ("SQLITE_CORRUPT",)

    def connect(self, target: Target, *, create: bool, readonly: bool, timeout: float) -> Link:
        """Open a file, or a library in memory."""
        # A file that is only read is opened for writing where it may be, too: only then can a
        # write that was broken off be undone.
        path, mode = target.path, "rwc" if create else "rw"
        link = sqlite3.connect(
            f"{path.as_uri()}?mode={mode}" if path else f"file:{MEMORY}",
            timeout=timeout,
            isolation_level=None,
            uri=True,
            check_same_thread=False,
        )
        link.execute("PRAGMA foreign_keys = ON")
        # Bytes that are no UTF-8 are damage: a checksum names the capture.
        link.text_factory = methodcaller("decode", "utf-8", "surrogateescape")
        if readonly and not create:
            link.execute("PRAGMA query_only = ON")
        return link

    def engine(self, link: Link) -> sqlalchemy.Engine:
        """Return an engine on this connection."""
        import sqlalchemy

        pool = sqlalchemy.StaticPool
        return sqlalchemy.create_engine("sqlite://", creator=lambda: link, poolclass=pool)

    def begin(self, link: Link, *, writes: bool, snapshot: str = "") -> None:
        """Begin a transaction."""
        link.execute("BEGIN IMMEDIATE" if writes else "BEGIN")

    def snapshot(self, link: Link) -> str:
        """Return nothing: while somebody reads, nobody can change a file."""
        return ""

    def end(self, link: Link) -> None:
        """Undo what has not been committed, as another process may have kept a commit from."""
        if link.in_transaction:
            link.rollback()

    def is_broken(self, link: Link) -> bool:
        """Return False: a file stays."""
        return False

    def ask(self, link: Link, statement: str, values: Values | None) -> Any:
        """Execute a statement."""
        if values is None or isinstance(values, Mapping):
            return link.execute(statement, values or {})
        return link.cursor().executemany(statement, values)

    def insert(
        self, link: Link, table: str, names: Sequence[str], rows: Sequence[Sequence[Any]]
    ) -> None:
        """Write rows, many in a statement, which is faster than one by one."""
        begin = f"INSERT INTO {table} ({', '.join(names)}) VALUES "
        row, many = f"({', '.join('?' * len(names))})", MOST // len(names)
        for first in range(0, len(rows), many):
            some = rows[first : first + many]
            link.execute(begin + ", ".join([row] * len(some)), [*chain.from_iterable(some)])

    def last_number(self, link: Link, table: str) -> int:
        """Return the highest number that a row has ever had, or has where that is not kept."""
        asked = "SELECT max(seq) FROM sqlite_sequence WHERE name = :name"
        ((kept,),) = link.execute(asked, {"name": table})
        ((highest,),) = link.execute(f"SELECT max(id) FROM {table}")
        return max(kept or 0, highest or 0)

    def go_on_after(self, link: Link, table: str, number: int) -> None:
        """Note the highest number; a table that keeps none gives out what is free."""
        values = {"number": number, "name": table}
        link.execute("UPDATE sqlite_sequence SET seq = :number WHERE name = :name", values)

    def fault(self, error: BaseException) -> str:
        """Return SQLite's name of an error; its messages may be damaged in a damaged file, too."""
        if isinstance(error, UnicodeDecodeError):
            return "SQLITE_CORRUPT"
        return getattr(error, "sqlite_errorname", None) or ""

    def tables(self, link: Link) -> set[str]:
        """Return the names of all tables."""
        asked = "SELECT name FROM sqlite_master WHERE type = 'table' "
        return {name for (name,) in link.execute(f"{asked} AND substr(name, 1, 7) <> 'sqlite_'")}

    def view(self, link: Link, name: str) -> str | None:
        """Return the statement that made a view."""
        asked = "SELECT sql FROM sqlite_master WHERE type = 'view' AND name = :name"
        row = link.execute(asked, {"name": name}).fetchone()
        return row[0] if row else None

    def make_view(self, link: Link, name: str, statement: str) -> None:
        """Make a view."""
        link.execute(f"DROP VIEW IF EXISTS {name}")
        link.execute(statement)

    def numbers(self, link: Link, names: Sequence[str], chosen: str) -> NDArray[np.int64] | None:
        """Return rows of symbols as characters of one text, which numpy reads as an array.

        To fetch numbers one by one takes longer than to read them. The condition leaves out values
        that are not numbers; the plus signs keep SQLite from converting the text ``''`` to a number
        in each row.
        """
        short = [name for name in names if name not in _LONG]
        characters = (
            *(f"{name} % {_FULL}" for name in _LONG),
            *(f"{name} / {_FULL} % {_FULL}" for name in _LONG),  # faster than shift and mask
            *(f"{name} >> {2 * _BITS}" for name in _LONG),  # below 0 where the number is
            *short,
        )
        ((text,),) = link.execute(
            f"SELECT CAST(group_concat(char({', '.join(characters)}), '') AS BLOB) "
            f"FROM symbol_code WHERE +sign < '' AND +notes < '' AND {chosen}"
        )
        spelled = (text or b"").decode("utf-8", "surrogatepass")
        read = np.frombuffer(spelled.encode("utf-32-le", "surrogatepass"), "<u4")
        read = read.reshape(-1, len(characters))
        count = len(_LONG)
        if (read[:, 2 * count :] == _REPLACEMENT_CHARACTER).any():
            return None
        wide = read.astype(np.int64)
        found = np.empty((len(wide), len(names)), np.int64)
        for at, name in enumerate(_LONG):
            low, middle, high = (wide[:, at + count * place] for place in range(3))
            found[:, names.index(name)] = low | middle << _BITS | high << 2 * _BITS
        for at, name in enumerate(short, 3 * count):
            found[:, names.index(name)] = wide[:, at]
        return found

    def damaged_pages(self, link: Link, most: int, watch: Callable[[int, int], None]) -> list[str]:
        """Return the damage in the pages of the file.

        SQLite looks at all of them at once, and does not tell how far it is: in a thread, so that
        whoever waits is told that it does, and can break it off.
        """
        ((pages,),) = link.execute("PRAGMA page_count")
        lines = list[str]()

        def look() -> None:
            # quick_check takes two thirds of the time, but leaves out whether the keys of rows
            # rise, and nothing else looks at the keys of symbols.
            try:
                found = link.execute(f"PRAGMA integrity_check({most})").fetchall()
                lines.extend(line for (line,) in found)
            except (sqlite3.Error, UnicodeDecodeError) as error:
                lines.append(str(error))

        thread = Thread(target=look)
        thread.start()
        try:
            while thread.is_alive():
                watch(0, pages)
                thread.join(_TICK)
        finally:
            while thread.is_alive():  # what is broken off may not have begun yet
                link.interrupt()
                thread.join(_TICK)
        watch(pages, pages)
        return [line for line in lines if line != "ok"]

    def size(self, link: Link) -> int:
        """Return the bytes of the file."""
        path = _path(link)
        return path.stat().st_size if path else 0

    def folder(self, link: Link) -> Path | None:
        """Return the folder of the file."""
        path = _path(link)
        return path and path.parent

    def moment(self, link: Link) -> int:
        """Return the second."""
        return int(time.time())

    def oldest_reader(self, link: Link, spared: float) -> float:
        """Return the moment below which no reader that goes on can have begun."""
        # To commit, a rollback journal waits for all readers: those that go on began afterwards.
        # Beside a write-ahead log they may read on, and nothing tells of them.
        ((mode,),) = link.execute("PRAGMA journal_mode")
        return time.time() - spared if mode == "wal" else float("inf")

    def before_rebuilding(self, link: Link) -> None:
        """Switch off what would take along all rows that hang on a table that is rebuilt."""
        link.execute("PRAGMA foreign_keys = OFF")

    def before_writing(self, link: Link) -> None:
        """Keep the journal's file from now on."""
        _change_journal(link, "delete", "persist")

    def after_writing(self, link: Link) -> None:
        """Delete the journal's file, also one that another connection kept."""
        _change_journal(link, "delete", "persist")
        _change_journal(link, "persist", "delete")

    def give_back_room(self, link: Link) -> None:
        """Make the file as small as its content; leave it as it is if the disk has no room."""
        with suppress(sqlite3.Error):
            link.execute("VACUUM")


SQLITE = Sqlite()

_BITS = 20
"""Bits of a number that one character holds."""

_FULL = 1 << _BITS

_LONG = ("sign", "notes")
"""Columns of ``symbol_code`` whose numbers take three characters; the others take one."""

_REPLACEMENT_CHARACTER = 0xFFFD
"""What SQLite writes for a number that is no character. A short number may have this value, too,
which is rare."""


def _path(link: Link) -> Path | None:
    """Return the library's file; None: it is in memory."""
    (path,) = [it for _, name, it in link.execute("PRAGMA database_list") if name == "main"]
    return Path(path) if path else None


def _change_journal(link: Link, before: str, after: str) -> None:
    """Change the mode of the journal; a write-ahead log that its owner has chosen stays."""
    ((mode,),) = link.execute("PRAGMA journal_mode")
    if mode == before:
        link.execute(f"PRAGMA journal_mode = {after}")
