"""Where things lie in a BVH file, byte by byte, for exact clips.

Nothing here trusts the ``Frames:`` count: frames are the lines that are there.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import CaptureError
from lanindex.formats.bvh.hierarchy import Hierarchy, line_of, parse, text_of

_COUNT = re.compile(rb"\s*Frames[ \t]*:[ \t]*([^\s]*)[^\r\n]*", re.IGNORECASE)
_TIME = re.compile(rb"\s*(Frame[ \t]*Time[ \t]*:[ \t]*([^\s]*)[^\r\n]*)", re.IGNORECASE)
_BLOCK = 1 << 17  # bytes looked through at a time
_END = re.compile(rb"\r\n|\r|\n")


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """The bytes of a BVH file.

    A clip is ``data[: count[0]]``, its own number of frames, ``data[count[1] : first]``, and
    ``data[frames[i, 0] : ends[i]]`` for each frame i.

    Attributes
    ----------
    hierarchy : Hierarchy
        The joints.
    count : tuple of int
        First byte of the number behind ``Frames:``, and the one after its last.
    declared : int
        That number.
    time : str or None
        What stands behind ``Frame Time:``; None: there is no such line.
    time_line : tuple of int
        Bytes of that line, without its end; empty where there is none.
    first : int
        The byte behind the header: the line after ``Frame Time:``.
    frames : ndarray
        (T, 2) int64, first byte of each frame's line and the one after its last, without line end.
    ends : ndarray
        (T,) int64, the byte behind each line's end.
    newline : bytes
        The line end of the ``Frames:`` line.
    """

    hierarchy: Hierarchy
    count: tuple[int, int]
    declared: int
    time: str | None
    time_line: tuple[int, int]
    first: int
    frames: NDArray[np.int64]
    ends: NDArray[np.int64]
    newline: bytes


def scan(data: bytes, path: str = "") -> Layout:
    """Find the frames of a BVH file without reading their numbers.

    Parameters
    ----------
    data : bytes
        The file.
    path : str
        Its name, for errors.

    Returns
    -------
    Layout
        At least one frame.

    Raises
    ------
    CaptureError
        The hierarchy or the lines behind MOTION cannot be understood, or there are no frames.
    """
    hierarchy, motion = parse(data, path)
    if not hierarchy.width:
        raise CaptureError(
            "no joint has CHANNELS, nothing can move", place=path, wanted="a ROOT with channels"
        )
    count = _COUNT.match(data, motion)
    if count is None or not re.fullmatch(rb"[+-]?\d{1,30}", count.group(1)):
        found = "no Frames: line" if count is None else f"Frames: {text_of(count.group(1))[:40]!r}"
        line = line_of(data, motion if count is None else count.start(1))
        raise CaptureError(
            found, place=f"{path}:{line}", wanted="Frames: and a whole number behind MOTION"
        )
    time = _TIME.match(data, count.end())
    header = time or count
    newline = _END.match(data, count.end())
    behind = _END.match(data, header.end())
    first = behind.end() if behind else len(data)
    frames, ends = _lines(data, first, hierarchy.width)
    if not len(frames):
        raise CaptureError(
            "no frames",
            place=f"{path}:{line_of(data, first)}",
            wanted=f"lines of {hierarchy.width} numbers behind MOTION",
        )
    return Layout(
        hierarchy,
        count.span(1),
        int(count.group(1)),
        text_of(time.group(2)) if time else None,
        time.span(1) if time else (count.end(), count.end()),
        first,
        frames,
        ends,
        newline.group() if newline else b"\n",
    )


def _lines(data: bytes, first: int, width: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the lines that are not blank, (T, 2) without their ends, and (T,) with them."""
    text = np.frombuffer(data, np.uint8, offset=first)
    returns = data.find(b"\r", first) >= 0
    breaks = np.concatenate(
        [
            np.flatnonzero((part == 10) | (part == 13) if returns else part == 10) + start
            for start in range(0, max(len(text), 1), _BLOCK)
            for part in (text[start : start + _BLOCK],)
        ]
    )
    starts = np.concatenate(([0], breaks + 1))
    stops = np.concatenate((breaks, [len(text)]))
    ends = np.minimum(stops + 1, len(text))
    if returns:
        following = np.minimum(breaks + 1, max(len(text) - 1, 0))
        ends[:-1] += (text[breaks] == 13) & (text[following] == 10) & (following > breaks)
    keep = stops > starts
    starts, stops, ends = starts[keep], stops[keep], ends[keep]
    blank = [
        line
        for line in np.flatnonzero(stops - starts < 2 * width - 1).tolist()
        if data[first + starts[line] : first + stops[line]].isspace()
    ]
    frames = np.stack((starts, stops), axis=1) + first
    ends += first
    return (np.delete(frames, blank, axis=0), np.delete(ends, blank)) if blank else (frames, ends)
