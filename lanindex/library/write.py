"""Write captures and tracks as rows. The caller has begun the transaction."""

from __future__ import annotations

import json
from collections.abc import Mapping
from itertools import repeat
from typing import Any

from lanindex.errors import LibraryError
from lanindex.library import rows, segments
from lanindex.library.connect import Link, ask, insert
from lanindex.library.read import content_checksum, description_checksum, encoded_of, read_state
from lanindex.library.rows import COLUMNS, TRACK, Encoding, encoded_checksum
from lanindex.model import Score

_COUNT = "UPDATE state SET captures = captures + :more, numbers = numbers + :more * :one"
_TOUCH = (  # The stamp of the columns follows if they were up to date
    "UPDATE state SET stamp = stamp + 1, "
    "columns = CASE WHEN columns = stamp THEN stamp + 1 ELSE columns END "
    f"WHERE stamp BETWEEN 0 AND {1 << 31} RETURNING id"  # Neither text nor bytes nor NULL
)
_FORGET_PROFILES = (
    "DELETE FROM profile WHERE NOT EXISTS "
    "(SELECT 1 FROM capture WHERE capture.profile_id = profile.id)"
)


def put_capture(
    connection: Link, values: Mapping[str, Any], score: Score, encoding: Encoding
) -> tuple[int, bool]:
    """Write a capture and its score, in place of those of the same location.

    Return its number, and whether it is new.
    """
    made = rows.rows_of(score)
    profile = {"name": encoding.profile, "digest": encoding.digest} if encoding.digest else {}
    meter, other = score.meter, json.dumps(score.other)
    heading = rows.pack_heading(score.heading)
    values = {
        **values,
        "fps": float(score.rate),
        "rate": str(score.rate),
        "frames": int(score.frames),
        "speed": str(meter.speed),
        "beats": int(meter.beats),
        "beat": int(meter.beat),
        "division": int(meter.division),
        "other": other,
        "heading": heading,
        "profile_id": _profile(connection, profile) if profile else None,
        "options": json.dumps(encoding.facts(), sort_keys=True),
        "tracks": made.checksum,
        "content": content_checksum(other, heading),
    }
    values["checksum"] = encoded_checksum(values, profile.get("name"), profile.get("digest"))
    asked = "SELECT id FROM capture WHERE location = :location"
    held = ask(connection, asked, {"location": values["location"]}).fetchone()
    if held is None:
        number = _insert(connection, "capture", {"label": "", "said": -1, **values})
        ask(connection, _COUNT, {"more": 1, "one": number})
    else:
        number = int(held[0])
        _delete_rows(connection, number, "symbol_code", "track")
        _update_capture(connection, number, values)
        ask(connection, _FORGET_PROFILES)
    segments.mark_changed(connection, number, dead=held is not None)
    tracks = [(number, *row) for row in made.tracks]
    insert(connection, "track", ("capture_id", *TRACK), tracks)
    names = ("capture_id", "track", "ordinal", *COLUMNS)
    insert(connection, "symbol_code", names, list(zip(repeat(number), *made.symbols)))
    return number, held is None


def describe(
    connection: Link,
    number: int,
    label: str | None,
    metadata: Mapping[str, str] | None,
    new: bool = False,
) -> None:
    """Write label and metadata of a capture; None leaves what is stored, unless that is damaged."""
    held: dict[str, str] = {}
    if not new:
        key = {"number": number}
        asked = "SELECT label, said FROM capture WHERE id = :number"
        before, checksum = ask(connection, asked, key).fetchone()
        asked = "SELECT key, value FROM metadata WHERE capture_id = :number"
        held = dict(ask(connection, asked, key).fetchall())
        if description_checksum(number, before, held) != checksum:
            label, metadata = label or "", metadata or {}  # What was stored is damaged
        if label is None and metadata is None:
            return
        label = before if label is None else label
        if metadata is not None:
            _delete_rows(connection, number, "metadata")
    if metadata is not None:
        held = {str(key): str(value) for key, value in metadata.items()}
        described = [(number, *pair) for pair in held.items()]
        insert(connection, "metadata", ("capture_id", "key", "value"), described)
    label = str(label or "")
    checksum = description_checksum(number, label, held)
    _update_capture(connection, number, {"label": label, "said": checksum})
    if not new:
        segments.mark_changed(connection, number)


def move_capture(connection: Link, number: int, path: str, location: str) -> None:
    """Write where a capture's file is now."""
    facts, profile = encoded_of(connection, number)
    checksum = encoded_checksum({**facts, "path": path, "location": location}, *profile)
    _update_capture(connection, number, {"path": path, "location": location, "checksum": checksum})
    segments.mark_changed(connection, number)


def remove_capture(connection: Link, number: int) -> None:
    """Delete a capture, all its rows, and its profile if no other capture has it."""
    _delete_rows(connection, number, "symbol_code", "track", "metadata")
    ask(connection, "DELETE FROM capture WHERE id = :number", {"number": number})
    ask(connection, _COUNT, {"more": -1, "one": number})
    segments.mark_changed(connection, number, pending=False)
    ask(connection, _FORGET_PROFILES)


def touch(connection: Link) -> None:
    """Raise the change stamp; segments that were up to date stay so."""
    if len(ask(connection, _TOUCH).fetchall()) != 1:
        read_state(connection)  # Raises with the content of the state
        raise LibraryError("the library's stamp cannot be raised", wanted="a number from 0")


def _profile(connection: Link, values: Mapping[str, str]) -> int:
    """Return the number of a profile, written if it is new."""
    asked = "SELECT id FROM profile WHERE name = :name AND digest = :digest"
    held = ask(connection, asked, values).fetchone()
    return int(held[0]) if held else _insert(connection, "profile", values)


def _delete_rows(connection: Link, number: int, *tables: str) -> None:
    for table in tables:
        ask(connection, f"DELETE FROM {table} WHERE capture_id = :number", {"number": number})


def _update_capture(connection: Link, number: int, values: Mapping[str, Any]) -> None:
    changes = ", ".join([f"{name} = :{name}" for name in values])
    change = f"UPDATE capture SET {changes} WHERE id = :number"
    ask(connection, change, {"number": number, **values})


def _insert(connection: Link, table: str, values: Mapping[str, Any]) -> int:
    columns = f"({', '.join(values)}) VALUES ({', '.join([f':{name}' for name in values])})"
    ((number,),) = ask(connection, f"INSERT INTO {table} {columns} RETURNING id", values).fetchall()
    return int(number)
