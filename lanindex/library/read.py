"""Read captures and tracks from their rows and check them against their checksums.

All functions run inside a transaction that the caller has begun.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from itertools import groupby
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import LanindexError, LibraryError
from lanindex.library import rows
from lanindex.library.connect import (
    Progress,
    among,
    ask,
    dialect_of,
    first_values,
    no_progress,
    no_tick,
)
from lanindex.library.dialect import MOST, Link
from lanindex.library.rows import COLUMNS, ENCODED, KIND_NAMES, Encoding, checksum, damaged
from lanindex.model import Capture, Meter, Span, Track
from lanindex.model.symbol import blank

_FACTS = len(ENCODED) + 2
"""Number of leading columns of `_CAPTURES` that a capture's checksum covers."""

_NUMBER = _FACTS + 1
"""Index of the capture's number in a row of `_CAPTURES`."""

_Raw = tuple[Any, ...]
"""A row as the database driver returns it."""

_READ = [f"capture.{name}" for name in (*ENCODED, "checksum", "id", "label", "said")]
_READ[len(ENCODED) : len(ENCODED)] = ["profile.name", "profile.digest"]
_CAPTURES = (
    f"SELECT {', '.join(_READ)} FROM capture LEFT JOIN profile ON profile.id = capture.profile_id"
)

_NONSENSE = (ValueError, TypeError, ArithmeticError, LookupError, RecursionError, LanindexError)
"""Errors that a stored value can raise even if its checksum is right."""


class State(NamedTuple):
    """The one row of ``state``: what is true of a library as a whole."""

    id: int
    stamp: int
    captures: int
    numbers: int
    columns: int


def read_state(connection: Link) -> State:
    """Return the one row of ``state``."""
    state_rows = ask(connection, f"SELECT {', '.join(State._fields)} FROM state").fetchall()
    if len(state_rows) != 1 or not all(isinstance(value, int) for value in state_rows[0]):
        raise LibraryError(
            f"the library's state is {state_rows}",
            wanted="one row of whole numbers",
            remedy="Ingest the captures into a new library: all in it comes from them.",
        )
    return State(*state_rows[0])


def check_numbers(connection: Link, capture_ids: Sequence[int]) -> None:
    """Raise an error if the captures of a library are not those that were stored."""
    stored, count, total = read_state(connection), len(capture_ids), sum(capture_ids)
    if (count, total) != (stored.captures, stored.numbers):
        raise LibraryError(
            f"the library holds {count} captures whose numbers add up to {total}",
            wanted=f"{stored.captures} and {stored.numbers}, as were stored",
            remedy="Ingest the captures into a new library; or, if another program took some out "
            "on purpose, tell this one: UPDATE state SET "
            f"captures = {count}, numbers = {total}",
        )


def capture_numbers(connection: Link) -> list[int]:
    """Return the numbers of all captures, in order."""
    capture_ids: list[int] = first_values(ask(connection, "SELECT id FROM capture ORDER BY id"))
    check_numbers(connection, capture_ids)
    return capture_ids


def read_numbers(connection: Link, capture_ids: Sequence[int]) -> list[int]:
    """Return those of some captures' numbers that exist, in the same order."""
    stored = set[int]()
    for first in range(0, len(capture_ids), MOST):
        chosen = among(capture_ids[first : first + MOST])
        stored.update(first_values(ask(connection, f"SELECT id FROM capture WHERE id IN {chosen}")))
    return [number for number in capture_ids if number in stored]


class Stored(NamedTuple):
    """A capture with its encoding and the checksums of its other rows and columns."""

    capture: Capture
    encoding: Encoding
    tracks: int  # Checksum of its rows of ``track``
    content: int  # Checksum of its heading and of the lines that were not understood


