"""What a library holds, counted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from sqlalchemy import ColumnElement, Connection, FromClause, func, select

from lanindex.library.schema import capture, profile, symbol


@dataclass(frozen=True, slots=True)
class Stats:
    """Counts of a library.

    Attributes
    ----------
    captures, frames, symbols : int
        In all; of symbols all rows, starting positions and passing ones included.
    seconds : float
        Length of all captures.
    size : int
        Bytes of the database; 0 where it is no file.
    parts : Mapping of str to int
        Symbols by part.
    labels, profiles, formats : Mapping of str to int
        Captures by label, by profile (the empty name: scores that came as such), by format.
    """

    captures: int
    frames: int
    symbols: int
    seconds: float
    size: int
    parts: Mapping[str, int]
    labels: Mapping[str, int]
    profiles: Mapping[str, int]
    formats: Mapping[str, int]


def count(connection: Connection, size: int) -> Stats:
    """Count what a library holds.

    Parameters
    ----------
    connection : Connection
        In a transaction.
    size : int
        Bytes of the database.
    """
    captures, frames, seconds = connection.execute(
        select(
            func.count(),
            func.coalesce(func.sum(capture.c.frames), 0),
            func.coalesce(func.sum(capture.c.frames / capture.c.fps), 0.0),
        ).select_from(capture)
    ).one()
    parts = _by(connection, symbol.c.part)
    return Stats(
        captures=captures,
        frames=int(frames),
        symbols=sum(parts.values()),
        seconds=float(seconds),
        size=size,
        parts=parts,
        labels=_by(connection, capture.c.label),
        profiles=_by(connection, func.coalesce(profile.c.name, ""), capture.outerjoin(profile)),
        formats=_by(connection, capture.c.format),
    )


def _by(
    connection: Connection, column: ColumnElement[str], table: FromClause | None = None
) -> dict[str, int]:
    counted = select(column, func.count()).group_by(column).order_by(column)
    found = connection.execute(counted if table is None else counted.select_from(table))
    return {name: number for name, number in found}
