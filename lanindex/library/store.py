"""The library: captures and their scores in a database.

``with Store.open("dance.db", create=True) as store: store.add(...)`` is one transaction a capture:
whatever breaks off, the library holds whole captures or none.
"""

import json
import os
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from itertools import islice, repeat
from typing import Any, Self

import numpy as np

from lanindex.alphabet import TRACKS
from lanindex.errors import AbsentError, LibraryError, UsageError
from lanindex.library import read, rows, segments
from lanindex.library.cache import ColumnCache
from lanindex.library.connect import (
    DEFAULT,
    Session,
    ask,
    dialect_of,
    first_values,
    insert,
    no_tick,
    target,
)
from lanindex.library.dialect import MOST, Link
from lanindex.library.rows import Encoding
from lanindex.library.selection import (
    ALL,
    Selection,
    Texts,
    absolute,
    check_description,
    check_text,
    is_gone,
    is_number,
    printable,
    selected,
    texts_needed,
)
from lanindex.library.stats import Stats, count
from lanindex.model import Capture, Score, Span, Track
from lanindex.model.columns import Columns, Roster

_BATCH = 256
"""Captures read at a time by `Store.tracks`."""

_COUNT = "UPDATE state SET captures = captures + :more, numbers = numbers + :more * :one"
_TOUCH = (  # The stamp of the columns follows if they were up to date
    "UPDATE state SET stamp = stamp + 1, "
    "columns = CASE WHEN columns = stamp THEN stamp + 1 ELSE columns END "
    f"WHERE stamp BETWEEN 0 AND {1 << 31} RETURNING id"  # Neither text nor bytes nor NULL
)
_FORGET_PROFILES = (
    "DELETE FROM profile WHERE NOT EXISTS "
    "(SELECT 1 FROM capture WHERE capture.profile_id = profile.id)"
)


