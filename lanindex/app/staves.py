"""Staves on the terminal: of a capture, and of what lies around hits."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from lanindex.app.columns import room
from lanindex.app.output import Output

if TYPE_CHECKING:
    from lanindex.draw.text import Line, Staff
    from lanindex.model import Capture, Hit, Track
    from lanindex.pipeline import Library

Tracks = dict[str, "Track"]


def staff_of(out: Output, capture: Capture, tracks: Tracks) -> Staff:
    """Return a capture's staff, in characters that standard output has."""
    from lanindex.draw.text import ASCII, UNICODE, Staff
    from lanindex.model import Score

    score = Score(capture.rate, capture.frames, capture.meter, tracks)
    return Staff(score, UNICODE if out.unicode else ASCII)


def whole(out: Output, capture: Capture, tracks: Tracks, parts: Sequence[str] | None) -> None:
    """Print the staff of a capture, of some parts or of those that move."""
    staff = staff_of(out, capture, tracks)
    out.line(out.paint(capture.path, "path"))
    _print(out, staff.lines(parts=parts, width=_width(out)))
    out.note(staff.signs.legend)


def check(pad: str) -> None:
    """Refuse what is no time around hits."""
    from fractions import Fraction

    from lanindex.pipeline.export import pad_frames

    pad_frames(pad, Fraction(1), "--context")


def around(out: Output, library: Library, hits: Iterable[Hit], pad: str) -> None:
    """Print hits, and below each the staff of what lies around it."""
    from lanindex.app import formatting
    from lanindex.pipeline.export import pad_frames, padded

    held, staff = -1, None
    for hit in hits:
        capture = hit.capture
        if staff is None or capture.id != held:
            ((_, tracks),) = library.tracks([capture.id])
            held, staff = capture.id, staff_of(out, capture, tracks)
        formatting.hits(out, [hit], "")
        span = padded(hit.span, pad_frames(pad, capture.rate), capture.frames)
        _print(out, staff.lines(span.start, span.stop, marked=hit.symbols, width=_width(out)))
        out.line()
    if staff is not None:
        out.note(staff.signs.legend)


def _width(out: Output) -> int | None:
    return room() if out.terminal else None


def _print(out: Output, lines: Iterable[Line]) -> None:
    for line in lines:
        pieces: list[Any] = [out.paint(text, style) if style else text for text, style in line]
        out.line(*pieces)
