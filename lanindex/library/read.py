"""Rows to captures and tracks, each held against its checksum, inside another's transaction."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import LanindexError, LibraryError
from lanindex.library import checksums, codes, packed, rows, state
from lanindex.library.encoding import ENCODED, Encoding
from lanindex.library.link import Link, among, ask, first_values
from lanindex.library.selection import is_number
from lanindex.library.texts import absolute
from lanindex.model import Capture, Meter, Score, Span, Track

_FACTS = len(ENCODED) + 2
"""Columns of `_CAPTURES` that a capture's checksum is over: `ENCODED`, and its profile."""

_NUMBER = _FACTS + 1
"""The column of `_CAPTURES` that is a capture's number."""

_Raw = tuple[Any, ...]
"""A row as the driver gives it."""

_READ = [f"capture.{name}" for name in (*ENCODED, "checksum", "id", "label", "said")]
_READ[len(ENCODED) : len(ENCODED)] = ["profile.name", "profile.digest"]
_CAPTURES = (
    f"SELECT {', '.join(_READ)} FROM capture LEFT JOIN profile ON profile.id = capture.profile_id"
)
_CODES = f"SELECT capture_id, track, ordinal, {', '.join(codes.COLUMNS)} FROM symbol_code"
_BY_KEY = "ORDER BY capture_id, track, ordinal"


class Stored(NamedTuple):
    """A capture, with what else its rows say."""

    capture: Capture
    encoding: Encoding
    tracks: int
    """Checksum of the list of its tracks."""
    content: int
    """Checksum of its heading and its other lines."""


def meant(connection: Link, named: str) -> Iterator[list[tuple[int, str]]]:
    """Yield the captures that a name fits, one way after the other: number and location of each.

    Their path is this name, their absolute path is, it ends with this name, their number is this.
    The first two are looked up in an index; the third goes through the index of locations.
    """
    tail, number = os.sep + named, int(named) if named.isascii() and named.isdigit() else 0
    ways: tuple[tuple[str, str | int], ...] = (
        ("path = :one", named),
        ("location = :one", absolute(named)),
        (f"substr(location, -{len(tail)}) = :one", tail),
        ("id = :one", number if str(number) == named and is_number(number) else -1),
    )
    for way, one in ways:
        asked = f"SELECT id, location FROM capture WHERE {way}"
        yield sorted(ask(connection, asked, {"one": one}))  # sorted by SQL, it would scan the table


def paths_begun(connection: Link, begun: str) -> Iterator[str]:
    """Yield the paths that begin with a text, or whose last part does, in order."""
    escaped = re.sub(r"([\\%_])", r"\\\1", begun)
    asked = "SELECT path FROM capture WHERE path LIKE :begun ESCAPE :mark"
    asked += " OR path LIKE :name ESCAPE :mark ORDER BY path"
    values = {"begun": f"{escaped}%", "name": f"%{os.sep}{escaped}%", "mark": "\\"}
    for (path,) in ask(connection, asked, values):
        if path.startswith(begun) or os.path.basename(path).startswith(begun):
            yield path


def locations(connection: Link, places: Sequence[str], digests: Sequence[str]) -> list[str]:
    """Return where the captures lie that are at one of these places or have such a sha256."""
    found: list[str] = []
    for column, values in (("location", places), ("sha256", digests)):
        for first in range(0, len(values), state.MOST):
            some = {f"v{at}": one for at, one in enumerate(values[first : first + state.MOST])}
            chosen = ", ".join(f":{name}" for name in some)
            asked = f"SELECT location FROM capture WHERE {column} IN ({chosen})"
            found += first_values(ask(connection, asked, some))
    return found


def read_stored(
    connection: Link, numbers: Sequence[int] | None = None
) -> Iterator[Stored | LibraryError]:
    """Yield captures in the order of their numbers: all, or those that exist of some."""
    chosen, described = _CAPTURES, "SELECT capture_id, key, value FROM metadata"
    if numbers is not None:
        chosen += f" WHERE capture.id IN {among(numbers)}"
        described += f" WHERE capture_id IN {among(numbers)}"
    metadata: dict[int, dict[str, str]] = {}
    for number, key, value in ask(connection, described):
        metadata.setdefault(number, {})[key] = value
    for row in ask(connection, f"{chosen} ORDER BY capture.id").fetchall():
        try:
            yield _stored(row, metadata.get(row[_NUMBER], {}))
        except LibraryError as error:
            yield error


