"""The tracks of the whole body: where its weight is, where it goes, how it turns.

Source: ``encode/BODY.md``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import FASTEST, MOST_AMOUNT, PLACE
from lanindex.encode.bends import bends
from lanindex.encode.ground import LEGS, Ground, grounds
from lanindex.encode.inclines import inclines
from lanindex.encode.joints import Body
from lanindex.encode.places import Stretch, stretches
from lanindex.encode.profile import Profile
from lanindex.encode.rests import NEEDED, WISHED, apart, rests
from lanindex.encode.steps import Event, events, stances
from lanindex.encode.timing import to_source
from lanindex.encode.touch import ARMS, touches
from lanindex.encode.track import Written
from lanindex.encode.twists import twists
from lanindex.encode.ways import travel, turns
from lanindex.model import Motion, Span
from lanindex.model.symbol import blank

Floats = NDArray[np.float64]


def whole(body: Body, turn: Floats) -> tuple[list[Written], tuple[str, ...]]:
    """Write down what the whole body does.

    Parameters
    ----------
    body : Body
        The capture.
    turn : ndarray
        (N,) radians, as from `lanindex.encode.heading.heading`.

    Returns
    -------
    tuple of list of Written and tuple of str
        Tracks of which the capture knows enough, stretch by stretch; and what was doubtful.
    """
    found, doubts = list[Written](), dict[str, None]()
    motion, profile = body.motion, body.profile
    for part, known, begin, those in bends(body):
        found.append(_written(part, known, begin, those, motion, profile))
    arm, leg = body.length(ARMS), body.length(LEGS)
    for part, one, those in touches(body, arm) if arm else ():
        found.append(_written(part, one.known, one.frames.start, those, motion, profile))
    parts = stretches(body, NEEDED, WISHED) if leg else ()
    for ground, places in zip(grounds(body, leg) if leg else (), parts, strict=True):
        doubts |= dict.fromkeys(ground.doubts)
        found += _weight(ground, places, turn)
    for hips in stretches(body, ("RHip", "LHip")):
        begin, front = hips.frames.start, turn[hips.frames.start : hips.frames.stop]
        for part, those in (
            ("body_travel", travel(_way(hips), front, leg, profile) if leg else []),
            ("body_turn", turns(front, profile)),
        ):
            found.append(_written(part, hips.known, begin, those, motion, profile))
    for part, over, begun, those in chain(twists(body), inclines(body, turn)):
        begin = over.frames.start
        found.append(_written(part, over.known, begin, [begun, *those], motion, profile))
    return found, tuple(doubts)


def _way(hips: Stretch) -> Floats:
    """Return where the middle of the hips is over the ground, (N, 2), mm."""
    found = np.empty((len(hips.frames), 2))
    for block, places in hips.blocks():
        found[block.inner] = (places["RHip"] + places["LHip"])[:, ::2] / 2
    return found


def _weight(ground: Ground, places: Stretch, turn: Floats) -> Iterator[Written]:
    motion, profile = places.body.motion, places.body.profile
    front = turn[ground.begin : ground.begin + ground.carries.shape[1]]
    landed, flights = events(ground, front)
    carried = rests(ground, places)
    landed = apart(landed, carried, len(front))
    for foot, side in enumerate("rl"):
        own = [one for one in landed if one.foot == foot]
        held = stances(ground, foot)
        if held and not held[0].start:
            own = [Event(0, 0, PLACE, held[0].level, 1.0), *own]
        yield _written(f"{side}_support", ground.known, ground.begin, own, motion, profile)
        yield _written(f"{side}_stance", ground.known, ground.begin, held, motion, profile)
    yield _written("jump", ground.known, ground.begin, flights, motion, profile)
    yield _written("other_support", ground.known, ground.begin, carried, motion, profile)


def _written(
    part: str,
    known: Span,
    begin: int,
    those: Sequence[Event],
    motion: Motion,
    profile: Profile,
) -> Written:
    """Return the rows of a track; an event without frames is its starting position."""
    starts = bool(those) and those[0].stop == 0
    rows = blank(len(those) + (not starts))
    rows["start"][0] = rows["stop"][0] = begin
    free = 0
    for row, one in zip(rows[not starts :], those, strict=True):
        row["direction"], row["level"] = one.direction, one.level
        row["amount"] = min(one.amount, MOST_AMOUNT)
        row["margin"] = max(one.margin, 0.0)
        row["speed"] = round(min(one.speed, FASTEST), 2)
        row["runner_direction"] = one.beside
        if one.stop:
            row["start"] = begin + max(one.start, free)
            row["stop"] = begin + max(one.stop, one.start + 1)
        free = one.stop
    told = to_source(rows, known, motion.rate, profile.rate)
    return Written(part, known, told if starts else told[1:])
