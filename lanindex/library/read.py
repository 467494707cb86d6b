"""Rows to captures and tracks, inside a transaction that someone else began."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from sqlalchemy import ColumnElement, Connection, Row, Table, or_, select

from lanindex.library import rows, schema
from lanindex.model import Capture, Score, Track

_MOST = 500
"""Values in one statement: databases take a thousand at least."""

_SHOWN = [column for column in schema.capture.c if column.name not in ("other", "heading")]


def capture_numbers(connection: Connection) -> list[int]:
    """Return the numbers of all captures, in order."""
    column = schema.capture.c.id
    return list(connection.scalars(select(column).order_by(column)))


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


def read_captures(connection: Connection, numbers: Sequence[int] | None = None) -> list[Capture]:
    """Return captures in the order of their numbers: all, or those that exist of some."""
    found = select(*_SHOWN).order_by(schema.capture.c.id)
    described = select(schema.metadata)
    if numbers is not None:
        found = found.where(schema.capture.c.id.in_(numbers))
        described = described.where(schema.metadata.c.capture_id.in_(numbers))
    metadata: dict[int, dict[str, str]] = {}
    for number, key, value in connection.execute(described):
        metadata.setdefault(number, {})[key] = value
    return [_capture(row, metadata.get(row.id, {})) for row in connection.execute(found)]


def _capture(row: Row[Any], metadata: Mapping[str, str]) -> Capture:
    return Capture(
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
    )


def read_tracks(
    connection: Connection, numbers: Sequence[int], parts: Sequence[str] | None = None
) -> dict[int, dict[str, Track]]:
    """Return the tracks of captures: all, or those of some parts."""

    def chosen(table: Table) -> ColumnElement[bool]:
        inside = table.c.capture_id.in_(numbers)
        return inside if parts is None else inside & table.c.part.in_(parts)

    track, symbol = schema.track, schema.symbol
    listed = connection.execute(
        select(track.c.capture_id, track.c.part, track.c.known)
        .where(chosen(track))
        .order_by(track.c.capture_id, track.c.ordinal)
    )
    found = connection.execute(
        select(*(symbol.c[name] for name in rows.COLUMNS))
        .where(chosen(symbol))
        .order_by(symbol.c.capture_id, symbol.c.part, symbol.c.ordinal)
    )
    # Straight from the driver: SQLAlchemy's rows would cost as much again.
    return rows.read_tracks(listed, rows.read_symbols(found.cursor.fetchall()))


def read_score(connection: Connection, capture: Capture) -> Score:
    """Return the score of a capture."""
    table = schema.capture.c
    row = connection.execute(select(table.other, table.heading).where(table.id == capture.id)).one()
    return Score(
        rate=capture.rate,
        frames=capture.frames,
        meter=capture.meter,
        tracks=read_tracks(connection, [capture.id]).get(capture.id, {}),
        heading=rows.read_heading(row.heading),
        other=tuple(json.loads(row.other)),
    )
