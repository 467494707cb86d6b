"""Steps and jumps: the weight goes from foot to foot, or into the air.

Source: ``encoding/BODY.md``, "Steps" and "Jumps".
"""

import math
from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import HIGH, LOW, MID, PLACE
from lanindex.encoding.arithmetic import runs
from lanindex.encoding.curves import BRIEF, SECTOR, Event, begun, lulls
from lanindex.encoding.ground import FLICKER, FOOT, HIPS, SIDES, STANDS, STIRS, Ground

Floats = NDArray[np.float64]
Heights = NDArray[np.float32]

STAYS = 0.15
"""Lengths of a leg: a step that takes the pelvis no farther is in place."""

SLID, RAISED = 0.1, 0.05
"""Lengths of a leg: a foot that moves and rises less between two stands has not stepped."""

BENT = 40.0
"""Degrees from straight: a knee that is bent farther under the weight makes a step low."""

TOES = 0.07
"""Lengths of a leg that the ankle stands higher above the toe than in this capture's stands: a
step on the toes, high."""

WEIGHT = 0.15
"""Seconds after a foot stands in which knee and ankle tell the level."""

BOTH_BOTH, HOP, LEAP, ONE_BOTH, BOTH_ONE, UNSEEN = range(6)
"""Take-off and landing: from both feet to both, from one to the same, to the other, from one to
both, from both to one; or one of them not seen."""

_JUMPS = {(2, 2): BOTH_BOTH, (1, 1): HOP, (1, 2): ONE_BOTH, (2, 1): BOTH_ONE}
"""By how many feet take off and land."""


def ways(ground: Ground, turn: Floats, spans: Sequence[tuple[int, int]]) -> list[tuple[int, float]]:
    """Return directions of the pelvis between frames, and margins; `turn` (N,) radians."""
    if not spans:
        return []
    ends = np.minimum(np.array(spans, np.int64), len(turn) - 1)
    hips = ground.places.take(HIPS, ends.ravel())
    pelvis = ((hips["RHip"] + hips["LHip"]) / 2).reshape(-1, 2, 3)
    fronts = turn[ends[:, 1]].tolist()
    found = []
    for (start, stop), front in zip(pelvis, fronts, strict=True):
        forward, right = faced(stop - start, front)
        found.append(sector(forward / ground.leg, right / ground.leg, STAYS))
    return found


def faced(moved: Floats, turn: float) -> tuple[float, float]:
    """Return how far a way over the ground goes forward and to the right of a heading."""
    sine, cosine = math.sin(turn), math.cos(turn)
    return moved[0] * cosine - moved[2] * sine, moved[0] * sine + moved[2] * cosine


def sector(forward: float, right: float, least: float) -> tuple[int, float]:
    """Return the direction of a way, place if it is shorter than `least`, and its margin."""
    size = math.hypot(forward, right)
    if size < least:
        return PLACE, (least - size) / least
    azimuth = math.degrees(math.atan2(forward, right)) % 360
    code = round(azimuth / 45) % 8
    off = abs((azimuth - 45 * code + 180) % 360 - 180)
    return code, min(1 - off / SECTOR, (size - least) / least, 1.0)


def events(ground: Ground, turn: Floats) -> tuple[list[Event], list[Event]]:
    """Return the steps and the flights, each in order of time; `turn` (N,) the heading, radians."""
    brief, held = round(FLICKER * ground.rate), round(BRIEF * ground.rate)
    full = 0  # when the last foot stood
    landed = _together(ground, _landings(ground), brief)
    feet = [[stop for _, stop, foot in landed if foot == own] for own in range(2)]
    levels = [iter(_levels(ground, foot, stops)) for foot, stops in enumerate(feet)]
    spans = list[tuple[int, int]]()
    for release, stop, foot in landed:
        flight = _flown(ground, stop, brief)
        both = ground.carries[1 - foot][flight[1] : stop + brief].any() if flight else False
        if flight and both:
            start = flight[0]
        else:
            start = full
            if release - full > stop - release:  # it rests before it is lifted
                start += round(begun(ground.feet.speed[foot, full:stop], release - full, STIRS))
            first = max(start, release)
            rests = lulls(ground.feet.speed[foot, first : stop - brief], STANDS, held)
            start = max([start, *(first + end for _, end in rests if first + end < stop - brief)])
        spans.append((start, stop))
        full = stop
    found = [
        Event(*span, direction, next(levels[foot]), margin, foot)
        for span, (*_, foot), (direction, margin) in zip(
            spans, landed, ways(ground, turn, spans), strict=True
        )
    ]
    return found, _flights(ground, turn, brief)


