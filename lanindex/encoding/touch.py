"""What the hands touch: each other, the head, the trunk, the other arm, the legs.

First what each hand is nearest to, how far it is and how fast it passes, frame by frame; then the
stretches of time in which that is a touch.

Source: ``encoding/BODY.md``, "Touch".
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache
from itertools import count
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import TOUCHED
from lanindex.data import shipped
from lanindex.encoding.arithmetic import Block, blocks, held, runs
from lanindex.encoding.curves import Event, pieces
from lanindex.encoding.ground import FLICKER
from lanindex.encoding.joints import Body
from lanindex.encoding.places import Stretch, stretches

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ints = NDArray[np.int64]

PALM = 0.15
"""Lengths of an arm from the wrist to the middle of the palm, towards the hand's joint."""

CROWN = 0.33
"""Lengths of an arm from the neck to the middle of the head, towards the head's joint."""

PALMS, SKULL, TRUNK, SLEEVE = 0.15, 0.25, 0.25, 0.13
"""Lengths of an arm: a palm that is nearer to the other one, to the middle of the head, to the
trunk's lines or to the other arm's touches it."""

THIGH, KNEE, SHANK, FOOT = 0.2, 0.17, 0.15, 0.15
"""The same, of the legs."""

WIDER = 0.05
"""Lengths of an arm that all of these are longer for a hand of which only the wrist is known."""

LEAVES = 1.25
"""Times as far, and touch ends."""

HANGS = 30.0
"""Degrees from the trunk, neck to hips: an arm hangs beside it, if it is straight."""

STRAIGHT = 0.8
"""Lengths of an arm from shoulder to wrist of one that is straight."""

_ARM = ("own Wrist", "own Shoulder", "Hip", "Neck")
_SIDES = ("RWaist", "RNeck", "LWaist", "LNeck")
CORE = ("RHip", "LHip", "Neck")
_REACHES = {
    **{"hand": PALMS, "head": SKULL, "trunk": TRUNK, "arm": SLEEVE},
    **{"thigh": THIGH, "knee": KNEE, "shank": SHANK, "foot": FOOT},
}
_LINES = tuple(map(tuple, shipped("encoding/touch.toml")["lines"]))
"""What is touched, and the ends of a line inside it; ``other`` is the other side of the hand's."""

ALWAYS, NEVER, CLASPED, RIGHT_HANGS, LEFT_HANGS = range(5)
"""When a line does not count."""

_UNLESS: tuple[dict[str, int], ...] = (
    {},
    {"arm": CLASPED, "trunk": RIGHT_HANGS, "thigh": RIGHT_HANGS},
    {"arm": CLASPED, "trunk": LEFT_HANGS, "thigh": LEFT_HANGS},
)
_PAIRS = (("R", "L", (("hand", "LPalm", "LPalm"),)), ("R", "L", _LINES), ("L", "R", _LINES))
"""Of both hands together, the right and the left one: whose palm, whose is the other, the lines."""

FAR = 9
"""Reaches from a palm: what is farther is not looked at."""

FEW, MANY = 128, 512
"""Frames of all lines, and of the nearest ones, that are looked at together: memory for so many is
had again at once."""


class Near(NamedTuple):
    """What both hands together, the right one and the left one are nearest to, frame by frame."""

    what: NDArray[np.int8]  # (3, N) int8, codes of ``alphabet.TOUCHED``
    apart: NDArray[np.float32]  # (3, N) float32, how far it is, as a part of how near touches
    pace: NDArray[np.float32]  # (3, N) float32, lengths of an arm a second past it

    def take(self, other: Near, part: Block) -> None:
        """Take what was found of some frames and their neighbours."""
        self.what[:, part.inner] = other.what[:, part.within]
        self.apart[:, part.inner] = other.apart[:, part.within]
        self.pace[:, part.inner] = other.pace[:, part.within]


