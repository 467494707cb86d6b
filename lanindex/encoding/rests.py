"""What carries the body beside feet, or instead of them: knees, the seat, the trunk, hands.

Source: ``encoding/BODY.md``, "Other supports".
"""

from __future__ import annotations

import numpy as np

from lanindex.alphabet import CARRIERS
from lanindex.encoding.arithmetic import held, runs
from lanindex.encoding.carriers import HAND, KNEE, OTHER, SEAT, TRUNK, lowest, masses, points
from lanindex.encoding.events import Event
from lanindex.encoding.ground import SIDES, SLIDES, STANCE, STANDS, STIRS, Ground, fifth
from lanindex.encoding.places import Stretch
from lanindex.encoding.ways import pieces

ANKLE = 0.08
"""Lengths of a leg that an ankle stands above the floor, where no toe tells."""

SETTLES = 0.5
"""Seconds that a body is still at least of which something unseen must carry the weight."""

SPEEDS = (STIRS, STANDS, SLIDES)
NEEDED = tuple(side + it for side in SIDES for it in ("Hip", "Ankle"))
WISHED = ("Neck", *(side + it for side in SIDES for it in ("Knee", "Toe", "Wrist")))


def rests(ground: Ground, places: Stretch) -> list[Event]:
    """Return when something else than feet carries, and what."""
    count, rate = ground.carries.shape[1], ground.rate
    floor, mass = _floor(ground), masses(places.names)
    low = np.zeros((2, len(CARRIERS), count), bool)
    for block, seen in places.blocks(1):
        some = lowest(seen, ground.leg, floor)
        if some.stop:
            own = np.zeros((2, len(CARRIERS), block.outer.stop - block.outer.start), bool)
            body = points(seen, ground.leg, floor, some)
            feet = ground.carries[:, block.outer][:, some]
            own[..., some] = places.body.stages.carriers(body, mass, feet, rate, SPEEDS)
            low[..., block.inner] = own[..., block.within]
    for start, stop in ground.air:
        low[..., start:stop] = False
    if not low[0].any():
        return []
    carrier = np.full(count, -1, np.int8)
    for part in (OTHER, KNEE, HAND, SEAT, TRUNK):
        least = STANCE if part != OTHER else SETTLES
        for start, stop in runs(held(*low[:, part])):
            if stop - start >= least * rate:
                carrier[start:stop] = part
    found = []
    for start, stop in runs(carrier >= 0):
        for first, last in pieces(carrier[start:stop], round(STANCE * rate)):
            what = int(carrier[start + first])
            found.append(Event(start + first, start + last, -1, -1, 1.0, amount=what))
    return found


def apart(steps: list[Event], carried: list[Event], count: int) -> list[Event]:
    """Return the steps that end, and as they begin, while nothing else than feet carries."""
    resting, free = np.zeros(count + 1, bool), np.zeros(count + 1, np.int64)
    for one in carried:
        resting[one.start : one.stop], free[one.stop] = True, one.stop
    free = np.maximum.accumulate(free)
    return [
        one._replace(start=max(one.start, int(free[one.stop])))
        for one in steps
        if not resting[one.stop]
    ]


def _floor(ground: Ground) -> float:
    """Return the height of the floor where feet carry, in lengths of a leg."""
    lowest = ground.feet.heights.min(axis=(0, 1))
    stood = lowest[np.any(ground.carries, axis=0)]
    toes = ground.feet.heights.shape[1] > 1
    return fifth(stood if len(stood) else lowest) - (0 if toes else ANKLE)