class Store:
    """Captures and their scores in a database. Made by `open`; serves several threads.

    A capture is named by its number, or by its path: as ingested, absolute, or the end of it.
    """

    def __init__(self, session: Session) -> None:
        self.session, self.cache = session, ColumnCache(session)

    @classmethod
    def open(cls, named: str | os.PathLike[str] = DEFAULT, **options: Any) -> Self:
        """Open a library with options of `Session`, which keeps notes unless there is `note`."""
        return cls(Session(target(named), **options))

    def __repr__(self) -> str:
        return f"<Store {self.place}>"

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the database."""
        self.session.close()

    @property
    def place(self) -> str:
        """The library as it was named."""
        return self.session.target.place

    def stamp(self) -> int:
        """Return the number that changes with every change."""
        with self.session.reading() as connection:
            return read.read_state(connection).stamp

    def capture_count(self) -> int:
        """Return how many captures there are, without reading any."""
        with self.session.reading() as connection:
            return read.read_state(connection).captures

    def check_writable(self) -> None:
        """Refuse a library that this user may not change, before the work whose result it keeps."""
        with self.session.writing() as connection:
            ask(connection, "UPDATE state SET stamp = stamp WHERE id IS NULL")

    @contextmanager
    def changing(self) -> Iterator[Link]:
        """Begin a transaction that changes what the library holds, and raise its change stamp."""
        with self.session.writing() as connection:
            if len(ask(connection, _TOUCH).fetchall()) != 1:
                read.read_state(connection)  # Raises with the content of the state
                raise LibraryError("the library's stamp cannot be raised", wanted="a number from 0")
            yield connection

    def add(
        self,
        path: str | os.PathLike[str],
        score: Score,
        *,
        format: str,
        sha256: str,
        encoding: Encoding | None = None,
        label: str | None = None,
        metadata: Mapping[str, str] | None = None,
        warnings: Sequence[str] = (),
    ) -> int:
        """Store a score, in place of an earlier one of the same path, and return its number."""
        shown, encoding = printable(os.fspath(path)), encoding or Encoding()
        location = absolute(path)
        check_text(shown, [format, sha256, encoding.profile, *score.tracks])
        check_description(shown, label, metadata)
        rows.check(score, shown)
        values = {
            "path": shown,
            "location": location,
            "format": format,
            "sha256": sha256,
            "warnings": json.dumps(list(warnings)),
        }
        with self.changing() as connection:
            number, new = put_capture(connection, values, score, encoding)
            lost = describe(connection, number, label, metadata, new)
        if lost:
            self.session.note(f"{shown}: its label or metadata were damaged, and are gone")
        return number

    def label(
        self, which: int | str, label: str | None = None, metadata: Mapping[str, str] | None = None
    ) -> bool:
        """Change what the user says of a capture; its score stays."""
        return bool(self.describe([(which, label, metadata)]))

    def describe(
        self, changes: Iterable[tuple[int | str, str | None, Mapping[str, str] | None]]
    ) -> list[int]:
        """Change what the user says of captures, all or none, and return which have changed."""
        changed: dict[int, tuple[str | None, Mapping[str, str] | None]] = {}
        for which, label, metadata in changes:
            check_description(self.place, label, metadata)
            before = self.capture(which)
            if label not in (None, before.label) or metadata not in (None, before.metadata):
                changed[before.id] = label, metadata
        if changed:
            with self.changing() as connection:
                for number, (label, metadata) in changed.items():
                    describe(connection, number, label, metadata)
        return list(changed)

    def move(self, which: int | str, path: str | os.PathLike[str], version: str = "") -> None:
        """Change where a capture's file is, and its version there; all else stays."""
        shown = printable(os.fspath(path))
        with self.changing() as connection:
            stored = self._stored(connection, which)
            number, encoding = stored.capture.id, replace(stored.encoding, version=version)
            facts, profile = read.encoded_of(connection, number)
            values = {"path": shown, "location": absolute(path), "options": _options(encoding)}
            checksum = rows.encoded_checksum({**facts, **values}, *profile)
            _update_capture(connection, number, {**values, "checksum": checksum})
            segments.mark_changed(connection, number)

    def remove(self, *which: int | str) -> None:
        """Take captures out of the library; none where one of them is not there."""
        with self.changing() as connection:
            for number in {self._number(connection, one) for one in which}:
                _delete_rows(connection, number, "symbol_code", "track", "metadata")
                ask(connection, "DELETE FROM capture WHERE id = :number", {"number": number})
                ask(connection, _COUNT, {"more": -1, "one": number})
                segments.mark_changed(connection, number, pending=False)
                ask(connection, _FORGET_PROFILES)

    def missing(self) -> list[Capture]:
        """Return the captures whose file is no longer where it was ingested."""
        return [capture for capture in self.captures() if is_gone(capture.location)]

    def known(self) -> dict[str, tuple[str, Encoding]]:
        """Return what need not be encoded again: by absolute path, sha256 and encoding.

        In the order of the captures; one that is damaged is left out.
        """
        with self.session.reading() as connection:
            return {
                one.capture.location: (one.capture.sha256, one.encoding)
                for one in read.read_stored(connection)
                if isinstance(one, read.Stored)
            }

    def captures(self, selection: Selection = ALL) -> list[Capture]:
        """Return the selected captures, in the order in which they came."""
        with self.session.reading() as connection:
            stored = read.read_captures(connection, progress=self.session.progress)
        captures = [one.capture for one in stored]
        names = texts_needed(selection)
        texts = {name: [getattr(capture, name) for capture in captures] for name in names}
        return [captures[place] for place in selected(selection, texts, len(captures))]

    def each(self, numbers: Iterable[int] | None = None) -> Iterator[Capture]:
        """Yield some captures, by number, or all, in order; few of them are in memory."""
        if numbers is None:
            with self.session.reading() as connection:
                numbers = read.capture_numbers(connection)
        wanted = sorted(set(numbers))
        for first in range(0, len(wanted), MOST):
            some = wanted[first : first + MOST]
            with self.session.reading() as connection:
                chosen = read.read_captures(connection, some)
                if len(chosen) < len(some):  # Raises if captures are lost
                    read.capture_numbers(connection)
            self.session.progress("captures", first + len(some), len(wanted))
            for one in chosen:
                yield one.capture

    def numbers(self, selection: Selection = ALL) -> list[int] | None:
        """Return the numbers of the selected captures, without reading each; None: all."""
        if not selection.globs:
            return None
        with self.session.reading() as connection:
            numbers, texts = self.cache.texts(connection, texts_needed(selection))
        return [numbers[place] for place in selected(selection, texts, len(numbers))]

    def texts(self, name: str, numbers: Iterable[int] | None = None) -> dict[int, Any]:
        """Return a text of some captures or all by their numbers, without reading each capture.

        `name` is ``path``, ``location``, ``format``, ``label``, ``metadata`` or ``profile``.
        """
        with self.session.reading() as connection:
            every, texts = self.cache.texts(connection, [name])
        by_number = dict(zip(every, texts[name], strict=True))
        if numbers is None:
            return by_number
        try:
            return {number: by_number[number] for number in numbers}
        except KeyError as error:
            raise LibraryError(
                f"there is no capture {error.args[0]} any more",
                place=self.place,
                remedy="Search again: the library has changed since.",
            ) from None

    def paths_starting(self, text: str, most: int) -> list[str]:
        """Return up to `most` paths that begin with a text, or whose file name does, in order."""
        escaped = re.sub(r"([\\%_])", r"\\\1", text)
        asked = "SELECT path FROM capture WHERE path LIKE :begun ESCAPE :mark"
        asked += " OR path LIKE :name ESCAPE :mark ORDER BY path"
        values = {"begun": f"{escaped}%", "name": f"%{os.sep}{escaped}%", "mark": "\\"}
        with self.session.reading() as connection:
            held = ask(connection, asked, values)
            begun = (
                path
                for (path,) in held
                if path.startswith(text) or os.path.basename(path).startswith(text)
            )
            return list(islice(begun, most))

    def captures_numbered(self, numbers: Sequence[int]) -> list[Capture]:
        """Return those captures that exist of some numbers, in the order of the numbers."""
        wanted = sorted(set(numbers))
        with self.session.reading() as connection:
            return [
                one.capture
                for first in range(0, len(wanted), MOST)
                for one in read.read_captures(connection, wanted[first : first + MOST])
            ]

    def capture(self, which: int | str) -> Capture:
        """Return one capture."""
        with self.session.reading() as connection:
            return self._stored(connection, which).capture

    def encoding(self, which: int | str) -> Encoding:
        """Return how a capture was read and written down."""
        with self.session.reading() as connection:
            return self._stored(connection, which).encoding

    def located(self, places: Sequence[str], digests: Sequence[str]) -> list[str]:
        """Return where captures lie that are at one of these places, or have such a sha256."""
        locations: list[str] = []
        with self.session.reading() as connection:
            for column, values in (("location", places), ("sha256", digests)):
                for first in range(0, len(values), MOST):
                    some = {f"v{at}": one for at, one in enumerate(values[first : first + MOST])}
                    chosen = ", ".join(f":{name}" for name in some)
                    asked = f"SELECT location FROM capture WHERE {column} IN ({chosen})"
                    locations += first_values(ask(connection, asked, some))
        return locations

    def tracks(
        self,
        captures: Iterable[int] | None = None,
        parts: Iterable[str] | None = None,
        *,
        listed: bool = True,
    ) -> Iterator[tuple[Capture, dict[str, Track]]]:
        """Yield each capture with its tracks, in the order of their numbers."""
        only = None if parts is None else list(parts)
        if captures is not None:
            numbers = sorted({int(one) for one in captures if is_number(one)})
        else:
            with self.session.reading() as connection:
                numbers = read.capture_numbers(connection)
        for first in range(0, len(numbers), _BATCH):
            some = numbers[first : first + _BATCH]
            with self.session.reading() as connection:
                chosen = read.read_captures(connection, some)
                if len(chosen) < len(some):  # Raises if captures are lost
                    read.capture_numbers(connection)
                tracks = read.read_tracks(connection, chosen, only, listed=listed)
            for one in chosen:
                yield one.capture, tracks[one.capture.id]

    def score(self, which: int | str) -> Score:
        """Return the score of a capture, field by field as it was stored."""
        with self.session.reading() as connection:
            stored = self._stored(connection, which)
            ((heading, other),) = read.read_contents(connection, [stored])
            tracks = read.read_tracks(connection, [stored])[stored.capture.id]
        rate, frames, meter = stored.capture.rate, stored.capture.frames, stored.capture.meter
        return Score(rate, frames, meter, tracks, heading, other)

    def stretch(
        self, which: int | str, frames: Span, parts: Sequence[str] | None = None
    ) -> tuple[Score, dict[str, int]]:
        """Return what a score holds in a stretch, and by track which of its rows is the first.

        It has the frames of the whole, and no heading.
        """
        with self.session.reading() as connection:
            stored = self._stored(connection, which)
            tracks, firsts = read.read_stretch(connection, stored, frames, parts)
        capture = stored.capture
        return Score(capture.rate, capture.frames, capture.meter, tracks), firsts

    def counts(self, which: int | str) -> dict[str, int]:
        """Return how many rows each track of a capture has."""
        with self.session.reading() as connection:
            rows = read.read_track_rows(connection, [self._stored(connection, which)])
        return dict(zip(rows.part, rows.symbols, strict=True))

    def parts(self, *, checked: bool = True, tick: Callable[[], None] = no_tick) -> list[str]:
        """Return the parts that any capture has, in the order of the alphabet."""
        with self.session.reading() as connection:
            if checked:
                held = self.cache.checked_parts(connection, tick)
            else:
                held = set(segments.part_names(connection))
        return [part for part in TRACKS if part in held] + sorted(held.difference(TRACKS))

    def check_parts(self, named: Iterable[str]) -> None:
        """Refuse a part that neither the alphabet nor any capture has."""
        for part in named:
            if part not in TRACKS and part not in (held := self.parts(checked=False)):
                wanted = f"one of {' '.join(dict.fromkeys((*TRACKS, *held)))}"
                raise UsageError(f'"{part}"', place="--part", wanted=wanted)

    def columns(
        self,
        parts: Iterable[str],
        numbers: Iterable[int] | None = None,
        *,
        more: Collection[str] = (),
        tick: Callable[[], None] = no_tick,
        kept: bool = True,
    ) -> tuple[Roster, dict[str, Columns]]:
        """Return captures and what some parts do in them, as columns.

        They come from the library's segments, which are mended where they are damaged, and all are
        kept while the library is open, even if only some captures are wanted; if not `kept`, those
        of the others never are in memory. A part that no capture has gets columns without rows.
        `tick` is called with each column that is read, and may raise.
        """
        chosen = None if numbers is None else np.array(sorted(set(numbers)), np.int64)
        only = None if kept else chosen
        roster, columns = self.cache.columns(list(dict.fromkeys(parts)), more, tick, only)
        if chosen is None:
            return roster, columns
        order = np.flatnonzero(np.isin(roster.number, chosen))
        return roster.at(order), {part: one.at(order) for part, one in columns.items()}

    def stats(self) -> Stats:
        """Count what the library holds."""
        with self.session.reading() as connection:
            size = dialect_of(connection).size(connection)
            return self.cache.trusting(connection, lambda spine: count(connection, spine, size))

    def _stored(self, connection: Link, which: int | str) -> read.Stored:
        number = self._number(connection, which)
        captures = read.read_captures(connection, [number])
        if len(captures) != 1:  # The table has it, but its index does not
            raise rows.damaged(number, None, "its row")
        return captures[0]

    def _number(self, connection: Link, which: int | str) -> int:
        """Return the number of a capture that is there, damaged or not."""
        if isinstance(which, str):
            named = printable(which)
            for fitting in _matches_of_name(connection, named):
                if len(fitting) == 1:
                    return fitting[0][0]
                if fitting:
                    locations = [location for _, location in fitting]
                    raise LibraryError(
                        f"{len(locations)} captures are called {named}",
                        place=self.place,
                        remedy=f"Name one: {_joined_names(locations)}",
                    )
            # not kept: what this transaction has changed may be undone
            every = partial(segments.read_all_texts, connection, names=("path", "location"))
            _, texts = self.cache.trusting(connection, every)
            raise _absent_error(named, texts, self.place)
        if is_number(which) and read.read_numbers(connection, [int(which)]):
            return int(which)
        raise _absent_error(str(which), {"path": [], "location": []}, self.place)


