"""Which way limbs are written down: the plain one, or the compiled one (extra ``fast``).

To import numba and to make ready what it has compiled costs nine tenths of a second, a fifth of one
where it compiles for something else already: a few short captures go the plain way.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.encode import bends, carriers, curves, ground, limbs, near, steps, swings, track, ways
from lanindex.encode.carriers import Carriers
from lanindex.encode.ground import Feet, Flags, Stood
from lanindex.encode.limbs import Curves, Floats, Limbs
from lanindex.encode.near import Nearest
from lanindex.encode.profile import Profile
from lanindex.encode.resample import Resampling
from lanindex.encode.steps import Levels
from lanindex.encode.swings import Angles
from lanindex.encode.track import Written

WORTH = 600_000
"""Frames of parts, what the process wrote down before among them, from which on numba is wanted."""

CHEAPER = 5
"""By how much less it is to be had once numba has been imported for something else."""


class Stages(NamedTuple):
    """The loops over frames: of parts, of joints, of hands, of what carries, and of angles."""

    curves: Curves
    written: Callable[[Limbs, Profile], list[Written]]
    calm: Callable[[Floats, Resampling, range, int], Floats]
    nearest: Nearest
    carriers: Carriers
    mean: Callable[[Floats, int], Floats]
    bends: Callable[[Floats, Profile], list[Floats]]
    arrivals: Callable[[Angles, float, Profile, bool], Floats]
    turns: Callable[[Floats, Profile], Floats]
    stood: Stood
    carried: Callable[[Feet, NDArray[np.float32], float], tuple[Flags, bool]]
    levels: Levels


PLAIN = Stages(
    limbs.curves,
    track.written,
    limbs.calm,
    near.nearest,
    carriers.carriers,
    curves.mean,
    bends.found,
    swings.arrivals,
    ways.turns,
    ground.stood,
    ground.carried,
    steps.levels,
)

_FAST = "lanindex.encode.written_fast"
_gone = 0


def chosen(work: int) -> Stages:
    """Return the compiled way once it is there, or much has been done without; else the plain one.

    Parameters
    ----------
    work : int
        Frames of parts that are to be written down now.
    """
    global _gone
    _gone += work
    enough = _gone >= (WORTH // CHEAPER if "numba" in sys.modules else WORTH)
    return (compiled() or PLAIN) if enough or _FAST in sys.modules else PLAIN


@cache
def compiled() -> Stages | None:
    """Load the compiled way; without numba, or a folder for its cache, there is none."""
    try:
        from lanindex.encode.carriers_fast import carriers
        from lanindex.encode.curves_fast import arrivals, bends, mean, turns
        from lanindex.encode.ground_fast import carried, levels, stood
        from lanindex.encode.limbs_fast import calm, curves
        from lanindex.encode.near_fast import nearest
        from lanindex.encode.written_fast import written
    except (ImportError, RuntimeError):
        return None
    of_curves = mean, bends, arrivals, turns
    return Stages(curves, written, calm, nearest, carriers, *of_curves, stood, carried, levels)
