"""How much of their movement two clips do not share: an alignment of symbols, part by part.

To turn the movements of one clip into those of another, a movement may be left out or put in,
which costs its size (how far it goes, its swings, and a little for being one), or be replaced,
which costs how far apart the two begin and end, how their lengths differ in proportion, and their
swings. The cheapest way is the *difference* of the two; leaving out all of both would cost their
*sizes*. What moves far counts much, what stands still counts nothing, without any weights.

    likeness = 1 - (sum of differences) / (sum of sizes + 1)

is 1 for equal clips and 0 for those that share nothing; the 1 keeps two clips that hardly move from
being told apart by their trembling. It is the same from either side and in the mirror.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from lanindex.search.example.moves import Clips, Floats, Moves, Numbers, Windows

REPLACED = 0.8
"""What a replaced movement costs, for each of how far apart both ends are."""

PACE = 0.05
"""What it costs if one takes e times as long as the other."""

POSE = 0.5
"""What it costs for how far apart the parts are before they first move."""

CALM = 1.0
"""What is added to the sizes, about one large movement."""

_CELLS = 1 << 15
"""Cells of a row of the alignment that are worked on at a time: what a processor keeps near."""


def likeness(differences: Floats, sizes: Floats) -> Floats:
    """Return how alike clips are, 0 to 1, from what they do not share and their sizes in all."""
    alike: Floats = np.clip(1 - differences / (sizes + np.float32(CALM)), 0, 1)
    return alike


def compared(query: Clips, clips: Clips, windows: Windows) -> Floats:
    """Return how alike one clip is to each of many stretches of clips.

    Parameters
    ----------
    query : Clips
        One clip, with the same parts.
    clips : Clips
        Many.
    windows : Windows
        B stretches of these.

    Returns
    -------
    ndarray
        (B,) float32, 0 to 1. What only one of both has, a part too, is not shared.
    """
    differences, sizes = aligned(query, clips, windows)
    return likeness(differences.sum(axis=0), sizes.sum(axis=0) + query.moves.sizes.sum())


def aligned(query: Clips, clips: Clips, windows: Windows) -> tuple[Floats, Floats]:
    """Return the differences of one clip and stretches of others, and the sizes of these.

    Returns
    -------
    differences, sizes : ndarray
        (P, B) float32 each, by part; the sizes are those of the stretches alone.
    """
    own = np.array(
        [query.moves.sizes[low:high].sum() for low, high in query.first], np.float32
    ).reshape(-1, 1)
    differences = np.broadcast_to(own, windows.low.shape).copy()
    sizes = np.zeros(windows.low.shape, np.float32)
    moving = np.diff(query.first, axis=1)[:, 0]
    for parts, stretches in _lanes(moving, windows):
        lanes = _Lanes(query, clips, parts, windows.low[parts, stretches])
        counts = windows.high[parts, stretches] - windows.low[parts, stretches] - 1
        differences[parts, stretches], sizes[parts, stretches] = lanes.walked(counts)
    return differences, sizes


def _lanes(moving: Numbers, windows: Windows) -> Iterator[tuple[Numbers, Numbers]]:
    """Yield parts and stretches to work on together: of about one length, little is padded.

    Those of whose part the query has most rows go first; a part that a clip lacks is left out.
    """
    counts = windows.high - windows.low
    scale = np.ceil(np.log2(np.maximum(counts, 1))).astype(np.int64)
    parts, stretches = np.nonzero(counts)
    scales = scale[parts, stretches]
    order = np.lexsort((-moving[parts], scales))
    borders = np.flatnonzero(np.diff(scales[order])) + 1
    for alike in np.split(order, borders):
        if len(alike):
            most = max(1, _CELLS // int(2 ** scales[alike[0]]))
            for first in range(0, len(alike), most):
                lanes = alike[first : first + most]
                yield parts[lanes], stretches[lanes]


class _Lanes:
    """Alignments that go side by side: one a lane, each of one part, all of about one length."""

    def __init__(self, query: Clips, clips: Clips, parts: Numbers, low: Numbers) -> None:
        self.query, self.clips, self.low = query.moves, clips.moves, low
        self.rows = query.first[parts, 0]
        self.count = query.first[parts, 1] - self.rows

    def walked(self, counts: Numbers) -> tuple[Floats, Floats]:
        """Return differences and sizes: row by row of the query, all lanes at once."""
        places = np.minimum(np.arange(counts.max() + 1)[:, None], counts)
        index = self.low + places
        self.points = np.moveaxis(self.clips.points[index], -1, 0).copy()
        self.paces, self.swings = self.clips.paces[index], self.clips.swings[index]
        gaps = self.clips.sizes[index]
        gaps[0] = self.swings[0]
        self.reach = np.cumsum(gaps, axis=0)
        lanes = np.arange(len(counts))
        sizes = self.reach[counts, lanes]
        cost, before = self.reach, self.reach  # of a part that the query lacks all is put in
        differences = sizes.copy()
        for row in range(int(self.count.max(initial=0))):
            alive = int(np.searchsorted(-self.count, -row))  # the longest go first
            cost, before = self._row(row, alive, cost[:, :alive], before[:, :alive])
            differences[:alive] = cost[counts[:alive], lanes[:alive]]
        return differences, sizes

    def _row(self, row: int, alive: int, cost: Floats, before: Floats) -> tuple[Floats, Floats]:
        """Return the costs of one more row of the query, and how far it is from each row."""
        own, query = self.rows[:alive] + row, self.query
        here = _apart(self.points[:, :, :alive], query.points[own])
        swings = np.abs(self.swings[:, :alive] - query.swings[own])
        reach = self.reach[:, :alive]
        if row == 0:
            begin = np.float32(POSE) * here[0] + swings[0] - self.swings[0, :alive]
            return reach + begin, here
        change = here[1:] + before[:-1]
        change *= np.float32(REPLACED)
        change += np.float32(PACE) * np.abs(self.paces[1:, :alive] - query.paces[own])
        change += swings[1:]
        change += cost[:-1]
        best = cost + query.sizes[own]
        np.minimum(best[1:], change, out=best[1:])
        # What is put in adds up along the clip: a running minimum of what is left without it.
        best -= reach
        np.minimum.accumulate(best, axis=0, out=best)
        best += reach
        return best, here


def _apart(points: Floats, own: Floats) -> Floats:
    """Return how far points lie from one point a lane: (3, M, L) and (L, 3) to (M, L)."""
    total: Floats = np.square(points[0] - own[:, 0])
    total += np.square(points[1] - own[:, 1])
    total += np.square(points[2] - own[:, 2])
    np.sqrt(total, out=total)
    return total


class Pair(NamedTuple):
    """Two movements that correspond.

    Attributes
    ----------
    own, row : int
        Rows of both clips.
    saving : float
        What is saved by replacing one by the other.
    """

    own: int
    row: int
    saving: float


def pairs(query: Clips, clip: Clips, part: int) -> list[Pair]:
    """Return which movements of two clips correspond, by the cheapest alignment of one part.

    Parameters
    ----------
    query, clip : Clips
        Of one clip each, with the same parts.
    part : int
        Which of these.

    Returns
    -------
    list of Pair
        By time, without those that save nothing.
    """
    (own, end), (row, last) = query.first[part], clip.first[part]
    one, two = query.moves.some(slice(own, end)), clip.moves.some(slice(row, last))
    if not len(one.rows) or not len(two.rows):
        return []
    savings = one.sizes[:, None] + two.sizes - changes(one, two)
    savings[0], savings[:, 0] = 0, 0
    best = np.zeros((len(one.rows), len(two.rows)), np.float32)
    for index in range(1, len(best)):
        best[index, 1:] = np.maximum(best[index - 1, 1:], best[index - 1, :-1] + savings[index, 1:])
        np.maximum.accumulate(best[index], out=best[index])
    found: list[Pair] = []
    index, place = len(one.rows) - 1, len(two.rows) - 1
    while index and place:
        here = best[index, place]
        if here == best[index - 1, place]:
            index -= 1
        elif here == best[index, place - 1]:
            place -= 1
        else:
            saving = float(savings[index, place])
            found.append(Pair(int(own) + index, int(row) + place, saving))
            index, place = index - 1, place - 1
    return found[::-1]


def changes(query: Moves, other: Moves) -> Floats:
    """Return what it costs to replace each row by each: (N, M) float32, at 0 0 the beginnings."""
    away = query.points[:, None] - other.points
    apart = np.sqrt(np.square(away).sum(axis=2))
    swings = np.abs(query.swings[:, None] - other.swings)
    change: Floats = swings + np.float32(PACE) * np.abs(query.paces[:, None] - other.paces)
    change[1:, 1:] += np.float32(REPLACED) * (apart[1:, 1:] + apart[:-1, :-1])
    change[:1, :1] = np.float32(POSE) * apart[:1, :1] + swings[:1, :1]
    return change
