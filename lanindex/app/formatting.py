"""How hits, symbols and captures look: for a person, in a pipe, as JSON lines."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import groupby
from typing import TYPE_CHECKING

from lanindex import records
from lanindex.app.output import Output

if TYPE_CHECKING:
    from lanindex.model import Hit, Symbol


def words(symbols: Iterable[Symbol]) -> str:
    """Return symbols in short: a part is named where it changes."""
    words: list[str] = []
    part = ""
    for symbol in symbols:
        name = symbol.words
        words.append(name if symbol.part == part else f"{symbol.part} {name}")
        part = symbol.part
    return ", ".join(words)


def hits(out: Output, found: Iterable[Hit]) -> None:
    """Print hits: grouped by capture on a terminal, a line each elsewhere."""
    if out.json:
        for hit in found:
            out.record(records.of_hit(hit))
    elif not out.terminal:
        for hit in found:
            record = records.of_hit(hit)
            keys = ("capture", "start_frame", "end_frame", "start", "end", "fit")
            out.row([*(record[key] for key in keys), words(hit.symbols)])
    else:
        for index, (_, group) in enumerate(groupby(found, key=lambda hit: hit.capture.id)):
            if index:
                out.line()
            _group(out, list(group))


def _group(out: Output, found: list[Hit]) -> None:
    capture = found[0].capture
    label = ("  ", out.paint(capture.label, "dim")) if capture.label else ()
    out.line(out.paint(capture.path, "path"), *label)
    for hit in found:
        begin, end = (records.seconds(capture, frame) for frame in (hit.span.start, hit.span.stop))
        time = out.paint(f"{begin:8.2f}-{end:.2f} s", "place")
        frames = out.paint(f"[{hit.span.start}, {hit.span.stop})", "dim")
        out.line(time, "  ", frames, f"  fit {hit.fit:.2f}  {words(hit.symbols)}")


def duration(value: float) -> str:
    """Return a time as a person says it: 3.2 s, 4:05 min, 2:10 h."""
    if value < 60:
        return f"{value:.1f} s"
    whole = round(value)
    if whole < 3600:
        return f"{whole // 60}:{whole % 60:02d} min"
    return f"{whole // 3600}:{whole % 3600 // 60:02d} h"


def counted(number: int, noun: str) -> str:
    """Return ``1 hit``, ``2 hits``."""
    return f"{number:,} {noun}" + ("" if number == 1 else "s")
