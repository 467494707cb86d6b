"""Where the body goes and how it turns.

Source: ``encoding/BODY.md``, "Travel" and "Turns".
"""

from __future__ import annotations

from itertools import chain, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTION_CODES, PLACE
from lanindex.encoding.arithmetic import held, unwrapped, window
from lanindex.encoding.curves import lulls, mean, swings
from lanindex.encoding.events import SECTOR, Event, table
from lanindex.encoding.onset import seen
from lanindex.encoding.places import Stretch
from lanindex.encoding.profile import Profile

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


def travel(hips: Stretch, front: Floats, leg: float, profile: Profile) -> Floats:
    """Return the stretches in which the body goes one way, or stays, as from `events.table`.

    `front` (N,) radians, the heading, averaged over `STRIDE`.
    """
    rate, count = float(profile.rate), len(front)
    if count < 2:
        return table([Event(0, count, PLACE, -1, 1.0, amount=0)])
    forward, right, path = np.empty((3, count))
    codes, fast, goes = np.empty(count, np.int8), np.empty(count, bool), np.empty(count, bool)
    half = window(STRIDE, profile.rate) // 2
    for block, places in hips.blocks(half):
        some = block.inner
        way = (places["RHip"] + places["LHip"])[:, ::2] / 2
        frames = np.arange(some.start, some.stop)
        first, last = np.maximum(frames - half, 0), np.minimum(frames + half, count - 1)
        went = way[last - block.outer.start] - way[first - block.outer.start]
        east, south = went.T / ((last - first) * leg / rate)
        sine, cosine = np.sin(front[some]), np.cos(front[some])
        ahead = forward[some] = east * cosine - south * sine
        aside = right[some] = east * sine + south * cosine
        path[some] = np.arctan2(south, east)
        pace = np.hypot(ahead, aside)
        codes[some] = np.round(np.degrees(np.arctan2(ahead, aside)) % 360 / 45) % 8
        fast[some], goes[some] = pace > GOES, pace > RESTS
    codes[~held(fast, goes)] = PLACE
    starts, stops = np.array(pieces(codes, round(BRIEF * rate))).T
    code, sizes = codes[starts].astype(int), stops - starts
    moves = code != PLACE
    ahead, aside = (np.add.reduceat(it, starts) / sizes for it in (forward, right))
    off = (np.degrees(np.arctan2(ahead, aside)) - 45 * code + 180) % 360 - 180
    margin = 1 - np.where(moves, np.abs(off) / SECTOR, np.hypot(ahead, aside) / GOES)
    top = np.maximum.reduceat(np.hypot(forward, right, out=forward), starts)
    del right
    path = unwrapped(path)
    np.degrees(path, out=path)
    curved = np.rint(np.maximum.reduceat(path, starts) - np.minimum.reduceat(path, starts))
    found = np.full((len(starts), len(Event._fields)), -1.0)
    for name, values in (
        ("start", starts),
        ("stop", stops),
        ("direction", code),
        ("margin", np.minimum(np.maximum(margin, 0), 1)),
        ("amount", np.where(moves, curved, 0)),
        ("speed", np.where(moves, top, -0.01)),
        ("beside", np.where(moves, (code + np.where(off > 0, 1, -1)) % 8, -1)),
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

    `heading` (N,) degrees, in one go: past half a circle it goes on.
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
