"""What carries the body beside feet, or instead of them: knees, the seat, the trunk, hands.

Source: ``encode/BODY.md``, "Other supports".
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import CARRIERS
from lanindex.encode.arithmetic import runs
from lanindex.encode.ground import SIDES, SLIDES, STANCE, STANDS, STIRS, Ground, fifth, held
from lanindex.encode.places import Stretch
from lanindex.encode.steps import Event
from lanindex.encode.ways import pieces

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Places = dict[str, Floats]

KNEELS, SITS, LIES, PROPS = 0.16, 0.2, 0.3, 0.12
"""Lengths of a leg above the floor: a knee that is lower kneels, hips that are lower sit, hips and
neck lie, a wrist props."""

HIGHER = 1.25
"""Times as high, and they do so no more."""

CROUCHES = 0.8
"""Lengths of a leg above the floor: hips that are higher sit on nothing."""

ANKLE = 0.08
"""Lengths of a leg that an ankle stands above the floor, where no toe tells."""

TOPPLES = 0.15
"""Lengths of a leg over the ground from the body's centre to what carries: farther out it falls."""

SETTLES = 0.5
"""Seconds that a body is still at least of which something unseen must carry the weight."""

_MASSES = {("Hip", "Neck"): 0.68, ("Hip", "Knee"): 0.2, ("Knee", "Ankle"): 0.12}
"""Of the body's weight, what lies about the middle between two joints."""

_KNEE, _SEAT, _TRUNK, _HAND, _OTHER = range(len(CARRIERS))
NEEDED = tuple(side + it for side in SIDES for it in ("Hip", "Ankle"))
WISHED = ("Neck", *(side + it for side in SIDES for it in ("Knee", "Toe", "Wrist")))


def rests(ground: Ground, places: Stretch) -> list[Event]:
    """Return when something else than feet carries, and what.

    Parameters
    ----------
    ground : Ground
        Which foot carries.
    places : Stretch
        Where `NEEDED` joints and `WISHED` ones are, over the same stretch.
    """
    count, rate = ground.carries.shape[1], ground.rate
    low = {part: np.zeros((2, count), bool) for part in range(len(CARRIERS))}
    floor = _floor(ground)
    for block, seen in places.blocks(1):
        some = {name: it / ground.leg - [0, floor, 0] for name, it in seen.items()}
        for part, begins, stays in _carriers(some, ground.carries[:, block.outer], rate):
            for whole, own in zip(low[part], (begins, stays), strict=True):
                whole[block.inner] = own[block.within]
    carrier = np.full(count, -1, np.int8)
    for start, stop in ground.air:
        for both in low.values():
            both[:, start:stop] = False
    for part in (_OTHER, _KNEE, _HAND, _SEAT, _TRUNK):
        least = STANCE if part != _OTHER else SETTLES
        for start, stop in runs(held(*low[part])):
            if stop - start >= least * rate:
                carrier[start:stop] = part
    found = []
    for start, stop in runs(carrier >= 0):
        for first, last in pieces(carrier[start:stop], round(STANCE * rate)):
            what = int(carrier[start + first])
            found.append(Event(start + first, start + last, -1, -1, 1.0, amount=what))
    return found


def apart(steps: list[Event], carried: list[Event], count: int) -> list[Event]:
    """Return the steps that end, and as they begin, while nothing else than feet carries.

    Parameters
    ----------
    steps : list of Event
        In order of time.
    carried : list of Event
        As from `rests`.
    count : int
        Frames of the stretch.
    """
    resting, free = np.zeros(count + 1, bool), np.zeros(count + 1, np.int64)
    for one in carried:
        resting[one.start : one.stop], free[one.stop] = True, one.stop
    free = np.maximum.accumulate(free)
    return [
        replace(one, start=max(one.start, int(free[one.stop])))
        for one in steps
        if not resting[one.stop]
    ]


def _floor(ground: Ground) -> float:
    """Return the height of the floor where feet carry, in lengths of a leg."""
    lowest = ground.feet.points[..., 1].min(axis=(0, 1))
    stood = lowest[np.any(ground.carries, axis=0)]
    toes = ground.feet.points.shape[1] > 1
    return fifth(stood if len(stood) else lowest) - (0 if toes else ANKLE)


