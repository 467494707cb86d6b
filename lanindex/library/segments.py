"""Segments: the columns of many captures, written once, never changed, never simply believed.

A segment is a row of ``segment``, whose listing names its columns, and one row of
``segment_column`` for each of them: whole numbers in as few bytes as the largest needs. The listing
has a checksum of its own and those of the columns. `read_spine` tells what there is without
loading any; whatever does not fit leads to `Distrust`, and the columns are made again of the rows.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import MEASURES
from lanindex.errors import LibraryError
from lanindex.library import checksums, state
from lanindex.library.link import Link, among, ask, faults, first_values
from lanindex.model.columns import EXTRA, Columns, Roster, extras_of, has_amount

CAPTURES = {"number": np.int64, "frames": np.int32, "rate": np.int64, "speed": np.int64}
"""By the name of a column of the captures, its type in memory."""

TYPES = {
    **{"counts": np.int64, "cell": np.uint8, "runner": np.uint8, "margin": np.uint16},
    **{"start": np.int32, "length": np.int32, "gaps": np.int32, "swings": np.int32},
    "amount": np.int16,
    **dict.fromkeys(MEASURES, np.uint16),
}
"""The same of a column of a part."""

_WIDTHS = {(True, "rate"): 2, (True, "speed"): 2, (False, "gaps"): 3}
"""Numbers in a row of it, where that is not one; by whether it is the captures'."""

_STORED = tuple((np.dtype(name), np.iinfo(name)) for name in ("<u1", "<u2", "<u4", "<i8"))

_MOST = 500
"""Values in one statement: databases take a thousand at least."""

TEXTS = ("path", "location", "format", "label", "metadata", "profile", "still")
"""What captures are called, which is JSON; by which profile they were written down (empty: by
none), and which parts were seen all the time and have no symbol."""


class Distrust(LibraryError):
    """The segments are not what the rows would give; make them anew."""


class Entry(NamedTuple):
    """A line of a segment's listing: a column."""

    part: str
    """Whose; empty: the captures'."""
    name: str
    type: str
    """As stored, as numpy writes it."""
    values: int
    checksum: int


class Segment(NamedTuple):
    """A segment before anything of it is loaded."""

    id: int
    captures: int
    symbols: int
    entries: dict[tuple[str, str], Entry]
    """By part and name."""

    @property
    def parts(self) -> list[str]:
        """The parts of which any of its captures has symbols, or that one does not always see."""
        return list(dict.fromkeys(part for part, _ in self.entries if part))

    @property
    def complete(self) -> bool:
        """Whether it has all columns: what an earlier version wrote lacks some."""
        named = all(("", name) in self.entries for name in TEXTS)
        return named and all(
            (part, wanted) in self.entries
            for part, name in self.entries
            if name == "cell"
            for wanted in (*extras_of(part), *["amount"] * has_amount(part))
        )


class Spine(NamedTuple):
    """What there is of columns."""

    segments: list[Segment]
    dead: dict[int, int]
    pending: list[int]


_SEGMENTS = "SELECT id, captures, symbols, listing, checksum FROM segment ORDER BY id"
_DEAD = "SELECT capture_id, segment_id FROM segment_dead"
_PENDING = "SELECT capture_id FROM segment_pending ORDER BY capture_id"
_PARTS = "SELECT DISTINCT part FROM track"
_CONTENT = (
    "SELECT content FROM segment_column "
    "WHERE segment_id = :segment AND part = :part AND name = :name"
)
_BEGIN = (
    "INSERT INTO segment (captures, symbols, listing, checksum) VALUES (:captures, 0, '', 0) "
    "RETURNING id"
)
_STORE = (
    "INSERT INTO segment_column (segment_id, part, name, content) "
    "VALUES (:segment, :part, :name, :content)"
)
_LIST = (
    "UPDATE segment SET symbols = :symbols, listing = :listing, checksum = :checksum "
    "WHERE id = :segment"
)
_DROP_PART = "DELETE FROM segment_column WHERE segment_id = :segment AND part = :part"
_DROP_COLUMNS = "DELETE FROM segment_column WHERE segment_id = :segment"
_DROP = "DELETE FROM segment WHERE id = :segment"
_FORGET = (
    "DELETE FROM segment_dead WHERE NOT EXISTS "
    "(SELECT 1 FROM segment WHERE id <= segment_dead.segment_id)"
)
_RAISE = "DELETE FROM segment_dead WHERE capture_id = :number"
_DIE = (
    "INSERT INTO segment_dead (capture_id, segment_id) "
    "SELECT :number, newest FROM (SELECT max(id) AS newest FROM segment) AS own "
    "WHERE newest IS NOT NULL"
)
_WAIT = "INSERT INTO segment_pending (capture_id) VALUES (:number)"
_COVER = "DELETE FROM segment_pending WHERE capture_id = :number"
_ALL = ("segment_column", "segment", "segment_dead", "segment_pending")


