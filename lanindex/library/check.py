"""What can be wrong inside a library: asked of the database, answered in sentences."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lanindex.errors import LibraryError
from lanindex.library import called, columns, derive, gather, read, rows, segments, state
from lanindex.library.codes import VIEW, view_sql
from lanindex.library.connect import is_sqlite
from lanindex.library.link import Link, ask, faults, first_values
from lanindex.library.segments import Distrust
from lanindex.library.texts import printable
from lanindex.model import Capture, Score
from lanindex.model.columns import same_columns

_MOST = 5
"""Rows named for each thing that is wrong."""


def check_connection(connection: Link) -> list[str]:
    """Return what is wrong, a sentence each.

    Parameters
    ----------
    connection : Link
        In a transaction.
    """
    found: list[str] = []
    if is_sqlite(connection):
        damage = _damage(connection)
        if damage:  # what a damaged file answers to the other questions means nothing
            return damage
        found = _loose(connection)
    for question in (_unlike_stored, _spare_profiles, _view, _columns):
        found += _cut(list(question(connection)))
    return found


def _cut(told: list[str]) -> list[str]:
    return told[:_MOST] + ([f"… and {len(told) - _MOST} more like it"] if told[_MOST:] else [])


def _damage(connection: Link) -> list[str]:
    try:
        pages = ask(connection, f"PRAGMA integrity_check({_MOST})").fetchall()
    except faults() as error:
        return [f"the file is damaged: {getattr(error, 'orig', error)}"]
    return [f"the file is damaged: {line}" for (line,) in pages if line != "ok"]


def _loose(connection: Link) -> list[str]:
    bonds = ask(connection, "PRAGMA foreign_key_check").fetchall()
    loose = "a row of {0} hangs on a row of {2} that does not exist"
    return _cut([loose.format(*bond) for bond in bonds])


def _unlike_stored(connection: Link) -> Iterator[str]:
    """Yield what is not as it was stored, capture by capture."""
    try:
        state.capture_numbers(connection)
    except LibraryError as error:
        yield str(error)
    for number in first_values(ask(connection, "SELECT id FROM capture ORDER BY id").fetchall()):
        try:
            stored = read.read_capture(connection, number)
            score = read.read_score(connection, stored)
        except LibraryError as error:
            yield str(error)
            continue
        yield from _nonsense(stored.capture, score)


def _nonsense(stored: Capture, score: Score) -> Iterator[str]:
    """Yield what a program has stored that says nothing."""
    for part, track in score.tracks.items():
        rows_of_track = track.symbols
        for row in np.flatnonzero(rows.wrong(rows_of_track, score.frames)):
            yield f"{stored.path}: {part}, symbol {row} is {rows_of_track[row]}"


def _spare_profiles(connection: Link) -> Iterator[str]:
    unused = (
        "SELECT name FROM profile WHERE NOT EXISTS "
        "(SELECT 1 FROM capture WHERE capture.profile_id = profile.id)"
    )
    for name in first_values(ask(connection, unused)):
        yield f"the profile {printable(str(name))} wrote nothing down"


def _view(connection: Link) -> Iterator[str]:
    """Yield whether the view in words is another one than this program's."""
    if not shows_all(connection):
        yield (
            "the view symbol does not show what the library holds. "
            "It is made anew by: lanindex db upgrade"
        )


def shows_all(connection: Link) -> bool:
    """Return whether the view in words is this program's; of other databases it is believed."""
    asked = f"SELECT sql FROM sqlite_master WHERE type = 'view' AND name = '{VIEW}'"
    return not is_sqlite(connection) or ask(connection, asked).fetchall() == [(view_sql(),)]


def _columns(connection: Link) -> Iterator[str]:
    """Yield what of the segments cannot be trusted, or is not what the rows give."""
    try:
        gather.verify(connection)
    except Distrust as fault:
        yield f"the columns are {fault.found}. The next search or ingest makes them anew"
        return
    except LibraryError:  # of the library's state, which was said before
        return
    spine = segments.read_spine(connection)
    for segment in spine.segments:
        order, roster, held = columns.alive(connection, spine, segment)
        names = called.read_texts(connection, segment)
        for first in range(0, len(order), derive.BATCH):
            some = order[first : first + derive.BATCH]
            try:
                found, wanted = derive.derived(connection, roster.number[some].tolist())
            except LibraryError:  # which was said before
                continue
            own = roster.taken(some)
            same = found.same_as(own)
            now = called.of_rows(connection, own.number.tolist())
            same = same and called.together([names], called.NAMES, some) == now
            for part in held.keys() | wanted.keys():
                mine = held[part].taken(some) if part in held else None
                same = same and same_columns(mine, wanted.get(part))
            if not same:
                yield (
                    f"the columns of captures {own.number[0]} to {own.number[-1]} in segment "
                    f"{segment.id} are not those of their rows, wanted the same. Have them made "
                    "anew: UPDATE state SET columns = -1"
                )