def _matches_of_name(connection: Link, name: str) -> Iterator[list[tuple[int, str]]]:
    """Yield the captures that a name fits, one way after the other: number and location of each.

    Their path is this name, their absolute path is, it ends with this name, their number is this.
    The first two are looked up in an index; the third goes through the index of locations.
    """
    tail, number = os.sep + name, int(name) if name.isascii() and name.isdigit() else 0
    ways: tuple[tuple[str, str | int], ...] = (
        ("path = :one", name),
        ("location = :one", absolute(name)),
        (f"substr(location, length(location) - {len(tail) - 1}) = :one", tail),
        ("id = :one", number if str(number) == name and is_number(number) else -1),
    )
    for way, one in ways:
        asked = f"SELECT id, location FROM capture WHERE {way}"
        yield sorted(ask(connection, asked, {"one": one}))  # sorted by SQL, it would scan the table


def _absent_error(name: str, texts: Texts, place: str) -> AbsentError:
    """Return the error that a name means no capture, with those that have one like it."""
    from rapidfuzz import process

    pairs = zip(texts["location"], texts["path"], strict=True)
    paths = {os.path.basename(location): path for location, path in pairs}
    near = process.extract(os.path.basename(name), list(paths), limit=3, score_cutoff=60)
    remedy = "All are shown by: lanindex list"
    if near:
        remedy = f"Did you mean {_joined_names([paths[file_name] for file_name, _, _ in near])}?"
    return AbsentError(f"there is no capture {name}", place=place, remedy=remedy)


