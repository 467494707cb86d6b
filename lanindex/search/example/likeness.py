"""How alike clips are: the edit distance of two, the nearest neighbours of one, and groups of all.

The page of `lanindex.search` says how, under "By example".
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import CELL, PASSING, THOUSANDTHS, Columns, ranges
from lanindex.search.limits import Progress
from lanindex.search.sphere import CELLS, MIDDLES, points_of

Floats = NDArray[np.float32]
Numbers = NDArray[np.int64]
Doubles = NDArray[np.float64]

STEP = 0.25  # what a movement costs that only one clip has, beside how far it goes
SWING = 0.2  # what a swing costs: a move out and back within one cell
SUBSTITUTED = 0.8  # what a substitution costs, for each of how far apart both ends are
PACE = 0.05  # what it costs if one takes e times as long as the other
POSE = 0.5  # what it costs for how far apart the parts are before they first move
CALM = 1.0  # added to the sizes, about one large movement
BRIEFEST = 1 / 60  # seconds that a movement takes at least
SQUARE = 1 << 20  # pairs of movements aligned in one go; longer parts are aligned piece by piece
_ROWS = 1 << 13  # rows of the other side worked on at a time: what a processor's cache holds

LONGER = 4.0  # times the example's length from which on stretches of a clip are tried, too
MOST = 4096  # clips that are aligned at most
TOGETHER = 1 << 16  # clips whose columns are in memory at a time, where they come from a library
_BLOCK, _LAID_OUT = 256, 1 << 18  # clips aligned at a time, and rows of clips laid out
_LONG = 16  # rows a part of an example from which on these are fewer
LONGEST = 2048  # movements of a part of the example that are each compared with every movement
_FARTHEST = 2.0  # how far a movement can go
_STEPS, _BEGINNINGS = 4, 2000  # stretches begun in the example's length, and in a clip at most
_TRIED, _FINALISTS = 12, 3  # stretches of a clip aligned at a time, and those that are shifted
_LENGTHS = np.array([0.7, 1.0, 1.4])  # of stretches, in proportion to the example's


def unwatched(noun: str, done: int, total: int) -> None:
    """Ignore progress."""


class MoveTable(NamedTuple):
    """N movements that a score shows, in columns."""

    points: Floats  # (N, 3) where each leads to
    sizes: Floats  # (N,) what it costs to delete; of a starting position the swings alone
    paces: Floats  # (N,) the logarithm of its seconds
    swings: Floats  # (N,) what its swings cost
    starts: Numbers  # (N,) frames of the source, half-open
    stops: Numbers
    rows: Numbers  # (N,) where it stands in its track

    def at(self, rows: slice | Numbers) -> MoveTable:
        """Return some of them."""
        return MoveTable._make(column[rows] for column in self)


class Windows(NamedTuple):
    """B stretches of clips, as rows of their movements."""

    moves: MoveTable
    low: Numbers  # (P, B) by part: the row where it is before
    high: Numbers  # (P, B) the row behind the last; the same where the part is not there

    def at(self, cells: Any) -> Windows:
        """Return some of them: an index of (P, B)."""
        return Windows(self.moves, self.low[cells], self.high[cells])


@dataclass(frozen=True, slots=True)
class Clips:
    """Clips laid out: the movements of a part in all of them, then those of the next part."""

    parts: tuple[str, ...]
    moves: MoveTable
    # (P, C + 1) the row with which each clip's part begins, where it is before it first moves; two
    # equal ones in a row where a clip lacks the part
    first: Numbers

    def __len__(self) -> int:
        return int(self.first.shape[1]) - 1

    def full_windows(self) -> Windows:
        """Return the windows that hold all of each clip."""
        return Windows(self.moves, self.first[:, :-1], self.first[:, 1:])

    def windows(self, clips: Numbers, begins: Numbers, ends: Numbers) -> Windows:
        """Return stretches of clips: (B,) which, and frames, half-open; what arrives in them."""
        # the parts of all clips one after the other, so far apart that one search tells a row
        stops = self.moves.stops
        far = max(times.max(initial=0) for times in (stops, begins, ends)) + 2
        each = np.arange(len(self.parts) * len(self)).reshape(len(self.parts), -1) * far
        times = np.repeat(each.ravel(), np.diff(self.first, axis=1).ravel()) + stops
        first, last, base = self.first[:, clips], self.first[:, clips + 1], each[:, clips]
        low = np.searchsorted(times, base + np.maximum(begins, -1), "right") - 1
        low = np.maximum(low, first)
        high = np.searchsorted(times, base + np.maximum(ends, -1), "right")
        high = np.where(first < last, np.maximum(high, low + 1), low)
        return Windows(self.moves, low, high)

    def cut(self, clip: int, begin: int, end: int) -> Clips:
        """Return one stretch of one clip as a clip by itself."""
        _, low, high = self.windows(np.array([clip]), np.array([begin]), np.array([end]))
        bounds, rows = ranges(low[:, 0], high[:, 0])
        moves = self.moves.at(rows)
        begins = bounds[:-1][low[:, 0] < high[:, 0]]
        moves.sizes[begins] = moves.swings[begins]
        return Clips(self.parts, moves, np.stack([bounds[:-1], bounds[1:]], axis=1))


@dataclass(frozen=True, slots=True)
class ClipSource:
    """The captures of columns, a few of which at a time are laid out as clips."""

    columns: Mapping[str, Columns]  # by part, in order, with their swings
    places: Numbers  # (C,) of each clip in the columns
    frames: Numbers  # (C,) its length
    rates: Doubles  # (C,) frames a second

    def __len__(self) -> int:
        return len(self.places)

    @property
    def counts(self) -> Numbers:
        """How many symbols each clip has, (C,)."""
        each = [np.diff(it.bounds)[self.places] for it in self.columns.values()]
        counts: Numbers = np.sum(each, axis=0)
        return counts

    def at(self, places: Numbers) -> ClipSource:
        """Return some of the captures: (D,) which."""
        own = self.places[places], self.frames[places], self.rates[places]
        return ClipSource(self.columns, *own)

    def clips(self, places: Numbers, watch: Progress = unwatched) -> Clips:
        """Return some of the clips, laid out: (D,) which."""
        tables: list[MoveTable] = []
        counts = np.zeros((len(self.columns), len(places)), np.int64)
        for part, columns in enumerate(self.columns.values()):
            watch("parts", part, len(self.columns))
            moves, counts[part] = _moves(columns.at(self.places[places]), self.rates[places])
            tables.append(moves)
        ends = np.append(0, np.cumsum(counts))
        first = np.arange(len(tables))[:, None] * len(places) + np.arange(len(places) + 1)
        moves = MoveTable(*map(np.concatenate, zip(*tables, strict=True)))
        return Clips(tuple(self.columns), moves, ends[first])


class LargeSource:
    """The captures of a library, of which a few at a time are read: (C,) frames and rates."""

    def __init__(
        self, frames: Numbers, rates: Doubles, read: Callable[[Numbers], ClipSource]
    ) -> None:
        self.frames, self.rates, self._read = frames, rates, read
        self._places, self._held = frames[:0], ClipSource({}, frames[:0], frames[:0], rates[:0])

    def __len__(self) -> int:
        return len(self.frames)

    def at(self, places: Numbers) -> ClipSource:
        """Return some of the captures: (D,) which, rising; those read last are at hand."""
        if not np.isin(places, self._places).all():
            del self._held  # it leaves the memory first
            self._places, self._held = places, self._read(places)
        return self._held.at(np.searchsorted(self._places, places))


def _moves(columns: Columns, rates: Doubles) -> tuple[MoveTable, Numbers]:
    """Return the movements of one part in several clips, and how many each has."""
    rows = np.flatnonzero(columns.cell & PASSING == 0)  # a score does not show what is passed
    edges = np.searchsorted(rows, columns.bounds)
    counts = np.diff(edges)
    starts, stops = columns.start[rows].astype(np.int64), columns.stop[rows].astype(np.int64)
    seconds = (stops - starts) / np.repeat(rates, counts)
    paces = np.log(np.maximum(seconds, BRIEFEST)).astype(np.float32)
    swings = np.zeros(len(rows), np.float32)
    if columns.swings is not None:
        swings += np.float32(SWING) * columns.swings[rows]
    margins = (columns.margin[rows] / THOUSANDTHS).clip(max=1.0).astype(np.float32)
    points = points_of(columns.cell[rows] & CELL, columns.runner[rows], margins)
    lengths = np.zeros(len(rows), np.float32)
    lengths[1:] = distances(points[1:].T, points[:-1].T)
    moving = starts < stops
    moving[edges[:-1][counts > 0]] = False
    sizes = swings + np.where(moving, np.float32(STEP) + lengths, np.float32(0))
    places = rows - np.repeat(columns.bounds[:-1], counts)
    return MoveTable(points, sizes, paces, swings, starts, stops, places), counts


def distances(one: Floats, two: Floats) -> Floats:
    """Return how far points lie apart: (N,) from (3, N) of each side, coordinates first."""
    total = np.square(one[0] - two[0])
    total += np.square(one[1] - two[1])
    total += np.square(one[2] - two[2])
    return np.asarray(np.sqrt(total, out=total), np.float32)


def lowest(owner: Numbers, value: NDArray[Any], most: int) -> Numbers:
    """Return which have the least values of their owner's, so many of each, in that order."""
    order = np.lexsort((value, owner))
    fresh = np.flatnonzero(np.diff(owner[order], prepend=-1))
    sizes = np.diff(fresh, append=len(order))
    return order[np.arange(len(order)) - np.repeat(fresh, sizes) < most]