class Plan(NamedTuple):
    """What points are made of the joints that are known, and what lines hands may be near."""

    joints: tuple[str, ...]  # The first rows of the points
    size: int  # How many points there are
    # (2, M): from which joint towards which one palms and the middle of the head lie. They are the
    # rows behind the joints
    tips: Ints
    far: Floats  # (M, 1) float64, lengths of an arm from the first of both
    # Right hip, left hip, neck, the middle of the hips, the waist, and the first of both sides'
    # waists and necks; empty where they are not known
    trunk: Ints
    # (4, 2): wrist, shoulder, middle of the hips, neck of each side; -1 where it is not known
    arms: Ints
    # (6, L): of which of `Near`, the code of what is touched, the palm, both ends, and when it does
    # not count. The first of each never does; the second is from palm to palm
    lines: Ints
    reaches: Floats  # (L,) float64, lengths of an arm
    parts: tuple[slice, ...]  # The lines of each of `Near`


@cache
def plan(joints: tuple[str, ...]) -> Plan:
    """Return what there is to look at where these joints are known, both wrists among them."""
    rows, trunk = {name: row for row, name in enumerate(joints)}, list[int]()
    fresh = count(len(joints))
    ways = [(f"{side}Palm", f"{side}Wrist", f"{side}Hand", PALM) for side in "RL"]
    ways = [it for it in (*ways, ("Crown", "Neck", "Head", CROWN)) if {*it[1:3]} <= rows.keys()]
    tips = np.array([[rows[it[1]] for it in ways], [rows[it[2]] for it in ways]], np.int64)
    rows |= {name: next(fresh) for name, *_ in ways}
    for side in "RL":
        rows.setdefault(f"{side}Palm", rows[f"{side}Wrist"])
    if rows.keys() >= {*CORE}:
        rows |= {name: next(fresh) for name in ("Hip", *_SIDES)}
        rows["Waist"] = rows["Chest"] if "Chest" in rows else next(fresh)
        trunk = [rows[it] for it in (*CORE, "Hip", "Waist", _SIDES[0])]
    arms = [[rows.get(it.replace("own ", side), -1) for side in "RL"] for it in _ARM]
    lines, reaches = list[tuple[int, ...]](), list[float]()
    for whose, (side, other, those) in enumerate(_PAIRS):
        palm, wider = rows[f"{side}Palm"], 0 if f"{side}Hand" in rows else WIDER
        lines.append((whose, 0, palm, palm, palm, NEVER))
        reaches.append(1.0)
        for name, *ends in those:
            one, two = (rows.get(it.replace("other ", other), -1) for it in ends)
            if min(one, two) >= 0:
                unless = _UNLESS[whose].get(name, ALWAYS)
                lines.append((whose, TOUCHED.index(name), palm, one, two, unless))
                reaches.append(_REACHES[name] + wider)
    far = np.array([[it[3]] for it in ways]).reshape(-1, 1)
    size = next(fresh)
    table = np.array(lines).T.copy()
    edges = np.searchsorted(table[0], range(4)).tolist()
    parts = tuple(map(slice, edges, edges[1:]))
    made = tips, far, np.array(trunk, np.int64)
    return Plan(joints, size, *made, np.array(arms), table, np.array(reaches), parts)


def points(places: dict[str, Floats], arm: float, plan: Plan) -> Floats:
    """Return joints, lengths of an arm, with room for what `fill` adds: (3, P, N)."""
    joints, frames = len(plan.joints), len(places[plan.joints[0]])
    flat = np.empty((3, plan.size * frames))
    known = [places[name].T for name in plan.joints]
    np.concatenate(known, axis=1, out=flat[:, : joints * frames])
    found = flat.reshape(3, plan.size, frames)
    found[:, :joints] /= arm
    return found


