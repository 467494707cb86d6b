"""What stands in the columns of a staff: signs of direction and level, holds, and what is unknown.

Each column is brought to one size and cut where its ink has gaps; each piece is compared with the
signs that `lanindex.draw.picture` draws at its height. Ink lower than a third of a symbol's width
is no sign: digits, and what is left of lines.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTIONS, LEVELS
from lanindex.draw.picture import GAP, C, Circle, Mark, Polyline, sign
from lanindex.draw.staff import PITCH

if TYPE_CHECKING:
    from lanindex.reader.staff import Staff

Floats = NDArray[np.float32]

SIZE = 28
"""Pixels of the width of a symbol in a column that is compared."""

UNIT = SIZE / C
"""Pixels of a unit of a picture."""

_WIDE = round(PITCH * UNIT)
_STROKE = 7  # units: as symbols are drawn
_FINE = 4  # a template is drawn so many times larger, and made smaller
_SHIFT = 2  # pixels by which a piece may lie elsewhere than its ink says
_INK = 0.3  # darkness of a row from which on it belongs to a sign
_SURE = 0.5  # likeness below which a piece is unknown


@dataclass(frozen=True, slots=True)
class Column:
    """A column of all staves of a page."""

    number: int  # From the centre line outwards, 1 and on; on its left -1 and on
    x: float  # Its middle, from the centre line, widths of a symbol
    inside: bool  # Whether it lies between the outer lines


@dataclass(frozen=True, slots=True)
class Sign:
    """A sign in a column; what is not known has no kind."""

    column: Column
    start: float  # Counts from the first staff's base on; a starting position lies below 0
    end: float
    kind: str  # "sign", "hold", or empty
    direction: str | None
    level: str | None
    confidence: float  # 0 to 1


@dataclass(frozen=True, slots=True)
class Page:
    """The signs of a page, and how time lies on it."""

    unit: float  # Width of a symbol, by the distance from the centre line to the outer ones
    counts: list[float]  # At the base of each staff, and at the top of the last
    columns: list[Column]
    signs: list[Sign]


def read(staves: Sequence[Staff]) -> Page:
    """Return the signs of the staves of a page: of each column together, upwards."""
    inks = [_without_lines(staff) for staff in staves]
    unit, inside = _unit(staves, inks)
    beat = _beat(staves)
    counts = [0.0]
    for staff in staves:
        counts.append(counts[-1] + (staff.base - staff.top) / staff.inner / beat)
    tall = _joined(staves, inks, unit, beat, counts)
    columns = list(_columns(tall, unit, inside))
    rows = (len(tall) - _BELOW) / counts[-1]
    lines = [*counts]
    for staff, begin in zip(staves, counts, strict=False):
        lines += [begin + (staff.base - it) / staff.inner / beat for it in staff.bars]
    cuts = [round(len(tall) - _BELOW - it * rows) for it in lines]
    ends = [round(len(tall) - _BELOW - it * rows) for it in counts[1:-1]]
    found = [it for column in columns for it in _signs(tall, rows, cuts, ends, column)]
    return Page(unit, counts, columns, found)


def _without_lines(staff: Staff) -> Floats:
    """Return darkness, (H, W), of a staff without its own lines."""
    ink = (255 - staff.image.astype(np.float32)) / np.float32(255)
    half, width = staff.stroke / 2 + 0.5, ink.shape[1]
    left, right = (round(staff.centre + side * (staff.inner + half)) for side in (-1, 1))
    for y in (*staff.bars, staff.base, staff.top):
        _bridge(ink, y, half, max(left, 0), min(right, width))
    short = staff.inner / 4
    for y in staff.ticks:
        _bridge(ink, y, half, round(staff.centre - short), round(staff.centre + short))
    for side in (-1, 0, 1):
        x = staff.centre + side * staff.inner
        first, last = (min(max(round(x + it), 0), width) for it in (-half, half))
        ink[:, first : last + 1] = 0
    return ink


def _bridge(ink: Floats, y: float, half: float, first: int, last: int) -> None:
    """Replace a line across by what lies above and below it."""
    low, high = round(y - half), round(y + half) + 1
    if low < 1 or high >= len(ink):
        return
    above, below = ink[low - 1, first:last], ink[high, first:last]
    share = np.linspace(0, 1, high - low, dtype=np.float32)[:, None]
    between = above * (1 - share) + below * share
    ink[low:high, first:last] = np.minimum(between, ink[low:high, first:last])


def _boxes(ink: Floats) -> NDArray[np.int32]:
    """Return x, y, width, height and size of connected ink: (N, 5)."""
    _, _, boxes, _ = cv2.connectedComponentsWithStats((ink > 0.4).astype(np.uint8), connectivity=8)
    return np.asarray(boxes[1:])


def _unit(staves: Sequence[Staff], inks: Sequence[Floats]) -> tuple[float, list[float]]:
    """Return the width of a symbol by the distance of the outer lines from the centre line.

    And the middles of the columns between, in widths: so many, and perhaps a narrow one of bends,
    fill the room.
    """
    wide, tall = list[float](), list[float]()
    for staff, ink in zip(staves, inks, strict=True):
        boxes = _boxes(ink[max(round(staff.top), 0) : round(staff.foot)])
        wide += (boxes[:, 2] / staff.inner).tolist()
        tall += (boxes[:, 3] / staff.inner).tolist()
    pixel = 1 / float(np.median([staff.inner for staff in staves]))
    widths, heights = np.array(wide), np.array(tall)
    best = (-1.0, 0.0, list[float]())
    for count in range(2, 8):
        for narrow in (0, 1):
            unit = 1 / (count * PITCH / C + narrow)
            off = (widths - (1 + _STROKE / C) * unit - pixel) / (0.06 * unit + pixel / 2)
            fits = np.exp(-(off**2)) * (heights > 0.45 * unit)
            score = float(fits.sum()) - 0.1 * count - 0.3 * narrow
            middles = [(it + 0.5) * PITCH / C for it in range(count)]
            middles += [count * PITCH / C + 0.5] * narrow
            best = max(best, (score, unit, middles))
    return best[1], best[2]


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


_WIDEST = 12
"""Widths of a symbol on either side of the centre line that are looked at."""


def _joined(
    staves: Sequence[Staff], inks: Sequence[Floats], unit: float, beat: float, counts: list[float]
) -> Floats:
    """Return the ink of all staves as of one, time upwards, `SIZE` to a symbol's width: (H, W).

    Its last `_BELOW` rows lie below the first staff: there the starting position is.
    """
    rows = beat / unit * SIZE  # of a count
    pieces = []
    for number, (staff, ink) in enumerate(zip(staves, inks, strict=True)):
        factor = SIZE / (unit * staff.inner)
        if factor < 1:
            ink = np.asarray(cv2.GaussianBlur(ink, (0, 0), 0.35 / factor), np.float32)
        # the middles of pixels, as of a picture that is drawn at this size
        xs = (np.arange(2 * _WIDEST * SIZE) + 0.5 - _WIDEST * SIZE) / factor + staff.centre
        first, last = (round(it * rows) for it in counts[number : number + 2])
        ys = staff.base - (np.arange(last - 1, first - 1, -1) + 0.5 - first) / (
            (last - first) / (staff.base - staff.top)
        )
        if number == 0:
            below = (np.arange(_BELOW) + 0.5) / factor + staff.base
            below[below > staff.foot] = len(ink) + 9
            ys = np.concatenate([ys, below])
        across, down = np.meshgrid(xs.astype(np.float32), ys.astype(np.float32))
        pieces.append(cv2.remap(ink, across, down, cv2.INTER_LINEAR, borderValue=0))
    return np.concatenate(pieces[::-1]).astype(np.float32)


_BELOW = 6 * SIZE


def _columns(tall: Floats, unit: float, inside: list[float]) -> Iterator[Column]:
    """Yield the columns inside, and those outside in which something stands."""
    boxes = _boxes(tall) / SIZE
    boxes = boxes[(boxes[:, 3] > 0.4) & (boxes[:, 2] > 0.3) & (boxes[:, 2] < 1.6)]
    middles = boxes[:, 0] + boxes[:, 2] / 2 - _WIDEST
    for side in (-1, 1):
        away = middles * side - 1 / unit
        taken = sorted({int(it // (PITCH / C)) for it in away[away > 0.2]})
        places = [*inside, *(1 / unit + (it + 0.5) * PITCH / C for it in taken)]
        for number, place in enumerate(places, 1):
            if place < _WIDEST - 1:
                yield Column(side * number, side * place, number <= len(inside))


def _signs(
    tall: Floats, rows: float, lines: list[int], ends: list[int], column: Column
) -> Iterator[Sign]:
    """Yield what stands in a column; a count has so many rows."""
    first = round((column.x + _WIDEST) * SIZE - _WIDE / 2)
    strip = np.ascontiguousarray(tall[:, first : first + _WIDE])
    base = len(strip) - _BELOW
    for top, foot in _pieces(strip):
        for begin, end, name, likeness in _best_cut(
            strip, top, foot, lines, ends, column.number < 0
        ):
            direction, level = name or (None, None)
            kind = "" if name is None else "hold" if direction is None else "sign"
            start, stop = ((base - it) / rows for it in (end, begin))
            yield Sign(column, start, stop, kind, direction, level, likeness)


BLUR = 0.6  # pixels by which templates are blurred


def _pieces(strip: Floats) -> list[tuple[int, int]]:
    """Return the rows, half-open, of stretches of ink in a column."""
    rows = strip[:, 2:-2].max(axis=1) > _INK
    edges = np.flatnonzero(np.diff(np.concatenate([[0], rows.astype(np.int8), [0]])))
    return [(a, b) for a, b in edges.reshape(-1, 2).tolist() if b - a > SIZE * 0.3]


Name = tuple[str | None, str | None]  # Direction and level; of the circle of a hold neither
Named = tuple[float, float, Name | None, float]  # First and last row, name, likeness


def _best_cut(
    strip: Floats, first: int, last: int, lines: list[int], ends: list[int], left: bool
) -> list[Named]:
    """Return the signs that a stretch of ink is best explained by: rows, name, likeness.

    Between two it has a lighter row, or a line of the staff, whose rows are given; `ends` are the
    rows at which a staff goes on on the next one.
    """
    rows = strip[first:last, 3:-3].max(axis=1)
    cuts = [
        it for it in range(SIZE // 2, len(rows) - SIZE // 2)
        if rows[it] < 0.7 * min(rows[it - 4 : it].max(), rows[it + 1 : it + 5].max())
        and rows[it] == rows[max(it - 3, 0) : it + 4].min()
    ]  # fmt: skip
    cuts += [it - first for it in lines if first + SIZE // 3 < it < last - SIZE // 3]
    places = [first, *(first + it for it in sorted(set(cuts))), last]
    best: list[tuple[float, int, Named | None]] = [(0.0, -1, None)]
    for end in range(1, len(places)):
        options = []
        for begin in range(max(end - 8, 0), end):
            low, high = places[begin], places[end]
            found = _named(strip, low, high, ends, left)
            worth = (found[3] - _SURE) * (high - low)
            options.append((best[begin][0] + worth, begin, found))
        best.append(max(options, key=lambda it: it[0]))
    chosen, at = list[Named](), len(places) - 1
    while at > 0:
        _, before, named = best[at]
        assert named is not None
        chosen.append(named)
        at = before
    return chosen


def _named(strip: Floats, first: int, last: int, ends: list[int], left: bool) -> Named:
    """Return the rows of a sign, its name, and how much it is like it."""
    best: tuple[float, Name | None, float, float] = (-1.0, None, first, last)
    top, foot = max(first - _SHIFT, 0), min(last + _SHIFT, len(strip))
    piece = strip[top:foot]
    for name in _NAMES:
        for size in (last - first - 1, last - first, last - first - 2):
            cuts = tuple(last - it for it in ends if first + 3 < it < last - 3)
            template = _template(*name, size, left, cuts)
            if len(template) > len(piece):
                continue
            likeness = cv2.matchTemplate(piece, template, cv2.TM_CCOEFF_NORMED)
            _, value, _, (_, y) = cv2.minMaxLoc(likeness)
            if value > best[0]:
                best = value, name, top + y + _PAD, top + y + len(template) - _PAD
    value, found, begin, end = best
    return begin, end, found if value >= _SURE else None, max(value, 0.0)


_PAD = 1
_NAMES: list[Name] = [(way, level) for way in DIRECTIONS for level in LEVELS] + [(None, None)]
"""Directions and levels, and the circle of a hold."""


@lru_cache(maxsize=8192)
def _template(
    direction: str | None, level: str | None, height: int, left: bool, cuts: tuple[int, ...]
) -> Floats:
    """Return a sign as it looks at a height in pixels, with its outline: (H, W) of darkness.

    `cuts` are the heights at which it goes on on the next staff.
    """
    units = max(round(height / UNIT) - _STROKE, GAP)
    margin = (_WIDE / UNIT - C) / 2 - 2 / UNIT
    pad = _PAD / UNIT + _STROKE / 2
    if direction is None:
        marks: list[Mark] = [Circle(C // 2, units // 2, round(0.55 * C) // 2)]
    else:
        at = sorted({0, units, *(min(round(it / UNIT), units) for it in cuts)})
        marks = [
            mark
            for low, high in pairwise(at)
            for mark in sign(0, units - low, direction, level, units, (low, high), left=left)
        ]
    rows, wide = height + 2 * _PAD, _WIDE - 4
    image = np.zeros((rows * _FINE, wide * _FINE), np.uint8)
    scale = UNIT * _FINE
    thick = max(round(_STROKE * scale), 1)
    for mark in marks:
        if isinstance(mark, Circle):
            centre = round((mark.x + margin) * scale), round((mark.y + pad) * scale)
            solid = -1 if mark.style == "solid" else thick
            cv2.circle(image, centre, round(mark.radius * scale), 255, solid, cv2.LINE_AA)
        elif isinstance(mark, Polyline):
            for number, points in enumerate(mark.lines):
                xs = [round((mark.x + x + margin) * scale) for x, _ in points]
                ys = [round((mark.y + y + pad) * scale) for _, y in points]
                corners = np.array([xs, ys], np.int32).T.reshape(-1, 1, 2)
                if mark.style == "solid":
                    cv2.fillPoly(image, [corners], 255)
                closed = mark.closed and number == 0
                cv2.polylines(image, [corners], closed, 255, thick, cv2.LINE_AA)
    small = cv2.resize(image, (wide, rows), interpolation=cv2.INTER_AREA).astype(np.float32) / 255
    return np.asarray(cv2.GaussianBlur(small, (0, 0), BLUR), np.float32)
