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

from lanindex.search import compiled
from lanindex.search.example.moves import Clips, Floats, Moves, Numbers, Windows

REPLACED = 0.8
"""What a replaced movement costs, for each of how far apart both ends are."""

PACE = 0.05
"""What it costs if one takes e times as long as the other."""

POSE = 0.5
"""What it costs for how far apart the parts are before they first move."""

CALM = 1.0
"""What is added to the sizes, about one large movement."""

SQUARE = 1 << 20
"""Pairs of movements that are laid upon each other in one go; of longer parts, piece by piece."""

_CELLS = 1 << 15
"""Cells of a row of the alignment that are worked on at a time: what a processor keeps near."""


def likeness(apart: Floats, whole: Floats) -> Floats:
    """Return how alike clips are, 0 to 1, from what they do not share and their sizes."""
    alike: Floats = np.clip(1 - apart / (whole + np.float32(CALM)), 0, 1)
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
    return paired(query, query.whole().some(np.zeros(len(windows), np.int64)), clips, windows)


def paired(one: Clips, ours: Windows, two: Clips, theirs: Windows) -> Floats:
    """Return how alike stretches of clips are to others, pair by pair: (B,) float32, 0 to 1."""
    apart = differences(one.moves, ours, two.moves, theirs).sum(axis=0)
    whole = sizes(one.moves, ours).sum(axis=0) + sizes(two.moves, theirs).sum(axis=0)
    return likeness(apart, whole)


def sizes(moves: Moves, windows: Windows) -> Floats:
    """Return what it costs to leave out each part of each stretch: (P, B) float32."""
    reach = np.concatenate([[0], np.cumsum(moves.sizes, dtype=np.float64)])
    there = windows.low < windows.high
    begun = np.append(moves.swings, np.float32(0))[windows.low]
    inside = reach[windows.high] - reach[np.minimum(windows.low + 1, windows.high)]
    return np.asarray(np.where(there, inside + begun, 0), np.float32)


def differences(one: Moves, ours: Windows, two: Moves, theirs: Windows) -> Floats:
    """Return what stretches of clips do not share, pair by pair: (P, B) float32, by part."""
    found = sizes(one, ours) + sizes(two, theirs)
    mine, others = ours.high - ours.low, theirs.high - theirs.low
    both = (mine > 0) & (others > 0)
    found[both] += _begun(one, ours.low[both], two, theirs.low[both])
    # where one side never moves, all that the other does is left out, and there is no choice
    both &= (mine > 1) & (others > 1)
    for lane in np.argwhere(mine * others * both > SQUARE):
        both[tuple(lane)] = False
        found[tuple(lane)] = _by_pieces(one, _cell(ours, lane), two, _cell(theirs, lane))
    fast = compiled.chosen("example", int((mine * others)[both].sum()))
    if fast:
        own = (one.points, one.sizes, one.paces, one.swings, ours.low[both], ours.high[both])
        other = (two.points, two.sizes, two.paces, two.swings, theirs.low[both], theirs.high[both])
        values = np.empty(np.count_nonzero(both), np.float32)
        fast.differences(*own, *other, values)
        found[both] = values
        return found
    for parts, stretches in _lanes(np.where(both, mine, 0), others):
        lanes = _Lanes(one, two, ours.low[parts, stretches], theirs.low[parts, stretches])
        counts = others[parts, stretches] - 1
        found[parts, stretches] = lanes.walked(mine[parts, stretches], counts)
    return found


def _cell(windows: Windows, lane: Numbers) -> Windows:
    """Return one part of one stretch."""
    part, stretch = lane
    return Windows(windows.low[part, stretch, None, None], windows.high[part, stretch, None, None])


def _by_pieces(one: Moves, ours: Windows, two: Moves, theirs: Windows) -> float:
    """Return what two long parts do not share, if each piece is compared with the one opposite.

    So the work grows with their length and not with its square. It is no less than what the
    cheapest way of all would find.
    """
    size = float((ours.high - ours.low).item()) * float((theirs.high - theirs.low).item())
    count = int(np.ceil(np.sqrt(size / SQUARE))) + 1
    mine, others = _pieces(ours, count), _pieces(theirs, count)
    return float(differences(one, mine, two, others).sum())