def pieces(counts: Numbers, most: int) -> Iterator[slice]:
    """Yield which clips to work on at a time: about `most` of their (C,) rows, one at least."""
    full = np.cumsum(counts) // most
    edges = np.flatnonzero(np.diff(full, prepend=-1, append=-1))
    yield from (slice(*pair) for pair in pairwise(edges.tolist()))


def likeness(difference: Floats, size: Floats) -> Floats:
    """Return how alike clips are, 0 to 1, from their differences and their sizes."""
    alike: Floats = np.clip(1 - difference / (size + np.float32(CALM)), 0, 1)
    return alike


def compared(query: Clips, windows: Windows) -> Floats:
    """Return how alike one clip is to each of many stretches with the same parts: (B,) float32."""
    return paired(query.full_windows().at(np.s_[:, np.zeros_like(windows.low[0])]), windows)


def paired(one: Windows, two: Windows) -> Floats:
    """Return how alike stretches of clips are to others, pair by pair: (B,) float32, 0 to 1."""
    size = sizes(one) + sizes(two)
    return likeness((size - savings(one, two, size)).sum(axis=0), size.sum(axis=0))


def sizes(windows: Windows) -> Floats:
    """Return what it costs to delete each part of each stretch: (P, B) float32."""
    moves, low, high = windows
    inside = np.minimum(low + 1, high)
    bounds, rows = ranges(inside.ravel(), high.ravel())
    reach = np.append(0, np.cumsum(moves.sizes[rows], dtype=np.float64))
    costs = np.diff(reach[bounds]).reshape(inside.shape)
    costs += np.append(moves.swings, np.float32(0))[low]
    return np.where(low < high, costs, 0).astype(np.float32)


