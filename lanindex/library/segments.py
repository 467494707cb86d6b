"""The columns and texts of captures: from segments, or from rows where they are in none.

A segment holds the columns of many captures, written once, never changed, checked when it is read:
a row of ``segment``, whose listing names its columns, and one row of ``segment_column`` for each of
them, whole numbers in as few bytes as the largest needs; or, in place of these rows, a file
(`lanindex.library.segment_files`). The listing has a checksum of its own and those of the columns.
`read_spine` lists the segments without loading their columns; damage leads to `Distrust`, and the
columns are made again of the rows.

Filters look at the texts of all captures, so segments hold them too: one list of JSON a column.
Counts of all that a segment holds are stored with it, for summaries.
Whoever changes a text marks the capture as not covered by its segment.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import MEASURES
from lanindex.errors import LibraryError
from lanindex.library import read, segment_files
from lanindex.library.connect import among, ask, faults, first_values, insert, is_damage, no_tick
from lanindex.library.dialect import MOST, Link
from lanindex.library.rows import bytes_checksum, checksum
from lanindex.library.segment_files import Distrust
from lanindex.library.selection import Texts
from lanindex.library.totals import Counting, Totals
from lanindex.model.columns import (
    EXTRA,
    ROSTER,
    Columns,
    Roster,
    columns_of_rows,
    enrolled,
    extras_of,
    has_amount,
    joined_columns,
    roster_of,
    seen_of,
)

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


BLOCK = 1 << 20
"""Bytes of a column that have a checksum of their own, so that a stretch of it can be checked."""


class Entry(NamedTuple):
    """A line of a segment's listing: a column."""

    part: str  # Whose; empty: the captures'
    name: str
    type: str  # As stored, as numpy writes it
    values: int
    checksum: int | tuple[int, ...]  # Of all of it, or of each `BLOCK`
    begin: int = 0  # The byte at which it begins in the segment's file

    @property
    def size(self) -> int:
        """How many bytes it takes."""
        return self.values * np.dtype(self.type).itemsize


class Segment(NamedTuple):
    """A segment before anything of it is loaded.

    One with a file can be read without the database, by any process that reaches the `place`.
    """

    id: int
    captures: int
    symbols: int
    entries: dict[tuple[str, str], Entry]  # By part and name
    file: str = ""  # The name of its file; empty: its columns are rows
    place: str = ""  # The folder or the URL where files of segments are

    @property
    def bytes(self) -> int:
        """The size of its file; 0: it has none."""
        ends = [one.begin + one.size for one in self.entries.values()]
        return max(ends, default=0) if self.file else 0

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
        return Spine([], {}, read.capture_numbers(connection))
    now = read.read_state(connection)
    if now.columns != now.stamp:
        raise Distrust("out of date, for another program has changed the library")
    with _distrusting_damage("the list of the segments"):
        place = segment_files.current_place(connection)
        asked = "SELECT id, captures, symbols, listing, checksum, file FROM segment ORDER BY id"
        segments = [_segment(place, *row) for row in ask(connection, asked)]
        asked = "SELECT capture_id, segment_id FROM segment_dead"
        dead = dict[int, int](ask(connection, asked).fetchall())
        asked = "SELECT capture_id FROM segment_pending ORDER BY capture_id"
        pending = first_values(ask(connection, asked))
    if not all(isinstance(one, int) for one in (*dead, *dead.values(), *pending)):
        raise Distrust("damaged: which captures they hold is no number")
    if not all(one.complete for one in segments):
        raise Distrust("made by an earlier version")
    return Spine(segments, dead, pending)


def _segment(
    place: str, number: int, captures: int, symbols: int, listing: str, content: int, file: Any
) -> Segment:
    if _row_checksum(captures, symbols, listing, file) != content:
        raise Distrust(f"damaged: the listing of segment {number}")
    entries = [Entry(*entry) for entry in json.loads(listing)]
    by_name = {(one.part, one.name): one for one in entries}
    for key, one in by_name.items():
        if isinstance(one.checksum, list):  # as JSON has it
            by_name[key] = one._replace(checksum=tuple(one.checksum))
    return Segment(number, captures, symbols, by_name, file or "", place)


