"""Reaches: how a part gets from one direction to the next.

Directions are unit vectors of the body frame: forward +x, up +y, right +z.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import LOW, MID, PLACE
from lanindex.model.bends import DEGREE, degree_of

Floats = NDArray[np.float64]
Cell = tuple[int, int]

FORWARD = np.array([1.0, 0.0, 0.0])
UP = np.array([0.0, 1.0, 0.0])
FOLDED: Cell = (PLACE, MID)


def direction(cell: Cell) -> Floats:
    """Return the reference direction of a cell other than `FOLDED`.

    returns (3,) unit vector.
    """
    code, level = cell
    if code == PLACE:
        return -UP if level == LOW else UP
    azimuth, elevation = np.radians(45.0 * code), np.radians(45.0 * (level + 1))
    flat = np.sin(elevation)
    return np.array([flat * np.sin(azimuth), -np.cos(elevation), flat * np.cos(azimuth)])


def minimum_jerk(share: Floats) -> Floats:
    """Return how much of a reach is done after a share of its time.

    `share`: (T,) float64, 0 to 1; returns (T,) float64, 0 to 1, at rest at both ends.
    """
    return share**3 * (10 - 15 * share + 6 * share**2)


def great_circle(start: Floats, stop: Floats, share: Floats, side: Floats) -> Floats:
    """Return directions along the shorter great circle between two.

    Half-way round there is no shorter one: that reach passes in front of the body, and from
    front to back past `side`.

    `start, stop`: (..., 3) unit vectors; `share`: (T,) 0 at `start`, 1 at `stop`; `side`: (3,) unit
    vector; returns (T, 3) unit vectors.
    """
    along = float(start @ stop)
    across = stop - along * start
    angle = np.arctan2(np.linalg.norm(across), along)
    if np.linalg.norm(across) < 1e-9:
        across = FORWARD - (FORWARD @ start) * start
        if np.linalg.norm(across) < 1e-9:
            across = side
    turn = share[:, None] * angle
    points: Floats = np.cos(turn) * start + np.sin(turn) * (across / np.linalg.norm(across))
    return points


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """A stretch of frames in which a part goes from one cell to another, or stays."""

    frames: slice  # Of the performance
    start: Cell  # Cells
    stop: Cell
    share: Floats  # (T,) how much is done in each of the frames


def reaches(rows: NDArray[Any], times: Floats, rate: Fraction, rest: Cell) -> Iterator[Reach]:
    """Yield what a track asks for, frame after frame.

    `rows`: (S,) of `model.SYMBOL`; `times`: (T,) seconds of the frames.
    """
    now, done = rest, 0
    for row in rows[~rows["passing"]]:
        cell = int(row["direction"]), int(row["level"])
        start, stop = float(row["start"] / rate), float(row["stop"] / rate)
        begin, end = np.searchsorted(times, [start - 1e-9, stop - 1e-9])
        yield Reach(slice(done, begin), now, now, np.zeros(begin - done))
        share = (
            minimum_jerk((times[begin:end] - start) / (stop - start)) if end > begin else times[:0]
        )
        yield Reach(slice(begin, end), now, cell, share)
        now, done = cell, int(end)
    yield Reach(slice(done, len(times)), now, now, np.zeros(len(times) - done))


def bent(rows: NDArray[Any], times: Floats, rate: Fraction) -> Floats:
    """Return how much of its length a limb of two equal bones reaches that bends as told.

    `rows`: (S,) of `model.SYMBOL`, of the bends of an arm or a leg; `times`: (T,) seconds of the
    frames; returns (T,) 1 straight, 0 folded.
    """
    angle, now = np.zeros(len(times)), 0.0
    for row in rows[~rows["passing"]]:
        start, stop = float(row["start"] / rate), float(row["stop"] / rate)
        begin = int(np.searchsorted(times, start - 1e-9))
        then = np.radians(DEGREE * degree_of(int(row["amount"])))
        share = np.clip((times[begin:] - start) / max(stop - start, 1e-9), stop <= start, 1)
        angle[begin:] = now + (then - now) * minimum_jerk(share)
        now = then
    reach: Floats = np.cos(angle / 2)
    return reach
