"""What can be wrong inside a library: asked of the database, answered in sentences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import LibraryError
from lanindex.library import (
    capture_texts,
    checksums,
    codes,
    columns,
    derive,
    read,
    rows,
    segments,
    state,
)
from lanindex.library.codes import VIEW, view_sql
from lanindex.library.connect import is_sqlite
from lanindex.library.link import Link, ask, faults, first_values
from lanindex.library.segments import Distrust
from lanindex.library.selection import Texts
from lanindex.library.texts import printable
from lanindex.model.columns import Columns, Roster, same_columns

_MOST = 5
"""Rows named for each thing that is wrong."""

_BATCH = 1024
"""Captures whose rows are read at once."""


def check_connection(connection: Link) -> list[str]:
    """Return what is wrong, a sentence each."""
    sqlite = is_sqlite(connection)
    if sqlite and (damage := _damage(connection)):
        return damage  # what a damaged file answers to the other questions means nothing
    found = _Findings()
    found.go_through(connection)
    lines = [
        found.sentences(),
        list(_spare_profiles(connection)),
        list(_view(connection)),
        found.unlike,
    ]
    loose = _loose(connection, found) if sqlite else []
    return loose + [line for lines in lines for line in _cut(lines)]


def _cut(lines: list[str]) -> list[str]:
    return lines[:_MOST] + ([f"… and {len(lines) - _MOST} more like it"] if lines[_MOST:] else [])


def _damage(connection: Link) -> list[str]:
    # quick_check takes two thirds of the time, but leaves out whether the keys of rows rise, and
    # nothing else looks at the keys of symbols.
    try:
        pages = ask(connection, f"PRAGMA integrity_check({_MOST})").fetchall()
    except faults() as error:
        return [f"the file is damaged: {getattr(error, 'orig', error)}"]
    return [f"the file is damaged: {line}" for (line,) in pages if line != "ok"]


def _loose(connection: Link, found: _Findings) -> list[str]:
    """Return which rows hang on others that do not exist.

    Rows of symbols, which are many, are asked only where there are others than those of whole
    tracks.
    """
    ((symbols,),) = ask(connection, "SELECT count(*) FROM symbol_code")
    names = ["capture", "metadata", "track"]
    if found.damaged or symbols != found.symbols:
        names.append("symbol_code")
    bonds = [bond for it in names for bond in ask(connection, f"PRAGMA foreign_key_check({it})")]
    loose = "a row of {0} hangs on a row of {2} that does not exist"
    return _cut([loose.format(*bond) for bond in bonds])


class _Piece(NamedTuple):
    """Some captures of a segment, and what it holds of all."""

    segment: int
    places: NDArray[np.int64]
    roster: Roster
    texts: Texts
    columns: dict[str, Columns]

    def same_as(self, read: derive.Derived, texts: Mapping[str, list[Any]]) -> bool:
        """Return whether the rows of the captures say the same."""
        roster, columns = read
        return (
            roster.same_as(self.roster.taken(self.places))
            and capture_texts.together([self.texts], capture_texts.NAMES, self.places) == texts
            and all(
                same_columns(self._taken(part), columns.get(part))
                for part in self.columns.keys() | columns.keys()
            )
        )

    def _taken(self, part: str) -> Columns | None:
        """Return the columns of a part in these captures; None: the segment has none."""
        return self.columns[part].taken(self.places) if part in self.columns else None


class _Findings:
    """What has been found wrong with captures, as they are gone through."""

    def __init__(self) -> None:
        self.state = ""
        self.damaged: list[tuple[int, str]] = []
        self.unlike: list[str] = []
        self.symbols = 0

    def sentences(self) -> list[str]:
        """Return what is not as it was stored, capture by capture."""
        return [self.state] * bool(self.state) + [line for _, line in sorted(self.damaged)]

    def go_through(self, connection: Link) -> None:
        """Read all rows once, and hold the columns against them."""
        try:
            state.capture_numbers(connection)
        except LibraryError as error:
            self.state = str(error)
        asked = ask(connection, "SELECT id FROM capture ORDER BY id")
        left = dict.fromkeys(first_values(asked))
        try:
            spine = segments.read_spine(connection)
            columns.read_rosters(connection, spine)
            for segment in spine.segments:
                order, roster, held = columns.alive(connection, spine, segment)
                texts = capture_texts.read_texts(connection, segment)
                for first in range(0, len(order), _BATCH):
                    some = order[first : first + _BATCH]
                    self._look(connection, roster.number[some].tolist(),
                               _Piece(segment.id, some, roster, texts, held))  # fmt: skip
                    for number in roster.number[some].tolist():
                        left.pop(number, None)
        except Distrust as fault:
            remedy = "The next search or ingest makes them anew"
            self.unlike = [f"the columns are {fault.found}. {remedy}"]
        except LibraryError:  # of the library's state, which is said before
            pass
        numbers = list(left)
        for first in range(0, len(numbers), _BATCH):
            self._look(connection, numbers[first : first + _BATCH], None)

    def _look(self, connection: Link, numbers: list[int], piece: _Piece | None) -> None:
        """Look at some captures; where one is not what was stored, at fewer at once."""
        try:
            chosen = read.read_captures(connection, numbers)
            if len(chosen) != len(numbers):  # a table says that it is there, its index that not
                raise checksums.damaged(numbers[0], None, "its row")
            wanted = read.read_wanted(connection, chosen)
            fields = read.read_fields(connection, wanted, every=True)
            for _ in read.read_contents(connection, chosen):
                pass
            self.damaged += _nonsense(connection, wanted, fields)
            rows = derive.of_rows(wanted, fields)
        except LibraryError as error:
            if len(numbers) == 1:
                self.damaged.append((numbers[0], str(error)))
                return
            half = len(numbers) // 2
            for some in (slice(half), slice(half, None)):
                own = piece and piece._replace(places=piece.places[some])
                self._look(connection, numbers[some], own)
            return
        self.symbols += len(fields)
        if piece is None:
            return
        texts = {name: capture_texts.of_read(name, chosen, wanted) for name in capture_texts.NAMES}
        listed = {
            name: [own.get(number, capture_texts.EMPTY[name]) for number in numbers]
            for name, own in texts.items()
        }
        if not piece.same_as(rows, listed):
            self.unlike.append(
                f"the columns of captures {numbers[0]} to {numbers[-1]} in segment "
                f"{piece.segment} are not those of their rows, wanted the same. Have them made "
                "anew: UPDATE state SET columns = -1"
            )


def _nonsense(
    connection: Link, wanted: read.Tracks, fields: NDArray[np.int64]
) -> Iterator[tuple[int, str]]:
    """Yield what a program has stored that says nothing, with the capture's number."""
    start, length = (fields[:, codes.COLUMNS.index(name)] for name in ("start", "length"))
    frames = np.array([one.capture.frames for one in wanted.chosen], np.int64)[wanted.place]
    if {*wanted.kind} <= {*range(len(codes.KIND_NAMES))} and not (
        (start + length > frames.repeat(wanted.symbols)) | codes.nameless(fields)
    ).any():
        return
    every = read.read_tracks(connection, wanted.chosen)
    for capture in (one.capture for one in wanted.chosen):
        for part, track in every[capture.id].items():
            for row in np.flatnonzero(rows.wrong(track.symbols, capture.frames)):
                yield capture.id, f"{capture.path}: {part}, symbol {row} is {track.symbols[row]}"


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
