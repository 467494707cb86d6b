"""Rows of numbers in text: headers, rows and cells; the motion and the clips that tables make.

A cell that is blank, or says ``nan``, is unknown.
"""

import csv
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.body import Declared
from lanindex.errors import CaptureError, quoted
from lanindex.formats import decimals
from lanindex.formats.decimals import LARGEST
from lanindex.formats.file import (
    Content,
    File,
    Wanted,
    clip,
    holding,
    line_of,
    text_of,
)
from lanindex.formats.points import Points, gathered, motion_of, spread
from lanindex.formats.rates import rate_by
from lanindex.model import Motion, Reading, Span

BLOCK = 4096
"""Rows whose numbers are held at a time."""

MOST = 1e18
"""No number is larger: ticks of 100 ns since the year 1 are not."""

BLANKS = b" "
"""As a separator: any number of blanks stands for one."""

NOTHING = b" \t\r\n,;\xef\xbb\xbf"
"""A line of these alone says nothing: blanks, separators, the mark of an encoding."""

_PIECE = 1 << 17  # bytes looked through at a time
_OPENS = np.isin(np.arange(256), list(b"0123456789+-."))
_COMMA = bytes.maketrans(b",", b".")

Lines = NDArray[np.int64]
Floats = NDArray[np.float64]
Finish = Callable[[NDArray[Any]], NDArray[Any]]
"""Makes points, (T, M, 3), of others."""


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """Where the numbers of a table lie."""

    lines: Lines  # (T, 2) int64, first byte of each row, and the one behind its line's end
    separator: bytes  # stands between cells; `BLANKS`: any number of them
    width: int  # columns: what a row has beyond them is blank
    heads: tuple[int, ...]  # columns of frame numbers, times, states
    points: tuple[int, ...]  # (3 M) columns of x, y, z of each point
    comma: bool = False  # whether a comma stands in numbers where a point would

    @property
    def columns(self) -> tuple[int, ...]:
        """All that are read."""
        return self.heads + self.points


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """A table before its numbers are read, and what its header says of them."""

    names: tuple[str, ...]  # (M) its points
    table: Table
    time: int | None = None  # which of the heads is the time, if there is one
    tick: float | None = 1.0  # seconds in one unit of it; None: found from how fast it grows
    rate: str = ""  # frames a second, as the file says; empty where it does not
    declared: Declared = field(default_factory=Declared)  # what it says of its unit and axes
    doubts: tuple[str, ...] = ()  # what its header gets wrong
    # the first of the heads that tell of each point whether it was seen: 0, not
    states: int | None = None
    finish: Finish | None = None  # what makes the points of what the table has instead
    rate_line: str = ""  # the line of the header that says the rate, for messages: ``:3``
    # bytes of the number of frames in the header; empty where it has none
    count: tuple[int, int] = (0, 0)


def rows(data: Content, first: int) -> Lines:
    """Return the lines, (T, 2), that are not blank, nor hold separators alone."""
    stop = len(data)
    end = newline(data[first : first + _PIECE])[0]
    found, doubtful = [np.zeros(0, np.int64)], [np.zeros(0, bool)]
    behind = True
    for start in range(first, stop, _PIECE):
        until = min(start + _PIECE, stop)
        held, begin = holding(data, start, until)
        text = np.frombuffer(held, np.uint8)[start - begin : until - begin]
        ends = text == end
        opens = np.flatnonzero(np.append(behind, ends[:-1]))
        behind = bool(ends[-1])
        found.append(opens + start)
        doubtful.append(~_OPENS[text[opens]])
    starts = np.concatenate(found)
    lines = np.stack((starts, np.append(starts[1:], stop)[: len(starts)]), axis=1)
    doubts = np.flatnonzero(np.concatenate(doubtful)).tolist()
    blank = [row for row in doubts if not data[lines[row, 0] : lines[row, 1]].strip(NOTHING)]
    return np.delete(lines, blank, axis=0) if blank else lines


def newline(head: bytes) -> bytes:
    """Return what ends the lines of a text: a carriage return where nothing else does."""
    return b"\r" if b"\r" in head and b"\n" not in head else b"\n"