def read_stored(
    connection: Link, capture_ids: Sequence[int] | None = None
) -> Iterator[Stored | LibraryError]:
    """Yield all captures or some, by number; an error takes the place of a damaged one.

    Numbers of captures that do not exist are skipped.
    """
    captures, described = _CAPTURES, "SELECT capture_id, key, value FROM metadata"
    if capture_ids is not None:
        captures += f" WHERE capture.id IN {among(capture_ids)}"
        described += f" WHERE capture_id IN {among(capture_ids)}"
    metadata: dict[int, dict[str, str]] = {}
    for number, key, value in ask(connection, described):
        metadata.setdefault(number, {})[key] = value
    for row in ask(connection, f"{captures} ORDER BY capture.id").fetchall():
        try:
            yield _stored(row, metadata.get(row[_NUMBER], {}))
        except LibraryError as error:
            yield error


def _stored(row: _Raw, metadata: Mapping[str, str]) -> Stored:
    facts, (whole, number, label, described) = row[:_FACTS], row[_FACTS:]
    path, location, form, sha256, _, rate, frames, *meter, options, warnings = facts[:-4]
    tracks, content, profile, digest = facts[-4:]
    what = "what is known of its file"
    if checksum(*facts) != whole:
        raise damaged(number, location, what)
    if description_checksum(number, label, metadata) != described:
        raise damaged(number, location, "its label or metadata (say them again, too)")
    try:
        encoding = _encoding(profile or "", digest or "", options)
        capture = Capture(
            *(number, path, form, sha256, label, _fraction(rate), frames, _meter(*meter)),
            metadata=metadata,
            location=location,
            warnings=_warnings_of(warnings),
            options=encoding.options,
        )
    except _NONSENSE as error:
        raise damaged(number, location, f"{what} ({error})") from error
    return Stored(capture, encoding, tracks, content)


@lru_cache(maxsize=64)
def _fraction(text: str) -> Fraction:
    return Fraction(text)


@lru_cache(maxsize=64)
def _meter(speed: str, beats: int, beat: int, division: int) -> Meter:
    return Meter(_fraction(speed), beats, beat, division)


@lru_cache(maxsize=64)
def _encoding(profile: str, digest: str, options: str) -> Encoding:
    return Encoding.stored(profile, digest, json.loads(options))


@lru_cache(maxsize=64)
def _warnings_of(warnings: str) -> tuple[str, ...]:
    return tuple(json.loads(warnings))


def description_checksum(number: int, label: str, metadata: Mapping[str, str]) -> int:
    """Return the checksum of a capture's label and metadata."""
    return checksum(number, label, *sorted(metadata.items(), key=ascii))


def encoded_of(connection: Link, number: int) -> tuple[dict[str, Any], tuple[Any, Any]]:
    """Return the `ENCODED` columns of a capture, and the name and digest of its profile."""
    (row,) = ask(connection, f"{_CAPTURES} WHERE capture.id = :number", {"number": number})
    return dict(zip(ENCODED, row, strict=False)), row[len(ENCODED) : _FACTS]


def read_captures(
    connection: Link,
    capture_ids: Sequence[int] | None = None,
    progress: Progress = no_progress,
) -> list[Stored]:
    """Return all captures or some, by number, and raise the error of the first damaged one."""
    captures: list[Stored] = []
    total = read_state(connection).captures if capture_ids is None else len(capture_ids)
    for one in read_stored(connection, capture_ids):
        if isinstance(one, LibraryError):
            raise one
        if len(captures) % MOST == 0:
            progress("captures", len(captures), total)
        captures.append(one)
    progress("captures", len(captures), total)
    if capture_ids is None:
        check_numbers(connection, [one.capture.id for one in captures])
    return captures


@dataclass(frozen=True, slots=True)
class TrackRows:
    """Rows of ``track`` of some captures: a sequence a column, as there may be millions of rows."""

    chosen: Sequence[Stored]  # The captures
    every: bool  # Whether these are all tracks of the captures
    place: NDArray[np.int64]  # (T,) int64: index of each row's capture in `chosen`
    ordinal: Sequence[int]
    part: Sequence[str]
    kind: Sequence[int]
    known: Sequence[str | None]
    symbols: Sequence[int]
    checksum: Sequence[int]

    @property
    def owners(self) -> list[Capture]:
        """The capture of each row."""
        captures = [one.capture for one in self.chosen]
        return [captures[place] for place in self.place.tolist()]


