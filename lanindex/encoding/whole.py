"""The tracks of the whole body: where its weight is, where it goes, how it turns.

Source: ``encoding/BODY.md``, "Travel" and "Turns".
"""

from collections.abc import Iterable, Iterator, Sequence
from math import atan2, degrees

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import FASTEST, MOST_AMOUNT, PLACE
from lanindex.encoding.arithmetic import held, parted, smooth, unwrapped, window
from lanindex.encoding.bends import bends_of
from lanindex.encoding.curves import BRIEF, SECTOR, STRIDE, Event, pieces, table, turns
from lanindex.encoding.ground import LEGS, Ground, grounds
from lanindex.encoding.joints import Body
from lanindex.encoding.limbs import AXES, heading
from lanindex.encoding.places import Stretch, stretches
from lanindex.encoding.profile import Profile
from lanindex.encoding.rests import NEEDED, WISHED, apart, rests
from lanindex.encoding.steps import events, stances
from lanindex.encoding.timing import to_source
from lanindex.encoding.touch import ARMS, touches
from lanindex.encoding.twists import Told, leans
from lanindex.encoding.written import Written
from lanindex.model.symbol import blank

Floats = NDArray[np.float64]

GOES, RESTS = 0.35, 0.2
"""Lengths of a leg a second: faster is travel; slower is none any more."""

BEYOND = 7.5
"""Degrees behind the border of a direction at which the way is another one."""

Way = tuple[int, int, float, float]
"""First frame and direction of a way; how far it goes ahead and aside."""


def travel(hips: Stretch, front: Floats, leg: float, profile: Profile) -> Floats:
    """Return the travels of a body as from `table`; `front` (N,) the chest's, smoothed, radians."""
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
    parts = [start for start, _ in pieces(codes, round(BRIEF * rate))]
    went = [np.add.reduceat(it, parts).tolist() for it in (forward, right)]
    ways = zip(parts, codes[parts].tolist(), *went, strict=True)
    starts, code, ahead, aside = np.array(_ways(ways)).T
    starts, code = starts.astype(int), code.astype(int)
    stops = np.append(starts[1:], count)
    sizes, moves = stops - starts, code != PLACE
    ahead, aside = ahead / sizes, aside / sizes
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


def _ways(parts: Iterable[Way]) -> list[Way]:
    """Return the ways of parts, those joined that lie but little beyond the border of the last."""
    found = list[Way]()
    for start, code, ahead, aside in parts:
        while found and PLACE not in (code, before := found[-1][1]):
            if abs((_azimuth(ahead, aside) - 45 * before + 180) % 360 - 180) > SECTOR + BEYOND:
                break
            start, _, further, beside = found.pop()
            ahead, aside = ahead + further, aside + beside
            code = round(_azimuth(ahead, aside) / 45) % 8
        found.append((start, code, ahead, aside))
    return found


def _azimuth(ahead: float, aside: float) -> float:
    return degrees(atan2(ahead, aside))


TOGETHER = 1 << 14
"""Events that are made rows together: rows take a part of the memory."""


def whole(body: Body, turn: Floats) -> tuple[list[Written], tuple[str, ...]]:
    """Return the rows of the whole body's tracks, and doubts; `turn` (N,) the heading, radians."""
    found, tracks, many = list[Written](), list[Told](), 0
    doubts = dict[str, None]()
    for one in _tracks(body, turn, doubts):
        tracks.append(one)
        many += len(one[3])
        if many > TOGETHER:
            found += _written(tracks, body)
            tracks, many = [], 0
    return found + _written(tracks, body), tuple(doubts)


def _tracks(body: Body, turn: Floats, doubts: dict[str, None]) -> Iterator[Told]:
    """Yield the tracks, and add what was doubtful."""
    yield from bends_of(body)
    arm, leg = body.length(ARMS), body.length(LEGS)
    for part, one, those in touches(body, arm) if arm else ():
        yield part, one.known, one.frames.start, table(those)
    if leg:
        yield from _feet(body, leg, turn, doubts)
    yield from _courses(body, leg, turn)
    yield from leans(body, turn)