def read(file: File, table: Table) -> tuple[Floats, NDArray[np.float32]]:
    """Read the numbers of a table: its heads, (T, H), and places, (T, M, 3)."""
    lines = table.lines
    needed = max(table.columns)  # as many separators stand in a row at least
    short = np.flatnonzero(lines[:, 1] - lines[:, 0] < needed)
    if len(short):  # before anything is allocated for them
        raise _damage(file, table, int(short[0]))
    heads = np.empty((len(lines), len(table.heads)))
    points = np.empty((len(lines), len(table.points)), np.float32)
    for start in range(0, len(lines), BLOCK):
        block = lines[start : start + BLOCK]
        data, at = _held(file.content, block)
        if table.comma:
            data, at = data[at[0, 0] : at[-1, 1]].translate(_COMMA), at - at[0, 0]
        values, bad = parse(data, at, table)
        if bad is not None:
            raise _damage(file, table, start + bad)
        heads[start : start + BLOCK] = values[:, : len(table.heads)]
        points[start : start + BLOCK] = values[:, len(table.heads) :]
    places = points.reshape(len(lines), -1, 3)
    places[np.isnan(places).any(axis=2)] = np.nan
    return heads, places


def _held(content: Content, lines: Lines) -> tuple[bytes, Lines]:
    """Return bytes that hold some lines, and where these are in them."""
    first, stop = int(lines[0, 0]), int(lines[-1, 1])
    if stop - first > 2 * int((lines[:, 1] - lines[:, 0]).sum()):
        return gathered(content, lines)
    data, begin = holding(content, first, stop)
    return data, lines - begin


def at_origin(places: NDArray[np.float32], names: Sequence[str]) -> tuple[str, ...]:
    """Take places, (T, M, 3), of 0, 0, 0 for unknown, as some programs write it."""
    zero = (places == 0).all(axis=2)
    # a point that lies there always may be what all others are measured from
    zero &= ~(zero | np.isnan(places[..., 0])).all(axis=0)
    if not zero.any():
        return ()
    places[zero] = np.nan
    gone = [names[index] for index in np.flatnonzero(zero.any(axis=0)).tolist()]
    most = ", ".join(gone[:3]) + (f" and {len(gone) - 3} others" if len(gone) > 3 else "")
    count = np.count_nonzero(zero.any(axis=1))
    return (f"{most} at 0, 0, 0 in {count} frames: taken as unknown",)


def read_motion(
    file: File,
    layout: Layout,
    form: str,
    options: Reading,
    wanted: Wanted,
    chosen: Sequence[int] | None = None,
) -> Motion:
    """Read the motion of a table's points, or of the chosen ones."""
    table = layout.table
    if wanted.frames is not None:
        table = replace(table, lines=table.lines[spread(wanted, len(table.lines))])
    heads, places = read(file, table)
    places = layout.finish(places) if layout.finish else places
    if layout.states is not None:
        places[heads[:, layout.states :] == 0] = np.nan
    names = layout.names
    if chosen is not None and len(chosen) < len(names):
        names, places = tuple(names[number] for number in chosen), places[:, chosen]
    gone = at_origin(places, names)
    times, unsure = _seconds(layout, heads)
    rate, uneven = rate_by(options, file.name + layout.rate_line, layout.rate, times)
    unsure = unsure if options.rate is None else ()
    doubts = (*layout.doubts, *unsure, *uneven, *gone)
    points = Points(names, places, rate, layout.declared, doubts=doubts)
    return motion_of(points, file, form, options, wanted)


_CLOCKS = (("seconds", 1.0), ("milliseconds", 1e-3), ("microseconds", 1e-6),
          ("units of 100 ns", 1e-7), ("nanoseconds", 1e-9))  # fmt: skip
_USUAL_STEP = (0.002, 0.2)  # seconds between frames


def _seconds(layout: Layout, heads: Floats) -> tuple[Floats, tuple[str, ...]]:
    """Return the times in seconds; where their unit is unknown, in the usual one."""
    if layout.time is None:
        return np.zeros(0), ()
    times = heads[:, layout.time]
    if layout.tick is not None:
        return times * layout.tick, ()
    steps = np.diff(times)
    steps = steps[np.isfinite(steps)]
    step = float(np.median(steps)) if len(steps) else 0.0
    for name, tick in _CLOCKS:
        if _USUAL_STEP[0] <= step * tick <= _USUAL_STEP[1]:
            doubt = () if tick == 1 else (f"its times are taken for {name}",)
            return (times - times[0]) * tick, doubt
    return times, ()


def cutter(file: File, layout: Layout) -> Callable[[Span], bytes]:
    """Return what cuts clips out of a table: its bytes, but for the number of frames."""
    lines, (before, after) = layout.table.lines, layout.count

    def cut(span: Span) -> bytes:
        count = str(len(span)).encode() if after > before else b""
        frames = int(lines[span.start, 0]), int(lines[span.stop - 1, 1])
        return clip(file.content, ((0, before), count, (after, int(lines[0, 0])), frames))

    return cut


