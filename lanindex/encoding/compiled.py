"""The loops over frames that have two ways: plain, and compiled (extra ``fast``)."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex import compiled
from lanindex.encoding import (
    bends,
    carriers,
    curves,
    ground,
    limbs,
    near,
    steps,
    swings,
    track,
    ways,
)
from lanindex.encoding.carriers import Carriers
from lanindex.encoding.ground import Feet, Flags, Stood
from lanindex.encoding.limbs import Curves, Floats, Limbs
from lanindex.encoding.near import Nearest
from lanindex.encoding.profile import Profile
from lanindex.encoding.resample import Resampling
from lanindex.encoding.steps import Levels
from lanindex.encoding.swings import Angles
from lanindex.encoding.track import Written


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


def chosen(frames: int) -> Stages:
    """Return the way for so many frames of a body: see `lanindex.compiled.chosen`."""
    return fast() if compiled.chosen("encode", frames * compiled.FRAME) else PLAIN


def fast() -> Stages:
    """Return the compiled way; numba must be there."""
    from lanindex.encoding.carriers_fast import carriers
    from lanindex.encoding.curves_fast import arrivals, bends, mean, turns
    from lanindex.encoding.ground_fast import carried, levels, stood
    from lanindex.encoding.limbs_fast import calm, curves
    from lanindex.encoding.near_fast import nearest
    from lanindex.encoding.written_fast import written

    of_curves = mean, bends, arrivals, turns
    return Stages(curves, written, calm, nearest, carriers, *of_curves, stood, carried, levels)
