"""What several stages work out alike."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def sizes(vectors: Floats) -> Floats:
    """Return the sizes of vectors.

    The horizontal part is summed first: quarter turns and mirroring then change no bit.

    Parameters
    ----------
    vectors : ndarray
        (..., 3) float64: forward, up, right.

    Returns
    -------
    ndarray
        (...) float64, in the vectors' unit.
    """
    size: Floats = np.sqrt(vectors[..., 0] ** 2 + vectors[..., 2] ** 2 + vectors[..., 1] ** 2)
    return size


def median(values: Floats) -> float:
    """Return the middle value, in a fifth of the time of numpy's median, which checks for NaN.

    Parameters
    ----------
    values : ndarray
        (N,) float64, one at least, none NaN.
    """
    ordered = np.sort(values)
    return float(ordered[(len(ordered) - 1) // 2] + ordered[len(ordered) // 2]) / 2
