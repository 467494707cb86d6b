"""The nearest neighbours of a clip: whole clips or, where they are much longer, a stretch of each.

A prefilter comes first: two clips share at most what each movement of one saves if it may
substitute the best of the other, whatever the order. That bound takes one look at each symbol.
Clips are aligned in the order of their bounds, until the bound falls below the likeness of the
worst that is wanted.

In a long clip, stretches of about the example's length begin everywhere. Running sums give the
bound of each; the most promising are aligned, those of all clips together; then the edges of the
best are moved about, and the most promising of these aligned.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.model.columns import ranges
from lanindex.search.example.align import (
    CALM,
    STEP,
    SUBSTITUTED,
    Clips,
    Doubles,
    Floats,
    Moves,
    Numbers,
    Source,
    Watch,
    Windows,
    begun,
    compared,
    likeness,
    lowest,
    pieces,
    savings_of,
    unwatched,
)

LONGER = 4.0  # times the example's length from which on stretches of a clip are tried, too
MOST = 4096  # clips that are aligned at most
_BLOCK, _ROWS = 256, 1 << 18  # clips aligned at a time, and rows of clips laid out
_LONG = 16  # rows a part of an example from which on these are fewer
LONGEST = 2048  # movements of a part of the example that are each compared with every movement
_FARTHEST = 2.0  # how far a movement can go
_STEPS, _BEGINNINGS = 4, 2000  # stretches begun in the example's length, and in a clip at most
_TRIED, _FINALISTS = 12, 3  # stretches of a clip aligned at a time, and those that are shifted
_LENGTHS = np.array([0.7, 1.0, 1.4])  # of stretches, in proportion to the example's


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
    source: Source,
    limit: int,
    *,
    most: int = MOST,
    watch: Watch = unwatched,
) -> NearestClips:
    """Return the `limit` clips of a source that are most like a query of so many seconds."""
    # of a long example fewer clips at a time, so that `watch` is called as often
    counts = np.sum([np.diff(it.bounds)[source.places] for it in source.columns.values()], axis=0)
    work = counts * max(1, len(query.moves.rows) // (_LONG * len(query.parts)))
    whole, stretch = np.zeros((2, len(source)), np.float32)
    for some in pieces(work, _ROWS):
        watch("captures", some.start, len(source))
        clips = source.taken(np.arange(some.start, some.stop))
        whole[some], stretch[some], *_ = bounds_of(query, clips)
    lengths = seconds * source.rates
    longer = source.frames >= LONGER * lengths
    bound = np.where(longer, np.maximum(whole, stretch), whole)
    order = np.argsort(-bound, kind="stable")
    near: list[Near] = []
    done, worst = 0, 0.0
    while done < min(most, len(order)) and bound[order[done]] > worst:
        watch("candidates", done, min(most, len(order)))
        block = order[done : min(done + _BLOCK, most)]
        block = block[next(pieces(work[block], _ROWS))]
        clips, frames = source.taken(block), source.frames[block]
        alike = compared(query, clips, clips.whole())
        near = _best(near, _Tried(block, np.zeros_like(block), frames, alike), limit)
        worst = near[-1].likeness if len(near) == limit else 0.0
        chosen = np.flatnonzero(longer[block] & (stretch[block] > worst))
        if len(chosen):
            found = _stretches(query, clips, chosen, frames, lengths[block], worst)
            near = _best(near, found._replace(clips=block[found.clips]), limit)
            worst = near[-1].likeness if len(near) == limit else 0.0
        done += len(block)
    return NearestClips(near, done, done >= len(order) or bool(bound[order[done]] <= worst))


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

    whole: Floats  # (C,) each whole clip at most
    stretch: Floats  # (C,) about the best stretch of each
    sizes: Doubles  # (N + 1,) running sum over the clips' rows of their sizes
    shares: Doubles  # (N + 1,) the same of what they save at most
    size: float  # of the one clip
    begun: float  # what its beginnings save at most

    def of(self, windows: Windows) -> Doubles:
        """Return how alike stretches may be at most: (B,)."""
        inside = np.minimum(windows.low + 1, windows.high)
        size = self.size + (self.sizes[windows.high] - self.sizes[inside]).sum(axis=0)
        common = (self.shares[windows.high] - self.shares[inside]).sum(axis=0)
        most: Doubles = (common + self.begun + CALM) / (size + CALM)
        return most


def bounds_of(query: Clips, clips: Clips) -> Bounds:
    """Return how alike each of many clips can be to one clip, which has the same parts."""
    saved, found = np.zeros((2, len(clips)), np.float32)
    share = np.zeros(len(clips.moves.rows), np.float32)
    begins = query.moves.taken(query.first[:, 0][query.first[:, 0] < query.first[:, 1]])
    for (low, high), borders in zip(query.first, clips.first, strict=True):
        there = np.flatnonzero(np.diff(borders))
        if low == high or not len(there):
            continue
        own, first = query.moves.taken(slice(low, high)), borders[there]
        rows = slice(first[0], borders[-1])
        most, best = _savings(own, clips.moves.taken(rows), first - first[0])
        share[rows] = best
        saved[there] += np.minimum(most, np.add.reduceat(best, first - first[0]))
        saved[there] += begun(own.taken(np.zeros(len(there), np.int64)), clips.moves.taken(first))
        found[there] += most
    sizes, shares = (
        np.append(0, np.cumsum(values, dtype=np.float64)) for values in (clips.moves.sizes, share)
    )
    size, begun_most = query.moves.sizes.sum(), 2 * float(begins.swings.sum())
    total = np.diff(sizes[clips.first], axis=1).sum(axis=0).astype(np.float32) + size
    stretch = np.clip(found / np.maximum(size + found / 2, np.float32(1e-6)), 0, 1)
    return Bounds(likeness(total - saved, total), stretch, sizes, shares, float(size), begun_most)


def _savings(own: Moves, rows: Moves, first: Numbers) -> tuple[Floats, Floats]:
    """Return what the query's movements save at most by clip, and each row: (C,) and (N,).

    `first` is (C,) where each clip begins among the rows.
    """
    most = np.zeros(len(first), np.float32)
    best = np.zeros(len(rows.rows), np.float32)
    if len(own.rows) > LONGEST:
        most += _most(own)[1:].sum()
        best = _most(rows)
        best[first] = 0
        return most, best
    for saving in savings_of(own, rows):
        np.maximum(saving, 0, out=saving)
        saving[first] = 0
        most += np.maximum.reduceat(saving, first)
        np.maximum(best, saving, out=best)
    return most, best


def _most(moves: Moves) -> Floats:
    """Return what each movement saves at most, whatever it may substitute: (N,).

    That is what it and its like cost, and what a substitution does not charge for how much farther
    the other goes. A starting position behind a gap costs nothing, but may stand for a movement.
    """
    farther = np.float32((1 - SUBSTITUTED) * _FARTHEST)
    starting = np.float32(STEP + _FARTHEST)
    most: Floats = 2 * moves.sizes + np.where(moves.starts < moves.stops, farther, starting)
    return most


def _stretches(
    query: Clips, clips: Clips, chosen: Numbers, frames: Numbers, lengths: Doubles, worst: float
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
        alike = compared(query, clips, windows.taken(kept))
        return _Tried(owner[kept], low[kept], high[kept], alike)

    step = lengths / _STEPS
    each = np.maximum(step, frames / _BEGINNINGS)
    counts = np.ceil(np.maximum(frames - lengths / 2, 1) / each).astype(np.int64)[chosen]
    _, place = ranges(np.zeros_like(counts), counts)
    owner = np.repeat(chosen, counts)
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
