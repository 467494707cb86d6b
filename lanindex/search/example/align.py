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

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from lanindex.model.columns import ranges
from lanindex.search.example.moves import Clips, Floats, Moves, Numbers, Windows, distances, pieces

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
"""Rows of the other side that are worked on at a time: what a processor's cache holds."""


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
    asked = sizes(query.moves, query.whole())
    whole = asked + sizes(clips.moves, windows)
    saved = np.zeros_like(whole)
    for part in range(len(query.parts)):
        here = Windows(windows.low[part : part + 1], windows.high[part : part + 1])
        low, high = query.first[part]
        lanes = np.flatnonzero((here.low < here.high) & (low < high))
        ours = Windows(np.full((1, len(lanes)), low), np.full((1, len(lanes)), high))
        theirs, most = here.some(lanes), whole[part : part + 1, lanes]
        if (high - low) * (theirs.high - theirs.low).max(initial=0) > SQUARE:
            saved[part, lanes] = savings(query.moves, ours, clips.moves, theirs, most)[0]
            continue
        saved[part, lanes] = _begun(query.moves, ours.low[0], clips.moves, theirs.low[0])
        own = query.moves.some(slice(low, high))
        saved[part, lanes] += _shared(own, clips.moves, theirs.low[0], theirs.high[0], most[0])
    return likeness((whole - saved).sum(axis=0), whole.sum(axis=0))


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
    rows, counts, most = mine[both], others[both], whole[both]
    for some in _lanes(rows, counts):
        here = _flat(one, low[some], rows[some]), _flat(two, begin[some], counts[some])
        more[some] = _best(counts[some], most[some], _pair_savings(*here))
    found[both] += more
    return found


def _shared(query: Moves, clips: Moves, low: Numbers, high: Numbers, most: Floats) -> Floats:
    """Return by how much stretches differ less than if all but the beginnings were left out: (B,).

    What replacing a movement saves is worked out once for all stretches that it lies in.
    """
    found = np.zeros(len(low), np.float32)
    for some in pieces(high - low, _ROWS):
        first, last = low[some].min(), high[some].max()
        bounds, places = ranges(low[some] - first, high[some] - first)
        rows = savings_of(query, clips, slice(first, last))
        found[some] = _best(np.diff(bounds), most[some], _taken(rows, places, bounds[:-1]))
    return found


def _taken(rows: Iterable[Floats], places: Numbers, first: Numbers) -> Iterator[Floats]:
    """Yield rows of savings in these places; a beginning takes the place of none."""
    for row in rows:
        here = row.take(places)
        here[first] = -np.inf
        yield here


def savings_of(query: Moves, others: Moves, rows: slice) -> Iterator[Floats]:
    """Yield, movement by movement of one clip, what it saves in the place of each of others: (N,).

    Its beginning is left out; what is first of the others saves nothing, a negative infinity.
    """
    mine, theirs = _columns(query, slice(None)), _columns(others, rows)
    before = distances(mine[:3, :1], theirs)
    for row in range(1, len(query.rows)):
        saved, before = _saving(mine[:, row : row + 1], theirs, before)
        yield saved


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
    """Return what laying beginnings upon each other saves; less than 0 where they are far apart."""
    away = one.points[ours] - two.points[theirs]
    saved: Floats = 2 * np.minimum(one.swings[ours], two.swings[theirs])
    saved -= np.float32(POSE) * np.sqrt(np.square(away).sum(axis=1))
    return saved


def _lanes(rows: Numbers, counts: Numbers) -> Iterator[Numbers]:
    """Yield which pairs to work on together: those with most rows of the one side first."""
    order = np.argsort(-rows, kind="stable")
    for some in pieces(counts[order], _ROWS):
        yield order[some]


class _Flat(NamedTuple):
    """Movements of one side of pairs, those of each pair, a lane, behind those of the one before.

    Attributes
    ----------
    first, counts : ndarray
        (L,) where each lane begins, and how many rows it has, its beginning counted.
    columns : ndarray
        (6, N) float32, as `_columns` makes them.
    """

    first: Numbers
    counts: Numbers
    columns: Floats


def _flat(moves: Moves, low: Numbers, counts: Numbers) -> _Flat:
    """Return so many rows from `low` on of each lane."""
    bounds, rows = ranges(low, low + counts)
    return _Flat(bounds[:-1], counts, _columns(moves, rows))


def _columns(moves: Moves, rows: slice | Numbers) -> Floats:
    """Return what is worked with of some movements, (6, N).

    The three coordinates where each leads to, times `REPLACED`; what it costs, less half of what
    follows; twice what its pace and its swings cost. So what two differ in is what both cost, less
    the smaller of each.
    """
    points = moves.points[rows]
    columns = np.empty((6, len(points)), np.float32)
    columns[:3] = points.T
    columns[:3] *= np.float32(REPLACED)
    columns[4], columns[5] = np.float32(PACE) * moves.paces[rows], moves.swings[rows]
    columns[3] = moves.sizes[rows] - columns[4] - columns[5]
    columns[4:] *= 2
    return columns


def _pair_savings(one: _Flat, two: _Flat) -> Iterator[Floats]:
    """Yield, row by row of the one side, what it saves in the places of the other: (N,).

    One side has fewer and fewer rows, lane by lane; N is as far as there are any.
    """
    own, ends = np.repeat(one.first, two.counts), two.first + two.counts
    two.columns[3, two.first] = -np.inf  # a beginning takes the place of none
    before = distances(one.columns[:3].take(own, axis=1), two.columns)
    for row in range(1, int(one.counts[0])):
        end = ends[np.searchsorted(-one.counts, -row) - 1]
        mine = one.columns.take(own[:end] + row, axis=1)
        saved, before = _saving(mine, two.columns[:, :end], before[:end])
        yield saved


def _saving(mine: Floats, other: Floats, before: Floats) -> tuple[Floats, Floats]:
    """Return what movements save that replace others, (N,), and how far they lie from them.

    `before` is how far those before them lie from the others; the first of all saves nothing.
    """
    here = distances(mine, other)
    saved = np.minimum(mine[4], other[4])
    saved += np.minimum(mine[5], other[5])
    saved += mine[3]
    saved += other[3]
    saved[1:] -= here[1:] + before[:-1]
    saved[0] = -np.inf
    return saved, here


def _best(counts: Numbers, most: Floats, savings: Iterable[Floats]) -> Floats:
    """Return the most that each lane saves: row by row of the one side, all lanes at once.

    Parameters
    ----------
    counts : ndarray
        (L,) how many rows each lane has of the other side.
    most : ndarray
        (L,) no lane can save more. So what is saved before a place is a running maximum along all
        of them, if each begins to count that much higher, and a little, than the one before it.
    savings : iterable of ndarray
        By row of the one side, what it saves in each place of the other: (N,), fewer and fewer.
    """
    begun = np.cumsum(most + 1.0, dtype=np.float64) - most
    best = np.repeat(begun, counts)
    bits = best.view(np.int64)  # numbers above 0 are in order as integers are, which is faster
    for saved in savings:
        end = len(saved)
        np.maximum(best[1:end], best[: end - 1] + saved[1:], out=best[1:end])
        np.maximum.accumulate(bits[:end], out=bits[:end])
    return np.asarray(best[np.cumsum(counts) - 1] - begun, np.float32)


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
