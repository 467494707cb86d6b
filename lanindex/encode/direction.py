"""Stage 3: which cell of space a limb points into, and how clearly.

Source: METHOD, stages 3 and 4, "Margin"; the paper, 4.5.2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from math import cos, pi, radians, sin

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import HIGH, LOW, PLACE
from lanindex.notation.lpd import Ranges

Floats = NDArray[np.float64]

CELLS = 27
"""Cells are numbered direction · 3 + level."""

FULL = 22.5
"""Degrees from a border at which a margin is 1."""


@dataclass(frozen=True, slots=True, eq=False)
class Space:
    """The space around a joint, divided for one limb.

    Attributes
    ----------
    ranges : Ranges
        The borders.
    length : float
        L, mm.
    references : ndarray
        (27, 3) float64, the middle of each cell: unit vectors, and for place the points
        (0, -1, 0), (0, 0, 0), (0, 1, 0); forward +x, up +y, right +z.
    """

    ranges: Ranges
    length: float
    references: Floats

    def reference(self, cell: int) -> Floats:
        """Return the middle of a cell, (3,) mm."""
        point: Floats = self.references[cell] * self.length
        return point


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """A curve in terms of the cells that it passes, point by point.

    Attributes
    ----------
    cells : ndarray
        (N,) int64, direction · 3 + level.
    apart : ndarray
        (N,) float64, distance from the middle of the point's cell: between unit vectors, for place
        between points, in limb lengths. To be compared within one cell.
    angle : ndarray
        (N,) float64, degrees from the reference direction: for place low and high from the
        vertical, 0 for place mid.
    """

    cells: NDArray[np.int64]
    apart: Floats
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


def sizes(vectors: Floats) -> Floats:
    """Return the sizes of vectors (..., 3)."""
    size: Floats = np.sqrt(vectors[..., 0] ** 2 + vectors[..., 2] ** 2 + vectors[..., 1] ** 2)
    return size


def _polar(curve: Floats) -> tuple[Floats, Floats, Floats]:
    """Return horizontal distance, azimuth and elevation from straight down, in degrees."""
    forward, up, right = curve.T
    away = np.hypot(forward, right)
    azimuth = np.degrees(np.arctan2(forward, right))
    azimuth += 360 * (azimuth < 0)
    nowhere = (away == 0) & (up == 0)  # at the joint itself, neither below nor above
    return away, azimuth, np.where(nowhere, 90.0, np.degrees(np.arctan2(away, -up)))


def _sectors(azimuth: Floats, ranges: Ranges) -> NDArray[np.int64]:
    order, borders = _borders(ranges)
    return order[borders.searchsorted(azimuth, side="right") - 1]


@cache
def _borders(ranges: Ranges) -> tuple[NDArray[np.int64], Floats]:
    order = np.argsort(ranges.starts)
    return order, np.array(ranges.starts)[order]


def course(curve: Floats, around: Space) -> Course:
    """Tell where each point of a curve lies.

    Parameters
    ----------
    curve : ndarray
        (N, 3) float64, mm: child minus parent, forward +x, up +y, right +z.
    around : Space
        The division.

    Returns
    -------
    Course
        (N) points.
    """
    ranges = around.ranges
    away, azimuth, elevation = _polar(curve)
    place = away <= ranges.radius(around.length)
    direction = np.where(place, PLACE, _sectors(azimuth, ranges))
    level = np.add(elevation >= ranges.mid, elevation >= ranges.high, dtype=np.int64)
    code = direction * 3 + level
    scale = np.where(place, around.length, np.maximum(sizes(curve), 1e-9))
    apart = sizes((curve.T / scale - around.references.T.take(code, axis=1)).T)
    angle = np.degrees(2 * np.arcsin(np.minimum(apart / 2, 1)))
    upright = np.where(level == LOW, elevation, np.where(level == HIGH, 180 - elevation, 0.0))
    return Course(code, apart, np.where(place, upright, angle))


def margins(
    curve: Floats, code: NDArray[np.int64], around: Space
) -> tuple[Floats, NDArray[np.int64]]:
    """Return how clearly points lie in their cells, and the cell across the nearest border.

    Parameters
    ----------
    curve : ndarray
        (N, 3) float64, mm.
    code : ndarray
        (N,) int64, the cell of each.
    around : Space
        The division.

    Returns
    -------
    margin : ndarray
        (N,) float64, 0 at a border, 1 at 22.5 degrees or one radius of place from every border.
    runner_up : ndarray
        (N,) int64, the cell across the border that is nearest in this measure.
    """
    ranges = around.ranges
    starts, radius = np.array(ranges.starts), ranges.radius(around.length)
    away, azimuth, elevation = _polar(curve)
    direction, level = np.divmod(code, 3)
    placed = direction == PLACE
    own = np.where(placed, 0, direction)
    before, after = (own - 1) % 8, (own + 1) % 8
    borders = np.array([-np.inf, ranges.mid, ranges.high, np.inf])
    never = 1e9
    across = np.where(placed, _sectors(azimuth, ranges), PLACE)
    choices = (
        (np.where(placed, never, (azimuth - starts[own]) % 360 / FULL), before * 3 + level),
        (np.where(placed, never, (starts[after] - azimuth) % 360 / FULL), after * 3 + level),
        ((borders[level + 1] - elevation) / FULL, direction * 3 + level + 1),
        ((elevation - borders[level]) / FULL, direction * 3 + level - 1),
        (
            np.abs(away - radius) / radius if radius else np.full_like(away, never),
            across * 3 + level,
        ),
    )
    measures = np.stack([measure for measure, _ in choices])
    nearest = np.argmin(measures, axis=0)
    rows = np.arange(len(curve))
    runner_up = np.stack([cell for _, cell in choices])[nearest, rows]
    return np.clip(measures[nearest, rows], 0.0, 1.0), runner_up