def points_of(motion: Motion) -> tuple[tuple[str, ...], NDArray[np.float32]]:
    """Return what a table of a motion shows: its markers, where it has them, or else its joints."""
    if motion.markers is not None:
        return motion.markers.names, motion.markers.positions
    return motion.skeleton.names, motion.positions


def parse(data: bytes, lines: Lines, table: Table) -> tuple[Floats, int | None]:
    """Read rows by their lines, (T, 2): values, (T, C), and the first damaged row."""
    values = np.empty((len(lines), len(table.columns)))
    read = decimals.fill(values, data, lines, table.separator, table.columns, table.width)
    bad = len(lines)
    for row in np.flatnonzero(~read).tolist():
        first, stop = lines[row].tolist()
        if not _fill(values[row], data[first:stop], table):
            bad = row
            break
    limits = np.full(values.shape[1], LARGEST)
    limits[: len(table.heads)] = MOST
    large = (np.abs(values[:bad]) > limits).any(axis=1)
    bad = int(large.argmax()) if large.any() else bad
    return values, bad if bad < len(lines) else None


def _fill(values: Floats, line: bytes, table: Table) -> bool:
    """Read a row, NaN where a cell is blank; return whether it holds what it should."""
    cells = cells_of(line, table.separator)
    if len(cells) > table.width and any(map(bytes.strip, cells[table.width :])):
        return False
    try:
        wanted = [cells[column] for column in table.columns]
        try:
            values[:] = list(map(float, wanted))
        except ValueError:
            values[:] = [float(cell.strip() or b"nan") for cell in wanted]
    except (ValueError, IndexError):
        return False
    # float() lets 1_0 pass
    return not (b"_" in line and any(b"_" in cell for cell in wanted))


def cells_of(line: bytes, separator: bytes) -> list[bytes]:
    """Cut a line into its cells."""
    return line.split(None if separator == BLANKS else separator)


def _damage(file: File, table: Table, row: int) -> CaptureError:
    """Say what is wrong with a row."""
    first, stop = table.lines[row].tolist()
    line = file.content[first:stop]
    cells = cells_of(line.translate(_COMMA) if table.comma else line, table.separator)
    found, wanted = f"has {len(cells)} cells", f"{table.width}, as the header says"
    for number, column in enumerate(table.columns):
        cell = cells[column].strip() if column < len(cells) else b""
        value = _number(cell or (b"" if table.separator == BLANKS else b"nan"))
        if value is None or abs(value) > (MOST if number < len(table.heads) else LARGEST):
            found = f"has {quoted(text_of(cell))} in column {column + 1}"
            wanted = f"a number up to {LARGEST:g}, or nothing where it is unknown"
            break
    last = row == len(table.lines) - 1 and len(cells) <= table.width
    return CaptureError(
        f"frame {row} {found}",
        place=f"{file.name}:{line_of(file.content, first)}",
        wanted=wanted,
        remedy="It is the last line: the file may be cut short." if last else "",
    )


def _number(word: bytes) -> float | None:
    """Return the number that a word is, if it is one; `float` lets 1_0 pass."""
    try:
        return None if b"_" in word else float(word)
    except ValueError:
        return None


def number_rows(data: bytes, lines: Lines, width: int) -> tuple[Floats, int | None]:
    """Read rows of `width` numbers between blanks: (T, width), and the first damaged row."""
    values, bad = parse(data, lines, Table(lines, BLANKS, width, (), tuple(range(width))))
    if np.isnan(values[:bad].sum()):
        bad = int(np.isnan(values[:bad]).any(axis=1).argmax())
    return values, bad


def fault(line: bytes, width: int) -> tuple[str, str]:
    """Say what is wrong with a damaged row of `width` numbers between blanks."""
    words = line.split()
    for place, word in enumerate(words, 1):
        text, value = word.decode("latin-1"), _number(word)
        shown = repr(text if len(text) <= 40 else text[:40] + "...")
        if value is None:
            return f"has {shown} as number {place}", "numbers with a decimal point"
        if not abs(value) <= LARGEST:
            return f"has {shown} as number {place}", f"finite numbers up to {LARGEST:g}"
    return f"has {len(words)} numbers", f"{width} as the hierarchy declares"


HEAD = 1 << 20
"""Bytes in which a header is looked for."""

