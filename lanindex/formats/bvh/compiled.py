"""Which path reads the numbers: the plain one, or the compiled one (extra ``fast``)."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex import compiled
from lanindex.body import kinematics
from lanindex.body.kinematics import Plan
from lanindex.formats.bvh import floats

Floats = NDArray[np.float64]
Parse = Callable[[bytes, NDArray[np.int64], int], tuple[Floats, int | None]]
Positions = Callable[[Plan, Floats], Floats]


class Paths(NamedTuple):
    """What reads numbers, and what makes places of them."""

    parse: Parse
    positions: Positions


PLAIN = Paths(floats.parse, kinematics.positions)


def paths(size: int) -> Paths:
    """Return the path for a file of so many bytes: see `lanindex.compiled.chosen`."""
    return fast() if compiled.chosen("numbers", size) else PLAIN


def fast() -> Paths:
    """Return the compiled path; numba must be there."""
    from lanindex.body import kinematics_fast
    from lanindex.formats.bvh import floats_fast

    return Paths(floats_fast.parse, kinematics_fast.positions)
