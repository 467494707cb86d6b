"""A stretch of a BVH file, byte for byte."""

from __future__ import annotations

from typing import Any, Protocol

from numpy.typing import NDArray

from lanindex.model import Span


class Lines(Protocol):
    """Where the bytes of a text capture lie."""

    @property
    def count(self) -> tuple[int, int]:
        """First byte of the number of frames, and the one after its last."""

    @property
    def first(self) -> int:
        """The byte behind the header."""

    @property
    def frames(self) -> NDArray[Any]:
        """(T, 2) int64, first byte of each frame's line, and the one after its last."""

    @property
    def ends(self) -> NDArray[Any]:
        """(T,) int64, the byte behind each line's end."""


def padded(span: Span, frames: int, total: int) -> Span:
    """Return a span with `frames` more on both sides, clamped to a file of `total` frames."""
    return Span(max(0, span.start - frames), min(total, span.stop + frames))


def bvh(data: bytes, lines: Lines, span: Span) -> bytes:
    """Return the clip of some frames.

    Parameters
    ----------
    data : bytes
        The whole source file.
    lines : Lines
        Where its bytes lie.
    span : Span
        Frames, not empty.

    Returns
    -------
    bytes
        Hierarchy, ``Frame Time:`` and the lines of the frames are the source's; only the number
        of frames is new.
    """
    before, after = lines.count
    starts, ends = lines.frames[span.start : span.stop, 0], lines.ends[span.start : span.stop]
    kept = (data[start:end] for start, end in zip(starts.tolist(), ends.tolist(), strict=True))
    head = data[:before] + str(len(span)).encode() + data[after : lines.first]
    return head + b"".join(kept)
