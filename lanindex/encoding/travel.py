"""Where the body goes.

Source: ``encoding/BODY.md``, "Travel".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import PLACE
from lanindex.encoding.arithmetic import held, unwrapped, window
from lanindex.encoding.curves import BRIEF, SECTOR, STRIDE, Event, pieces, table
from lanindex.encoding.places import Stretch
from lanindex.encoding.profile import Profile

Floats = NDArray[np.float64]

GOES, RESTS = 0.35, 0.2
"""Lengths of a leg a second: faster is travel; slower is none any more."""


def travel(hips: Stretch, front: Floats, leg: float, profile: Profile) -> Floats:
    """Return the stretches in which the body goes one way, or stays, as from `table`.

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