def mark_pending(connection: Link, number: int) -> None:
    """Note that a capture is not in any segment yet."""
    for statement in (_COVER, _WAIT):  # another program may have said so
        ask(connection, statement, {"number": number})


def mark_dead(connection: Link, number: int) -> None:
    """Note that what the segments hold of a capture does not count any more."""
    for statement in (_COVER, _RAISE, _DIE):
        ask(connection, statement, {"number": number})


def mark_changed(connection: Link, number: int) -> None:
    """Note that a segment is to hold a capture that has changed in place of what they hold now."""
    mark_dead(connection, number)
    mark_pending(connection, number)


def mark_covered(connection: Link, numbers: Iterable[int]) -> None:
    """Note that a segment holds captures now."""
    ask(connection, _COVER, [{"number": number} for number in numbers])


def read_spine(connection: Link) -> Spine:
    """Return what there is of columns, with nothing loaded."""
    now = state.read_state(connection)
    if now.columns != now.stamp:
        raise Distrust("out of date, for another program has changed the library")
    with _readable("the list of the segments"):
        found = [_segment(row) for row in ask(connection, _SEGMENTS)]
        dead = dict[int, int](ask(connection, _DEAD).fetchall())
        pending = first_values(ask(connection, _PENDING))
    if not all(isinstance(one, int) for one in (*dead, *dead.values(), *pending)):
        raise Distrust("damaged: which captures they hold is no number")
    if not all(one.complete for one in found):
        raise Distrust("made by an earlier version")
    return Spine(found, dead, pending)


@contextmanager
def _readable(what: str) -> Iterator[None]:
    """Distrust what lies on a damaged page: the rows may lie on others."""
    try:
        yield
    except faults() as error:
        origin = getattr(error, "orig", error)
        if not getattr(origin, "sqlite_errorname", "").startswith("SQLITE_CORRUPT"):
            raise
        raise Distrust(f"damaged: {what} cannot be read") from error


def count_pending(connection: Link) -> int:
    """Return how many captures are in no segment."""
    return int(ask(connection, "SELECT count(*) FROM segment_pending").fetchone()[0])


def part_names(connection: Link) -> list[str]:
    """Return the parts whose columns any capture fills; and filled, as long as segments tell."""
    asked, found = _PARTS, list[str]()
    try:
        spine = read_spine(connection)
    except Distrust:
        pass  # the tracks tell, which takes longer
    else:
        found = [name for one in spine.segments for name in one.parts]
        if len(spine.pending) <= _MOST:
            asked = f"{_PARTS} WHERE capture_id IN {among(spine.pending)}"
    found += first_values(ask(connection, asked))
    return [name for name in dict.fromkeys(found) if isinstance(name, str)]


def _segment(row: Any) -> Segment:
    number, captures, symbols, listing, checksum = row
    if checksums.of_values(captures, symbols, listing) != checksum:
        raise Distrust(f"damaged: the listing of segment {number}")
    entries = [Entry(*entry) for entry in json.loads(listing)]
    return Segment(number, captures, symbols, {(one.part, one.name): one for one in entries})