_PART = rows.TRACK.index("part")
_SYMBOLS = rows.TRACK.index("symbols")


def _select_tracks(connection: Link, where: str, values: Mapping[str, str] | None = None) -> Any:
    """Return rows of ``track`` in order: the columns `rows.TRACK`, then the capture's number."""
    asked = f"SELECT {', '.join(rows.TRACK)}, capture_id FROM track {where}"
    return ask(connection, f"{asked} ORDER BY capture_id, ordinal", values).fetchall()


def _checked_tracks(connection: Link, captures: Sequence[_Raw], where: str = "") -> list[_Raw]:
    """Return the rows of ``track`` of some captures, if they are those that were stored.

    `captures` are numbers, locations and checksums; the condition `where` selects them.
    """
    selected = groupby(_select_tracks(connection, where), itemgetter(-1))
    by_capture = {number: list(group) for number, group in selected}
    for number, location, content in captures:
        if checksum(*(row[:-1] for row in by_capture.setdefault(number, []))) != content:
            raise damaged(number, location, "the list of its tracks")
    return [row for number, _, _ in captures for row in by_capture[number]]


def read_parts(connection: Link, tick: Callable[[], None] = no_tick) -> set[str]:
    """Return the parts that any capture has; `tick` is called now and then, and may raise."""
    captures = ask(connection, "SELECT id, location, tracks FROM capture").fetchall()
    check_numbers(connection, first_values(captures))
    parts = set[str]()
    for first in range(0, len(captures), MOST):
        tick()
        some = captures[first : first + MOST]
        where = f"WHERE capture_id IN {among(first_values(some))}"
        parts |= {row[_PART] for row in _checked_tracks(connection, some, where)}
    return parts


def read_track_rows(
    connection: Link,
    chosen: Sequence[Stored],
    parts: Sequence[str] | None = None,
    *,
    listed: bool = True,
) -> TrackRows:
    """Return the rows of ``track`` of captures: of all parts or of some.

    With `listed`, each capture's list of tracks is checked. Without it only the rows of `parts` are
    read, and a row that is missing or has the name of another part goes unnoticed.
    """
    captures = [(one.capture.id, one.capture.location, one.tracks) for one in chosen]
    numbers = first_values(captures)
    where = f"WHERE capture_id IN {among(numbers)}"
    if parts is None:
        selected = _checked_tracks(connection, captures, where)
    elif listed:
        every = _checked_tracks(connection, captures, where)
        selected = [row for row in every if row[_PART] in parts]
    else:
        values = {f"part{at}": part for at, part in enumerate(parts)}
        where += f" AND part IN ({', '.join(f':{name}' for name in values) or 'NULL'})"
        wanted = {*numbers}
        selected = [
            row
            for row in _select_tracks(connection, where, values)
            # In a damaged row they may be anything
            if type(row[0]) is type(row[_SYMBOLS]) is int and row[_SYMBOLS] >= 0
            if row[-1] in wanted
        ]
    place = np.searchsorted(numbers, [row[-1] for row in selected])
    columns = list(zip(*selected, strict=True)) or [()] * len(rows.TRACK)
    return TrackRows(chosen, parts is None, place, *columns[: len(rows.TRACK)])


def read_tracks(
    connection: Link,
    chosen: Sequence[Stored],
    parts: Sequence[str] | None = None,
    *,
    listed: bool = True,
) -> dict[int, dict[str, Track]]:
    """Return the tracks of captures by capture number and part: of all parts or of some.

    `listed` is explained at `read_track_rows`.
    """
    tracks = read_track_rows(connection, chosen, parts, listed=listed)
    return tracks_of(tracks, read_symbols(connection, tracks))


