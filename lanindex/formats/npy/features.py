"""Features of HumanML3D and KIT-ML → where the joints are.

A frame holds how far the root turns about y until the next (half the angle), how far it moves
along x and z as it faces then, its height, and x, y, z of each other joint from below the root, as
it faces. Turns, speeds and contacts of the feet, which follow, tell nothing more.

Source: Guo et al. (2022), *Generating Diverse and Natural 3D Human Motions from Text*, CVPR, and
the code published with it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

TITLES = {263: "HumanML3D", 251: "KIT-ML"}
"""By how many numbers a frame has, twelve for each joint but one: whose they are."""


def used(width: int) -> int:
    """Return how many of a frame's numbers tell where joints are."""
    return 4 + 3 * ((width + 1) // 12 - 1)


def placed(values: NDArray[Any]) -> NDArray[np.float32]:
    """Return where joints are.

    Parameters
    ----------
    values : ndarray
        (T, 4 + 3 (J - 1)) the numbers that are `used`.

    Returns
    -------
    ndarray
        (T, J, 3) y up; the root begins above the origin and faces z.
    """
    values = values.astype(np.float64)
    turned = 2 * np.cumsum(np.append(0, values[:-1, 0]))
    places = np.zeros((len(values), (values.shape[1] - 4) // 3 + 1, 3))
    places[1:, 0, [0, 2]] = values[:-1, 1:3]
    places[:, 1:] = values[:, 4:].reshape(len(values), -1, 3)
    x, z, cos, sin = places[..., 0], places[..., 2], np.cos(turned), np.sin(turned)
    places[..., 0], places[..., 2] = (
        x * cos[:, None] - z * sin[:, None],
        x * sin[:, None] + z * cos[:, None],
    )
    places[:, 0] = np.cumsum(places[:, 0], axis=0)
    places[:, 1:, [0, 2]] += places[:, :1, [0, 2]]
    places[:, 0, 1] = values[:, 3]
    return places.astype(np.float32)
