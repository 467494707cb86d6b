"""Where the body goes and how it turns.

Source: ``encode/BODY.md``, "Travel" and "Turns".
"""

from __future__ import annotations

from itertools import chain, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTION_CODES, PLACE
from lanindex.encode.arithmetic import held, unwrapped
from lanindex.encode.curves import lulls, mean, swings
from lanindex.encode.events import SECTOR, Event, table
from lanindex.encode.limbs import window
from lanindex.encode.onset import seen
from lanindex.encode.profile import Profile

Floats = NDArray[np.float64]

STRIDE = 1.0
"""Seconds that path and heading are averaged over: the sway of a stride is gone then."""

GOES, RESTS = 0.35, 0.2
"""Lengths of a leg a second: faster is travel; slower is none any more."""

BRIEF = 0.4
"""Seconds: what lasts shorter is part of what was before."""

TURNS = 30.0
"""Degrees: less is no turn."""

PAUSE = 10.0
"""Degrees a second: slower, for as long as `BRIEF`, parts two turns."""


def travel(way: Floats, front: Floats, leg: float, profile: Profile) -> Floats:
    """Return the stretches in which the body goes one way, or stays, as from `events.table`.

    Parameters
    ----------
    way : ndarray
        (N, 2) float64, mm: where the middle of the hips is over the ground.
    front : ndarray
        (N,) radians, the heading, averaged over `STRIDE`.
    leg : float
        Its length, mm.
    profile : Profile
        For the rate.

    Returns
    -------
    ndarray
        They fill the stretch.
    """
    rate = float(profile.rate)
    if len(way) < 2:
        return table([Event(0, len(way), PLACE, -1, 1.0, amount=0)])
    width = window(STRIDE, profile.rate)
    frames = np.arange(len(way))
    first, last = np.maximum(frames - width // 2, 0), np.minimum(frames + width // 2, frames[-1])
    east, south = (way[last] - way[first]).T / ((last - first) * leg / rate)
    forward = east * np.cos(front) - south * np.sin(front)
    right = east * np.sin(front) + south * np.cos(front)
    pace = np.hypot(forward, right)
    azimuth = np.degrees(np.arctan2(forward, right)) % 360
    path = np.degrees(unwrapped(np.arctan2(south, east)))
    codes = np.where(held(pace > GOES, pace > RESTS), np.round(azimuth / 45) % 8, PLACE).astype(int)
    starts, stops = np.array(pieces(codes, round(BRIEF * rate))).T
    code, sizes = codes[starts], stops - starts
    goes = code != PLACE
    ahead, aside = (np.add.reduceat(it, starts) / sizes for it in (forward, right))
    off = (np.degrees(np.arctan2(ahead, aside)) - 45 * code + 180) % 360 - 180
    margin = 1 - np.where(goes, np.abs(off) / SECTOR, np.hypot(ahead, aside) / GOES)
    curved = np.rint(np.maximum.reduceat(path, starts) - np.minimum.reduceat(path, starts))
    found = np.full((len(starts), len(Event._fields)), -1.0)
    for name, values in (
        ("start", starts),
        ("stop", stops),
        ("direction", code),
        ("margin", np.minimum(np.maximum(margin, 0), 1)),
        ("amount", np.where(goes, curved, 0)),
        ("speed", np.where(goes, np.maximum.reduceat(pace, starts), -0.01)),
        ("beside", np.where(goes, (code + np.where(off > 0, 1, -1)) % 8, -1)),
    ):
        found[:, Event._fields.index(name)] = values
    return found


def pieces(codes: NDArray[Any], least: int) -> list[tuple[int, int]]:
    """Make of codes runs of some length, in place; return their frames.

    A run that is too short joins what was before it; at the beginning, what comes first that is
    long enough, or else the longest.
    """
    edges = [0, *((codes[1:] != codes[:-1]).nonzero()[0] + 1).tolist(), len(codes)]
    if len(edges) == 2:
        return [(0, len(codes))]
    sizes = [stop - start for start, stop in pairwise(edges)]
    long = [start for start, size in zip(edges, sizes, strict=False) if size >= least]
    starts, kept = [0], list[int]()
    for start in long or [edges[sizes.index(max(sizes))]]:
        if not kept or codes[start] != kept[-1]:
            starts += [start] if kept else []
            kept.append(int(codes[start]))
    found = list(pairwise([*starts, len(codes)]))
    for (start, stop), code in zip(found, kept, strict=True):
        codes[start:stop] = code
    return found


def turns(heading: Floats, profile: Profile) -> Floats:
    """Return the turns about the vertical, as from `events.table`.

    Parameters
    ----------
    heading : ndarray
        (N,) degrees, in one go: past half a circle it goes on.
    profile : Profile
        For the rate.
    """
    rate = float(profile.rate)
    if len(heading) < 2:
        return table([])
    calm = mean(heading, window(STRIDE, profile.rate))
    light = mean(heading, window(profile.smoothing, profile.rate))
    pace = np.abs(np.gradient(calm)) * rate
    found = []
    for first, last in swings(calm, TURNS):
        for start, stop in _parts(pace[first : last + 1], round(BRIEF * rate)):
            done = calm[first + stop - 1] - calm[first + start]
            if abs(done) >= TURNS:
                found.append(_turn(light, first + start, first + stop, rate))
    return table([one for one in found if one.amount >= TURNS])


def _parts(pace: Floats, least: int) -> list[tuple[int, int]]:
    """Part a turn where it rests."""
    rests = lulls(pace, PAUSE, least)
    edges = [0, *chain(*rests), len(pace)]
    return [(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if b > a]


def _turn(heading: Floats, start: int, stop: int, rate: float) -> Event:
    """Return a turn, from when it is seen to begin until it is seen to end."""
    some = heading[start:stop]
    left = some[-1] > some[0]
    pace = np.gradient(some) * (rate if left else -rate)
    whole = 0, len(some) - 1
    first, last = seen(some, pace, whole, whole, PAUSE / rate)
    amount = round(abs(float(some[last] - some[first])))
    code = DIRECTION_CODES["left" if left else "right"]
    margin = min(amount / TURNS - 1, 1.0)
    speed = float(pace.max()) / 360
    return Event(start + first, start + last, code, -1, margin, amount=amount, speed=speed)
