"""Steps and jumps: the weight goes from foot to foot, or into the air.

Source: ``encode/BODY.md``, "Steps" and "Jumps".
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import HIGH, LOW, MID, PLACE
from lanindex.encode.arithmetic import runs
from lanindex.encode.events import SECTOR, Event
from lanindex.encode.ground import FLICKER, STIRS, Feet, Flags, Ground
from lanindex.encode.onset import begun

Floats = NDArray[np.float64]

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


def way(ground: Ground, turn: Floats, start: int, stop: int) -> tuple[int, float]:
    """Return in which direction the pelvis goes between two frames, and how clear that is.

    Parameters
    ----------
    ground : Ground
        The body.
    turn : ndarray
        (N,) radians, its heading, as `lanindex.encode.heading.heading` returns it.
    start, stop : int
        Frames; the front is that of the last.
    """
    last = min(stop, len(turn) - 1)
    pelvis = ground.feet.pelvis
    forward, right = faced(pelvis[last] - pelvis[min(start, last)], turn[last])
    return sector(forward / ground.leg, right / ground.leg, STAYS)


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
    """Return the feet that stand anew, and the flights, each in order of time.

    Parameters
    ----------
    ground : Ground
        Which foot carries.
    turn : ndarray
        (N,) radians, the heading over the same frames.
    """
    brief = round(FLICKER * ground.rate)
    found, full = list[Event](), 0  # when the last foot stood
    landed = _together(ground, _landings(ground), brief)
    feet = [[stop for _, stop, foot in landed if foot == own] for own in range(2)]
    levels = [iter(_levels(ground, foot, stops)) for foot, stops in enumerate(feet)]
    for release, stop, foot in landed:
        flight = _flown(ground, stop, brief)
        both = ground.carries[1 - foot][flight[1] : stop + brief].any() if flight else False
        if flight and both:
            start = flight[0]
        else:
            rests = release - full > stop - release
            start = _left(ground, foot, (full, release, stop)) if rests else full
        direction, margin = way(ground, turn, start, stop)
        found.append(Event(start, stop, direction, next(levels[foot]), margin, foot))
        full = stop
    return found, [_flight(ground, turn, start, stop, brief) for start, stop in ground.air]


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
    """Let both feet that land from one flight stand at one time, that of the later one."""
    found = list(landings)
    for number, (one, two) in enumerate(pairwise(landings)):
        flight = _flown(ground, one[1], brief)
        if flight and two[1] <= flight[1] + brief and one[2] != two[2]:
            found[number] = (one[0], two[1], one[2])
    return found


def _flown(ground: Ground, stop: int, brief: int) -> tuple[int, int] | None:
    """Return the flight that a foot lands from that stands at a frame; None: from none."""
    number = bisect_right(ground.air, stop, key=lambda one: one[1]) - 1
    flight = ground.air[number] if number >= 0 else None
    return flight if flight and stop - flight[1] <= brief else None


def _left(ground: Ground, foot: int, times: tuple[int, int, int]) -> int:
    """Return when a foot begins to leave that rests, then is lifted, and then stands."""
    rests, release, stop = times
    return rests + round(
        begun(ground.feet.speed[foot, rests:stop].tolist(), release - rests, STIRS)
    )


def _landings(ground: Ground) -> list[tuple[int, int, int]]:
    """Return of each foot that stands anew when it left, when it stands, and which it is."""
    found = []
    for foot, (ankle, *_) in enumerate(ground.feet.points):
        for release, stop in runs(~ground.carries[foot]):
            if not 0 < stop < len(ankle):
                continue
            way = ankle[release : stop + 1]
            slid = math.hypot(*(way[-1] - way[0])[[0, 2]])
            raised = float(way[:, 1].max() - min(way[0, 1], way[-1, 1]))
            if slid >= SLID or raised >= RAISED or release == 0:
                found.append((release, stop, foot))
    return sorted(found, key=lambda one: (one[1], one[2]))


def _levels(ground: Ground, foot: int, frames: Sequence[int]) -> list[int]:
    if not frames:
        return []
    told = ground.carries, ground.feet, foot, ground.usual[foot], ground.rate
    return ground.stages.levels(frames, *told)


def levels(
    frames: Sequence[int], carries: Flags, feet: Feet, foot: int, usual: float | None, rate: float
) -> list[int]:
    """Return the levels of steps, by how the leg takes the weight from some frames on.

    Parameters
    ----------
    frames : sequence of int
        When the foot stands.
    carries, feet, usual
        As of a `Ground`, of the foot.
    foot : int
        0 right, 1 left.
    rate : float
        Frames a second.
    """
    width, count = max(round(WEIGHT * rate), 1), carries.shape[1]
    near = np.array(frames, np.int64)[:, None] + np.arange(width)
    there = np.minimum(near, count - 1)
    carried = carries[foot][there] & (near < count)
    bent = np.where(carried, feet.bent[foot][there], np.inf).min(axis=1)
    low = (bent > BENT) & (bent < np.inf)  # where it is not known it is not more
    high = np.zeros(len(near), bool)
    if usual is not None:
        ankle, toe = feet.points[foot, ..., 1]
        rise = np.sort(np.where(carried, ankle[there] - toe[there], np.inf), axis=1)
        middle = np.count_nonzero(carried, axis=1)[:, None]
        middle = np.concatenate((middle - 1, middle), axis=1) // 2
        one, other = np.take_along_axis(rise, np.maximum(middle, 0), axis=1).T
        high = ((one + other) / 2 - usual > TOES) & carried.any(axis=1)
    found: list[int] = np.where(low, LOW, np.where(high, HIGH, MID)).tolist()
    return found


def _flight(ground: Ground, turn: Floats, start: int, stop: int, brief: int) -> Event:
    """Return a flight with its feet."""
    direction, margin = way(ground, turn, start, stop)
    feet = [
        {foot for foot in range(2) if ground.carries[foot][max(first, 0) : last].any()}
        for first, last in ((start - brief, start), (stop, stop + brief))
    ]
    return Event(start, stop, direction, -1, margin, amount=_feet(*feet))


def _feet(before: set[int], after: set[int]) -> int:
    if not before or not after:
        return UNSEEN  # the capture begins or ends in the air
    if len(before) == len(after) == 1:
        return HOP if before == after else LEAP
    return {(2, 2): BOTH_BOTH, (1, 2): ONE_BOTH, (2, 1): BOTH_ONE}[len(before), len(after)]
