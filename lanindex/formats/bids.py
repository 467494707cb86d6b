"""Motion-BIDS: positions in ``*_motion.tsv`` without a header, described by files beside it.

Source: Brain Imaging Data Structure, "Motion": https://bids-specification.readthedocs.io.
"""

import io
import json
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.body import Declared
from lanindex.body.calibration import UNITS
from lanindex.errors import CaptureError, UsageError, quoted
from lanindex.formats import text_rows
from lanindex.formats.file import File, Wanted, opened, siblings
from lanindex.formats.points import Points, motion_of
from lanindex.formats.rates import rate_by
from lanindex.model import Motion, Reading

ENDING = "_motion.tsv"
"""Of the file that holds the positions; those beside it are called alike."""

CHANNELS, SIDECAR, FRAMES = "_channels.tsv", "_motion.json", "_channels.json"

_NAME = re.compile(
    r"sub-[A-Za-z0-9+]+(?:_ses-[A-Za-z0-9+]+)?_task-(?P<task>[A-Za-z0-9+]+)"
    r"_tracksys-(?P<system>[A-Za-z0-9+]+)(?:_acq-[A-Za-z0-9+]+)?(?:_run-\d+)?_motion\.tsv"
)
_WANTED = "a name like sub-01_task-walk_tracksys-body_motion.tsv"
_OTHERS = ("ACCEL", "ANGACCEL", "GYRO", "JNTANG", "LATENCY", "MAGN", "MISC", "ORNT", "VEL")
_AXES = ("x", "y", "z")
_COLUMNS = ("name", "component", "type", "tracked_point", "units")
_DIRECTIONS = {
    **{"L": (1, 0, 0), "R": (-1, 0, 0), "S": (0, 1, 0), "I": (0, -1, 0)},
    **{"A": (0, 0, 1), "P": (0, 0, -1)},
    **{"F": (0, 0, 1), "B": (0, 0, -1), "U": (0, 1, 0), "D": (0, -1, 0)},
}
"""Where an axis leads: to the left, up, ahead. F, B, U and D stand in older files."""

_UNKNOWN = re.compile(rb"(?<![^\t\r\n])n/a(?![^\t\r\n])")
_SPACE = {
    "SpatialAxes": "LSA",
    "RotationRule": "right-hand",
    "Description": "y up; what lies ahead is a convention, where a capture does not tell",
}


@dataclass(frozen=True, slots=True, eq=False)
class _Channels:
    """What the columns are."""

    names: tuple[str, ...]  # (M) the tracked points whose places are known
    points: tuple[int, ...]  # (3 M) columns of x, y, z of each
    latency: tuple[int, ...]  # the column of times, if there is one
    width: int  # columns in all
    unit: str  # of the places
    frame: str  # what the channels call the space that they are measured in


def read(file: File, options: Reading, wanted: Wanted) -> Motion:
    """Read positions of Motion-BIDS, of points that have all three axes: see `read_file`."""
    channels, sidecar = (
        _channels(_required_file(file, CHANNELS)),
        _object(_required_file(file, SIDECAR)),
    )
    content = file.content[:]
    known = File(file.name, _UNKNOWN.sub(b"nan", content) if b"n/a" in content else content)
    lines = text_rows.rows(known.content, 0)
    if not len(lines):
        raise CaptureError("no frames", place=file.name, wanted="lines of numbers")
    width = len(known.content[int(lines[0, 0]) : int(lines[0, 1])].split(b"\t"))
    if width != channels.width:
        found = f"{width} columns, {CHANNELS} has {channels.width} channels"
        raise CaptureError(found, place=f"{file.name}:1", wanted="a channel a column, no header")
    table = text_rows.Table(lines, b"\t", width, channels.latency, channels.points)
    heads, places = text_rows.read(known, table)
    rates = (sidecar.get(key) for key in ("SamplingFrequencyEffective", "SamplingFrequency"))
    rate = next((str(it) for it in rates if isinstance(it, int | float) and it > 0), "")
    times = heads[:, 0] if channels.latency else np.zeros(0)
    hertz, doubts = rate_by(options, f"{_stem(file)}{SIDECAR}", rate, times)
    declared, ways = Declared(channels.unit), _axis_directions(file, channels, sidecar)
    if ways is None:
        doubts += ("where its axes lead is not told: taken for right-handed",)
    else:
        places, declared = places @ ways, Declared(channels.unit, "y")
    points = Points(channels.names, places, hertz, declared, doubts=doubts)
    return motion_of(points, file, "bids", options, wanted)


def companions(file: File, options: Reading) -> tuple[File, ...]:
    """Return the files beside one that it is read with."""
    found = (_file_beside(file, ending) for ending in (CHANNELS, SIDECAR, FRAMES))
    return tuple(it for it in found if it is not None)


def _stem(file: File) -> str:
    return file.name[: -len(ENDING)]


def _file_beside(file: File, ending: str) -> File | None:
    wanted = PurePath(_stem(file) + ending).name.lower()
    paths = siblings(file.name, ending)
    return next((opened(it) for it in paths if PurePath(it).name.lower() == wanted), None)


def _required_file(file: File, ending: str) -> File:
    found = _file_beside(file, ending)
    if found is None:
        wanted = PurePath(_stem(file) + ending).name
        raise CaptureError("no file that tells of it beside it", place=file.name, wanted=wanted)
    return found


