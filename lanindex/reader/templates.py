"""Signs as they look in a column, as small images with which ink is compared."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import CARRIERS, DIRECTION_CODES, DIRECTIONS, KINDS, LEVELS, SIXTHS
from lanindex.draw import svg
from lanindex.draw.picture import (
    PIXEL,
    SIGNS,
    SMALL,
    C,
    Circle,
    Label,
    Mark,
    Picture,
    Polyline,
    sign,
    turn,
)
from lanindex.draw.staff import LEAST, ONE, PITCH
from lanindex.model.symbol import Symbol, blank, listed

Floats = NDArray[np.float32]

SIZE = 28
"""Pixels of the width of a symbol in a column that is compared."""

UNIT = SIZE / C
"""Pixels of a unit of a picture."""

STROKE = 7  # units: as symbols are drawn
COARSE = SIZE // 2
"""The same where signs are looked for."""

PAD = 1  # pixels above, below and beside a sign
SPREAD = round(2 * PITCH * UNIT) + 4  # pixels of one that stands across the centre line
_FINE = 4  # an image is drawn so many times larger, and made smaller


class Name(NamedTuple):
    """What a sign says."""

    kind: str  # Of `lanindex.alphabet.KINDS`, or "hold", "again", "circle", "?"
    direction: str | None = None
    level: str | None = None
    amount: int | None = None


_ALL = [Name("", way, level) for way in DIRECTIONS for level in LEVELS]
NAMES: dict[str, list[Name]] = {
    "gesture": [*(it._replace(kind="gesture") for it in _ALL), Name("again")],
    "support": [*(it._replace(kind="support") for it in _ALL), Name("hold"), Name("?")],
    "bend": [Name("bend", amount=it) for it in range(SIXTHS + 1)],
    **{it: [Name(it, way) for way in KINDS[it].directions] for it in ("twist", "incline")},
    "turn": [Name(it, way) for it in ("turn", "circle") for way in KINDS["turn"].directions],
    "travel": [Name("travel", way) for way in DIRECTIONS],
    "carrier": [Name("carrier", amount=it) for it in (*range(len(CARRIERS)), None)],
}
"""What signs in the columns of a kind say; degrees are read once the rest is known."""

ACROSS = [Name("turn", way) for way in KINDS["turn"].directions]
"""What stands across the centre line, as high as its ink."""

DEGREES = ("turn", "circle", "twist", "incline")
"""Kinds of signs in which degrees are written."""

APART = ("again", "bend", "circle", "travel")
"""Kinds of signs with gaps in them, from their lower end upwards."""


@lru_cache(maxsize=1024)
def _symbol(name: Name) -> Symbol:
    row = blank(1)
    row["direction"] = DIRECTION_CODES.get(name.direction or "", -1)
    row["amount"] = -1 if name.amount is None else name.amount
    return listed("other_support", row)[0]


def fits(name: Name, height: float) -> bool:
    """Return whether a sign can be so many widths high."""
    units = height * C - STROKE
    if name.kind in ("hold", "?"):
        return abs(units - ONE) < 0.15 * C
    if name.kind == "carrier" and name.amount is not None:  # its word has no room in a low frame
        return units >= len(CARRIERS[name.amount]) * SMALL * 2 // 3
    return units > 0.7 * LEAST


@lru_cache(maxsize=8192)
def image(
    name: Name, height: int, left: bool, cuts: tuple[int, ...], blur: float, size: int = SIZE
) -> Floats:
    """Return a sign at a height in pixels, `size` to its width: (H, W) of darkness.

    `cuts` are the heights at which it continues on the next staff; `left` is the left of the staff;
    `blur` is in pixels of `SIZE`.
    """
    units = max(round(height * C / size) - STROKE, 1)
    if cuts and name.level in ("low", "mid"):  # others have strokes of their own on each staff
        drawn = image(name, height, left, (), blur, size).copy()
    else:
        pieces = list(pairwise(sorted({0, units, *(min(it * C // size, units) for it in cuts)})))
        marks = _marks(name, units, left, pieces)
        drawn = _drawn(marks, height, size + 2 * PAD, blur * size / SIZE, size / C)
    for cut in cuts:
        mend(drawn, PAD + height - cut, size)
    return drawn


@lru_cache(maxsize=8192)
def mean_image(
    name: Name, height: int, left: bool, cuts: tuple[int, ...], blur: float, size: int = SIZE
) -> Floats:
    """Return the same; of a sign in which degrees are written, and are not known, the mean."""
    if name.kind not in DEGREES or name.amount is not None or name.direction == "place":
        return image(name, height, left, cuts, blur, size)
    drawn = [image(it, height, left, cuts, blur, size) for it in _with_any(name)]
    return np.asarray(np.mean(drawn, axis=0), np.float32)


def _with_any(name: Name) -> list[Name]:
    """Return a sign with degrees of all kinds."""
    return [name._replace(amount=it) for it in range(45, 375, 45)]


@lru_cache(maxsize=512)
def across(name: Name, height: int, cuts: tuple[int, ...], blur: float) -> Floats:
    """Return a turn across the centre line, (H, W) of darkness."""
    units = max(round(height / UNIT) - STROKE, 1)
    pieces = pairwise(sorted({0, units, *(min(round(it / UNIT), units) for it in cuts)}))
    symbol = _symbol(name)
    marks = [it for low, high in pieces for it in turn(symbol, 0, units - low, high - low, PITCH)]
    drawn = _drawn(marks, height, SPREAD, blur, UNIT)
    for cut in cuts:
        mend(drawn, PAD + height - cut, SIZE)
    return drawn


@lru_cache(maxsize=512)
def mean_across(name: Name, height: int, cuts: tuple[int, ...], blur: float) -> Floats:
    """Return the same with the mean of degrees."""
    drawn = [across(it, height, cuts, blur) for it in _with_any(name)]
    return np.asarray(np.mean(drawn, axis=0), np.float32)


@lru_cache(maxsize=8)
def ring(size: int, blur: float) -> Floats:
    """Return a circle of weight of so many units, (H, W) of darkness."""
    height = round((size + STROKE) * UNIT)
    return _drawn([Circle(0, size // 2, size // 2)], height, SIZE + 2 * PAD, blur, UNIT)


def _marks(name: Name, units: int, left: bool, pieces: Sequence[tuple[int, int]]) -> list[Mark]:
    """Return the marks of a sign round x = 0, from its top at 0 downwards."""
    if name.kind == "hold":
        return [Circle(0, units // 2, ONE // 2)]
    if name.kind == "?":
        return [Label(0, units, "?", ONE)]
    if own := SIGNS.get(name.kind):
        symbol = _symbol(name)
        marks = [mark for low, high in pieces for mark in own(symbol, 0, units - low, high - low)]
        return [it for it in marks if name.amount is not None or not isinstance(it, Label)]
    way, level = name.direction, name.level
    return [
        mark
        for low, high in pieces
        for mark in sign(-C // 2, units - low, way, level, units, (low, high), left=left)
    ]


def _drawn(marks: Sequence[Mark], height: int, wide: int, blur: float, unit: float) -> Floats:
    """Return marks round x = 0 as darkness, (H, W), so many pixels to a unit."""
    rows, scale = height + 2 * PAD, unit * _FINE
    large = np.zeros((rows * _FINE, wide * _FINE), np.uint8)
    thick = max(round(STROKE * scale), 1)
    middle, top = wide / 2 / unit, PAD / unit + STROKE / 2
    for mark in marks:
        x, y = mark.x + middle, mark.y + top  # type: ignore[union-attr]
        if isinstance(mark, Circle):
            solid = -1 if mark.style == "solid" else thick
            centre = round(x * scale), round(y * scale)
            cv2.circle(large, centre, round(mark.radius * scale), 255, solid, cv2.LINE_AA)
        elif isinstance(mark, Label):
            _paste(large, mark, round(x * scale), round(y * scale), scale)
        elif isinstance(mark, Polyline):
            lines = [
                np.rint(np.add(points, (x, y)) * scale).astype(np.int32) for points in mark.lines
            ]
            if mark.style == "solid":
                for corners in lines:
                    cv2.fillPoly(large, [corners], 255)
            for closed in (True, False):
                own = [
                    it for number, it in enumerate(lines)
                    if closed == (mark.closed and (number == 0 or len(it) > 2))
                ]  # fmt: skip
                cv2.polylines(large, own, closed, 255, thick, cv2.LINE_AA)
    small = cv2.resize(large, (wide, rows), interpolation=cv2.INTER_AREA).astype(np.float32) / 255
    return np.asarray(cv2.GaussianBlur(small, (0, 0), blur), np.float32)


def _paste(large: NDArray[np.uint8], label: Label, x: int, y: int, scale: float) -> None:
    """Draw a label with its anchor at a place of an image (H, W), as far as it lies within."""
    text = _text(label.text, label.size, label.turned, scale)
    top, left = y - text.shape[0] // 2, x - text.shape[1] // 2
    low, first = max(top, 0), max(left, 0)
    high, last = min(top + text.shape[0], len(large)), min(left + text.shape[1], large.shape[1])
    if low < high and first < last:
        piece = text[low - top : high - top, first - left : last - left]
        large[low:high, first:last] = np.maximum(large[low:high, first:last], piece)


@lru_cache(maxsize=256)
def _text(text: str, size: int, turned: bool, scale: float) -> NDArray[np.uint8]:
    """Return a label, its anchor in the middle, (H, W) of darkness, so many pixels to a unit."""
    half = size * (len(text) + 1)
    label = Label(half, half, text, size, turned=turned)
    picture = Picture(2 * half, 2 * half, "", "", (label,))
    drawn = svg.image(svg.write(picture, scale=scale * PIXEL, ink=svg.INK))
    return 255 - np.asarray(
        cv2.imdecode(np.frombuffer(drawn, np.uint8), cv2.IMREAD_GRAYSCALE), np.uint8
    )


def mend(ink: Floats, row: int, size: int) -> None:
    """Draw over a row of ink (H, W) what lies above and below: a staff ends there."""
    half = SEAM * size // SIZE
    low, high = max(row - half, 1), min(row + half, len(ink) - 1)
    share = np.linspace(0, 1, high - low + 2, dtype=np.float32)[1:-1, None]
    ink[low:high] = ink[low - 1] * (1 - share) + ink[high] * share


SEAM = 4
"""Pixels above and below a staff's end that are drawn over."""