def _row_checksum(captures: int, symbols: int, listing: str, file: Any) -> int:
    return checksum(captures, symbols, listing, *([] if file is None else [file]))


@contextmanager
def _distrusting_damage(what: str) -> Iterator[None]:
    """Turn an error of a damaged page into `Distrust`: the rows may lie on other pages."""
    try:
        yield
    except faults() as error:
        if not is_damage(error):
            raise
        raise Distrust(f"damaged: {what} cannot be read") from error


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


def read_column(
    connection: Link | None,
    segment: Segment,
    part: str,
    name: str,
    rows: tuple[int, int] | None = None,
) -> NDArray[Any]:
    """Return a column as it is stored, or some rows; empty where there is none of that name."""
    entry, width = segment.entries.get((part, name)), _WIDTHS.get((not part, name), 1)
    stored = np.empty(0, np.uint8)
    if entry is not None:
        what = f"{name} of {part or 'the captures'} in segment {segment.id}"
        type = np.dtype(entry.type)
        ends = (0, entry.values) if rows is None else (rows[0] * width, rows[1] * width)
        start, stop = (min(end, entry.values) * type.itemsize for end in ends)
        try:
            content = _content(connection, segment, entry, start, stop, what)
        except Distrust:
            if not (segment.file and segment_files.shelf_of(segment.place).forget(segment.file)):
                raise
            content = _content(connection, segment, entry, start, stop, what)
        stored = np.frombuffer(content, type)
    return stored if width == 1 else stored.reshape(-1, width)


def _content(
    connection: Link | None, segment: Segment, entry: Entry, start: int, stop: int, what: str
) -> NDArray[np.uint8]:
    """Return the bytes of a column from `start` to `stop`, checked: (N,) uint8."""
    whole, sums = entry.size, entry.checksum
    block = BLOCK if isinstance(sums, tuple) else max(whole, 1)
    sums = sums if isinstance(sums, tuple) else (sums,)
    first, last = start // block, -(-stop // block)
    begin, end = first * block, min(last * block, whole)
    if segment.file:
        ends = entry.begin + begin, entry.begin + end
        content = segment_files.shelf_of(segment.place).read(segment.file, *ends)
    else:
        content = _stored_content(connection, segment, entry, what)[begin:end]
    for number in range(first, last):
        at = number * block - begin
        if bytes_checksum(content[at : at + block].data) != sums[number]:
            raise Distrust(f"damaged: {what}{_in_file(segment)}")
    return content[start - begin : stop - begin]


def _stored_content(
    connection: Link | None, segment: Segment, entry: Entry, what: str
) -> NDArray[np.uint8]:
    """Return the bytes of a column that is a row: (N,) uint8."""
    assert connection is not None
    asked = (
        "SELECT content FROM segment_column "
        "WHERE segment_id = :segment AND part = :part AND name = :name"
    )
    values = {"segment": segment.id, "part": entry.part, "name": entry.name}
    with _distrusting_damage(what):
        (content,) = ask(connection, asked, values).fetchone() or (None,)
    if not isinstance(content, bytes) or len(content) != entry.size:
        raise Distrust(f"damaged: {what}")
    return np.frombuffer(content, np.uint8)


def _in_file(segment: Segment) -> str:
    return f" ({segment.place.rstrip('/')}/{segment.file})" if segment.file else ""


def check_files(spine: Spine) -> None:
    """Check that the files of segments are what their names say."""
    faults = []
    for one in spine.segments:
        if one.file:
            try:
                segment_files.shelf_of(one.place).check(one.file)
            except segment_files.Unreachable:
                raise
            except Distrust as fault:
                faults.append(fault.found.removeprefix("damaged: "))
    if faults:
        raise Distrust(f"damaged: {'; '.join(faults)}")


def read_roster(
    connection: Link | None,
    segment: Segment,
    captures: tuple[int, int] | None = None,
    tick: Callable[[], None] = no_tick,
) -> Roster:
    """Return the captures of a segment, dead ones too, or some as of `read_columns`."""
    columns = dict[str, NDArray[Any]]()
    for name in ROSTER:
        tick()
        columns[name] = read_column(connection, segment, "", name, captures)
    first, last = captures or (0, segment.captures)
    if {len(one) for one in columns.values()} != {last - first}:
        raise Distrust(f"damaged: the captures of segment {segment.id}")
    return Roster(*(columns[name].astype(type) for name, type in ROSTER.items()))