def _joined_names(names: Sequence[str], most: int = 3) -> str:
    return ", ".join(names[:most]) + (" …" if len(names) > most else "")


def put_capture(
    connection: Link, values: Mapping[str, Any], score: Score, encoding: Encoding
) -> tuple[int, bool]:
    """Write a capture and its score, in place of those of the same location.

    Return its number, and whether it is new.
    """
    tracks, symbols, listing = rows.rows_of(score)
    profile = {"name": encoding.profile, "digest": encoding.digest} if encoding.digest else {}
    meter, other = score.meter, json.dumps(score.other)
    heading = rows.pack_heading(score.heading)
    values = {
        **values,
        "fps": float(score.rate),
        "rate": str(score.rate),
        "frames": int(score.frames),
        "speed": str(meter.speed),
        "beats": int(meter.beats),
        "beat": int(meter.beat),
        "division": int(meter.division),
        "other": other,
        "heading": heading,
        "profile_id": _profile(connection, profile) if profile else None,
        "options": _options(encoding),
        "tracks": listing,
        "content": read.content_checksum(other, heading),
    }
    values["checksum"] = rows.encoded_checksum(values, profile.get("name"), profile.get("digest"))
    asked = "SELECT id FROM capture WHERE location = :location"
    held = ask(connection, asked, {"location": values["location"]}).fetchone()
    if held is None:
        number = _insert(connection, "capture", {"label": "", "said": -1, **values})
        ask(connection, _COUNT, {"more": 1, "one": number})
    else:
        number = int(held[0])
        _delete_rows(connection, number, "symbol_code", "track")
        _update_capture(connection, number, values)
        ask(connection, _FORGET_PROFILES)
    segments.mark_changed(connection, number, dead=held is not None)
    numbered = [(number, *row) for row in tracks]
    insert(connection, "track", ("capture_id", *rows.TRACK), numbered)
    names = ("capture_id", "track", "ordinal", *rows.COLUMNS)
    insert(connection, "symbol_code", names, list(zip(repeat(number), *symbols)))
    return number, held is None


