"""Tables of points: how each program's is recognised, where its points are, clips of it.

Sources: Microsoft, *Kinect for Windows SDK 2.0*, JointType, and LabanotationSuite; Vicon, *Nexus
User Guide*, ASCII export; Vicon, *Plug-in Gait Reference Guide*, kinematic segments; NaturalPoint,
*Motive*, CSV data export; Qualisys, *QTM User Manual*, TSV export.
"""

import re
import tomllib
from collections.abc import Callable
from dataclasses import replace
from itertools import chain, islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.body import Declared
from lanindex.body.markers import marker_set_of
from lanindex.body.recognition import LIMBS, candidates
from lanindex.data import shipped
from lanindex.errors import CaptureError, UsageError, quoted, shown
from lanindex.formats import sniff, text_rows
from lanindex.formats.file import Content, File, Wanted
from lanindex.formats.people import named, subject_points
from lanindex.formats.points import spread
from lanindex.formats.sniff import separator_of
from lanindex.formats.text_rows import (
    NOTHING,
    Layout,
    Line,
    count_doubt,
    first_row,
    header_lines,
    table_of,
    triples,
    twice,
    xyz,
)
from lanindex.model import Motion, Reading, Span

KINECT = tuple(shipped("formats/skeletons.toml")["kinect"]["joints"])
"""The joints of Kinect v2, in the order of its JointType."""

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


def layout_of(file: File) -> Layout:
    """Return where the points of a table are, whosesoever it is."""
    head = list(islice(header_lines(file), _NAME_ROWS))
    first = next((line for line in head if line.text.strip(NOTHING)), None)
    if first is None:
        raise CaptureError("nothing but blanks", place=file.name, wanted="a table of points")
    begun = first.text.removeprefix(b"\xef\xbb\xbf").strip().lower()
    for starts, kind in _KINDS.items():
        if begun.startswith(starts):
            return kind(file, head)
    if sniff.nexus(b"".join(line.text for line in head)):
        return _nexus(file, head)
    return _kinect(file, first) or _named_columns(file, head)


def _kinect(file: File, first: Line) -> Layout | None:
    """Return a table of LabanotationSuite: no header, ticks, then x, y, z and a state of each."""
    if not sniff.kinect(first.text):
        return None
    separator, width = separator_of(first.text), sniff.KINECT_COLUMNS
    starts = range(1, width, 4)
    heads = (0, *(at + 3 for at in starts))
    table = table_of(file, first.first, separator, width, heads, xyz(starts))
    return Layout(KINECT, table, 0, 1e-7, declared=Declared("m", "y"), states=1)


def _named_columns(file: File, head: list[Line]) -> Layout:
    """Return a table whose header names the columns: ``time``, ``head_x``, ``head_y`` ..."""
    points, unit, cells = dict[str, tuple[int, int, int]](), None, list[str]()
    for line in head:
        row = line.cells(separator_of(line.text))
        there, unit_there = triples(row)
        if len(there) > len(points):
            best, points, unit, cells = line, there, unit_there, row
    if not points:
        raise CaptureError(
            f"a table that begins with {shown(head[0].text.decode('latin-1').strip(), 40)!r}",
            place=file.name,
            wanted="a header that names x, y, z of each joint, as head_x, head_y, head_z",
            remedy="Say what its columns are with --columns.",
        )
    times = [(number, match) for number, cell in enumerate(cells)
             if (match := _TIME.fullmatch(cell))][:1]  # fmt: skip
    tick = next((_UNITS[match[1].lower()] for _, match in times if match[1]), None)
    separator = separator_of(best.text)
    columns = tuple(chain.from_iterable(points.values()))
    heads = [number for number, _ in times]
    table = table_of(file, best.stop, separator, len(cells), heads, columns)
    used = {cells[column] for column in columns}
    doubts = twice([cell for cell in cells if cell in used], "columns")
    time = 0 if times else None
    return Layout(tuple(points), table, time, tick, "", Declared(unit), doubts)


