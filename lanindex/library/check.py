"""Find damage inside a library: rows, columns, the view, and what SQLite itself finds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

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
from lanindex.library.segments import TEXTS, Distrust
from lanindex.library.selection import Texts, printable
from lanindex.model.columns import Columns, Roster, same_columns

_MOST = 5
"""Lines of each kind of damage."""

_BATCH = 1024
"""Captures whose rows are read at once."""


def check_connection(connection: Link) -> list[str]:
    """Return what is wrong, a sentence each."""
    if pages := damaged_pages(connection, _MOST):
        # Answers of a damaged file to other questions mean nothing.
        return [f"the file is damaged: {line}" for line in pages]
    findings = _Findings()
    findings.go_through(connection)
    tables = ["capture", "metadata", "track"]
    ((symbols,),) = ask(connection, "SELECT count(*) FROM symbol_code")
    if findings.damaged or symbols != findings.symbols:  # Not looked at otherwise: there are many
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
        findings.sentences(),
        [f"the profile {name} wrote nothing down" for name in spare],
        [] if has_view(connection, VIEW, view_sql()) else [view],
        findings.unlike,
    ]
    return [line for some in lines for line in _shorten(some)]


def _shorten(lines: list[str]) -> list[str]:
    return lines[:_MOST] + ([f"… and {len(lines) - _MOST} more like it"] if lines[_MOST:] else [])


class _Piece(NamedTuple):
    """Some captures of a segment, by their places, and the columns and texts of all in it."""

    segment: int
    places: NDArray[np.int64]
    roster: Roster
    texts: Texts
    by_part: dict[str, Columns]

    def same_as(self, derived: columns.Derived, texts: Mapping[str, list[Any]]) -> bool:
        """Return whether columns and texts of the rows are equal."""
        roster, by_part = derived
        held = {part: one.at(self.places) for part, one in self.by_part.items()}
        return (
            roster.same_as(self.roster.at(self.places))
            and columns.joined_texts([self.texts], TEXTS, self.places) == texts
            and all(
                same_columns(held.get(part), by_part.get(part))
                for part in held.keys() | by_part.keys()
            )
        )


class _Findings:
    """Damage of captures and of their columns."""

    def __init__(self) -> None:
        self.state = ""
        self.damaged: list[tuple[int, str]] = []
        self.unlike: list[str] = []
        self.symbols = 0

    def sentences(self) -> list[str]:
        """Return the damage of captures, in the order of their numbers."""
        return [self.state] * bool(self.state) + [line for _, line in sorted(self.damaged)]

    def go_through(self, connection: Link) -> None:
        """Read all rows once, and compare the columns with them."""
        try:
            read.capture_numbers(connection)
        except LibraryError as error:
            self.state = str(error)
        asked = ask(connection, "SELECT id FROM capture ORDER BY id")
        left = dict.fromkeys(first_values(asked))
        try:
            spine = segments.read_spine(connection)
            columns.read_rosters(connection, spine)
            for segment in spine.segments:
                roster = segments.read_roster(connection, segment)
                order = columns.alive(spine, segment, roster)
                held = {
                    part: segments.read_columns(connection, segment, part) for part in segment.parts
                }
                texts = segments.read_texts(connection, segment)
                for first in range(0, len(order), _BATCH):
                    some = order[first : first + _BATCH]
                    self._check_captures(connection, roster.number[some].tolist(),
                               _Piece(segment.id, some, roster, texts, held))  # fmt: skip
                    for number in roster.number[some].tolist():
                        left.pop(number, None)
        except Distrust as fault:
            remedy = "The next search or ingest makes them anew"
            self.unlike = [f"the columns are {fault.found}. {remedy}"]
        except LibraryError:  # Of the library's state, which is noted above
            pass
        numbers = list(left)
        for first in range(0, len(numbers), _BATCH):
            self._check_captures(connection, numbers[first : first + _BATCH], None)

    def _check_captures(self, connection: Link, numbers: list[int], piece: _Piece | None) -> None:
        """Check some captures; if one is damaged, check each half."""
        try:
            chosen = read.read_captures(connection, numbers)
            if len(chosen) != len(numbers):  # The table has it, but its index does not
                raise rows.damaged(numbers[0], None, "its row")
            wanted = read.read_wanted(connection, chosen)
            fields = read.read_fields(connection, wanted, every=True)
            for _ in read.read_contents(connection, chosen):
                pass
            self.damaged += _senseless_symbols(connection, wanted, fields)
            derived = columns.of_rows(wanted, fields)
        except LibraryError as error:
            if len(numbers) == 1:
                self.damaged.append((numbers[0], str(error)))
                return
            half = len(numbers) // 2
            for some in (slice(half), slice(half, None)):
                own = piece and piece._replace(places=piece.places[some])
                self._check_captures(connection, numbers[some], own)
            return
        self.symbols += len(fields)
        if piece is None:
            return
        texts = {name: columns.texts_of(name, chosen, wanted) for name in TEXTS}
        if not piece.same_as(derived, texts):
            self.unlike.append(
                f"the columns of captures {numbers[0]} to {numbers[-1]} in segment "
                f"{piece.segment} are not those of their rows, wanted the same. Have them made "
                "anew: UPDATE state SET columns = -1"
            )


def _senseless_symbols(
    connection: Link, tracks: read.Tracks, fields: NDArray[np.int64]
) -> Iterator[tuple[int, str]]:
    """Yield symbols that were stored with a right checksum but make no sense, by capture."""
    start, length = (fields[:, rows.COLUMNS.index(name)] for name in ("start", "length"))
    frames = np.array([one.capture.frames for one in tracks.chosen], np.int64)[tracks.place]
    if {*tracks.kind} <= {*range(len(rows.KIND_NAMES))} and not (
        (start + length > frames.repeat(tracks.symbols)) | rows.nameless(fields)
    ).any():
        return
    every = read.read_tracks(connection, tracks.chosen)
    for capture in (one.capture for one in tracks.chosen):
        for part, track in every[capture.id].items():
            for row in np.flatnonzero(rows.wrong(track.symbols, capture.frames)):
                yield capture.id, f"{capture.path}: {part}, symbol {row} is {track.symbols[row]}"