def tracks_of(tracks: TrackRows, symbols: NDArray[Any]) -> dict[int, dict[str, Track]]:
    """Return tracks by capture number and part, made of their rows and (S,) symbols."""
    by_capture: dict[int, dict[str, Track]] = {one.capture.id: {} for one in tracks.chosen}
    columns, first = (tracks.owners, tracks.part, tracks.kind, tracks.known, tracks.symbols), 0
    for capture, part, kind, spans, count in zip(*columns, strict=True):
        stretch = symbols[first : first + count]
        first += count
        known = known_of(capture, part, spans)
        try:
            by_capture[capture.id][part] = Track(part, stretch, known, KIND_NAMES[kind])
        except _NONSENSE as error:
            raise damaged(capture.id, capture.location, f"its track {part} ({error})") from error
    return by_capture


def read_stretch(
    connection: Link, one: Stored, frames: Span, parts: Sequence[str] | None = None
) -> tuple[dict[str, Track], dict[str, int]]:
    """Return what tracks of a capture hold in a stretch, and which of their rows is the first.

    Rows follow each other by their ends, so those of a stretch are found without all others. They
    are looked at, but not their checksums, which are over whole tracks.
    """
    found = read_track_rows(connection, [one], parts)
    firsts, held = list[int](), [np.empty((0, len(COLUMNS)), np.int64)]
    try:
        for track, count in zip(found.ordinal, found.symbols, strict=True):
            first, packed = _stretch(connection, (one.capture.id, track), count, frames)
            firsts.append(first)
            held.append(packed)
    except _NONSENSE as error:
        what = f"its track {found.part[len(firsts)]} ({error})"
        raise damaged(one.capture.id, one.capture.location, what) from error
    packed, counts = np.concatenate(held), [len(it) for it in held[1:]]
    symbols = rows.unpack(packed)
    odd = (rows.pack(symbols) != packed).any(axis=1) | rows.wrong(symbols, one.capture.frames)
    if odd.any():
        part = found.part[int(np.searchsorted(np.cumsum(counts), odd.argmax(), "right"))]
        raise damaged(one.capture.id, one.capture.location, f"its track {part}")
    tracks = tracks_of(replace(found, symbols=counts), symbols)[one.capture.id]
    return tracks, dict(zip(found.part, firsts, strict=True))


def _stretch(
    connection: Link, track: tuple[int, int], count: int, frames: Span
) -> tuple[int, NDArray[np.int64]]:
    """Return the first row of a track that tells of a stretch, and the fields of all: (S, C)."""
    values = dict(zip(("number", "track"), track, strict=True))
    where = "FROM symbol_code WHERE capture_id = :number AND track = :track AND ordinal"

    def ended(frame: int) -> int:  # how many rows end by a frame: a binary search in one query
        asked = f"""WITH RECURSIVE found(rows, step) AS (
            SELECT 0, CAST(:step AS INTEGER)
            UNION ALL
            SELECT CASE WHEN (SELECT start + length {where} = rows + step - 1) <= :frame
                THEN rows + step ELSE rows END, step / 2
            FROM found WHERE step > 0)
        SELECT rows FROM found WHERE step = 0"""
        step = 1 << count.bit_length() - 1 if count else 0
        found = ask(connection, asked, {**values, "step": step, "frame": frame})
        return int(found.fetchone()[0])

    first = max(ended(frames.start) - 1, 0)
    last = min(ended(frames.stop - 1), count - 1)
    asked = f"SELECT {', '.join(COLUMNS)} {where} BETWEEN :first AND :last ORDER BY ordinal"
    held = ask(connection, asked, {**values, "first": first, "last": last}).fetchall()
    if len(held) != last + 1 - first:
        raise ValueError(f"{len(held)} rows in place of {last + 1 - first}")
    return first, np.array(held, np.int64).reshape(-1, len(COLUMNS))


def known_of(capture: Capture, part: str, known: str | None) -> tuple[Span, ...]:
    """Return `Track.known`, the frames in which a part was seen, from the column ``known``."""
    try:
        if known is None:
            return (Span(0, capture.frames),)
        return tuple(Span(start, stop) for start, stop in json.loads(known))
    except _NONSENSE as error:
        raise damaged(capture.id, capture.location, f"its track {part} ({error})") from error


