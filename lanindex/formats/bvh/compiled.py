"""Which path reads the numbers: the plain one, or the compiled one (extra ``fast``)."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.body import kinematics
from lanindex.body.kinematics import Plan
from lanindex.formats.bvh import floats

WORTH = 4_000_000
"""Bytes to be read in a process from which on numba's import (half a second) is risked."""

_FAST = "lanindex.formats.bvh.floats_fast"

Floats = NDArray[np.float64]
Parse = Callable[[bytes, NDArray[np.int64], int], tuple[Floats, int | None]]
Positions = Callable[[Plan, Floats], Floats]


class Paths(NamedTuple):
    """What reads numbers, and what makes places of them."""

    parse: Parse
    positions: Positions


PLAIN = Paths(floats.parse, kinematics.positions)


def paths(size: int) -> Paths:
    """Return the compiled path for a large file, or once it has been loaded; else the plain one.

    Parameters
    ----------
    size : int
        Bytes to be read.
    """
    return (compiled() or PLAIN) if size >= WORTH or _FAST in sys.modules else PLAIN


@cache
def compiled() -> Paths | None:
    """Load the compiled path; without numba, or a folder for its cache, there is none."""
    try:
        from lanindex.body import kinematics_fast
        from lanindex.formats.bvh import floats_fast
    except (ImportError, RuntimeError):
        return None
    return Paths(floats_fast.parse, kinematics_fast.positions)
