"""The places of a C3D file's points, a block of frames at a time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.formats.c3d.layout import TURN, Layout, Turns
from lanindex.formats.file import PIECE, Content, holding

LARGEST = 1e7
"""In units of the file: nobody is farther away, and damaged numbers are mostly larger."""

_TRANSLATION = 12
"""Where it begins in a matrix of 4 x 4, column by column."""


def places(
    content: Content, layout: Layout, chosen: NDArray[np.int64] | None = None
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
    layout: Layout,
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


def _numbers(data: bytes, at: int, layout: Layout, frames: int) -> NDArray[Any]:
    """Return the numbers of some frames, (T, N): a view unless they are DEC's floats."""
    processor = layout.parameters.processor
    count = frames * layout.frame // layout.number
    told = processor.floats if layout.scale < 0 else processor.ints
    return told(data, count, at).reshape(frames, -1)


def _segments(
    data: bytes,
    at: int,
    layout: Layout,
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
