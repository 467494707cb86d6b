"""Stage 3: which cell of space a limb points into, and how clearly.

Source: ``encoding/METHOD.md``, stages 3 and 4; Matsumoto and Hachimura (2001), 4.5.2.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import cos, pi, radians, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import HIGH, LOW, PLACE
from lanindex.encoding.arithmetic import blocks, sizes
from lanindex.notation.lpd_ldd import Ranges

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

CELLS = 27
"""Cells are numbered direction · 3 + level."""

FULL = 22.5
"""Degrees from a border at which a margin is 1."""


@dataclass(frozen=True, slots=True, eq=False)
class Space:
    """The space around a joint, divided for one limb."""

    ranges: Ranges  # The borders
    length: float  # L, mm
    # (27, 3) float64, the middle of each cell: unit vectors, and for place the points (0, -1, 0),
    # (0, 0, 0), (0, 1, 0); forward +x, up +y, right +z
    references: Floats

    def reference(self, cell: int) -> Floats:
        """Return the middle of a cell, (3,) mm."""
        point: Floats = self.references[cell] * self.length
        return point


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """A curve in terms of the cells that it passes, point by point."""

    cells: NDArray[np.int8]  # (N,) int8, direction · 3 + level
    # (N,) float64, distance from the middle of the point's cell: between unit vectors, for place
    # between points, in limb lengths. To be compared within one cell
    apart: Floats
    # (N,) float64, degrees from the reference direction: for place low and high from the vertical,
    # 0 for place mid
    angle: Floats


def space(ranges: Ranges, length: float) -> Space:
    """Divide the space around a joint for a limb of `length` mm."""
    return Space(ranges, length, _references(ranges))


@cache
def _references(ranges: Ranges) -> Floats:
    references = np.zeros((CELLS, 3))
    for direction in range(PLACE):
        azimuth = radians(ranges.centre(direction))
        for level, elevation in enumerate((pi / 4, pi / 2, 3 * pi / 4)):
            references[direction * 3 + level] = (
                sin(azimuth) * sin(elevation),
                -cos(elevation),
                cos(azimuth) * sin(elevation),
            )
    references[PLACE * 3 + LOW, 1] = -1
    references[PLACE * 3 + HIGH, 1] = 1
    references.flags.writeable = False
    return references


def polar(points: Floats) -> tuple[Floats, Floats, Floats]:
    """Return horizontal distance, azimuth and elevation from straight down, in degrees."""
    forward, up, right = (points[..., axis] for axis in range(3))
    away = np.hypot(forward, right)
    azimuth = np.degrees(np.arctan2(forward, right))
    azimuth += 360 * (azimuth < 0)
    nowhere = (away == 0) & (up == 0)  # at the joint itself, neither below nor above
    return away, azimuth, np.where(nowhere, 90.0, np.degrees(np.arctan2(away, -up)))


def _sectors(azimuth: Floats, ranges: Ranges) -> NDArray[np.int64]:
    order = np.argsort(ranges.starts)
    borders = np.array(ranges.starts)[order]
    return order[borders.searchsorted(azimuth, side="right") - 1]


class Borders(NamedTuple):
    """The divisions of some limbs' spaces, one a row: see `Ranges`, and `Space.references`."""

    place: Floats
    relative: Flags
    mid: Floats
    high: Floats
    starts: Floats
    references: Floats


@cache
def borders(each: tuple[Ranges, ...]) -> Borders:
    """Return the divisions of several spaces as arrays."""
    fields = zip(*((it.place, it.relative, it.mid, it.high, it.starts) for it in each), strict=True)
    return Borders._make((*map(np.array, fields), np.array([_references(it) for it in each])))


def numbers(around: Sequence[Space]) -> tuple[Borders, Floats]:
    """Return the divisions; and length, radius of place, elevations of mid and high, (4, P)."""
    found = borders(tuple(one.ranges for one in around))
    length = np.array([one.length for one in around])
    radius = found.place * np.where(found.relative, length, 1)
    return found, np.array((length, radius, found.mid, found.high))