def _nexus(file: File, head: list[Line]) -> Layout:
    """Return the block ``Trajectories`` of an export of Vicon Nexus, else the model's segments."""
    at = block(file.content, b"Trajectories")
    outputs = block(file.content, b"Model Outputs") if at is None else None
    start = outputs if at is None else at
    head = list(islice(header_lines(file, start), 5)) if start is not None else []
    if start is not None and len(head) < 5:
        raise CaptureError("ends in its header", place=file.name, wanted="five lines, then frames")
    joints, starts, finish = tuple[str, ...](), list[int](), None
    if head:
        separator = separator_of(head[3].text)
        rate, names, axes, units = (line.cells(separator) for line in head[1:5])
        if at is not None:
            starts = [column for column in _columns(axes, POSITION)
                      if column < len(names) and names[column]]  # fmt: skip
            joints = tuple(names[column] for column in starts)
        else:
            joints, starts, finish = segment_joints(names, axes)
    if at is None and not starts:
        raise CaptureError(
            "an export of Vicon Nexus without markers or segments",
            place=file.name,
            wanted="the block Trajectories",
            remedy="Export the trajectories too, or give the C3D file.",
        )
    unit = next((units[column] for column in starts if column < len(units)), None)
    table = table_of(file, head[4].stop, separator, len(axes), [0], xyz(starts))
    beyond = np.flatnonzero(table.lines[1:, 0] != table.lines[:-1, 1])
    if len(beyond):  # a blank line ends the block
        table = replace(table, lines=table.lines[: int(beyond[0]) + 1])
    return Layout(joints, table, rate=rate[0], declared=Declared(unit), finish=finish)


def _columns(axes: list[str], wanted: list[str]) -> list[int]:
    """Return the columns, from the third on, at which some axes begin."""
    upper = [axis.upper() for axis in axes]
    starts = range(2, len(axes) - len(wanted) + 1)
    return [column for column in starts if upper[column : column + len(wanted)] == wanted]


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


def _motive(file: File, head: list[Line]) -> Layout:
    """Return an export of OptiTrack Motive: places of bones, where it has them, else of markers."""
    first = head[0].cells(b",")
    header = dict(zip(first[::2], first[1::2], strict=False))
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
    space = header.get("Coordinate Space", "Global")
    if space.lower() != "global":
        raise CaptureError(
            f"places as each bone's parent sees them (Coordinate Space {quoted(space, 20)})",
            place=file.name,
            wanted="Global",
            remedy="Export it with Use World Space Coordinates.",
        )
    under = axes.cells(b",")
    points = _motive_points(rows["name"], kinds, rows.get("type", []), under)
    table = table_of(file, axes.stop, b",", len(under), [1], xyz(points.values()))
    unit = header.get("Length Units", "").lower()
    rate = header.get("Export Frame Rate") or header.get("Capture Frame Rate", "")
    declared = Declared(_LENGTHS.get(unit, unit or None), "y")
    doubts = count_doubt(header.get("Total Exported Frames", ""), len(table.lines))
    return Layout(tuple(points), table, 0, 1.0, rate, declared, doubts)


def _motive_points(
    names: list[str], kinds: list[str], types: list[str], axes: list[str]
) -> dict[str, int]:
    """Return names and first columns of the bones; where there are none, of the markers."""
    width = min(len(names), len(kinds), len(axes))
    found: dict[str, dict[str, int]] = {}
    for column in range(2, width - 2):
        if kinds[column] == "Position" and axes[column : column + 3] == POSITION:
            kind = types[column] if column < len(types) else "Marker"
            kind = "Bone" if kind == "Bone" else "Marker" if "Marker" in kind else kind
            name = names[column]
            parts = name.split(":")
            if kind == "Bone" and (len(parts) == 1 or parts[0] == parts[-1]):
                name = f"{parts[0]}:Hip"  # the skeleton itself
            found.setdefault(kind, {})[name] = column
    return found.get("Bone") or found.get("Marker") or next(iter(found.values()), {})


