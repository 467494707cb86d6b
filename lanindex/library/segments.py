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
from sqlalchemy import (
    BindParameter,
    Connection,
    bindparam,
    delete,
    func,
    insert,
    literal,
    select,
    update,
)
from sqlalchemy.exc import DatabaseError

from lanindex.errors import LibraryError
from lanindex.library import checksums, schema, state
from lanindex.model.columns import Columns, Roster

TYPES = {"number": np.int64, "frames": np.int32, "rate": np.int64, "speed": np.int64} | {
    **{"counts": np.int64, "cell": np.uint8, "runner": np.uint8, "margin": np.uint16},
    **{"start": np.int32, "length": np.int32, "gaps": np.int32, "swings": np.int32},
}
"""By the name of a column, its type in memory."""

_WIDTHS = {"rate": 2, "speed": 2, "gaps": 3}
"""Numbers in a row of it, where that is not one."""

_STORED = tuple(np.dtype(name) for name in ("<u1", "<u2", "<u4", "<i8"))

_MOST = 500
"""Values in one statement: databases take a thousand at least."""

CAPTURES = ("number", "frames", "rate", "speed")
TEXTS = ("path", "location", "format", "label", "metadata")
"""The columns of the captures: numbers, and what they are called, which is JSON."""

OLD = "made by an earlier version"
"""What is wrong with segments that lack a column."""


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
        """The parts that any of its captures has."""
        return list(dict.fromkeys(part for part, _ in self.entries if part))

    @property
    def complete(self) -> bool:
        """Whether it has all columns: what an earlier version wrote lacks some."""
        named = all(("", name) in self.entries for name in TEXTS)
        return named and all(
            (part, "swings") in self.entries for part, name in self.entries if name == "cell"
        )


class Spine(NamedTuple):
    """What there is of columns.

    Attributes
    ----------
    segments : list of Segment
        The oldest first.
    dead : dict of int to int
        By capture, the newest segment in which it does not count.
    pending : list of int
        The captures that no segment holds, in order.
    """

    segments: list[Segment]
    dead: dict[int, int]
    pending: list[int]


_ID: BindParameter[int] = bindparam("segment")
_NUMBER: BindParameter[int] = bindparam("number")
_STORE = schema.segment_column.c
_SEGMENTS = select(schema.segment).order_by(schema.segment.c.id)
_DEAD = select(schema.segment_dead.c.capture_id, schema.segment_dead.c.segment_id)
_PENDING = select(schema.segment_pending.c.capture_id).order_by(schema.segment_pending.c.capture_id)
_COUNT = select(func.count()).select_from(schema.segment_pending)
_CONTENT = select(_STORE.content).where(
    _STORE.segment_id == _ID, _STORE.part == bindparam("part"), _STORE.name == bindparam("name")
)
_STORE_COLUMNS = insert(schema.segment_column)
_LIST = update(schema.segment).where(schema.segment.c.id == _ID)
_DROP_PART = delete(schema.segment_column).where(
    _STORE.segment_id == _ID, _STORE.part == bindparam("part")
)
_DROP_COLUMNS = delete(schema.segment_column).where(_STORE.segment_id == _ID)
_DROP = delete(schema.segment).where(schema.segment.c.id == _ID)
_RAISE = delete(schema.segment_dead).where(schema.segment_dead.c.capture_id == _NUMBER)
_DIE = insert(schema.segment_dead).from_select(
    ["capture_id", "segment_id"],
    select(literal(0) + _NUMBER, func.max(schema.segment.c.id)).having(
        func.max(schema.segment.c.id).is_not(None)
    ),
)
_WAIT = insert(schema.segment_pending)
_COVER = delete(schema.segment_pending).where(schema.segment_pending.c.capture_id == _NUMBER)


def mark_pending(connection: Connection, number: int) -> None:
    """Note that a capture is not in any segment yet."""
    connection.execute(_COVER, {"number": number})  # another program may have said so
    connection.execute(_WAIT, {"capture_id": number})


def mark_dead(connection: Connection, number: int) -> None:
    """Note that what the segments hold of a capture does not count any more."""
    for statement in (_COVER, _RAISE, _DIE):
        connection.execute(statement, {"number": number})


def mark_changed(connection: Connection, number: int) -> None:
    """Note that a segment is to hold a capture that has changed in place of what they hold now."""
    mark_dead(connection, number)
    mark_pending(connection, number)


def mark_covered(connection: Connection, numbers: Iterable[int]) -> None:
    """Note that a segment holds captures now."""
    connection.execute(_COVER, [{"number": number} for number in numbers])


def read_spine(connection: Connection) -> Spine:
    """Return what there is of columns, with nothing loaded.

    Raises
    ------
    Distrust
        If they are out of date, or not what was stored.
    """
    now = state.read_state(connection)
    if now.columns != now.stamp:
        raise Distrust("out of date, for another program has changed the library")
    with _readable("the list of the segments"):
        found = [_segment(row) for row in connection.execute(_SEGMENTS)]
        dead = {number: last for number, last in connection.execute(_DEAD)}
        pending = list(connection.scalars(_PENDING))
    if not all(isinstance(one, int) for one in (*dead, *dead.values(), *pending)):
        raise Distrust("damaged: which captures they hold is no number")
    return Spine(found, dead, pending)


@contextmanager
def _readable(what: str) -> Iterator[None]:
    """Distrust what lies on a damaged page: the rows may lie on others."""
    try:
        yield
    except DatabaseError as error:
        if not getattr(error.orig, "sqlite_errorname", "").startswith("SQLITE_CORRUPT"):
            raise
        raise Distrust(f"damaged: {what} cannot be read") from error


