"""How hits, symbols and captures look: for a person, in a pipe, as JSON lines."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from itertools import groupby
from typing import TYPE_CHECKING

from lanindex import records
from lanindex.app.columns import room, wrapped
from lanindex.app.output import Output
from lanindex.model.capture import in_words

if TYPE_CHECKING:
    from lanindex.model import Hit, Symbol
    from lanindex.search.explain import Trace


NARROW = 24
"""Cells that the symbols of a hit need at least, to hang below each other."""


def words(symbols: Iterable[Symbol]) -> str:
    """Return symbols in short: a part is named where it changes."""
    return ", ".join(in_words(symbols))


def hits(out: Output, found: Iterable[Hit], pattern: str) -> None:
    """Print the hits of a pattern: grouped by capture on a terminal, a line each elsewhere."""
    if out.json:
        for hit in found:
            out.record(records.of_hit(hit, pattern))
    elif not out.terminal:
        for hit in found:
            capture, (start, stop) = hit.capture, (hit.start, hit.stop)
            times = records.seconds(capture, start), records.seconds(capture, stop)
            fit = round(hit.fit, 3)
            out.row([capture.path, start, stop, *times, fit, words(hit.symbols)])
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
        time, frames = f"{begin:8.2f}-{end:.2f} s", f"[{hit.span.start}, {hit.span.stop})"
        fit = f"  fit {hit.fit:.2f}  "
        before = len(f"{time}  {frames}{fit}")
        left = room() - before
        first, *others = wrapped(in_words(hit.symbols), left if left >= NARROW else sys.maxsize)
        out.line(out.paint(time, "place"), "  ", out.paint(frames, "dim"), fit, first)
        for other in others:
            out.line(" " * before + other)


def trace(out: Output, seen: Trace) -> None:
    """Print what a pattern met with in one capture: its steps, or where it came to an end."""
    from lanindex.search.explain.why import doubts

    out.line(out.paint(seen.capture.path, "path"))
    for hit, steps in seen.hits:
        out.line(out.paint(hit.when, "place"), f"  fit {hit.fit:.2f}")
        width = max(len(it.step) for it in steps)
        for matched in steps:
            said = "; ".join(f"{it}, {doubts(it)}" for it in matched.symbols)
            out.line("  ", matched.step.ljust(width), "  " if width else "", said or "left out")
    for stop in seen.stops:
        if stop.reached:
            out.line("found:      ", stop.reached)
        out.line("not found:  ", stop.wanted)
        out.line("  ", stop.reason)


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
