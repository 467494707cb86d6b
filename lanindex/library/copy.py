"""Copy a library into another database: from SQLite to PostgreSQL, back, or to a new file."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import closing
from typing import Any

from lanindex.errors import LibraryError, UsageError, counted
from lanindex.library import read, segments
from lanindex.library.connect import (
    Progress,
    Session,
    among,
    ask,
    dialect_of,
    insert,
    no_progress,
    target,
    translated,
)
from lanindex.library.dialect import Link
from lanindex.library.store import Store

_BATCH = 256
"""Captures that are copied at once."""


def copy(
    source: str | os.PathLike[str],
    to: str | os.PathLike[str],
    note: Callable[[str], None] | None = None,
    progress: Progress = no_progress,
) -> int:
    """Copy a library into a new one, and return how many captures it has.

    All captures keep their numbers, so both libraries answer alike. Each is checked as it is read.
    It is one transaction: an interruption leaves an empty library. The columns that searches read
    are made anew, of the rows.
    """
    where, into = target(source), target(to)
    if (where.url, where.path) == (into.url, into.path):
        raise UsageError("a library copied onto itself", place=into.place, wanted="another one")
    with (
        closing(Session(where, readonly=True)) as old,
        Store(Session(into, create=True, note=note, progress=progress)) as new,
    ):
        with old.reading() as link, new.session.writing() as copied:
            there = read.read_state(copied)
            if there.captures:
                raise UsageError(
                    f"this library has {counted(there.captures, 'capture')}",
                    place=into.place,
                    wanted="a new one",
                    remedy="Name another file, database or schema.",
                )
            with translated(where.place):  # or the new library would be named
                numbers = read.capture_numbers(link)
                last = {it: dialect_of(link).last_number(link, it) for it in ("profile", "capture")}
                profiles = _rows(link, "profile")
            insert(copied, *profiles)
            for first in range(0, len(numbers), _BATCH):
                progress("captures", first, len(numbers))
                some = numbers[first : first + _BATCH]
                with translated(where.place):
                    _check(link, some, where.place)
                    tables = [_rows(link, "capture", f"WHERE id IN {among(some)}")]
                    for table in ("metadata", "track", "symbol_code"):
                        tables.append(_rows(link, table, f"WHERE capture_id IN {among(some)}"))
                for rows in tables:
                    insert(copied, *rows)
            progress("captures", len(numbers), len(numbers))
            for table, number in last.items():
                dialect_of(copied).go_on_after(copied, table, number)
            held = {"stamp": there.stamp + 1, "captures": len(numbers), "numbers": sum(numbers)}
            changes = ", ".join(f"{name} = :{name}" for name in held)
            ask(copied, f"UPDATE state SET {changes}", held)
            segments.begin_anew(copied)
        new.cache.compact()
    return len(numbers)


def _check(link: Link, numbers: list[int], place: str) -> None:
    """Raise an error where one of some captures is damaged."""
    chosen = read.read_captures(link, numbers)
    if len(chosen) != len(numbers):
        remedy = "Ask which: lanindex db check"
        raise LibraryError("captures are missing", place=place, remedy=remedy)
    read.read_symbols(link, read.read_track_rows(link, chosen))
    for _ in read.read_contents(link, chosen):
        pass


def _rows(link: Link, table: str, where: str = "") -> tuple[str, list[str], list[Any]]:
    """Return a table's name, its columns, and the rows that a condition chooses."""
    from lanindex.library.schema import tables

    names = [column.name for column in tables.tables[table].columns]
    return table, names, ask(link, f"SELECT {', '.join(names)} FROM {table} {where}").fetchall()
