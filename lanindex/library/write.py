"""Captures and tracks to rows, inside a transaction that someone else began."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sqlalchemy import Connection, Table, delete, insert, select, update

from lanindex.library import rows, schema
from lanindex.model import Score


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
    table = schema.capture
    number = connection.scalar(select(table.c.id).where(table.c.location == values["location"]))
    if number is None:
        number = _inserted(connection, table, {"label": "", **values})
    else:
        _clear(connection, number)
        connection.execute(update(table).where(table.c.id == number).values(**values))
    _insert(connection, schema.track, rows.track_rows(number, score))
    _insert(connection, schema.symbol, rows.symbol_rows(number, score))
    return int(number)


def describe(
    connection: Connection, number: int, label: str | None, metadata: Mapping[str, str] | None
) -> None:
    """Write what the user says of a capture; None leaves what there is."""
    if label is not None:
        table = schema.capture
        connection.execute(update(table).where(table.c.id == number).values(label=label))
    if metadata is not None:
        described = schema.metadata
        connection.execute(delete(described).where(described.c.capture_id == number))
        _insert(connection, described, [(number, *pair) for pair in metadata.items()])


def remove_capture(connection: Connection, number: int) -> None:
    """Take out a capture and all that hangs on it."""
    _clear(connection, number)
    describe(connection, number, None, {})
    connection.execute(delete(schema.capture).where(schema.capture.c.id == number))


def put_profile(connection: Connection, name: str, digest: str) -> int:
    """Return the number of a profile, written if it is new."""
    table = schema.profile
    found = connection.scalar(
        select(table.c.id).where(table.c.name == name, table.c.digest == digest)
    )
    return found or _inserted(connection, table, {"name": name, "digest": digest})


def forget_profiles(connection: Connection) -> None:
    """Take out the profiles that no capture was written down with."""
    capture, profile = schema.capture.c, schema.profile
    used = select(capture.id).where(capture.profile_id == profile.c.id)
    connection.execute(delete(profile).where(~used.exists()))


def _clear(connection: Connection, number: int) -> None:
    for table in (schema.symbol, schema.track):
        connection.execute(delete(table).where(table.c.capture_id == number))


def _inserted(connection: Connection, table: Table, values: Mapping[str, Any]) -> int:
    key = connection.execute(insert(table).values(**values)).inserted_primary_key
    return int(key[0]) if key else 0


def _insert(connection: Connection, table: Table, values: list[tuple[Any, ...]]) -> None:
    # As tuples straight to the driver, where it takes tuples.
    if not values:
        return
    statement = insert(table)
    if connection.dialect.positional:
        text = str(statement.compile(dialect=connection.dialect))
        connection.exec_driver_sql(text, values)
    else:
        names = table.c.keys()
        connection.execute(statement, [dict(zip(names, row, strict=True)) for row in values])
