"""A stretch of a BVH file, byte for byte."""

from __future__ import annotations

import io
from collections.abc import Callable

from lanindex.formats.bvh.layout import Layout, scan
from lanindex.formats.file import Content, File
from lanindex.model import Reading, Span

_BLOCK = 4096  # frames copied at a time


def cutter(file: File, told: Reading | None = None) -> Callable[[Span], bytes]:
    """Return what cuts clips out of a BVH file, which is looked through once."""
    layout = scan(file.content, file.name)
    return lambda span: cut(file.content, layout, span)


def cut(data: Content, layout: Layout, span: Span) -> bytes:
    """Return the clip of some frames."""
    before, after = layout.count
    clip = io.BytesIO()
    clip.write(data[:before] + str(len(span)).encode() + data[after : layout.first])
    for start in range(span.start, span.stop, _BLOCK):
        stop = min(start + _BLOCK, span.stop)
        starts, ends = layout.frames[start:stop, 0], layout.ends[start:stop]
        first, last = int(starts[0]), int(ends[-1])
        piece = data[first:last]
        if (starts[1:] == ends[:-1]).all():
            clip.write(piece)
            continue
        for begin, end in zip((starts - first).tolist(), (ends - first).tolist(), strict=True):
            clip.write(piece[begin:end])  # what stands between is left out
    return clip.getvalue()