def fill(points: Floats, plan: Plan) -> None:
    """Write palms and what else lines go through where there is room for them."""
    joints = len(plan.joints)
    start, end = points.take(plan.tips, axis=1).swapaxes(0, 1)
    way = end - start
    way /= np.maximum(_size(way), 1e-9)
    way *= plan.far
    way += start
    points[:, joints : joints + len(plan.far)] = way
    if len(plan.trunk):
        right, left, neck, hip, waist, first = plan.trunk
        hips = points.take((right, left), axis=1)
        middle = points[:, hip] = (hips[:, 0] + hips[:, 1]) / 2
        if waist >= joints:
            points[:, waist] = (middle + points[:, neck]) / 2
        both = points.take((waist, neck), axis=1)
        sides = both[:, None] + hips[:, :, None] - middle[:, None, None]
        points[:, first : first + 4] = sides.reshape(3, 4, -1)


def nearest(points: Floats, plan: Plan, rate: float, fast: bool = False) -> Near:
    """Return what hands are nearest to; `points` (3, P, N) from `points` are filled."""
    fill(points, plan)
    frames = points.shape[2]
    off = np.zeros((5, frames), bool)
    off[NEVER], off[RIGHT_HANGS:] = True, _hangs(points, plan.arms)
    if fast:
        from lanindex.encoding import touch_fast

        return touch_fast.nearest(points, plan, off, rate)
    found = empty(frames)
    for part in blocks(frames, 1, MANY):
        some = np.ascontiguousarray(points[..., part.outer])
        found.take(_nearest(some, plan, off[:, part.outer], rate), part)
    return found


def empty(frames: int) -> Near:
    """Return what is to be filled."""
    apart, pace = np.empty((2, 3, frames), np.float32)
    return Near(np.empty((3, frames), np.int8), apart, pace)


def _nearest(points: Floats, plan: Plan, off: Flags, rate: float) -> Near:
    frames = points.shape[2]
    line, along = np.empty((3, frames), np.int64), np.empty((3, frames))
    apart = np.empty((3, frames), np.float32)
    for part in blocks(frames, size=FEW):
        some = part.inner
        away, where = _gaps(points[..., some], plan, off[:, some])
        for whose, lines in enumerate(plan.parts):
            away[lines].argmin(axis=0, out=line[whose, some])
            line[whose, some] += lines.start
        cell = line[:, some] * away.shape[1] + np.arange(away.shape[1])
        away.take(cell, out=apart[:, some])
        where.take(cell, out=along[:, some])
    pace = _past(points, plan.lines[2:5].take(line, axis=1), along, rate)
    pace[apart == FAR] = FAR
    return Near(plan.lines[1].astype(np.int8).take(line), apart, pace)


def _gaps(points: Floats, plan: Plan, off: Flags) -> tuple[NDArray[np.float32], Floats]:
    """Return distances of palms from lines, divided by reach, and positions on the lines, (L, N).

    `points` (3, P, N); `off` (5, N) when lines do not count: their distance is `FAR`.
    """
    way, start, line = (points.take(row, axis=1) for row in plan.lines[2:5])
    way -= start
    line -= start
    along = _dot(way, line)
    along /= np.maximum(_dot(line, line), 1e-9)
    along = np.minimum(np.maximum(along, 0), 1)
    line *= along
    way -= line
    away = (_size(way) / plan.reaches[:, None]).astype(np.float32)
    np.less(away[1], LEAVES, out=off[CLASPED])
    away[off.take(plan.lines[5], axis=0)] = FAR
    return away, along


def _past(points: Floats, ends: Ints, along: Floats, rate: float) -> NDArray[np.float32]:
    """Return how fast palms pass what is nearest, (3, N); ends: palm and line, (3, 3, N)."""
    count = points.shape[2]
    frames = np.arange(count)
    before, after = np.maximum(frames - 1, 0), np.minimum(frames + 1, count - 1)
    flat, cell = points.reshape(3, -1), ends * count
    speed = flat.take(cell + after, axis=1)
    speed -= flat.take(cell + before, axis=1)
    speed *= np.where(after - before == 2, rate / 2, rate)
    past, one, two = speed.swapaxes(0, 1)
    past -= (1 - along) * one
    past -= along * two
    return _size(past).astype(np.float32)