def encoded_of(connection: Link, number: int) -> tuple[dict[str, Any], tuple[Any, Any]]:
    """Return what was encoded of a capture, by column, and its profile's name and digest."""
    (row,) = ask(connection, f"{_CAPTURES} WHERE capture.id = :number", {"number": number})
    return dict(zip(ENCODED, row, strict=False)), row[len(ENCODED) : _FACTS]


def _stored(row: _Raw, metadata: Mapping[str, str]) -> Stored:
    facts, (checksum, number, label, stored) = row[:_FACTS], row[_FACTS:]
    path, location, form, sha256, _, rate, frames, *meter, options, warnings, tracks, content = (
        facts[:-2]
    )
    what = "what is known of its file"
    if checksums.of_values(*facts) != checksum:
        raise checksums.damaged(number, location, what)
    if said(number, label, metadata) != stored:
        raise checksums.damaged(number, location, "its label or metadata (say them again, too)")
    try:
        encoding = _encoding(facts[-2] or "", facts[-1] or "", options)
        capture = Capture(
            *(number, path, form, sha256, label, _fraction(rate), frames, _meter(*meter)),
            metadata=metadata,
            location=location,
            warnings=_listed(warnings),
            options=encoding.options,
        )
    except _NONSENSE as error:
        raise checksums.damaged(number, location, f"{what} ({error})") from error
    return Stored(capture, encoding, tracks, content)


_NONSENSE = (ValueError, TypeError, ArithmeticError, LookupError, RecursionError, LanindexError)
"""What reading a value leads to that a program has stored with the right checksum."""


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
def _listed(warnings: str) -> tuple[str, ...]:
    return tuple(json.loads(warnings))


def said(number: int, label: str, metadata: Mapping[str, str]) -> int:
    """Return the checksum of what the user says of a capture."""
    return checksums.of_values(number, label, *sorted(metadata.items(), key=ascii))


def read_captures(connection: Link, numbers: Sequence[int] | None = None) -> list[Stored]:
    """Return captures in the order of their numbers: all, or those that exist of some."""
    found = list(read_stored(connection, numbers))
    for one in found:
        if isinstance(one, LibraryError):
            raise one
    if numbers is None:
        state.check_numbers(
            connection, [one.capture.id for one in found if isinstance(one, Stored)]
        )
    return [one for one in found if isinstance(one, Stored)]


def read_chosen(connection: Link, numbers: Sequence[int]) -> list[Capture]:
    """Return those captures that exist of some, however many."""
    return [
        one.capture
        for first in range(0, len(numbers), state.MOST)
        for one in read_captures(connection, numbers[first : first + state.MOST])
    ]


def read_capture(connection: Link, number: int) -> Stored:
    """Return one capture that is there."""
    found = read_captures(connection, [number])
    if len(found) != 1:  # one table says that it is there, its index that it is not
        raise checksums.damaged(number, None, "its row")
    return found[0]


@dataclass(frozen=True, slots=True)
class Tracks:
    """Rows of ``track`` of some captures, column by column: there are millions."""

    chosen: Sequence[Stored]
    place: NDArray[np.int64]
    ordinal: Sequence[int]
    part: Sequence[str]
    kind: Sequence[int]
    known: Sequence[str | None]
    symbols: Sequence[int]
    checksum: Sequence[int]

    @property
    def owners(self) -> list[Capture]:
        """The capture of each."""
        captures = [one.capture for one in self.chosen]
        return [captures[place] for place in self.place.tolist()]


_LISTED = ("ordinal", "part", "kind", "known", "symbols", "checksum")
_PART = _LISTED.index("part")
_COUNTED = "SELECT capture_id, count(*) FROM track"


def read_parts(connection: Link) -> set[str]:
    """Return the parts that any capture has."""
    wanted = ask(connection, "SELECT id, location, tracks FROM capture").fetchall()
    state.check_numbers(connection, [number for number, _, _ in wanted])
    return {row[_PART] for own in _lists(connection, wanted) for row in own}


