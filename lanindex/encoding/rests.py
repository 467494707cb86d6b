"""What carries the body beside feet, or instead of them: knees, the seat, the trunk, hands.

Source: ``encoding/BODY.md``, "Other supports".
"""

from functools import cache
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import CARRIERS
from lanindex.encoding.arithmetic import blocks, held, runs, sizes, slopes
from lanindex.encoding.curves import Event, pieces
from lanindex.encoding.ground import SETTLES, SIDES, SLIDES, STANCE, STANDS, STIRS, Ground, fifth
from lanindex.encoding.places import Stretch

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

TOPPLES = 0.15
"""Lengths of a leg over the ground from the body's centre to what carries: farther out it falls."""

_MASSES = {("Hip", "Neck"): 0.68, ("Hip", "Knee"): 0.2, ("Knee", "Ankle"): 0.12}
"""Of the body's weight, what lies about the middle between two joints."""

JOINTS = (
    *("RHip", "LHip", "Neck"),
    *(side + it for it in ("Knee", "Wrist", "Ankle", "Toe") for side in "RL"),
)
LIMITS = {
    "Hip": max(CROUCHES, HIGHER * max(SITS, LIES)),
    "Knee": KNEELS * HIGHER,
    "Wrist": PROPS * HIGHER,
}
"""Lengths of a leg above the floor: while these joints are higher, nothing but feet carries."""

KNEE, SEAT, TRUNK, HAND, OTHER = range(len(CARRIERS))
HEIGHTS = np.array((SITS, LIES, KNEELS, KNEELS, PROPS, PROPS))
BASE = np.array([JOINTS.index(side + it) for it in ("Ankle", "Toe", "Knee") for side in "RL"])
PAIRS = np.array(list(combinations_with_replacement(range(len(BASE)), 2))).T
"""Lines between the joints that feet and knees carry on; of one alone, too."""

AWAY = 9
"""Lengths of a leg above the floor: there is what is not known."""

FEW = 256
"""Frames that are looked at together: memory for so many is had again at once."""


def lowest(places: Places, leg: float, floor: float) -> slice:
    """Return the frames in which something low may carry, and one more on both sides."""
    found = np.zeros(len(places["RHip"]), bool)
    for joint, height in LIMITS.items():
        for name in ("R" + joint, "L" + joint):
            if name in places:
                found |= places[name][:, 1] < (height + floor) * leg + 1
    frames = np.flatnonzero(found)
    return slice(max(frames[0] - 1, 0), frames[-1] + 2) if len(frames) else slice(0, 0)


def points(places: Places, leg: float, floor: float, frames: slice) -> Floats:
    """Return where `JOINTS` are, (3, J, n), lengths of a leg above the floor: see `lowest`."""
    known = [name in places for name in JOINTS]
    some = [(places[name] if name in places else places["RHip"])[frames] for name in JOINTS]
    found: Floats = np.array(some).transpose(2, 0, 1) / leg
    found[1] -= floor
    found[:, np.logical_not(known)] = np.array((0, AWAY, 0))[:, None, None]
    return found


@cache
def masses(names: tuple[str, ...]) -> Floats:
    """Return of the body's weight what hangs at each of `JOINTS`, (J,), if these are known."""
    found = dict.fromkeys(JOINTS, 0.0)
    for ends, mass in _MASSES.items():
        for end in ends:
            sides = {end, "R" + end, "L" + end} & {*JOINTS}
            sides = sides if sides <= {*names} else {"RHip", "LHip"}
            found |= {name: found[name] + mass / 2 / len(sides) for name in sides}
    return np.array([*found.values()])


def carriers(points: Floats, masses: Floats, feet: Flags, rate: float) -> Flags:
    """Return where each carrier may begin, and where it may go on, (2, C, N).

    `points` (3, J, N) and `masses` (J,) as from the functions; `feet` (2, N) those that carry.
    """
    pace = sizes((slopes(points) * rate).transpose(1, 2, 0))
    hips, calm = points[1, :2].min(axis=0), pace[:2].min(axis=0)
    high = np.concatenate(([hips, np.maximum(hips, points[1, 2])], points[1, 3:7]))
    pace = np.concatenate(([calm, calm], pace[3:7]))
    limit = HEIGHTS[:, None]
    lies = np.array(((high < limit) & (pace < STANDS), (high < limit * HIGHER) & (pace < SLIDES)))
    toes = feet & (points[1, -2:] < AWAY)
    on = np.concatenate((feet, toes, lies[1, 2:4]))
    off, crouches = np.zeros(len(hips)), hips < CROUCHES
    looked_at = np.flatnonzero(lies[1, 4] | lies[1, 5] | crouches)
    for part in blocks(len(looked_at), size=FEW):
        some = looked_at[part.inner]
        off[some] = _off(points[::2].take(some, axis=2), masses, on.take(some, axis=1))
    found = np.empty((2, len(CARRIERS), len(hips)), bool)
    found[:, SEAT], found[:, TRUNK] = lies[:, 0], lies[:, 1]
    found[:, KNEE] = lies[:, 2] | lies[:, 3]
    topples = np.array((off > TOPPLES, off > TOPPLES / 2))
    found[:, HAND] = (lies[:, 4] | lies[:, 5]) & topples
    crouches &= topples[0]
    found[:, OTHER] = crouches & (calm < STIRS), crouches & (calm < STANDS)
    return found


def _off(points: Floats, masses: Floats, on: Flags) -> Floats:
    """Return how far the body's middle is, over the ground, from what carries it, (N,)."""
    centre = (points * masses[:, None]).sum(axis=1)
    base = points.take(BASE, axis=1)
    one, two = PAIRS
    start, line = base.take(one, axis=1), base.take(two, axis=1)
    line -= start
    way = centre[:, None] - start
    along = _dot(way, line) / np.maximum(_dot(line, line), 1e-9)
    way -= np.minimum(np.maximum(along, 0), 1) * line
    apart = np.sqrt(_dot(way, way))
    apart[~(on[one] & on[two])] = np.inf
    found: Floats = apart.min(axis=0)
    return found


def _dot(one: Floats, other: Floats) -> Floats:
    found: Floats = one[0] * other[0] + one[1] * other[1]
    return found


ANKLE = 0.08
"""Lengths of a leg that an ankle stands above the floor, where no toe tells."""

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
            own[..., some] = carriers(body, mass, feet, rate)
            low[..., block.inner] = own[..., block.within]
    for start, stop in ground.air:
        low[..., start:stop] = False
    low[:, OTHER] |= ground.high
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
