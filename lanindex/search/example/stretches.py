"""The stretch of a long clip that is most like an example.

Stretches of about the example's length begin everywhere in the clip. What each may have in common
with it is told by running sums; the most promising are aligned, those of all clips together; then
the edges of the best are moved about, and the most promising of these aligned.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import ranges
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
    chosen: Numbers,
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
    chosen : ndarray
        Which clips, in order.
    frames, lengths : ndarray
        (C,) of each clip its length, and the example's at its rate.
    worst : float
        A likeness; what cannot be above it is left out.
    """
    step = lengths / STEPS
    each = np.maximum(step, frames / BEGINNINGS)
    counts = np.ceil(np.maximum(frames - lengths / 2, 1) / each).astype(np.int64)[chosen]
    _, place = ranges(np.zeros_like(counts), counts)
    owner = np.repeat(chosen, counts)
    begins = np.asarray(place * each[owner], np.float64)
    first = _tried(query, clips, reach, owner, begins, begins + lengths[owner], worst)
    finals = first.best(_FINALISTS)
    middles = (finals.begins + finals.ends)[:, None] / 2
    middles = middles + step[finals.clips, None] * np.arange(-1, 2) / 3
    middle = np.repeat(middles.ravel(), len(_LENGTHS))
    owner = np.repeat(finals.clips, middles.shape[1] * len(_LENGTHS))
    half = lengths[owner] * np.tile(_LENGTHS, middles.size) / 2
    again = _tried(query, clips, reach, owner, middle - half, middle + half, worst)
    every = first.beside(again).best(1)
    begins, ends = np.maximum(every.begins, 0), np.minimum(every.ends, frames[every.clips])
    told = zip(every.clips, begins, ends, every.likeness, strict=True)
    return [Stretch(int(c), int(b), int(e), float(alike)) for c, b, e, alike in told]


class _Tried(NamedTuple):
    """Stretches that were aligned: whose, from which frame to which, how alike; (K,) each."""

    clips: Numbers
    begins: Numbers
    ends: Numbers
    likeness: Floats

    def best(self, most: int) -> _Tried:
        """Return the best of each clip, so many at the most."""
        kept = _first(self.clips, -self.likeness, most)
        clips, begins, ends, likeness = self
        return _Tried(clips[kept], begins[kept], ends[kept], likeness[kept])

    def beside(self, other: _Tried) -> _Tried:
        """Return these, and others behind them."""
        return _Tried(
            np.append(self.clips, other.clips),
            np.append(self.begins, other.begins),
            np.append(self.ends, other.ends),
            np.append(self.likeness, other.likeness),
        )


def _tried(
    query: Clips,
    clips: Clips,
    reach: Reach,
    owner: Numbers,
    begins: NDArray[np.float64],
    ends: NDArray[np.float64],
    worst: float,
) -> _Tried:
    """Return the most promising stretches of each clip, and how alike they are."""
    low, high = np.round(begins).astype(np.int64), np.round(ends).astype(np.int64)
    windows = clips.windows(owner, low, high)
    most = reach.most(windows)
    kept = _first(owner, -most, _TRIED)
    kept = kept[most[kept] > worst]
    likeness = compared(query, clips, windows.some(kept))
    return _Tried(owner[kept], low[kept], high[kept], likeness)


def _first(owner: Numbers, value: NDArray[Any], most: int) -> Numbers:
    """Return which have the least values of their owner's, so many of each, in that order."""
    order = np.lexsort((value, owner))
    fresh = np.flatnonzero(np.diff(owner[order], prepend=-1))
    sizes = np.diff(fresh, append=len(order))
    kept: Numbers = order[np.arange(len(order)) - np.repeat(fresh, sizes) < most]
    return kept
