"""Stage 1: where the body faces, frame by frame.

Source: ``encode/METHOD.md``, stage 1; Matsumoto and Hachimura (2001), 4.2.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from fractions import Fraction
from functools import partial

import numpy as np
from numpy.typing import NDArray

from lanindex.encode.arithmetic import runs
from lanindex.encode.joints import Joints, body, unknown_of
from lanindex.encode.resample import resample
from lanindex.model import Motion

Floats = NDArray[np.float64]

AXES = (("LHip", "RHip"), ("LShoulder", "RShoulder"))
"""What tells where the body faces, the first that is there."""

SHORTEST_AXIS = 1.0
"""Millimetres: a hip axis shorter than this on the ground tells no heading."""


Reading = Callable[[Iterable[str]], Joints]


def heading(motion: Motion, target: Fraction, read: Reading | None = None) -> Floats:
    """Return the turn that brings the hip axis to +z, frame by frame.

    Parameters
    ----------
    motion : Motion
        The capture.
    target : Fraction
        Frames a second of the result.
    read : callable, optional
        What gives its joints, where they have been read.

    Returns
    -------
    ndarray
        (N,) float64, radians about the vertical; where the axis tells nothing the last turn is
        kept. A body without hips is turned by its shoulders.

    Examples
    --------
    >>> from fractions import Fraction
    >>> import lanindex
    >>> from lanindex.encode.heading import heading
    >>> turn = heading(lanindex.read("corpus/compass.bvh"), Fraction(60))
    >>> turn.shape, round(float(turn[0]), 3)  # faces +z; forward shall be +x
    ((1679,), -1.571)
    """
    axis = _axis(read or partial(body, motion))
    count = math.floor((len(axis) - 1) * target / motion.rate) + 1
    across = np.full((2, count), np.nan).T
    for start, stop in runs(~unknown_of(axis)):
        begin, values = resample(axis[start:stop], start, motion.rate, target)
        across[begin : begin + len(values)] = values
    turn: Floats = np.arctan2(across[:, 0], across[:, 1])
    clear = np.hypot(across[:, 0], across[:, 1]) >= SHORTEST_AXIS
    if clear.all():
        return turn
    if not clear.any():
        return np.zeros(count)
    last = np.maximum.accumulate(np.where(clear, np.arange(count), -1))
    last[last < 0] = np.argmax(clear)
    held: Floats = turn[last]
    return held


def _axis(read: Reading) -> Floats:
    """Return the way from left to right over the ground, (T, 2)."""
    for pair in AXES:
        joints = read(pair)
        left, right = (joints[name] for name in pair)
        axis = np.stack([right[:, level] - left[:, level] for level in (0, 2)]).T
        if not unknown_of(axis).all():
            break
    return axis