def _carriers(places: Places, feet: Flags, rate: float) -> Iterator[tuple[int, Flags, Flags]]:
    """Yield what may carry: its code, where it begins to, and where it goes on.

    Parameters
    ----------
    places : dict of str to ndarray
        (N, 3) lengths of a leg above the floor, by joint.
    feet : ndarray
        (2, N) bool, whether they carry.
    rate : float
        Frames a second.
    """
    paces = {name: _pace(it, rate) for name, it in places.items()}
    hips = np.minimum(places["RHip"][:, 1], places["LHip"][:, 1])
    slow = {it: np.minimum(paces["RHip"], paces["LHip"]) < it for it in (STIRS, STANDS, SLIDES)}
    lies = hips if "Neck" not in places else np.maximum(hips, places["Neck"][:, 1])
    yield _SEAT, (hips < SITS) & slow[STANDS], (hips < SITS * HIGHER) & slow[SLIDES]
    if "Neck" in places:
        yield _TRUNK, (lies < LIES) & slow[STANDS], (lies < LIES * HIGHER) & slow[SLIDES]
    knees, wrists = (_low(places, paces, *it) for it in (("Knee", KNEELS), ("Wrist", PROPS)))
    yield _KNEE, *(knees[0] | knees[1])
    base = [
        (places[side + joint], on)
        for side, foot, (_, knee) in zip(SIDES, feet, knees, strict=True)
        for joint, on in (("Ankle", foot), ("Toe", foot), ("Knee", knee))
        if side + joint in places
    ]
    off = _off(_centre(places), base)
    begins, stays = wrists[0] | wrists[1]
    yield _HAND, begins & (off > TOPPLES), stays & (off > TOPPLES / 2)
    crouches = (hips < CROUCHES) & (off > TOPPLES)
    yield _OTHER, crouches & slow[STIRS], crouches & slow[STANDS]


def _low(places: Places, paces: Places, joint: str, height: float) -> Flags:
    """Return where a joint begins to lie on the floor, and where it stays, (2 sides, 2, N)."""
    found = np.zeros((2, 2, len(places["RHip"])), bool)
    for side, name in enumerate(side + joint for side in SIDES):
        if name in places:
            up, pace = places[name][:, 1], paces[name]
            found[side] = (up < height) & (pace < STANDS), (up < height * HIGHER) & (pace < SLIDES)
    return found


def _centre(places: Places) -> Floats:
    """Return where the body's weight has its middle, over the ground, (N, 2)."""
    joints = dict(places)
    for name in ("Hip", "Knee", "Ankle"):
        if f"R{name}" in places and f"L{name}" in places:
            joints[name] = (places[f"R{name}"] + places[f"L{name}"]) / 2
    found = np.zeros((len(joints["Hip"]), 2))
    for (one, two), mass in _MASSES.items():
        ends = [joints[name] if name in joints else joints["Hip"] for name in (one, two)]
        found += mass / 2 * (ends[0] + ends[1])[:, ::2]
    return found


def _off(centre: Floats, base: list[tuple[Floats, Flags]]) -> Floats:
    """Return how far a point over the ground is from lines between points that carry, (N,)."""
    found = np.full(len(centre), np.inf)
    for (one, on), (two, too) in combinations([*base, *base[:1]], 2):
        start, line = one[:, ::2], (two - one)[:, ::2]
        along = ((centre - start) * line).sum(axis=1)
        along = np.clip(along / np.maximum((line * line).sum(axis=1), 1e-9), 0, 1)
        along = np.where(on & too, along, np.where(on, 0.0, 1.0))[:, None]
        apart = np.linalg.norm(centre - start - along * line, axis=1)
        found = np.where(on | too, np.minimum(found, apart), found)
    return found


def _pace(points: Floats, rate: float) -> Floats:
    if len(points) < 2:
        return np.zeros(len(points))
    pace: Floats = np.linalg.norm(np.gradient(points, axis=0) * rate, axis=1)
    return pace
