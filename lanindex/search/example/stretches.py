"""The stretch of a long clip that is most like an example.

Stretches of about the example's length begin everywhere in the clip. What each may have in common
with it is told by running sums; the most promising are aligned, those of all clips together; then
the edges of the best are moved about, and the most promising of these aligned.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.search.example.align import CALM, compared
from lanindex.search.example.candidates import Promise
from lanindex.search.example.moves import Clips, Floats, Numbers, Windows

STEPS = 4
"""Beginnings of stretches in the length of the example."""

BEGINNINGS = 2000
"""Beginnings of stretches in one clip, at the most."""

_TRIED = 12
"""Stretches of a clip that are aligned at a time."""

_FINALISTS = 3
"""Stretches of a clip whose edges are moved about."""

_LENGTHS = np.array([0.7, 1.0, 1.4])
"""Lengths of stretches, as parts of the example's."""


class Stretch(NamedTuple):
    """A stretch of a clip: frames of its source, half-open, and how like the example it is."""

    clip: int
    begin: int
    end: int
    likeness: float


class Reach(NamedTuple):
    """Running sums over the rows of clips.

    Attributes
    ----------
    sizes, share : ndarray
        (N + 1,) float64, of the rows' sizes, and of what they may have in common at most.
    asked, begun : float
        The size of the example, and what its beginning may have in common at most.
    """

    sizes: NDArray[np.float64]
    share: NDArray[np.float64]
    asked: float
    begun: float

    def most(self, windows: Windows) -> NDArray[np.float64]:
        """Return how alike stretches may be at the most."""
        inside = np.minimum(windows.low + 1, windows.high)
        whole = self.asked + (self.sizes[windows.high] - self.sizes[inside]).sum(axis=0)
        common = (self.share[windows.high] - self.share[inside]).sum(axis=0)
        most: NDArray[np.float64] = (common + self.begun + CALM) / (whole + CALM)
        return most


def reach_of(query: Clips, clips: Clips, promise: Promise) -> Reach:
    """Return the running sums of clips."""
    sizes, share = (
        np.concatenate([[0.0], np.cumsum(values, dtype=np.float64)])
        for values in (clips.moves.sizes, promise.share)
    )
    begins = query.first[:, 0][query.first[:, 0] < query.first[:, 1]]
    begun = 2 * float(query.moves.swings[begins].sum())
    return Reach(sizes, share, float(query.moves.sizes.sum()), begun)


def stretches(
    query: Clips,
    clips: Clips,
    reach: Reach,
    chosen: Sequence[int],
    frames: NDArray[np.int64],
    lengths: NDArray[np.float64],
    worst: float,
) -> list[Stretch]:
    """Return the best stretch of each of some clips, if it may be better than the worst wanted.

    Parameters
    ----------
    query, clips : Clips
        The example, and all clips.
    reach : Reach
        Of these.
    chosen : sequence of int
        Which clips.
    frames, lengths : ndarray
        (C,) of each clip its length, and the example's at its rate.
    worst : float
        A likeness; what cannot be above it is left out.
    """
    tries = []
    for clip in chosen:
        step = max(lengths[clip] / STEPS, frames[clip] / BEGINNINGS)
        begins = np.arange(0, max(frames[clip] - lengths[clip] / 2, 1), step)
        tries.append((clip, begins, begins + lengths[clip]))
    first = _tried(query, clips, reach, tries, worst)
    tries = []
    for clip, begins, ends, likeness in first:
        finals = np.argsort(-likeness, kind="stable")[:_FINALISTS]
        step = lengths[clip] / STEPS
        middles = ((begins[finals] + ends[finals]) / 2)[:, None] + step * np.arange(-1, 2) / 3
        middle = np.repeat(middles.ravel(), len(_LENGTHS))
        half = np.tile(lengths[clip] * _LENGTHS / 2, middles.size)
        tries.append((clip, middle - half, middle + half))
    found: dict[int, Stretch] = {}
    for clip, begins, ends, likeness in [*first, *_tried(query, clips, reach, tries, worst)]:
        best = int(np.argmax(likeness))
        if clip not in found or likeness[best] > found[clip].likeness:
            begin, end = max(0, int(begins[best])), min(int(frames[clip]), int(ends[best]))
            found[clip] = Stretch(clip, begin, end, float(likeness[best]))
    return list(found.values())


_Try = tuple[int, NDArray[np.float64], NDArray[np.float64]]


def _tried(
    query: Clips, clips: Clips, reach: Reach, tries: Sequence[_Try], worst: float
) -> list[tuple[int, Numbers, Numbers, Floats]]:
    """Return the most promising stretches of each clip, and how alike they are."""
    kept = []
    windows = []
    for clip, begins, ends in tries:
        low, high = np.round(begins).astype(np.int64), np.round(ends).astype(np.int64)
        here = clips.windows(clip, low, high)
        most = reach.most(here)
        order = np.argsort(-most, kind="stable")[:_TRIED]
        order = order[most[order] > worst]
        if len(order):
            windows.append(here.some(order))
            kept.append((clip, low[order], high[order]))
    if not kept:
        return []
    together = Windows(
        np.concatenate([one.low for one in windows], axis=1),
        np.concatenate([one.high for one in windows], axis=1),
    )
    likeness = compared(query, clips, together)
    borders = np.cumsum([len(one) for one in windows])[:-1]
    return [(*one, alike) for one, alike in zip(kept, np.split(likeness, borders), strict=True)]