def describe(
    connection: Link,
    number: int,
    label: str | None,
    metadata: Mapping[str, str] | None,
    new: bool = False,
) -> bool:
    """Write label and metadata of a capture; None leaves what is stored, unless that is damaged.

    Return whether something was lost so.
    """
    held, lost = dict[str, str](), False
    if not new:
        key = {"number": number}
        asked = "SELECT label, said FROM capture WHERE id = :number"
        before, checksum = ask(connection, asked, key).fetchone()
        asked = "SELECT key, value FROM metadata WHERE capture_id = :number"
        held = dict(ask(connection, asked, key).fetchall())
        if read.description_checksum(number, before, held) != checksum:
            lost = label is None or metadata is None
            label, metadata = label or "", metadata or {}  # What was stored is damaged
        if label is None and metadata is None:
            return lost
        label = before if label is None else label
        if metadata is not None:
            _delete_rows(connection, number, "metadata")
    if metadata is not None:
        held = {str(key): str(value) for key, value in metadata.items()}
        described = [(number, *pair) for pair in held.items()]
        insert(connection, "metadata", ("capture_id", "key", "value"), described)
    label = str(label or "")
    checksum = read.description_checksum(number, label, held)
    _update_capture(connection, number, {"label": label, "said": checksum})
    if not new:
        segments.mark_changed(connection, number)
    return lost


def _options(encoding: Encoding) -> str:
    return json.dumps(encoding.facts(), sort_keys=True)


def _profile(connection: Link, values: Mapping[str, str]) -> int:
    """Return the number of a profile, written if it is new."""
    asked = "SELECT id FROM profile WHERE name = :name AND digest = :digest"
    held = ask(connection, asked, values).fetchone()
    return int(held[0]) if held else _insert(connection, "profile", values)


def _delete_rows(connection: Link, number: int, *tables: str) -> None:
    for table in tables:
        ask(connection, f"DELETE FROM {table} WHERE capture_id = :number", {"number": number})


def _update_capture(connection: Link, number: int, values: Mapping[str, Any]) -> None:
    changes = ", ".join([f"{name} = :{name}" for name in values])
    change = f"UPDATE capture SET {changes} WHERE id = :number"
    ask(connection, change, {"number": number, **values})


def _insert(connection: Link, table: str, values: Mapping[str, Any]) -> int:
    columns = f"({', '.join(values)}) VALUES ({', '.join([f':{name}' for name in values])})"
    ((number,),) = ask(connection, f"INSERT INTO {table} {columns} RETURNING id", values).fetchall()
    return int(number)
