"""Captures and tracks to rows, inside a transaction that someone else began."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import lru_cache
from itertools import repeat
from typing import Any

from sqlalchemy import (
    BindParameter,
    Connection,
    Delete,
    Dialect,
    Table,
    bindparam,
    case,
    delete,
    insert,
    select,
    update,
)

from lanindex.errors import LibraryError
from lanindex.library import read, rows, schema, segments, state
from lanindex.library.encoding import Encoding, encoded
from lanindex.model import Score

_NUMBER: BindParameter[int] = bindparam("number")


_STATE = schema.state.c


def _of(table: Table) -> Delete:
    return delete(table).where(table.c.capture_id == _NUMBER)


# Built once: SQLAlchemy takes longer to build a statement than SQLite to run it.
_FIND = select(schema.capture.c.id).where(schema.capture.c.location == bindparam("location"))
_CHANGE = update(schema.capture).where(schema.capture.c.id == _NUMBER)
_REMOVE = delete(schema.capture).where(schema.capture.c.id == _NUMBER)
_CLEAR = (_of(schema.symbol_code), _of(schema.track))
_FORGET = _of(schema.metadata)
_SAID = select(schema.capture.c.label, schema.capture.c.said).where(schema.capture.c.id == _NUMBER)
_METADATA = select(schema.metadata.c.key, schema.metadata.c.value).where(
    schema.metadata.c.capture_id == _NUMBER
)
_COUNT = update(schema.state).values(
    captures=_STATE.captures + bindparam("more"),
    numbers=_STATE.numbers + bindparam("more") * bindparam("one"),
)
_TOUCH = (
    update(schema.state)
    .where(_STATE.stamp.between(0, 1 << 31))  # no text, no bytes, not nothing
    .values(
        stamp=_STATE.stamp + 1,  # and the columns go along, if they were true before
        columns=case((_STATE.columns == _STATE.stamp, _STATE.stamp + 1), else_=_STATE.columns),
    )
)
_FIND_PROFILE = select(schema.profile.c.id).where(
    schema.profile.c.name == bindparam("name"), schema.profile.c.digest == bindparam("digest")
)
_FORGET_PROFILES = delete(schema.profile).where(
    ~select(schema.capture.c.id).where(schema.capture.c.profile_id == schema.profile.c.id).exists()
)


def put_capture(
    connection: Connection, values: Mapping[str, Any], score: Score, encoding: Encoding
) -> tuple[int, bool]:
    """Write a capture and its score, in place of those of the same location.

    Parameters
    ----------
    connection : Connection
        In a transaction.
    values : Mapping
        Columns of ``capture``, as far as neither encoding nor checksums.
    score : Score
        Checked.
    encoding : Encoding
        How it was written down.

    Returns
    -------
    int, bool
        The number of the capture, the old one where there was one; whether it is new.
    """
    made = rows.rows_of(score)
    named = (encoding.profile, encoding.digest) if encoding.digest else None
    name, digest = named or (None, None)
    values = {
        **values,
        "profile_id": put_profile(connection, *named) if named else None,
        "options": json.dumps(encoding.facts(), sort_keys=True),
        "tracks": made.checksum,
        "content": read.content(values["other"], values["heading"]),
    }
    values["checksum"] = encoded(values, name, digest)
    held = connection.scalar(_FIND, {"location": values["location"]})
    if held is None:
        number = _inserted(connection, schema.capture, {"label": "", "said": -1, **values})
        connection.execute(_COUNT, {"more": 1, "one": number})
    else:
        number = int(held)
        _clear(connection, number)
        connection.execute(_CHANGE, {"number": number, **values})
        connection.execute(_FORGET_PROFILES)
        segments.mark_dead(connection, number)
    segments.mark_pending(connection, number)
    _insert(connection, schema.track, [(number, *row) for row in made.tracks])
    _insert(connection, schema.symbol_code, list(zip(repeat(number), *made.symbols)))
    return number, held is None


def describe(
    connection: Connection,
    number: int,
    label: str | None,
    metadata: Mapping[str, str] | None,
    new: bool = False,
) -> None:
    """Write what the user says of a capture; None leaves what there is, if that is whole."""
    held: dict[str, str] = {}
    if not new:
        row = connection.execute(_SAID, {"number": number}).one()
        held = {key: value for key, value in connection.execute(_METADATA, {"number": number})}
        if read.said(number, row.label, held) != row.said:  # nobody knows any more what was said
            label, metadata = label or "", metadata or {}
        if label is None and metadata is None:
            return
        label = row.label if label is None else label
        if metadata is not None:
            connection.execute(_FORGET, {"number": number})
    if metadata is not None:
        held = {str(key): str(value) for key, value in metadata.items()}
        _insert(connection, schema.metadata, [(number, *pair) for pair in held.items()])
    label = str(label or "")
    said = read.said(number, label, held)
    connection.execute(_CHANGE, {"number": number, "label": label, "said": said})
    if not new:
        segments.mark_changed(connection, number)


def move_capture(connection: Connection, number: int, path: str, location: str) -> None:
    """Write where a capture's file is now."""
    facts, profile = read.encoded_of(connection, number)
    checksum = encoded({**facts, "path": path, "location": location}, *profile)
    changed = {"path": path, "location": location, "checksum": checksum}
    connection.execute(_CHANGE, {"number": number, **changed})
    segments.mark_changed(connection, number)


def remove_capture(connection: Connection, number: int) -> None:
    """Take out a capture, all that hangs on it, and its profile if it was the last of it."""
    _clear(connection, number)
    connection.execute(_FORGET, {"number": number})
    connection.execute(_REMOVE, {"number": number})
    connection.execute(_COUNT, {"more": -1, "one": number})
    segments.mark_dead(connection, number)
    connection.execute(_FORGET_PROFILES)


def touch(connection: Connection) -> None:
    """Raise the change stamp; the segments stay true if they were.

    Raises
    ------
    LibraryError
        If there is none that can be raised.
    """
    if connection.execute(_TOUCH).rowcount != 1:
        state.read_state(connection)  # says what there is
        raise LibraryError("the library's stamp cannot be raised", wanted="a number from 0")


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