def _lists(connection: Link, wanted: Sequence[Any], chosen: str = "") -> list[list[_Raw]]:
    """Return the rows of ``track`` of each capture, in the columns of `_LISTED`.

    Of each wanted one its number, its location and the checksum of these are told; of all captures
    they are `chosen` by a condition, if they are not all.
    """
    asked = f"SELECT {', '.join(_LISTED)} FROM track {chosen} ORDER BY capture_id, ordinal"
    every = ask(connection, asked).fetchall()
    asked = f"{_COUNTED} {chosen} GROUP BY capture_id ORDER BY capture_id"
    lists, first = dict[int, list[_Raw]](), 0
    for number, count in ask(connection, asked):
        lists[number] = every[first : first + count]
        first += count
    found = [lists.get(number, []) for number, _, _ in wanted]
    for own, (number, location, checksum) in zip(found, wanted, strict=True):
        if checksums.of_values(*own) != checksum:
            raise checksums.damaged(number, location, "the list of its tracks")
    return found


def _unlisted(connection: Link, numbers: Sequence[int], parts: Sequence[str]) -> list[_Raw]:
    """Return the rows of ``track`` of some parts, in the columns of `_LISTED`, then the capture."""
    values = {f"part{place}": part for place, part in enumerate(parts)}
    named = ", ".join(f":{name}" for name in values) or "NULL"
    asked = (
        f"SELECT {', '.join(_LISTED)}, capture_id FROM track "
        f"WHERE capture_id IN {among(numbers)} AND part IN ({named}) ORDER BY capture_id, ordinal"
    )
    return [row for row in ask(connection, asked, values) if _countable(row)]


def _countable(row: _Raw) -> bool:
    """Return whether a row of ``track`` tells what rows of symbols it has."""
    ordinal, _, _, _, symbols, *_ = row
    return type(ordinal) is type(symbols) is int and symbols >= 0


def read_tracks(
    connection: Link,
    chosen: Sequence[Stored],
    parts: Sequence[str] | None = None,
    *,
    listed: bool = True,
) -> dict[int, dict[str, Track]]:
    """Return the tracks of captures, by the captures' numbers: all, or those of some parts.

    `listed` as in `read_wanted`.
    """
    wanted = read_wanted(connection, chosen, parts, listed=listed)
    symbols, first = codes.unpack(read_fields(connection, wanted, every=parts is None)), 0
    tracks: dict[int, dict[str, Track]] = {one.capture.id: {} for one in chosen}
    rows = zip(wanted.owners, wanted.part, wanted.kind, wanted.known, wanted.symbols, strict=True)
    for capture, part, kind, spans, count in rows:
        stretch = symbols[first : first + count]
        first += count
        known = known_of(capture, part, spans)
        try:
            tracks[capture.id][part] = Track(part, stretch, known, codes.KIND_NAMES[kind])
        except _NONSENSE as error:
            what = f"its track {part} ({error})"
            raise checksums.damaged(capture.id, capture.location, what) from error
    return tracks


def read_wanted(
    connection: Link,
    chosen: Sequence[Stored],
    parts: Sequence[str] | None = None,
    *,
    listed: bool = True,
) -> Tracks:
    """Return the tracks of captures, without their symbols: all, or those of some parts."""
    own = [(one.capture.id, one.capture.location, one.tracks) for one in chosen]
    numbers = [number for number, _, _ in own]
    if listed or parts is None:
        lists = _lists(connection, own, f"WHERE capture_id IN {among(numbers)}")
        if parts is not None:
            lists = [[row for row in held if row[_PART] in parts] for held in lists]
        place = np.repeat(np.arange(len(lists)), np.array(list(map(len, lists)), np.int64))
        found = list(chain.from_iterable(lists))
    else:
        found = _unlisted(connection, numbers, parts)
        place = np.searchsorted(numbers, [row[-1] for row in found])
    columns = list(zip(*found, strict=True)) or [()] * len(_LISTED)
    return Tracks(chosen, place, *columns[: len(_LISTED)])


def known_of(capture: Capture, part: str, known: str | None) -> tuple[Span, ...]:
    """Return the stretches of frames in which a part was seen, as its track has them."""
    try:
        return rows.read_known(known, capture.frames)
    except _NONSENSE as error:
        what = f"its track {part} ({error})"
        raise checksums.damaged(capture.id, capture.location, what) from error