def read_counts(connection: Link | None, segment: Segment, part: str) -> NDArray[np.int64]:
    """Return how many symbols of a part each capture of a segment has, dead ones too."""
    if (part, "counts") not in segment.entries:
        return np.zeros(segment.captures, np.int64)
    counts = read_column(connection, segment, part, "counts").astype(np.int64)
    if len(counts) != segment.captures:
        raise Distrust(f"damaged: counts of {part} in segment {segment.id}")
    return counts


def read_columns(
    connection: Link | None,
    segment: Segment,
    part: str,
    more: Collection[str] = EXTRA,
    tick: Callable[[], None] = no_tick,
    captures: tuple[int, int] | None = None,
) -> Columns:
    """Return the columns of a part in the captures of a segment, dead ones too.

    `more` names which of `lanindex.model.columns.EXTRA` are wanted, too. `captures` are the places
    of the first capture that is wanted and of the first that is not; of the symbols of all others
    a file is not read. A segment that has one needs no connection.
    """
    names = ["cell", "runner", "margin", "start", "length"]
    names += ["amount"] * has_amount(part) + [name for name in extras_of(part) if name in more]
    bounds = np.concatenate([[0], read_counts(connection, segment, part)]).cumsum(dtype=np.int64)
    first, last = captures or (0, segment.captures)
    rows = None if captures is None else (int(bounds[first]), int(bounds[last]))
    held = dict[str, NDArray[Any]]()
    for name in names:
        tick()
        column = read_column(connection, segment, part, name, rows)
        held[name] = column.astype(_TYPES[name], copy=False)
    bounds = bounds[first : last + 1] - bounds[first]
    if {len(column) for column in held.values()} != {bounds[-1].item()}:
        raise Distrust(f"damaged: the columns of {part} are not of one length")
    seen = read_column(connection, segment, part, "gaps").astype(_TYPES["gaps"], copy=False)
    if captures is not None:
        begin, end = np.searchsorted(seen[:, 0], captures)
        seen = seen[begin:end] - np.array([first, 0, 0], np.int32)
    stop = held.pop("length") + held["start"]
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


def read_totals(connection: Link, segment: Segment) -> Totals | None:
    """Return the counts of a segment's captures, dead ones included; earlier versions had none."""
    content = read_column(connection, segment, "", "totals").tobytes()
    try:
        return Totals.unpacked(content) if content else None
    except (ValueError, TypeError, AttributeError) as error:  # It was stored so, with its checksum
        raise Distrust(f"damaged: the counts of segment {segment.id}") from error


def put(connection: Link, roster: Roster, texts: Texts, columns: Iterable[Columns]) -> None:
    """Write a segment."""
    begin = "INSERT INTO segment (captures, symbols, listing, checksum) VALUES (0, 0, '', 0)"
    ((number,),) = ask(connection, f"{begin} RETURNING id").fetchall()
    entries, symbols = list[Entry](), 0

    def parts() -> Iterator[tuple[str, Mapping[str, NDArray[Any]]]]:
        nonlocal symbols
        named: dict[str, NDArray[Any]] = {name: getattr(roster, name) for name in ROSTER}
        for name in TEXTS:
            text = json.dumps(list(texts[name]), ensure_ascii=False)
            named[name] = np.frombuffer(text.encode("utf-8", "surrogatepass"), np.uint8)
        yield "", named
        counting = Counting(roster, texts)
        for one in columns:
            if not one.blank:
                symbols += len(one)
                counting.add(one.part, np.diff(one.bounds), one.seen)
                yield one.part, _arrays(one)
        yield "", {"totals": np.frombuffer(counting.finished().packed(), np.uint8)}

    def contents() -> Iterator[tuple[str, str, memoryview]]:
        end = 0
        for part, arrays in parts():
            for name, array in arrays.items():
                stored = array.astype(_smallest_type(array), order="C", copy=False)
                content = stored.reshape(-1).view(np.uint8).data
                end, sums = segment_files.begin_of(end), _checksums(content)
                entries.append(Entry(part, name, stored.dtype.str, array.size, sums, end))
                end += len(content)
                yield part, name, content

    place = segment_files.current_place(connection)
    file = _keep(connection, place, number, contents())
    _describe(connection, number, len(roster), symbols, entries, file)


