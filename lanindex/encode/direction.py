"""Stage 3: which cell of space a limb points into, and how clearly.

Source: METHOD, stages 3 and 4, "Margin"; the paper, 4.5.2.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, hypot, pi, radians, sin

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import HIGH, LOW, MID, PLACE
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

    def cell(self, point: Floats) -> int:
        """Return the cell of one point (3,), mm."""
        return int(cells(point[None], self)[0])

    def reference(self, cell: int) -> Floats:
        """Return the middle of a cell, (3,) mm."""
        point: Floats = self.references[cell] * self.length
        return point


def space(ranges: Ranges, length: float) -> Space:
    """Divide the space around a joint for a limb of `length` mm."""
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
    return Space(ranges, length, references)


def cells(curve: Floats, around: Space) -> NDArray[np.int64]:
    """Return the cell that each point lies in.

    Parameters
    ----------
    curve : ndarray
        (N, 3) float64, mm: child minus parent, forward +x, up +y, right +z.
    around : Space
        The division.

    Returns
    -------
    ndarray
        (N,) int64, direction · 3 + level.
    """
    forward, up, right = curve[:, 0], curve[:, 1], curve[:, 2]
    away = np.hypot(forward, right)
    ranges = around.ranges
    azimuth = np.degrees(np.arctan2(forward, right)) % 360
    order = np.argsort(ranges.starts)
    borders = np.array(ranges.starts)[order]
    direction = order[np.searchsorted(borders, azimuth, side="right") - 1]
    direction = np.where(away <= ranges.radius(around.length), PLACE, direction)
    elevation = np.degrees(np.arctan2(away, -up))
    level = np.searchsorted([ranges.mid, ranges.high], elevation, side="right")
    result: NDArray[np.int64] = direction * 3 + level
    return result


def nearest(curve: Floats, cell: int, around: Space) -> tuple[int, float]:
    """Return where a curve comes nearest to the middle of a cell.

    Parameters
    ----------
    curve : ndarray
        (N, 3) float64, mm.
    cell : int
        Which.
    around : Space
        The division.

    Returns
    -------
    frame : int
        The nearest, by angle, for place by distance; the first on ties.
    angle : float
        Degrees from the reference there: for place low and high from the vertical, 0 for
        place mid.
    """
    reference = around.references[cell]
    if cell // 3 == PLACE:
        frame = int(np.argmin(((curve - reference * around.length) ** 2).sum(axis=1)))
        if cell % 3 == MID:
            return frame, 0.0
        point = curve[frame]
        upright = point[1] * reference[1]
        return frame, float(np.degrees(np.arctan2(hypot(point[0], point[2]), upright)))
    size = np.sqrt((curve**2).sum(axis=1))
    apart = ((curve / np.maximum(size, 1e-9)[:, None] - reference) ** 2).sum(axis=1)
    frame = int(np.argmin(apart))
    return frame, float(np.degrees(2 * np.arcsin(min(1.0, np.sqrt(apart[frame]) / 2))))


def margin(point: Floats, around: Space) -> tuple[float, int]:
    """Return how clearly a point lies in its cell, and the cell across the nearest border.

    Parameters
    ----------
    point : ndarray
        (3,) float64, mm.
    around : Space
        The division.

    Returns
    -------
    margin : float
        0 at a border, 1 at 22.5 degrees or one radius of place from every border.
    runner_up : int
        The cell across the border that is nearest in this measure.
    """
    ranges = around.ranges
    forward, up, right = (float(value) for value in point)
    away = hypot(forward, right)
    cell = around.cell(point)
    direction, level = divmod(cell, 3)
    azimuth = float(np.degrees(np.arctan2(forward, right))) % 360
    elevation = float(np.degrees(np.arctan2(away, -up)))
    sector = direction if direction != PLACE else _sector(azimuth, ranges)
    choices: list[tuple[float, int]] = []
    if direction != PLACE:
        choices += _beside(azimuth, direction, level, ranges)
    if level != HIGH:
        border = (ranges.mid, ranges.high)[level]
        choices.append(((border - elevation) / FULL, direction * 3 + level + 1))
    if level != LOW:
        border = (ranges.mid, ranges.high)[level - 1]
        choices.append(((elevation - border) / FULL, direction * 3 + level - 1))
    radius = ranges.radius(around.length)
    across = sector if direction == PLACE else PLACE
    if radius > 0:
        choices.append((abs(away - radius) / radius, across * 3 + level))
    least, other = min(choices, key=lambda choice: choice[0])
    return min(1.0, max(0.0, least)), other


def _sector(azimuth: float, ranges: Ranges) -> int:
    turned = [(azimuth - start) % 360 for start in ranges.starts]
    return turned.index(min(turned))


def _beside(azimuth: float, direction: int, level: int, ranges: Ranges) -> list[tuple[float, int]]:
    before, after = (direction - 1) % 8, (direction + 1) % 8
    return [
        (((azimuth - ranges.starts[direction]) % 360) / FULL, before * 3 + level),
        (((ranges.starts[after] - azimuth) % 360) / FULL, after * 3 + level),
    ]
