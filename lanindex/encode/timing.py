"""Stage 6: from resampled frames to frames of the source and ticks of the score.

Source: METHOD, "Rate and frames" and stage 6; the paper, 4.7.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.model import Meter, Span

Rows = NDArray[Any]

FINEST = 1 << 16
"""Ticks in a unit beyond which the grid is not refined."""


def to_source(rows: Rows, known: Span, rate: Fraction, target: Fraction) -> Rows:
    """Replace resampled frames by frames of the source.

    Parameters
    ----------
    rows : ndarray
        (S,) of `model.SYMBOL`, in order of time, start and stop in resampled frames; the first is
        the starting position.
    known : Span
        The stretch of the source that they belong to.
    rate, target : Fraction
        Frames a second of the source and of `rows`.

    Returns
    -------
    ndarray
        (S,) of `model.SYMBOL`: every row but the first has a frame at least, none overlap, and a
        passing row lies inside the row after it. Where the stretch has fewer frames than symbols,
        the first of them become passing.
    """
    rows = rows.copy()
    step = rate / target
    for name in ("start", "stop"):
        borders = -(-rows[name].astype(np.int64) * step.numerator // step.denominator)
        rows[name] = np.clip(borders, known.start, known.stop)
    rows[:1]["start"] = rows[:1]["stop"] = known.start
    _thin(rows, len(known))
    _spread(rows, known)
    _nest(rows)
    return rows


def _shown(rows: Rows) -> NDArray[np.int64]:
    return np.flatnonzero(~rows["passing"])[1:]


def _thin(rows: Rows, frames: int) -> None:
    surplus = len(_shown(rows)) - frames
    if surplus > 0:
        rows["passing"][_shown(rows)[:surplus]] = True


def _spread(rows: Rows, known: Span) -> None:
    """Give every shown symbol a frame: of the next one, at the end of the previous ones."""
    shown = _shown(rows).tolist()
    free = known.start
    for index in shown:
        start = max(int(rows["start"][index]), free)
        free = max(int(rows["stop"][index]), start + 1)
        rows["start"][index], rows["stop"][index] = start, free
    limit = known.stop
    for index in reversed(shown):
        if rows["stop"][index] <= limit:
            break
        rows["stop"][index] = limit
        rows["start"][index] = limit = min(int(rows["start"][index]), limit - 1)


def _nest(rows: Rows) -> None:
    """Lay each passing row inside the shown row that follows it."""
    outer = len(rows) - 1
    for index in range(len(rows) - 1, 0, -1):
        if not rows["passing"][index]:
            outer = index
            continue
        low, high = int(rows["start"][outer]), int(rows["stop"][outer])
        start = min(max(int(rows["start"][index]), low), high - 1)
        rows["start"][index] = start
        rows["stop"][index] = min(max(int(rows["stop"][index]), start + 1), high)


def quantise(tracks: Iterable[Rows], frames: int, rate: Fraction, meter: Meter) -> Meter:
    """Round the borders of all symbols to the score's grid, in place.

    Parameters
    ----------
    tracks : iterable of ndarray
        (S,) of `model.SYMBOL` each, start and stop in source frames; ``tick`` and ``ticks`` are
        filled.
    frames : int
        Length of the source.
    rate : Fraction
        Frames a second.
    meter : Meter
        The grid that is wanted.

    Returns
    -------
    Meter
        The grid that was used: as wanted, or finer by a power of two where a symbol found no
        room. Each symbol has a tick at least; they neither overlap nor get lost.
    """
    tracks = list(tracks)
    while not all(_fits(rows, frames, rate, meter) for rows in tracks):
        if meter.division >= FINEST:
            break
        meter = replace(meter, division=meter.division * 2)
    return meter


def _fits(rows: Rows, frames: int, rate: Fraction, meter: Meter) -> bool:
    scale = meter.tick_rate / rate
    last = -(-frames * scale.numerator // scale.denominator)
    ticks = {}
    for name in ("start", "stop"):
        doubled = 2 * rows[name].astype(np.int64) * scale.numerator
        ticks[name] = (doubled + scale.denominator) // (2 * scale.denominator)
    free = 0
    starts, stops = ticks["start"].tolist(), ticks["stop"].tolist()
    lone = (rows["start"] == rows["stop"]) | rows["passing"]
    for index in np.flatnonzero(~lone).tolist():
        starts[index] = max(starts[index], free)
        stops[index] = free = max(stops[index], starts[index] + 1)
    rows["tick"] = starts
    rows["ticks"] = np.subtract(stops, starts)
    return free <= last
