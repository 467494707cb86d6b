"""Captures and tracks to rows, inside a transaction that someone else began."""

from __future__ import annotations

import json
from collections.abc import Mapping
from itertools import chain, repeat
from typing import Any

from sqlalchemy import Connection, Table, insert

from lanindex.errors import LibraryError
from lanindex.library import read, rows, schema, segments, state
from lanindex.library.encoding import Encoding, encoded
from lanindex.library.link import ask, driver_of
from lanindex.model import Score

_MOST = 999
"""Values in one statement: any SQLite takes so many."""

_FIND = "SELECT id FROM capture WHERE location = :location"
_REMOVE = "DELETE FROM capture WHERE id = :number"
_CLEAR = (
    "DELETE FROM symbol_code WHERE capture_id = :number",
    "DELETE FROM track WHERE capture_id = :number",
)
_FORGET = "DELETE FROM metadata WHERE capture_id = :number"
_SAID = "SELECT label, said FROM capture WHERE id = :number"
_METADATA = "SELECT key, value FROM metadata WHERE capture_id = :number"
_COUNT = "UPDATE state SET captures = captures + :more, numbers = numbers + :more * :one"
_TOUCH = (  # and the columns go along, if they were true before
    "UPDATE state SET stamp = stamp + 1, "
    "columns = CASE WHEN columns = stamp THEN stamp + 1 ELSE columns END "
    f"WHERE stamp BETWEEN 0 AND {1 << 31} RETURNING id"  # no text, no bytes, not nothing
)
_FIND_PROFILE = "SELECT id FROM profile WHERE name = :name AND digest = :digest"
_FORGET_PROFILES = (
    "DELETE FROM profile WHERE NOT EXISTS "
    "(SELECT 1 FROM capture WHERE capture.profile_id = profile.id)"
)


def put_capture(
    connection: Connection, values: Mapping[str, Any], score: Score, encoding: Encoding
) -> tuple[int, bool]:
    """Write a capture and its score, in place of those of the same location."""
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
    held = ask(connection, _FIND, {"location": values["location"]}).fetchone()
    if held is None:
        number = _inserted(connection, "capture", {"label": "", "said": -1, **values})
        ask(connection, _COUNT, {"more": 1, "one": number})
    else:
        number = int(held[0])
        _clear(connection, number)
        _change(connection, number, values)
        ask(connection, _FORGET_PROFILES)
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
        before, checksum = ask(connection, _SAID, {"number": number}).fetchone()
        held = dict(ask(connection, _METADATA, {"number": number}).fetchall())
        if read.said(number, before, held) != checksum:  # nobody knows any more what was said
            label, metadata = label or "", metadata or {}
        if label is None and metadata is None:
            return
        label = before if label is None else label
        if metadata is not None:
            ask(connection, _FORGET, {"number": number})
    if metadata is not None:
        held = {str(key): str(value) for key, value in metadata.items()}
        _insert(connection, schema.metadata, [(number, *pair) for pair in held.items()])
    label = str(label or "")
    said = read.said(number, label, held)
    _change(connection, number, {"label": label, "said": said})
    if not new:
        segments.mark_changed(connection, number)


def move_capture(connection: Connection, number: int, path: str, location: str) -> None:
    """Write where a capture's file is now."""
    facts, profile = read.encoded_of(connection, number)
    checksum = encoded({**facts, "path": path, "location": location}, *profile)
    _change(connection, number, {"path": path, "location": location, "checksum": checksum})
    segments.mark_changed(connection, number)


def remove_capture(connection: Connection, number: int) -> None:
    """Take out a capture, all that hangs on it, and its profile if it was the last of it."""
    _clear(connection, number)
    ask(connection, _FORGET, {"number": number})
    ask(connection, _REMOVE, {"number": number})
    ask(connection, _COUNT, {"more": -1, "one": number})
    segments.mark_dead(connection, number)
    ask(connection, _FORGET_PROFILES)


def touch(connection: Connection) -> None:
    """Raise the change stamp; the segments stay true if they were."""
    if len(ask(connection, _TOUCH).fetchall()) != 1:
        state.read_state(connection)  # says what there is
        raise LibraryError("the library's stamp cannot be raised", wanted="a number from 0")


def put_profile(connection: Connection, name: str, digest: str) -> int:
    """Return the number of a profile, written if it is new."""
    named = {"name": name, "digest": digest}
    held = ask(connection, _FIND_PROFILE, named).fetchone()
    return int(held[0]) if held else _inserted(connection, "profile", named)


def _clear(connection: Connection, number: int) -> None:
    for statement in _CLEAR:
        ask(connection, statement, {"number": number})


def _change(connection: Connection, number: int, values: Mapping[str, Any]) -> None:
    changes = ", ".join([f"{name} = :{name}" for name in values])
    ask(
        connection,
        f"UPDATE capture SET {changes} WHERE id = :number",
        {"number": number, **values},
    )


def _inserted(connection: Connection, table: str, values: Mapping[str, Any]) -> int:
    columns = f"({', '.join(values)}) VALUES ({', '.join([f':{name}' for name in values])})"
    ((number,),) = ask(connection, f"INSERT INTO {table} {columns} RETURNING id", values).fetchall()
    return int(number)


def _insert(connection: Connection, table: Table, values: list[tuple[Any, ...]]) -> None:
    # Many rows to a statement: what the driver does for each one takes longer than to store it.
    names, driver = table.c.keys(), driver_of(connection)
    if driver is None and values:
        connection.execute(insert(table), [dict(zip(names, row, strict=True)) for row in values])
    elif driver is not None:
        row, many = f"({', '.join('?' * len(names))})", _MOST // len(names)
        begin = f"INSERT INTO {table.name} ({', '.join(names)}) VALUES "
        rest = len(values) % many
        driver.executemany(begin + row, values[:rest])
        for first in range(rest, len(values), many):
            some = list(chain.from_iterable(values[first : first + many]))
            driver.execute(begin + ", ".join([row] * many), some)