def _courses(body: Body, leg: float | None, turn: Floats) -> Iterator[Told]:
    """Yield where the body travels, and how it turns."""
    profile = body.profile
    chest = heading(body.motion, profile.rate, body, AXES[::-1])
    shoulders = np.zeros(len(chest), bool)
    for one in stretches(body, AXES[1]):
        shoulders[one.frames.start : one.frames.stop] = True
    for hips in stretches(body, ("RHip", "LHip")):
        begin, frames = hips.frames.start, slice(hips.frames.start, hips.frames.stop)
        way, front = table([]), unwrapped(chest[frames])
        if leg:
            calm = smooth(front, window(STRIDE, profile.rate), body.fast)
            way = travel(hips, calm, leg, profile)
            del calm
        yield "body_travel", hips.known, begin, way
        own = unwrapped(turn[frames])
        front = _shoulders(front, own, shoulders[frames])
        own = np.degrees(own)
        yield "body_turn", hips.known, begin, turns(own, profile, front, body.fast)


def _shoulders(front: Floats, hips: Floats, seen: NDArray[np.bool_]) -> Floats:
    """Return the heading of the shoulders, (N,) degrees; unseen, they turn as the hips do."""
    pace = np.where(seen[1:] & seen[:-1], np.diff(front), np.diff(hips))
    turned: Floats = np.degrees(np.cumsum(np.append(0.0, pace)))
    return turned


def _feet(body: Body, leg: float, turn: Floats, doubts: dict[str, None]) -> Iterator[Told]:
    """Yield the tracks of what carries the body, and add what was doubtful."""
    parts = stretches(body, NEEDED, WISHED)
    for ground, places in zip(grounds(body, leg), parts, strict=True):
        doubts |= dict.fromkeys(ground.doubts)
        yield from _weight(ground, places, turn)
        del ground


def _weight(ground: Ground, places: Stretch, turn: Floats) -> Iterator[Told]:
    front = turn[ground.places.frames.start : ground.places.frames.start + ground.carries.shape[1]]
    landed, flights = events(ground, front)
    carried = rests(ground, places)
    landed = apart(landed, carried, len(front))
    for foot, side in enumerate("rl"):
        own = [one for one in landed if one.foot == foot]
        held = stances(ground, foot)
        if held and not held[0].start:
            own = [Event(0, 0, PLACE, held[0].level, 1.0), *own]
        yield f"{side}_support", ground.places.known, ground.places.frames.start, table(own)
        yield f"{side}_stance", ground.places.known, ground.places.frames.start, table(held)
    yield "jump", ground.places.known, ground.places.frames.start, table(flights)
    yield "other_support", ground.places.known, ground.places.frames.start, table(carried)


def _written(tracks: Sequence[Told], body: Body) -> list[Written]:
    """Return the rows of tracks; an event without frames is its track's starting position."""
    if not tracks:
        return []
    parts, known, begun, each = zip(*tracks, strict=True)
    bare = np.array([not len(those) or those[0, 1] > 0 for those in each], np.int64)
    counts = np.array(list(map(len, each)))
    events = np.concatenate(each)
    start, stop, direction, level, margin, _, amount, speed, beside = events.T
    rows = blank(len(events) + int(bare.sum()))
    place = np.arange(len(events)) + np.cumsum(bare).repeat(counts)
    begin, free = np.repeat(begun, counts), np.zeros(len(rows))
    free[place] = stop
    for name, values in (
        ("direction", direction),
        ("level", level),
        ("amount", np.minimum(amount, MOST_AMOUNT)),
        ("margin", np.maximum(margin, 0.0)),
        ("speed", np.round(np.minimum(speed, FASTEST), 2)),
        ("runner_direction", beside),
        ("start", begin + np.maximum(start, free[place - 1])),
        ("stop", begin + np.maximum(stop, start + 1)),
    ):
        rows[name][place] = values
    ends = np.cumsum(counts + bare)
    first = ends - counts - bare
    rows["start"][first] = rows["stop"][first] = begun
    sizes = (counts + bare).tolist()
    to_source(rows, sizes, known, body.motion.rate, body.profile.rate)
    return [
        Written(part, span, own[without:])
        for part, span, own, without in zip(parts, known, parted(rows, sizes), bare, strict=True)
    ]
