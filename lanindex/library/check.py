"""What can be wrong inside a library: asked of the database, answered in sentences."""

from __future__ import annotations

import json
from collections.abc import Iterator
from fractions import Fraction

from sqlalchemy import ColumnElement, Connection, Select, func, or_, select
from sqlalchemy.exc import DatabaseError

from lanindex.alphabet import DIRECTIONS, LEVELS
from lanindex.library.schema import capture, profile, symbol, track

_MOST = 5
"""Rows named for each thing that is wrong."""


def check_connection(connection: Connection) -> list[str]:
    """Return what is wrong, a sentence each.

    Parameters
    ----------
    connection : Connection
        In a transaction.
    """
    if connection.dialect.name == "sqlite":
        try:
            damage = list(_damage(connection))
        except DatabaseError as error:
            damage = [f"the file is damaged: {error.orig}"]
        if damage:  # what the other questions would find in a damaged file means nothing
            return damage
    found = []
    for sentence, statement in _QUESTIONS.items():
        found += _told(sentence, [tuple(row) for row in connection.execute(statement)])
    return found + list(_unreadable(connection))


def _told(sentence: str, rows: list[tuple[object, ...]]) -> list[str]:
    told = [sentence.format(*row) for row in rows[:_MOST]]
    return told + ([f"… and {len(rows) - _MOST} more like it"] if len(rows) > _MOST else [])


def _damage(connection: Connection) -> Iterator[str]:
    for (line,) in connection.exec_driver_sql(f"PRAGMA integrity_check({_MOST})"):
        if line != "ok":
            yield f"the file is damaged: {line}"
    orphans = connection.exec_driver_sql("PRAGMA foreign_key_check").all()
    yield from _told(
        "a row of {0} hangs on a row of {2} that does not exist", list(map(tuple, orphans))
    )


def _symbols(
    wrong: ColumnElement[bool], *columns: ColumnElement[object]
) -> Select[tuple[object, ...]]:
    return (
        select(capture.c.path, symbol.c.part, symbol.c.ordinal, *columns)
        .join_from(symbol, capture, capture.c.id == symbol.c.capture_id)
        .where(wrong)
        .limit(1000)
    )


_span = (symbol.c.start_frame, symbol.c.end_frame, capture.c.frames)
_last = func.max(symbol.c.ordinal)

_QUESTIONS: dict[str, Select[tuple[object, ...]]] = {
    "{0}: {1}, symbol {2} lies at [{3}, {4}), outside the {5} frames": _symbols(
        or_(
            symbol.c.start_frame < 0,
            symbol.c.end_frame < symbol.c.start_frame,
            symbol.c.end_frame > capture.c.frames,
        ),
        *_span,
    ),
    "{0}: {1}, symbol {2} has the unknown direction {3}": _symbols(
        or_(symbol.c.direction.not_in(DIRECTIONS), symbol.c.runner_direction.not_in(DIRECTIONS)),
        symbol.c.direction,
    ),
    "{0}: {1}, symbol {2} has the unknown level {3}": _symbols(
        or_(symbol.c.level.not_in(LEVELS), symbol.c.runner_level.not_in(LEVELS)), symbol.c.level
    ),
    "{0}: {1} has {2} symbols, numbered up to {3}": (
        select(capture.c.path, symbol.c.part, func.count(), _last)
        .join_from(symbol, capture, capture.c.id == symbol.c.capture_id)
        .group_by(symbol.c.capture_id, capture.c.path, symbol.c.part)
        .having(_last + 1 != func.count())
    ),
    "the profile {0} wrote nothing down": (
        select(profile.c.name)
        .outerjoin_from(profile, capture, capture.c.profile_id == profile.c.id)
        .where(capture.c.id.is_(None))
    ),
}
"""A sentence, and the rows of which it is true."""


def _unreadable(connection: Connection) -> Iterator[str]:
    columns = (capture.c.rate, capture.c.speed, capture.c.options, capture.c.other)
    for row in connection.execute(select(capture.c.path, *columns)):
        for column in columns:
            if not _reads(column.name, row._mapping[column]):
                yield f"{row.path}: {column.name} cannot be read: {row._mapping[column]}"
    known = select(capture.c.path, track.c.part, track.c.known).join_from(track, capture)
    for path, part, text in connection.execute(known):
        if not _reads("known", text):
            yield f"{path}: {part}: the stretches in which it was seen cannot be read: {text}"


def _reads(name: str, text: str) -> bool:
    try:
        if name in ("rate", "speed"):
            return Fraction(text) > 0
        json.loads(text)
    except (ValueError, ZeroDivisionError):
        return False
    return True
