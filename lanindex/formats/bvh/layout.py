"""Where the header and the frames of a BVH file lie, byte by byte, and clips of them.

Frames are the lines that are there: the ``Frames:`` count is not trusted.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import CaptureError
from lanindex.formats.bvh.hierarchy import Hierarchy, parse
from lanindex.formats.file import Content, File, clip, holding, line_of, text_of
from lanindex.model import Reading, Span

_COUNT = re.compile(rb"\s*Frames[ \t]*:[ \t]*([^\s]*)[^\r\n]*", re.IGNORECASE)
_TIME = re.compile(rb"\s*(Frame[ \t]*Time[ \t]*:[ \t]*([^\s]*)[^\r\n]*)", re.IGNORECASE)
_BLOCK = 1 << 17  # bytes looked through at a time
_HEAD = 1 << 20  # bytes in which a header is looked for
_BEYOND = 4096  # bytes that must follow it there, lest its last line be cut
_END = re.compile(rb"\r\n|\r|\n")

Places = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class BvhLayout:
    """The bytes of a BVH file.

    A clip is ``data[: count[0]]``, its own number of frames, ``data[count[1] : first]``, and
    ``data[frames[i, 0] : ends[i]]`` for each frame i.
    """

    hierarchy: Hierarchy  # the joints
    # first byte of the number behind ``Frames:``, and the one after its last
    count: tuple[int, int]
    declared: int  # that number
    time: str | None  # what stands behind ``Frame Time:``; None: there is no such line
    time_line: tuple[int, int]  # bytes of that line, without its end; empty where there is none
    first: int  # the byte behind the header: the line after ``Frame Time:``
    # (T, 2) int64, first byte of each frame's line and the one after its last, without line end
    frames: NDArray[np.int64]
    ends: NDArray[np.int64]  # (T,) int64, the byte behind each line's end
    newline: bytes  # the line end of the ``Frames:`` line


def scan(data: Content, path: str = "") -> BvhLayout:
    """Find the frames of a BVH file without reading their numbers."""
    hierarchy, count, time, newline, first = _header(data, path)
    frames, ends = _lines(data, first, hierarchy.width)
    if not len(frames):
        raise CaptureError(
            "no frames",
            place=f"{path}:{line_of(data, first)}",
            wanted=f"lines of {hierarchy.width} numbers behind MOTION",
        )
    return BvhLayout(
        hierarchy,
        count.span(1),
        int(count.group(1)),
        text_of(time.group(2)) if time else None,
        time.span(1) if time else (count.end(), count.end()),
        first,
        frames,
        ends,
        newline,
    )


_Header = tuple[Hierarchy, re.Match[bytes], re.Match[bytes] | None, bytes, int]


def _header(data: Content, path: str) -> _Header:
    """Read what stands before the frames, of a large file as little as tells it for certain."""
    size = _HEAD
    while size < len(data):
        head = data[:size]
        try:
            found = _parsed(head, path)
        except CaptureError:  # it may be we who cut it short
            found = None
        if found is not None and len(head[found[-1] :].lstrip()) > _BEYOND:
            return found
        size *= 8
    return _parsed(data[:], path)


def _parsed(data: bytes, path: str) -> _Header:
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
    newline = _END.match(data, count.end())
    behind = _END.match(data, (time or count).end())
    first = behind.end() if behind else len(data)
    return hierarchy, count, time, newline.group() if newline else b"\n", first


def _lines(data: Content, first: int, width: int) -> tuple[Places, Places]:
    """Return the lines that are not blank, (T, 2) without their ends, and (T,) with them."""
    length = len(data)
    breaks, pairs = _breaks(data, first)
    starts = np.concatenate(([first], breaks + 1))
    stops = np.concatenate((breaks, [length]))
    ends = np.minimum(stops + 1, length)
    ends[:-1] += pairs
    del breaks, pairs
    keep = stops > starts
    if not keep.all():
        starts, stops, ends = starts[keep], stops[keep], ends[keep]
    frames = np.stack((starts, stops), axis=1)
    short = np.flatnonzero(stops - starts < 2 * width - 1)
    blank = [line for line in short.tolist() if data[starts[line] : stops[line]].isspace()]
    return (np.delete(frames, blank, axis=0), np.delete(ends, blank)) if blank else (frames, ends)


def _breaks(data: Content, first: int) -> tuple[Places, NDArray[np.bool_]]:
    """Return the bytes that end a line, and which of them are followed by their second half."""
    breaks: list[Places] = [np.zeros(0, np.int64)]
    pairs: list[NDArray[np.bool_]] = [np.zeros(0, bool)]
    for start in range(first, len(data), _BLOCK):
        stop = min(start + _BLOCK + 1, len(data))  # and the byte behind, for a pair across
        held, begin = holding(data, start, stop)
        text = np.frombuffer(held, np.uint8)[start - begin : stop - begin]
        here = text[:_BLOCK]
        returns = held.find(b"\r", start - begin, stop - begin) >= 0
        found = np.flatnonzero((here == 10) | (here == 13) if returns else here == 10)
        pair = np.zeros(len(found), bool)
        if returns:
            behind = np.append(text[1:], 0).astype(np.uint8)
            pair = (text[found] == 13) & (behind[found] == 10)
        breaks.append(found + start)
        pairs.append(pair)
    return np.concatenate(breaks), np.concatenate(pairs)


def cutter(file: File, options: Reading | None = None) -> Callable[[Span], bytes]:
    """Return what cuts clips out of a BVH file, which is looked through once."""
    data, layout = file.content, scan(file.content, file.name)
    before, after = layout.count

    def cut(span: Span) -> bytes:
        starts = layout.frames[span.start : span.stop, 0]
        ends = layout.ends[span.start : span.stop]
        gaps = np.flatnonzero(starts[1:] != ends[:-1])  # blank lines, which are left out
        runs = zip(starts[[0, *(gaps + 1)]].tolist(), ends[[*gaps, -1]].tolist(), strict=True)
        count = str(len(span)).encode()
        return clip(data, ((0, before), count, (after, layout.first), *runs))

    return cut