def savings(one: Windows, two: Windows, size: Floats) -> Floats:
    """Return the most that substitutions save of each part, pair by pair: (P, B), as `size`."""
    one_counts, two_counts = one.high - one.low, two.high - two.low
    both = (one_counts > 0) & (two_counts > 0)
    saved_most = np.zeros_like(size)
    saved_most[both] = beginning_savings(one.moves.at(one.low[both]), two.moves.at(two.low[both]))
    # where one side never moves, all that the other does is deleted, and there is no choice
    both &= (one_counts > 1) & (two_counts > 1)
    for part, pair in np.argwhere(one_counts * two_counts * both > SQUARE).tolist():
        cell = slice(part, part + 1), slice(pair, pair + 1)
        saved_most[cell] = size[cell] - _by_pieces(one.at(cell), two.at(cell))
        both[cell] = False
    low, begin = one.low[both], two.low[both]
    more = np.zeros(len(low), np.float32)
    rows, counts, most = one_counts[both], two_counts[both], size[both]
    order = np.argsort(-rows, kind="stable")
    for lane_slice in pieces(counts[order], _ROWS):
        lanes = order[lane_slice]
        ranges_of_both = low[lanes], rows[lanes], begin[lanes], counts[lanes]
        saved = _lane_savings(one.moves, two.moves, *ranges_of_both)
        more[lanes] = _most_saved(counts[lanes], most[lanes], saved)
    saved_most[both] += more
    return saved_most


def _by_pieces(one: Windows, two: Windows) -> float:
    """Return the difference of two long parts if each piece is compared with the one opposite.

    So the work grows with their length, not with its square.
    """
    rows = [float((it.high - it.low).item()) for it in (one, two)]
    count = int(np.ceil(np.sqrt(rows[0] * rows[1] / SQUARE))) + 1

    def cut(windows: Windows) -> Windows:  # each piece begins where the one before it came to
        low, high = windows.low.item(), windows.high.item()
        ends = np.linspace(low, high - 1, count + 1).astype(np.int64)
        return Windows(windows.moves, ends[None, :-1], ends[None, 1:] + 1)

    one, two = cut(one), cut(two)
    size = sizes(one) + sizes(two)
    return float((size - savings(one, two, size)).sum())


def beginning_savings(one: MoveTable, two: MoveTable) -> Floats:
    """Return what substituting beginnings saves, (N,); less than 0 where they are far apart."""
    away = one.points - two.points
    saved: Floats = 2 * np.minimum(one.swings, two.swings)
    saved -= np.float32(POSE) * np.sqrt(np.square(away).sum(axis=1))
    return saved


def _columns(moves: MoveTable, rows: slice | Numbers) -> Floats:
    """Return what `_saving` needs of some movements, (6, N).

    The coordinates where each leads to, times `SUBSTITUTED`; its size, less what its pace and its
    swings cost; and twice these two. Two movements share the smaller of each.
    """
    points = moves.points[rows]
    columns = np.empty((6, len(points)), np.float32)
    columns[:3] = points.T
    columns[:3] *= np.float32(SUBSTITUTED)
    columns[4], columns[5] = np.float32(PACE) * moves.paces[rows], moves.swings[rows]
    columns[3] = moves.sizes[rows] - columns[4] - columns[5]
    columns[4:] *= 2
    return columns


