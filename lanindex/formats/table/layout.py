"""What is known of a table before its numbers are read, and what its header is made of."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from lanindex.body import Stated
from lanindex.errors import CaptureError, quoted
from lanindex.formats import numbers
from lanindex.formats.bvh.hierarchy import text_of
from lanindex.formats.file import File
from lanindex.formats.table.segments import Finish

HEAD = 1 << 20
"""Bytes in which a header is looked for."""

SEPARATORS = (b"\t", b";", b",")
"""What stands between cells: the first of these that a header has most of."""

_AXIS = re.compile(
    r"(?P<name>.*?[\w\])](?=[\W_XYZ]))[\s_.:|(\[-]*"
    r"(?:pos(?:ition)?[\s_.-]*)?(?P<axis>[xyzXYZ])(?:[\s_.-]*pos(?:ition)?)?[)\]]?"
    r"(?:[\s_]*[(\[]?(?P<unit>mm|cm|m|inch)[)\]]?)?"
)
_NO_PLACE = re.compile(
    r"(rot|rotation|quat|quaternion|vel|velocity|acc|angle|euler)$", re.IGNORECASE
)
_PLACE = re.compile(r"[\W_]*(pos|position)$", re.IGNORECASE)


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """A table, before its numbers are read."""

    title: str  # whose table it is, as people call it
    names: tuple[str, ...]  # (M) its points
    table: numbers.Table  # where the numbers lie
    time: int | None = None  # which of the table's heads is the time
    tick: float | None = 1.0  # seconds in one unit of it; None: to be told from how fast it grows
    rate: str = ""  # frames a second, as the file says; empty where it does not
    # the first of the heads that tell of each point whether it was seen: 0, not
    states: int | None = None
    stated: Stated = field(default_factory=Stated)  # what it says of its unit and axes
    doubts: tuple[str, ...] = ()  # what its header gets wrong
    finish: Finish | None = None  # what makes the points, (T, M, 3), of what the table has instead


@dataclass(frozen=True, slots=True)
class Line:
    """A line of a header."""

    text: bytes  # with its end
    first: int  # its bytes
    stop: int

    def cells(self, separator: bytes) -> list[str]:
        """Return its cells without blanks and quotation marks around them."""
        text = text_of(self.text.removeprefix(b"\xef\xbb\xbf").rstrip(b"\r\n"))
        if '"' not in text:
            return [cell.strip() for cell in text.split(separator.decode())]
        try:
            row = next(csv.reader([text], delimiter=separator.decode()), [])
        except csv.Error:
            row = text.split(separator.decode())
        return [cell.strip().strip('"') for cell in row]


def lines(file: File, first: int = 0) -> Iterator[Line]:
    """Yield the lines of a header, from a byte on, as far as a header may reach."""
    head = file.content[first : first + HEAD]
    end, at = numbers.newline(head), 0
    while at < len(head):
        stop = head.find(end, at) + 1 or len(head)
        yield Line(head[at:stop], first + at, first + stop)
        at = stop


def separator_of(line: bytes) -> bytes:
    """Return what stands between the cells of a line."""
    return max(SEPARATORS, key=line.count)


def comma_of(line: bytes, separator: bytes) -> bool:
    """Tell whether the numbers of a row have commas where a point would stand."""
    return separator != b"," and b"." not in line and re.search(rb"\d,\d", line) is not None


def triples(cells: Sequence[str]) -> tuple[dict[str, tuple[int, int, int]], str | None]:
    """Return which columns are x, y, z of which point, and the unit that they name.

    Examples
    --------
    >>> from lanindex.formats.table.layout import triples
    >>> triples(["t", "head_x", "head_y", "head_z", "q_x"])
    ({'head': (1, 2, 3)}, None)
    >>> triples(["Hand.X [mm]", "Hand.Y [mm]", "Hand.Z [mm]"])
    ({'Hand': (0, 1, 2)}, 'mm')
    """
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


def twice(names: Sequence[str], what: str) -> tuple[str, ...]:
    """Return a warning where several points or columns have one name.

    Examples
    --------
    >>> from lanindex.formats.table.layout import twice
    >>> twice(["hand", "head", "hand"], "points")
    ("several points are called 'hand': the first is read",)
    """
    again = [quoted(name) for name, many in Counter(names).items() if many > 1]
    more = f" and {len(again) - 3} others" if len(again) > 3 else ""
    told = f"several {what} are called {', '.join(again[:3])}{more}: the first is read"
    return (told,) if again else ()


def made(
    file: File,
    rows: numbers.Lines,
    separator: bytes,
    width: int,
    heads: Sequence[int],
    points: Sequence[tuple[int, int, int]],
    comma: bool = False,
) -> numbers.Table:
    """Return a table, of which there is at least one row and one point."""
    if not len(rows) or not points:
        found = "no frames" if points else "no columns x, y, z of any point"
        wanted = "rows of numbers behind the header"
        raise CaptureError(found, place=file.name, wanted=wanted)
    columns = tuple(column for point in points for column in point)
    return numbers.Table(rows, separator, width, tuple(heads), columns, comma)


def counted(said: str, there: int) -> tuple[str, ...]:
    """Return a warning where a header says another number of frames than there are."""
    if not said or said == str(there):
        return ()
    return (f"its header says {said[:20]!r} frames, the file has {there}",)