def _object(sidecar: File | None) -> dict[str, Any]:
    """Return the object that a sidecar holds; an empty one where there is none."""
    if sidecar is None:
        return {}
    try:
        found = json.loads(sidecar.content[:].decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise CaptureError("damaged JSON", place=sidecar.name, wanted="an object") from error
    if not isinstance(found, dict):
        raise CaptureError("no object", place=sidecar.name, wanted="one")
    return found


def _channels(beside: File) -> _Channels:
    try:
        text = beside.content[:].decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise CaptureError("no text", place=beside.name, wanted="UTF-8") from error
    head, *lines = [line.split("\t") for line in text.splitlines() if line.strip()] or [[""]]
    if absent := [name for name in _COLUMNS if name not in head]:
        wanted = f"the columns {' '.join(_COLUMNS)}"
        raise CaptureError(f"no column {absent[0]}", place=f"{beside.name}:1", wanted=wanted)
    found: dict[str, dict[str, int]] = {}
    units: dict[str, None] = {}
    frames: dict[str, None] = {}
    latency: tuple[int, ...] = ()
    for column, cells in enumerate(lines):
        row = dict(zip(head, (cell.strip() for cell in cells), strict=False))
        kind, axis, point = (row.get(name, "") for name in ("type", "component", "tracked_point"))
        if kind == "LATENCY":
            latency = latency or (column,)
        if kind != "POS" or axis not in _AXES:
            continue
        if axis in found.setdefault(point, {}):
            place = f"{beside.name}:{column + 2}"
            raise CaptureError(f"{axis} of {quoted(point)} again", place=place, wanted="one each")
        found[point][axis] = column
        units[row.get("units", "")] = frames[row.get("reference_frame", "")] = None
    whole = {point: axes for point, axes in found.items() if len(axes) == len(_AXES)}
    if not whole:
        wanted = "channels of the type POS with x, y and z of a tracked point"
        raise CaptureError("no positions", place=beside.name, wanted=wanted)
    if len(units) > 1 or len(frames) > 1:
        several = units if len(units) > 1 else frames
        both = " and ".join(quoted(it) for it in several)
        raise CaptureError(f"positions in {both}", place=beside.name, wanted="the same for all")
    unit = next(iter(units))
    if unit not in UNITS:
        wanted = f"one of {', '.join(UNITS)}"
        raise CaptureError(f"positions in {quoted(unit)}", place=beside.name, wanted=wanted)
    points = tuple(axes[axis] for axes in whole.values() for axis in _AXES)
    return _Channels(tuple(whole), points, latency, len(lines), unit, next(iter(frames)))


def _axis_directions(
    file: File, channels: _Channels, sidecar: dict[str, Any]
) -> NDArray[np.float32] | None:
    """Return where x, y and z lead: how far left, up, ahead; None where the files do not say."""
    described = _object(_file_beside(file, FRAMES)).get("reference_frame")
    levels = described.get("Levels") if isinstance(described, dict) else None
    level = levels.get(channels.frame) if isinstance(levels, dict) else None
    axes = level.get("SpatialAxes") if isinstance(level, dict) else sidecar.get("SpatialAxes")
    ways = [_DIRECTIONS[it] for it in axes if it in _DIRECTIONS] if isinstance(axes, str) else []
    if len(ways) != len(_AXES) or abs(np.linalg.det(np.array(ways))) < 0.5:
        return None
    return np.array(ways, np.float32)


def files(motion: Motion, path: Path) -> Iterator[tuple[Path, bytes]]:
    """Yield the Motion-BIDS files of a motion: metres, y up; its markers, or else its joints."""
    match = _NAME.fullmatch(path.name)
    if match is None:
        raise UsageError(f'"{path.name}"', wanted=_WANTED)
    names, places = text_rows.points_of(motion)
    form = "\t".join(["%.7f"] * (3 * len(names))) + "\n"
    out = io.StringIO()
    for row in places:
        out.write((form % tuple((row.ravel() / 1000).tolist())).replace("nan", "n/a"))
    yield path, out.getvalue().encode()
    stem = path.name[: -len(ENDING)]
    lines = ["\t".join((*_COLUMNS, "reference_frame"))]
    for point in _distinct_names(names):
        lines += [f"{point}_{axis}\t{axis}\tPOS\t{point}\tm\tglobal" for axis in _AXES]
    yield path.with_name(stem + CHANNELS), ("\n".join(lines) + "\n").encode()
    frame = {"reference_frame": {"Levels": {"global": _SPACE}}}
    yield path.with_name(stem + FRAMES), _json(frame)
    rate = float(motion.rate)
    about = {
        "TaskName": match["task"],
        "TrackingSystemName": match["system"],
        "SamplingFrequency": rate,
        "RecordingDuration": len(motion) / rate,
        "TrackedPointsCount": len(names),
        "MotionChannelCount": 3 * len(names),
        "POSChannelCount": 3 * len(names),
        **{f"{kind}ChannelCount": 0 for kind in _OTHERS},
        "SamplingFrequencyEffective": rate,
        "MissingValues": "n/a",
    }
    yield path.with_name(stem + SIDECAR), _json(about)


def _json(content: dict[str, Any]) -> bytes:
    return (json.dumps(content, indent=2, ensure_ascii=False) + "\n").encode()


def _distinct_names(names: tuple[str, ...]) -> list[str]:
    """Return names without tabs, each once."""
    found: dict[str, None] = {}
    many: Counter[str] = Counter()
    for name in names:
        one = clean = " ".join(name.split()) or "point"
        while one in found:
            many[clean] += 1
            one = f"{clean} {many[clean] + 1}"
        found[one] = None
    return list(found)