def _lane_savings(
    one: MoveTable, two: MoveTable, low: Numbers, rows: Numbers, begin: Numbers, counts: Numbers
) -> Iterator[Floats]:
    """Yield, row by row of the one side, what it saves in the places of the other: (N,).

    Each pair is a lane; lanes follow each other. (L,) where each begins on either side, and how
    many rows it has, fewer and fewer on the one side; N is as far as there are any.
    """
    firsts, places = ranges(low, low + rows)
    one_columns = _columns(one, places)
    ends, places = ranges(begin, begin + counts)
    two_columns = _columns(two, places)
    two_columns[3, ends[:-1]] = -np.inf  # a beginning takes the place of none
    one_rows = np.repeat(firsts[:-1], counts)
    before = distances(one_columns[:3].take(one_rows, axis=1), two_columns)
    for row in range(1, int(rows[0])):
        end = ends[np.searchsorted(-rows, -row)]
        moves = one_columns.take(one_rows[:end] + row, axis=1)
        saved, before = _saving(moves, two_columns[:, :end], before[:end])
        yield saved


def _saving(one: Floats, two: Floats, before: Floats) -> tuple[Floats, Floats]:
    """Return what substituting movements saves, (..., N), and how far they lie from the others.

    `before` is how far those before them lie from the others; the first of these saves nothing.
    """
    apart = distances(one, two)
    saved = np.minimum(one[4], two[4])
    saved += np.minimum(one[5], two[5])
    saved += one[3]
    saved += two[3]
    saved[..., 1:] -= apart[..., 1:] + before[..., :-1]
    saved[..., 0] = -np.inf
    return saved, apart


