"""Symbols of many clips, laid out as points and times for comparing.

A symbol is the point that it leads to on a sphere about the joint it is seen from: the middle of
its cell, drawn towards the cell across the nearest border the less clearly it lies in its own
(half-way at the border). `place low` and `place high` are the poles, `place mid` is the centre. So
neighbouring cells are near each other, opposite ones far apart, and what lies on a border is near
to both sides.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTIONS, LEVELS, PLACE
from lanindex.model.columns import PASSING, THOUSANDTHS, Columns, codes_of

Floats = NDArray[np.float32]
Numbers = NDArray[np.int64]

STEP = 0.25
"""What every movement costs that one clip has and the other has not, beside how far it goes."""

SWING = 0.2
"""What a swing costs: a move out and back within one cell."""

BRIEFEST = 1 / 60
"""Seconds that a movement takes at least."""


def _points() -> Floats:
    points = np.zeros((len(DIRECTIONS), len(LEVELS), 3), np.float32)
    azimuth = np.radians(45.0 * np.arange(PLACE))[:, None]
    elevation = np.radians(45.0 * (1 + np.arange(len(LEVELS))))
    points[:PLACE, :, 0] = np.sin(elevation) * np.cos(azimuth)
    points[:PLACE, :, 1] = -np.cos(elevation)
    points[:PLACE, :, 2] = np.sin(elevation) * np.sin(azimuth)
    points[PLACE, :, 1] = np.arange(len(LEVELS)) - 1
    return points


POINTS = _points()
"""Where each cell has its middle: (9, 3, 3), by direction and level, x right, y up, z forward."""


@dataclass(frozen=True, slots=True)
class Moves:
    """Rows of symbols, those that a score shows.

    Attributes
    ----------
    points : ndarray
        (N, 3) float32, where each leads to.
    sizes : ndarray
        (N,) float32, what it costs that the other clip has not: `STEP`, how far it goes, and its
        swings; of a starting position the swings alone.
    paces : ndarray
        (N,) float32, the logarithm of its seconds.
    swings : ndarray
        (N,) float32, what its swings cost.
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

    def some(self, rows: slice | Numbers) -> Moves:
        """Return some rows."""
        return Moves(*(getattr(self, name)[rows] for name in _COLUMNS))


_COLUMNS = ("points", "sizes", "paces", "swings", "starts", "stops", "rows")


def _moves(
    rows: NDArray[Any], lengths: Numbers, rates: NDArray[np.float64]
) -> tuple[Moves, Numbers]:
    """Return the movements of one part in several clips, and how many rows each has."""
    kept = _shown(rows)
    ends = np.cumsum(lengths)
    counts = np.diff(np.searchsorted(kept, ends), prepend=0)
    shown = rows[kept]
    kept = kept - np.repeat(ends - lengths, counts)
    starts, stops = shown["start"].astype(np.int64), shown["stop"].astype(np.int64)
    seconds = (stops - starts) / np.repeat(rates, counts)
    paces = np.log(np.maximum(seconds, BRIEFEST)).astype(np.float32)
    swings = np.zeros(len(shown), np.float32)
    if "swings" in (rows.dtype.names or ()):
        swings += np.float32(SWING) * shown["swings"]
    points = _placed(shown)
    way = np.sqrt(np.square(np.diff(points, axis=0, prepend=points[:1])).sum(axis=1))
    moving = starts < stops
    moving[(np.cumsum(counts) - counts)[counts > 0]] = False
    sizes = swings + np.where(moving, np.float32(STEP) + way, np.float32(0))
    return Moves(points, sizes, paces, swings, starts, stops, kept), counts


def _shown(rows: NDArray[Any]) -> Numbers:
    """Return which rows a score shows: what is merely passed is left out."""
    passing = "passing" in (rows.dtype.names or ())
    return np.flatnonzero(~rows["passing"]) if passing else np.arange(len(rows))


def _placed(rows: NDArray[Any]) -> Floats:
    """Return where symbols lead to; one without direction or level leads to the centre."""
    told = (rows["direction"] >= 0) & (rows["level"] >= 0)
    cells = POINTS[rows["direction"], rows["level"]]
    points: Floats = np.where(told[:, None], cells, np.float32(0))
    if "runner_direction" in (rows.dtype.names or ()):
        near = (rows["runner_direction"] >= 0) & (rows["runner_level"] >= 0) & told
        share = np.where(near, 0.5 * (1.0 - np.clip(rows["margin"], 0.0, 1.0)), 0.0)
        towards = POINTS[rows["runner_direction"], rows["runner_level"]] - points
        points += share[:, None].astype(np.float32) * towards
    return points


