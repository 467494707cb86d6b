"""Stage 6: from resampled frames to frames of the source and ticks of the score.

Source: ``encode/METHOD.md``, stage 6; Matsumoto and Hachimura (2001), 4.7.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.model import Meter, Span
from lanindex.notation.beats import Beats, ticks_at

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

    Examples
    --------
    >>> from fractions import Fraction
    >>> from lanindex.encode.timing import to_source
    >>> from lanindex.model import Span
    >>> from lanindex.model.symbol import blank
    >>> rows = blank(2)
    >>> rows["start"], rows["stop"] = [0, 31], [0, 53]  # a starting position, a symbol
    >>> seen = to_source(rows, Span(0, 30), Fraction(30), Fraction(60))
    >>> seen["start"], seen["stop"]
    (array([ 0, 16], dtype=int32), array([ 0, 27], dtype=int32))
    """
    rows = rows.copy()
    step = rate / target
    frames = np.array((rows["start"], rows["stop"]), np.int64)
    borders = -(-frames * step.numerator // step.denominator)
    starts, stops = np.clip(borders, known.start, known.stop).tolist()
    starts[0] = stops[0] = known.start
    passing = rows["passing"].tolist()
    shown = [index for index, gone in enumerate(passing) if index and not gone]
    surplus = max(len(shown) - len(known), 0)
    for index in shown[:surplus]:
        passing[index] = True
    _spread(starts, stops, shown[surplus:], known)
    _nest(starts, stops, passing)
    rows["start"], rows["stop"], rows["passing"] = starts, stops, passing
    return rows


def _spread(starts: list[int], stops: list[int], shown: list[int], known: Span) -> None:
    """Give every shown symbol a frame: of the next one, at the end of the previous ones."""
    free = known.start
    for index in shown:
        starts[index] = max(starts[index], free)
        stops[index] = free = max(stops[index], starts[index] + 1)
    limit = known.stop
    for index in reversed(shown):
        if stops[index] <= limit:
            break
        stops[index] = limit
        starts[index] = limit = min(starts[index], limit - 1)


def _nest(starts: list[int], stops: list[int], passing: list[bool]) -> None:
    """Lay each passing row inside the shown row that follows it."""
    outer = len(passing) - 1
    for index in range(len(passing) - 1, 0, -1):
        if not passing[index]:
            outer = index
            continue
        low, high = starts[outer], stops[outer]
        starts[index] = min(max(starts[index], low), high - 1)
        stops[index] = min(max(stops[index], starts[index] + 1), high)


def quantise(
    tracks: Iterable[Rows], frames: int, rate: Fraction, meter: Meter, beats: Beats | None = None
) -> Meter:
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
    beats : Beats, optional
        When each beat comes; else as evenly as the meter says.

    Returns
    -------
    Meter
        The grid that was used: as wanted, or finer by a power of two where a symbol found no
        room. Each symbol has a tick at least; they neither overlap nor get lost.

    Examples
    --------
    >>> from fractions import Fraction
    >>> from lanindex.encode.timing import quantise
    >>> from lanindex.model import Meter
    >>> from lanindex.model.symbol import blank
    >>> rows = blank(2)
    >>> rows["start"], rows["stop"] = [0, 31], [0, 53]  # a starting position, a symbol
    >>> meter = quantise([rows], 60, Fraction(30), Meter())
    >>> meter.division, rows["tick"], rows["ticks"]
    (32, array([0, 8], dtype=int32), array([0, 6], dtype=int32))
    """
    tracks = list(tracks)
    while not all([_fits(rows, frames, rate, meter, beats) for rows in tracks]):
        if meter.division >= FINEST:
            break
        meter = replace(meter, division=meter.division * 2)
    return meter


def _fits(rows: Rows, frames: int, rate: Fraction, meter: Meter, beats: Beats | None) -> bool:
    last = int(ticks_at(np.array([frames]), meter, rate, beats, up=True)[0])
    borders = np.array((rows["start"], rows["stop"]), np.int64)
    starts, stops = ticks_at(borders, meter, rate, beats).tolist()
    free = 0
    lone = (rows["start"] == rows["stop"]) | rows["passing"]
    for index in np.flatnonzero(~lone).tolist():
        starts[index] = max(starts[index], free)
        stops[index] = free = max(stops[index], starts[index] + 1)
    rows["tick"] = starts
    rows["ticks"] = np.subtract(stops, starts)
    first = (rows["start"] == 0) & (rows["stop"] == 0)
    rows["tick"][first] = 0  # unit 1 may begin before the capture does
    return free <= last
