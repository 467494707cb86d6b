"""Two movements laid upon each other in time, by where the joints are (dynamic time warping)."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES
from lanindex.errors import UsageError
from lanindex.formats.animation import without_gaps
from lanindex.library.store import Store
from lanindex.model import Capture
from lanindex.pipeline.motion import motion

Floats = NDArray[np.float32]

RATE = 30
"""Frames a second that are compared at the most."""

MOST = 1500
"""Frames of a capture that are compared at the most: of more than 50 seconds, fewer a second."""

LEAST = 0.5
"""Share of frames in which a joint must be known; what is missing is filled in straight lines."""


def normalised(joints: NDArray[np.float32], rate: float) -> Floats:
    """Return joints (T, 20, 3), mm, as any body would move anywhere: (U, 20, 3) in leg lengths.

    At most `RATE` frames a second, seen from between the hips, which are turned to lie along z.
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
    known = _known(one, two)
    if not known.any() or not len(one) or not len(two):
        return float("inf")
    for cost in _costs(_mean_distances(one[:, known], two[:, known])):
        last = cost[-1]
    return float(last) / (len(one) + len(two))


def _mean_distances(one: Floats, two: Floats) -> NDArray[np.float64]:
    """Return the mean distance of joints for each pair of frames: (T, U)."""
    total: NDArray[np.float64] = np.zeros((len(one), len(two)))
    for joint in range(one.shape[1]):
        first, second = one[:, joint].astype(np.float64), two[:, joint].astype(np.float64)
        squares = np.square(first).sum(axis=1)[:, None] + np.square(second).sum(axis=1)
        squares -= 2 * first @ second.T
        total += np.sqrt(np.maximum(squares, 0, out=squares), out=squares)
    total /= one.shape[1]
    return total


def _costs(distances: NDArray[np.float64]) -> Iterator[NDArray[np.float64]]:
    """Yield the costs of the cheapest ways to each frame of one, (U,).

    A step forward in both counts twice.
    """
    first, *rows = distances
    cost = np.cumsum(first)
    cost += first[0]
    yield cost
    for row in rows:
        reach = np.cumsum(row)
        arrived = cost + row
        arrived[1:] = np.minimum(arrived[1:], cost[:-1] + 2 * row[1:])
        # A way along the row adds up what it passes: a running minimum of what is left without.
        cost = np.minimum.accumulate(arrived - reach) + reach
        yield cost


def _known(one: Floats, two: Floats) -> NDArray[np.bool_]:
    """Return which joints are known in all frames of both, (20,)."""
    both = np.isfinite(one).all(axis=(0, 2)) & np.isfinite(two).all(axis=(0, 2))
    return np.asarray(both, np.bool_)


def cheapest_way(one: Floats, two: Floats) -> NDArray[np.int64]:
    """Return the pairs of frames, (N, 2), of the cheapest way through two `normalised` clips.

    It goes from the first frames to the last ones, a frame forward in one or both at a time.
    """
    known = _known(one, two)
    distances = _mean_distances(one[:, known], two[:, known])
    costs = np.array([*_costs(distances)])
    at, to = len(one) - 1, len(two) - 1
    way = [(at, to)]
    while at or to:
        before = [(at - 1, to - 1), (at - 1, to), (at, to - 1)]
        found = [
            costs[it] + distances[at, to] * (2 if step == 0 else 1) if min(it) >= 0 else np.inf
            for step, it in enumerate(before)
        ]
        at, to = before[int(np.argmin(found))]
        way.append((at, to))
    return np.array(way[::-1])


def in_step(store: Store, *captures: Capture) -> NDArray[np.float64]:
    """Return at which seconds two captures do the same: see `lanindex.Library.in_step`."""
    joints, rates = [], []
    ends = [float(it.frames / it.rate) for it in captures]
    for capture, end in zip(captures, ends, strict=True):
        body = motion(store, capture.id, fps=min(RATE, MOST / end))
        places = body.places[:, : len(JOINT_CODES)].copy()
        seldom = np.isfinite(places).all(axis=2).mean(axis=0) < LEAST
        places[:, seldom] = np.nan
        joints.append(normalised(without_gaps(places), float(body.rate)))
        rates.append(float(body.rate))
    one, two = joints
    if not _known(one, two).any():
        paths = " and ".join(it.path for it in captures)
        raise UsageError(
            f"no joint is known well enough in {paths}", wanted="hips, a leg and one more"
        )
    way = cheapest_way(one, two)
    # where one stands still while the other moves on, it is in the middle of what the other does
    firsts = np.flatnonzero(np.diff(way[:, 0], prepend=-1))
    there = [way[start:stop, 1].mean() for start, stop in pairwise([*firsts, len(way)])]
    seconds = np.stack([np.arange(len(one)), there], axis=1) / rates
    return np.concatenate([[[0.0, 0.0]], seconds[1:-1], [ends]])