def _hangs(points: Floats, rows: Ints) -> Flags:
    """Tell when arms hang beside the trunk, (2, N); one that is not known whole never does."""
    wrist, shoulder, hip, neck = points.take(rows, axis=1, mode="wrap").swapaxes(0, 1)
    arm, trunk = wrist - shoulder, hip - neck
    size = _size(arm)
    along = _dot(arm, trunk) > math.cos(math.radians(HANGS)) * size * _size(trunk)
    hangs: Flags = along & (size > STRAIGHT) & (rows.min(axis=0) >= 0)[:, None]
    return hangs


def _dot(one: Floats, other: Floats) -> Floats:
    """Return the product of vectors (3, ...), what is horizontal first: see `arithmetic.sizes`."""
    all_three = one * other
    found: Floats = all_three[0]
    found += all_three[2]
    found += all_three[1]
    return found


def _size(vectors: Floats) -> Floats:
    found: Floats = np.sqrt(_dot(vectors, vectors))
    return found


QUIET, DWELLS = 0.5, 0.25
"""Lengths of an arm a second, and seconds: a hand does not touch what it passes faster, or slowly
for less time."""

RUBS = 1.5
"""Lengths of an arm a second: a hand that comes to pass faster has left."""

MEETS = 1.0
"""Lengths of an arm a second: hands that never pass each other slower do not touch."""

ARMS = ("r_arm", "l_arm")
HANDS = ("RWrist", "LWrist")
_OTHERS = (
    *("Chest", "Head"),
    *(side + it for side in "RL" for it in ("Hand", "Shoulder", "Elbow", "Knee", "Ankle", "Toe")),
)
_TRACKS = ("hands_touch", "r_hand_touch", "l_hand_touch")


def touches(body: Body, arm: float) -> Iterator[tuple[str, Stretch, list[Event]]]:
    """Yield what the hands touch: track, stretch, symbols."""
    rate = float(body.profile.rate)
    core = [name for name in CORE if len(body.known[name])]
    for one in stretches(body, (*HANDS, *core), _OTHERS):
        found, lines = empty(len(one.frames)), plan(one.names)
        for block, places in one.blocks(1):
            near = nearest(points(places, arm, lines), lines, rate, body.fast)
            found.take(near, block)
        for part, what, apart, pace in zip(_TRACKS, *found, strict=True):
            yield part, one, _events(what, apart, pace, rate, part == _TRACKS[0])


def _events(
    what: NDArray[np.int8],
    apart: NDArray[np.float32],
    pace: NDArray[np.float32],
    rate: float,
    together: bool,
) -> list[Event]:
    """Return the touches of a hand, or of both together."""
    meets = apart < 1
    if not meets.any():
        return []
    brief, dwells = round(FLICKER * rate), round(DWELLS * rate)
    stays = apart < LEAVES
    if not together:
        meets, stays = meets & (pace < QUIET), stays & (pace < RUBS)
    found = []
    for start, stop in _joined(runs(held(meets, stays)), brief):
        for first, last in pieces(what[start:stop], brief + 1):
            some = slice(start + first, start + last)
            slow = pace[some]
            calm = max((b - a for a, b in runs(slow < QUIET)), default=0)
            if slow.min() > MEETS if together else calm < dwells:
                continue
            clear = 1 - float(apart[some].min())
            found.append(Event(some.start, some.stop, -1, -1, clear, amount=int(what[some.start])))
    return found


def _joined(parts: list[tuple[int, int]], brief: int) -> list[tuple[int, int]]:
    """Return runs of frames, those as one between which no more frames lie."""
    found = parts[:1]
    for start, stop in parts[1:]:
        if start - found[-1][1] <= brief:
            found[-1] = (found[-1][0], stop)
        else:
            found.append((start, stop))
    return found
