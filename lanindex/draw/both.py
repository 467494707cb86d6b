"""Two scores beside each other: of each staff that of the one, and right of it the other's."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from lanindex.draw import columns as places
from lanindex.draw import staff
from lanindex.draw.clock import Clock
from lanindex.draw.layout import MARGIN, laid_out
from lanindex.draw.page import Page, keys_of, short
from lanindex.draw.picture import C, Mark, Picture, Text
from lanindex.draw.score import BARS, chosen
from lanindex.errors import UsageError
from lanindex.model import Score, Symbol

NAMES = ("A", "B")
"""What stands above the staves of either."""


def both(
    scores: Sequence[Score],
    marked: Sequence[Iterable[Symbol]],
    *,
    titles: Sequence[str] = NAMES,
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
    clocks = [Clock(score, seconds) for score in scores]
    begins, ends = clocks[0].at(start), max(clock.at(last) for clock in clocks)
    shared = places.columns([part for drawn, _ in own for part in drawn])
    paper = laid_out(clocks[0], begins, ends, bars, shared)
    marks, counts = list[Mark](), list[str]()
    for number, (score, (drawn, _), clock) in enumerate(zip(scores, own, clocks, strict=True)):
        layout = replace(paper, score=number, scores=len(scores))
        symbols, more = Page(score, clock, layout, keys_of(score, marked[number])).marks(drawn)
        named = [
            Text(layout.centre(it), MARGIN + C // 4, NAMES[number], C // 2)
            for it in range(len(layout.edges) - 1)
        ]
        marks += [*more, *staff.staves(layout, clock), *staff.names(layout), *named, *symbols]
        counts.append(f"{NAMES[number]}: {len(symbols)} symbol{'s' * (len(symbols) != 1)}")
    summary = f"{', '.join(counts)}; Labanotation, time upwards: {short(last - start)} s"
    said = dict.fromkeys(line for _, missing in own for line in missing)
    title = ", ".join(f"{name}: {it}" for name, it in zip(NAMES, titles, strict=True))
    shared_paper = replace(paper, scores=len(scores))
    return Picture(
        *shared_paper.size, title, summary, tuple(marks), tuple(said), shared_paper.staves
    )