def _checksums(content: memoryview) -> int | tuple[int, ...]:
    """Return the checksums of a column's blocks; of one alone that of all of it."""
    begins = range(0, max(len(content), 1), BLOCK)
    sums = tuple(bytes_checksum(content[begin : begin + BLOCK]) for begin in begins)
    return sums if len(sums) > 1 else sums[0]


def _keep(
    connection: Link, place: str, number: int, contents: Iterable[tuple[str, str, memoryview]]
) -> str | None:
    """Write the columns of a segment, and return the name of their file; None: they are rows."""
    if place:
        return segment_files.shelf_of(place).write(content for *_, content in contents)
    names = ["segment_id", "part", "name", "content"]
    for part, name, content in contents:
        insert(connection, "segment_column", names, [(number, part, name, content)])
    return None


def _describe(
    connection: Link,
    number: int,
    captures: int,
    symbols: int,
    entries: Sequence[Entry],
    file: str | None,
) -> None:
    """Fill the row of a segment."""
    values: dict[str, Any] = {"captures": captures, "symbols": symbols}
    values |= {"listing": json.dumps(entries), "file": file}
    values |= {"checksum": _row_checksum(*values.values()), "id": number}
    changes = ", ".join([f"{name} = :{name}" for name in values])
    ask(connection, f"UPDATE segment SET {changes} WHERE id = :id", values)


def move(connection: Link, where: str) -> None:
    """Keep all columns in files at a place, or (empty) in the database; they stay as they are.

    Of none the old ones are dropped before the new file has been checked.
    """
    place = segment_files.absolute_place(connection, where) if where else ""
    written = list[str]()
    try:
        for one in read_spine(connection).segments:
            if (one.place if one.file else "") != place:
                _move_segment(connection, one, place, written)
    except BaseException:
        for name in written:
            with suppress(LibraryError):
                segment_files.shelf_of(place).remove(name)
        raise
    segment_files.set_place(connection, where)


def _move_segment(connection: Link, segment: Segment, place: str, written: list[str]) -> None:
    """Move the columns of a segment; `written` gets the name of their new file."""
    end, entries = 0, list[Entry]()
    for one in segment.entries.values():
        entries.append(one._replace(begin=segment_files.begin_of(end)))
        end = entries[-1].begin + one.size

    def contents() -> Iterator[tuple[str, str, memoryview]]:
        for part, name in segment.entries:
            content = read_column(connection, segment, part, name).reshape(-1)
            yield part, name, content.view(np.uint8).data

    file = _keep(connection, place, segment.id, contents())
    if file is not None:
        written.append(file)
        segment_files.shelf_of(place).check(file)
    _drop_contents(connection, [segment])
    _describe(connection, segment.id, segment.captures, segment.symbols, entries, file)


def _arrays(columns: Columns) -> dict[str, NDArray[Any]]:
    """Return the columns of a part that have anything in them."""
    arrays = {"counts": np.diff(columns.bounds)}
    for name in (*EXTRA, "amount", "cell", "runner", "margin", "start"):
        arrays[name] = getattr(columns, name)
    arrays |= {"length": columns.stop - columns.start, "gaps": columns.seen}
    return {name: array for name, array in arrays.items() if array is not None and array.size}


def _smallest_type(array: NDArray[Any]) -> np.dtype[Any]:
    """Return the smallest type that has room for all numbers of an array."""
    least, most = (int(array.min()), int(array.max())) if array.size else (0, 0)
    return next(one for one, room in _STORED if room.min <= least and most <= room.max)


def drop_part(connection: Link, segments: Iterable[Segment], part: str) -> None:
    """Delete the columns of a part (empty: of the captures) in some segments."""
    statement = "DELETE FROM segment_column WHERE segment_id = :segment AND part = :part"
    ask(connection, statement, [{"segment": one.id, "part": part} for one in segments])


