"""Captures and tracks to rows, inside a transaction that someone else began."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from sqlalchemy import (
    BindParameter,
    Connection,
    Delete,
    Dialect,
    Table,
    bindparam,
    delete,
    insert,
    select,
    update,
)

from lanindex.library import rows, schema
from lanindex.model import Score

_NUMBER: BindParameter[int] = bindparam("number")


def _of(table: Table) -> Delete:
    return delete(table).where(table.c.capture_id == _NUMBER)


# Built once: SQLAlchemy takes longer to build a statement than SQLite to run it.
_FIND = select(schema.capture.c.id).where(schema.capture.c.location == bindparam("location"))
_CHANGE = update(schema.capture).where(schema.capture.c.id == _NUMBER)
_REMOVE = delete(schema.capture).where(schema.capture.c.id == _NUMBER)
_CLEAR = (_of(schema.symbol), _of(schema.track))
_FORGET = _of(schema.metadata)
_FIND_PROFILE = select(schema.profile.c.id).where(
    schema.profile.c.name == bindparam("name"), schema.profile.c.digest == bindparam("digest")
)
_FORGET_PROFILES = delete(schema.profile).where(
    ~select(schema.capture.c.id).where(schema.capture.c.profile_id == schema.profile.c.id).exists()
)


def put_capture(connection: Connection, values: Mapping[str, Any], score: Score) -> int:
    """Write a capture and its score, in place of those of the same location.

    Parameters
    ----------
    connection : Connection
        In a transaction.
    values : Mapping
        Columns of ``capture``.
    score : Score
        Checked.

    Returns
    -------
    int
        The number of the capture: the old one where there was one.
    """
    number = connection.scalar(_FIND, {"location": values["location"]})
    if number is None:
        number = _inserted(connection, schema.capture, {"label": "", **values})
    else:
        _clear(connection, number)
        connection.execute(_CHANGE, {"number": number, **values})
        connection.execute(_FORGET_PROFILES)
    _insert(connection, schema.track, rows.track_rows(number, score))
    _insert(connection, schema.symbol, rows.symbol_rows(number, score))
    return int(number)


def describe(
    connection: Connection, number: int, label: str | None, metadata: Mapping[str, str] | None
) -> None:
    """Write what the user says of a capture; None leaves what there is."""
    if label is not None:
        connection.execute(_CHANGE, {"number": number, "label": label})
    if metadata is not None:
        connection.execute(_FORGET, {"number": number})
        _insert(connection, schema.metadata, [(number, *pair) for pair in metadata.items()])


def remove_capture(connection: Connection, number: int) -> None:
    """Take out a capture, all that hangs on it, and its profile if it was the last of it."""
    _clear(connection, number)
    describe(connection, number, None, {})
    connection.execute(_REMOVE, {"number": number})
    connection.execute(_FORGET_PROFILES)


def put_profile(connection: Connection, name: str, digest: str) -> int:
    """Return the number of a profile, written if it is new."""
    named = {"name": name, "digest": digest}
    return connection.scalar(_FIND_PROFILE, named) or _inserted(connection, schema.profile, named)


def _clear(connection: Connection, number: int) -> None:
    for statement in _CLEAR:
        connection.execute(statement, {"number": number})


def _inserted(connection: Connection, table: Table, values: Mapping[str, Any]) -> int:
    key = connection.execute(insert(table), values).inserted_primary_key
    return int(key[0]) if key else 0


def _insert(connection: Connection, table: Table, values: list[tuple[Any, ...]]) -> None:
    # As tuples straight to the driver, where it takes tuples.
    if not values:
        return
    dialect = connection.dialect
    if dialect.positional:
        connection.exec_driver_sql(_insert_text(table, dialect), values)
    else:
        names = table.c.keys()
        connection.execute(insert(table), [dict(zip(names, row, strict=True)) for row in values])


@lru_cache(maxsize=16)
def _insert_text(table: Table, dialect: Dialect) -> str:
    return str(insert(table).compile(dialect=dialect))
