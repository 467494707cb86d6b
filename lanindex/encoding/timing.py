"""Stage 6: from resampled frames to frames of the source and ticks of the score.

Source: ``encoding/METHOD.md``, stage 6; Matsumoto and Hachimura (2001), 4.7.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.model import Meter, Span
from lanindex.notation.beats import Beats, ticks_at

Rows = NDArray[Any]
IntArray = NDArray[np.int64]

FINEST = 1 << 16
"""Ticks in a unit beyond which the grid is not refined."""

TOGETHER = 1 << 16
"""Rows whose ticks are worked out together: some 10 MB."""


def to_source(
    rows: Rows, counts: Sequence[int], known: Sequence[Span], rate: Fraction, target: Fraction
) -> None:
    """Replace resampled frames by frames of the source, in place.

    Every row but the first of a track then has a frame at least, none overlap, and a passing row
    lies inside the row after it. Where a stretch has fewer frames than symbols, the first of them
    become passing.

    `rows` (S,) of `model.SYMBOL`, track by track in order of time, start and stop in resampled
    frames; the first of each is its starting position.
    """
    owner, ends = np.arange(len(counts)).repeat(counts), np.cumsum(counts)
    first = ends - counts
    low, high = np.array([(one.start, one.stop) for one in known], np.int64).T
    step = rate / target
    frames = np.array((rows["start"], rows["stop"]), np.int64)
    borders = -(-frames * step.numerator // step.denominator)
    borders = np.minimum(np.maximum(borders, low[owner]), high[owner])
    borders[:, first] = low
    passing, later = rows["passing"], np.ones(len(rows), np.bool_)
    later[first] = False
    shown = np.flatnonzero(later & ~passing)
    many = np.bincount(owner[shown], minlength=len(counts))
    surplus = np.maximum(many - (high - low), 0)
    over = _places(many) < surplus[owner[shown]]
    passing[shown[over]] = True
    shown, many = shown[~over], many - surplus
    begin, end = low[owner[shown]], high[owner[shown]]
    starts, stops = _apart(borders[:, shown] - begin, many) + begin
    stops = np.minimum(stops, end - (many[owner[shown]] - 1 - _places(many)))
    borders[:, shown] = np.minimum(starts, stops - 1), stops
    if len(gone := np.flatnonzero(later & passing)):
        outer = np.union1d(shown, ends - 1)
        outer = outer[np.searchsorted(outer, gone)]
        borders[:, gone] = _nested(borders[:, gone], *borders[:, outer])
    rows["start"], rows["stop"] = borders


def _nested(spans: IntArray, low: IntArray, high: IntArray) -> IntArray:
    """Lay each span inside another, so that it has a frame; (2, S)."""
    starts = np.minimum(np.maximum(spans[0], low), high - 1)
    return np.array((starts, np.minimum(np.maximum(spans[1], starts + 1), high)))


def _apart(spans: IntArray, counts: IntArray) -> IntArray:
    """Give every span room of one at least, from 0 on and behind those before it on its track.

    Spans are (2, S), track by track, of which `counts` tells how many each has.
    """
    place = _places(counts)
    least = np.maximum(np.maximum(spans[1], spans[0] + 1) - place, 1)
    over = np.arange(len(counts)).repeat(counts) * least.max(initial=0)  # no track reaches the next
    free = np.maximum.accumulate(least + over) - over + place
    before = np.append(0, free[:-1])
    before[place == 0] = 0
    return np.array((np.maximum(spans[0], before), free))


def _places(counts: IntArray) -> IntArray:
    """Return how many come before each on its own track: (S,)."""
    begins = np.cumsum(counts) - counts
    places: IntArray = np.arange(counts.sum()) - begins.repeat(counts)
    return places


def quantise(
    tracks: Iterable[Rows], frames: int, rate: Fraction, meter: Meter, beats: Beats | None = None
) -> Meter:
    """Round the borders of all symbols to the score's grid, in place.

    `tracks` (S,) of `model.SYMBOL` each, start and stop in source frames; ``tick`` and ``ticks``
    are filled.
    """
    few = list(_few(tracks))
    last = np.array([frames])
    while True:
        end = int(ticks_at(last, meter, rate, beats, up=True)[0])
        behind = max((_tick(some, meter, rate, beats) for some in few), default=0)
        if meter.division >= FINEST or behind <= end:
            return meter
        meter = replace(meter, division=meter.division * 2)


def _few(tracks: Iterable[Rows]) -> Iterator[list[Rows]]:
    """Yield the tracks of a score, as many at a time as have rows enough to be worth it."""
    some = list[Rows]()
    for rows in tracks:
        some.append(rows)
        if sum(map(len, some)) > TOGETHER:
            yield some
            some = []
    if some:
        yield some


def _tick(tracks: Sequence[Rows], meter: Meter, rate: Fraction, beats: Beats | None) -> int:
    """Write the ticks of some tracks; return the last one of all."""
    starts, stops, passing = (
        np.concatenate([rows[name] for rows in tracks]) for name in ("start", "stop", "passing")
    )
    owner = np.arange(len(tracks)).repeat(list(map(len, tracks)))
    shown = np.flatnonzero((starts != stops) & ~passing)
    ticks = ticks_at(np.array((starts, stops), np.int64), meter, rate, beats)
    ticks[:, shown] = _apart(ticks[:, shown], np.bincount(owner[shown], minlength=len(tracks)))
    last = int(ticks[1, shown].max(initial=0))
    ticks[1] -= ticks[0]
    ticks[0, (starts == 0) & (stops == 0)] = 0  # unit 1 may begin before the capture does
    first = 0
    for rows in tracks:
        rows["tick"], rows["ticks"] = ticks[:, first : first + len(rows)]
        first += len(rows)
    return last