def _drop_contents(connection: Link, segments: Sequence[Segment]) -> None:
    """Delete the columns of some segments; files go later, see `segment_files.collect`."""
    for one in segments:
        if one.file:
            segment_files.retire(connection, one.place, [one.file])
        else:
            statement = "DELETE FROM segment_column WHERE segment_id = :segment"
            ask(connection, statement, {"segment": one.id})


def drop(connection: Link, segments: Sequence[Segment]) -> None:
    """Delete some segments, and marks of dead captures that no segment holds any more."""
    _drop_contents(connection, segments)
    numbers = [{"segment": one.id} for one in segments]
    ask(connection, "DELETE FROM segment WHERE id = :segment", numbers)
    held = "SELECT 1 FROM segment WHERE id <= segment_dead.segment_id"
    ask(connection, f"DELETE FROM segment_dead WHERE NOT EXISTS ({held})")


def begin_anew(connection: Link) -> None:
    """Delete all segments, and mark all captures as pending."""
    stamp = read.read_state(connection).stamp
    files = first_values(ask(connection, "SELECT file FROM segment WHERE file IS NOT NULL"))
    segment_files.retire(connection, segment_files.current_place(connection), map(str, files))
    for table in ("segment_column", "segment", "segment_dead", "segment_pending"):
        ask(connection, f"DELETE FROM {table}")
    if numbers := read.capture_numbers(connection):
        insert(connection, "segment_pending", ["capture_id"], [(number,) for number in numbers])
    ask(connection, "UPDATE state SET columns = :stamp", {"stamp": stamp})


BATCH = 256
"""Captures read at a time."""


class Piece(NamedTuple):
    """Some captures of a library."""

    roster: Roster
    columns: dict[str, Columns]  # Of the parts that any of them has
    texts: Texts  # Empty where only some parts were read

    def at(self, places: NDArray[np.int64]) -> Piece:
        """Return some of the captures, by their places in the roster: (D,) int64."""
        columns = {part: one.at(places) for part, one in self.columns.items()}
        return Piece(self.roster.at(places), columns, joined_texts([self.texts], places))

    def same_as(self, other: Piece) -> bool:
        """Return whether captures, columns and texts are equal."""
        own, others = (
            {part: one for part, one in piece.columns.items() if not one.blank}
            for piece in (self, other)
        )
        return (
            self.roster.same_as(other.roster)
            and self.texts == other.texts
            and own.keys() == others.keys()
            and all(one.same_as(others[part]) for part, one in own.items())
        )


def batches(
    connection: Link,
    numbers: Sequence[int],
    parts: Sequence[str] | None = None,
    tick: Callable[[], None] = no_tick,
) -> Iterator[Piece]:
    """Yield captures from their rows, some at a time, by number: with all parts, or some."""
    for first in range(0, len(numbers), BATCH):
        tick()
        chosen = read.read_captures(connection, numbers[first : first + BATCH])
        tracks = read.read_track_rows(connection, chosen, parts)
        symbols = read.read_symbols(connection, tracks)
        yield of_rows(tracks, symbols, TEXTS if parts is None else ())


def together(pieces: Sequence[Piece]) -> Piece:
    """Join captures; the columns leave the pieces, which saves memory."""
    if len(pieces) == 1:
        return pieces[0]
    sizes = [len(one.roster) for one in pieces]
    columns = {
        part: joined_columns(part, [one.columns.pop(part, None) for one in pieces], sizes)
        for part in dict.fromkeys(part for one in pieces for part in one.columns)
    }
    roster = enrolled([one.roster for one in pieces])
    return Piece(roster, columns, joined_texts([one.texts for one in pieces]))


def of_rows(tracks: read.TrackRows, symbols: NDArray[Any], texts: Iterable[str] = TEXTS) -> Piece:
    """Return captures of which the rows of tracks and their symbols, (S,), have been read."""
    by_part, columns, first = tracks_by_part(tracks), dict[str, Columns](), 0
    codes = {part: code for code, part in enumerate(by_part)}
    few = np.min_scalar_type(len(codes))  # numpy sorts small numbers by counting
    whose = np.array([codes[part] for part in tracks.part], few)
    order = np.argsort(np.repeat(whose, np.array(tracks.symbols, np.int64)), kind="stable")
    symbols = symbols.take(order)  # by an index, numpy copies field by field
    for part, (counts, seen) in by_part.items():
        last = first + int(counts.sum())
        columns[part] = columns_of_rows(part, counts, symbols[first:last], seen)
        first = last
    roster = roster_of([one.capture for one in tracks.chosen])
    return Piece(roster, columns, texts_of(texts, tracks.chosen, tracks))


