"""Symbols of many clips, laid out as points and times for comparing.

A symbol is the point that it leads to on a sphere about the joint it is seen from: the middle of
its cell, drawn towards the cell across the nearest border the less clearly it lies in its own
(half-way at the border). `place low` and `place high` are the poles, `place mid` is the centre. So
neighbouring cells are near each other, opposite ones far apart, and what lies on a border is near
to both sides.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTIONS, LEVELS, PLACE
from lanindex.model.columns import PASSING, THOUSANDTHS, Columns, codes_of, ranges

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

_MIDDLES: Floats = np.append(POINTS.reshape(-1, 3), np.zeros((1, 3), np.float32), axis=0)
_NOWHERE = len(_MIDDLES) - 1


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


Fields = Mapping[str, NDArray[Any]]
"""Rows of symbols, field by field: some of those of a score's symbols, by their names."""


def _moves(fields: Fields, lengths: Numbers, rates: NDArray[np.float64]) -> tuple[Moves, Numbers]:
    """Return the movements of one part in several clips, and how many rows each has."""
    kept = np.arange(lengths.sum())
    if "passing" in fields:  # a score does not show what is merely passed
        kept = np.flatnonzero(~fields["passing"])
    ends = np.cumsum(lengths)
    counts = np.diff(np.searchsorted(kept, ends), prepend=0)
    shown = {name: field[kept] for name, field in fields.items()}
    kept = kept - np.repeat(ends - lengths, counts)
    starts, stops = shown["start"].astype(np.int64), shown["stop"].astype(np.int64)
    seconds = (stops - starts) / np.repeat(rates, counts)
    paces = np.log(np.maximum(seconds, BRIEFEST)).astype(np.float32)
    swings = np.zeros(len(kept), np.float32)
    if "swings" in shown:
        swings += np.float32(SWING) * shown["swings"]
    points = _placed(shown)
    way = np.zeros(len(kept), np.float32)
    way[1:] = distances(points[1:].T, points[:-1].T)
    moving = starts < stops
    moving[(np.cumsum(counts) - counts)[counts > 0]] = False
    sizes = swings + np.where(moving, np.float32(STEP) + way, np.float32(0))
    return Moves(points, sizes, paces, swings, starts, stops, kept), counts


def distances(one: Floats, two: Floats) -> Floats:
    """Return how far points lie apart: (N,) from (3, N) of each side, coordinates first."""
    total = np.square(one[0] - two[0])
    total += np.square(one[1] - two[1])
    total += np.square(one[2] - two[2])
    return np.asarray(np.sqrt(total, out=total), np.float32)


def _placed(fields: Fields) -> Floats:
    """Return where symbols lead to; one without direction or level leads to the centre."""
    cells = _cells(fields, "")
    points = _MIDDLES[cells]
    if "runner_direction" in fields:
        runners = _cells(fields, "runner_")
        margin = np.clip(fields["margin"], 0.0, 1.0)
        share = np.where((runners < _NOWHERE) & (cells < _NOWHERE), 0.5 * (1.0 - margin), 0.0)
        points += share[:, None].astype(np.float32) * (_MIDDLES[runners] - points)
    return points


def _cells(fields: Fields, which: str) -> Numbers:
    """Return the places of cells in `_MIDDLES`; `_NOWHERE` without direction or level."""
    direction, level = fields[f"{which}direction"], fields[f"{which}level"]
    told = (direction >= 0) & (level >= 0)
    return np.where(told, direction.astype(np.int64) * len(LEVELS) + level, _NOWHERE)


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

    @property
    def counts(self) -> Numbers:
        """(C,) how many rows each clip has."""
        counts: Numbers = np.diff(self.first, axis=1).sum(axis=0)
        return counts

    def taken(self, order: Numbers) -> Clips:
        """Return some of the clips: (D,) which."""
        pieces = [ranges(borders[order], borders[order + 1]) for borders in self.first]
        rows = np.concatenate([rows for _, rows in pieces])
        counts = np.stack([np.diff(bounds) for bounds, _ in pieces])
        return Clips(self.parts, self.moves.some(rows), _borders(counts))

    def windows(self, clips: Numbers, begins: Numbers, ends: Numbers) -> Windows:
        """Return stretches of clips.

        Parameters
        ----------
        clips : ndarray
            (B,) which.
        begins, ends : ndarray
            (B,) frames of their sources, half-open: what arrives in them.
        """
        low = np.zeros((len(self.parts), len(clips)), np.int64)
        high = low.copy()
        if not len(clips):
            return Windows(low, high)
        some = slice(clips.min(), clips.max() + 2)
        far = max(self.moves.stops.max(initial=0), begins.max(), ends.max()) + 2
        for part, borders in enumerate(self.first):
            edges = borders[some]
            stops = self.moves.stops[edges[0] : edges[-1]]
            times = np.repeat(np.arange(len(edges) - 1) * far, np.diff(edges)) + stops
            base = (clips - some.start) * far
            first, last = borders[clips], borders[clips + 1]
            before = np.searchsorted(times, base + np.maximum(begins, -1), "right") - 1
            low[part] = np.maximum(edges[0] + before, first)
            high[part] = edges[0] + np.searchsorted(times, base + np.maximum(ends, -1), "right")
            high[part] = np.where(first < last, np.maximum(high[part], low[part] + 1), low[part])
        return Windows(low, high)

    def cut(self, clip: int, begin: int, end: int) -> Clips:
        """Return one stretch of one clip as a clip by itself."""
        window = self.windows(np.array([clip]), np.array([begin]), np.array([end]))
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
        rows = np.concatenate(own)
        fields = {name: rows[name] for name in _FIELDS if name in (rows.dtype.names or ())}
        found.append(_moves(fields, lengths, np.array(rates, np.float64)))
    return _clips(parts, found)


