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

_ROWS = 1 << 13
"""Rows of the other side that are worked on at a time: what a processor keeps near."""


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
    whole = sizes(one.moves, ours) + sizes(two.moves, theirs)
    saved = savings(one.moves, ours, two.moves, theirs, whole)
    return likeness((whole - saved).sum(axis=0), whole.sum(axis=0))


def sizes(moves: Moves, windows: Windows) -> Floats:
    """Return what it costs to leave out each part of each stretch: (P, B) float32."""
    counts = np.maximum(windows.high - windows.low - 1, 0).ravel()
    ends = np.cumsum(counts)
    rows = np.arange(counts.sum()) + np.repeat(windows.low.ravel() + 1 - ends + counts, counts)
    reach = np.concatenate([[0], np.cumsum(moves.sizes[rows], dtype=np.float64)])
    inside = (reach[ends] - reach[ends - counts]).reshape(windows.low.shape)
    begun = np.append(moves.swings, np.float32(0))[windows.low]
    return np.asarray(np.where(windows.low < windows.high, inside + begun, 0), np.float32)


def savings(one: Moves, ours: Windows, two: Moves, theirs: Windows, whole: Floats) -> Floats:
    """Return by how much stretches of clips differ less than if all were left out, pair by pair.

    Parameters
    ----------
    one, two : Moves
        Both sides' rows.
    ours, theirs : Windows
        B stretches of each.
    whole : ndarray
        (P, B) float32, the sizes of both together.

    Returns
    -------
    ndarray
        (P, B) float32, by part: the most that is saved by replacing movements.
    """
    mine, others = ours.high - ours.low, theirs.high - theirs.low
    both = (mine > 0) & (others > 0)
    found = np.zeros_like(whole)
    found[both] = _begun(one, ours.low[both], two, theirs.low[both])
    # where one side never moves, all that the other does is left out, and there is no choice
    both &= (mine > 1) & (others > 1)
    for lane in np.argwhere(mine * others * both > SQUARE):
        both[tuple(lane)] = False
        pieces = _by_pieces(one, _cell(ours, lane), two, _cell(theirs, lane))
        found[tuple(lane)] = whole[tuple(lane)] - pieces
    low, begin = ours.low[both], theirs.low[both]
    more = np.zeros(len(low), np.float32)
    fast = compiled.chosen("example", int((mine * others)[both].sum()))
    if fast:
        own = (one.points, one.sizes, one.paces, one.swings, low, ours.high[both])
        other = (two.points, two.sizes, two.paces, two.swings, begin, theirs.high[both])
        fast.savings(*own, *other, more)
    else:
        rows, counts, most = mine[both], others[both], whole[both]
        for some in _lanes(rows, counts):
            here = _flat(one, low[some], rows[some]), _flat(two, begin[some], counts[some])
            more[some] = _saved(*here, most[some])
    found[both] += more
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
    whole = sizes(one, mine) + sizes(two, others)
    return float((whole - savings(one, mine, two, others, whole)).sum())


def _pieces(windows: Windows, count: int) -> Windows:
    """Return so many pieces of a part; each begins where the one before it came to."""
    ends = np.linspace(windows.low.item(), windows.high.item() - 1, count + 1).astype(np.int64)
    return Windows(ends[None, :-1], ends[None, 1:] + 1)


def _begun(one: Moves, ours: Numbers, two: Moves, theirs: Numbers) -> Floats:
    """Return what is saved by laying beginnings upon each other; less than 0 where far apart."""
    away = one.points[ours] - two.points[theirs]
    saved: Floats = 2 * np.minimum(one.swings[ours], two.swings[theirs])
    saved -= np.float32(POSE) * np.sqrt(np.square(away).sum(axis=1))
    return saved


def _lanes(rows: Numbers, counts: Numbers) -> Iterator[Numbers]:
    """Yield which pairs to work on together: those with most rows of the one side first."""
    order = np.argsort(-rows, kind="stable")
    full = np.cumsum(counts[order]) // _ROWS
    yield from np.split(order, np.flatnonzero(np.diff(full)) + 1) if len(order) else ()


class _Flat(NamedTuple):
    """Movements of one side of pairs, those of each pair, a lane, behind those of the one before.

    Attributes
    ----------
    first, counts : ndarray
        (L,) where each lane begins, and how many rows it has, its beginning counted.
    columns : ndarray
        (6, N) float32: the three coordinates where each leads to, times `REPLACED`; what it costs,
        less half of what follows; twice what its pace and its swings cost. So what two differ in
        is what both cost, less the smaller of each.
    """

    first: Numbers
    counts: Numbers
    columns: Floats


def _flat(moves: Moves, low: Numbers, counts: Numbers) -> _Flat:
    """Return so many rows from `low` on of each lane."""
    first = np.cumsum(counts) - counts
    rows = np.arange(counts.sum()) + np.repeat(low - first, counts)
    columns = np.empty((6, len(rows)), np.float32)
    columns[:3] = moves.points[rows].T
    columns[:3] *= np.float32(REPLACED)
    columns[4], columns[5] = np.float32(PACE) * moves.paces[rows], moves.swings[rows]
    columns[3] = moves.sizes[rows] - columns[4] - columns[5]
    columns[4:] *= 2
    return _Flat(first, counts, columns)


def _saved(one: _Flat, two: _Flat, most: Floats) -> Floats:
    """Return the most that each lane saves: row by row of the one side, all lanes at once.

    No lane can save as much as there is between where it and the next begin to count (`most` and a
    little), so that what is saved before a place is a running maximum along all of them.
    """
    begun = np.cumsum(most + 1.0, dtype=np.float64) - most
    best = np.repeat(begun, two.counts)
    # Numbers above 0 are in order as integers are; a running maximum of these takes a fifth.
    bits = best.view(np.int64)
    own = np.repeat(one.first, two.counts)
    two.columns[3, two.first] = -np.inf  # a beginning takes the place of none
    ends = two.first + two.counts
    before = _apart(one.columns[:3].take(own, axis=1), two.columns)
    for row in range(1, int(one.counts[0])):
        end = ends[np.searchsorted(-one.counts, -row) - 1]
        mine, other = one.columns.take(own[:end] + row, axis=1), two.columns[:, :end]
        here = _apart(mine, other)
        saved = np.minimum(mine[4], other[4])
        saved += np.minimum(mine[5], other[5])
        saved += mine[3]
        saved += other[3]
        saved[1:] -= here[1:] + before[: end - 1]
        np.maximum(best[1:end], best[: end - 1] + saved[1:], out=best[1:end])
        np.maximum.accumulate(bits[:end], out=bits[:end])
        before = here
    return np.asarray(best[ends - 1] - begun, np.float32)


def _apart(one: Floats, two: Floats) -> Floats:
    """Return how far points lie apart, coordinates first."""
    total = np.square(one[0] - two[0])
    total += np.square(one[1] - two[1])
    total += np.square(one[2] - two[2])
    return np.asarray(np.sqrt(total, out=total), np.float32)


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