def tracks_by_part(
    tracks: read.TrackRows,
) -> dict[str, tuple[NDArray[np.int64], NDArray[np.int32]]]:
    """Return by part how many symbols each capture has, (C,), and `Columns.seen`, (G, 3)."""
    counts = {part: np.zeros(len(tracks.chosen), np.int64) for part in dict.fromkeys(tracks.part)}
    seen: dict[str, list[tuple[int, int, int]]] = {part: [] for part in counts}
    columns = (tracks.place.tolist(), tracks.part, tracks.symbols, tracks.known)
    for place, part, symbols, known in zip(*columns, strict=True):
        counts[part][place] = symbols
        if known is not None:
            capture = tracks.chosen[place].capture
            spans = seen_of(read.known_of(capture, part, known), capture.frames)
            seen[part] += [(place, *span) for span in spans]
    return {
        part: (counts[part], np.array(own, np.int32).reshape(-1, 3)) for part, own in seen.items()
    }


def read_all_columns(
    connection: Link,
    spine: Spine,
    wanted: Mapping[str, Collection[str]],
    tick: Callable[[], None] = no_tick,
    only: NDArray[np.int64] | None = None,
) -> tuple[Roster, dict[str, Columns]]:
    """Return all captures of a library, or only some, and the columns of the wanted parts.

    `wanted` names by part which of `lanindex.model.columns.EXTRA` are wanted, too. `tick` is
    called with each column that is read. `only` are the numbers of captures, (N,).
    """
    rosters, order = read_rosters(connection, spine, tick)
    added = together(list(batches(connection, spine.pending, list(wanted), tick)))
    check_pending(added.roster.number.tolist(), spine.pending)
    roster = enrolled([*rosters, added.roster])
    if only is not None:
        order = np.arange(len(roster)) if order is None else order
        order = order[np.isin(roster.number[order], only)]
    columns = {
        part: stored_columns(connection, spine.segments, part, order, more, added, tick)
        for part, more in wanted.items()
    }
    return roster if order is None else roster.at(order), columns


def stored_columns(
    connection: Link,
    stored_segments: Sequence[Segment],
    part: str,
    order: NDArray[np.int64] | None,
    more: Collection[str] = EXTRA,
    added: Piece | None = None,
    tick: Callable[[], None] = no_tick,
) -> Columns:
    """Return the columns of a part in captures of segments, then in those that are `added`.

    `order` selects and sorts the captures; None: all, dead ones too, as they come.
    """
    chosen, first = None if order is None else np.sort(order), 0
    pieces, sizes = list[Columns | None](), list[int]()

    def unread() -> Iterator[tuple[Callable[[], Columns] | None, int]]:
        for one in stored_segments:
            read_piece = partial(read_columns, connection, one, part, more, tick)
            yield read_piece if (part, "counts") in one.entries else None, one.captures
        if added is not None:
            spare: dict[str, Any] = {name: None for name in EXTRA if name not in more}
            last = added.columns.get(part)
            yield None if last is None else partial(replace, last, **spare), len(added.roster)

    for read_piece, captures in unread():
        places = np.arange(captures)
        if chosen is not None:
            begin, end = np.searchsorted(chosen, (first, first + captures))
            places = chosen[begin:end] - first
            first += captures
        piece = read_piece() if read_piece is not None and len(places) else None
        if piece is not None and len(places) < captures:
            piece = piece.at(places)  # the others leave the memory before the next are read
        pieces.append(piece)
        sizes.append(len(places))
    columns = joined_columns(part, pieces, sizes)
    if order is None or chosen is None or np.array_equal(chosen, order):
        return columns
    return columns.at(np.searchsorted(chosen, order))


def read_rosters(
    connection: Link, spine: Spine, tick: Callable[[], None] = no_tick
) -> tuple[list[Roster], NDArray[np.int64] | None]:
    """Return the captures of each segment, and the order of all as `order_of` returns it."""
    rosters = [read_roster(connection, one, tick=tick) for one in spine.segments]
    return rosters, checked_order(connection, spine, [one.number for one in rosters])


