"""Segments: the columns of many captures, written once, never changed, checked when they are read.

A segment is a row of ``segment``, whose listing names its columns, and one row of
``segment_column`` for each of them: whole numbers in as few bytes as the largest needs. The listing
has a checksum of its own and those of the columns. `read_spine` lists the segments without loading
their columns; damage leads to `Distrust`, and the columns are made again of the rows.

Filters look at the texts of all captures, so segments hold them too: one list of JSON a column.
Whoever changes a text marks the capture as not covered by its segment.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import MEASURES
from lanindex.errors import LibraryError
from lanindex.library.connect import (
    MOST,
    Link,
    among,
    ask,
    faults,
    first_values,
    insert,
    name_of,
)
from lanindex.library.read import capture_numbers, read_state
from lanindex.library.rows import bytes_checksum, checksum
from lanindex.library.selection import Texts
from lanindex.model.columns import EXTRA, ROSTER, Columns, Roster, extras_of, has_amount

_TYPES = {
    **{"counts": np.int64, "cell": np.uint8, "runner": np.uint8, "margin": np.uint16},
    **{"start": np.int32, "length": np.int32, "gaps": np.int32, "swings": np.int32},
    "amount": np.int16,
    **dict.fromkeys(MEASURES, np.uint16),
}
"""By the name of a stored column of a part, its type in memory; ``gaps`` is `Columns.seen`."""

_WIDTHS = {(True, "rate"): 2, (True, "speed"): 2, (False, "gaps"): 3}
"""Numbers in a row of a column that has several; by whether it is one of the captures."""

_STORED = tuple((np.dtype(name), np.iinfo(name)) for name in ("<u1", "<u2", "<u4", "<i8"))

TEXTS = ("path", "location", "format", "label", "metadata", "profile", "still")
"""What captures are called, which is JSON; by which profile they were written down (empty: by
none), and which parts were seen all the time and have no symbol."""


class Distrust(LibraryError):
    """The segments are not those of the rows; they must be made anew."""


class Entry(NamedTuple):
    """A line of a segment's listing: a column."""

    part: str  # Whose; empty: the captures'
    name: str
    type: str  # As stored, as numpy writes it
    values: int
    checksum: int


class Segment(NamedTuple):
    """A segment before anything of it is loaded."""

    id: int
    captures: int
    symbols: int
    entries: dict[tuple[str, str], Entry]  # By part and name

    @property
    def parts(self) -> list[str]:
        """The parts of which a capture has symbols or ranges in `Columns.seen`."""
        return list(dict.fromkeys(part for part, _ in self.entries if part))

    @property
    def complete(self) -> bool:
        """Whether it has all columns; segments of earlier versions lack some."""
        named = all(("", name) in self.entries for name in TEXTS)
        return named and all(
            (part, wanted) in self.entries
            for part, name in self.entries
            if name == "cell"
            for wanted in (*extras_of(part), *["amount"] * has_amount(part))
        )


class Spine(NamedTuple):
    """The segments of a library, and which captures they lack."""

    segments: list[Segment]
    dead: dict[int, int]  # By capture, the newest segment in which it does not count
    pending: list[int]  # Captures that are in no segment


def mark_changed(connection: Link, number: int, *, dead: bool = True, pending: bool = True) -> None:
    """Note that a capture has changed.

    If `dead`, what the segments hold of it does not count any more; if `pending`, another one is to
    hold it.
    """
    mark_covered(connection, [number])  # another program may have noted it already
    if dead:
        ask(connection, "DELETE FROM segment_dead WHERE capture_id = :number", {"number": number})
        newest = first_values(ask(connection, "SELECT max(id) FROM segment"))
        if newest != [None]:
            insert(connection, "segment_dead", ["capture_id", "segment_id"], [(number, *newest)])
    if pending:
        insert(connection, "segment_pending", ["capture_id"], [(number,)])


def mark_covered(connection: Link, numbers: Iterable[int]) -> None:
    """Note that a segment holds some captures now."""
    values = [{"number": number} for number in numbers]
    ask(connection, "DELETE FROM segment_pending WHERE capture_id = :number", values)


def read_spine(connection: Link, *, trusted: bool = True) -> Spine:
    """Return the segments, with nothing loaded; if they are not `trusted`, none."""
    if not trusted:
        return Spine([], {}, capture_numbers(connection))
    now = read_state(connection)
    if now.columns != now.stamp:
        raise Distrust("out of date, for another program has changed the library")
    with _distrusting_damage("the list of the segments"):
        asked = "SELECT id, captures, symbols, listing, checksum FROM segment ORDER BY id"
        segments = [_segment(row) for row in ask(connection, asked)]
        asked = "SELECT capture_id, segment_id FROM segment_dead"
        dead = dict[int, int](ask(connection, asked).fetchall())
        asked = "SELECT capture_id FROM segment_pending ORDER BY capture_id"
        pending = first_values(ask(connection, asked))
    if not all(isinstance(one, int) for one in (*dead, *dead.values(), *pending)):
        raise Distrust("damaged: which captures they hold is no number")
    if not all(one.complete for one in segments):
        raise Distrust("made by an earlier version")
    return Spine(segments, dead, pending)


