"""Stage 1: where the body faces, frame by frame.

Source: ``encoding/METHOD.md``, stage 1; Matsumoto and Hachimura (2001), 4.2.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lanindex.encoding.arithmetic import blocks, runs
from lanindex.encoding.joints import Body, unknown_of
from lanindex.encoding.profile import load
from lanindex.encoding.resample import Resampling
from lanindex.model import Motion

Floats = NDArray[np.float64]

AXES = (("LHip", "RHip"), ("LShoulder", "RShoulder"))
"""What tells where the body faces, the first that is there."""

SHORTEST_AXIS = 1.0
"""Millimetres: a hip axis shorter than this on the ground tells no heading."""


def heading(motion: Motion, target: Fraction, body: Body | None = None) -> Floats:
    """Return the turn that brings the hip axis to +z, frame by frame.

    returned (N,) float64, radians about the vertical; where the axis tells nothing the last turn is
    kept.
    """
    whole = body or Body(motion, load("default"))
    for pair in AXES:
        seen = np.empty(len(motion), bool)
        for part in blocks(len(motion)):
            seen[part.inner] = ~unknown_of(_axis(whole, pair, part.inner))
        if seen.any():
            break
    count = math.floor((len(motion) - 1) * target / motion.rate) + 1
    turn, clear = np.zeros(count), np.zeros(count, bool)
    for start, stop in runs(seen):
        work = Resampling(start, stop - start, motion.rate / target)
        for part in blocks(len(work.frames)):
            some = work.frames[part.inner]
            near = work.sources(some)
            axis = _axis(whole, pair, slice(start + near.start, start + near.stop))
            east, south = work.values(axis, some).T
            turn[some.start : some.stop] = np.arctan2(east, south)
            clear[some.start : some.stop] = np.hypot(east, south) >= SHORTEST_AXIS
    for start, stop in runs(~clear):
        if stop - start < count:
            turn[start:stop] = turn[start - 1 if start else stop]
        else:
            turn[:] = 0
    return turn


def _axis(body: Body, pair: tuple[str, str], frames: slice) -> Floats:
    """Return the way from left to right over the ground in some frames, (n, 2)."""
    left, right = body.at(pair, frames).transpose(1, 0, 2)
    axis: Floats = (right - left)[:, ::2]
    return axis
