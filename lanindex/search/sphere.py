"""Where symbols point: cells as points of a sphere about the joint.

`place low` and `place high` are the poles, `place mid` is the centre. So neighbouring cells are
near each other, opposite ones far apart. A symbol points to the middle of its cell, drawn towards
the cell across the nearest border the less clearly it lies in its own: half-way at the border.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTIONS, LEVELS, PLACE
from lanindex.model.columns import CELL, cell_of

CELLS = np.array([cell_of(*codes) for codes in np.ndindex(len(DIRECTIONS), len(LEVELS))])
"""(27,) the cells with a direction and a level, those of a direction together."""

KNOWN = np.isin(np.arange(CELL + 1), CELLS)
"""Which cells those are."""

MIDDLES = np.zeros((CELL + 1, 3))
"""The middle of each cell: x right, y up, z forward; without direction or level the centre."""

_AZIMUTH = np.radians(45.0 * np.arange(PLACE))[:, None]
_ELEVATION = np.radians(45.0 * (1 + np.arange(len(LEVELS))))
_POINTS = np.zeros((len(DIRECTIONS), len(LEVELS), 3))
_POINTS[:PLACE, :, 0] = np.sin(_ELEVATION) * np.cos(_AZIMUTH)
_POINTS[:PLACE, :, 1] = -np.cos(_ELEVATION)
_POINTS[:PLACE, :, 2] = np.sin(_ELEVATION) * np.sin(_AZIMUTH)
_POINTS[PLACE, :, 1] = np.arange(len(LEVELS)) - 1
MIDDLES[CELLS] = _POINTS.reshape(-1, 3)


def points_of(
    cells: NDArray[Any], runners: NDArray[Any], margins: NDArray[np.floating[Any]]
) -> NDArray[Any]:
    """Return where symbols point: (N, 3), from (N,) cells and margins."""
    middles = MIDDLES.astype(margins.dtype)
    points: NDArray[Any] = middles[cells]
    share = (1 - margins) / 2 * (KNOWN[cells] & KNOWN[runners])
    points += share[:, None] * (middles[runners] - points)
    return points
