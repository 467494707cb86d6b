"""A picture as pages: no more staves on each than a sheet of paper that lies has room for."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import replace

from lanindex.draw.layout import MARGIN
from lanindex.draw.picture import Group, Mark, Path, Picture

RATIO = 2**0.5
"""How much wider than tall such a sheet is (ISO 216)."""


def pages(picture: Picture) -> list[Picture]:
    """Return a picture cut between staves, each page as high as it."""
    staves = picture.staves
    if len(staves) < 2:
        return [picture]
    room = picture.height * RATIO - MARGIN
    each = max(int(room // (staves[1] - staves[0])), 1)
    firsts = staves[::each]
    marks: list[list[Mark]] = [[] for _ in firsts]
    for mark in picture.marks:
        for page, own in _parted(mark, firsts):
            marks[page].append(own)
    ends = [*firsts[1:], picture.width]
    return [
        replace(
            picture,
            left=first - MARGIN,
            width=end - first + MARGIN,
            marks=tuple(own),
            staves=staves[number * each : (number + 1) * each],
        )
        for number, (first, end, own) in enumerate(zip(firsts, ends, marks, strict=True))
    ]


def _parted(mark: Mark, firsts: tuple[int, ...]) -> Iterable[tuple[int, Mark]]:
    """Yield what of a mark stands on which page: a symbol may stand on two."""
    if not isinstance(mark, Group):
        x = mark.x + (mark.lines[0][0][0] if isinstance(mark, Path) else 0)
        yield max(bisect_right(firsts, x) - 1, 0), mark
        return
    held: dict[int, list[Mark]] = {}
    for one in mark.marks:
        for page, own in _parted(one, firsts):
            held.setdefault(page, []).append(own)
    for page, some in held.items():
        yield page, replace(mark, marks=tuple(some))
