"""How fast, how far and how straight each symbol is gone.

Source: ``encode/BODY.md``, "Measures".
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.encode.limbs import Limbs
from lanindex.encode.profile import Profile
from lanindex.model.symbol import FIELDS

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]
Rows = NDArray[Any]

WAY = 0.05
"""Seconds from one point of a way to the next."""

_TINY = 1e-9
"""Millimetres: who is no farther away points nowhere."""


def measure(rows: Rows, counts: Sequence[int], limbs: Limbs, profile: Profile) -> None:
    """Fill in the measures of rows, in place; a starting position has none.

    Parameters
    ----------
    rows : ndarray
        (S,) of `model.SYMBOL`, part by part, start and stop in resampled frames, the first of each
        its starting position.
    counts : sequence of int
        (P) rows of each part.
    limbs : Limbs
        (P) parts whose symbols they are.
    profile : Profile
        Frames a second.
    """
    limb, frames = np.arange(len(counts)).repeat(counts), limbs.curve.shape[1]
    first = np.maximum(rows["start"].astype(np.int64) - limbs.begin - 1, 0)
    last = np.clip(rows["stop"].astype(np.int64) - limbs.begin - 1, first, frames - 1)
    rate = float(profile.rate)
    speed = _peaks(limbs.curve, limb, first, last) * rate / limbs.lengths[limb]
    pace = max(round(WAY * rate), 1)
    size, straight = _ways(limbs.curve, limb, first, last, limbs.lengths, pace)
    moved = np.diff(limb, prepend=-1) == 0
    for name, values in ("speed", speed), ("size", size), ("straightness", straight):
        how = FIELDS[name]
        told = np.rint(np.minimum(values * how.scale, how.most)) / how.scale
        rows[name][moved] = told[moved]


def _peaks(curve: Floats, limb: Whole, first: Whole, last: Whole) -> Floats:
    """Return the highest speed of each row: (S,) mm a frame, by central differences."""
    parts, frames, _ = curve.shape
    squares = np.zeros((parts, frames + 1))  # one more, for a row to end before
    if frames > 1:
        for place in curve.transpose(2, 0, 1):
            squares[:, 1:-2] += np.square(place[:, 2:] - place[:, :-2])
            squares[:, 0] += 4 * (place[:, 1] - place[:, 0]) ** 2
            squares[:, -2] += 4 * (place[:, -1] - place[:, -2]) ** 2
    pairs = np.stack((first, last + 1), axis=1) + (limb * (frames + 1))[:, None]
    peaks: Floats = np.sqrt(np.maximum.reduceat(squares.ravel(), pairs.ravel())[::2]) / 2
    return peaks


def _ways(
    curve: Floats, limb: Whole, first: Whole, last: Whole, lengths: Floats, pace: int
) -> tuple[Floats, Floats]:
    """Return the degrees from the first frame of each row to its last, and how straight it goes.

    The way counts what the direction turns, in radians, and what the part is stretched or drawn
    in, in its lengths, both at once.
    """
    counts = -((first - last) // pace) + 1
    begins = np.cumsum(counts) - counts
    row = np.arange(len(first)).repeat(counts)
    frames = first[row] + pace * (np.arange(len(row)) - begins[row])
    points = curve[limb[row], np.minimum(frames, last[row])]
    away = np.sqrt(np.square(points).sum(axis=1))
    directions = points / np.maximum(away, _TINY)[:, None]
    away /= lengths[limb[row]]
    ends = begins + counts - 1
    turned = _angles(directions[ends], directions[begins])
    whole = np.hypot(turned, away[ends] - away[begins])
    steps = np.hypot(_angles(directions[1:], directions[:-1]), np.diff(away))
    steps[ends[:-1]] = 0  # from one row to the next
    gone = np.add.reduceat(np.append(steps, 0.0), begins)
    straight = np.divide(whole, gone, out=np.ones(len(whole)), where=gone > 0)
    return np.degrees(turned), np.minimum(straight, 1.0)


def _angles(some: Floats, others: Floats) -> Floats:
    """Return the angles between unit vectors, radians: (N,)."""
    angles: Floats = 2 * np.arcsin(np.minimum(np.sqrt(np.square(some - others).sum(axis=1)) / 2, 1))
    return angles
