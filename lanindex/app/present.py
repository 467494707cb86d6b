"""How hits, symbols and captures look: for a person, in a pipe, as JSON lines."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import groupby
from typing import TYPE_CHECKING, Any

from lanindex.app.screen import Screen
from lanindex.search.hits import hit_record, seconds, symbol_record

if TYPE_CHECKING:
    from lanindex.model import Capture, Hit, Symbol


def words(symbols: Iterable[Symbol]) -> str:
    """Return symbols in short: a part is named where it changes."""
    words: list[str] = []
    part = ""
    for symbol in symbols:
        name = f"{symbol.direction} {symbol.level}"
        words.append(name if symbol.part == part else f"{symbol.part} {name}")
        part = symbol.part
    return ", ".join(words)


def hits(screen: Screen, found: Iterable[Hit]) -> None:
    """Print hits: grouped by capture on a terminal, a line each elsewhere."""
    if screen.json:
        for hit in found:
            screen.record(hit_record(hit))
    elif not screen.terminal:
        for hit in found:
            record = hit_record(hit)
            keys = ("capture", "start_frame", "end_frame", "start", "end", "fit")
            screen.row([*(record[key] for key in keys), words(hit.symbols)])
    else:
        for index, (_, group) in enumerate(groupby(found, key=lambda hit: hit.capture.id)):
            if index:
                screen.out()
            _group(screen, list(group))


def _group(screen: Screen, found: list[Hit]) -> None:
    capture = found[0].capture
    label = f"  {screen.paint(capture.label, 'dim')}" if capture.label else ""
    screen.out(screen.paint(capture.path, "path") + label)
    for hit in found:
        begin, end = (seconds(capture, frame) for frame in (hit.span.start, hit.span.stop))
        time = screen.paint(f"{begin:8.2f}-{end:.2f} s", "place")
        frames = screen.paint(f"[{hit.span.start}, {hit.span.stop})", "dim")
        screen.out(f"{time}  {frames}  fit {hit.fit:.2f}  {words(hit.symbols)}")


def symbol_line(capture: Capture, symbol: Symbol) -> dict[str, Any]:
    """Return a symbol of a capture as one JSON line of ``show``."""
    return {
        "capture": capture.path,
        "capture_id": capture.id,
        "fps": round(float(capture.rate), 6),
        **symbol_record(symbol),
        "start": seconds(capture, symbol.span.start),
        "end": seconds(capture, symbol.span.stop),
        "passing": symbol.passing,
        "swings": symbol.swings,
        "margin": round(symbol.margin, 3),
        "runner_up": " ".join(symbol.runner_up) if symbol.runner_up else None,
    }


def capture_line(capture: Capture) -> dict[str, Any]:
    """Return a capture as one JSON line of ``list``."""
    return {
        "capture": capture.path,
        "capture_id": capture.id,
        "label": capture.label,
        "format": capture.format,
        "fps": round(float(capture.rate), 6),
        "frames": capture.frames,
        "seconds": seconds(capture, capture.frames),
        "sha256": capture.sha256,
        "metadata": dict(capture.metadata),
    }


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
