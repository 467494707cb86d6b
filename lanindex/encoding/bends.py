"""How far elbows and knees are bent, and when they bend and stretch.

Source: ``encoding/BODY.md``, "Bends".
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain, pairwise

import numpy as np

from lanindex.alphabet import SIXTHS
from lanindex.encoding.arithmetic import Floats, window
from lanindex.encoding.curves import lulls, mean, swings
from lanindex.encoding.events import Event, table
from lanindex.encoding.onset import seen
from lanindex.encoding.profile import Profile
from lanindex.model.derived import DEGREE, bending, stretching

SWING = 20.0
"""Degrees of angle: less is no bend, and no farther from the middle of a degree is still that."""

CALM = 0.15
"""Seconds that an angle is averaged over where its pace is looked at."""

IDLES = 20.0
"""Degrees of angle a second: slower, for as long as `LULL`, parts two bends."""

LULL = 0.25
"""Seconds that a joint is slow for where it rests."""

Ends = tuple[int, int]


def found(angles: Floats, profile: Profile) -> list[Floats]:
    """Return the symbols of curves.

    `angles` (P, N) float64, degrees from straight; returned (P), as from `events.table`: the degree
    at the beginning, and the bends.
    """
    calm = mean(angles, window(CALM, profile.rate))
    short = angles.shape[1] < 2
    pace = np.zeros(angles.shape) if short else np.gradient(calm, axis=1) * float(profile.rate)
    return [table(_found(*curves, profile)) for curves in zip(angles, calm, pace, strict=True)]


def _found(angle: Floats, calm: Floats, pace: Floats, profile: Profile) -> list[Event]:
    degree = min(round(calm[0] / DEGREE), SIXTHS)
    found = [_event(0, 0, bending(degree), float(calm[0]), degree)]
    fast = np.abs(pace)
    least = round(LULL * profile.rate)
    for first, last in swings(calm, SWING):
        if abs(calm[last] - calm[first]) < SWING:
            continue
        way = 1 if calm[last] > calm[first] else -1
        for part, within in _pieces(way * pace[first : last + 1], first, least):
            arrived = float(angle[part[1]])
            if way * (arrived - DEGREE * degree) <= SWING:
                continue
            degree = min(round(arrived / DEGREE), SIXTHS)
            amount = bending(degree) if way > 0 else stretching(degree)
            begin, end = seen(angle, fast, part, within, IDLES / float(profile.rate))
            found.append(_event(begin, end, amount, arrived, degree))
    return found


def _event(start: int, stop: int, amount: int, angle: float, degree: int) -> Event:
    off = abs(angle / DEGREE - degree)
    return Event(start, stop, -1, -1, max(1 - 2 * off, 0.0), amount=amount)


def _pieces(pace: Floats, first: int, least: int) -> Iterator[tuple[Ends, Ends]]:
    """Part a swing where it rests or gives way: what moves, and what may go on slowly between.

    Beside the first and the last frame of each are those that its borders lie between: what moves
    may have begun in the rest before, and end in the one behind.
    """
    last = first + len(pace) - 1
    slow = lulls(pace, IDLES, least)
    rests = ((first + start, min(first + stop, last)) for start, stop in slow)
    edges = [first, first, *chain(*rests), last, last]
    for number, part in enumerate(pairwise(edges[1:-1])):
        if part[0] < part[1]:
            yield part, part if number % 2 else (edges[number], edges[number + 3])
