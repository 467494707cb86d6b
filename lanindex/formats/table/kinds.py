"""The tables of points: how each program's is recognised, and where its points are.

Sources: Microsoft, *Kinect for Windows SDK 2.0*, JointType, and LabanotationSuite; Vicon, *Nexus
User Guide*, ASCII export; Vicon, *Plug-in Gait Reference Guide*, kinematic segments; NaturalPoint,
*Motive*, CSV data export; Qualisys, *QTM User Manual*, TSV export.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.body import Declared
from lanindex.errors import CaptureError, UsageError, quoted, shown
from lanindex.formats import sniff, tables
from lanindex.formats.file import Content, File
from lanindex.formats.tables import (
    Finish,
    Line,
    TableLayout,
    comma_of,
    count_doubt,
    header_lines,
    separator_of,
    table_of,
    triples,
    twice,
)

_JOINTS = (
    "SpineBase SpineMid Neck Head ShoulderLeft ElbowLeft WristLeft HandLeft ShoulderRight "
    "ElbowRight WristRight HandRight HipLeft KneeLeft AnkleLeft FootLeft HipRight KneeRight "
    "AnkleRight FootRight SpineShoulder HandTipLeft ThumbLeft HandTipRight ThumbRight"
)
KINECT = tuple(_JOINTS.split())
"""The joints of Kinect v2, in the order of its JointType."""

_TICKS = 1e-7  # seconds
_NEXUS = b"trajectories", b"model outputs", b"devices", b"joints", b"segments"
_NAME_ROWS = 40  # lines in which a header is looked for
_TIME = re.compile(
    r"(?:time|timestamp|seconds?|secs?|t)(?:[\s_]*[(\[]?(s|sec|seconds|ms|us|µs|ns|milliseconds|"
    r"microseconds|nanoseconds)?[)\]]?)",
    re.IGNORECASE,
)
_UNITS = {"s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "milliseconds": 1e-3, "us": 1e-6,
          "µs": 1e-6, "microseconds": 1e-6, "ns": 1e-9, "nanoseconds": 1e-9}  # fmt: skip
_MOTIVE_ROWS = ("type", "name", "id")
_LENGTHS = {"millimeters": "mm", "centimeters": "cm", "meters": "m"}


def layout_of(file: File) -> TableLayout:
    """Return where the points of a table are, whosesoever it is."""
    head = list(islice(header_lines(file), _NAME_ROWS))
    first = next((line for line in head if line.text.strip(b" \t\r\n,;\xef\xbb\xbf")), None)
    if first is None:
        raise CaptureError("nothing but blanks", place=file.name, wanted="a table of points")
    begun = first.text.removeprefix(b"\xef\xbb\xbf").strip().lower()
    for starts, kind in _KINDS.items():
        if begun.startswith(starts):
            return kind(file, head)
    if sniff.nexus(b"".join(line.text for line in head)):
        return _nexus(file, head)
    return _kinect(file, first) or _named(file, head)


def _first(file: File, rows: tables.Lines) -> bytes:
    """Return the first row; nothing, if there is none."""
    return file.content[int(rows[0, 0]) : int(rows[0, 1])] if len(rows) else b""


def _kinect(file: File, first: Line) -> TableLayout | None:
    """Return a table of LabanotationSuite: no header, ticks, then x, y, z and a state of each."""
    separator = separator_of(first.text)
    cells = first.text.strip().rstrip(separator).split(separator)
    width = 1 + 4 * len(KINECT)
    if len(cells) != width or not all(map(_is_number, cells)):
        return None
    starts = range(1, width, 4)
    points = [(at, at + 1, at + 2) for at in starts]
    heads = [0, *(at + 3 for at in starts)]
    comma = comma_of(first.text, separator)
    rows = tables.rows(file.content, first.first)
    table = table_of(file, rows, separator, width, heads, points, comma)
    return TableLayout("Kinect v2", KINECT, table, 0, _TICKS, states=1, declared=Declared("m", "y"))


def _is_number(cell: bytes) -> bool:
    try:
        float(cell.replace(b",", b"."))
    except ValueError:
        return False
    return True


def _named(file: File, head: list[Line]) -> TableLayout:
    """Return a table whose header names the columns: ``time``, ``head_x``, ``head_y`` ..."""
    best: tuple[Line, list[str], bytes] | None = None
    most = 0
    for line in head:
        separator = separator_of(line.text)
        cells = line.cells(separator)
        points = triples(cells)[0]
        if len(points) > most:
            best, most = (line, cells, separator), len(points)
    if best is None:
        raise CaptureError(
            f"a table that begins with {shown(head[0].text.decode('latin-1').strip(), 40)!r}",
            place=file.name,
            wanted="a header that names x, y, z of each joint, as head_x, head_y, head_z",
            remedy="Say what its columns are with --columns.",
        )
    line, cells, separator = best
    points, unit = triples(cells)
    time = [number for number, cell in enumerate(cells) if _TIME.fullmatch(cell)]
    rows = tables.rows(file.content, line.stop)
    comma = comma_of(_first(file, rows), separator)
    table = table_of(file, rows, separator, len(cells), time[:1], list(points.values()), comma)
    said = _TIME.fullmatch(cells[time[0]]) if time else None
    tick = _UNITS[said[1].lower()] if said and said[1] else None
    when = 0 if time else None
    used = {cells[column] for point in points.values() for column in point}
    doubts = twice([cell for cell in cells if cell in used], "columns")
    return TableLayout(
        "a table", tuple(points), table, when, tick, declared=Declared(unit), doubts=doubts
    )


def _nexus(file: File, head: list[Line]) -> TableLayout:
    """Return the block ``Trajectories`` of an export of Vicon Nexus, else the model's segments."""
    at = block(file.content, b"Trajectories")
    outputs = block(file.content, b"Model Outputs") if at is None else None
    start = outputs if at is None else at
    head = list(islice(header_lines(file, start), 5)) if start is not None else []
    if start is not None and len(head) < 5:
        raise CaptureError("ends in its header", place=file.name, wanted="five lines, then frames")
    found: tuple[tuple[str, ...], list[Triple], Finish | None] = ((), [], None)
    if head:
        separator = separator_of(head[3].text)
        rate, names, axes, units = (line.cells(separator) for line in head[1:5])
        found = _trajectories(names, axes) if at is not None else segment_joints(names, axes)
    called, points, finish = found
    if at is None and not points:
        raise CaptureError(
            "an export of Vicon Nexus without markers or segments",
            place=file.name,
            wanted="the block Trajectories",
            remedy="Export the trajectories too, or give the C3D file.",
        )
    rows = tables.rows(file.content, head[4].stop)
    beyond = np.flatnonzero(rows[1:, 0] != rows[:-1, 1])  # a blank line ends the block
    rows = rows[: int(beyond[0]) + 1] if len(beyond) else rows
    unit = next((units[point[0]] for point in points if point[0] < len(units)), None)
    comma = comma_of(_first(file, rows), separator)
    table = table_of(file, rows, separator, len(axes), [0], points, comma)
    return TableLayout(
        "Vicon Nexus", called, table, rate=rate[0], declared=Declared(unit), finish=finish
    )