def count_pending(connection: Connection) -> int:
    """Return how many captures are in no segment."""
    return int(connection.scalar(_COUNT) or 0)


def part_names(connection: Connection) -> list[str]:
    """Return the names of all parts that any capture has; and had, as long as segments tell."""
    part, number = schema.track.c.part, schema.track.c.capture_id
    asked, found = select(part).distinct(), list[str]()
    try:
        spine = read_spine(connection)
    except Distrust:
        pass  # the tracks tell, which takes longer
    else:
        found = [name for one in spine.segments for name in one.parts]
        if len(spine.pending) <= _MOST:
            asked = asked.where(number.in_(spine.pending))
    found += connection.scalars(asked)
    return [name for name in dict.fromkeys(found) if isinstance(name, str)]


def _segment(row: Any) -> Segment:
    told = (row.captures, row.symbols, row.listing)
    if checksums.of_values(*told) != row.checksum:
        raise Distrust(f"damaged: the listing of segment {row.id}")
    entries = [Entry(*entry) for entry in json.loads(row.listing)]
    return Segment(
        row.id, row.captures, row.symbols, {(one.part, one.name): one for one in entries}
    )


def read_column(connection: Connection, segment: Segment, part: str, name: str) -> NDArray[Any]:
    """Return a column as it is stored; empty where the segment has none of that name.

    Raises
    ------
    Distrust
        If it is not what was stored.
    """
    entry, width = segment.entries.get((part, name)), _WIDTHS.get(name, 1)
    stored = np.empty(0, np.uint8)
    if entry is not None:
        what = f"{name} of {part or 'the captures'} in segment {segment.id}"
        asked = {"segment": segment.id, "part": part, "name": name}
        with _readable(what):  # straight from the driver: whatever else it is, it becomes no bytes
            (content,) = connection.execute(_CONTENT, asked).cursor.fetchone() or (None,)
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
    connection: Connection,
    roster: Roster,
    texts: Iterable[tuple[str, NDArray[np.uint8]]],
    columns: Iterable[Columns],
) -> int:
    """Write a segment and return its number.

    Parameters
    ----------
    connection : Connection
        In a transaction that may write.
    roster : Roster
        The captures.
    texts : iterable of (str, ndarray)
        What they are called, as `lanindex.library.called.spelled` gives it.
    columns : iterable of Columns
        Of all parts that any of them has; each is written before the next is asked for.
    """
    unlisted = {"captures": len(roster), "symbols": 0, "listing": "", "checksum": 0}
    key = connection.execute(insert(schema.segment), unlisted).inserted_primary_key
    number, symbols = int(key[0]) if key else 0, 0
    own = [(name, getattr(roster, name)) for name in CAPTURES]
    entries = _put(connection, number, "", [*own, *texts])
    for one in columns:
        entries += _put(connection, number, one.part, _arrays(one))
        symbols += len(one)
    listing = json.dumps(entries)
    checksum = checksums.of_values(len(roster), symbols, listing)
    told = {"symbols": symbols, "listing": listing, "checksum": checksum}
    connection.execute(_LIST, {"segment": number, **told})
    return number


def _arrays(columns: Columns) -> list[tuple[str, NDArray[Any]]]:
    """Return the columns of a part that have anything in them."""
    found = [("counts", np.diff(columns.bounds)), ("swings", columns.swings)]
    found += [(name, getattr(columns, name)) for name in ("cell", "runner", "margin", "start")]
    found += [("length", columns.stop - columns.start), ("gaps", columns.gaps)]
    return [(name, array) for name, array in found if array is not None and array.size]


def _put(
    connection: Connection, segment: int, part: str, arrays: Sequence[tuple[str, NDArray[Any]]]
) -> list[Entry]:
    entries, values = [], []
    for name, array in arrays:
        stored = array.astype(_smallest(array), order="C", copy=False)
        content = stored.reshape(-1).view(np.uint8).data
        row = {"segment_id": segment, "part": part, "name": name, "content": content}
        values.append(row)
        checksum = checksums.of_bytes(content)
        entries.append(Entry(part, name, stored.dtype.str, array.size, checksum))
    connection.execute(_STORE_COLUMNS, values)
    return entries


def _smallest(array: NDArray[Any]) -> np.dtype[Any]:
    """Return the smallest type that has room for all numbers of an array."""
    least, most = (int(array.min()), int(array.max())) if array.size else (0, 0)
    ranges = ((one, np.iinfo(one)) for one in _STORED)
    return next(one for one, room in ranges if room.min <= least and most <= room.max)


def drop_part(connection: Connection, segments: Iterable[Segment], part: str) -> None:
    """Delete the columns of a part (empty: of the captures) in some segments."""
    connection.execute(_DROP_PART, [{"segment": one.id, "part": part} for one in segments])


def drop(connection: Connection, segments: Iterable[Segment]) -> None:
    """Delete some segments, and the marks that speak of none any more."""
    for one in segments:
        connection.execute(_DROP_COLUMNS, {"segment": one.id})
        connection.execute(_DROP, {"segment": one.id})
    oldest = select(func.coalesce(func.min(schema.segment.c.id), 1 << 62)).scalar_subquery()
    connection.execute(delete(schema.segment_dead).where(schema.segment_dead.c.segment_id < oldest))


def begin_anew(connection: Connection) -> None:
    """Delete all segments; every capture is to be put into one."""
    stamp = state.read_state(connection).stamp
    for table in (
        schema.segment_column,
        schema.segment,
        schema.segment_dead,
        schema.segment_pending,
    ):
        connection.execute(delete(table))
    numbers = state.capture_numbers(connection)
    if numbers:
        connection.execute(_WAIT, [{"capture_id": number} for number in numbers])
    connection.execute(update(schema.state).values(columns=stamp))