def _qualisys(file: File, head: list[Line]) -> Layout:
    """Return an export of Qualisys: keys, the names of the markers, then x, y, z of each."""
    header: dict[str, str] = {}
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
        header[key] = cells[1] if len(cells) > 1 else ""
        names = [name for name in cells[1:] if name] if key == "MARKER_NAMES" else names
    if header.get("DATA_INCLUDED", "3D") not in ("3D", ""):
        found = f"data of the kind {shown(header['DATA_INCLUDED'], 20)!r}"
        raise CaptureError(found, place=file.name, wanted="3D, places of markers")
    if before is None:
        row = first_row(file, begin).rstrip(b"\r\n")
        extra = row.removesuffix(b"\t").count(b"\t") + 1 - 3 * len(names)
        before = ["frame", "time"][: max(extra, 0)]
    width = len(before) + 3 * len(names)
    heads = [before.index("time")] if "time" in before else []
    table = table_of(file, begin, b"\t", width, heads, range(len(before), width))
    doubts = count_doubt(header.get("NO_OF_FRAMES", ""), len(table.lines))
    rate, time = header.get("FREQUENCY", ""), 0 if heads else None
    return Layout(tuple(names), table, time, 1.0, rate, Declared("mm"), doubts)


_KINDS: dict[bytes | tuple[bytes, ...], Callable[[File, list[Line]], Layout]] = {
    _NEXUS: _nexus,
    b"format version": _motive,
    (b"no_of_frames", b"file_version"): _qualisys,
}
"""By how a table begins, in small letters: whose it is."""


JOINTS: dict[str, str] = shipped("formats/skeletons.toml")["segments"]
"""By segment, the joint at its origin."""

POSITION = ["X", "Y", "Z"]
SEGMENT = ["RX", "RY", "RZ", "TX", "TY", "TZ", "SX", "SY", "SZ"]
"""The axes of a marker, and those of a segment: its rotation, its origin, its length."""


