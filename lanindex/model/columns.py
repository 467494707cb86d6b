"""Symbols as columns: what one part does in many captures, field by field.

A search over a whole library reads a few long arrays instead of millions of objects. The rows of
all captures follow each other; `Columns.bounds` tells where each capture's begin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lanindex.model.arrays import frozen
from lanindex.model.capture import Capture
from lanindex.model.score import Track

PASSING, STARTING = 1 << 6, 1 << 7
"""Flags of a cell: on the way only, and a starting position."""

CELL = PASSING - 1
"""The bits of a cell without its flags."""

THOUSANDTHS = 1000
"""A margin of 1."""


def cell_of(direction: int, level: int) -> int:
    """Return the cell of a direction and a level, -1 where there is none of them."""
    return (direction + 1) | (level + 1) << 4


@dataclass(frozen=True, slots=True, eq=False)
class Roster:
    """The captures that columns are of, in the order of their numbers.

    Attributes
    ----------
    number : ndarray
        (C,) int64, as in the library.
    frames : ndarray
        (C,) int32.
    rate : ndarray
        (C, 2) int64: frames a second, as a fraction.
    speed : ndarray
        (C, 2) int64: beats a minute, as a fraction.
    """

    number: NDArray[np.int64]
    frames: NDArray[np.int32]
    rate: NDArray[np.int64]
    speed: NDArray[np.int64]

    def __len__(self) -> int:
        """Return how many captures there are."""
        return len(self.number)

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        for name in ("number", "frames", "rate", "speed"):
            object.__setattr__(self, name, frozen(getattr(self, name)))


@dataclass(frozen=True, slots=True, eq=False)
class Columns:
    """The symbols of one part, in all captures of a roster.

    Attributes
    ----------
    part : str
        Whose.
    bounds : ndarray
        (C + 1,) int64: the rows of capture c are ``bounds[c]`` up to, not including,
        ``bounds[c + 1]``; none where it lacks the part.
    cell : ndarray
        (S,) uint8: as from `cell_of`, with the flags `PASSING` and `STARTING`.
    runner : ndarray
        (S,) uint8: the cell across the nearest border; 0: none known.
    margin : ndarray
        (S,) uint16, thousandths.
    start, stop : ndarray
        (S,) int32: frames of the source, half-open.
    gaps : ndarray
        (G, 3) int32, in order: capture, and a stretch of frames in which the part was seen.
        Captures that do not stand here are known from the first frame to the last.
    """

    part: str
    bounds: NDArray[np.int64]
    cell: NDArray[np.uint8]
    runner: NDArray[np.uint8]
    margin: NDArray[np.uint16]
    start: NDArray[np.int32]
    stop: NDArray[np.int32]
    gaps: NDArray[np.int32]

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        for name in ("bounds", "cell", "runner", "margin", "start", "stop", "gaps"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    def __len__(self) -> int:
        """Return how many symbols there are."""
        return len(self.cell)


def roster_of(captures: Sequence[Capture]) -> Roster:
    """Return the roster of some captures.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.model.columns import roster_of
    >>> with lanindex.open_library("dance.db") as library:
    ...     roster = roster_of(library.captures("*compass*"))
    >>> len(roster), roster.rate
    (1, array([[30,  1]]))
    """
    rates = [one.rate.as_integer_ratio() for one in captures]
    speeds = [one.meter.speed.as_integer_ratio() for one in captures]
    return Roster(
        np.array([one.id for one in captures], np.int64),
        np.array([one.frames for one in captures], np.int32),
        np.array(rates, np.int64).reshape(-1, 2),
        np.array(speeds, np.int64).reshape(-1, 2),
    )


def columns_of(part: str, captures: Sequence[Capture], tracks: Sequence[Track | None]) -> Columns:
    """Return the columns of a part.

    Parameters
    ----------
    part : str
        Whose.
    captures : sequence of Capture
        In the order of the roster.
    tracks : sequence of Track or None
        Of each capture; None where it lacks the part.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.model.columns import STARTING, cell_of, columns_of
    >>> with lanindex.open_library("dance.db") as library:
    ...     (capture, held), = library.tracks([library.capture("compass.bvh").id])
    >>> columns = columns_of("r_arm", [capture], [held["r_arm"]])
    >>> len(columns) == len(held["r_arm"]), int(columns.cell[0]) == cell_of(8, 0) | STARTING
    (True, True)
    """
    from lanindex.model.symbol import SYMBOL

    rows = [track.symbols if track else np.empty(0, SYMBOL) for track in tracks]
    symbols = np.concatenate([np.empty(0, SYMBOL), *rows], dtype=SYMBOL)
    gaps = [
        (number, span.start, span.stop)
        for number, (capture, track) in enumerate(zip(captures, tracks, strict=True))
        if track and [(it.start, it.stop) for it in track.known] != [(0, capture.frames)]
        for span in track.known
    ]
    cell = _cells(symbols["direction"], symbols["level"])
    cell |= np.where(symbols["passing"], np.uint8(PASSING), np.uint8(0))
    cell |= np.where(symbols["start"] == symbols["stop"], np.uint8(STARTING), np.uint8(0))
    return Columns(
        part,
        np.cumsum([0, *map(len, rows)], dtype=np.int64),
        cell,
        _cells(symbols["runner_direction"], symbols["runner_level"]),
        np.rint(symbols["margin"].astype(np.float64) * THOUSANDTHS).astype(np.uint16),
        symbols["start"].copy(),
        symbols["stop"].copy(),
        np.array(gaps, np.int32).reshape(-1, 3),
    )


def _cells(directions: NDArray[np.int8], levels: NDArray[np.int8]) -> NDArray[np.uint8]:
    cells: NDArray[np.uint8] = ((directions + 1) | (levels + 1) << 4).astype(np.uint8)
    return cells