def read_fields(connection: Link, wanted: Tracks, *, every: bool = False) -> NDArray[np.int64]:
    """Return the fields of the rows of tracks: (S, C) int64, in the order of `codes.COLUMNS`."""
    captures = [wanted.chosen[place].capture.id for place in dict.fromkeys(wanted.place.tolist())]
    if not captures:
        return np.empty((0, len(codes.COLUMNS)), np.int64)
    tracks = (wanted.ordinal, wanted.symbols, wanted.checksum)
    found = packed.read_fields(connection, captures, *tracks, every=every)
    return _checked(_numbers(connection, wanted), wanted)[:, 3:] if found is None else found


def _numbers(connection: Link, wanted: Tracks) -> NDArray[np.int64]:
    """Return the rows of tracks: (S, C + 3) int64, capture, track, row, fields; perhaps more."""
    locations = {one.id: one.location for one in wanted.owners}
    chosen = f"WHERE capture_id IN {among(locations)} AND track IN {among({*wanted.ordinal})}"
    found = ask(connection, f"{_CODES} {chosen} {_BY_KEY}").fetchall()
    if not found:
        return np.empty((0, len(codes.COLUMNS) + 3), np.int64)
    numbers = np.array(found)
    if numbers.dtype == np.int64:
        return numbers
    number, track = next(row[:2] for row in found if not all(isinstance(one, int) for one in row))
    what = f"its track number {track} holds what is no number"
    raise checksums.damaged(number, locations[number], what)


def _checked(numbers: NDArray[np.int64], wanted: Tracks) -> NDArray[np.int64]:
    """Return the rows of the tracks, one after the other, if they are what was stored."""
    keys = [(one.id, track) for one, track in zip(wanted.owners, wanted.ordinal, strict=True)]
    if len(numbers) != sum(wanted.symbols):
        own = {*keys}
        numbers = numbers[[key in own for key in map(tuple, numbers[:, :2].tolist())]]
    if (
        len(numbers) != sum(wanted.symbols)
        or not np.array_equal(numbers[:, :2], np.repeat(keys, wanted.symbols, axis=0))
        or rows.of_tracks(numbers[:, 1:], wanted.symbols) != [*wanted.checksum]
    ):
        raise _culprit(numbers, wanted)
    return numbers


def _culprit(numbers: NDArray[np.int64], wanted: Tracks) -> LibraryError:
    """Return the error that names the track whose rows are others, missing or too many."""
    columns = (wanted.owners, wanted.ordinal, wanted.part, wanted.symbols, wanted.checksum)
    for capture, ordinal, part, count, checksum in zip(*columns, strict=True):
        own = numbers[(numbers[:, 0] == capture.id) & (numbers[:, 1] == ordinal), 1:]
        if len(own) != count or rows.of_tracks(own, [len(own)]) != [checksum]:
            what = f"its track {part}"
            break
    return checksums.damaged(capture.id, capture.location, what)


def read_score(connection: Link, stored: Stored) -> Score:
    """Return the score of a capture."""
    capture = stored.capture
    ((packed, other),) = read_contents(connection, [stored])
    tracks = read_tracks(connection, [stored])[capture.id]
    heading = rows.unpacked_heading(packed)
    return Score(capture.rate, capture.frames, capture.meter, tracks, heading, other)


def read_contents(
    connection: Link, chosen: Sequence[Stored]
) -> Iterator[tuple[NDArray[Any], tuple[str, ...]]]:
    """Yield of captures the heading, still packed, and the lines that were not understood."""
    numbers = among(one.capture.id for one in chosen)
    asked = f"SELECT id, other, heading FROM capture WHERE id IN {numbers}"
    held = {number: (lines, blob) for number, lines, blob in ask(connection, asked)}
    what = "its heading or the lines that were not understood"
    for capture, *_, checksum in chosen:
        lines, blob = held[capture.id]
        if content(lines, blob) != checksum:
            raise checksums.damaged(capture.id, capture.location, what)
        try:
            yield rows.read_heading(blob), tuple(json.loads(lines))
        except _NONSENSE as error:
            raise checksums.damaged(capture.id, capture.location, f"{what} ({error})") from error


def content(other: Any, heading: Any) -> int | None:
    """Return the checksum of a capture's heading and of its other lines."""
    if not isinstance(heading, bytes) or not isinstance(other, str):
        return None
    return checksums.of_bytes(heading, other.encode("utf-8", "surrogatepass"))
