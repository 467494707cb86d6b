"""A picture as a short list of marks, in whole units, x to the right and y down."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

C = 140
"""Units of the width of a symbol: all else is measured by it."""

PIXEL = 10
"""Units of a pixel, at scale 1."""

Points = tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class Polyline:
    """Some lines from point to point."""

    x: int  # Where their points are counted from
    y: int
    lines: tuple[Points, ...]  # Each from its first point to its last
    closed: bool = False  # Whether each of more than two points goes on to its first
    style: str = ""  # One of `lanindex.draw.svg.STYLES`


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