@dataclass(frozen=True, slots=True)
class Clips:
    """Many clips: the movements of a part in all of them, then those of the next part.

    Attributes
    ----------
    parts : tuple of str
        In order.
    moves : Moves
        All rows.
    first : ndarray
        (P, C + 1), the row with which each clip's part begins, where it is before it first moves;
        two equal ones in a row where a clip lacks the part.
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

    def windows(self, clip: int, begins: Numbers, ends: Numbers) -> Windows:
        """Return stretches of one clip.

        Parameters
        ----------
        clip : int
            Which.
        begins, ends : ndarray
            (B,) frames of its source, half-open: what arrives in them.
        """
        low = np.zeros((len(self.parts), len(begins)), np.int64)
        high = low.copy()
        for part, (first, last) in enumerate(self.first[:, clip : clip + 2]):
            stops = self.moves.stops[first:last]
            low[part] = first + np.maximum(np.searchsorted(stops, begins, "right") - 1, 0)
            high[part] = first + np.searchsorted(stops, ends, "right")
            high[part] = np.where(first < last, np.maximum(high[part], low[part] + 1), low[part])
        return Windows(low, high)

    def cut(self, clip: int, begin: int, end: int) -> Clips:
        """Return one stretch of one clip as a clip by itself."""
        window = self.windows(clip, np.array([begin]), np.array([end]))
        low, high = window.low[:, 0], window.high[:, 0]
        index = np.concatenate([np.arange(*pair) for pair in zip(low, high, strict=True)])
        ends = np.cumsum(high - low)
        moves = self.moves.some(index)
        begins = (ends - high + low)[high > low]
        moves.sizes[begins] = moves.swings[begins]
        return Clips(self.parts, moves, np.stack([ends - high + low, ends], axis=1))


@dataclass(frozen=True, slots=True)
class Windows:
    """Stretches of clips.

    Attributes
    ----------
    low, high : ndarray
        (P, B) rows of `Clips`, half-open, by part: the first is where the part is before; equal
        where it is not there.
    """

    low: Numbers
    high: Numbers

    def __len__(self) -> int:
        """Return the number of stretches."""
        return int(self.low.shape[1])

    def some(self, which: Numbers) -> Windows:
        """Return some of them."""
        return Windows(self.low[:, which], self.high[:, which])


def clips_of(
    tracks: Sequence[Mapping[str, NDArray[Any]]], rates: Sequence[float], parts: Sequence[str]
) -> Clips:
    """Return clips side by side.

    Parameters
    ----------
    tracks : sequence of Mapping of str to ndarray
        Of each clip its parts: (S,) rows with at least the fields direction, level, start and stop
        (codes, frames), by time, of which the first is where the part begins. Margin, runner-up
        and swings count where they are there; what is passing is left out.
    rates : sequence of float
        Of each clip: frames a second.
    parts : sequence of str
        Which parts, in order.
    """
    some = next((rows for clip in tracks for rows in clip.values()), np.zeros(0, _LEAST))[:0]
    found = []
    for part in parts:
        own = [clip.get(part, some) for clip in tracks]
        lengths = np.array([len(rows) for rows in own], np.int64)
        found.append(_moves(np.concatenate(own), lengths, np.array(rates, np.float64)))
    return _clips(parts, found)


def clips_in(
    columns: Mapping[str, Columns], rates: NDArray[np.float64], parts: Sequence[str]
) -> Clips:
    """Return the captures of columns side by side.

    Parameters
    ----------
    columns : Mapping of str to Columns
        By part, with their swings.
    rates : ndarray
        (C,) of each capture: frames a second.
    parts : sequence of str
        Which parts, in order.
    """
    every = (columns[part] for part in parts)
    return _clips(parts, [_moves(_rows(one), np.diff(one.bounds), rates) for one in every])


_ROW = [
    *(("direction", "i1"), ("level", "i1"), ("runner_direction", "i1"), ("runner_level", "i1")),
    *(("margin", "f4"), ("passing", "?"), ("start", "i4"), ("stop", "i4"), ("swings", "i4")),
]


def _rows(columns: Columns) -> NDArray[Any]:
    """Return columns as the rows that `clips_of` takes."""
    rows = np.empty(len(columns), _ROW)
    for name, cells in (("", columns.cell), ("runner_", columns.runner)):
        direction, level = codes_of(cells)
        rows[f"{name}direction"], rows[f"{name}level"] = direction, level
    rows["margin"] = columns.margin / THOUSANDTHS
    rows["passing"] = (columns.cell & PASSING) > 0
    rows["start"], rows["stop"] = columns.start, columns.stop
    rows["swings"] = 0 if columns.swings is None else columns.swings
    return rows


def _clips(parts: Sequence[str], found: Sequence[tuple[Moves, Numbers]]) -> Clips:
    counts = np.stack([counts for _, counts in found])
    return Clips(tuple(parts), _chained([moves for moves, _ in found]), _borders(counts))


_LEAST = [("direction", "i1"), ("level", "i1"), ("start", "i4"), ("stop", "i4")]


def _chained(pieces: Sequence[Moves]) -> Moves:
    columns = [np.concatenate([getattr(one, name) for one in pieces]) for name in _COLUMNS]
    return Moves(*columns)


def _borders(counts: Numbers) -> Numbers:
    """Return where each clip begins in each part, from (P, C) numbers of rows."""
    ends = np.concatenate([[0], np.cumsum(counts.ravel())])
    parts, clips = counts.shape
    borders: Numbers = ends[np.arange(parts)[:, None] * clips + np.arange(clips + 1)]
    return borders