def segment_joints(
    names: list[str], axes: list[str]
) -> tuple[tuple[str, ...], list[int], Callable[[NDArray[Any]], NDArray[Any]]]:
    """Return names, columns and a `Finish` of the joints of Plug-in Gait's segments, hips last.

    A segment has a rotation (RX, RY, RZ: axis times angle, degrees), an origin (TX, TY, TZ), the
    joint at its lower end, and a length (SX, SY, SZ): hips lie that far along the z axes of the
    thighs.
    """
    joints: list[str] = []
    origins: list[int] = []
    hips: dict[str, int] = {}  # of each the knee, among the joints
    for column in _columns(axes, SEGMENT):
        subject, mark, segment = names[column].rpartition(":") if column < len(names) else [""] * 3
        if segment in JOINTS:
            if segment[1:] == "FE":
                hips[f"{subject}{mark}{segment[0]}Hip"] = len(joints)
            joints.append(subject + mark + JOINTS[segment])
            origins.append(column + 3)
    many, knees = len(joints), list(hips.values())
    more = [origins[knee] + away for knee in knees for away in (-3, 3)]  # turns and lengths

    def finish(places: NDArray[Any]) -> NDArray[Any]:
        turns, lengths = places[:, many::2], places[:, many + 1 :: 2, 2:]
        upper = places[:, knees] + lengths * _upwards(np.radians(turns))
        return np.concatenate((places[:, :many], upper), axis=1)

    return (*joints, *hips), origins + more, finish


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
    """Read a user's file of columns (TOML): see ``guide/formats.md``."""
    try:
        columns = tomllib.loads(Path(path).read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise UsageError(f"--columns {path}: {error}", wanted="a file that says joints") from None
    for key, value in columns.items():
        if key not in _KEYS or not isinstance(value, _KEYS[key]):
            found = f"--columns {path}: {key} = {quoted(value)}"
            raise UsageError(found, wanted=f"one of {', '.join(_KEYS)}")
    joints = columns.get("joints")
    if not joints or not all(isinstance(axes, list) and len(axes) == 3 for axes in joints.values()):
        found = f"--columns {path}: no [joints]" if not joints else f"--columns {path}: [joints]"
        raise UsageError(found, wanted="of each joint its three columns, x, y, z")
    return columns


def given_layout(file: File, path: str) -> Layout:
    """Return where the points of a table are, as its user says."""
    options = columns_of(path)
    skip = options.get("skip", 1)
    head = list(islice(header_lines(file), min(max(skip, 0), _MOST) + 1))
    header, first = head[skip - 1] if 0 < skip <= len(head) else None, head[-1:]
    text = (header or first[0]).text if head else b""
    separator = options.get("separator", "").encode() or separator_of(text)
    separator = text_rows.BLANKS if separator in (b"space", b" ") else separator
    if len(separator) != 1:
        raise UsageError(f"--columns {path}: separator", wanted="one character, or space")
    cells = header.cells(separator) if header else []
    columns = {name: tuple(_column(cell, cells, path) for cell in axes)
               for name, axes in options["joints"].items()}  # fmt: skip
    time = [_column(options["time"], cells, path)] if "time" in options else []
    used = [*time, *(column for axes in columns.values() for column in axes)]
    if len(set(used)) < len(used):
        raise UsageError(f"--columns {path}: a column that is used twice", wanted="each once")
    begin = header.stop if header else 0
    width = max(len(text_rows.cells_of(first_row(file, begin), separator)), max(used) + 1)
    points = chain.from_iterable(columns.values())
    table = table_of(file, begin, separator, width, time, points, options.get("comma"))
    tick = float(options["tick"]) if "tick" in options else None
    declared = Declared(options.get("unit"), options.get("up"))
    rate = str(options.get("rate", ""))
    return Layout(tuple(columns), table, 0 if time else None, tick, rate, declared)


def _column(cell: object, cells: list[str], path: str) -> int:
    """Return which column is meant, counted from 0."""
    if isinstance(cell, int) and not isinstance(cell, bool) and 0 < cell <= 100_000:
        return cell - 1
    if isinstance(cell, str) and cell in cells:
        return cells.index(cell)
    there = ", ".join(cells[:8]) or "no names"
    wanted = f"a number from 1 on, or a name of the header ({there} ...)"
    raise UsageError(f"--columns {path}: column {quoted(cell)}", wanted=wanted)


def read(file: File, options: Reading, wanted: Wanted) -> Motion:
    """Read a table of points, of several subjects the one that is meant: see `read_file`."""
    layout = _layout(file, options)
    every = list(range(len(layout.names)))
    chosen, whose = subject_points(file, people(layout.names), every)
    doubts = twice([layout.names[number] for number in chosen], "points") + whose
    layout = replace(layout, doubts=layout.doubts + doubts)
    return text_rows.read_motion(file, layout, "csv", options, wanted, chosen)


frames = spread


def people(names: tuple[str, ...]) -> dict[str, list[int]]:
    """Return the points of each subject that makes a body, by what stands before a colon."""
    groups: dict[str, list[int]] = {}
    for number, name in enumerate(names):
        groups.setdefault(name.rpartition(":")[0], []).append(number)
    found = {
        subject: points
        for subject, points in groups.items()
        if _makes_body(tuple(names[number].rpartition(":")[2] for number in points))
    }
    return named(found)


def _makes_body(names: tuple[str, ...]) -> bool:
    """Tell whether points are enough of a body: of a known set of markers, or named as limbs."""
    if marker_set_of(names):
        return True
    found: Any = candidates(names)
    return any(
        all(found["limbs", side, joint] for side in "RL" for joint in limb) for limb in LIMBS
    )


def subjects(file: File) -> tuple[str, ...]:
    """Return the names of the people that a file holds; none where nobody is named."""
    return tuple(name for name in people(file.once(layout_of).names) if name)


def _layout(file: File, options: Reading | None) -> Layout:
    named = options.columns if options else None
    return given_layout(file, named) if named else file.once(layout_of)


def cutter(file: File, options: Reading | None = None) -> Callable[[Span], bytes]:
    """Return what cuts clips out of a table: header and rows byte for byte."""
    return text_rows.cutter(file, _layout(file, options))


def write(motion: Motion) -> bytes:
    """Write a motion as CSV: ``frame,time,<name>_x,<name>_y,<name>_z``, seconds, mm, y up."""
    names, places = text_rows.points_of(motion)
    names = tuple(re.sub(r'[,;"\s]+', " ", name).strip() or "point" for name in names)
    head = ",".join(("frame", "time", *(f"{name}_{axis}" for name in names for axis in "xyz")))
    return (head + "\n" + text_rows.written(motion, places, ",")).encode()
