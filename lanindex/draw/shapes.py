"""The shapes of directions and levels, in units, as tall as time makes them.

Points are counted from a shape's lower left corner, y up.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from math import ceil, floor

from lanindex.alphabet import DIRECTION_CODES, DIRECTIONS, MIRRORED
from lanindex.draw.picture import C, Circle, Mark, Path, Points

_OUTLINES = {
    "": "00 10 11 01",
    "place": "00 10 11 01",
    "right": "00 1h 01",
    "left": "10 11 0h",
    "forward": "00 10 1t mt m1 01",
    "back": "00 m0 mk 1k 11 01",
    "r_forward": "00 10 11 0t",
    "l_forward": "00 10 1t 01",
    "r_back": "0k 10 11 01",
    "l_back": "00 1k 11 01",
}
"""Corners by direction, x and y: 0 and 1 the ends, m and h the middle, k and t a way from them."""

_SLOPE = 0.45
"""From one stroke of a high symbol to the next, upwards, in widths."""

_DOT = 0.11
"""Radius of the dot of a middle level, in widths."""


def mirrored(direction: str) -> str:
    """Return the mirror image of a direction."""
    return DIRECTIONS[MIRRORED[DIRECTION_CODES[direction]]] if direction else ""


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
    outline = _outline(direction or "", height, low, high, left, width)
    strokes = _strokes(outline) if level == "high" else ()
    marks: list[Mark] = [Path(x, y, (outline, *strokes), True, "solid" if level == "low" else "")]
    if level == "mid":
        across, up = _dot(direction or "", height, left, width)
        if low <= up < high or (up == high == height):
            radius = min(round(_DOT * width), max((high - low) // 4, 1))
            marks.append(Circle(x + across, y - up + low, radius, "solid"))
    return marks


def _notch(height: int, width: int) -> float:
    """Return how deep chimneys and slants are, as a part of the height."""
    return min(1 / 3, 1.1 * width / max(height, 1))


def _dot(direction: str, height: int, left: bool, width: int) -> tuple[int, int]:
    across = {"right": 1 / 3, "left": 2 / 3}.get(direction, 1 / 2)
    notch = _notch(height, width) / 2
    up = 0.5 - notch * direction.endswith("forward") + notch * direction.endswith("back")
    return round(across * width), round(up * height)


@lru_cache(maxsize=4096)
def _outline(direction: str, height: int, low: int, high: int, left: bool, width: int) -> Points:
    """Return the corners of what is seen of a shape, the lower of them at height 0, y down."""
    notch = _notch(height, width)
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


def _cut(corners: list[tuple[float, float]], at: int, way: int) -> list[tuple[float, float]]:
    """Return the part of a shape above a height, or (way -1) below it."""
    kept = []
    for (x, y), (to_x, to_y) in pairwise([*corners, corners[0]]):
        if (y - at) * way >= 0:
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
