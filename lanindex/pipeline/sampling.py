"""Which captures of a large library a job looks at where it would take too long to look at all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lanindex.errors import UsageError


def sampled(count: int, most: int | None) -> NDArray[np.int64]:
    """Return the places of the captures that are looked at: (S,) int64, in order.

    They are drawn at random, since captures that follow each other may be alike, and the same ones
    each time.
    """
    if most is not None and most < 1:
        raise UsageError(f"a sample of {most}", wanted="1 or more")
    if most is None or count <= most:
        return np.arange(count)
    return np.sort(np.random.default_rng(0).choice(count, most, replace=False))
