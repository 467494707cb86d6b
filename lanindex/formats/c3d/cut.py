"""A stretch of a C3D file, in its own numbers.

Frames keep the numbers that they have in the source: the header tells the first one, and so does
TRIAL:ACTUAL_START_FIELD. Times of events count from the trial's frame 1, so that all events stay
as they are, those outside the clip too. Only where the numbers of frames have no room, beyond
65,535 in a file without ACTUAL_END_FIELD, do they begin with 1, and the events' times with them.

Source: *The C3D File Format, User Guide*, Motion Lab Systems (c3d.org), "EVENT:TIMES".
"""

from __future__ import annotations

import math
from collections.abc import Callable

from lanindex.formats.c3d.layout import BLOCK, C3dLayout, scan
from lanindex.formats.c3d.parameters import FULL
from lanindex.formats.file import Content, File
from lanindex.model import Reading, Span

_END = "TRIAL:ACTUAL_END_FIELD"
_EVENTS = (300, 304, 376)
"""In the header: how many events it has, and where their times begin and end."""


def cutter(file: File, options: Reading | None = None) -> Callable[[Span], bytes]:
    """Return what cuts clips out of a C3D file, whose header is looked through once."""
    layout = scan(file)
    return lambda span: cut(file.content, layout, span)


def cut(content: Content, layout: C3dLayout, span: Span) -> bytes:
    """Return the clip of some frames."""
    frames, begin = _frames(content, layout.start, layout.frame, span), 0
    turns = layout.turns
    if turns:
        end = layout.start + math.ceil(layout.frames * layout.frame / BLOCK) * BLOCK
        frames += content[end : turns.start]
        begin = math.ceil((layout.start + len(frames)) / BLOCK) + 1
        frames += bytes(-(layout.start + len(frames)) % BLOCK)
        frames += _frames(content, turns.start, turns.frame, span)
    return _head(content, layout, span, begin) + frames


def _head(content: Content, layout: C3dLayout, span: Span, begin: int) -> bytes:
    """Return header and parameters of a clip, whose rotations begin in a block."""
    parameters, write = layout.parameters, layout.parameters.processor.written
    start, frames = layout.start // BLOCK + 1, len(span)
    first = layout.first + span.start
    later = 0
    room = parameters.find(_END)
    if first + frames - 1 > FULL and (room is None or (room.count < 2 and room.kind != 4)):
        first, later = 1, first - 1
    last = first + frames - 1
    head = bytearray(content[: layout.start])
    counts = (layout.points, layout.analog, min(first, FULL), min(last, FULL))
    head[2:10] = write(counts, 2)
    head[16:18] = write([start], 2)
    data = bytearray(parameters.data[: layout.start - layout.section])
    for key, count in {
        "POINT:USED": layout.points,
        "POINT:DATA_START": start,
        "POINT:FRAMES": frames,
        "POINT:LONG_FRAMES": frames,
        "TRIAL:ACTUAL_START_FIELD": first,
        _END: last,
        "ROTATION:DATA_START": begin,
    }.items():
        parameters.put_count(data, key, count)
    if max(parameters.processor.floats(head, 1, 12)[0], -1.0) != layout.scale:
        head[12:16] = write([layout.scale], 4)
    if any(max(it, -1.0) != layout.scale for it in parameters.numbers("POINT:SCALE")):
        parameters.put(data, "POINT:SCALE", [layout.scale])
    if later and layout.rate:
        _move_events(layout, later / layout.rate, head, data)
    head[layout.section : layout.section + len(data)] = data
    return bytes(head[: layout.start])


def _move_events(layout: C3dLayout, seconds: float, head: bytearray, data: bytearray) -> None:
    """Count the times of events from a later frame on."""
    parameters = layout.parameters
    times = parameters.numbers("EVENT:TIMES")
    moved = [
        it
        for minutes, rest in zip(times[::2], times[1::2], strict=False)
        for it in (0.0, 60 * minutes + rest - seconds)
    ]
    parameters.put(data, "EVENT:TIMES", moved)
    count, start, stop = _EVENTS
    number = min(int(parameters.processor.ints(head, 1, count)[0]), (stop - start) // 4)
    if number > 0:
        earlier = parameters.processor.floats(head, number, start) - seconds
        head[start : start + 4 * number] = parameters.processor.written(earlier, 4)


def _frames(content: Content, start: int, size: int, span: Span) -> bytes:
    """Return some frames, the last block filled up but where readers count many frames by it."""
    data = content[start + span.start * size : start + span.stop * size]
    return data + bytes(-len(data) % BLOCK if len(span) <= FULL else 0)
