"""From where to where something goes that is turned, or leans.

Source: ``encoding/BODY.md``, "Swings".
"""

from __future__ import annotations

import math
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import PLACE
from lanindex.encoding.arithmetic import blocks, window
from lanindex.encoding.curves import departures, lulls, mean
from lanindex.encoding.events import Event, table
from lanindex.encoding.onset import seen
from lanindex.encoding.profile import Profile
from lanindex.encoding.ways import BRIEF, PAUSE

Angles = NDArray[np.complex128]
Floats = NDArray[np.float64]

MOVED = 15.0
"""Degrees: what goes no farther has not moved."""

STEADY = 0.15
"""Seconds that angles are averaged over where it is told how fast they change."""


def swings(angles: Angles, profile: Profile) -> list[tuple[int, int]]:
    """Return from which frame to which angles go somewhere.

    `angles` (N,) complex128, degrees: how far something is turned, or how far forward (the
    imaginary part) and to the right it leans.
    """
    rate, width = float(profile.rate), window(STEADY, profile.rate)
    if len(angles) < 2:
        return []
    pace = np.empty(len(angles))
    for block in blocks(len(angles), width // 2 + 1):
        some = angles[block.outer]
        aside, ahead = np.gradient(mean(np.array((some.real, some.imag)), width), axis=1)
        pace[block.inner] = np.hypot(aside * rate, ahead * rate)[block.within]
    found = []
    for first, last in departures(angles, MOVED):
        parts = _parts(angles, pace, first, last, round(BRIEF * rate))
        before = [first, *(stop for _, stop in parts)]
        behind = [*(start for start, _ in parts[1:]), last]
        for part, low, high in zip(parts, before, behind, strict=False):
            found.append(seen(angles, pace, part, (low, high), PAUSE / rate))
    return found


def _parts(
    angles: Angles, pace: Floats, first: int, last: int, least: int
) -> list[tuple[int, int]]:
    """Part a way where it rests, in parts that are long enough; both frames are included."""
    rests = lulls(pace[first : last + 1], PAUSE, least)
    edges = [first, *(first + edge for edge in chain(*rests)), last + 1]
    found, begin = list[tuple[int, int]](), -1
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        if stop > start:
            begin = start if begin < 0 else begin
            if abs(angles[stop - 1] - angles[begin]) >= MOVED:
                found.append((begin, stop - 1))
                begin = -1
    return found or [(first, last)]


def arrivals(angles: Angles, away: float, profile: Profile, eighths: bool) -> Floats:
    """Return where angles are at first, and where they go: as from `events.table`.

    `angles` (N,) complex128, as for `swings`; one at least.
    """
    found = [_there(angles, 0, 0, away, eighths)]
    for start, stop in swings(angles, profile):
        one = _there(angles, start, min(stop, len(angles) - 1), away, eighths)
        if one.direction != PLACE or found[-1].direction != PLACE:
            found.append(one)
    return table(found)


def _there(angles: Angles, start: int, stop: int, away: float, eighths: bool) -> Event:
    """Return what says where angles have arrived."""
    angle = complex(angles[stop])
    size = abs(angle)
    if size < away:
        return Event(start, stop, PLACE, -1, 1 - size / away, amount=0)
    step = 45 if eighths else 180
    azimuth = math.degrees(math.atan2(angle.imag, angle.real))
    code = round(azimuth / step) % (360 // step)
    off = abs((azimuth - step * code + 180) % 360 - 180)
    margin = min(size / away - 1, 1 - off / (step / 2), 1.0)
    return Event(start, stop, code * step // 45, -1, margin, amount=round(size))
