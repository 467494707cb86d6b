"""The staff itself: its lines, bars, beats, numbers and names."""

from __future__ import annotations

from math import ceil, floor

from lanindex.draw.clock import Clock
from lanindex.draw.layout import GAP, MARGIN, START, Layout
from lanindex.draw.picture import C, Mark, Text, line

_DOUBLE = C // 5
_NAME = round(0.45 * C)
_EPS = 1e-6
_TICKS = C // 4
"""Height of a count from which on each has its tick."""


def staves(layout: Layout, clock: Clock) -> list[Mark]:
    """Return all staves without symbols."""
    marks: list[Mark] = []
    last = len(layout.edges) - 2
    inner = layout.columns.inner
    for staff in range(last + 1):
        x, base, top = layout.centre(staff), layout.base, layout.base - layout.height(staff)
        foot = base + (MARGIN + START if staff == 0 else 0)
        marks += [line(x + side, foot, x + side, top, "staff") for side in (-inner, 0, inner)]
        marks += _across(x, base, inner, double=staff == 0)
        marks += _across(x, top, inner, double=staff == last)
        marks += _counts(layout, clock, staff)
    return marks


def _across(x: int, y: int, half: int, *, double: bool) -> list[Mark]:
    ys = (y, y + _DOUBLE) if double else (y,)
    return [line(x - half, it, x + half, it, "staff") for it in ys]


def _counts(layout: Layout, clock: Clock, staff: int) -> list[Mark]:
    """Return the ticks of beats, the lines of bars, and the numbers beside them."""
    marks: list[Mark] = []
    x, inner = layout.centre(staff), layout.columns.inner
    bottom, top = layout.edges[staff : staff + 2]
    first = ceil(layout.start + bottom / layout.beat - _EPS)
    bars = ceil(C / (clock.bar * layout.beat))  # that share a number, where they stand close
    for count in range(first, floor(layout.start + top / layout.beat + _EPS) + 1):
        y = layout.base - (round((count - layout.start) * layout.beat) - bottom)
        begins, ends = y >= layout.base, y <= layout.base - (top - bottom)
        if count % clock.bar:
            if not (begins or ends) and layout.beat >= _TICKS:
                marks.append(line(x - C // 4, y, x + C // 4, y, "staff"))
            continue
        if count // clock.bar % bars:
            continue
        if not (begins or ends):
            marks.append(line(x - inner, y, x + inner, y, "light" if clock.seconds else "staff"))
        if not ends:
            at = x - layout.columns.left - GAP * 4
            marks.append(Text(at, y + C // 5, clock.number(count), C // 2 + 10, "end"))
    return marks


def names(layout: Layout) -> list[Mark]:
    """Return what stands below the first staff: what each column is for."""
    x, y = layout.centre(0), layout.base + 2 * MARGIN + START
    return [
        Text(x + at + _NAME // 3, y, name_of(part), _NAME, "under", turned=True)
        for part, at in layout.columns.places.items()
    ]


def name_of(part: str) -> str:
    """Return a part's name below its column: there its side is plain to see."""
    return part.removeprefix("r_").removeprefix("l_").removeprefix("body_").replace("_", " ")
