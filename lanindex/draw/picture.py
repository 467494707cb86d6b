"""A picture as a short list of marks, and the signs of Labanotation as such marks.

Places are whole units, x to the right and y down.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise
from math import ceil, cos, floor, radians, sin
from types import MappingProxyType

from lanindex.alphabet import KINDS, kind_of
from lanindex.data import shipped
from lanindex.model import Symbol
from lanindex.model.derived import degree_of

C = 140  # units of the width of a symbol: all else is measured by it
PIXEL = 10  # units of a pixel, at scale 1

Points = tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class Polyline:
    """Some lines from point to point."""

    x: int  # Where their points are counted from
    y: int
    lines: tuple[Points, ...]  # Each from its first point to its last
    closed: bool = False  # Whether each of more than two points goes on to its first
    style: str = ""  # One of `lanindex.draw.svg.STYLES`
    width: int = 0  # How thick they are; 0: as their style says


@dataclass(frozen=True, slots=True)
class Circle:
    """A circle round a point."""

    x: int
    y: int
    radius: int
    style: str = ""


@dataclass(frozen=True, slots=True)
class Label:
    """A short text, its middle (or an end, by its style) at a point."""

    x: int
    y: int
    text: str
    size: int
    style: str = ""
    turned: bool = False


@dataclass(frozen=True, slots=True)
class MarkGroup:
    """Marks that belong together, with a title and data for programs."""

    marks: tuple[Mark, ...]  # What is drawn
    title: str = ""  # What it is, in words
    # What programs read: part, direction, level, start, end, amount
    data: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))


Mark = Polyline | Circle | Label | MarkGroup


@dataclass(frozen=True, slots=True)
class Picture:
    """A score as a picture."""

    width: int  # Units; `C` is the width of a symbol, `PIXEL` a pixel
    height: int
    title: str  # What it shows, for those who do not see it
    summary: str
    marks: tuple[Mark, ...]  # What is drawn, in order
    warnings: tuple[str, ...] = ()  # What is not drawn
    # Where each staff begins, from left to right: between them it can be cut
    staves: tuple[int, ...] = ()
    left: int = 0  # Where it begins, of a page of a larger one

    def groups(self) -> list[MarkGroup]:
        """Return the marks of symbols, in order."""
        return [mark for mark in self.marks if isinstance(mark, MarkGroup) and mark.data]


def line(x: int, y: int, to_x: int, to_y: int, style: str = "") -> Polyline:
    """Return a straight line."""
    return Polyline(x, y, (((0, 0), (to_x - x, to_y - y)),), style=style)


def box(x: int, y: int, width: int, height: int, style: str = "") -> Polyline:
    """Return a rectangle, from its upper left corner."""
    return Polyline(x, y, (((0, 0), (width, 0), (width, height), (0, height)),), True, style)


_OUTLINES: dict[str, str] = shipped("draw/signs.toml")["outlines"]
"""Corners by direction, x and y: 0 and 1 the ends, m and h the middle, k and t a way from them."""

_SLOPE = 0.45  # from one stroke of a high symbol to the next, upwards, in widths
_DOT = 0.11  # radius of the dot of a middle level, in widths


def sign(
    x: int,
    y: int,
    direction: str | None,
    level: str | None,
    height: int,
    seen: tuple[int, int] | None = None,
    *,
    left: bool = False,
    width: int = C,
) -> list[Mark]:
    """Return the marks of a direction and a level."""
    low, high = seen or (0, height)
    way, notch = direction or "place", min(1 / 3, 1.1 * width / max(height, 1))
    outline = _outline(way, height, low, high, left, width, notch)
    strokes = _strokes(outline) if level == "high" else ()
    style = "solid" if level == "low" else ""
    marks: list[Mark] = [Polyline(x, y, (outline, *strokes), True, style)]
    if level == "mid":
        across = round({"right": 1 / 3, "left": 2 / 3}.get(way, 1 / 2) * width)
        share = 0.5 - notch / 2 * way.endswith("forward") + notch / 2 * way.endswith("back")
        up = round(share * height)
        if low <= up < high or (up == high == height):
            radius = min(round(_DOT * width), max((high - low) // 4, 1))
            marks.append(Circle(x + across, y - up + low, radius, "solid"))
    return marks


@lru_cache(maxsize=4096)
def _outline(
    direction: str, height: int, low: int, high: int, left: bool, width: int, notch: float
) -> Points:
    """Return the corners of the visible piece of a shape, y down; `notch`: share of its height."""
    xs = {"0": 0, "m": 0.5, "1": 1}
    ys = {"0": 0, "k": notch, "h": 0.5, "t": 1 - notch, "1": 1}
    turned = left and direction in ("forward", "back")
    corners = [
        (width * (1 - xs[across] if turned else xs[across]), height * ys[up])
        for across, up in map(tuple, _OUTLINES[direction].split())
    ]
    if low > 0:
        corners = _cut(corners, low, 1)
    if high < height:
        corners = _cut(corners, high, -1)
    return tuple((round(x), low - round(y)) for x, y in corners)


def _cut(corners: list[tuple[float, float]], at: int, side: int) -> list[tuple[float, float]]:
    """Return the part of a shape above a height, or (way -1) below it."""
    kept = []
    for (x, y), (to_x, to_y) in pairwise([*corners, corners[0]]):
        if (y - at) * side >= 0:
            kept.append((x, y))
        if (y - at) * (to_y - at) < 0:
            kept.append((x + (to_x - x) * (at - y) / (to_y - y), float(at)))
    return kept


@lru_cache(maxsize=4096)
def _strokes(outline: Points) -> tuple[Points, ...]:
    """Return slanting strokes, rising to the right, inside a shape; one goes through its middle."""
    sums = [x + y for x, y in outline]  # the same along a stroke
    middle, step = (min(sums) + max(sums)) / 2, _SLOPE * C
    first, last = ceil((min(sums) - middle) / step), floor((max(sums) - middle) / step)
    strokes = []
    for number in range(first, last + 1):
        at = middle + number * step
        met = sorted(
            (x + (to_x - x) * (at - x - y) / (to_x + to_y - x - y))
            for (x, y), (to_x, to_y) in pairwise([*outline, outline[0]])
            if (x + y <= at) != (to_x + to_y <= at)
        )
        for start, stop in zip(met[::2], met[1::2], strict=True):
            if stop - start >= 1:
                strokes.append(tuple((round(x), round(at - x)) for x in (start, stop)))
    return tuple(strokes)


SMALL = round(0.5 * C)  # the size of numbers
GAP = C // 16  # left free below and above each symbol
_PINNED = round(3.2 * SMALL)  # room for a pin above its number
_CROSS = round(0.36 * C)  # width and height of the signs of bends
BOW = round(0.3 * C)  # how deep bows are


def turn(symbol: Symbol, x: int, y: int, height: int, half: int = C // 2) -> list[Mark]:
    """Return a box that slants up to the side of a turn, and its amount, beside a centre line."""
    slant = _slant(symbol, height)
    left, right = max(slant, 0), max(-slant, 0)  # how far its upper corners lie below its top
    corners = ((-half, left), (half, right), (half, height - left), (-half, height - right))
    aside = half // 2 * (-1 if slant < 0 else 1) if half > C // 2 else 0
    told = _amount(symbol, x + aside, y - height // 2, height - abs(slant))
    return [Polyline(x, y - height, (corners,), True), *told]


def circle(symbol: Symbol, x: int, y: int, height: int) -> list[Mark]:
    """Return a circular path: a line between two bars that slant up to its side, and its amount."""
    slant, half, middle = _slant(symbol, height) // 2, C // 3, y - height // 2
    low, high = y - abs(slant), y - height + abs(slant)
    told = _amount(symbol, x, middle, low - high)
    gap = min(len(told), 2) * SMALL * 11 // 20
    bars = [line(x - half, at + slant, x + half, at - slant) for at in (low, high)]
    return [*bars, line(x, low, x, middle + gap), line(x, high, x, middle - gap), *told]


def _slant(symbol: Symbol, height: int) -> int:
    """Return how far the right of a sign lies above its left."""
    size = min(height // 3, C // 2)
    return {"left": -size, "right": size}.get(symbol.direction or "", 0)


def _amount(symbol: Symbol, x: int, middle: int, room: int) -> list[Mark]:
    """Return degrees and, in room enough, a pin that points ahead at 0, then to the side."""
    if not symbol.amount or room < SMALL:
        return []
    if room < _PINNED:
        return [_number(symbol, x, middle + SMALL // 3)]
    side = -1 if symbol.direction == "left" else 1
    way, pin = radians(side * symbol.amount), middle - SMALL // 2
    across, down = round(SMALL * sin(way)), round(-SMALL * cos(way))
    end = x + across // 2, pin + down // 2
    shaft = line(x - across // 2, pin - down // 2, *end)
    return [_number(symbol, x, middle + SMALL), shaft, Circle(*end, C // 12, "solid")]


def _number(symbol: Symbol, x: int, y: int) -> Label:
    return Label(x, y, str(symbol.amount), SMALL)


def incline(symbol: Symbol, x: int, y: int, height: int) -> list[Mark]:
    """Return the shape of a direction without a level, and the degrees of the lean in it."""
    marks = sign(x - C // 2, y, symbol.direction, None, height)
    if symbol.amount and height >= 1.5 * SMALL:
        marks.append(_number(symbol, x, y - height // 2 + SMALL // 3))
    return marks


def travel(symbol: Symbol, x: int, y: int, height: int) -> list[Mark]:
    """Return a path: a line between two bars, with its direction."""
    ends = tuple(((-C // 3, -at), (C // 3, -at)) for at in (0, height))
    size = min(height * 3 // 5, C)
    low, width = (height - size) // 2, C * 3 // 5
    stem = (((0, 0), (0, -low)), ((0, -low - size), (0, -height)))
    where = sign(x - width // 2, y - low, symbol.direction, None, size, width=width)
    return [Polyline(x, y, (*ends, *stem)), *where]


def bend(symbol: Symbol, x: int, y: int, height: int) -> list[Mark]:
    """Return a cross and the degree of a bend, or posts for a straight limb, and how long."""
    size, degree = min(height, _CROSS), degree_of(symbol.amount or 0)
    half, left = size // 2, x - C * 3 // 10 * bool(degree)  # the number stands beside the cross
    cross = (((-half, 0), (half, -size)), ((-half, -size), (half, 0)))
    posts = (((-half, -size), (-half, 0), (half, -size), (half, 0)),)
    stem = (((0, -size - 2 * GAP), (0, -height)),) * (height > size + 2 * GAP)
    marks: list[Mark] = [Polyline(left, y, (*(cross if degree else posts), *stem))]
    if degree and height >= _CROSS:
        marks.append(Label(x + C // 5, y, str(degree), SMALL))
    return marks


def again(symbol: Symbol, x: int, y: int, height: int) -> list[Mark]:
    """Return a stroke between two dots, and how long what lies before it goes on."""
    half, middle = min(height, C) // 3, y - height // 2
    dots = [Circle(x + at, middle + at, C // 12, "solid") for at in (-half * 2 // 3, half * 2 // 3)]
    ends = (y, middle + half + GAP), (middle - half - GAP, y - height)
    stems = [line(x, one, x, two) for one, two in ends if one > two]
    return [line(x - half, middle + half, x + half, middle - half), *dots, *stems]


def carrier(symbol: Symbol, x: int, y: int, height: int) -> list[Mark]:
    """Return a frame with the name of the carrier."""
    marks: list[Mark] = [box(x - C // 2, y - height, C, height)]
    word = KINDS[kind_of(symbol.part)].amount(symbol.amount or 0)
    if height >= len(word) * SMALL * 2 // 3:
        marks.append(Label(x + SMALL // 3, y - height // 2, word, SMALL, turned=True))
    return marks


def bow(x: int, to_x: int, y: int) -> Polyline:
    """Return a bow from one column to another, its ends up."""
    wide, steps = to_x - x, 8
    points = tuple(
        (wide * step // steps, round(BOW * sin(radians(180 * step / steps))))
        for step in range(steps + 1)
    )
    return Polyline(x, y - BOW, (points,))


SIGNS: dict[str, Callable[[Symbol, int, int, int], list[Mark]]] = {
    **{"turn": turn, "twist": turn, "circle": circle, "incline": incline},
    **{"travel": travel, "bend": bend, "carrier": carrier, "again": again},
}
"""What draws the symbols of a kind, and turns by steps; others have a direction and a level.

Each draws from the middle of a column, its lower end and its height.
"""