def course(curves: Floats, around: Sequence[Space]) -> list[Course]:
    """Return the cells of curves (P, N, 3) mm, forward, up, right of the parent joint."""
    shape = curves.shape[:-1]
    cells, apart, angle = np.empty(shape, np.int8), np.empty(shape), np.empty(shape)
    for part in blocks(curves.shape[1]):
        found = _course(curves[:, part.inner], around)
        cells[:, part.inner], apart[:, part.inner], angle[:, part.inner] = found
    return list(map(Course, cells, apart, angle))


def _course(curves: Floats, around: Sequence[Space]) -> tuple[NDArray[np.int64], Floats, Floats]:
    """Return the fields of `Course` for some frames of each curve, (P, N) each."""
    found, (length, radius, mid, high) = numbers(around)
    length, radius, mid, high = (it[:, None] for it in (length, radius, mid, high))
    away, azimuth, elevation = polar(curves)
    place = away <= radius
    sectors = [_sectors(turn, one.ranges) for turn, one in zip(azimuth, around, strict=True)]
    level = np.add(elevation >= mid, elevation >= high, dtype=np.int64)
    code = np.where(place, PLACE, sectors) * 3 + level
    scale = np.where(place, length, np.maximum(sizes(curves), 1e-9))
    middles = found.references.reshape(-1, 3).T
    middle = middles.take(code + CELLS * np.arange(len(around))[:, None], axis=1)
    apart = sizes((curves.transpose(2, 0, 1) / scale - middle).transpose(1, 2, 0))
    return code, apart, _angles(code, apart, elevation)


def _angles(code: NDArray[np.int64], apart: Floats, elevation: Floats) -> Floats:
    direction, level = np.divmod(code, 3)
    angle = np.degrees(2 * np.arcsin(np.minimum(apart / 2, 1)))
    upright = np.where(level == LOW, elevation, np.where(level == HIGH, 180 - elevation, 0.0))
    found: Floats = np.where(direction == PLACE, upright, angle)
    return found


def angles(points: Floats, code: NDArray[np.int64], apart: Floats) -> Floats:
    """Return how far points (N, 3) are from the middle of their cells, as in `Course`."""
    return _angles(code, apart, polar(points)[2])


def margins(
    points: Floats, code: NDArray[np.int64], around: Sequence[Space], limb: NDArray[np.int64]
) -> tuple[Floats, NDArray[np.int64]]:
    """Return the margins (N,) of points (N, 3) mm, and the cells (N,) across the nearest borders.

    `code` (N,) the cells of the points, `limb` (N,) their index in `around`; a margin is 0 at a
    border, 1 at `FULL` degrees or one radius of place from every border.
    """
    found, borders = numbers(around)
    _, radius, mid, high = borders[:, limb]
    away, azimuth, elevation = polar(points)
    direction, level = np.divmod(code, 3)
    placed = direction == PLACE
    before, after = (direction - 1) % 8, (direction + 1) % 8
    behind = azimuth[:, None] - found.starts[limb]
    across = np.where(placed, (behind % 360).argmin(axis=1), PLACE)
    rows = np.arange(len(code))
    never = 1e9
    measures = np.array(
        (
            np.where(placed, never, behind[rows, direction % 8] % 360 / FULL),
            np.where(placed, never, -behind[rows, after] % 360 / FULL),
            (np.choose(level, (mid, high, np.inf)) - elevation) / FULL,
            (elevation - np.choose(level, (-np.inf, mid, high))) / FULL,
            np.divide(np.abs(away - radius), radius, np.full_like(away, never), where=radius > 0),
        )
    )
    others = np.array(
        (before * 3 + level, after * 3 + level, code + 1, code - 1, across * 3 + level)
    )
    nearest = measures.argmin(axis=0), rows
    return np.clip(measures[nearest], 0.0, 1.0), others[nearest]
