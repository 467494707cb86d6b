"""How hits and staves are printed: on a terminal, to a pipe, as JSON lines."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from lanindex import records
from lanindex.app.output import Output, room, wrapped

if TYPE_CHECKING:
    from lanindex.draw.text import TextStaff
    from lanindex.model import Capture, Hit, Track
    from lanindex.pipeline import Library

NARROW = 24  # least cells for the symbols of a hit to be wrapped below each other


def hits(out: Output, hits: Iterable[Hit], pattern: str) -> None:
    """Print hits: grouped by capture on a terminal, else a line each."""
    from lanindex.model.capture import in_words

    if out.json:
        out.records(records.of_hit(hit, pattern) for hit in hits)
        return
    terminal, last = out.terminal, None
    for hit in hits:
        capture, symbols = hit.capture, in_words(hit.symbols)
        begin, end = (records.seconds(capture, frame) for frame in (hit.start, hit.stop))
        if not terminal:
            times = hit.start, hit.stop, begin, end
            out.row([capture.path, *times, round(hit.fit, 3), ", ".join(symbols)])
            continue
        if capture.id != last:
            if last is not None:
                out.line()
            label = ("  ", out.paint(capture.label, "dim")) if capture.label else ()
            out.line(out.paint(capture.path, "path"), *label)
            last = capture.id
        time, frames = f"{begin:8.2f}-{end:.2f} s", f"[{hit.start}, {hit.stop})"
        fit = f"  fit {hit.fit:.2f}  "
        indent = " " * len(f"{time}  {frames}{fit}")
        left = room() - len(indent)
        first, *others = wrapped(symbols, left if left >= NARROW else sys.maxsize)
        out.line(out.paint(time, "place"), "  ", out.paint(frames, "dim"), fit, first)
        for other in others:
            out.line(indent, other)


def staff(
    out: Output, capture: Capture, tracks: dict[str, Track], parts: Sequence[str] | None
) -> None:
    """Print the staff of a capture: of some parts, or of those that move."""
    staff = _staff_of(out, capture, tracks)
    out.line(out.paint(capture.path, "path"))
    _print_staff(out, staff, parts=parts)
    out.note(staff.signs.legend)


def hits_with_staves(out: Output, library: Library, shown: Iterable[Hit], pad: str) -> None:
    """Print hits, each with the staff of the symbols around it."""
    from lanindex.pipeline.export import pad_frames, padded

    number, staff = -1, None
    for hit in shown:
        capture = hit.capture
        if staff is None or capture.id != number:
            ((_, tracks),) = library.tracks([capture.id])
            number, staff = capture.id, _staff_of(out, capture, tracks)
        hits(out, [hit], "")
        span = padded(hit.span, pad_frames(pad, capture.rate), capture.frames)
        _print_staff(out, staff, start=span.start, stop=span.stop, marked=hit.symbols)
        out.line()
    if staff is not None:
        out.note(staff.signs.legend)


def _staff_of(out: Output, capture: Capture, tracks: dict[str, Track]) -> TextStaff:
    """Return a capture's staff, in characters that standard output can print."""
    from lanindex.draw.text import ASCII, UNICODE, TextStaff
    from lanindex.model import Score

    score = Score(capture.rate, capture.frames, capture.meter, tracks)
    return TextStaff(score, UNICODE if out.unicode else ASCII)


def _print_staff(out: Output, staff: TextStaff, **stretch: Any) -> None:
    """Print some lines of a staff: `stretch` are the options of its `lines`."""
    for line in staff.lines(**stretch, width=room() if out.terminal else None):
        out.line(*(out.paint(text, style) if style else text for text, style in line))