def _trajectories(names: list[str], axes: list[str]) -> tuple[tuple[str, ...], list[Triple], None]:
    """Return the markers of a header, and their columns."""
    starts = [
        column
        for column in range(2, min(len(names), len(axes) - 2))
        if names[column] and [axis.upper() for axis in axes[column : column + 3]] == ["X", "Y", "Z"]
    ]
    columns = [(column, column + 1, column + 2) for column in starts]
    return tuple(names[column] for column in starts), columns, None


def block(content: Content, title: bytes) -> int | None:
    """Return where a line begins that holds a title; None: there is none."""
    pattern = re.compile(rb"(?:^|[\r\n]|\xef\xbb\xbf)" + title + rb"(?=[\s,;]|$)", re.IGNORECASE)
    size = 1 << 20
    for start in range(0, len(content), size):
        held = content[start : start + size + len(title) + 8]
        for match in pattern.finditer(held):
            if match.start() or not start:
                return start + match.end() - len(title)
    return None


def _motive(file: File, head: list[Line]) -> TableLayout:
    """Return an export of OptiTrack Motive: places of bones, where it has them, else of markers."""
    first = head[0].cells(b",")
    said = dict(zip(first[::2], first[1::2], strict=False))
    rows: dict[str, list[str]] = {}
    kinds: list[str] = []
    axes: Line | None = None
    for line in head[1:]:
        cells = line.cells(b",")
        if cells[0].lower() == "frame":
            axes = line
            break
        if "Position" in cells:
            kinds = cells
        elif any(cells[2:]):  # rows of older exports are not called by what they hold
            rows[cells[1].lower() or _MOTIVE_ROWS[min(len(rows), 2)]] = cells
    if axes is None or not kinds or "name" not in rows:
        wanted = "rows of Name, Rotation and Position, and Frame"
        raise CaptureError("the header of Motive cut short", place=file.name, wanted=wanted)
    space = said.get("Coordinate Space", "Global")
    if space.lower() != "global":
        raise CaptureError(
            f"places as each bone's parent sees them (Coordinate Space {quoted(space, 20)})",
            place=file.name,
            wanted="Global",
            remedy="Export it with Use World Space Coordinates.",
        )
    types = rows.get("type", [])
    names, points = _motive_points(rows["name"], kinds, types, axes.cells(b","))
    lines_there = tables.rows(file.content, axes.stop)
    width = len(axes.cells(b","))
    table = table_of(file, lines_there, b",", width, [1], points)
    unit = said.get("Length Units", "").lower()
    rate = said.get("Export Frame Rate") or said.get("Capture Frame Rate", "")
    count = said.get("Total Exported Frames", "")
    doubts = count_doubt(count, len(lines_there))
    declared = Declared(_LENGTHS.get(unit, unit or None), "y")
    return TableLayout("Motive", names, table, 0, 1.0, rate, declared=declared, doubts=doubts)


