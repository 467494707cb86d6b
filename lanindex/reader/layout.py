"""Where columns and counts lie on the staves of a page, and their ink as that of one staff."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from operator import attrgetter
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from lanindex.draw.picture import C
from lanindex.draw.staff import DOUBLE
from lanindex.reader.names import WIDEST, Column, columns
from lanindex.reader.staff import LONGEST, Staff
from lanindex.reader.templates import SIZE, Floats, Name, mend

BELOW = 6 * SIZE
"""Rows of ink below the first staff: there the starting position is."""

NEAR = SIZE // 2
"""Rows of ink above and below the base of a staff that are kept as they are."""

_BLACK = 0.6  # darkness of a line across from which on nothing is seen through it


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """What the staves of a page show, and how time lies on them."""

    unit: float  # Width of a symbol, by the distance from the centre line to the outer ones
    counts: list[float]  # At the base of each staff, and at the top of the last
    columns: list[Column]
    named: bool  # Whether names say which they are; else their places do
    # (H, W) darkness without the staves' lines, of all staves as of one: time upwards, `SIZE` to a
    # symbol's width, the centre line in the middle; the last `BELOW` rows lie below the base
    ink: Floats
    lines: list[int]  # Rows of bar lines and ticks, of the base and the tops
    bars: list[int]  # Of those, bar lines and the base
    ends: list[int]  # Rows at which a staff continues on the next one
    # For each of these, (2 * `NEAR`, W) darkness around the top of that staff, and the next's base
    tops: list[Floats]
    bases: list[Floats]
    rows: float  # Rows of a count


@dataclass(frozen=True, slots=True)
class Piece:
    """A stretch of ink in a column, or across some, rows half-open from its top."""

    top: float
    foot: float
    name: Name | None  # None: it is like no sign
    likeness: float  # 0 to 1


def layout(staves: Sequence[Staff]) -> Layout:
    """Return how the staves of a page are laid out."""
    unit, parts, named = columns(staves)
    inks = [_without_lines(staff, unit) for staff in staves]
    beat = _beat(staves)
    counts = [0.0]
    for staff in staves:
        counts.append(counts[-1] + (staff.base - staff.top) / staff.inner / beat)
    tall, tops, bases = _joined(staves, inks, unit, beat, counts)
    rows = (len(tall) - BELOW) / counts[-1]
    bars, ticks = (
        [
            begin + (staff.base - it) / staff.inner / beat
            for staff, begin in zip(staves, counts, strict=False)
            for it in own(staff)
        ]
        for own in (attrgetter("bars"), attrgetter("ticks"))
    )
    cuts, across, ends = (
        [round(len(tall) - BELOW - it * rows) for it in own]
        for own in ([*counts, *bars, *ticks], [*counts, *bars], counts[1:-1])
    )
    return Layout(unit, counts, parts, named, tall, cuts, across, ends, tops, bases, rows)


def _without_lines(staff: Staff, unit: float) -> Floats:
    """Return darkness, (H, W), of a staff without its own lines."""
    ink = (255 - staff.image.astype(np.float32)) / np.float32(255)
    double = unit * staff.inner * DOUBLE / C
    seconds = [staff.base + double] * staff.first + [staff.top + double] * staff.last
    half, width = staff.stroke / 2 + 1, ink.shape[1]
    left, right = (round(staff.centre + side * (staff.inner + half)) for side in (-1, 1))
    for y in (*staff.bars, staff.base, staff.top, *seconds):
        _bridge(ink, y, half, max(left, 0), min(right, width))
    short = unit * staff.inner / 4
    for y in staff.ticks:
        _bridge(ink, y, half, round(staff.centre - short), round(staff.centre + short))
    places = np.arange(width)
    for side in (-1, 0, 1):  # signs stand a tenth of their width away from them
        away = np.abs(places - staff.centre - side * staff.inner) - staff.stroke / 2
        ink *= away.clip(0, 1).astype(np.float32)
    return ink


def _bridge(ink: Floats, y: float, half: float, first: int, last: int) -> None:
    """Take a line across out of ink (H, W); where it is black, by what lies above and below it."""
    low, high = round(y - half) - 1, round(y + half) + 2
    if low < 1 or high >= len(ink):
        return
    own = ink[low:high, first:last]
    # signs cover less of a row than 70 %: what is darker anywhere is the line's own
    line = np.percentile(own, 30, axis=1, keepdims=True)
    clear = ((own - line) / (1 - line).clip(0.2)).clip(0, 1)
    seen = np.flatnonzero(line[:, 0] < _BLACK)
    for at in np.flatnonzero(line[:, 0] >= _BLACK):
        above, below = seen[seen < at][-1:], seen[seen > at][:1]
        if len(above) and len(below):
            share = np.float32((at - above[0]) / (below[0] - above[0]))
            clear[at] = np.minimum(clear[above[0]] * (1 - share) + clear[below[0]] * share, own[at])
    ink[low:high, first:last] = clear


def _beat(staves: Sequence[Staff]) -> float:
    """Return the height of a count by the distance of the outer lines from the centre line."""
    steps = list[float]()
    for staff in staves:
        ys = sorted((staff.base, *staff.bars, *staff.ticks), reverse=True)
        steps += [(a - b) / staff.inner for a, b in pairwise(ys)]
    if not steps:
        return float(np.median([(it.base - it.top) / it.inner for it in staves]))
    usual = float(np.median(steps))
    whole = [it for it in steps if abs(it / usual - 1) < 0.15]
    return float(np.mean(whole))


def _joined(
    staves: Sequence[Staff], inks: Sequence[Floats], unit: float, beat: float, counts: list[float]
) -> tuple[Floats, list[Floats], list[Floats]]:
    """Return the ink of all staves as of one, time upwards, `SIZE` to a symbol's width: (H, W).

    Its last `BELOW` rows lie below the first staff: there the starting position is. And the ink
    around the tops of staves that go on, and the bases of the next ones.
    """
    rows = beat / unit * SIZE  # of a count
    pieces, tops, bases = [], list[Floats](), list[Floats]()
    for number, (staff, ink) in enumerate(zip(staves, inks, strict=True)):
        factor = SIZE / (unit * staff.inner)
        if factor < 1:
            ink = np.asarray(cv2.GaussianBlur(ink, (0, 0), 0.35 / factor), np.float32)
        # the middles of pixels, as of a picture that is drawn at this size
        xs = (np.arange(2 * WIDEST * SIZE) + 0.5 - WIDEST * SIZE) / factor + staff.centre
        first, last = (round(it * rows) for it in counts[number : number + 2])
        ys = staff.base - (np.arange(last - 1, first - 1, -1) + 0.5 - first) / (
            (last - first) / (staff.base - staff.top)
        )
        if number == 0:
            below = (np.arange(BELOW) + 0.5) / factor + staff.base
            below[below > staff.foot] = len(ink) + 9
            ys = np.concatenate([ys, below])
        pieces.append(_seen(ink, xs, ys))
        near = (np.arange(-NEAR, NEAR) + 0.5) / factor
        tops.append(_seen(ink, xs, staff.top + near))
        bases.append(_seen(ink, xs, staff.base + near))
    ink = np.concatenate(pieces[::-1]).astype(np.float32)
    for count in counts[1:-1]:
        mend(ink, len(ink) - BELOW - round(count * rows), SIZE)
    return ink, tops[:-1], bases[1:]


def _seen(ink: Floats, xs: NDArray[Any], ys: NDArray[Any]) -> Floats:
    """Return ink (H, W) at places (w,) across and (h,) down: (h, w)."""
    across, down = np.meshgrid(xs.astype(np.float32), ys.astype(np.float32))
    pieces = [
        cv2.remap(ink, across[it : it + LONGEST], down[it : it + LONGEST], cv2.INTER_LINEAR)
        for it in range(0, len(ys), LONGEST)
    ]
    return np.concatenate(pieces).astype(np.float32, copy=False)
