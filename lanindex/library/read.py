"""Rows to captures and tracks, each held against its checksum, inside another's transaction."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from fractions import Fraction
from itertools import groupby
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, Row, or_, select

from lanindex.errors import LibraryError
from lanindex.library import checksums, codes, rows, schema
from lanindex.library.encoding import Encoding, encoded
from lanindex.model import Capture, Score, Track

_MOST = 500
"""Values in one statement: databases take a thousand at least."""

CAPTURE = (
    select(
        *(one for one in schema.capture.c if one.name not in ("other", "heading")),
        schema.profile.c.name.label("profile"),
        schema.profile.c.digest.label("digest"),
    )
    .select_from(schema.capture.outerjoin(schema.profile))
    .order_by(schema.capture.c.id)
)
_LISTED = select(schema.track).order_by(schema.track.c.capture_id, schema.track.c.ordinal)
_CODES = (
    select(schema.symbol_code)
    .join_from(
        schema.track,
        schema.symbol_code,
        (schema.symbol_code.c.capture_id == schema.track.c.capture_id)
        & (schema.symbol_code.c.track == schema.track.c.ordinal),
    )
    .order_by(*schema.symbol_code.primary_key.columns)
)


class Stored(NamedTuple):
    """A capture, with what else its rows say."""

    capture: Capture
    encoding: Encoding
    tracks: int
    """Checksum of the list of its tracks."""
    content: int
    """Checksum of its heading and its other lines."""


def capture_numbers(connection: Connection) -> list[int]:
    """Return the numbers of all captures, in order.

    Raises
    ------
    LibraryError
        If there are more or fewer than were stored.
    """
    column = schema.capture.c.id
    found = list(connection.scalars(select(column).order_by(column)))
    check_numbers(connection, found)
    return found


def read_numbers(connection: Connection, numbers: Sequence[int]) -> list[int]:
    """Return those numbers that captures have."""
    column = schema.capture.c.id
    return list(connection.scalars(select(column).where(column.in_(numbers))))


def check_numbers(connection: Connection, found: Sequence[int]) -> None:
    """Refuse a library that has other captures than were stored.

    Raises
    ------
    LibraryError
        With how many there are and were.
    """
    stored, now = read_state(connection), (len(found), sum(found))
    if now != (stored.captures, stored.numbers):
        raise LibraryError(
            f"the library holds {now[0]} captures whose numbers add up to {now[1]}",
            wanted=f"{stored.captures} and {stored.numbers}, as were stored",
            remedy="Ingest the captures into a new library; or, if another program took some out "
            "on purpose, tell this one: UPDATE state SET "
            f"captures = {now[0]}, numbers = {now[1]}",
        )


def read_state(connection: Connection) -> Row[Any]:
    """Return the one row of ``state``.

    Raises
    ------
    LibraryError
        If it is not one of two whole numbers.
    """
    found = connection.execute(select(schema.state)).all()
    if len(found) != 1 or not all(isinstance(value, int) for value in found[0]):
        raise LibraryError(
            f"the library's state is {[tuple(row) for row in found]}",
            wanted="one row of whole numbers",
            remedy="Ingest the captures into a new library: all in it comes from them.",
        )
    return found[0]


def numbers_at(connection: Connection, path: str) -> list[int]:
    """Return the numbers of the captures of exactly this path."""
    column = schema.capture.c
    here = or_(column.location == os.path.abspath(path), column.path == path)
    return list(connection.scalars(select(column.id).where(here)))


def locations(connection: Connection, places: Sequence[str], digests: Sequence[str]) -> list[str]:
    """Return where the captures lie that are at one of these places or have such a sha256."""
    found: list[str] = []
    for column, values in ((schema.capture.c.location, places), (schema.capture.c.sha256, digests)):
        for first in range(0, len(values), _MOST):
            chosen = column.in_(values[first : first + _MOST])
            found += connection.scalars(select(schema.capture.c.location).where(chosen))
    return found


def read_stored(
    connection: Connection, numbers: Sequence[int] | None = None
) -> Iterator[Stored | LibraryError]:
    """Yield captures in the order of their numbers: all, or those that exist of some.

    Yields
    ------
    Stored or LibraryError
        The error, where a capture is not what was stored.
    """
    found, described = CAPTURE, select(schema.metadata)
    if numbers is not None:
        found = found.where(schema.capture.c.id.in_(numbers))
        described = described.where(schema.metadata.c.capture_id.in_(numbers))
    metadata: dict[int, dict[str, str]] = {}
    for number, key, value in connection.execute(described):
        metadata.setdefault(number, {})[key] = value
    for row in connection.execute(found).all():
        try:
            yield _stored(row, metadata.get(row.id, {}))
        except LibraryError as error:
            yield error


def _stored(row: Any, metadata: Mapping[str, str]) -> Stored:
    if encoded(row._asdict(), row.profile, row.digest) != row.checksum:
        raise checksums.damaged(row.id, row.location, "what is known of its file")
    if said(row.id, row.label, metadata) != row.said:
        raise checksums.damaged(row.id, row.location, "its label or metadata (say them again, too)")
    with _understood(row.id, row.location, "what is known of its file"):
        capture = Capture(
            id=row.id,
            path=row.path,
            format=row.format,
            sha256=row.sha256,
            label=row.label,
            rate=Fraction(row.rate),
            frames=row.frames,
            meter=rows.read_meter(row),
            metadata=metadata,
            location=row.location,
            warnings=tuple(json.loads(row.warnings)),
        )
        encoding = Encoding(row.profile or "", row.digest or "", json.loads(row.options))
    return Stored(capture, encoding, row.tracks, row.content)


def said(number: int, label: str, metadata: Mapping[str, str]) -> int | None:
    """Return the checksum of what the user says of a capture."""
    try:
        return checksums.of_values(number, label, sorted(metadata.items()))
    except TypeError:  # keys of several types have no order
        return None


@contextmanager
def _understood(number: int, path: str, what: str) -> Iterator[None]:
    # Behind its checksum only a program that stored nonsense can be the cause.
    try:
        yield
    except (ValueError, TypeError, ArithmeticError, RecursionError) as error:
        raise checksums.damaged(number, path, f"{what} ({error})") from error


def read_captures(connection: Connection, numbers: Sequence[int] | None = None) -> list[Stored]:
    """Return captures in the order of their numbers: all, or those that exist of some.

    Raises
    ------
    LibraryError
        If one is not what was stored.
    """
    found = list(read_stored(connection, numbers))
    for one in found:
        if isinstance(one, LibraryError):
            raise one
    if numbers is None:
        check_numbers(connection, [one.capture.id for one in found if isinstance(one, Stored)])
    return [one for one in found if isinstance(one, Stored)]


def read_capture(connection: Connection, number: int) -> Stored:
    """Return one capture that is there.

    Raises
    ------
    LibraryError
        If it is not what was stored.
    """
    found = read_captures(connection, [number])
    if len(found) != 1:  # one table says that it is there, its index that it is not
        raise checksums.damaged(number, None, "its row")
    return found[0]


class Listed(NamedTuple):
    """A row of ``track`` without its capture."""

    ordinal: int
    part: str
    kind: int
    known: str | None
    symbols: int
    checksum: int


def read_lists(connection: Connection, chosen: Sequence[Stored]) -> dict[int, list[Listed]]:
    """Return the tracks of captures without their symbols, by the captures' numbers.

    Raises
    ------
    LibraryError
        If one of the lists is not what was stored.
    """
    table = schema.track.c
    numbers = [one.capture.id for one in chosen]
    found = connection.execute(_LISTED.where(table.capture_id.in_(numbers))).cursor.fetchall()
    lists = {
        number: [Listed(*row[1:]) for row in listed]
        for number, listed in groupby(found, itemgetter(0))
    }
    for capture, _, checksum, _ in chosen:
        if checksums.of_values(lists.get(capture.id, [])) != checksum:
            raise checksums.damaged(capture.id, capture.location, "the list of its tracks")
    return lists


def read_tracks(
    connection: Connection, chosen: Sequence[Stored], parts: Sequence[str] | None = None
) -> dict[int, dict[str, Track]]:
    """Return the tracks of captures, by the captures' numbers: all, or those of some parts.

    Raises
    ------
    LibraryError
        If one of them is not what was stored.
    """
    lists = read_lists(connection, chosen)
    wanted = [
        (one, listed)
        for one in chosen
        for listed in lists.get(one.capture.id, ())
        if parts is None or listed.part in parts
    ]
    statement = _CODES.where(schema.track.c.capture_id.in_([one.capture.id for one in chosen]))
    if parts is not None:
        statement = statement.where(schema.track.c.part.in_(parts))
    numbers = _numbers(connection.execute(statement).cursor.fetchall(), chosen)
    _check_tracks(numbers, wanted)
    symbols, first = codes.unpack(numbers[:, 3:]), 0
    tracks: dict[int, dict[str, Track]] = {one.capture.id: {} for one in chosen}
    for (capture, *_), listed in wanted:
        stretch = symbols[first : first + listed.symbols]
        first += listed.symbols
        with _understood(capture.id, capture.location, f"its track {listed.part}"):
            known = rows.read_known(listed.known, capture.frames)
            kind = codes.KIND_NAMES[listed.kind]
            tracks[capture.id][listed.part] = Track(listed.part, stretch, known, kind)
    return tracks


def _numbers(found: Sequence[tuple[Any, ...]], chosen: Sequence[Stored]) -> NDArray[np.int64]:
    """Return rows of ``symbol_code`` as numbers: (S, C + 3) int64, capture, track, row, fields."""
    if not found:
        return np.empty((0, len(codes.COLUMNS) + 3), np.int64)
    numbers = np.array(found)
    if numbers.dtype == np.int64:
        return numbers
    number, track = next(row[:2] for row in found if not all(isinstance(one, int) for one in row))
    location = next(one.capture.location for one in chosen if one.capture.id == number)
    raise checksums.damaged(number, location, f"its track number {track} holds what is no number")


def _check_tracks(numbers: NDArray[np.int64], wanted: Sequence[tuple[Stored, Listed]]) -> None:
    """Refuse rows that are not those of the tracks, one after the other."""
    fields, first = np.ascontiguousarray(numbers[:, 1:]), 0
    for one, listed in wanted:
        last = first + listed.symbols
        if (numbers[first:last, 0] != one.capture.id).any() or (
            rows.of_symbols(fields[first:last]) != listed.checksum
        ):
            break
        first = last
    else:
        if first == len(numbers):
            return
    for one, listed in wanted:  # which of them it is, when rows are missing or too many
        own = (numbers[:, 0] == one.capture.id) & (numbers[:, 1] == listed.ordinal)
        if own.sum() != listed.symbols or rows.of_symbols(fields[own]) != listed.checksum:
            what = f"its track {listed.part}"
            raise checksums.damaged(one.capture.id, one.capture.location, what)


def read_score(connection: Connection, stored: Stored) -> Score:
    """Return the score of a capture.

    Raises
    ------
    LibraryError
        If it is not what was stored.
    """
    capture, table = stored.capture, schema.capture.c
    row = connection.execute(select(table.other, table.heading).where(table.id == capture.id)).one()
    what = "its heading or the lines that were not understood"
    if content(row.other, row.heading) != stored.content:
        raise checksums.damaged(capture.id, capture.location, what)
    tracks = read_tracks(connection, [stored])[capture.id]
    with _understood(capture.id, capture.location, what):
        return Score(
            rate=capture.rate,
            frames=capture.frames,
            meter=capture.meter,
            tracks=tracks,
            heading=rows.read_heading(row.heading),
            other=tuple(json.loads(row.other)),
        )


def content(other: Any, heading: Any) -> int | None:
    """Return the checksum of a capture's heading and of its other lines."""
    if not isinstance(heading, bytes) or not isinstance(other, str):
        return None
    return checksums.of_bytes(heading, other.encode("utf-8", "surrogatepass"))