def _motive_points(
    names: list[str], kinds: list[str], types: list[str], axes: list[str]
) -> tuple[tuple[str, ...], list[tuple[int, int, int]]]:
    """Return names and columns of the bones; where there are none, of the markers."""
    width = min(len(names), len(kinds), len(axes))
    found: dict[str, dict[str, tuple[int, int, int]]] = {}
    for column in range(2, width - 2):
        if kinds[column] == "Position" and axes[column : column + 3] == ["X", "Y", "Z"]:
            kind = types[column] if column < len(types) else "Marker"
            kind = "Bone" if kind == "Bone" else "Marker" if "Marker" in kind else kind
            name = names[column]
            parts = name.split(":")
            if kind == "Bone" and (len(parts) == 1 or parts[0] == parts[-1]):
                name = f"{parts[0]}:Hip"  # the skeleton itself
            found.setdefault(kind, {})[name] = (column, column + 1, column + 2)
    chosen = found.get("Bone") or found.get("Marker") or next(iter(found.values()), {})
    return tuple(chosen), list(chosen.values())


def _qualisys(file: File, head: list[Line]) -> TableLayout:
    """Return an export of Qualisys: keys, the names of the markers, then x, y, z of each."""
    said: dict[str, str] = {}
    names: list[str] = []
    before: list[str] | None = None
    begin = head[0].first
    for line in head:
        cells = line.cells(b"\t")
        key = cells[0].upper()
        if key in ("FRAME", "TIME") or key.endswith(" X"):
            before = [cell.lower() for cell in cells[:2] if cell.lower() in ("frame", "time")]
            begin = line.stop
            break
        if not re.fullmatch(r"[A-Z_]{2,}", key):
            break
        begin = line.stop
        said[key] = cells[1] if len(cells) > 1 else ""
        names = [name for name in cells[1:] if name] if key == "MARKER_NAMES" else names
    if said.get("DATA_INCLUDED", "3D") not in ("3D", ""):
        found = f"data of the kind {shown(said['DATA_INCLUDED'], 20)!r}"
        raise CaptureError(found, place=file.name, wanted="3D, places of markers")
    rows = tables.rows(file.content, begin)
    if before is None:
        row = _first(file, rows).rstrip(b"\r\n")
        extra = row.removesuffix(b"\t").count(b"\t") + 1 - 3 * len(names)
        before = ["frame", "time"][: max(extra, 0)]
    skip = len(before or ())
    points = [(at, at + 1, at + 2) for at in range(skip, skip + 3 * len(names), 3)]
    heads = [before.index("time")] if before and "time" in before else []
    comma = comma_of(_first(file, rows), b"\t")
    table = table_of(file, rows, b"\t", skip + 3 * len(names), heads, points, comma)
    doubts = count_doubt(said.get("NO_OF_FRAMES", ""), len(rows))
    when = 0 if heads else None
    rate = said.get("FREQUENCY", "")
    return TableLayout(
        "Qualisys", tuple(names), table, when, 1.0, rate, declared=Declared("mm"), doubts=doubts
    )


_KINDS: dict[bytes | tuple[bytes, ...], Callable[[File, list[Line]], TableLayout]] = {
    _NEXUS: _nexus,
    b"format version": _motive,
    (b"no_of_frames", b"file_version"): _qualisys,
}
"""By how a table begins, in small letters: whose it is."""


JOINTS = {
    "PEL": "Pelvis",
    "TRX": "Neck",
    "HED": "Head",
    **{
        side + segment: side + joint
        for side in "LR"
        for segment, joint in (
            ("CL", "Shoulder"),
            ("HU", "Elbow"),
            ("RA", "Wrist"),
            ("HN", "Hand"),
            ("FE", "Knee"),
            ("TI", "Ankle"),
            ("TO", "Toe"),
        )
    },
}
"""By segment, the joint at its origin."""