def checked_order(
    connection: Link, spine: Spine, numbers: Iterable[NDArray[np.int64]]
) -> NDArray[np.int64] | None:
    """Return the order of all captures by `order_of`; they must be those that there are.

    `numbers` are those of each segment's captures, dead ones included.
    """
    number = np.concatenate([*numbers, np.array(spine.pending, np.int64)])
    order = order_of(spine, number)
    number = number if order is None else number[order]
    stored = read.read_state(connection)
    if (len(number), int(number.sum())) != (stored.captures, stored.numbers) or (
        np.diff(number) <= 0
    ).any():
        raise Distrust("damaged: they are not those of the captures that there are")
    return order


def order_of(spine: Spine, numbers: NDArray[np.int64]) -> NDArray[np.int64] | None:
    """Return the places of the captures that are alive, by number; None: all, as they come."""
    ages = np.repeat(
        [one.id for one in spine.segments] + [1 << 62],
        [one.captures for one in spine.segments] + [len(spine.pending)],
    )
    alive = np.ones(len(numbers), np.bool_)
    if spine.dead:
        dead = np.array(sorted(spine.dead.items()), np.int64)
        places = np.searchsorted(dead[:, 0], numbers).clip(max=len(dead) - 1)
        alive = (dead[places, 0] != numbers) | (dead[places, 1] < ages)
    if alive.all() and (np.diff(numbers) > 0).all():
        return None
    order = np.flatnonzero(alive)
    return order[np.argsort(numbers[order], kind="stable")]


def alive(spine: Spine, segment: Segment, numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the places of the captures of a segment that are alive, by number."""
    order = order_of(Spine([segment], spine.dead, []), numbers)
    return np.arange(len(numbers)) if order is None else order


def check_pending(there: Sequence[int], pending: Sequence[int]) -> None:
    """Refuse a list of pending captures that differs from those that exist."""
    if list(there) != list(pending):
        raise Distrust("damaged: they wait for captures that there are not")


def read_all_texts(
    connection: Link, spine: Spine, names: Sequence[str]
) -> tuple[list[int], dict[str, list[Any]]]:
    """Return the numbers of all captures, in order, and their texts by name of the column."""
    rosters, order = read_rosters(connection, spine)
    pieces = [
        {"id": roster.number.tolist(), **read_texts(connection, one, names)}
        for one, roster in zip(spine.segments, rosters, strict=True)
    ]
    for first in range(0, len(spine.pending), MOST):
        numbers = spine.pending[first : first + MOST]
        chosen = read.read_captures(connection, numbers)
        check_pending([one.capture.id for one in chosen], numbers)
        pieces.append({"id": numbers, **texts_of(names, chosen)})
    texts = joined_texts([{name: () for name in ("id", *names)}, *pieces], order)
    return texts.pop("id"), texts


def joined_texts(
    pieces: Sequence[Texts], order: NDArray[np.int64] | None = None
) -> dict[str, list[Any]]:
    """Join the texts of pieces that have the same; `order` selects and sorts the captures."""
    names = pieces[0] if pieces else ()
    texts = {name: [value for piece in pieces for value in piece[name]] for name in names}
    if order is None:
        return texts
    places = order.tolist()
    return {name: [values[place] for place in places] for name, values in texts.items()}


def texts_of(
    names: Iterable[str], chosen: Sequence[read.Stored], tracks: read.TrackRows | None = None
) -> dict[str, list[Any]]:
    """Return texts of captures by name of the column; ``still`` needs all tracks of theirs."""
    texts: dict[str, list[Any]] = {}
    for name in names:
        if name == "profile":
            texts[name] = [one.encoding.profile for one in chosen]
        elif name == "still" and tracks is not None:
            texts[name] = [[] for _ in chosen]
            columns = (tracks.place.tolist(), tracks.part, tracks.symbols, tracks.known)
            for place, part, symbols, known in zip(*columns, strict=True):
                if symbols == 0 and known is None:
                    texts[name][place].append(part)
        else:
            texts[name] = [getattr(one.capture, name) for one in chosen]
    return texts
