"""What is on a page beside what is read: ink where no column is, names of none, gaps of staves.

Nothing on a page is passed over in silence: what this finds is told with its place.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import dist

import cv2
import numpy as np

from lanindex.draw.picture import C
from lanindex.draw.staff import MARGIN, NAME, NUMBERS, PITCH
from lanindex.errors import counted
from lanindex.reader.layout import BELOW, Layout
from lanindex.reader.names import SCALE, WIDEST, names_below, unlike
from lanindex.reader.signs import Sign
from lanindex.reader.staff import Staff
from lanindex.reader.templates import SIZE

Ends = tuple[float, float]

_INK = 0.4  # darkness from which on ink counts
_HALF = 0.62  # widths of a symbol on either side of a column's middle that are its own
_HIGH, _WIDE = 0.6, 0.4  # widths of a symbol: lower is a bar's number, narrower is a line
_DEEP = 6  # pixels above and below what stands across columns that are its own: of bows, too
_NAME = 0.38  # widths of a symbol on either side of its middle that are its name's
_GAP = 1.6  # times the usual distance of staves from which on one is missing
_NEXT = 1.0  # widths of a symbol beyond the last column that may be one without a name


def strange(
    staves: Sequence[Staff], page: Layout, signs: Sequence[Sign]
) -> Iterator[tuple[Ends, Ends]]:
    """Yield where ink is and no column: widths of a symbol from the centre line, and counts."""
    ink = (page.ink > _INK).astype(np.uint8)
    base = len(ink) - BELOW
    xs = (np.arange(ink.shape[1]) + 0.5) / SIZE - WIDEST
    for column in page.columns:
        ink[:, np.abs(xs - column.x) < _HALF] = 0
    for sign in signs:
        if sign.column not in page.columns:  # it stands across some
            rows = [round(base - it * page.rows) for it in (sign.end, sign.start)]
            near = np.abs(xs - sign.column.x) < sign.column.half + 0.1
            ink[max(rows[0] - _DEEP, 0) : rows[1] + _DEEP, near] = 0
    rows = [round(base - it * page.rows) for it in page.counts]
    rows[0] += round((staves[0].foot - staves[0].base) / staves[0].inner / page.unit * SIZE)
    ink[rows[0] :] = 0
    for (foot, top), (begin, end) in zip(pairwise(rows), _own(staves, page), strict=True):
        ink[top:foot, (xs < begin) | (xs > end)] = 0
        ink[top] = 0
    _, _, boxes, _ = cv2.connectedComponentsWithStats(ink)
    for x, y, wide, high, _ in boxes[1:].tolist():
        if wide > _WIDE * SIZE and high > _HIGH * SIZE:
            xs_of = x / SIZE - WIDEST, (x + wide) / SIZE - WIDEST
            yield xs_of, ((base - y - high) / page.rows, (base - y) / page.rows)


def unknown_names(staves: Sequence[Staff], page: Layout) -> Iterator[str]:
    """Yield names below staves that are not known, or doubtful."""
    for number, (staff, (begin, end)) in enumerate(zip(staves, _own(staves, page), strict=True), 1):
        ink = (names_below(staff, page.unit * staff.inner / C) > _INK).astype(np.uint8)
        xs = (np.arange(ink.shape[1]) + 0.5) / SCALE / C - WIDEST
        ink[:, (xs < begin) | (xs > end)] = 0
        for column in page.columns:
            ink[:, np.abs(xs - column.x) < _NAME] = 0
        words = cv2.morphologyEx(ink, cv2.MORPH_CLOSE, np.ones((9, 3), np.uint8))  # of letters
        _, _, boxes, _ = cv2.connectedComponentsWithStats(words)
        least = np.array([NAME / 3, NAME]) * SCALE
        if found := int((boxes[1:, 2:4] > least).all(axis=1).sum()):
            yield f"below staff {number}: {counted(found, 'name')} of a column not known"
    for column in unlike(staves, page.unit, page.columns):
        yield f"below the staves: a name that is read as {column.part}, and hardly like it"


def missing_staves(staves: Sequence[Staff], page: Layout) -> Iterator[str]:
    """Yield between which staves there is room for more."""
    left, right = _reach(page)
    usual = left + right + (NUMBERS + MARGIN) / C
    for number, pitch in enumerate(_pitches(staves, page), 1):
        if pitch > _GAP * usual:
            yield f"between staff {number} and {number + 1}: room for a staff, and none is found"


def _own(staves: Sequence[Staff], page: Layout) -> Iterator[tuple[float, float]]:
    """Yield from where to where a staff's own place is, widths of a symbol: the next one's begins.

    Before the first staff and behind the last one a column may be that has no name.
    """
    left, right = _reach(page)
    ends = [*(it - left for it in _pitches(staves, page)), right + _NEXT]
    yield from zip([-left - _NEXT, *[-left] * (len(staves) - 1)], ends, strict=True)


def _reach(page: Layout) -> tuple[float, float]:
    """Return how far columns go to the left and to the right, widths of a symbol."""
    most = [1 / page.unit, 1 / page.unit]
    for it in page.columns:
        most[it.x > 0] = max(most[it.x > 0], abs(it.x) + PITCH / C / 2)
    return most[0], most[1]


def _pitches(staves: Sequence[Staff], page: Layout) -> Iterator[float]:
    """Yield from each staff's centre line to the next one's, widths of a symbol."""
    for one, other in pairwise(staves):
        left, right = (one.on_page(one.centre + side * one.inner, one.base) for side in (-1, 1))
        centres = [it.on_page(it.centre, it.base) for it in (one, other)]
        yield 2 * dist(*centres) / dist(left, right) / page.unit
