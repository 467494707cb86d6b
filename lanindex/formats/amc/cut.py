"""A stretch of an AMC file, byte for byte but for the numbers of its frames."""

from __future__ import annotations

import io
from collections.abc import Callable

from lanindex.formats.amc.layout import scan
from lanindex.formats.file import File, holding
from lanindex.model import Reading, Span

_BLOCK = 4096  # frames copied at a time


def cutter(file: File, told: Reading | None = None) -> Callable[[Span], bytes]:
    """Return what cuts clips out of an AMC file, which is looked through once.

    The header and the lines of the frames are the source's; frames count from 1. The skeleton is
    no part of it: `lanindex.formats.amc.beside` gives it.
    """
    layout = scan(file.content, file.name)

    def cut(span: Span) -> bytes:
        clip = io.BytesIO()
        clip.write(layout.header)
        for start in range(span.start, span.stop, _BLOCK):
            block = slice(start, min(start + _BLOCK, span.stop))
            stops, ends = layout.stops[block].tolist(), layout.ends[block].tolist()
            data, first = holding(file.content, stops[0], ends[-1])
            for number, (stop, end) in enumerate(zip(stops, ends, strict=True), start):
                clip.write(b"%d" % (number - span.start + 1))
                clip.write(data[stop - first : end - first])
        return clip.getvalue()

    return cut
