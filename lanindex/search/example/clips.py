"""Movements of many clips as points and times, laid out side by side for alignment.

A movement is the point that its symbol leads to on a sphere about the joint it is seen from: the
middle of its cell, drawn towards the cell across the nearest border the less clearly it lies in its
own (half-way at the border). `place low` and `place high` are the poles, `place mid` is the centre.
So neighbouring cells are near each other, opposite ones far apart, and what lies on a border is
near to both sides.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTIONS, LEVELS, PLACE
from lanindex.model.columns import CELL, PASSING, THOUSANDTHS, Columns, cell_of, ranges

Floats = NDArray[np.float32]
Numbers = NDArray[np.int64]

Watch = Callable[[str, int, int], None]
"""Is told what is gone through, how much of it is done, and of how much; it may raise."""


def unwatched(noun: str, done: int, total: int) -> None:
    """Tell nobody."""


STEP = 0.25
"""What every movement costs that one clip has and the other has not, beside how far it goes."""

SWING = 0.2
"""What a swing costs: a move out and back within one cell."""

BRIEFEST = 1 / 60
"""Seconds that a movement takes at least."""


_AZIMUTH = np.radians(45.0 * np.arange(PLACE))[:, None]
_ELEVATION = np.radians(45.0 * (1 + np.arange(len(LEVELS))))

POINTS = np.zeros((len(DIRECTIONS), len(LEVELS), 3), np.float32)
"""The middle of each cell: (9, 3, 3), by direction and level, x right, y up, z forward."""

POINTS[:PLACE, :, 0] = np.sin(_ELEVATION) * np.cos(_AZIMUTH)
POINTS[:PLACE, :, 1] = -np.cos(_ELEVATION)
POINTS[:PLACE, :, 2] = np.sin(_ELEVATION) * np.sin(_AZIMUTH)
POINTS[PLACE, :, 1] = np.arange(len(LEVELS)) - 1

# the same by cell as columns have it; without direction or level, the centre
_CELLS = [cell_of(*codes) for codes in np.ndindex(POINTS.shape[:2])]
_KNOWN = np.zeros(CELL + 1, bool)
_MIDDLES = np.zeros((CELL + 1, 3), np.float32)
_KNOWN[_CELLS], _MIDDLES[_CELLS] = True, POINTS.reshape(-1, 3)


class Moves(NamedTuple):
    """Movements that a score shows, in columns.

    Attributes
    ----------
    points : ndarray
        (N, 3) float32, where each leads to.
    sizes : ndarray
        (N,) float32, what it costs to delete: `STEP`, how far it goes, and its swings; of a
        starting position the swings alone.
    paces, swings : ndarray
        (N,) float32, the logarithm of its seconds, and what its swings cost.
    starts, stops : ndarray
        (N,) frames of the source, half-open.
    rows : ndarray
        (N,) where it stands in its track.
    """

    points: Floats
    sizes: Floats
    paces: Floats
    swings: Floats
    starts: Numbers
    stops: Numbers
    rows: Numbers

    def taken(self, rows: slice | Numbers) -> Moves:
        """Return some of them."""
        return Moves._make(column[rows] for column in self)


class Windows(NamedTuple):
    """Stretches of clips: (P, B) rows of `Clips` by part, half-open.

    The first row is where the part is before; both are equal where it is not there.
    """

    low: Numbers
    high: Numbers

    def taken(self, which: Numbers) -> Windows:
        """Return some of them."""
        return Windows(self.low[:, which], self.high[:, which])


@dataclass(frozen=True, slots=True)
class Clips:
    """Clips laid out: the movements of a part in all of them, then those of the next part.

    `first` is (P, C + 1), the row with which each clip's part begins, where it is before it first
    moves; two equal ones in a row where a clip lacks the part.
    """

    parts: tuple[str, ...]
    moves: Moves
    first: Numbers

    def __len__(self) -> int:
        """Return the number of clips."""
        return int(self.first.shape[1]) - 1

    def whole(self) -> Windows:
        """Return the windows that hold all of each clip."""
        return Windows(self.first[:, :-1], self.first[:, 1:])

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
        return Windows(low, np.where(first < last, np.maximum(high, low + 1), low))

    def cut(self, clip: int, begin: int, end: int) -> Clips:
        """Return one stretch of one clip as a clip by itself."""
        low, high = self.windows(np.array([clip]), np.array([begin]), np.array([end]))
        bounds, rows = ranges(low[:, 0], high[:, 0])
        moves = self.moves.taken(rows)
        begins = bounds[:-1][low[:, 0] < high[:, 0]]
        moves.sizes[begins] = moves.swings[begins]
        return Clips(self.parts, moves, np.stack([bounds[:-1], bounds[1:]], axis=1))


@dataclass(frozen=True, slots=True)
class Source:
    """The captures of columns, a few of which at a time are laid out as clips.

    The columns have their swings, by part, in order. The others are (C,), of each clip: its place
    in the columns, its length in frames, and frames a second.
    """

    columns: Mapping[str, Columns]
    places: Numbers
    frames: Numbers
    rates: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of clips."""
        return len(self.places)

    @property
    def counts(self) -> Numbers:
        """(C,) how many rows each clip has, with those that are merely passed."""
        counts = np.zeros(len(self), np.int64)
        for columns in self.columns.values():
            counts += np.diff(columns.bounds)[self.places]
        return counts

    def taken(self, order: Numbers, watch: Watch = unwatched) -> Clips:
        """Return some of the clips, laid out: (D,) which."""
        found: list[Moves] = []
        counts = np.zeros((len(self.columns), len(order)), np.int64)
        for part, columns in enumerate(self.columns.values()):
            watch("parts", part, len(self.columns))
            moves, counts[part] = _moves(columns.taken(self.places[order]), self.rates[order])
            found.append(moves)
        ends = np.append(0, np.cumsum(counts))
        first = np.arange(len(found))[:, None] * len(order) + np.arange(len(order) + 1)
        moves = Moves(*map(np.concatenate, zip(*found, strict=True)))
        return Clips(tuple(self.columns), moves, ends[first])


def _moves(columns: Columns, rates: NDArray[np.float64]) -> tuple[Moves, Numbers]:
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
    points = _placed(columns, rows)
    way = np.zeros(len(rows), np.float32)
    way[1:] = distances(points[1:].T, points[:-1].T)
    moving = starts < stops
    moving[edges[:-1][counts > 0]] = False
    sizes = swings + np.where(moving, np.float32(STEP) + way, np.float32(0))
    places = rows - np.repeat(columns.bounds[:-1], counts)
    return Moves(points, sizes, paces, swings, starts, stops, places), counts


def _placed(columns: Columns, rows: Numbers) -> Floats:
    """Return where symbols lead to; one without direction or level leads to the centre."""
    cells, runners = columns.cell[rows] & CELL, columns.runner[rows]
    points: Floats = _MIDDLES[cells]
    margin = (columns.margin[rows] / THOUSANDTHS).clip(max=1.0).astype(np.float32)
    share = (0.5 * (1 - margin)) * (_KNOWN[cells] & _KNOWN[runners])
    points += share[:, None] * (_MIDDLES[runners] - points)
    return points


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
    kept: Numbers = order[np.arange(len(order)) - np.repeat(fresh, sizes) < most]
    return kept


def pieces(counts: Numbers, most: int) -> Iterator[slice]:
    """Yield which clips to work on at a time: about `most` of their (C,) rows, one at least."""
    full = np.cumsum(counts) // most
    edges = np.flatnonzero(np.diff(full, prepend=-1, append=-1))
    yield from (slice(*pair) for pair in pairwise(edges.tolist()))