def read_symbols(connection: Link, tracks: TrackRows) -> NDArray[Any]:
    """Return the symbols of tracks, one track after the other: (S,) of `SYMBOL`."""
    capture_ids = [
        tracks.chosen[place].capture.id for place in dict.fromkeys(tracks.place.tolist())
    ]
    if not capture_ids:
        return blank(0)
    chosen = f"capture_id IN {among(capture_ids)}"
    of_tracks = f"{chosen} AND track IN {among({*tracks.ordinal})}"
    fields = _fields(connection, tracks, chosen if tracks.every else of_tracks)
    if fields is None:  # the rows are read again, one by one: an error says which are damaged
        fields = _fields_by_row(connection, tracks, of_tracks)
    return rows.unpack(fields)


def _fields(link: Link, tracks: TrackRows, chosen: str) -> NDArray[np.int64] | None:
    """Return the fields of the symbols of tracks, (S, C) int64; None if they may be damaged.

    The keys of the rows are not fetched: the rows of a track come in order, and the track's
    checksum covers their ordinals, too. Every deviation from what was stored is noticed, but not
    where it is.
    """
    fields = dialect_of(link).numbers(link, COLUMNS, chosen)
    if fields is None or len(fields) != sum(tracks.symbols):
        return None
    numbers = rows.numbered(fields, tracks.symbols, tracks.ordinal)
    same = rows.track_checksums(numbers, tracks.symbols) == [*tracks.checksum]
    return fields if same else None


def _fields_by_row(connection: Link, tracks: TrackRows, chosen: str) -> NDArray[np.int64]:
    """Return the fields of the symbols of tracks, (S, C) int64; an error names a damaged track."""
    asked = f"SELECT capture_id, track, ordinal, {', '.join(COLUMNS)} FROM symbol_code"
    by_track: dict[tuple[int, int], list[_Raw]] = {}
    locations = {one.id: one.location for one in tracks.owners}
    for row in ask(connection, f"{asked} WHERE {chosen} ORDER BY capture_id, track, ordinal"):
        if not all(isinstance(value, int) for value in row):
            what = f"its track number {row[1]} holds what is no number"
            raise damaged(row[0], locations.get(row[0]), what)  # or a row of another table
        by_track.setdefault(row[:2], []).append(row[1:])
    tables = [np.empty((0, len(COLUMNS) + 2), np.int64)]
    columns = (tracks.owners, tracks.ordinal, tracks.part, tracks.symbols, tracks.checksum)
    for capture, ordinal, part, count, content in zip(*columns, strict=True):
        held = by_track.pop((capture.id, ordinal), [])
        table = np.array(held, np.int64).reshape(len(held), len(COLUMNS) + 2)
        if len(held) != count or rows.track_checksums(table, [count]) != [content]:
            raise damaged(capture.id, capture.location, f"its track {part}")
        tables.append(table)
    return np.concatenate(tables)[:, 2:]


def read_contents(
    connection: Link, chosen: Sequence[Stored]
) -> Iterator[tuple[NDArray[np.float32], tuple[str, ...]]]:
    """Yield the heading of each capture, and the lines that were not understood."""
    capture_ids = among(one.capture.id for one in chosen)
    asked = f"SELECT id, other, heading FROM capture WHERE id IN {capture_ids}"
    held = {number: (lines, blob) for number, lines, blob in ask(connection, asked)}
    what = "its heading or the lines that were not understood"
    for capture, *_, content in chosen:
        lines, blob = held.get(capture.id, (None, None))
        if content_checksum(lines, blob) != content:
            raise damaged(capture.id, capture.location, what)
        try:
            yield rows.unpack_heading(blob), tuple(json.loads(lines))
        except _NONSENSE as error:
            raise damaged(capture.id, capture.location, f"{what} ({error})") from error


def content_checksum(other: Any, heading: Any) -> int | None:
    """Return the checksum of a capture's heading and lines; None if their types are wrong."""
    if not isinstance(heading, bytes) or not isinstance(other, str):
        return None
    return rows.bytes_checksum(heading, other.encode("utf-8", "surrogatepass"))
