"""Stage 2: where a part holds still, and the moves between the holds.

Source: ``encoding/METHOD.md``, stages 2 and 2b; Matsumoto and Hachimura (2001), 4.3 and 4.4.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.encoding.arithmetic import blocks, dist, median, sizes

Floats = NDArray[np.float64]

_SURELY = 1 - 1e-9  # so that what is rounded decides nothing

LONG_HOLD = 6
"""Frames: the noise of a hold at least this long says when a move leaves it."""


class Hold(NamedTuple):
    """Where a part stays near one point, from one candidate to another."""

    first: int  # Resampled frames, both included
    last: int


class Segment(NamedTuple):
    """A move between two holds."""

    # Resampled frames, both included: the last of the hold before, the first of the one after
    first: int
    last: int
    begin: int  # When the move is seen to begin and to end (stage 2b), both included
    end: int


def speeds(curve: Floats, rate: float) -> Floats:
    """Return the speed: central difference, one-sided at the ends.

    `curve` (..., N, 3) float64, mm; returned (..., N) float64, mm/s.
    """
    if curve.shape[-2] < 2:
        return np.zeros(curve.shape[:-1])
    speed = np.empty(curve.shape[:-1])
    for part in blocks(curve.shape[-2], 1):
        slope = np.gradient(curve[..., part.outer, :], axis=-2)
        speed[..., part.inner] = sizes(slope[..., part.within, :] * rate)
    return speed


def candidates(speed: Floats, slow: float, prominence: float, still: float) -> NDArray[np.int64]:
    """Return the frames at which the limb may have stopped.

    `speed` (N,) float64, mm/s; returned (C,) int64, rising; always the first frame and the last.
    """
    level = np.maximum(speed, still)
    borders = np.ones(len(level) + 1, bool)
    borders[1:-1] = level[1:] != level[:-1]
    heights = level[borders[:-1]]
    del level  # what a long capture is done with would be half as much again
    rises = np.ones(len(heights) + 1, bool)
    rises[0] = False
    rises[1:-1] = heights[1:] > heights[:-1]
    lowest = np.flatnonzero((rises[1:] > rises[:-1]) & (heights <= slow))
    deep = _deep(heights, lowest, prominence)
    del heights, rises, lowest
    edges = np.flatnonzero(borders)
    chosen = np.zeros(len(speed), bool)
    chosen[0] = chosen[-1] = chosen[edges[deep]] = chosen[edges[deep + 1] - 1] = True
    return np.flatnonzero(chosen)


def _deep(heights: Floats, lowest: NDArray[np.int64], prominence: float) -> NDArray[np.int64]:
    """Leave out minima, until between each and a lower neighbour there is a rim high enough."""
    while True:
        depths = heights[lowest]
        rims = np.maximum.reduceat(heights, lowest)[:-1]
        before, after = depths[:-1], depths[1:]
        shallow = np.zeros(len(lowest), bool)
        shallow[:-1] = (before > after) & (rims - before < prominence)
        shallow[1:] |= (after > before) & (rims - after < prominence)
        if not shallow.any():
            return lowest
        lowest = lowest[~shallow]


def holds(
    curve: Floats, stops: NDArray[np.int64], distance: float, path_check: float
) -> list[Hold]:
    """Group candidates that stay together.

    `curve` (N, 3) float64, mm; `stops` (C,) int64, rising.
    """
    found: list[Hold] = []
    limit = path_check or np.inf
    within = min(distance, limit)
    marks = _marks(curve, stops, path_check)
    first, origin, strays = next(marks)
    last, before = first, origin
    for stop, point, further in marks:
        near = dist(point, origin) <= within
        if near and dist(before, origin) + strays > limit * _SURELY:
            near = sizes(curve[last:stop] - curve[first]).max() <= limit
        if not near:
            found.append(Hold(first, last))
            first, origin = stop, point
        last, before, strays = stop, point, further
    found.append(Hold(first, last))
    return found


def _marks(
    curve: Floats, stops: NDArray[np.int64], path_check: float
) -> Iterator[tuple[int, tuple[float, ...], float]]:
    """Yield frame and place of each candidate, and how far the limb strays until the next.

    As numbers of Python they take ten times the memory, so they are made a few at a time.
    """
    strayed = np.zeros(len(stops))
    if path_check:
        strayed[:-1] = _strayed(curve, stops)
    for part in blocks(len(stops)):
        some = stops[part.inner]
        places = map(tuple, curve[some].tolist())
        yield from zip(some.tolist(), places, strayed[part.inner].tolist(), strict=True)


def _strayed(curve: Floats, stops: NDArray[np.int64]) -> Floats:
    """Return how far the limb strays from each candidate until the next."""
    away = np.empty(max(len(curve) - 1, 0))
    origins = stops[:-1].repeat(stops[1:] - stops[:-1])
    for part in blocks(len(away)):
        away[part.inner] = sizes(curve[part.inner] - curve.T.take(origins[part.inner], axis=1).T)
    return np.maximum.reduceat(away, stops[:-1])


def segments(speed: Floats, stops: Sequence[Hold], onset: float, still: float) -> list[Segment]:
    """Return the moves between the holds, with the times at which they begin and end.

    `speed` (N,) float64, mm/s.
    """
    if not onset:
        return [Segment(a.last, b.first, a.last, b.first) for a, b in pairwise(stops)]
    noise = [
        max(still, median(speed[first : last + 1])) if last - first + 1 >= LONG_HOLD else still
        for first, last in stops
    ]
    values = speed.data  # a list of Python's own numbers would take four times the memory
    found = []
    for (before, after), (quiet, calm) in zip(pairwise(stops), pairwise(noise), strict=True):
        first, last = before.last, after.first
        peak, move = max(values[first : last + 1]), range(first, last + 1)
        begin = _begin(values, before.first, move, peak / 4, max(onset * peak, quiet))
        end = _begin(values, after.last, move[::-1], peak / 4, max(onset * peak, calm))
        found.append(Segment(first, last, begin, max(begin, end)))
    return found


def _begin(speed: memoryview, hold: int, move: range, fast: float, slow: float) -> int:
    """Return where the move begins: back from its first fast frame, but not beyond the hold."""
    for start in move:
        if speed[start] >= fast:
            break
    for frame in range(start, hold, -move.step):
        if speed[frame] <= slow:
            return frame
    return hold
