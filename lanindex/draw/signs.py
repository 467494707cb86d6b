"""The signs of what has no direction and level of its own: turns, ways, bends, bows, holds."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, radians, sin

from lanindex.alphabet import KINDS, kind_of
from lanindex.draw.picture import C, Circle, Mark, Path, Text, box, line
from lanindex.draw.shapes import sign
from lanindex.model import Symbol
from lanindex.model.bends import STRETCHES, degree_of

SMALL = round(0.5 * C)
"""The size of numbers, and of narrow signs."""

BOW = round(0.3 * C)
"""How deep bows are."""

_CURVES = 45
"""Degrees from which on a way is drawn as one that goes round."""

Sign = Callable[[Symbol, int, int, int], list[Mark]]
"""Draws a symbol from the middle of its column, its lower end and its height."""


def turn(symbol: Symbol, x: int, y: int, height: int) -> list[Mark]:
    """Return a box that slants up to the side of a turn, and its amount: a pin, and degrees."""
    slant = 0 if symbol.direction == "place" else min(height // 3, C // 2)
    low, high = (0, slant) if symbol.direction == "left" else (slant, 0)
    half, foot = C // 2, height - slant
    corners = ((-half, low), (half, high), (half, high + foot), (-half, low + foot))
    marks: list[Mark] = [Path(x, y - height, (corners,), True)]
    room, middle = height - 2 * slant, y - height // 2
    if symbol.amount and room >= 2.2 * SMALL:
        way = radians(symbol.amount * (-1 if symbol.direction == "left" else 1))
        marks += _pin(x, middle - SMALL // 2, way)
        marks.append(_number(symbol, x, middle + SMALL))
    elif symbol.amount and height - slant >= SMALL:
        marks.append(_number(symbol, x, middle + SMALL // 3))
    return marks


def _pin(x: int, y: int, way: float) -> list[Mark]:
    """Return a pin that points to where a turn ends: 0 is ahead, then with the clock."""
    across, down = round(SMALL * sin(way)), round(-SMALL * cos(way))
    end = x + across // 2, y + down // 2
    return [line(x - across // 2, y - down // 2, *end), Circle(*end, C // 12, "solid")]


def _number(symbol: Symbol, x: int, y: int) -> Text:
    return Text(x, y, str(symbol.amount), SMALL)


def incline(symbol: Symbol, x: int, y: int, height: int) -> list[Mark]:
    """Return the shape of a direction without a level, and the degrees of the lean in it."""
    marks = sign(x - C // 2, y, symbol.direction, None, height)
    if symbol.amount and height >= 1.5 * SMALL:
        marks.append(_number(symbol, x, y - height // 2 + SMALL // 3))
    return marks


def travel(symbol: Symbol, x: int, y: int, height: int) -> list[Mark]:
    """Return the line of a way between two bars, slanting where it goes round, and where to."""
    slant = min(C // 3, height // 4) if (symbol.amount or 0) >= _CURVES else 0
    ends = tuple(((-C // 3, -at), (C // 3, -at - slant)) for at in (0, height - slant))
    size = min(height * 3 // 5, C)
    low, width = (height - size) // 2, C * 3 // 5
    stem = (((0, -slant // 2), (0, -low)), ((0, -low - size), (0, slant // 2 - height)))
    where = sign(x - width // 2, y - low, symbol.direction, None, size, width=width)
    return [Path(x, y, (*ends, *stem)), *where]


def bend(symbol: Symbol, x: int, y: int, height: int) -> list[Mark]:
    """Return a narrow sign, a cross to bend or posts to stretch, its degree and how long."""
    size = min(height, SMALL)
    half, amount = size // 2, symbol.amount or 0
    strokes: tuple[tuple[tuple[int, int], ...], ...]
    if amount < STRETCHES:
        strokes = (((-half, 0), (half, -size)), ((-half, -size), (half, 0)))
    else:
        strokes = (((-half, -size), (-half, 0), (half, -size), (half, 0)),)
    numbered = height >= 2.2 * SMALL
    top = round(2.2 * SMALL) if numbered else size
    if height > top:
        strokes += (((0, -top), (0, -height)),)
    marks: list[Mark] = [Path(x, y, strokes)]
    if numbered:
        marks.append(Text(x, y - size - SMALL // 4, str(degree_of(amount)), SMALL))
    return marks


def carrier(symbol: Symbol, x: int, y: int, height: int) -> list[Mark]:
    """Return a frame with the name of what carries."""
    marks: list[Mark] = [box(x - C // 2, y - height, C, height)]
    word = KINDS[kind_of(symbol.part)].amount(symbol.amount or 0)
    if height >= len(word) * SMALL * 2 // 3:
        marks.append(Text(x + SMALL // 3, y - height // 2, word, SMALL, turned=True))
    return marks


def bow(x: int, to_x: int, y: int) -> Path:
    """Return a bow from one column to another, its ends up."""
    wide, steps = to_x - x, 8
    points = tuple(
        (wide * step // steps, round(BOW * sin(radians(180 * step / steps))))
        for step in range(steps + 1)
    )
    return Path(x, y - BOW, (points,))


SIGNS: dict[str, Sign] = {
    "turn": turn,
    "twist": turn,
    "incline": incline,
    "travel": travel,
    "bend": bend,
    "carrier": carrier,
}
"""What draws the symbols of a kind; all others have a direction and a level."""