_AXIS = re.compile(
    r"(?P<name>.*?[\w\])](?=[\W_XYZ]))[\s_.:|(\[-]*"
    r"(?:pos(?:ition)?[\s_.-]*)?(?P<axis>[xyzXYZ])(?:[\s_.-]*pos(?:ition)?)?[)\]]?"
    r"(?:[\s_]*[(\[]?(?P<unit>mm|cm|m|inch)[)\]]?)?"
)
_NO_PLACE = re.compile(
    r"(rot|rotation|quat|quaternion|vel|velocity|acc|angle|euler)$", re.IGNORECASE
)
_PLACE = re.compile(r"[\W_]*(pos|position)$", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Line:
    """A line of a header."""

    text: bytes  # with its end
    first: int  # its bytes
    stop: int

    def cells(self, separator: bytes) -> list[str]:
        """Return its cells without blanks and quotation marks around them."""
        text = text_of(self.text.removeprefix(b"\xef\xbb\xbf").rstrip(b"\r\n"))
        row = text.split(None if separator == BLANKS else separator.decode())
        if '"' in text and separator != BLANKS:
            with suppress(csv.Error):
                row = next(csv.reader([text], delimiter=separator.decode()), [])
        return [cell.strip().strip('"') for cell in row]


def header_lines(file: File, first: int = 0) -> Iterator[Line]:
    """Yield the lines of a header, from a byte on, as far as a header may reach."""
    head = file.content[first : first + HEAD]
    end, at = newline(head), 0
    while at < len(head):
        stop = head.find(end, at) + 1 or len(head)
        yield Line(head[at:stop], first + at, first + stop)
        at = stop


def triples(cells: Sequence[str]) -> tuple[dict[str, tuple[int, int, int]], str | None]:
    """Return which columns are x, y, z of which point, and the unit that they name."""
    found: dict[str, dict[str, int]] = {}
    units: dict[str, str | None] = {}
    for column, cell in enumerate(cells):
        match = _AXIS.fullmatch(cell) if len(cell) < 200 else None
        if match and not _NO_PLACE.search(match["name"]):
            name = _PLACE.sub("", match["name"]) or match["name"]
            found.setdefault(name, {}).setdefault(match["axis"].lower(), column)
            units[name] = match["unit"]
    whole = {name: (at["x"], at["y"], at["z"]) for name, at in found.items() if len(at) == 3}
    named = {units[name] for name in whole}
    return whole, named.pop() if len(named) == 1 else None


def twice(names: Sequence[str], noun: str) -> tuple[str, ...]:
    """Return a warning where several points or columns have one name."""
    again = [quoted(name) for name, many in Counter(names).items() if many > 1]
    more = f" and {len(again) - 3} others" if len(again) > 3 else ""
    doubt = f"several {noun} are called {', '.join(again[:3])}{more}: the first is read"
    return (doubt,) if again else ()


def first_row(file: File, first: int) -> bytes:
    """Return the first row from a byte on; nothing, if there is none."""
    lines = (line.text for line in header_lines(file, first))
    return next((line for line in lines if line.strip(NOTHING)), b"")


def xyz(columns: Iterable[int]) -> tuple[int, ...]:
    """Return columns, each with the two behind it."""
    return tuple(chain.from_iterable((column, column + 1, column + 2) for column in columns))


def table_of(
    file: File,
    first: int,
    separator: bytes,
    width: int,
    heads: Iterable[int],
    points: Iterable[int],
    comma: bool | None = None,
) -> Table:
    """Return the table from a byte on: a row and a point at least; `comma` None: look for it."""
    lines, columns = rows(file.content, first), tuple(points)
    if not len(lines) or not columns:
        found = "no frames" if columns else "no columns x, y, z of any point"
        wanted = "rows of numbers behind the header"
        raise CaptureError(found, place=file.name, wanted=wanted)
    if comma is None:
        row = first_row(file, first)
        comma = separator != b"," and b"." not in row and re.search(rb"\d,\d", row) is not None
    return Table(lines, separator, width, tuple(heads), columns, comma)


def count_doubt(text: str, count: int, noun: str = "frames") -> tuple[str, ...]:
    """Return a warning where a header gives another number of frames than there are."""
    if not text or text == str(count):
        return ()
    return (f"its header says {quoted(text)} {noun}, the file has {count}",)


def written(
    motion: Motion, places: NDArray[np.float32], separator: str, first: int = 0, end: str = "\n"
) -> str:
    """Return the rows of a table: number, seconds, and places (T, M, 3), blank where unknown."""
    form = separator.join(["%d", "%.7f", *["%.4f"] * (3 * places.shape[1])]) + end
    seconds = np.arange(len(places)) / float(motion.rate)
    return "".join(
        (form % (frame, time, *row.ravel().tolist())).replace("nan", "")
        for frame, (time, row) in enumerate(zip(seconds.tolist(), places, strict=True), first)
    )