def _segment(row: Any) -> Segment:
    number, captures, symbols, listing, content = row
    if checksum(captures, symbols, listing) != content:
        raise Distrust(f"damaged: the listing of segment {number}")
    entries = [Entry(*entry) for entry in json.loads(listing)]
    return Segment(number, captures, symbols, {(one.part, one.name): one for one in entries})


@contextmanager
def _distrusting_damage(what: str) -> Iterator[None]:
    """Turn an error of a damaged page into `Distrust`: the rows may lie on other pages."""
    try:
        yield
    except faults() as error:
        if not name_of(error).startswith("SQLITE_CORRUPT"):
            raise
        raise Distrust(f"damaged: {what} cannot be read") from error


def count_pending(connection: Link) -> int:
    """Return how many captures are in no segment."""
    return int(ask(connection, "SELECT count(*) FROM segment_pending").fetchone()[0])


def part_names(connection: Link) -> list[str]:
    """Return the parts that any capture has; with segments, also those that only dead ones have."""
    asked, names = "SELECT DISTINCT part FROM track", list[str]()
    with suppress(Distrust):  # Without segments all tracks are read, which takes longer
        spine = read_spine(connection)
        names = [name for one in spine.segments for name in one.parts]
        if len(spine.pending) <= MOST:
            asked += f" WHERE capture_id IN {among(spine.pending)}"
    names += first_values(ask(connection, asked))
    return [name for name in dict.fromkeys(names) if isinstance(name, str)]


def read_column(connection: Link, segment: Segment, part: str, name: str) -> NDArray[Any]:
    """Return a column as it is stored; empty where the segment has none of that name."""
    entry, width = segment.entries.get((part, name)), _WIDTHS.get((not part, name), 1)
    stored = np.empty(0, np.uint8)
    if entry is not None:
        what = f"{name} of {part or 'the captures'} in segment {segment.id}"
        asked = (
            "SELECT content FROM segment_column "
            "WHERE segment_id = :segment AND part = :part AND name = :name"
        )
        values = {"segment": segment.id, "part": part, "name": name}
        with _distrusting_damage(what):
            (content,) = ask(connection, asked, values).fetchone() or (None,)
        type = np.dtype(entry.type)
        if (
            not isinstance(content, bytes)
            or bytes_checksum(content) != entry.checksum
            or len(content) != entry.values * type.itemsize
        ):
            raise Distrust(f"damaged: {what}")
        stored = np.frombuffer(content, type)
    return stored if width == 1 else stored.reshape(-1, width)


def read_roster(connection: Link, segment: Segment) -> Roster:
    """Return the captures of a segment, dead ones too."""
    columns = {name: read_column(connection, segment, "", name) for name in ROSTER}
    if {len(one) for one in columns.values()} != {segment.captures}:
        raise Distrust(f"damaged: the captures of segment {segment.id}")
    return Roster(*(columns[name].astype(type) for name, type in ROSTER.items()))


def read_counts(connection: Link, segment: Segment, part: str) -> NDArray[np.int64]:
    """Return how many symbols of a part each capture of a segment has, dead ones too."""
    if (part, "counts") not in segment.entries:
        return np.zeros(segment.captures, np.int64)
    counts = read_column(connection, segment, part, "counts").astype(np.int64)
    if len(counts) != segment.captures:
        raise Distrust(f"damaged: counts of {part} in segment {segment.id}")
    return counts


def read_columns(
    connection: Link, segment: Segment, part: str, more: Collection[str] = EXTRA
) -> Columns:
    """Return the columns of a part in the captures of a segment, dead ones too.

    `more` names which of `lanindex.model.columns.EXTRA` are wanted, too.
    """
    names = ["cell", "runner", "margin", "start", "length", "gaps"]
    names += ["amount"] * has_amount(part) + [name for name in extras_of(part) if name in more]
    held = {
        name: read_column(connection, segment, part, name).astype(_TYPES[name], copy=False)
        for name in names
    }
    bounds = np.concatenate([[0], read_counts(connection, segment, part)]).cumsum(dtype=np.int64)
    if {len(column) for name, column in held.items() if name != "gaps"} != {bounds[-1].item()}:
        raise Distrust(f"damaged: the columns of {part} are not of one length")
    stop, seen = held.pop("length") + held["start"], held.pop("gaps")
    return Columns(part, bounds, stop=stop, seen=seen, **held)


