"""Find damage inside a library: rows, columns, the view, and what SQLite itself finds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import LibraryError
from lanindex.library import columns, read, rows, segments
from lanindex.library.connect import (
    Link,
    ask,
    damaged_pages,
    first_values,
    has_view,
    loose_rows,
)
from lanindex.library.rows import VIEW, view_sql
from lanindex.library.segments import Distrust
from lanindex.library.selection import printable

_MOST = 5
"""Lines of each kind of damage."""

_BATCH = 1024
"""Captures whose rows are read at once."""

Damage = list[tuple[int, str]]
"""By the number of a capture, a sentence on what is damaged."""


def check_connection(connection: Link) -> list[str]:
    """Return what is wrong, a sentence each."""
    if pages := damaged_pages(connection, _MOST):
        # Answers of a damaged file to other questions mean nothing.
        return [f"the file is damaged: {line}" for line in pages]
    state, damage, unlike, symbols = list[str](), Damage(), list[str](), 0
    try:
        read.capture_numbers(connection)
    except LibraryError as error:
        state = [str(error)]
    numbers = first_values(ask(connection, "SELECT id FROM capture ORDER BY id"))
    compared = set[int]()
    try:
        for segment, stored in _pieces_of_segments(connection):
            some = stored.roster.number
            for piece in _pieces_of_rows(connection, some.tolist(), damage):
                symbols += sum(map(len, piece.columns.values()))
                own = piece.roster.number
                if not piece.same_as(stored.at(np.flatnonzero(np.isin(some, own)))):
                    unlike.append(
                        f"the columns of captures {own[0]} to {own[-1]} in segment {segment} are "
                        "not those of their rows, wanted the same. Have them made anew: "
                        "UPDATE state SET columns = -1"
                    )
            compared.update(some.tolist())
    except Distrust as fault:
        unlike = [f"the columns are {fault.found}. The next search or ingest makes them anew"]
    except LibraryError:  # Of the library's state, which is noted above
        pass
    rest = [number for number in numbers if number not in compared]
    for first in range(0, len(rest), _BATCH):
        for piece in _pieces_of_rows(connection, rest[first : first + _BATCH], damage):
            symbols += sum(map(len, piece.columns.values()))
    tables = ["capture", "metadata", "track"]
    ((count,),) = ask(connection, "SELECT count(*) FROM symbol_code")
    if damage or count != symbols:  # Not looked at otherwise: there are many
        tables.append("symbol_code")
    bonds = [bond for table in tables for bond in loose_rows(connection, table)]
    loose = "a row of {0} hangs on a row of {2} that does not exist"
    profiles = (
        "SELECT name FROM profile WHERE NOT EXISTS "
        "(SELECT 1 FROM capture WHERE capture.profile_id = profile.id)"
    )
    spare = [printable(str(name)) for name in first_values(ask(connection, profiles))]
    view = (
        "the view symbol does not show what the library holds. "
        "It is made anew by: lanindex db upgrade"
    )
    lines = [
        [loose.format(*bond) for bond in bonds],
        state + [line for _, line in sorted(damage)],
        [f"the profile {name} wrote nothing down" for name in spare],
        [] if has_view(connection, VIEW, view_sql()) else [view],
        unlike,
    ]
    return [line for some in lines for line in _shorten(some)]


def _shorten(lines: list[str]) -> list[str]:
    return lines[:_MOST] + ([f"… and {len(lines) - _MOST} more like it"] if lines[_MOST:] else [])


def _pieces_of_segments(connection: Link) -> Iterator[tuple[int, columns.Piece]]:
    """Yield the captures that the segments hold, some at a time, with the number of the segment."""
    spine = segments.read_spine(connection)
    columns.read_rosters(connection, spine)
    for segment in spine.segments:
        roster = segments.read_roster(connection, segment)
        held = {part: segments.read_columns(connection, segment, part) for part in segment.parts}
        whole = columns.Piece(roster, held, segments.read_texts(connection, segment))
        order = columns.alive(spine, segment, roster)
        for first in range(0, len(order), _BATCH):
            yield segment.id, whole.at(order[first : first + _BATCH])


def _pieces_of_rows(
    connection: Link, numbers: list[int], damage: Damage
) -> Iterator[columns.Piece]:
    """Yield captures from their rows, at once if none is damaged; note the damage of the others."""
    try:
        chosen = read.read_captures(connection, numbers)
        if len(chosen) != len(numbers):  # The table has it, but its index does not
            raise rows.damaged(numbers[0], None, "its row")
        tracks = read.read_track_rows(connection, chosen)
        symbols = read.read_symbols(connection, tracks)
        for _ in read.read_contents(connection, chosen):
            pass
        damage += _senseless_symbols(tracks, symbols)
        piece = columns.of_rows(tracks, symbols)
    except LibraryError as error:
        if len(numbers) == 1:
            damage.append((numbers[0], str(error)))
            return
        half = len(numbers) // 2
        for some in (numbers[:half], numbers[half:]):
            yield from _pieces_of_rows(connection, some, damage)
    else:
        yield piece


def _senseless_symbols(tracks: read.TrackRows, symbols: NDArray[Any]) -> Iterator[tuple[int, str]]:
    """Yield symbols that were stored with a right checksum but make no sense, by capture."""
    frames = np.array([one.capture.frames for one in tracks.chosen], np.int64)[tracks.place]
    if {*tracks.kind} <= {*range(len(rows.KIND_NAMES))} and not (
        rows.wrong(symbols, frames.repeat(tracks.symbols)).any()
    ):
        return
    every = read.tracks_of(tracks, symbols)
    for capture in (one.capture for one in tracks.chosen):
        for part, track in every[capture.id].items():
            for row in np.flatnonzero(rows.wrong(track.symbols, capture.frames)):
                yield capture.id, f"{capture.path}: {part}, symbol {row} is {track.symbols[row]}"