_LEAST = [("direction", "i1"), ("level", "i1"), ("start", "i4"), ("stop", "i4")]
_FIELDS = (
    *("direction", "level", "runner_direction", "runner_level"),
    *("margin", "passing", "start", "stop", "swings"),
)


@dataclass(frozen=True, slots=True)
class LazyClips:
    """The captures of columns, laid out when they are asked for, so that memory holds but few.

    Attributes
    ----------
    parts : tuple of str
        In order.
    columns : Mapping of str to Columns
        By part, with their swings.
    places : ndarray
        (C,) where each clip stands in the columns.
    rates : ndarray
        (C,) of each clip: frames a second.
    """

    parts: tuple[str, ...]
    columns: Mapping[str, Columns]
    places: Numbers
    rates: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of clips."""
        return len(self.places)

    @property
    def counts(self) -> Numbers:
        """(C,) how many rows each clip has, with those that are merely passed."""
        counts = np.zeros(len(self), np.int64)
        for part in self.parts:
            counts += np.diff(self.columns[part].bounds)[self.places]
        return counts

    def taken(self, order: Numbers, watch: Watch = unwatched) -> Clips:
        """Return some of the clips: (D,) which."""
        found = []
        for done, part in enumerate(self.parts):
            watch("parts", done, len(self.parts))
            own = self.columns[part].taken(self.places[order])
            found.append(_moves(_fields(own), np.diff(own.bounds), self.rates[order]))
        return _clips(self.parts, found)


def _fields(columns: Columns) -> Fields:
    """Return columns as the fields that a score's symbols have."""
    direction, level = codes_of(columns.cell)
    runner_direction, runner_level = codes_of(columns.runner)
    swings = np.zeros(len(columns), np.int32) if columns.swings is None else columns.swings
    return {
        "direction": direction,
        "level": level,
        "runner_direction": runner_direction,
        "runner_level": runner_level,
        "margin": (columns.margin / THOUSANDTHS).astype(np.float32),
        "passing": (columns.cell & PASSING) > 0,
        "start": columns.start,
        "stop": columns.stop,
        "swings": swings,
    }


def pieces(counts: Numbers, most: int) -> Iterator[slice]:
    """Yield which clips to work on at a time: as many as have so many rows, one at least.

    Parameters
    ----------
    counts : ndarray
        (C,) how many rows each clip has.
    most : int
        Rows, about.
    """
    full = np.cumsum(counts) // most
    edges = np.flatnonzero(np.diff(full, prepend=-1, append=-1))
    yield from (slice(*pair) for pair in pairwise(edges.tolist()))


def _clips(parts: Sequence[str], found: Sequence[tuple[Moves, Numbers]]) -> Clips:
    counts = np.stack([counts for _, counts in found])
    return Clips(tuple(parts), _chained([moves for moves, _ in found]), _borders(counts))


def _chained(pieces: Sequence[Moves]) -> Moves:
    columns = [np.concatenate([getattr(one, name) for one in pieces]) for name in _COLUMNS]
    return Moves(*columns)


def _borders(counts: Numbers) -> Numbers:
    """Return where each clip begins in each part, from (P, C) numbers of rows."""
    ends = np.concatenate([[0], np.cumsum(counts.ravel())])
    parts, clips = counts.shape
    borders: Numbers = ends[np.arange(parts)[:, None] * clips + np.arange(clips + 1)]
    return borders