def read_texts(connection: Link, segment: Segment, names: Iterable[str] = TEXTS) -> Texts:
    """Return the texts of a segment's captures, dead ones included."""
    texts: dict[str, Sequence[Any]] = {}
    for name in names:
        column, values = read_column(connection, segment, "", name), None
        with suppress(ValueError):  # It was stored so, with its checksum
            values = json.loads(column.tobytes())
        if not isinstance(values, list) or len(values) != segment.captures:
            raise Distrust(f"damaged: {name} of the captures in segment {segment.id}")
        texts[name] = values
    return texts


def put(connection: Link, roster: Roster, texts: Texts, columns: Iterable[Columns]) -> None:
    """Write a segment."""
    begin = "INSERT INTO segment (captures, symbols, listing, checksum) VALUES (0, 0, '', 0)"
    ((number,),) = ask(connection, f"{begin} RETURNING id").fetchall()
    named: dict[str, NDArray[Any]] = {name: getattr(roster, name) for name in ROSTER}
    for name in TEXTS:
        text = json.dumps(list(texts[name]), ensure_ascii=False)
        named[name] = np.frombuffer(text.encode("utf-8", "surrogatepass"), np.uint8)
    entries, symbols = _write_columns(connection, number, "", named), 0
    for one in columns:
        if not one.blank:
            entries += _write_columns(connection, number, one.part, _arrays(one))
            symbols += len(one)
    listing = json.dumps(entries)
    values = {"captures": len(roster), "symbols": symbols, "listing": listing}
    values |= {"checksum": checksum(*values.values()), "id": number}
    changes = ", ".join([f"{name} = :{name}" for name in values])
    ask(connection, f"UPDATE segment SET {changes} WHERE id = :id", values)


def _arrays(columns: Columns) -> dict[str, NDArray[Any]]:
    """Return the columns of a part that have anything in them."""
    arrays = {"counts": np.diff(columns.bounds)}
    for name in (*EXTRA, "amount", "cell", "runner", "margin", "start"):
        arrays[name] = getattr(columns, name)
    arrays |= {"length": columns.stop - columns.start, "gaps": columns.seen}
    return {name: array for name, array in arrays.items() if array is not None and array.size}


def _write_columns(
    connection: Link, segment: int, part: str, arrays: Mapping[str, NDArray[Any]]
) -> list[Entry]:
    entries, rows = [], []
    for name, array in arrays.items():
        stored = array.astype(_smallest_type(array), order="C", copy=False)
        content = stored.reshape(-1).view(np.uint8).data
        rows.append((segment, part, name, content))
        entries.append(Entry(part, name, stored.dtype.str, array.size, bytes_checksum(content)))
    insert(connection, "segment_column", ["segment_id", "part", "name", "content"], rows)
    return entries


def _smallest_type(array: NDArray[Any]) -> np.dtype[Any]:
    """Return the smallest type that has room for all numbers of an array."""
    least, most = (int(array.min()), int(array.max())) if array.size else (0, 0)
    return next(one for one, room in _STORED if room.min <= least and most <= room.max)


def drop_part(connection: Link, segments: Iterable[Segment], part: str) -> None:
    """Delete the columns of a part (empty: of the captures) in some segments."""
    statement = "DELETE FROM segment_column WHERE segment_id = :segment AND part = :part"
    ask(connection, statement, [{"segment": one.id, "part": part} for one in segments])


def drop(connection: Link, segments: Iterable[Segment]) -> None:
    """Delete some segments, and marks of dead captures that no segment holds any more."""
    numbers = [{"segment": one.id} for one in segments]
    ask(connection, "DELETE FROM segment_column WHERE segment_id = :segment", numbers)
    ask(connection, "DELETE FROM segment WHERE id = :segment", numbers)
    held = "SELECT 1 FROM segment WHERE id <= segment_dead.segment_id"
    ask(connection, f"DELETE FROM segment_dead WHERE NOT EXISTS ({held})")


def begin_anew(connection: Link) -> None:
    """Delete all segments, and mark all captures as pending."""
    stamp = read_state(connection).stamp
    for table in ("segment_column", "segment", "segment_dead", "segment_pending"):
        ask(connection, f"DELETE FROM {table}")
    if numbers := capture_numbers(connection):
        insert(connection, "segment_pending", ["capture_id"], [(number,) for number in numbers])
    ask(connection, "UPDATE state SET columns = :stamp", {"stamp": stamp})