def _most_saved(counts: Numbers, most: Floats, savings: Iterable[Floats]) -> Floats:
    """Return the most that each lane saves, (L,), from what `_lane_savings` yields.

    No lane can save more than `most`: so what is saved before a place is a running maximum along
    all lanes, if each begins to count that much higher, and a little, than the one before it.
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
    """Two movements that correspond: the row of the second, and what substituting it saves."""

    row: int
    saving: float


def pairs(query: Clips, clip: Clips, part: int) -> list[Pair]:
    """Return which movements of one part of two clips correspond, by the cheapest alignment."""
    (own, end), (row, last) = query.first[part], clip.first[part]
    if own == end or row == last:
        return []
    query_columns = _columns(query.moves, slice(own, end))[:, :, None]
    clip_columns = _columns(clip.moves, slice(row, last))[:, None]
    savings, _ = _saving(
        query_columns[:, 1:], clip_columns, distances(query_columns[:, :-1], clip_columns)
    )
    best = np.zeros((end - own, last - row), np.float32)
    for before, row_best, saved in zip(best, best[1:], savings, strict=False):
        row_best[1:] = np.maximum(before[1:], before[:-1] + saved[1:])
        np.maximum.accumulate(row_best, out=row_best)
    aligned: list[Pair] = []
    index, place = end - own - 1, last - row - 1
    while index and place:
        if best[index, place] == best[index - 1, place]:
            index -= 1
        elif best[index, place] == best[index, place - 1]:
            place -= 1
        else:
            saving = float(savings[index - 1, place])
            aligned.append(Pair(int(row + place), saving))
            index, place = index - 1, place - 1
    return aligned[::-1]


# Nearest neighbours.


class Near(NamedTuple):
    """A clip, or a stretch of it (frames, half-open), and how like the example it is, 0 to 1."""

    clip: int
    begin: int
    end: int
    likeness: float


class NearestClips(NamedTuple):
    """What is like an example."""

    near: list[Near]  # the best first
    aligned: int  # how many clips were aligned to find it
    sure: bool  # whether no other whole clip could be among them


def nearest(
    query: Clips,
    seconds: float,
    source: ClipSource | LargeSource,
    limit: int,
    *,
    most: int = MOST,
    watch: Progress = unwatched,
) -> NearestClips:
    """Return the `limit` clips of a source that are most like a query of so many seconds."""
    # of a long example fewer clips at a time, so that `watch` is called as often
    long = max(1, len(query.moves.rows) // (_LONG * len(query.parts)))
    work = np.zeros(len(source), np.int64)
    bound_of_clip, bound_of_stretch = np.zeros((2, len(source)), np.float32)

    def bound(start: int, held: ClipSource) -> None:
        work[start : start + len(held)] = own = held.counts * long
        for some in pieces(own, _LAID_OUT):
            watch("captures", start + some.start, len(source))
            clips = held.clips(np.arange(some.start, some.stop))
            here = slice(start + some.start, start + some.stop)
            bound_of_clip[here], bound_of_stretch[here], *_ = bounds_of(query, clips)

    for start in range(0, len(source), TOGETHER):
        bound(start, source.at(np.arange(start, min(start + TOGETHER, len(source)))))
    lengths = seconds * source.rates
    longer = source.frames >= LONGER * lengths
    most_alike = np.where(longer, np.maximum(bound_of_clip, bound_of_stretch), bound_of_clip)
    order = np.argsort(-most_alike, kind="stable")
    near: list[Near] = []
    done, worst = 0, 0.0
    held = source.at(candidates := np.sort(order[:most]))
    while done < min(most, len(order)) and most_alike[order[done]] > worst:
        watch("candidates", done, min(most, len(order)))
        block = order[done : min(done + _BLOCK, most)]
        block = block[next(pieces(work[block], _LAID_OUT))]
        clips, frames = held.clips(np.searchsorted(candidates, block)), source.frames[block]
        alike = compared(query, clips.full_windows())
        near = _best(near, _Tried(block, np.zeros_like(block), frames, alike), limit)
        worst = near[-1].likeness if len(near) == limit else 0.0
        chosen = np.flatnonzero(longer[block] & (bound_of_stretch[block] > worst))
        if len(chosen):
            stretches = _stretches(query, clips, chosen, frames, lengths[block], worst)
            near = _best(near, stretches._replace(clips=block[stretches.clips]), limit)
            worst = near[-1].likeness if len(near) == limit else 0.0
        done += len(block)
    return NearestClips(near, done, done >= len(order) or bool(most_alike[order[done]] <= worst))


class _Tried(NamedTuple):
    """Stretches that were aligned: whose, from which frame to which, how alike; (K,) each."""

    clips: NDArray[Any]
    begins: NDArray[Any]
    ends: NDArray[Any]
    likeness: NDArray[Any]

    def best(self, most: int) -> _Tried:
        """Return the best of each clip, so many at the most."""
        kept = lowest(self.clips, -self.likeness, most)
        return _Tried._make(column[kept] for column in self)


def _best(near: list[Near], more: _Tried, limit: int) -> list[Near]:
    """Return the best, each clip once; of equally good ones the longest."""
    every = [*near, *map(Near, *(column.tolist() for column in more))]
    kept: dict[int, Near] = {}
    for one in sorted(every, key=lambda one: (-one.likeness, one.begin - one.end, one.clip)):
        kept.setdefault(one.clip, one)
    return [one for one in kept.values() if one.likeness > 0][:limit]


class Bounds(NamedTuple):
    """How alike C clips can be to one."""

    full: Floats  # (C,) each whole clip at most
    stretch: Floats  # (C,) about the best stretch of each
    sizes: Doubles  # (N + 1,) running sum over the clips' rows of their sizes
    shares: Doubles  # (N + 1,) the same of what they save at most
    size: float  # of the one clip
    beginnings: float  # what its beginnings save at most

    def of(self, windows: Windows) -> Doubles:
        """Return how alike stretches may be at most: (B,)."""
        inside = np.minimum(windows.low + 1, windows.high)
        size = self.size + (self.sizes[windows.high] - self.sizes[inside]).sum(axis=0)
        common = (self.shares[windows.high] - self.shares[inside]).sum(axis=0)
        most: Doubles = (common + self.beginnings + CALM) / (size + CALM)
        return most


def bounds_of(query: Clips, clips: Clips) -> Bounds:
    """Return how alike each of many clips can be to one clip, which has the same parts."""
    saved, savings_sum = np.zeros((2, len(clips)), np.float32)
    share = np.zeros(len(clips.moves.rows), np.float32)
    begins = query.moves.at(query.first[:, 0][query.first[:, 0] < query.first[:, 1]])
    for (low, high), borders in zip(query.first, clips.first, strict=True):
        there = np.flatnonzero(np.diff(borders))
        if low == high or not len(there):
            continue
        moves, first = query.moves.at(slice(low, high)), borders[there]
        rows = slice(first[0], borders[-1])
        most, best = _savings(moves, clips.moves.at(rows), first - first[0])
        share[rows] = best
        saved[there] += np.minimum(most, np.add.reduceat(best, first - first[0]))
        saved[there] += beginning_savings(
            moves.at(np.zeros(len(there), np.int64)), clips.moves.at(first)
        )
        savings_sum[there] += most
    sizes, shares = (
        np.append(0, np.cumsum(values, dtype=np.float64)) for values in (clips.moves.sizes, share)
    )
    size, begun_most = query.moves.sizes.sum(), 2 * float(begins.swings.sum())
    total = np.diff(sizes[clips.first], axis=1).sum(axis=0).astype(np.float32) + size
    stretch = np.clip(savings_sum / np.maximum(size + savings_sum / 2, np.float32(1e-6)), 0, 1)
    return Bounds(likeness(total - saved, total), stretch, sizes, shares, float(size), begun_most)


def _savings(query: MoveTable, rows: MoveTable, first: Numbers) -> tuple[Floats, Floats]:
    """Return what the query's movements save at most by clip, and each row: (C,) and (N,).

    `first` is (C,) where each clip begins among the rows.
    """
    most = np.zeros(len(first), np.float32)
    best = np.zeros(len(rows.rows), np.float32)
    if len(query.rows) > LONGEST:
        most += _most(query)[1:].sum()
        best = _most(rows)
        best[first] = 0
        return most, best
    query_columns, row_columns = _columns(query, slice(None)), _columns(rows, slice(None))
    before = distances(query_columns[:3, :1], row_columns)
    for row in range(1, len(query.rows)):
        saving, before = _saving(query_columns[:, row : row + 1], row_columns, before)
        np.maximum(saving, 0, out=saving)
        saving[first] = 0
        most += np.maximum.reduceat(saving, first)
        np.maximum(best, saving, out=best)
    return most, best


def _most(moves: MoveTable) -> Floats:
    """Return what each movement saves at most, whatever it may substitute: (N,).

    That is what it and its like cost, and what a substitution does not charge for how much farther
    the other goes. A starting position behind a gap costs nothing, but may stand for a movement.
    """
    farther = np.float32((1 - SUBSTITUTED) * _FARTHEST)
    starting = np.float32(STEP + _FARTHEST)
    return 2 * moves.sizes + np.where(moves.starts < moves.stops, farther, starting)


def _stretches(
    query: Clips,
    clips: Clips,
    clip_numbers: Numbers,
    frames: Numbers,
    lengths: Doubles,
    worst: float,
) -> _Tried:
    """Return the best stretch of each chosen clip, if it can be above `worst`.

    `frames` and `lengths` are (C,): the length of each clip, and the example's at its rate.
    """
    bounds = bounds_of(query, clips)

    def tried(owner: Numbers, begins: Doubles, ends: Doubles) -> _Tried:
        low, high = np.round(begins).astype(np.int64), np.round(ends).astype(np.int64)
        windows = clips.windows(owner, low, high)
        most = bounds.of(windows)
        kept = lowest(owner, -most, _TRIED)  # the most promising
        kept = kept[most[kept] > worst]
        alike = compared(query, windows.at(np.s_[:, kept]))
        return _Tried(owner[kept], low[kept], high[kept], alike)

    step = lengths / _STEPS
    each = np.maximum(step, frames / _BEGINNINGS)
    counts = np.ceil(np.maximum(frames - lengths / 2, 1) / each).astype(np.int64)[clip_numbers]
    _, place = ranges(np.zeros_like(counts), counts)
    owner = np.repeat(clip_numbers, counts)
    begins = np.asarray(place * each[owner], np.float64)
    first = tried(owner, begins, begins + lengths[owner])
    finals = first.best(_FINALISTS)
    middles = (finals.begins + finals.ends)[:, None] / 2
    middles = middles + step[finals.clips, None] * np.arange(-1, 2) / 3
    middle = np.repeat(middles.ravel(), len(_LENGTHS))
    owner = np.repeat(finals.clips, middles.shape[1] * len(_LENGTHS))
    half = lengths[owner] * np.tile(_LENGTHS, middles.size) / 2
    again = tried(owner, middle - half, middle + half)
    every = _Tried._make(np.append(*both) for both in zip(first, again, strict=True)).best(1)
    begins, ends = np.maximum(every.begins, 0), np.minimum(every.ends, frames[every.clips])
    return every._replace(begins=begins, ends=ends)


# Groups.

PAIRS = 60_000  # pairs that are aligned, about
FEWEST = 8  # neighbours of each clip that are aligned at least
_AXES, _TURNS = 32, 4  # numbers of a signature, and rounds of looking for their axes
_AT_ONCE = 1 << 12  # pairs that are aligned at a time
_NOTHING = 0.01  # the likeness below which two clips have nothing in common
_NEAREST = 1e-6  # the least likeness of clips with one signature, where a number is wanted
_NEIGHBOURS, _TREES = 2048, 8  # clips of a block, and how often more are split into blocks


class SimilarClips(NamedTuple):
    """Clips that are like each other."""

    members: list[int]  # the medoid, which is most like all others, then the likest to it
    likeness: float  # the mean of the others' to the medoid; of one clip alone 1


class Grouped(NamedTuple):
    """All clips in groups."""

    groups: list[SimilarClips]  # the largest first
    pairs: int  # how many were aligned
    every: bool  # whether these are all pairs


Align = Callable[[Windows, list[Numbers]], Iterator[Floats]]
"""Yields how alike pairs of clips are, (K,), for each of some lists of keys; see `aligned`."""


def aligned(clips: Windows, keys: list[Numbers]) -> Iterator[Floats]:
    """Yield how alike pairs of clips are, (K,), for each list of them.

    A key is the number of the one clip, times the number of clips, plus that of the other.
    """
    for some in keys:
        yield paired(*(clips.at(np.s_[:, it]) for it in np.divmod(some, clips.low.shape[1])))


def grouped(
    clips: Clips,
    *,
    least: float,
    wanted: int | None = None,
    watch: Progress = unwatched,
    align: Align = aligned,
) -> Grouped:
    """Join groups down to a mean likeness of `least`, or until no more than `wanted` are left."""
    vectors, likenesses = signatures(clips), _Likenesses(clips, watch, align)
    groups = [[clip] for clip in range(len(clips))]
    floor, every, settled = least, False, False
    while not every and (wanted or not settled):
        medoids = np.array([group[0] for group in groups], np.int64)
        reach = max(FEWEST, 2 * PAIRS // max(1, len(groups)))
        every = reach >= len(groups) - 1
        pairs = near(vectors[medoids], reach, watch)
        alike = likenesses.alike(medoids[pairs])
        if wanted:
            apart = np.linalg.norm(np.diff(vectors[medoids[pairs]], axis=1)[:, 0], axis=1)
            alike = np.maximum(alike, _NEAREST / (1 + apart))
        weights = [len(group) for group in groups]
        last = 0.0 if wanted and (every or floor <= _NOTHING) else floor
        joined = linked(weights, pairs, alike, last, wanted or 1, watch)
        order = _medoids_first(joined, weights, pairs, alike)
        settled = len(order) == len(groups)
        groups = [[clip for one in group for clip in groups[one]] for group in order]
        if wanted and len(groups) <= wanted:
            break
        floor = floor / 2 if settled else floor
    aligned, all_pairs = len(likenesses), len(clips) * (len(clips) - 1) // 2
    return Grouped(_ranked(groups, likenesses), aligned, aligned == all_pairs)


class _Likenesses:
    """How alike pairs of clips are, each aligned once."""

    def __init__(self, clips: Clips, watch: Progress, align: Align = aligned) -> None:
        self._clips, self._watch, self._align = clips, watch, align
        self._values: dict[int, float] = {}

    def __len__(self) -> int:
        return len(self._values)

    def alike(self, pairs: Numbers) -> Doubles:
        """Return how alike pairs of clips are: (K,), of a clip with itself 1."""
        low, high = np.sort(pairs, axis=1).T
        keys, done = low * len(self._clips) + high, 0
        unique = np.unique(keys[low < high])
        new = unique[[key not in self._values for key in unique.tolist()]]
        each = np.array_split(new, len(new) // _AT_ONCE + 1)
        self._watch("pairs", 0, len(new))
        found = self._align(self._clips.full_windows(), each)
        for some, alike in zip(each, found, strict=True):
            self._watch("pairs", done, len(new))
            self._values.update(zip(some.tolist(), alike.tolist(), strict=True))
            done += len(some)
        return np.array([self._values.get(key, 1.0) for key in keys.tolist()])


def near(vectors: Floats, reach: int, watch: Progress = unwatched) -> Numbers:
    """Return the pairs that may be alike: (K, 2), the lower number first, each once.

    Each clip is in pairs with the `reach` others whose signatures, (C, A), are nearest to its own.
    """
    count = len(vectors)
    if reach >= count - 1:
        return np.stack(np.triu_indices(count, 1), axis=1)
    squares = np.square(vectors).sum(axis=1)
    keys, gaps, done = [], [], 0
    trees = _TREES if count > _NEIGHBOURS else 1
    for block in _blocks(vectors, trees):
        watch("captures", done // trees, count)
        own, done = vectors[block], done + len(block)
        apart = squares[block, None] + squares[block] - 2 * own @ own.T
        np.fill_diagonal(apart, np.inf)
        nearest = np.argpartition(apart, reach, axis=1)[:, :reach]
        keys.append((block[:, None] * count + block[nearest]).ravel())
        gaps.append(np.take_along_axis(apart, nearest, axis=1).ravel())
    key, once = np.unique(np.concatenate(keys), return_index=True)
    kept = lowest(key // count, np.concatenate(gaps)[once], reach)
    pairs = np.sort(np.stack(np.divmod(key[kept], count), axis=1), axis=1)
    return np.stack(np.divmod(np.unique(pairs @ [count, 1]), count), axis=1)


def _blocks(vectors: Floats, trees: int) -> Iterator[Numbers]:
    """Yield clips in blocks of neighbours, all of them once for each tree."""
    random = np.random.default_rng(0)
    todo = [np.arange(len(vectors))] * trees
    while todo:
        block = todo.pop()
        if len(block) <= _NEIGHBOURS:
            yield block
            continue
        one, two = vectors[block[random.choice(len(block), 2, replace=False)]]
        middle = len(block) // 2
        order = np.argpartition(vectors[block] @ (one - two), middle)
        todo += [block[order[:middle]], block[order[middle:]]]


def signatures(clips: Clips) -> Floats:
    """Return how much each part of each clip moves to which cell, in a few numbers: (C, A)."""
    cells, count = MIDDLES[CELLS].astype(np.float32), len(clips)
    table = np.zeros((count, len(clips.parts), len(cells)), np.float32)
    for part, borders in enumerate(clips.first):
        moves = clips.moves.at(slice(borders[0], borders[-1]))
        nearest = np.argmax(moves.points @ cells.T - np.square(cells).sum(axis=1) / 2, axis=1)
        places = np.repeat(np.arange(count), np.diff(borders)) * len(cells) + nearest
        own = np.bincount(places, moves.sizes, count * len(cells))
        table[:, part] = own.reshape(count, -1)
    table = np.sqrt(table.reshape(count, -1))
    table -= table.mean(axis=0)
    # the axes along which they differ most, nearly: all of them would take longer than the rest
    axes = np.random.default_rng(0).normal(size=(table.shape[1], _AXES)).astype(np.float32)
    for _ in range(_TURNS):
        axes, _ = np.linalg.qr(table.T @ (table @ axes))
    return table @ axes


def linked(
    weights: list[int], pairs: Numbers, alike: Doubles, floor: float, wanted: int, watch: Progress
) -> list[list[int]]:
    """Return groups by average linkage: joined down to a mean likeness, or until few are left.

    Each item stands for as many clips as its weight says. (K, 2) pairs are (K,) alike, others not.
    """
    sums: dict[int, dict[int, float]] = {one: {} for one in range(len(weights))}
    for first in range(0, len(pairs), _AT_ONCE):
        watch("likenesses", first, len(pairs))
        some = slice(first, first + _AT_ONCE)
        for (one, two), value in zip(pairs[some].tolist(), alike[some].tolist(), strict=True):
            if value > 0:
                sums[one][two] = sums[two][one] = value * weights[one] * weights[two]
    size = dict(enumerate(weights))
    members = {one: [one] for one in sums}
    queue = [
        (-value / (size[one] * size[two]), one, two)
        for one in sums
        for two, value in sums[one].items()
        if one < two
    ]
    heapify(queue)
    new = len(weights)
    while queue and len(members) > wanted:
        value, one, two = heappop(queue)
        if one not in members or two not in members:
            continue
        if -value < floor:
            break
        watch("captures", new - len(weights), len(weights))
        members[new] = members.pop(one) + members.pop(two)
        size[new] = size[one] + size[two]
        own, other = sums.pop(one), sums.pop(two)
        sums[new] = {}
        for third in sorted((own.keys() | other.keys()) - {one, two}):
            total = sums[third].pop(one, 0.0) + sums[third].pop(two, 0.0)
            sums[new][third] = sums[third][new] = total
            heappush(queue, (-total / (size[new] * size[third]), third, new))
        new += 1
    return list(members.values())


def _medoids_first(
    joined: list[list[int]], weights: list[int], pairs: Numbers, alike: Doubles
) -> list[list[int]]:
    """Return groups, the member of each first that is most like all others of it."""
    count = len(weights)
    owner = np.zeros(count, np.int64)
    for number, group in enumerate(joined):
        owner[group] = number
    inside = owner[pairs[:, 0]] == owner[pairs[:, 1]]
    (one, two), value = pairs[inside].T, alike[inside]
    weight = np.array(weights, np.float64)
    total = np.bincount(one, value * weight[two], count)
    total += np.bincount(two, value * weight[one], count)
    order = np.lexsort((np.arange(count), -total, owner))
    ends = np.cumsum(np.bincount(owner, minlength=len(joined)))
    return [part.tolist() for part in np.split(order, ends[:-1])]


def _ranked(groups: list[list[int]], likenesses: _Likenesses) -> list[SimilarClips]:
    """Return groups, the largest first, their members by likeness to the medoid."""
    alike = likenesses.alike(np.array([(group[0], one) for group in groups for one in group]))
    ranked, ends = [], np.cumsum([len(group) for group in groups])
    for group, own in zip(groups, np.split(alike, ends[:-1]), strict=True):
        order = np.argsort(-own[1:], kind="stable").tolist()
        mean = float(own[1:].mean()) if order else 1.0
        ranked.append(SimilarClips([group[0], *(group[1 + place] for place in order)], mean))
    return sorted(ranked, key=lambda group: (-len(group.members), group.members[0]))
