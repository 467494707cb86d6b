"""The clips that are most like one: whole or, where they are much longer, their best stretch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.search.example.align import compared
from lanindex.search.example.candidates import Promise, promises
from lanindex.search.example.moves import Clips, Floats, Numbers

LONGER = 2.0
"""From how many times the length of the example on a clip is looked through by stretches, too."""

MOST = 4096
"""Clips that are aligned at the most."""

_BLOCK = 256
"""Clips that are aligned at a time."""

_STEPS = 4
"""Beginnings of stretches in the length of the example."""

_BEGINNINGS = 2000
"""Beginnings of stretches in one clip, at the most."""

_FINALISTS = 4
"""Stretches of one clip whose edges are moved about."""

_LENGTHS = (0.7, 1.0, 1.4)
"""Lengths of stretches, as parts of the example's."""


class Near(NamedTuple):
    """A clip that is like the example, or a stretch of it.

    Attributes
    ----------
    clip : int
        Which.
    begin, end : int
        Frames of its source, half-open.
    likeness : float
        0 to 1.
    """

    clip: int
    begin: int
    end: int
    likeness: float


class Found(NamedTuple):
    """What is like an example.

    Attributes
    ----------
    near : list of Near
        The best first.
    aligned : int
        How many clips were aligned.
    sure : bool
        Whether no whole clip that was not aligned could be among them.
    """

    near: list[Near]
    aligned: int
    sure: bool


def nearest(
    query: Clips,
    seconds: float,
    clips: Clips,
    frames: Sequence[int],
    rates: Sequence[float],
    limit: int,
    *,
    most: int = MOST,
) -> Found:
    """Return the clips that are most like one.

    Parameters
    ----------
    query : Clips
        The one, with the same parts as `clips`.
    seconds : float
        How long it lasts.
    clips : Clips
        To choose from.
    frames, rates : sequence
        Of each clip: its length in frames, and frames a second.
    limit : int
        How many are wanted.
    most : int
        How many are aligned at the most.
    """
    promise = promises(query, clips)
    lasting, rate = np.array(frames, np.int64), np.array(rates, np.float64)
    longer = lasting >= LONGER * seconds * rate
    hope = np.where(longer, np.maximum(promise.whole, promise.stretch), promise.whole)
    order = np.argsort(-hope, kind="stable")
    near: list[Near] = []
    done = 0
    while done < min(most, len(order)):
        if len(near) == limit and hope[order[done]] <= near[-1].likeness:
            break
        block = order[done : done + _BLOCK]
        whole = compared(query, clips, clips.whole().some(block))
        near += map(Near, block.tolist(), [0] * len(block), lasting[block].tolist(), whole.tolist())
        near = sorted(near, key=_rank)
        worst = near[limit - 1].likeness if len(near) >= limit else 0.0
        for clip in block[longer[block] & (promise.stretch[block] > worst)]:
            length = seconds * rate[clip]
            near.append(_stretch(query, clips, promise, int(clip), int(lasting[clip]), length))
        near = _best(near, limit)
        done += len(block)
    sure = done >= len(order) or (len(near) == limit and hope[order[done]] <= near[-1].likeness)
    return Found(near, done, sure)


def _best(near: list[Near], limit: int) -> list[Near]:
    """Return the best, each clip once."""
    kept: dict[int, Near] = {}
    for one in sorted(near, key=_rank):
        kept.setdefault(one.clip, one)
    return [one for one in kept.values() if one.likeness > 0][:limit]


def _rank(near: Near) -> tuple[float, int, int]:
    return -near.likeness, near.begin - near.end, near.clip


def _stretch(
    query: Clips, clips: Clips, promise: Promise, clip: int, frames: int, length: float
) -> Near:
    """Return the stretch of a clip that is most like the example."""
    step = max(length / _STEPS, frames / _BEGINNINGS)
    begins = np.arange(0, max(frames - length / 2, 1), step)
    low, high, likeness = _tried(query, clips, promise, clip, begins, begins + length, 16)
    finals = np.argsort(-likeness, kind="stable")[:_FINALISTS]
    middles = (low[finals] + high[finals]) / 2
    shifts = np.array([-step / 3, 0, step / 3])
    middle = (middles[:, None, None] + shifts[:, None] + 0 * np.array(_LENGTHS)).ravel()
    half = np.broadcast_to(length * np.array(_LENGTHS) / 2, (len(finals), 3, 3)).ravel()
    fine = _tried(query, clips, promise, clip, middle - half, middle + half, len(middle))
    low, high = np.concatenate([low, fine[0]]), np.concatenate([high, fine[1]])
    likeness = np.concatenate([likeness, fine[2]])
    best = int(np.argmax(likeness))
    return Near(clip, max(0, int(low[best])), min(frames, int(high[best])), float(likeness[best]))


def _tried(
    query: Clips,
    clips: Clips,
    promise: Promise,
    clip: int,
    begins: NDArray[np.float64],
    ends: NDArray[np.float64],
    most: int,
) -> tuple[Numbers, Numbers, Floats]:
    """Return the most promising of some stretches, and how alike they are."""
    low, high = np.round(begins).astype(np.int64), np.round(ends).astype(np.int64)
    own = query.moves.sizes.sum()
    windows = clips.windows(clip, low, high)
    share, sizes = np.zeros(len(low)), np.full(len(low), own)
    for part, (first, last) in enumerate(clips.first[:, clip : clip + 2]):
        reach = np.cumsum(np.concatenate([[0], promise.share[first:last]]))
        share += reach[windows.high[part] - first] - reach[windows.low[part] - first]
        reach = np.cumsum(np.concatenate([[0], clips.moves.sizes[first:last]]))
        sizes += reach[windows.high[part] - first] - reach[windows.low[part] - first]
    order = np.argsort(-(share / (sizes + 1)), kind="stable")[:most]
    return low[order], high[order], compared(query, clips, windows.some(order))