AXES = ["RX", "RY", "RZ", "TX", "TY", "TZ", "SX", "SY", "SZ"]

Triple = tuple[int, int, int]


def segment_joints(
    names: list[str], axes: list[str]
) -> tuple[tuple[str, ...], list[Triple], Finish]:
    """Return the joints of Plug-in Gait's segments: names, hips last; columns; what makes places.

    Of each segment an export gives a turn (RX, RY, RZ: axis times angle, degrees), the origin (TX,
    TY, TZ) and its length (SX, SY, SZ). Origins are the joints at the lower ends; the hips lie at
    the upper ends of the thighs, along their z axes.
    """
    called: list[str] = []
    points: list[Triple] = []
    thighs: list[tuple[str, int]] = []
    for column in range(2, min(len(names), len(axes) - 8)):
        subject, mark, segment = names[column].rpartition(":")
        if segment in JOINTS and [axis.upper() for axis in axes[column : column + 9]] == AXES:
            called.append(subject + mark + JOINTS[segment])
            points.append((column + 3, column + 4, column + 5))
            if segment[1:] == "FE":
                thighs.append((f"{subject}{mark}{segment[0]}Hip", column))
    knees = [points.index((column + 3, column + 4, column + 5)) for _, column in thighs]
    many = len(points)
    for _, column in thighs:
        points += [(column, column + 1, column + 2), (column + 6, column + 7, column + 8)]

    def finish(places: NDArray[Any]) -> NDArray[Any]:
        turns, lengths = places[:, many::2], places[:, many + 1 :: 2, 2:]
        hips = places[:, knees] + lengths * _upwards(np.radians(turns))
        return np.concatenate((places[:, :many], hips), axis=1)

    return (*called, *(name for name, _ in thighs)), points, finish


def _upwards(turns: NDArray[Any]) -> NDArray[Any]:
    """Return the z axis turned by axes times angles, (..., 3)."""
    angle = np.sqrt((turns * turns).sum(axis=-1, keepdims=True))
    axis = turns / np.where(angle > 0, angle, 1)
    up = np.array([0.0, 0.0, 1.0])
    across = np.cross(axis, up)
    along: NDArray[Any] = axis * axis[..., 2:]
    result: NDArray[Any] = up * np.cos(angle) + across * np.sin(angle) + along * (1 - np.cos(angle))
    return result


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


def columns_of(path: str) -> dict[str, Any]:
    """Read the user's file of columns (TOML).

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


def given_layout(file: File, path: str) -> TableLayout:
    """Return where the points of a table are, as its user says."""
    said = columns_of(path)
    skip = said.get("skip", 1)
    head = list(islice(header_lines(file), min(max(skip, 0), _MOST) + 1))
    header, first = head[skip - 1] if 0 < skip <= len(head) else None, head[-1:]
    text = (header or first[0]).text if head else b""
    separator = said.get("separator", "").encode() or separator_of(text)
    separator = tables.BLANKS if separator in (b"space", b" ") else separator
    if len(separator) != 1:
        raise UsageError(f"--columns {path}: separator", wanted="one character, or space")
    cells = text_cells(text, separator) if header else []
    columns = {name: tuple(_column(cell, cells, path) for cell in axes)
               for name, axes in said["joints"].items()}  # fmt: skip
    time = [_column(said["time"], cells, path)] if "time" in said else []
    used = [*time, *(column for axes in columns.values() for column in axes)]
    if len(set(used)) < len(used):
        raise UsageError(f"--columns {path}: a column that is used twice", wanted="each once")
    rows = tables.rows(file.content, header.stop if header else 0)
    row = file.content[int(rows[0, 0]) : int(rows[0, 1])] if len(rows) else b""
    comma = said.get("comma", comma_of(row, separator))
    width = max(len(tables.cells_of(row, separator)), max(used) + 1)
    points = [(x, y, z) for x, y, z in columns.values()]
    table = table_of(file, rows, separator, width, time, points, comma)
    tick = float(said["tick"]) if "tick" in said else None
    declared = Declared(said.get("unit"), said.get("up"))
    when = 0 if time else None
    rate = str(said.get("rate", ""))
    return TableLayout("a table", tuple(columns), table, when, tick, rate, declared=declared)


def text_cells(line: bytes, separator: bytes) -> list[str]:
    """Return the names of columns."""
    cells = tables.cells_of(line.removeprefix(b"\xef\xbb\xbf"), separator)
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