def stances(ground: Ground, foot: int) -> list[Event]:
    """Return how long a foot holds weight each time, and how the leg takes it at first."""
    held = runs(ground.carries[foot])
    levels = _levels(ground, foot, [start for start, _ in held])
    return [
        Event(start, stop, -1, level, 1.0, foot)
        for (start, stop), level in zip(held, levels, strict=True)
    ]


def _together(
    ground: Ground, landings: list[tuple[int, int, int]], brief: int
) -> list[tuple[int, int, int]]:
    """Let both feet that land together stand at one time, that of the later one."""
    found = list(landings)
    for number, (one, two) in enumerate(pairwise(landings)):
        flight = _flown(ground, one[1], brief)
        if flight and two[1] <= flight[1] + brief and one[2] != two[2]:
            found[number] = (one[0], two[1], one[2])
    return found


def _flown(ground: Ground, stop: int, brief: int) -> tuple[int, int] | None:
    """Return the flight or slide after which a foot stands at a frame; None: there is none."""
    number = bisect_right(ground.bare, stop, key=lambda one: one[1]) - 1
    flight = ground.bare[number] if number >= 0 else None
    return flight if flight and stop - flight[1] <= brief else None


def _landings(ground: Ground) -> list[tuple[int, int, int]]:
    """Return of each foot that stands anew when it left, when it stands, and which it is."""
    left = [
        (release, stop, foot)
        for foot, carries in enumerate(ground.carries)
        for release, stop in runs(~carries)
        if 0 < stop < len(carries)
    ]
    found = []
    for (release, stop, foot), slid in zip(left, _slid(ground, left), strict=True):
        high = ground.feet.heights[foot, 0, release : stop + 1]
        raised = float(high.max() - min(high[0], high[-1]))
        if slid >= SLID or raised >= RAISED or release == 0:
            found.append((release, stop, foot))
    return sorted(found, key=lambda one: (one[1], one[2]))


def _slid(ground: Ground, left: Sequence[tuple[int, int, int]]) -> list[float]:
    """Return how far ankles go over the ground, lengths of a leg, while feet are lifted."""
    frames = np.array(left, np.int64).reshape(-1, 3)
    slid = np.empty(len(left))
    for foot, side in enumerate(SIDES):
        own = np.flatnonzero(frames[:, 2] == foot)
        ankle = side + FOOT[0]
        places = ground.places.take((ankle,), frames[own, :2].ravel())[ankle]
        points = (places / ground.leg).astype(np.float32).reshape(-1, 2, 3)
        ways = (points[:, 1] - points[:, 0])[:, ::2].tolist()
        slid[own] = [math.hypot(*way) for way in ways]
    return slid.tolist()


def _levels(ground: Ground, foot: int, frames: Sequence[int]) -> list[int]:
    """Return the levels of steps, by how the leg takes the weight from some frames on."""
    if not frames:
        return []
    carries, bent, usual = ground.carries[foot], ground.bent[foot], ground.usual[foot]
    width, count = max(round(WEIGHT * ground.rate), 1), len(carries)
    near = np.array(frames, np.int64)[:, None] + np.arange(width)
    there = np.minimum(near, count - 1)
    carried = carries[there] & (near < count)
    knees = np.where(carried, bent[there], np.inf).min(axis=1)
    low = (knees > BENT) & (knees < np.inf)  # where it is not known it is not more
    high = np.zeros(len(near), bool)
    if usual is not None:
        ankle, toe = ground.feet.heights[foot]
        rise = np.sort(np.where(carried, ankle[there] - toe[there], np.inf), axis=1)
        middle = np.count_nonzero(carried, axis=1)[:, None]
        middle = np.concatenate((middle - 1, middle), axis=1) // 2
        one, other = np.take_along_axis(rise, np.maximum(middle, 0), axis=1).T
        high = ((one + other) / 2 - usual > TOES) & carried.any(axis=1)
    found: list[int] = np.where(low, LOW, np.where(high, HIGH, MID)).tolist()
    return found


def _flights(ground: Ground, turn: Floats, brief: int) -> list[Event]:
    """Return the flights with their feet."""
    found = []
    for (start, stop), way in zip(ground.air, ways(ground, turn, ground.air), strict=True):
        feet = [
            {foot for foot in range(2) if ground.carries[foot][max(first, 0) : last].any()}
            for first, last in ((start - brief, start), (stop, stop + brief))
        ]
        direction, margin = way
        # unseen where the capture begins or ends in the air
        kind = _JUMPS.get((len(feet[0]), len(feet[1])), UNSEEN)
        if kind == HOP and feet[0] != feet[1]:
            kind = LEAP
        found.append(Event(start, stop, direction, -1, margin, amount=kind))
    return found
