"""What the columns of any other table are, told by its user in a file (TOML).

All keys but ``joints`` may be left out::

    separator = ";"       # between cells; "space" for blanks; else what the header has most of
    comma = true          # a comma stands in numbers where a point would
    skip = 3              # lines before the first row; the last of them names the columns
    rate = 100            # frames a second; or
    time = "t"            # the column of times, and
    tick = 0.001          # seconds in one unit of it
    unit = "mm"
    up = "z"

    [joints]              # a column by its name, or by its number, counted from 1
    RightWrist = ["rwx", "rwy", "rwz"]
    LeftWrist = [5, 6, 7]
"""

from __future__ import annotations

import tomllib
from itertools import islice
from pathlib import Path
from typing import Any

from lanindex.body import Stated
from lanindex.errors import UsageError, quoted
from lanindex.formats import numbers
from lanindex.formats.file import File
from lanindex.formats.table.layout import Layout, comma_of, lines, made, separator_of

_NUMBER = (int, float)
_KEYS: dict[str, Any] = {
    "separator": str,
    "comma": bool,
    "skip": int,
    "rate": (*_NUMBER, str),
    "time": (int, str),
    "tick": _NUMBER,
    "unit": str,
    "up": str,
    "joints": dict,
}
_MOST = 1000  # lines that may be skipped


def told(path: str) -> dict[str, Any]:
    """Read what a user says of columns."""
    try:
        said = tomllib.loads(Path(path).read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise UsageError(f"--columns {path}: {error}", wanted="a file that says joints") from None
    for key, value in said.items():
        if key not in _KEYS or not isinstance(value, _KEYS[key]):
            found = f"--columns {path}: {key} = {quoted(value)}"
            raise UsageError(found, wanted=f"one of {', '.join(_KEYS)}")
    joints = said.get("joints")
    if not joints or not all(isinstance(axes, list) and len(axes) == 3 for axes in joints.values()):
        found = f"--columns {path}: no [joints]" if not joints else f"--columns {path}: [joints]"
        raise UsageError(found, wanted="of each joint its three columns, x, y, z")
    return said


def layout_of(file: File, path: str) -> Layout:
    """Return where the points of a table are, as its user says."""
    said = told(path)
    skip = said.get("skip", 1)
    head = list(islice(lines(file), min(max(skip, 0), _MOST) + 1))
    header, first = head[skip - 1] if 0 < skip <= len(head) else None, head[-1:]
    text = (header or first[0]).text if head else b""
    separator = said.get("separator", "").encode() or separator_of(text)
    separator = numbers.BLANKS if separator in (b"space", b" ") else separator
    if len(separator) != 1:
        raise UsageError(f"--columns {path}: separator", wanted="one character, or space")
    cells = text_cells(text, separator) if header else []
    columns = {name: tuple(_column(cell, cells, path) for cell in axes)
               for name, axes in said["joints"].items()}  # fmt: skip
    time = [_column(said["time"], cells, path)] if "time" in said else []
    used = [*time, *(column for axes in columns.values() for column in axes)]
    if len(set(used)) < len(used):
        raise UsageError(f"--columns {path}: a column that is used twice", wanted="each once")
    rows = numbers.rows(file.content, header.stop if header else 0)
    row = file.content[int(rows[0, 0]) : int(rows[0, 1])] if len(rows) else b""
    comma = said.get("comma", comma_of(row, separator))
    width = max(len(numbers.cells_of(row, separator)), max(used) + 1)
    points = [(x, y, z) for x, y, z in columns.values()]
    table = made(file, rows, separator, width, time, points, comma)
    tick = float(said["tick"]) if "tick" in said else None
    stated = Stated(said.get("unit"), said.get("up"))
    when = 0 if time else None
    rate = str(said.get("rate", ""))
    return Layout("a table", tuple(columns), table, when, tick, rate, stated=stated)


def text_cells(line: bytes, separator: bytes) -> list[str]:
    """Return the names of columns."""
    cells = numbers.cells_of(line.removeprefix(b"\xef\xbb\xbf"), separator)
    return [cell.decode("utf-8", "replace").strip().strip('"') for cell in cells]


def _column(cell: object, cells: list[str], path: str) -> int:
    """Return which column is meant, counted from 0."""
    if isinstance(cell, int) and not isinstance(cell, bool) and 0 < cell <= 100_000:
        return cell - 1
    if isinstance(cell, str) and cell in cells:
        return cells.index(cell)
    there = ", ".join(cells[:8]) or "no names"
    wanted = f"a number from 1 on, or a name of the header ({there} ...)"
    raise UsageError(f"--columns {path}: column {quoted(cell)}", wanted=wanted)
