"""The best of a search by example in the order in which their bodies move alike.

By dynamic time warping of joint positions: the plain way to compare movement, and a hundred times
dearer than symbols. Each frame of one clip is laid upon a frame of the other, in order, so that
joints lie near each other.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from lanindex import formats
from lanindex.alphabet import JOINT_CODES
from lanindex.errors import LanindexError, UsageError, shown
from lanindex.library.encoding import Encoding
from lanindex.library.store import Store
from lanindex.model import Reading, Span
from lanindex.notation import notation_of
from lanindex.pipeline.example import Alike
from lanindex.pipeline.patience import Patience, silent
from lanindex.pipeline.prepare import as_ingested
from lanindex.search.hits import Hits

Floats = NDArray[np.float32]

MOST = 100
"""Hits of which files are read."""

RATE = 30
"""Frames a second that are compared at the most."""


def reranked(library: Store, found: Alike, patience: Patience | None = None) -> Alike:
    """Return what is like an example, the best hundred by how far their joints lie from its own."""
    one, hits = found.example, found.hits
    known = library.known()
    digest = one.capture.sha256 if one.capture else ""
    location = one.capture.location if one.capture else one.path
    try:
        own = _joints(location, digest, known, one.span)
    except LanindexError as error:
        place = f"--like {shown(one.named)} --rerank"
        raise UsageError(f"no joint positions: {error}", place=place) from error
    told: list[str] = []
    apart: list[float] = []
    watch, best = patience or Patience(silent, None), hits[:MOST]
    for done, hit in enumerate(best):
        watch("files", done, len(best))
        try:
            joints = _joints(hit.capture.location, hit.capture.sha256, known, hit.span)
            apart.append(warped(own, joints))
            if apart[-1] == inf:
                told.append(f"{hit.path}: no joint is known in all frames of both")
        except LanindexError as error:
            told.append(str(error))
            apart.append(inf)
    order = sorted(range(len(apart)), key=apart.__getitem__)
    moved = [*(hits[index] for index in order), *hits[MOST:]]
    return replace(found, hits=Hits(moved, hits.pattern), told=tuple(told))


def _joints(
    location: str, digest: str, known: dict[str, tuple[str, Encoding]], span: Span
) -> NDArray[np.float32]:
    """Return the joints of a stretch of a file, as every body would do it."""
    if notation_of(location):
        raise UsageError("a score has no joints", place=location, wanted="a capture")
    file = formats.opened(location)
    _, encoding = known.get(location, ("", Encoding()))
    if digest and not as_ingested(file, digest, encoding):
        raise UsageError("has changed since it was ingested", place=location)
    told = Reading(**encoding.options)
    motion = formats.read_file(file, told, formats.Wanted(body_only=True))
    body = motion.skeleton.body
    joints = np.asarray(motion.positions[max(span.start, motion.first) : span.stop])[:, body]
    joints[:, body < 0] = np.nan
    return normalised(joints, float(motion.rate))


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
