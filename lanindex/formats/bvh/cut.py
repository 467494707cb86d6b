"""A stretch of a BVH file, byte for byte."""

from __future__ import annotations

from collections.abc import Callable

from lanindex.formats.bvh.layout import Layout, scan
from lanindex.formats.file import File
from lanindex.model import Span


def cutter(file: File) -> Callable[[Span], bytes]:
    """Return what cuts clips out of a BVH file, which is looked through once.

    Raises
    ------
    CaptureError
        The file cannot be read.
    """
    layout = scan(file.content, file.name)
    return lambda span: cut(file.content, layout, span)


def cut(data: bytes, layout: Layout, span: Span) -> bytes:
    """Return the clip of some frames.

    Parameters
    ----------
    data : bytes
        The whole source file.
    layout : Layout
        Where its bytes lie.
    span : Span
        Frames, not empty.

    Returns
    -------
    bytes
        Hierarchy, ``Frame Time:`` and the lines of the frames are the source's; only the number
        of frames is new.
    """
    before, after = layout.count
    starts, ends = layout.frames[span.start : span.stop, 0], layout.ends[span.start : span.stop]
    kept = (data[start:end] for start, end in zip(starts.tolist(), ends.tolist(), strict=True))
    head = data[:before] + str(len(span)).encode() + data[after : layout.first]
    return head + b"".join(kept)
