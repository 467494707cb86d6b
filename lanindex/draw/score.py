"""All symbols of a score on their staves."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from lanindex.alphabet import kind_of
from lanindex.draw import columns as places
from lanindex.draw import legend as meanings
from lanindex.draw import staff
from lanindex.draw.clock import Clock
from lanindex.draw.layout import BEAT, MARGIN, laid_out
from lanindex.draw.page import Page, keys_of, short
from lanindex.draw.picture import Picture
from lanindex.errors import UsageError
from lanindex.model import Score, Symbol
from lanindex.model.steps import STEP

BARS = 4
"""Bars of a staff."""


def draw(
    score: Score,
    *,
    title: str = "",
    parts: Sequence[str] | None = None,
    start: float = 0.0,
    stop: float | None = None,
    bars: int | None = BARS,
    seconds: bool = False,
    marked: Iterable[Symbol] = (),
    legend: bool = False,
    beat: int = BEAT,
) -> Picture:
    """Draw a score."""
    end = float(score.frames / score.rate)
    last = end if stop is None else min(stop, end)
    if not 0 <= start < last:
        raise UsageError(
            f"nothing from {start:g} s to {last:g} s", wanted=f"a stretch of 0 to {end:g} s"
        )
    drawn, missing = chosen(score, parts)
    clock = Clock(score, seconds)
    edges = clock.at(start), clock.at(last)
    layout = laid_out(clock, *edges, bars, places.columns(drawn), beat)
    marked = list(marked)
    hidden = sorted({it.part for it in marked} - {*drawn, STEP})
    missing += tuple(
        f"{part} is marked and not drawn: ask for it among the parts" for part in hidden
    )
    symbols, more = Page(score, clock, layout, keys_of(score, marked)).marks(drawn)
    count = f"{len(symbols)} symbols" if len(symbols) != 1 else "1 symbol"
    summary = f"Labanotation, time upwards: {short(last - start)} s, {count}"
    named = f"{summary} of {', '.join(drawn)}"
    marks = (*more, *staff.staves(layout, clock), *staff.names(layout), *symbols)
    width, height = layout.size
    if legend:
        kinds = {kind_of(part) for part in drawn}
        rows, tall = meanings.legend(kinds, width, MARGIN, marked=bool(marked))
        marks, width, height = (
            (*marks, *rows),
            width + meanings.WIDTH,
            max(height, tall + 2 * MARGIN),
        )
    return Picture(width, height, title or "score", named, marks, missing, layout.staves)


def chosen(score: Score, parts: Sequence[str] | None) -> tuple[list[str], tuple[str, ...]]:
    """Return which tracks are drawn, and what is to say of others."""
    there = [part for part in score.tracks if len(score.tracks[part])]
    if not there:
        raise UsageError("an empty score", wanted="a symbol in it")
    if parts is None:
        odd = [part for part in there if part != STEP and not places.known(part)]
        drawn = [part for part in places.usual(there) if places.known(part)]
        if not drawn:
            raise UsageError(f"no column for {', '.join(there)}", wanted="a part that has one")
        return drawn, tuple(f"no column for {part}: it is not drawn" for part in odd)
    for part in parts:
        if part not in score.tracks:
            wanted = f"one of {' '.join(there)}"
            raise UsageError(f'there is no part "{part}"', wanted=wanted)
        if not places.known(part):
            raise UsageError(f"no column for {part}", wanted="a part that has one")
    return [part for part in score.tracks if part in parts], ()
