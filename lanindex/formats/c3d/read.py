"""C3D: points and what the file says of itself → Motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lanindex.body.mapping import Declared
from lanindex.body.markers import marker_set_of
from lanindex.formats.c3d.layout import TURN, C3dLayout, Turns, scan
from lanindex.formats.file import PIECE, Content, File, Wanted, holding
from lanindex.formats.people import named, subject_points
from lanindex.formats.points import Points, motion_of
from lanindex.formats.rates import rate_by
from lanindex.model import Motion, Reading

if TYPE_CHECKING:
    from lanindex.formats.file import File


def read(file: File, options: Reading, wanted: Wanted) -> Motion:
    """Read a C3D file: see `lanindex.formats.read_file`.

    Points that are no places, as a model's angles and forces are, are left out. Of several
    subjects the one is read that the file's name tells behind ``#``, else the first that makes a
    body.

    Joints made of markers or, where the points are joints, these; of a file that has only
    the rotations of segments, these where each begins.
    """
    layout = file.once(scan)
    rate, _ = rate_by(options, file.name, "" if layout.rate is None else str(layout.rate))
    every = names_of(layout)
    names, doubts = subject_points(file, people(layout, every), every)
    used = _needed(names) if wanted.body_only and not options.body else names
    if len(used) < layout.points or layout.segments:
        there = places(file.content, layout, np.array(list(used), np.int64))
    else:
        there = places(file.content, layout)
    doubts = (*layout.doubts, *layout.parameters.doubts, *doubts)
    points = Points(tuple(used.values()), there, rate, _declared(layout), doubts=doubts)
    motion = motion_of(points, file, "c3d", options, wanted)
    if used is names:
        return motion
    return replace(motion, source=replace(motion.source, joints=tuple(names.values())))


def _needed(names: dict[int, str]) -> dict[int, str]:
    """Return the points that the joints of the body are made of; all where it is not made."""
    numbers = list(names)
    made = marker_set_of(tuple(names.values()))
    if made is None:
        return names
    used = {numbers[it]: names[numbers[it]] for it in sorted(made.used)}
    again = marker_set_of(tuple(used.values()))
    same = again is not None and again.sources(tuple(used.values())) == made.sources(
        tuple(names.values())
    )
    return used if same else names


def _declared(layout: C3dLayout) -> Declared:
    """Return unit and vertical axis, as far as the file tells them."""
    parameters = layout.parameters
    unit = next(iter(parameters.texts("POINT:UNITS")), "") or None
    screen = next(iter(parameters.texts("POINT:Y_SCREEN")), "").lower()
    up = screen.removeprefix("+") if screen.strip("+-") in ("x", "y", "z") else None
    return Declared(unit, up)


NO_PLACES = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "REACTIONS")
"""Lists of POINT that name points which are no places, but what a model tells of the body."""

_PLACES = {"MODELED_MARKER", "MARKER", "VIRTUAL_MARKER"}
TURNED = "_4X4"
"""Ends the name of a segment."""


def names_of(layout: C3dLayout) -> dict[int, str]:
    """Return the names of the points that are places, by their number in a frame.

    A point that has no name is called by its number, a segment without what ends its name.
    """
    parameters = layout.parameters
    if layout.segments:
        called = parameters.texts("ROTATION:LABELS")
        return {number: name.removesuffix(TURNED)
                for number, name in enumerate(_all(called, layout.segments.count))}  # fmt: skip
    groups = parameters.texts("POINT:TYPE_GROUPS")
    listed = [group.upper() for group, kind in zip(groups[::2], groups[1::2], strict=False)
              if kind.upper() not in _PLACES]  # fmt: skip
    lists = dict.fromkeys((*NO_PLACES, *listed))
    outputs = {name for one in lists for name in parameters.texts(f"POINT:{one}")}
    points = _all(parameters.texts("POINT:LABELS"), layout.points)
    return {number: name for number, name in enumerate(points) if name not in outputs}


def _all(called: tuple[str, ...], count: int) -> list[str]:
    """Return as many names as there are points: what is named beyond them is not stored."""
    named = [name or f"*{number}" for number, name in enumerate(called[:count], 1)]
    return named + [f"*{number}" for number in range(len(named) + 1, count + 1)]


def people(layout: C3dLayout, names: Mapping[int, str]) -> dict[str, dict[int, str]]:
    """Return the points of each subject that makes a body."""
    parameters = layout.parameters
    called = parameters.texts("SUBJECTS:NAMES")
    before = parameters.texts("SUBJECTS:LABEL_PREFIXES")
    subject = {prefix: name for prefix, name in zip(before, called, strict=False) if prefix}
    groups: dict[str, dict[int, str]] = {}
    for number, name in names.items():
        prefix = next((it for it in subject if name.startswith(it)), None)
        if prefix is None:
            prefix = name[: name.rfind(":") + 1]
        groups.setdefault(prefix, {})[number] = name
    found: dict[str, dict[int, str]] = {}
    for prefix, points in groups.items():
        bare = {number: name.removeprefix(prefix) for number, name in points.items()}
        if marker_set_of(tuple(bare.values())):
            alone = called[0] if not prefix and len(called) == 1 else ""
            name = subject.get(prefix, prefix.rstrip(":")) or alone
            name = f"{name} {len(found) + 1}".strip() if name in found else name
            found[name] = points if prefix.endswith(":") else bare
    return named(found)


def subjects(file: File) -> tuple[str, ...]:
    """Return the names of the people that a file holds; none where nobody is named."""
    layout = file.once(scan)
    return tuple(name for name in people(layout, names_of(layout)) if name)


LARGEST = 1e7
"""In units of the file: nobody is farther away, and damaged numbers are mostly larger."""

_TRANSLATION = 12
"""Where it begins in a matrix of 4 x 4, column by column."""


def places(
    content: Content, layout: C3dLayout, chosen: NDArray[np.int64] | None = None
) -> NDArray[np.float32]:
    """Return where points are.

    Takes `chosen` (K,); returns (T, K, 3).
    """
    turns = layout.segments
    width = turns.count if turns else layout.points
    there = np.empty((layout.frames, width if chosen is None else len(chosen), 3), np.float32)
    start, size = (turns.start, turns.frame) if turns else (layout.start, layout.frame)
    step = max(1, PIECE // size)
    for first in range(0, layout.frames, step):
        stop = min(first + step, layout.frames)
        data, offset = holding(content, start + first * size, start + stop * size)
        at = start + first * size - offset
        out = there[first:stop]
        if turns:
            _segments(data, at, layout, turns, chosen, out)
        else:
            _points(data, at, layout, chosen, out)
    return there


def _points(
    data: bytes,
    at: int,
    layout: C3dLayout,
    chosen: NDArray[np.int64] | None,
    out: NDArray[np.float32],
) -> None:
    """Read the points of some frames, of which the first begins at a byte."""
    table = _numbers(data, at, layout, len(out))
    rows = table[:, : 4 * layout.points].reshape(len(out), layout.points, 4)
    rows = rows if chosen is None else rows.take(chosen, axis=1)
    behind = rows[..., 3]
    with np.errstate(invalid="ignore", over="ignore"):  # of damaged files
        for axis in range(3):  # one after the other: five times as fast as three at a time
            if layout.scale < 0:
                out[..., axis] = rows[..., axis]
            else:
                np.multiply(rows[..., axis], np.float32(layout.scale), out=out[..., axis])
        _far(out)
        _take_out(out, behind < 0)
    nothing = (behind == 0) & (out[..., 0] == 0)
    if nothing.any():
        _take_out(out, nothing & (out[..., 1] == 0) & (out[..., 2] == 0))


def _numbers(data: bytes, at: int, layout: C3dLayout, frames: int) -> NDArray[Any]:
    """Return the numbers of some frames, (T, N): a view unless they are DEC's floats."""
    processor = layout.parameters.processor
    count = frames * layout.frame // layout.number
    numbers = processor.floats if layout.scale < 0 else processor.ints
    return numbers(data, count, at).reshape(frames, -1)


def _segments(
    data: bytes,
    at: int,
    layout: C3dLayout,
    turns: Turns,
    chosen: NDArray[np.int64] | None,
    out: NDArray[np.float32],
) -> None:
    """Read the places of segments in some frames: of several in a frame, the first."""
    count = len(out) * turns.frame // 4
    numbers = layout.parameters.processor.floats(data, count, at)
    rows = numbers.reshape(len(out), turns.ratio, turns.count, TURN)[:, 0]
    rows = rows if chosen is None else rows.take(chosen, axis=1)
    with np.errstate(invalid="ignore"):
        for axis in range(3):
            out[..., axis] = rows[..., _TRANSLATION + axis]
        _far(out)
        _take_out(out, rows[..., -1] < 0)


def _far(out: NDArray[np.float32]) -> None:
    """Take out what is no place, where there is such a thing."""
    if not (out.max(initial=0) <= LARGEST and out.min(initial=0) >= -LARGEST):
        _take_out(out, np.asarray(~(np.abs(out) <= LARGEST).all(axis=2)))


def _take_out(out: NDArray[np.float32], unknown: NDArray[np.bool_]) -> None:
    if unknown.any():
        out[unknown] = np.nan
