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
    """Where a part stays near one point, from one candidate to another.

    Attributes
    ----------
    first, last : int
        Resampled frames, both included.
    """

    first: int
    last: int


class Segment(NamedTuple):
    """A move between two holds.

    Attributes
    ----------
    first, last : int
        Resampled frames, both included: the last of the hold before, the first of the one after.
    begin, end : int
        When the move is seen to begin and to end (stage 2b), both included.
    """

    first: int
    last: int
    begin: int
    end: int


def speeds(curve: Floats, rate: float) -> Floats:
    """Return the speed: central difference, one-sided at the ends.

    Parameters
    ----------
    curve : ndarray
        (..., N, 3) float64, mm.
    rate : float
        Frames a second.

    Returns
    -------
    ndarray
        (..., N) float64, mm/s.

    Examples
    --------
    >>> import numpy as np
    >>> from lanindex.encoding.segment import speeds
    >>> speeds(np.array([[0.0, 0, 0], [1, 0, 0], [3, 0, 0]]), rate=60)
    array([ 60.,  90., 120.])
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

    Parameters
    ----------
    speed : ndarray
        (N,) float64, mm/s.
    slow : float
        v0, mm/s: minima above it do not count.
    prominence : float
        mm/s by which the lower rim must stand above a minimum.
    still : float
        mm/s: speeds at or below are one plateau, and both its ends count.

    Returns
    -------
    ndarray
        (C,) int64, rising; always the first frame and the last.

    Examples
    --------
    >>> import numpy as np
    >>> from lanindex.encoding.segment import candidates
    >>> speed = np.array([900.0, 5, 3, 4, 800, 300, 280, 290, 700])
    >>> candidates(speed, slow=600, prominence=50, still=10)
    array([0, 1, 3, 6, 8])
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

    Parameters
    ----------
    curve : ndarray
        (N, 3) float64, mm.
    stops : ndarray
        (C,) int64, rising.
    distance : float
        d_t, mm from the group's first.
    path_check : float
        mm from the group's first that the limb may stray between two of them; 0: anything.

    Returns
    -------
    list of Hold
        In order of time.

    Examples
    --------
    >>> import numpy as np
    >>> from lanindex.encoding.segment import holds
    >>> curve = np.zeros((6, 3))
    >>> curve[:, 0] = 0, 10, 20, 300, 310, 320
    >>> holds(curve, np.array([0, 2, 3, 5]), distance=50, path_check=100)
    [Hold(first=0, last=2), Hold(first=3, last=5)]
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

    Parameters
    ----------
    speed : ndarray
        (N,) float64, mm/s.
    stops : sequence of Hold
        In order of time.
    onset : float
        Part of the peak speed at which a move begins; 0: at the candidate.
    still : float
        mm/s.

    Returns
    -------
    list of Segment
        In order of time: one between each hold and the next.

    Examples
    --------
    >>> import numpy as np
    >>> from lanindex.encoding.segment import Hold, segments
    >>> speed = np.array([0.0, 10, 20, 400, 900, 400, 20, 10, 0])
    >>> segments(speed, [Hold(0, 1), Hold(7, 8)], onset=0.03, still=5)
    [Segment(first=1, last=7, begin=2, end=6)]
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
