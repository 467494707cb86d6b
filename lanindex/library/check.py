"""What can be wrong inside a library: asked of the database, answered in sentences."""

from __future__ import annotations

import json
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

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
        damage = _damage(connection)
        if damage:  # what a damaged file answers to the other questions means nothing
            return damage
    found = _unreadable(connection)
    for sentence, question in _QUESTIONS.items():
        found += _told(sentence, connection.execute(question).all())
    return found


def _told(sentence: str, rows: Sequence[Any]) -> list[str]:
    told = [sentence.format(*row) for row in rows[:_MOST]]
    return told + ([f"… and {len(rows) - _MOST} more like it"] if len(rows) > _MOST else [])


def _damage(connection: Connection) -> list[str]:
    try:
        pages = connection.exec_driver_sql(f"PRAGMA integrity_check({_MOST})").all()
        bonds = connection.exec_driver_sql("PRAGMA foreign_key_check").all()
    except DatabaseError as error:
        return [f"the file is damaged: {error.orig}"]
    found = [f"the file is damaged: {line}" for (line,) in pages if line != "ok"]
    return found + _told("a row of {0} hangs on a row of {2} that does not exist", bonds)


def _symbols(wrong: ColumnElement[bool], *columns: ColumnElement[Any]) -> Select[Any]:
    return (
        select(capture.c.path, symbol.c.part, symbol.c.ordinal, *columns)
        .join_from(symbol, capture, capture.c.id == symbol.c.capture_id)
        .where(wrong)
        .order_by(symbol.c.capture_id, symbol.c.part, symbol.c.ordinal)
    )


_LAST = func.max(symbol.c.ordinal)

_QUESTIONS: dict[str, Select[Any]] = {
    "{0}: {1}, symbol {2} lies at [{3}, {4}), outside the {5} frames": _symbols(
        or_(
            symbol.c.start_frame < 0,
            symbol.c.end_frame < symbol.c.start_frame,
            symbol.c.end_frame > capture.c.frames,
        ),
        *(symbol.c.start_frame, symbol.c.end_frame, capture.c.frames),
    ),
    "{0}: {1}, symbol {2} has the unknown direction {3} or {4}": _symbols(
        or_(symbol.c.direction.not_in(DIRECTIONS), symbol.c.runner_direction.not_in(DIRECTIONS)),
        *(symbol.c.direction, symbol.c.runner_direction),
    ),
    "{0}: {1}, symbol {2} has the unknown level {3} or {4}": _symbols(
        or_(symbol.c.level.not_in(LEVELS), symbol.c.runner_level.not_in(LEVELS)),
        *(symbol.c.level, symbol.c.runner_level),
    ),
    "{0}: {1} has {2} symbols, the last is number {3}": (
        select(capture.c.path, symbol.c.part, func.count(), _LAST)
        .join_from(symbol, capture, capture.c.id == symbol.c.capture_id)
        .group_by(symbol.c.capture_id, capture.c.path, symbol.c.part)
        .having(func.count() != _LAST + 1)
    ),
    "the profile {0} wrote nothing down": (
        select(profile.c.name)
        .outerjoin_from(profile, capture, capture.c.profile_id == profile.c.id)
        .where(capture.c.id.is_(None))
    ),
}
"""A sentence, and what to ask for the rows of which it is true."""


def _unreadable(connection: Connection) -> list[str]:
    columns = (capture.c.rate, capture.c.speed, capture.c.options, capture.c.other)
    texts = [
        (row.path, column.name, row[index])
        for row in connection.execute(select(*columns, capture.c.path))
        for index, column in enumerate(columns)
    ]
    known = select(capture.c.path, track.c.part, track.c.known).join_from(track, capture)
    texts += [(f"{path}: {part}", "known", text) for path, part, text in connection.execute(known)]
    wrong = [text for text in texts if not _reads(*text[1:])]
    return _told("{0}: {1} cannot be read: {2}", wrong)


def _reads(name: str, text: str) -> bool:
    try:
        if name in ("rate", "speed"):
            return Fraction(text) > 0
        json.loads(text)
    except (ValueError, ZeroDivisionError):
        return False
    return True