def read_column(connection: Link, segment: Segment, part: str, name: str) -> NDArray[Any]:
    """Return a column as it is stored; empty where the segment has none of that name."""
    entry, width = segment.entries.get((part, name)), _WIDTHS.get((not part, name), 1)
    stored = np.empty(0, np.uint8)
    if entry is not None:
        what = f"{name} of {part or 'the captures'} in segment {segment.id}"
        asked = {"segment": segment.id, "part": part, "name": name}
        with _readable(what):
            (content,) = ask(connection, _CONTENT, asked).fetchone() or (None,)
        type = np.dtype(entry.type)
        if (
            not isinstance(content, bytes)
            or checksums.of_bytes(content) != entry.checksum
            or len(content) != entry.values * type.itemsize
        ):
            raise Distrust(f"damaged: {what}")
        stored = np.frombuffer(content, type)
    return stored if width == 1 else stored.reshape(-1, width)


def put(
    connection: Link,
    roster: Roster,
    texts: Iterable[tuple[str, NDArray[np.uint8]]],
    columns: Iterable[Columns],
) -> int:
    """Write a segment and return its number."""
    ((number,),) = ask(connection, _BEGIN, {"captures": len(roster)}).fetchall()
    symbols = 0
    own = [(name, getattr(roster, name)) for name in CAPTURES]
    entries = _put(connection, number, "", [*own, *texts])
    for one in columns:
        if not one.blank:
            entries += _put(connection, number, one.part, _arrays(one))
            symbols += len(one)
    listing = json.dumps(entries)
    checksum = checksums.of_values(len(roster), symbols, listing)
    values = {"symbols": symbols, "listing": listing, "checksum": checksum}
    ask(connection, _LIST, {"segment": number, **values})
    return int(number)


def _arrays(columns: Columns) -> list[tuple[str, NDArray[Any]]]:
    """Return the columns of a part that have anything in them."""
    found = [("counts", np.diff(columns.bounds))]
    names = (*EXTRA, "amount", "cell", "runner", "margin", "start")
    found += [(name, getattr(columns, name)) for name in names]
    found += [("length", columns.stop - columns.start), ("gaps", columns.gaps)]
    return [(name, array) for name, array in found if array is not None and array.size]


def _put(
    connection: Link, segment: int, part: str, arrays: Sequence[tuple[str, NDArray[Any]]]
) -> list[Entry]:
    entries, values = [], []
    for name, array in arrays:
        stored = array.astype(_smallest(array), order="C", copy=False)
        content = stored.reshape(-1).view(np.uint8).data
        row = {"segment": segment, "part": part, "name": name, "content": content}
        values.append(row)
        checksum = checksums.of_bytes(content)
        entries.append(Entry(part, name, stored.dtype.str, array.size, checksum))
    ask(connection, _STORE, values)
    return entries


def _smallest(array: NDArray[Any]) -> np.dtype[Any]:
    """Return the smallest type that has room for all numbers of an array."""
    least, most = (int(array.min()), int(array.max())) if array.size else (0, 0)
    return next(one for one, room in _STORED if room.min <= least and most <= room.max)


def drop_part(connection: Link, segments: Iterable[Segment], part: str) -> None:
    """Delete the columns of a part (empty: of the captures) in some segments."""
    ask(connection, _DROP_PART, [{"segment": one.id, "part": part} for one in segments])


def drop(connection: Link, segments: Iterable[Segment]) -> None:
    """Delete some segments, and the marks that speak of none any more."""
    for one in segments:
        for statement in (_DROP_COLUMNS, _DROP):
            ask(connection, statement, {"segment": one.id})
    ask(connection, _FORGET)


def begin_anew(connection: Link) -> None:
    """Delete all segments; every capture is to be put into one."""
    stamp = state.read_state(connection).stamp
    for table in _ALL:
        ask(connection, f"DELETE FROM {table}")
    numbers = state.capture_numbers(connection)
    if numbers:
        ask(connection, _WAIT, [{"number": number} for number in numbers])
    ask(connection, "UPDATE state SET columns = :stamp", {"stamp": stamp})