def _pieces(windows: Windows, count: int) -> Windows:
    """Return so many pieces of a part; each begins where the one before it came to."""
    ends = np.linspace(windows.low.item(), windows.high.item() - 1, count + 1).astype(np.int64)
    return Windows(ends[None, :-1], ends[None, 1:] + 1)


def _begun(one: Moves, ours: Numbers, two: Moves, theirs: Numbers) -> Floats:
    """Return what it costs more to lay beginnings upon each other than to leave both out."""
    own, other = one.swings[ours], two.swings[theirs]
    away = one.points[ours] - two.points[theirs]
    more: Floats = np.float32(POSE) * np.sqrt(np.square(away).sum(axis=1))
    more += np.abs(own - other) - own - other
    return more


def _lanes(mine: Numbers, others: Numbers) -> Iterator[tuple[Numbers, Numbers]]:
    """Yield parts and stretches to work on together: of about one length, little is padded.

    About is four times: finer, there are so many small arrays that calling costs more than padding.
    Those with most rows of the one side go first; where one side has none there is no work.
    """
    scale = 2 * np.ceil(np.log2(np.maximum(others, 1)) / 2).astype(np.int64)
    parts, stretches = np.nonzero((others > 0) & (mine > 0))
    scales = scale[parts, stretches]
    order = np.lexsort((-mine[parts, stretches], scales))
    borders = np.flatnonzero(np.diff(scales[order])) + 1
    for alike in np.split(order, borders):
        if len(alike):
            most = max(1, _CELLS >> int(scales[alike[0]]))
            for first in range(0, len(alike), most):
                lanes = alike[first : first + most]
                yield parts[lanes], stretches[lanes]


class _Lanes:
    """Alignments that go side by side: one a lane, each of one part of one pair.

    Parameters
    ----------
    one, two : Moves
        Both sides' rows.
    mine, low : ndarray
        (L,) where each lane begins in these.
    """

    def __init__(self, one: Moves, two: Moves, mine: Numbers, low: Numbers) -> None:
        self.one, self.two, self.mine, self.low = one, two, mine, low

    def walked(self, rows: Numbers, counts: Numbers) -> Floats:
        """Return differences: row by row of one side, all lanes at once.

        Parameters
        ----------
        rows : ndarray
            (L,) rows of the one side, its beginning counted; the most first.
        counts : ndarray
            (L,) movements of the other.
        """
        index = self.low + np.minimum(np.arange(counts.max() + 1)[:, None], counts)
        self.points = np.moveaxis(self.two.points[index], -1, 0).copy()
        self.paces, self.swings = self.two.paces[index], self.two.swings[index]
        gaps = self.two.sizes[index]
        gaps[0] = 0
        self.reach = np.cumsum(gaps, axis=0)
        lanes = np.arange(len(counts))
        found = np.zeros(len(counts), np.float32)
        cost = before = self.reach
        for row in range(int(rows[0])):
            alive = int(np.searchsorted(-rows, -row))
            cost, before = self._row(row, alive, cost[:, :alive], before[:, :alive])
            found[:alive] = cost[counts[:alive], lanes[:alive]]
        return found

    def _row(self, row: int, alive: int, cost: Floats, before: Floats) -> tuple[Floats, Floats]:
        """Return the costs of one more row of the one side, and how far it is from each row."""
        own, one = self.mine[:alive] + row, self.one
        here = _apart(self.points[:, :, :alive], one.points[own])
        swings = np.abs(self.swings[:, :alive] - one.swings[own])
        reach = self.reach[:, :alive]
        if row == 0:
            return reach + np.float32(POSE) * here[0] + swings[0], here
        change = here[1:] + before[:-1]
        change *= np.float32(REPLACED)
        change += np.float32(PACE) * np.abs(self.paces[1:, :alive] - one.paces[own])
        change += swings[1:]
        change += cost[:-1]
        best = cost + one.sizes[own]
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
