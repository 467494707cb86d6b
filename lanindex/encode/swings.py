"""From where to where something goes that is turned, or leans.

Source: ``encode/BODY.md``, "Swings".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import PLACE
from lanindex.encode.arithmetic import runs
from lanindex.encode.limbs import smooth, window
from lanindex.encode.profile import Profile
from lanindex.encode.steps import Event
from lanindex.encode.ways import BRIEF, PAUSE

Angles = NDArray[np.complex128]
Floats = NDArray[np.float64]

MOVED = 15.0
"""Degrees: what goes no farther has not moved."""

SLOW = 3.0
"""Degrees a second: slower, a move has not begun, or has ended."""

STEADY = 0.15
"""Seconds that angles are averaged over where it is told how fast they change."""


def swings(angles: Angles, profile: Profile) -> list[tuple[int, int]]:
    """Return from which frame to which angles go somewhere.

    Parameters
    ----------
    angles : ndarray
        (N,) complex128, degrees: how far something is turned, or how far forward (the imaginary
        part) and to the right it leans.
    profile : Profile
        For the rate.

    Examples
    --------
    >>> import numpy as np
    >>> import lanindex
    >>> from lanindex.encode.swings import swings
    >>> there = np.clip(np.arange(120) - 30.0, 0, 40) + 0j  # 40 degrees in 40 frames of 60
    >>> swings(there, lanindex.load_profile())
    [(26, 75)]
    """
    rate = float(profile.rate)
    if len(angles) < 2:
        return []
    both = np.stack((angles.real, angles.imag), axis=1)
    calm = smooth(both[None], window(STEADY, profile.rate))[0]
    pace = np.hypot(*(np.gradient(calm, axis=0) * rate).T)
    found = []
    for first, last in _ways(angles):
        own = pace[first : last + 1]
        parts = _parts(angles[first : last + 1], own, round(BRIEF * rate))
        before = [0, *(stop for _, stop in parts)]
        behind = [*(start for start, _ in parts[1:]), len(own) - 1]
        for part, low, high in zip(parts, before, behind, strict=False):
            start, stop = _seen(own, part, low, high)
            found.append((first + start, first + stop))
    return found


def _ways(angles: Angles) -> list[tuple[int, int]]:
    """Return from where to where angles go away, less than `MOVED` back not counted."""
    found, anchor, best = list[tuple[int, int]](), 0, 0
    here = far = complex(angles[0])
    reach = 0.0
    for frame, angle in enumerate(angles.tolist()):
        away = abs(angle - here)
        if away >= reach:
            best, far, reach = frame, angle, away
        elif abs(angle - far) >= MOVED:
            if reach >= MOVED:
                found.append((anchor, best))
            anchor, here = best, far
            best, far, reach = frame, angle, abs(angle - here)
    return [*found, (anchor, best)] if reach >= MOVED else found


def _parts(angles: Angles, pace: Floats, least: int) -> list[tuple[int, int]]:
    """Part a way where it rests, in parts that are long enough; both frames are included."""
    rests = [(a, b) for a, b in runs(pace < PAUSE) if b - a >= least]
    edges = [0, *(edge for rest in rests for edge in rest), len(pace)]
    found, begin = list[tuple[int, int]](), -1
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        if stop > start:
            begin = start if begin < 0 else begin
            if abs(angles[stop - 1] - angles[begin]) >= MOVED:
                found.append((begin, stop - 1))
                begin = -1
    return found or [(0, len(pace) - 1)]


def _seen(pace: Floats, part: tuple[int, int], low: int, high: int) -> tuple[int, int]:
    """Return when a part is seen to begin, and to end, between two frames."""
    peak = pace[part[0] : part[1] + 1].max()
    quick = np.flatnonzero(pace[part[0] : part[1] + 1] >= peak / 4) + part[0]
    before = np.flatnonzero(pace[low : quick[0]] <= SLOW) + low
    behind = np.flatnonzero(pace[quick[-1] + 1 : high + 1] <= SLOW) + quick[-1] + 1
    first = int(before[-1]) + 1 if len(before) else low
    last = int(behind[0]) if len(behind) else high
    return first, max(last, first + 1)


def arrivals(
    angles: Angles, away: float, profile: Profile, eighths: bool
) -> tuple[Event, list[Event]]:
    """Return where angles are at first, and where they go.

    Parameters
    ----------
    angles : ndarray
        (N,) complex128, as for `swings`; one at least.
    away : float
        Degrees: what is nearer to nothing is in place.
    profile : Profile
        For the rate.
    eighths : bool
        Whether their directions are eight, not right and left alone.
    """
    begun = _there(angles, 0, 0, away, eighths)
    found, now = list[Event](), begun.direction
    for start, stop in swings(angles, profile):
        one = _there(angles, start, min(stop, len(angles) - 1), away, eighths)
        if one.direction != PLACE or now != PLACE:
            found.append(one)
            now = one.direction
    return begun, found


def _there(angles: Angles, start: int, stop: int, away: float, eighths: bool) -> Event:
    """Return what says where angles have arrived."""
    angle = complex(angles[stop])
    size = abs(angle)
    if size < away:
        return Event(start, stop, PLACE, -1, 1 - size / away, amount=0)
    step = 45 if eighths else 180
    azimuth = float(np.degrees(np.angle(angle)))
    code = round(azimuth / step) % (360 // step)
    off = abs((azimuth - step * code + 180) % 360 - 180)
    margin = min(size / away - 1, 1 - off / (step / 2), 1.0)
    return Event(start, stop, code * step // 45, -1, margin, amount=round(size))
