"""A score as a picture, and two of them beside each other."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from lanindex.alphabet import kind_of
from lanindex.draw.layout import (
    BEAT,
    MARGIN,
    TimeAxis,
    has_column,
    page_layout,
    staff_columns,
    usual_tracks,
)
from lanindex.draw.picture import C, Label, Mark, Picture
from lanindex.draw.staff import (
    LEGEND_WIDTH,
    SymbolPainter,
    keys_of,
    legend_rows,
    names,
    short,
    staves,
)
from lanindex.errors import UsageError
from lanindex.model import Score, Symbol
from lanindex.model.derived import STEP

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
    clock = TimeAxis(score, seconds)
    edges = clock.at(start), clock.at(last)
    layout = page_layout(clock, *edges, bars, staff_columns(drawn), beat)
    marked = list(marked)
    hidden = sorted({it.part for it in marked} - {*drawn, STEP})
    missing += tuple(
        f"{part} is marked and not drawn: ask for it among the parts" for part in hidden
    )
    symbols, more = SymbolPainter(score, clock, layout, keys_of(score, marked)).marks(drawn)
    count = f"{len(symbols)} symbols" if len(symbols) != 1 else "1 symbol"
    summary = f"Labanotation, time upwards: {short(last - start)} s, {count}"
    named = f"{summary} of {', '.join(drawn)}"
    marks = (*more, *staves(layout, clock), *names(layout), *symbols)
    width, height = layout.size
    if legend:
        kinds = {kind_of(part) for part in drawn}
        rows, tall = legend_rows(kinds, width, MARGIN, marked=bool(marked))
        marks, width, height = (
            (*marks, *rows),
            width + LEGEND_WIDTH,
            max(height, tall + 2 * MARGIN),
        )
    return Picture(width, height, title or "score", named, marks, missing, layout.staves)


def chosen(score: Score, parts: Sequence[str] | None) -> tuple[list[str], tuple[str, ...]]:
    """Return the tracks that are drawn, and warnings about others."""
    there = [part for part in score.tracks if len(score.tracks[part])]
    if not there:
        raise UsageError("an empty score", wanted="a symbol in it")
    if parts is None:
        odd = [part for part in there if part != STEP and not has_column(part)]
        drawn = [part for part in usual_tracks(there) if has_column(part)]
        if not drawn:
            raise UsageError(f"no column for {', '.join(there)}", wanted="a part that has one")
        return drawn, tuple(f"no column for {part}: it is not drawn" for part in odd)
    for part in parts:
        if part not in score.tracks:
            wanted = f"one of {' '.join(there)}"
            raise UsageError(f'there is no part "{part}"', wanted=wanted)
        if not has_column(part):
            raise UsageError(f"no column for {part}", wanted="a part that has one")
    return [part for part in score.tracks if part in parts], ()


LETTERS = ("A", "B")
"""What stands above the staves of either."""


def draw_pair(
    scores: Sequence[Score],
    marked: Sequence[Iterable[Symbol]],
    *,
    titles: Sequence[str] = LETTERS,
    parts: Sequence[str] | None = None,
    start: float = 0.0,
    stop: float | None = None,
    bars: int | None = BARS,
    seconds: bool = True,
) -> Picture:
    """Draw two scores beside each other, in the same columns and at the same heights."""
    end = max(float(score.frames / score.rate) for score in scores)
    last = end if stop is None else min(stop, end)
    if not 0 <= start < last:
        found = f"nothing from {start:g} s to {last:g} s"
        raise UsageError(found, wanted=f"a stretch of 0 to {end:g} s")
    own = [
        chosen(score, None if parts is None else [it for it in parts if it in score.tracks])
        for score in scores
    ]
    clocks = [TimeAxis(score, seconds) for score in scores]
    begins, ends = clocks[0].at(start), max(clock.at(last) for clock in clocks)
    shared = staff_columns([part for drawn, _ in own for part in drawn])
    paper = page_layout(clocks[0], begins, ends, bars, shared)
    marks, counts = list[Mark](), list[str]()
    for number, (score, (drawn, _), clock) in enumerate(zip(scores, own, clocks, strict=True)):
        layout = replace(paper, score=number, scores=len(scores))
        symbols, more = SymbolPainter(score, clock, layout, keys_of(score, marked[number])).marks(
            drawn
        )
        named = [
            Label(layout.centre(it), MARGIN + C // 4, LETTERS[number], C // 2)
            for it in range(len(layout.edges) - 1)
        ]
        marks += [*more, *staves(layout, clock), *names(layout), *named, *symbols]
        counts.append(f"{LETTERS[number]}: {len(symbols)} symbol{'s' * (len(symbols) != 1)}")
    summary = f"{', '.join(counts)}; Labanotation, time upwards: {short(last - start)} s"
    said = dict.fromkeys(line for _, missing in own for line in missing)
    title = ", ".join(f"{name}: {it}" for name, it in zip(LETTERS, titles, strict=True))
    shared_paper = replace(paper, scores=len(scores))
    return Picture(
        *shared_paper.size, title, summary, tuple(marks), tuple(said), shared_paper.staves
    )
