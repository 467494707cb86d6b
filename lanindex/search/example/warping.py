"""Dynamic time warping of joint positions: the body itself, where the files are at hand.

The plain way to compare movement, and a hundred times dearer than symbols: each frame of one clip
is laid upon a frame of the other, in order, so that joints lie near each other.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES

Floats = NDArray[np.float32]

RATE = 30
"""Frames a second that are compared at the most."""


def normalised(joints: NDArray[np.float32], rate: float) -> Floats:
    """Return a clip as every body would do it anywhere, facing any way.

    Parameters
    ----------
    joints, rate : ndarray, float
        (T, 20, 3), those of the body model, mm, y up, NaN where unknown; frames a second.

    Returns
    -------
    ndarray
        (U, 20, 3), at `RATE` at the most: seen from the middle of the hips, turned so that these
        lie along z, in lengths of the leg.
    """
    step = max(1.0, rate / RATE)
    kept = joints[np.floor(np.arange(0, len(joints), step)).astype(np.int64)].astype(np.float64)
    right, left = kept[:, JOINT_CODES["RHip"]], kept[:, JOINT_CODES["LHip"]]
    kept -= ((right + left) / 2)[:, None]
    across = right - left
    turn = np.arctan2(across[:, 0], across[:, 2])[:, None]
    x, z = kept[..., 0].copy(), kept[..., 2].copy()
    kept[..., 0] = np.cos(turn) * x - np.sin(turn) * z
    kept[..., 2] = np.sin(turn) * x + np.cos(turn) * z
    chain = kept[:, [JOINT_CODES[name] for name in ("RHip", "RKnee", "RAnkle")]]
    leg = np.linalg.norm(np.diff(chain, axis=1), axis=2).sum(axis=1)
    known = leg[np.isfinite(leg)]
    kept /= np.median(known) if len(known) else np.nan
    return np.asarray(kept, np.float32)


def warped(one: Floats, two: Floats) -> float:
    """Return how far joints lie apart on the cheapest way through two `normalised` clips.

    In leg lengths, the mean over joints and frames of both; infinity where no joint is known in all
    frames of both.
    """
    known = np.isfinite(one).all(axis=(0, 2)) & np.isfinite(two).all(axis=(0, 2))
    if not known.any() or not len(one) or not len(two):
        return float("inf")
    apart = _apart(one[:, known], two[:, known])
    return _cheapest(apart) / (len(one) + len(two))


def _apart(one: Floats, two: Floats) -> NDArray[np.float64]:
    """Return the mean distance of joints for each pair of frames: (T, U)."""
    total: NDArray[np.float64] = np.zeros((len(one), len(two)))
    for joint in range(one.shape[1]):
        here, there = one[:, joint].astype(np.float64), two[:, joint].astype(np.float64)
        squares = np.square(here).sum(axis=1)[:, None] + np.square(there).sum(axis=1)
        squares -= 2 * here @ there.T
        total += np.sqrt(np.maximum(squares, 0, out=squares), out=squares)
    total /= one.shape[1]
    return total


def _cheapest(apart: NDArray[np.float64]) -> float:
    """Return the cost of the cheapest way, in which a step forward in both counts twice."""
    first, *rows = apart
    cost = np.cumsum(first)
    cost += first[0]
    for row in rows:
        reach = np.cumsum(row)
        arrived = cost + row
        arrived[1:] = np.minimum(arrived[1:], cost[:-1] + 2 * row[1:])
        # A way along the row adds up what it passes: a running minimum of what is left without.
        cost = np.minimum.accumulate(arrived - reach) + reach
    return float(cost[-1])
